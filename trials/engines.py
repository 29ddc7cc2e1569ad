"""Builds the container image and runs it: with Docker or Podman, or without either, with buildah and crun.

Both ways the container is held as compose.yaml holds it: nothing may be written but its volume and a small /tmp, no
capabilities, no new privileges.
"""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

ROOT = Path(__file__).parents[1]
IMAGE = "gainscope-trial"
MOST_TMP = "64m"
PROCESSES = 256
PATIENCE = 1800.0
"""Seconds that building may take."""


class EngineError(Exception):
    """An engine did not do what it was asked to; in its own words."""


class Container(Protocol):
    """A container that runs: the port of this machine that leads to its server."""

    port: int

    def inside(self, command: Sequence[str]) -> subprocess.CompletedProcess[str]:
        """Run a command in it, as its user."""

    def stop(self, most: float) -> tuple[int, float]:
        """Ask it to end (SIGTERM) and kill it if it does not within some seconds: exit status, and seconds taken."""


class Engine(Protocol):
    """What builds and runs: its name, and the versions of its parts."""

    name: str

    def build(self, options: Sequence[str]) -> None:
        """Build the image from this checkout, with more options of the engine's own."""

    def config(self) -> Mapping[str, Any]:
        """What the image says of itself, by Docker's names."""

    def size(self) -> int:
        """Bytes of the image, unpacked."""

    def volume(self) -> contextlib.AbstractContextManager[str]:
        """A new volume, removed again."""

    def run(self, volume: str) -> contextlib.AbstractContextManager[Container]:
        """A container with a volume; gone afterwards."""


def find() -> Engine | None:
    """The engine of this machine; None where there is none that answers."""
    for program in ("docker", "podman"):
        if shutil.which(program) and _ask([program, "info"]).returncode == 0:
            return Docker(program)
    if os.geteuid() == 0 and all(map(shutil.which, ("buildah", "crun", "unshare"))):
        return Buildah()
    return None


def free_port() -> int:
    """A port of this machine that nobody listens at."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def _ask(command: Sequence[str], timeout: float = 60.0) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=timeout, check=False)


def _answer(command: Sequence[str], timeout: float = 60.0) -> str:
    done = _ask(command, timeout)
    if done.returncode:
        raise EngineError(f"{' '.join(command[:3])}: {done.stderr.strip()[-2000:]}")
    return done.stdout.strip()


class Docker:
    """An engine with a command line like Docker's."""

    def __init__(self, program: str) -> None:
        self.name = f"{program} {_answer([program, 'version', '--format', '{{.Server.Version}}'])}"
        self._program = program

    def build(self, options: Sequence[str]) -> None:
        _answer([self._program, "build", *options, "--tag", IMAGE, "."], PATIENCE)

    def config(self) -> Mapping[str, Any]:
        return dict(self._inspected()["Config"])

    def size(self) -> int:
        return int(self._inspected()["Size"])

    def _inspected(self) -> Mapping[str, Any]:
        return dict(json.loads(_answer([self._program, "image", "inspect", IMAGE]))[0])

    @contextlib.contextmanager
    def volume(self) -> Iterator[str]:
        name = _answer([self._program, "volume", "create"])
        try:
            yield name
        finally:
            _ask([self._program, "volume", "rm", name])

    @contextlib.contextmanager
    def run(self, volume: str) -> Iterator[Container]:
        name = _answer([
            self._program, "run", "--detach", "--read-only", "--tmpfs", f"/tmp:size={MOST_TMP},mode=1777",
            "--cap-drop", "ALL", "--security-opt", "no-new-privileges", "--pids-limit", str(PROCESSES),
            "--volume", f"{volume}:/data", "--publish", "127.0.0.1::8050", IMAGE,
        ])  # fmt: skip
        try:
            published = _answer([self._program, "port", name, "8050/tcp"])
            yield _Docked(self._program, name, int(published.splitlines()[0].rpartition(":")[2]))
        finally:
            _ask([self._program, "rm", "--force", name])


@dataclass(slots=True)
class _Docked:
    program: str
    name: str
    port: int

    def inside(self, command: Sequence[str]) -> subprocess.CompletedProcess[str]:
        return _ask([self.program, "exec", self.name, *command])

    def stop(self, most: float) -> tuple[int, float]:
        begun = time.perf_counter()
        _answer([self.program, "stop", "--time", f"{most:.0f}", self.name], most + 30)
        taken = time.perf_counter() - begun
        return int(_answer([self.program, "inspect", "--format", "{{.State.ExitCode}}", self.name])), taken


