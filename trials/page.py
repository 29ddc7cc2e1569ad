"""What a page in a browser asks of the server, without a browser.

Everything is taken from the server's own answers: which callbacks there are, where a page's controls stand, what its
sliders span. So the questions stay right when a page changes. The counterparts are assets/desk.js and study.js.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import orjson

from trials.wire import Answer, Client

CALLBACK = "/_dash-update-component"
CONTENT = "_pages_location.pathname"
"""The input by which a page's content is asked for."""

DESKS = {"explore": "/", "stability": "/stability", "tune": "/tune", "compare": "/compare", "data": "/data",
         "track": "/3d"}  # fmt: skip
"""Pages with plots and controls, and their paths."""

PATHS = {**DESKS, "papers": "/papers", "learn": "/learn"}

STUDYING = ("tune", "compare", "data")
"""Desks that ask for a study once they have settled."""

_CONFIG = re.compile(rb'<script id="_dash-config"[^>]*>(.*?)</script>', re.DOTALL)


@dataclass(frozen=True, slots=True)
class Callback:
    """A callback of the server: what it puts out, in Dash's notation, and the ids and properties that it takes."""

    output: str
    inputs: tuple[tuple[str, str], ...]

    def body(self, values: list[Any]) -> dict[str, Any]:
        """What Dash's renderer sends when all inputs have changed to these values."""
        changed = [".".join(place) for place in self.inputs]
        many = self.output.startswith("..")
        outputs = [_place(place) for place in self.output.strip(".").split("...")]
        inputs = zip(self.inputs, values, strict=True)
        return {
            "output": self.output,
            "outputs": outputs if many else outputs[0],
            "inputs": [{"id": name, "property": prop, "value": value} for (name, prop), value in inputs],
            "changedPropIds": changed,
            "parsedChangedPropsIds": changed,
        }


def _place(text: str) -> dict[str, str]:
    name, _, prop = text.rpartition(".")
    return {"id": name, "property": prop}


class RefusedError(Exception):
    """An answer that is none."""


def whole(answer: Answer, what: str) -> Answer:
    """The answer, where it is one.

    Raises:
        RefusedError: where it has another status than 200.
    """
    if answer.status != 200:
        raise RefusedError(f"{what}: {answer.status} {answer.body[:200].decode(errors='replace')}")
    return answer


class Site:
    """The server as a loaded page knows it: its callbacks, by the input that sets them off."""

    def __init__(self, dependencies: list[dict[str, Any]], end: str) -> None:
        self.callbacks: dict[str, Callback] = {}
        self._end = end
        for told in dependencies:
            if not told["clientside_function"]:
                places = tuple((place["id"], place["property"]) for place in told["inputs"])
                self.callbacks[".".join(places[0])] = Callback(told["output"], places)

    @staticmethod
    async def load(client: Client, path: str = "/") -> Site:
        """Load a page as a browser does that has its files: the document, then what Dash asks for.

        Raises:
            RefusedError: where something has another status than 200.
        """
        document = whole(await client.ask("GET", path, headers={"Accept": "text/html"}), path).body
        config = _CONFIG.search(document)
        if config is None:
            raise RefusedError(f"{path}: no page of Dash")
        for other in ("/_dash-layout", "/_dash-dependencies"):
            answer = whole(await client.ask("GET", other), other)
        return Site(orjson.loads(answer.body), orjson.loads(config[1]).get("end_id", ""))

    async def call(self, client: Client, asks: str, values: list[Any]) -> dict[str, Any]:
        """What a callback answers, by the ids of its outputs.

        Raises:
            RefusedError: where it has another status than 200.
        """
        body = orjson.dumps(self.callbacks[asks].body(values))
        headers = {"Content-Type": "application/json", "Accept": "application/json"}
        address = f"{CALLBACK}?endId={self._end}" if self._end else CALLBACK
        answer = whole(await client.ask("POST", address, body, headers), asks)
        return dict(orjson.loads(answer.body)["response"])

    async def content(self, client: Client, path: str, query: str = "") -> Any:
        """What a page consists of."""
        answer = await self.call(client, CONTENT, [path, f"?{query}" if query else ""])
        return answer["_pages_content"]["children"]

    async def beginning(self, client: Client, page: str, query: str = "") -> dict[str, Any]:
        """What a page says that its script begins with."""
        content = await self.content(client, PATHS[page], query)
        return next(part["data"] for part in components(content) if part["id"] == f"{page}-beginning")


