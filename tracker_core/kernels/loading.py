"""Kernels in a process that serves: each is loaded once it is there, and whoever calls it earlier waits.

Without this, the first call would compile it, here and now.
"""

from __future__ import annotations

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


class Loading:
    """All kernels of this process on their way.

    Args:
        ready: called once those are loaded that every page needs.
    """

    def __init__(self, ready: Callable[[], None]) -> None:
        self._ready = ready
        self._kernels: dict[str, Any] = {name: getattr(kernels, name) for name in SIGNATURES}
        self._here = {name: threading.Event() for name in SIGNATURES}
        self._needed = set(FIRST)
        self.preparation = Preparation(TARGET, ROOT, self._load)

    def run(self) -> None:
        """Load all kernels, those first that are compiled already; returns when nothing is left to wait for."""
        for name in SIGNATURES:
            setattr(kernels, name, self._waiting(name))
        try:
            self.preparation.run()
        finally:
            # What could not be compiled elsewhere is compiled by whoever calls it.
            for name in SIGNATURES:
                self._release(name)
            self._reach(set(FIRST))

    def stop(self) -> None:
        """End the compilers."""
        self.preparation.stop()

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