class Buildah:
    """No engine: buildah builds, and crun runs what it built, in the network of this machine."""

    def __init__(self) -> None:
        versions = (_answer(["buildah", "--version"]).split()[2], _answer(["crun", "--version"]).split()[2])
        self.name = "buildah {} and crun {}, in the network of this machine".format(*versions)

    def build(self, options: Sequence[str]) -> None:
        command = ["buildah", "bud", "--isolation", "chroot", "--format", "docker", *options, "--tag", IMAGE, "."]
        _answer(command, PATIENCE)

    def config(self) -> Mapping[str, Any]:
        return dict(self._inspected()["Docker"]["config"])

    def size(self) -> int:
        return sum(int(layer["size"]) for layer in json.loads(self._inspected()["Manifest"])["layers"])

    def _inspected(self) -> Mapping[str, Any]:
        return dict(json.loads(_answer(["buildah", "inspect", "--type", "image", IMAGE])))

    @contextlib.contextmanager
    def volume(self) -> Iterator[str]:
        user, group = map(int, self.config()["User"].split(":"))
        with tempfile.TemporaryDirectory(prefix="gainscope-volume-") as folder:
            os.chown(folder, user, group)
            yield folder

    @contextlib.contextmanager
    def run(self, volume: str) -> Iterator[Container]:
        working = _answer(["buildah", "from", "--pull-never", IMAGE])
        try:
            root = _answer(["buildah", "mount", working])
            with tempfile.TemporaryDirectory(prefix="gainscope-bundle-") as bundle:
                port = free_port()
                specification = _specification(self.config(), root, volume, port)
                (Path(bundle) / "config.json").write_text(json.dumps(specification))
                name = f"gainscope-{secrets.token_hex(4)}"
                command = _crun("run", "--bundle", bundle, name)
                with (
                    tempfile.TemporaryFile() as said,
                    subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=said) as process,
                ):
                    try:
                        yield _Crun(process, name, port, Path(bundle), specification["process"])
                    finally:
                        _ask(_crun("delete", "--force", name))
                        process.kill()
        finally:
            _ask(["buildah", "rm", working])


@dataclass(slots=True)
class _Crun:
    process: subprocess.Popen[bytes]
    name: str
    port: int
    bundle: Path
    first: Mapping[str, Any]

    def inside(self, command: Sequence[str]) -> subprocess.CompletedProcess[str]:
        # As the first process is held; by itself, crun would start it as root.
        described = self.bundle / "process.json"
        described.write_text(json.dumps({**self.first, "args": list(command)}))
        return _ask(_crun("exec", "--process", str(described), self.name))

    def stop(self, most: float) -> tuple[int, float]:
        begun = time.perf_counter()
        _answer(_crun("kill", self.name, "TERM"))
        try:
            status = self.process.wait(most)
        except subprocess.TimeoutExpired:
            status = -signal.SIGKILL
        return status, time.perf_counter() - begun


def _crun(*arguments: str) -> list[str]:
    """crun understands the second version of control groups alone, and is shown no other; it sets no bounds by them."""
    shown = 'mount -t cgroup2 none /sys/fs/cgroup && exec crun --cgroup-manager=disabled "$@"'
    return ["unshare", "--mount", "sh", "-c", shown, "crun", *arguments]


def _specification(config: Mapping[str, Any], root: str, volume: str, port: int) -> dict[str, Any]:
    """The container as the runtime specification of the OCI describes it."""
    user, group = map(int, config["User"].split(":"))
    closed = ["nosuid", "nodev", "noexec"]
    sets = ("bounding", "effective", "inheritable", "permitted", "ambient")
    return {
        "ociVersion": "1.0.2",
        "root": {"path": root, "readonly": True},
        "process": {
            "user": {"uid": user, "gid": group},
            "cwd": config["WorkingDir"],
            # Whoever is not on this machine has no business with a trial.
            "env": [*config["Env"], "GAINSCOPE_HOST=127.0.0.1", f"GAINSCOPE_PORT={port}"],
            "args": config["Cmd"],
            "noNewPrivileges": True,
            "capabilities": {name: [] for name in sets},
        },
        "mounts": [
            {"destination": "/proc", "type": "proc", "source": "proc"},
            {"destination": "/dev", "type": "tmpfs", "source": "tmpfs", "options": ["nosuid", "mode=755", "size=64k"]},
            {"destination": "/dev/shm", "type": "tmpfs", "source": "shm", "options": [*closed, "size=64m"]},
            {"destination": "/sys", "type": "sysfs", "source": "sysfs", "options": [*closed, "ro"]},
            {"destination": "/tmp", "type": "tmpfs", "source": "tmpfs",
             "options": [*closed, f"size={MOST_TMP}", "mode=1777"]},
            {"destination": "/data", "type": "bind", "source": volume, "options": ["bind", "rw", "nosuid", "nodev"]},
        ],
        "linux": {"namespaces": [{"type": kind} for kind in ("pid", "ipc", "uts", "mount")]},
    }  # fmt: skip
