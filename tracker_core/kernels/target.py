"""Which processor the loops are compiled for, and the folder that they are kept in."""

from __future__ import annotations

import contextlib
import os
import platform
import shutil
import tempfile
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import llvmlite
import numba
from llvmlite import binding
from numba.core import codegen

from tracker_core.checks import check_choice
from tracker_core.kernels.signatures import SIGNATURES

HERE = Path(__file__).parent
OWN = HERE / "__pycache__"
"""Where loops are kept unless NUMBA_CACHE_DIR says otherwise; and where an image brings those of named processors."""

_V3 = ("avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sahf", "sse4.2", "xsave")
LEVELS = {
    "x86-64-v4": (*_V3, "avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
    "x86-64-v3": _V3,
}
"""Families of processors, the best first, with what one must be able to do (x86-64 psABI, table 3.1)."""

X86 = platform.machine().lower() in ("x86_64", "amd64")
NATIVE = "native"


@dataclass(frozen=True, slots=True)
class Target:
    """A processor that loops are compiled for.

    Attributes:
        name: "native" for this machine's own, a level, or what NUMBA_CPU_NAME says.
        cpu: its name, as LLVM is told.
        features: what it can do, as LLVM is told; empty for what the name implies.
    """

    name: str
    cpu: str
    features: str

    @property
    def variables(self) -> dict[str, str]:
        """Environment in which numba compiles for it."""
        return {"NUMBA_CPU_NAME": self.cpu, "NUMBA_CPU_FEATURES": self.features}

    def folder(self, root: Path) -> Path:
        """Where its loops are kept: named after all that machine code depends on, the source of all loops among it.

        Numba compiles a loop anew when the file of that loop has changed, but not when one that it calls has.
        """
        words = [binding.get_process_triple(), self.cpu, self.features]
        words += [numba.__version__, llvmlite.__version__, platform.python_version(), str(HERE)]
        source = b"".join(path.read_bytes() for path in sorted(HERE.glob("*.py")))
        return root / sha256("\n".join(words).encode() + source).hexdigest()[:16]

    def complete(self, root: Path) -> bool:
        """Whether all kernels are there."""
        return all(stamp(self.folder(root), name).exists() for name in SIGNATURES)


def named(name: str) -> Target:
    """A target by name: "native" or, on a machine of their kind, one of LEVELS.

    Raises:
        InputError: for another name.
    """
    check_choice("level", name, (NATIVE, *(LEVELS if X86 else ())))
    if name == NATIVE:
        return Target(NATIVE, binding.get_host_cpu_name(), codegen.get_host_cpu_features())
    return Target(name, name, "")


def chosen(root: Path, cpu: str | None, features: str | None) -> Target:
    """What loops of this process are compiled for.

    That is what NUMBA_CPU_NAME says; else this machine, unless its loops are missing and those of a level are there
    that it has. Those that an image brings are copied: where numba keeps loops, it insists on writing.
    """
    native = named(NATIVE)
    if cpu is not None:
        return Target(cpu, cpu, native.features if features is None else features)
    if not native.complete(root):
        able = binding.get_host_cpu_features()
        for name, needed in LEVELS.items() if X86 else ():
            target = named(name)
            if all(able.get(feature, False) for feature in needed) and _at_hand(target, root):
                return target
    return native


def _at_hand(target: Target, root: Path) -> bool:
    if not target.complete(root) and target.complete(OWN):
        # Where nothing can be written, numba looks for another place itself.
        with contextlib.suppress(OSError):
            publish(target.folder(OWN), target.folder(root))
    return target.complete(root)


def stamp(folder: Path, kernel: str) -> Path:
    """The file that says that a kernel is there, for all its signatures."""
    return folder / f"{kernel}.compiled"


def publish(source: Path, folder: Path, pattern: str = "**/*") -> None:
    """Copy files of loops, so that whoever looks meanwhile finds each of them whole or not at all.

    What a file refers to comes before it: code, then its index, then the stamp.
    """
    order = (".nbc", ".nbi", ".compiled")
    files = [path for path in source.glob(pattern) if path.suffix in order]
    for path in sorted(files, key=lambda path: order.index(path.suffix)):
        place = folder / path.relative_to(source)
        place.parent.mkdir(parents=True, exist_ok=True)
        handle, unfinished = tempfile.mkstemp(dir=place.parent, prefix=".coming-")
        with os.fdopen(handle, "wb") as stream, path.open("rb") as content:
            shutil.copyfileobj(content, stream)
        # Whoever may read the one may read the other: an image is made by another user than the one that serves.
        shutil.copymode(path, unfinished)
        Path(unfinished).replace(place)


def settle(settings: Any) -> tuple[Target, Path]:
    """Tell numba for which processor loops are compiled and where they are kept; `settings` is its `config`.

    Returns the target and the folder of the folders of all targets.
    """
    root = Path(settings.CACHE_DIR or OWN)
    target = chosen(root, settings.CPU_NAME, settings.CPU_FEATURES)
    settings.CACHE_DIR = str(target.folder(root))
    settings.CPU_NAME, settings.CPU_FEATURES = target.cpu, target.features
    return target, root
