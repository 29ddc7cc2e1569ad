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
from pathlib import Path

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


@contextmanager
def server(**settings: str) -> Iterator[int]:
    """A running, ready server; gives its port.

    Args:
        settings: environment variables; recordings are kept in memory unless GAINSCOPE_DATA says where.
    """
    with socket.socket() as free:
        free.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        free.bind(("127.0.0.1", int(settings.get("GAINSCOPE_PORT", 0))))
        port = free.getsockname()[1]
    environment = os.environ | {"GAINSCOPE_PORT": str(port), "GAINSCOPE_HOST": "127.0.0.1", "GAINSCOPE_DATA": ""}
    with subprocess.Popen([sys.executable, "app.py"], cwd=ROOT, env=environment | settings) as process:
        try:
            _wait_until_ready(port, process)
            yield port
        finally:
            process.terminate()


def _wait_until_ready(port: int, process: subprocess.Popen[bytes]) -> None:
    for _ in range(600):
        if process.poll() is not None:
            break
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/readyz") as answer:
                if answer.status == 200:
                    return
        except OSError:
            pass
        time.sleep(0.1)
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