def components(tree: Any) -> Iterator[dict[str, Any]]:
    """The properties of every component of a page that has an id."""
    waiting = [tree]
    while waiting:
        part = waiting.pop()
        if isinstance(part, list):
            waiting += part
        elif isinstance(part, dict) and "props" in part:
            if "id" in part["props"]:
                yield part["props"]
            waiting.append(part["props"].get("children"))


class Desk:
    """A page with plots and controls, as its script holds it.

    Args:
        beginning: what the page says its script begins with.

    Attributes:
        name: of the page.
        values: its controls.
        link: what its address says; empty as long as everything stands as usual.
        stale: the plots that were drawn by hand.
        offers: choices that menus offer.
    """

    def __init__(self, beginning: Mapping[str, Any]) -> None:
        self.name: str = beginning["page"]
        self.values: dict[str, Any] = dict(beginning["controls"])
        self.sliders: Mapping[str, Any] = beginning["sliders"]
        self.link = ""
        self.stale: list[str] = []
        self.offers: Mapping[str, list[Any]] = {}
        self._often: list[str] = beginning["often"]
        self._in_turn: list[str] = beginning["inTurn"]
        self._pins: list[Any] = beginning["pins"]
        self._drawn: dict[str, str] = {}
        self._turn = self._seq = 0

    def question(
        self, changed: Mapping[str, Any], *, live: bool = False, want: Sequence[str] = (), scene: str = ""
    ) -> Any:
        """What is asked after a hand has changed some controls.

        Args:
            changed: the controls and their values.
            live: whether a slider moves: over the socket, for some of the plots.
            want: the plots that are to be drawn; empty for all.
            scene: the token of the page's scene, if it has one.
        """
        self._seq += 1
        self.values |= changed
        wanted = list(want) or None
        if live:
            share = self._in_turn[self._turn % len(self._in_turn) :][:1] if self._in_turn else []
            self._turn += 1
            wanted = [*self._often, *share]
        return {
            "seq": self._seq, "controls": self.values, "changed": list(changed), "pins": self._pins, "pinning": [],
            "drawn": self._drawn, "want": wanted, "theme": "light", "scene": scene,
        }  # fmt: skip

    def take(self, answer: Mapping[str, Any], *, live: bool = False) -> bool:
        """Take an answer in; whether what was asked could be run.

        Raises:
            RefusedError: where it answers another question, or lacks what every answer has.
        """
        if answer.get("seq") != self._seq:
            raise RefusedError(f"{self.name}: answer {answer.get('seq')} to question {self._seq}")
        self.values |= answer["controls"]
        if not answer["ok"]:
            return False
        self.link, self._pins, self.offers = answer["link"], answer["pins"], answer["offers"]
        if live:
            self.stale = [*self._often, *self._in_turn]
        else:
            drawn = answer["drawn"]
            self._drawn = self._drawn | drawn
            self.stale = [plot for plot in self.stale if plot not in drawn]
        return True


def text_part(message: bytes) -> dict[str, Any]:
    """The text of a message from a live socket, whose numbers must all be there.

    Raises:
        RefusedError: where numbers are missing.
    """
    length = int.from_bytes(message[:4], "little")
    answer: dict[str, Any] = json.loads(message[4 : 4 + length])
    counts = [count for traces in answer.get("lines", {}).values() for _, count in traces]
    if len(message) != 4 + length + 8 * sum(counts):
        raise RefusedError("live: the numbers are not whole")
    return answer
