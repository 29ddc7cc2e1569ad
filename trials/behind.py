"""Some servers of this checkout that share recordings, behind the proxy of deploy/Caddyfile."""

from __future__ import annotations

import os
import re
import subprocess
import time
import urllib.request
from typing import IO

from benchmarks.serving import ROOT, start, wait_until_ready
from trials.engines import free_port

SERVERS = 3
READY_WITHIN = 180.0
NOTICED = 2.5
"""Seconds in which the proxy notices that a server is ready; it looks every second."""

OPEN = re.compile(r'^gainscope_sockets\{route="/\w+/live"\} (\S+)$', re.MULTILINE)


class Behind:
    """Servers that share recordings, and a proxy before them.

    Args:
        folder: of recordings.
        log: where all of them say what they have to say.
    """

    def __init__(self, folder: str, log: IO[bytes]) -> None:
        self._log = log
        self._settings = {"GAINSCOPE_DATA": folder, "GAINSCOPE_PROXIES": "127.0.0.1", "GAINSCOPE_DRAIN_SECONDS": "3"}
        self.servers = [start(log, **self._settings) for _ in range(SERVERS)]
        self.port = free_port()
        addresses = " ".join(f"127.0.0.1:{server.port}" for server in self.servers)
        environment = os.environ | {
            "SITE": f"http://127.0.0.1:{self.port}", "REPLICAS": addresses, "XDG_DATA_HOME": folder + "-caddy",
            "XDG_CONFIG_HOME": folder + "-caddy", "CADDY_ADMIN": f"127.0.0.1:{free_port()}",
        }  # fmt: skip
        command = ["caddy", "run", "--config", str(ROOT / "deploy" / "Caddyfile"), "--adapter", "caddyfile"]
        self.proxy = subprocess.Popen(command, env=environment, stdout=log, stderr=log)

    def wait(self) -> None:
        """Until all servers are ready, and the proxy knows it."""
        for server in self.servers:
            wait_until_ready(server, READY_WITHIN)
        time.sleep(NOTICED)

    def replace(self, number: int) -> None:
        """Stop a server as an upgrade does, and start it anew at the same port; returns when it is ready."""
        old = self.servers[number]
        old.process.terminate()
        old.process.wait()
        self.servers[number] = start(self._log, **self._settings, GAINSCOPE_PORT=str(old.port))
        wait_until_ready(self.servers[number], READY_WITHIN)
        time.sleep(NOTICED)

    def sockets(self, number: int) -> int:
        """Sockets of pages that are open at a server, as it says itself."""
        with urllib.request.urlopen(f"http://127.0.0.1:{self.servers[number].port}/metrics") as answer:
            figures = answer.read().decode()
        return sum(int(float(count)) for count in OPEN.findall(figures))

    def end(self) -> None:
        """Stop everything."""
        for process in (self.proxy, *(server.process for server in self.servers)):
            process.terminate()
        for process in (self.proxy, *(server.process for server in self.servers)):
            try:
                process.wait(15)
            except subprocess.TimeoutExpired:
                process.kill()
