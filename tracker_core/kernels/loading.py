"""Kernels in a process that serves: each is loaded once it is there, and whoever calls it earlier waits.

Without this, the first call would compile it, here and now.
"""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable
from typing import Any

from tracker_core import kernels
from tracker_core.kernels.child import make
from tracker_core.kernels.compiled import ROOT, TARGET
from tracker_core.kernels.preparing import Compiled, Preparation
from tracker_core.kernels.signatures import FIRST, SIGNATURES


def held() -> bool:
    """Whether somebody who calls a kernel may have to wait, and had better do so in a thread."""
    return any(getattr(getattr(kernels, name), "waits", False) for name in SIGNATURES)


_LOG = logging.getLogger(__name__)


class Loading:
    """All kernels of this process on their way.

    Args:
        ready: called once those are loaded that every page needs, and all others that are compiled already.
    """

    def __init__(self, ready: Callable[[], None]) -> None:
        self._ready = ready
        self._kernels: dict[str, Any] = {name: getattr(kernels, name) for name in SIGNATURES}
        self._here = {name: threading.Event() for name in SIGNATURES}
        self._stopped = False
        self.preparation = Preparation(TARGET, ROOT, self._load)
        self._needed = set(FIRST) | SIGNATURES.keys() - self.preparation.missing

    def run(self) -> None:
        """Load all kernels, those first that are compiled already; returns when nothing is left to wait for.

        What no other process could compile is compiled here, and now. One that cannot be compiled at all stays one
        that is waited for: whoever calls it finds out in a thread, and where every page needs it nobody is ready.
        """
        for name in SIGNATURES:
            setattr(kernels, name, self._waiting(name))
        try:
            self.preparation.run()
            for name in SIGNATURES:
                if not (self._here[name].is_set() or self._stopped):
                    self._make(name)
        finally:
            for name in SIGNATURES:
                if self._stopped:
                    self._release(name)
                self._here[name].set()

    def stop(self) -> None:
        """End the compilers."""
        self._stopped = True
        self.preparation.stop()

    def _make(self, name: str) -> None:
        """Compile a kernel in this thread: slower and with more memory than elsewhere, but nobody waits for it."""
        _LOG.warning("A kernel that could not be compiled elsewhere is compiled here", extra={"kernel": name})
        try:
            for signature in SIGNATURES[name]:
                # Where it merely cannot be kept, it is there all the same.
                with contextlib.suppress(OSError):
                    self._kernels[name].compile(signature)
            self._load(Compiled(name, len(SIGNATURES[name]), None))
        except Exception:  # noqa: BLE001 - the others are to be loaded as well
            _LOG.exception("A kernel cannot be compiled", extra={"kernel": name})

    def _load(self, compiled: Compiled) -> None:
        make(self._kernels[compiled.kernel], compiled.kernel)
        self._release(compiled.kernel)
        self._reach({compiled.kernel})

    def _reach(self, names: set[str]) -> None:
        waited, self._needed = bool(self._needed), self._needed - names
        if waited and not self._needed:
            self._ready()

    def _release(self, name: str) -> None:
        setattr(kernels, name, self._kernels[name])
        self._here[name].set()

    def _waiting(self, name: str) -> Callable[..., Any]:
        kernel, here = self._kernels[name], self._here[name]

        def wait(*arguments: Any) -> Any:
            here.wait()
            return kernel(*arguments)

        wait.waits = True  # type: ignore[attr-defined]
        return wait
