"""The container image, built and run as it will be: `python -m trials.container [--option ...]`.

    --option OPTION     passed on to whatever builds it, as in --option=--build-arg --option=VERSION=1.2.0; repeatable

Ends with status 1 where something does not hold, and where there is nothing to build it with.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from trials.crowd import crowd
from trials.engines import Container, Engine, EngineError, find
from trials.report import Finding, at_most, machine, none_of, row
from trials.wire import Client

WITHOUT = "NOT TRIED: no Docker or Podman answers, and not all of root, buildah and crun are here"

MOST_MEGABYTES = 700.0
READY_WITHIN, READY_EVER = 60.0, 300.0
STOPPED_WITHIN = 10.0
EXERCISE = 60.0
"""Seconds for which some users try every page: whatever was trimmed must be missed by nobody."""

LABELS = tuple(f"org.opencontainers.image.{name}" for name in ("title", "description", "version", "revision"))

RECORDING = b"t,x,y\n" + b"".join(b"%d,%d,%d\n" % (row, 3 * row, row * row // 50) for row in range(300))

CLOSED = ("/", "/etc", "/gainscope", "/gainscope/assets", "/usr/bin", "/venv/lib", "/var")
OPEN = ("/data", "/tmp")

PROBE = (Path(__file__).parent / "probe.py").read_text()


def container(engine: Engine) -> Iterator[Finding]:
    """What holds of the image that was built, and of the container that runs it."""
    config = engine.config()
    yield from _image(config, engine.size())
    with engine.volume() as volume:
        with engine.run(volume) as first:
            yield at_most("from start to ready", _ready(first), READY_WITHIN, "s", timed=True)
            healthy = first.inside(config["Healthcheck"]["Test"][1:])
            said = healthy.stderr.strip() or "passes"
            yield Finding("health check of the image", said, "passes", healthy.returncode == 0)
            yield from _held(first)
            yield from asyncio.run(_used(first.port))
            data, found = asyncio.run(_uploaded(first.port))
            yield found
            yield from _stopped(first)
        with engine.run(volume) as second:
            yield at_most("ready again, with the same volume", _ready(second), READY_WITHIN, "s", timed=True)
            yield asyncio.run(_still_there(second.port, data))
            yield from _stopped(second)


def _image(config: Mapping[str, Any], size: int) -> Iterator[Finding]:
    labels = config.get("Labels") or {}
    yield none_of("labels that lack", [name for name in LABELS if not labels.get(name)], f"{len(LABELS)}")
    volumes = sorted(config.get("Volumes") or {})
    yield Finding("volumes", " ".join(volumes), "/data", volumes == ["/data"])
    yield at_most("size, unpacked", size / 1e6, MOST_MEGABYTES, "MB")


def _ready(container: Container) -> float:
    """Seconds until the server is ready; raises EngineError where it never is."""

    async def wait() -> float:
        begun = time.perf_counter()
        client = Client(container.port)
        while (taken := time.perf_counter() - begun) < READY_EVER:
            try:
                if (await client.ask("GET", "/readyz", patience=5)).status == 200:
                    return taken
            except (OSError, EOFError):
                pass
            await asyncio.sleep(0.1)
        raise EngineError(f"not ready after {READY_EVER:g} s")

    return asyncio.run(wait())


def _held(container: Container) -> Iterator[Finding]:
    """What the one who broke in could do."""
    done = container.inside(["python", "-c", PROBE, *CLOSED, *OPEN])
    if done.returncode:
        raise EngineError(done.stderr.strip()[-2000:])
    probe = json.loads(done.stdout)
    who = [probe["user"], *probe["groups"]]
    yield Finding("user and groups", " ".join(map(str, who)), "none of them 0", 0 not in who)
    none = all(int(bits, 16) == 0 for bits in probe["capabilities"])
    yield Finding("capabilities", "none" if none else " ".join(probe["capabilities"]), "none", none)
    gained = probe["new_privileges"]
    yield Finding("new privileges", "may come" if gained else "cannot come", "cannot come", not gained)
    writable = set(probe["writable"])
    yield none_of("writable", sorted(writable.intersection(CLOSED)), " ".join(CLOSED))
    yield none_of("not writable", sorted(set(OPEN) - writable), " ".join(OPEN))
    yield none_of("compilers and installers", probe["tools"], "the whole file system")
    yield none_of("files that give rights", probe["rights"], "the whole file system")
    parts = sorted(probe["parts"].items(), key=lambda part: -part[1])[:10]
    yield Finding("largest parts, MB", ", ".join(f"{name} {size / 1e6:.0f}" for name, size in parts))


async def _used(port: int) -> list[Finding]:
    """Every page with its callbacks, live sockets, studies, scenes, exports and uploads."""
    page = await Client(port).ask("GET", "/", headers={"Accept": "text/html"})
    first = Finding("main page", f"{page.status}, {len(page.body)} bytes", "200", page.status == 200)
    async with crowd(port, users=3, pace=0.5, arrivals=1) as tally:
        await asyncio.sleep(EXERCISE)
    actions = sum(map(len, tally.seconds.values()))
    kinds = ", ".join(sorted(tally.seconds))
    done = Finding("actions", f"{actions}: {kinds}", "some of each", {"load", "page", "move"} <= set(tally.seconds))
    return [first, done, none_of("errors", list(tally.errors), f"{actions} actions")]


async def _uploaded(port: int) -> tuple[str, Finding]:
    body = RECORDING + b"%d,0,0\n" % time.time_ns()
    answer = await Client(port).ask("PUT", "/recordings?name=walk.csv&keep=store", body)
    told = json.loads(answer.body)
    is_kept = answer.status == 200 and told["kept"] == "store"
    return told.get("data", ""), Finding("upload", f"{answer.status}, kept in {told.get('kept')}", "the store", is_kept)


async def _still_there(port: int, data: str) -> Finding:
    answer = await Client(port).ask("GET", f"/recordings/{data}")
    is_whole = answer.status == 200 and answer.body.startswith(RECORDING)
    return Finding("the upload, after a restart", f"{answer.status}, {len(answer.body)} bytes", "whole", is_whole)


def _stopped(container: Container) -> Iterator[Finding]:
    status, taken = container.stop(STOPPED_WITHIN)
    yield Finding("exit status after SIGTERM", str(status), "0", status == 0)
    yield at_most("from SIGTERM to the end", taken, STOPPED_WITHIN, "s")


def trial(options: Sequence[str] = ()) -> Iterator[Finding]:
    """The image is built, then tried; a failure to do either is found as well.

    Args:
        options: for whatever builds it.
    """
    engine = find()
    if engine is None:
        yield Finding("the image", WITHOUT, "built and run", held=False)
        return
    begun = time.perf_counter()
    try:
        engine.build(options)
        yield Finding("built", f"in {time.perf_counter() - begun:.0f} s with {engine.name}")
        yield from container(engine)
    except (EngineError, OSError, ValueError, LookupError) as error:
        yield Finding("the image", f"{type(error).__name__}: {error}", "built and run", held=False)


def main() -> int:
    parser = argparse.ArgumentParser(prog="trials.container", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--option", action="append", default=[], help="for whatever builds the image")
    options = parser.parse_args().option
    print(machine(), flush=True)
    held = True
    for finding in trial(options):
        print(row(Path(__file__).stem, finding), flush=True)
        held &= finding.held
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
