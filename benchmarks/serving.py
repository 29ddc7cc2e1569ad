"""A server and a browser for measuring and for testing."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, Playwright

ROOT = Path(__file__).parents[1]
CHROMIUM_FLAGS = [
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
WEBGL_FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SETTLED = "() => document.querySelector('.desk')?.dataset.state === 'settled'"


@dataclass(frozen=True, slots=True)
class Running:
    """A server that is running: where it listens, and its process."""

    port: int
    process: subprocess.Popen[bytes]


@contextmanager
def server(**settings: str) -> Iterator[int]:
    """A running, ready server; gives its port.

    Args:
        settings: environment variables; recordings are kept in memory unless GAINSCOPE_DATA says where.
    """
    with running(None, **settings) as it:
        yield it.port


@contextmanager
def running(log: IO[bytes] | None = None, **settings: str) -> Iterator[Running]:
    """A running, ready server and its process, which may be ended before the end.

    Args:
        log: where what it says goes; None for this process's own.
        settings: environment variables; recordings are kept in memory unless GAINSCOPE_DATA says where.

    Raises:
        RuntimeError: where it does not become ready within a minute.
    """
    it = start(log, **settings)
    with it.process as process:
        try:
            wait_until_ready(it)
            yield it
        finally:
            process.terminate()


def start(log: IO[bytes] | None = None, **settings: str) -> Running:
    """A server that has been started and is not ready yet; whoever starts it ends it."""
    with socket.socket() as free:
        free.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        free.bind(("127.0.0.1", int(settings.get("GAINSCOPE_PORT", 0))))
        port = free.getsockname()[1]
    environment = os.environ | {"GAINSCOPE_PORT": str(port), "GAINSCOPE_HOST": "127.0.0.1", "GAINSCOPE_DATA": ""}
    command = [sys.executable, "app.py"]
    return Running(port, subprocess.Popen(command, cwd=ROOT, env=environment | settings, stdout=log, stderr=log))


def wait_until_ready(it: Running, patience: float = 60.0) -> None:
    """Wait until a server says that it is ready.

    Raises:
        RuntimeError: where it ends before, or does not within so many seconds.
    """
    until = time.monotonic() + patience
    while time.monotonic() < until and it.process.poll() is None:
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{it.port}/readyz") as answer:
                if answer.status == 200:
                    return
        except OSError:
            pass
        time.sleep(0.05)
    raise RuntimeError("the server did not become ready")


def launch(playwright: Playwright, *, webgl: bool = False) -> Browser:
    """Chromium: the one that GAINSCOPE_CHROMIUM names, else the system's.

    With WebGL, without a graphics card, everything that it draws takes several times as long.
    """
    path = os.environ.get("GAINSCOPE_CHROMIUM") or shutil.which("chromium")
    drawing = WEBGL_FLAGS if webgl else ["--disable-gpu", "--disable-3d-apis"]
    return playwright.chromium.launch(executable_path=path, args=[*CHROMIUM_FLAGS, *drawing])


def settle(page: Page) -> None:
    """Wait until the page says that every plot shows the last change."""
    page.wait_for_function(SETTLED)
