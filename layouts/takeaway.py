"""Results on their way out over HTTP: everything that a link says, run anew and given as files."""

from __future__ import annotations

import asyncio
import contextlib
import csv
import io
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import IO, Any, TextIO

from fastapi import FastAPI, Request, Response
from fastapi.responses import StreamingResponse
from starlette.requests import ClientDisconnect
from starlette.types import Message, Receive, Scope, Send

from layouts.pipe import STALLED, Pipe, piped
from layouts.text import file_stem
from layouts.uploads import attachment, refusal
from server.metrics import computing, watch
from tracker_core import Experiment, InputError, Result, run_experiment
from tracker_core.checks import check_choice
from tracker_core.experiment import read_experiment
from tracker_core.exports import (
    Part,
    run_parts,
    run_summary,
    track_columns,
    write_archive,
    write_columns,
    write_json,
    write_track,
)
from tracker_core.fields import FIELDS
from tracker_core.measured import recorded
from tracker_core.recordings import KINDS

AT_ONCE = 2
"""Exports that are made at a time; the others wait."""

MOST_WAITING = 32
"""Exports that have been asked for and have not ended, those that are being sent among them."""

LOOKED_AFTER = 1.0
"""Seconds after which it is looked whether somebody still waits."""

ALL = "all.zip"


@dataclass(frozen=True, slots=True)
class Export:
    """A file that a run is given as.

    Attributes:
        name: what stands after the name of the target.
        media: its type.
        write: writes it.
    """

    name: str
    media: str
    write: Callable[[Result, IO[bytes], str], None]

    def written(self, experiment: Experiment, link: str, stream: IO[bytes]) -> None:
        """Run an experiment and write it to a stream; the link is what others find it by."""
        with computing("export"):
            self.write(run_experiment(experiment), stream, link)

    def named(self, stem: str) -> str:
        """What the file is called."""
        return f"{stem}.zip" if self.name == ALL else f"{stem}-{self.name}"


def _as_text(write: Callable[[Result, TextIO], None]) -> Callable[[Result, IO[bytes], str], None]:
    def written(result: Result, stream: IO[bytes], link: str) -> None:
        del link
        text = io.TextIOWrapper(stream, encoding="utf-8", newline="")
        write(result, text)
        text.detach()

    return written


def write_findings(result: Result, stream: TextIO) -> None:
    """The findings of a recording as CSV: kind, line (0 for the whole file), reason.

    Raises:
        InputError: where nothing was recorded.
    """
    experiment = result.experiment
    if experiment.data is None or experiment.reading is None:
        raise InputError("data", "must be given: nothing is found in a simulated target", experiment.scenario)
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(("line", "kind", "reason", "what is done"))
    for finding in recorded(experiment.data, experiment.reading).findings:
        kind = KINDS[finding.kind]
        # A spreadsheet calculates what begins with a sign; ours begin with a word.
        writer.writerow((finding.line, kind.title, f"found: {finding.text}", kind.done))


def write_all(result: Result, stream: IO[bytes], link: str) -> None:
    """Everything in one zip: the track, its metrics, the experiment, the findings, and the filter as code."""
    parts = run_parts(result, origin=link)
    if result.experiment.data is not None:
        parts.append(Part("findings.csv", partial(write_findings, result), "What was found in the file, by line."))
    write_archive(stream, parts)


_CSV, _JSON = "text/csv; charset=utf-8", "application/json"

EXPORTS: dict[str, Export] = {
    export.name: export
    for export in (
        Export(ALL, "application/zip", write_all),
        Export("track.csv", _CSV, _as_text(write_track)),
        Export("track.json", _JSON, _as_text(lambda result, stream: write_columns(track_columns(result), stream))),
        Export("metrics.json", _JSON, _as_text(lambda result, stream: write_json(run_summary(result), stream))),
        Export("experiment.json", _JSON, _as_text(lambda result, out: write_json(result.experiment.to_dict(), out))),
        Export("findings.csv", _CSV, _as_text(write_findings)),
    )
}


def attach(server: FastAPI) -> None:
    """Serve `GET /export/{name}?<link>` for every name in EXPORTS, and all of it as `GET /export.zip?<link>`.

    What cannot be run is answered with `{field, rule, received, message}`.
    """
    # Links are read by threads of their own: reading a long recording must not hold up what else needs a thread.
    readers = ThreadPoolExecutor(AT_ONCE, thread_name_prefix="links")
    makers = ThreadPoolExecutor(AT_ONCE, thread_name_prefix="exports")
    under_way: set[Request] = set()
    watch("gainscope_exports", "Exports that were asked for and have not ended.", lambda: len(under_way))

    async def give(request: Request, name: str) -> Response:
        if len(under_way) >= MOST_WAITING:
            return refusal(InputError("export", f"must wait: {MOST_WAITING} others do", name), 503)
        with contextlib.ExitStack() as ending:
            under_way.add(request)
            ending.callback(under_way.discard, request)
            try:
                export = EXPORTS[check_choice("export", name, EXPORTS)]
                query = dict(request.query_params)
                experiment = await asyncio.get_running_loop().run_in_executor(readers, experiment_of, query)
                pipe = piped(makers, partial(export.written, experiment, request.url.query))
                ending.callback(pipe.leave)
                await _opened(pipe, request)
            except InputError as error:
                return refusal(error, 404 if error.field == "export" else 422)
            title = export.named(file_stem(experiment.target.title))
            return _Given(pipe, ending.pop_all().close, media_type=export.media, headers=attachment(title))

    @server.get("/export.zip")
    async def everything(request: Request) -> Response:
        return await give(request, ALL)

    @server.get("/export/{name}")
    async def one(request: Request, name: str) -> Response:
        return await give(request, name)


async def _opened(pipe: Pipe, request: Request) -> None:
    """Wait until there is something to send, as long as somebody waits for it.

    Raises:
        ClientDisconnect: once nobody does.
    """
    first = asyncio.ensure_future(pipe.opened())
    try:
        while not (await asyncio.wait({first}, timeout=LOOKED_AFTER))[0]:
            if await request.is_disconnected():
                raise ClientDisconnect
        await first
    finally:
        first.cancel()


class _Given(StreamingResponse):
    """A file that is sent as it is written; in the end, whichever it is, its place is free again."""

    def __init__(self, pipe: Pipe, leave: Callable[[], None], **more: Any) -> None:
        super().__init__(pipe, **more)
        self._leave = leave

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def sent(message: Message) -> None:
            try:
                async with asyncio.timeout(STALLED):
                    await send(message)
            except TimeoutError:
                # A client that stays and takes nothing has left as well.
                raise ClientDisconnect from None

        try:
            await super().__call__(scope, receive, sent)
        finally:
            self._leave()


def experiment_of(query: Mapping[str, str]) -> Experiment:
    """The experiment of a link; what it says of the view counts for nothing.

    Raises:
        InputError: the first field that is wrong: nothing is left to a default that the page did not show.
    """
    experiment, errors = read_experiment({field: value for field, value in query.items() if field in FIELDS})
    if experiment is None:
        raise errors[0]
    return experiment
