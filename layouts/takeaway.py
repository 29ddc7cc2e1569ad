"""Results on their way out over HTTP: everything that a link says, run anew and given as files."""

from __future__ import annotations

import asyncio
import csv
import io
from collections.abc import Callable, Coroutine, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AsyncExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO, Any, TextIO, cast

from fastapi import FastAPI, Request, Response
from starlette.requests import ClientDisconnect

from layouts.incoming import MEGABYTE
from layouts.outgoing import FullError, Outgoing, Sent
from layouts.text import file_stem
from layouts.uploads import attachment, refusal
from server.clients import CLIENT
from server.limits import Places, share
from server.metrics import watch
from server.work import NoAnswerError, Work
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
"""Exports that are made at a time, and read from the disk; the others wait."""

MOST_BYTES = 512 * MEGABYTE
"""Room for exports that are made or sent, half of it for one client; the largest takes 125 MB."""

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

    def made(self, query: Mapping[str, str], link: str, stream: IO[bytes]) -> str:
        """Run what a link says and write it to a stream; what the file is called.

        Args:
            query: of the link.
            link: the same as a text, by which others find it.
            stream: it is written to.

        Raises:
            InputError: where it cannot be run.
        """
        experiment = experiment_of(query)
        self.write(run_experiment(experiment), stream, link)
        return self.named(file_stem(experiment.target.title))

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


def attach(server: FastAPI, work: Work, folder: Path | None = None) -> None:
    """Serve `GET /export/{name}?<link>` for every name in EXPORTS, and all of it as `GET /export.zip?<link>`.

    What cannot be run is answered with `{field, rule, received, message}`.

    Args:
        server: the application.
        work: under whose limits they are made.
        folder: on whose disk they lie while they are made and sent; None for where the system has such files.
    """
    makers = work.beside("export", AT_ONCE)
    readers = ThreadPoolExecutor(AT_ONCE, thread_name_prefix="exported")
    room = Places(MOST_BYTES, share(MOST_BYTES))
    under_way: set[Request] = set()
    watch("gainscope_exports", "Exports that were asked for and have not ended.", lambda: len(under_way))

    async def give(request: Request, name: str) -> Response:
        loop = asyncio.get_running_loop()
        async with AsyncExitStack() as ending:
            under_way.add(request)
            ending.callback(under_way.discard, request)
            outgoing = Outgoing(room, CLIENT.get(), folder)
            # It may be large, and a disk takes its time to let go of it.
            ending.push_async_callback(loop.run_in_executor, readers, outgoing.close)
            try:
                export = EXPORTS[check_choice("export", name, EXPORTS)]
                query = dict(request.query_params)
                make = partial(export.made, query, request.url.query, cast(IO[bytes], outgoing))
                title = await _made(makers.run(make), request)
                stream = await loop.run_in_executor(readers, outgoing.begin)
            except InputError as error:
                return refusal(error, 404 if error.field == "export" else 422)
            except NoAnswerError as error:
                return error.response()
            except FullError:
                return refusal(InputError("export", "must wait until others have been taken", name), 503)
            except OSError as error:
                rule = "could not be written by this server"
                return refusal(InputError("export", rule, error.strerror or type(error).__name__), 507)
            headers = attachment(title)
            return Sent(stream, outgoing.size, readers, ending.pop_all(), headers=headers, media_type=export.media)

    @server.get("/export.zip")
    async def everything(request: Request) -> Response:
        return await give(request, ALL)

    @server.get("/export/{name}")
    async def one(request: Request, name: str) -> Response:
        return await give(request, name)


async def _made(making: Coroutine[Any, Any, str], request: Request) -> str:
    """What making gives, as long as somebody waits for it.

    Raises:
        ClientDisconnect: once nobody does.
    """
    made = asyncio.ensure_future(making)
    try:
        while not (await asyncio.wait({made}, timeout=LOOKED_AFTER))[0]:
            if await request.is_disconnected():
                raise ClientDisconnect
        return await made
    finally:
        made.cancel()


def experiment_of(query: Mapping[str, str]) -> Experiment:
    """The experiment of a link; what it says of the view counts for nothing.

    Raises:
        InputError: the first field that is wrong: nothing is left to a default that the page did not show.
    """
    experiment, errors = read_experiment({field: value for field, value in query.items() if field in FIELDS})
    if experiment is None:
        raise errors[0]
    return experiment
