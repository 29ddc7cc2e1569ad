"""What somebody who runs in this container may do, as JSON; sent into it, where nothing else of this checkout is.

The arguments are folders, of which is told whether they may be written to.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path

TOOLS = re.compile(
    r"(.*-)?(gcc|g\+\+|cc|c\+\+|c[89]9|cpp|cc1|cc1plus|clang|clang\+\+|gfortran|tcc|as|ld|ld\.(bfd|gold|lld)|lld|llc|llvm-\w+"
    r"|make|ninja|cmake|pip|uv|conda)(-?[0-9.]+)?"
)
"""Names of programs that compile or install."""

INSTALLERS = ("pip", "ensurepip", "setuptools")
"""Packages that do."""

FOREIGN = ("/proc", "/sys", "/dev")


def files() -> Iterator[tuple[str, str]]:
    """Folder and name of every file."""
    for folder, folders, names in os.walk("/"):
        folders[:] = [] if folder in FOREIGN else folders
        for name in names:
            yield folder, name


def is_writable(folder: str) -> bool:
    """Whether a file can be made in a folder."""
    path = Path(folder, ".probe")
    try:
        path.write_bytes(b"?")
        path.unlink()
    except OSError:
        return False
    return True


def part(path: str) -> str:
    """What a file belongs to: a package of Python's, or else a folder of the system's."""
    names = path.split("/")
    return names[5] if path.startswith("/venv/lib/") and len(names) > 6 else names[1]


def main() -> None:
    tools, rights = set(), []
    parts: dict[str, int] = {}
    for folder, name in files():
        path = f"{folder}/{name}".replace("//", "/")
        told = os.lstat(path)
        if TOOLS.fullmatch(name) and Path(path).is_file() and os.access(path, os.X_OK):
            tools.add(path)
        if Path(folder).name in INSTALLERS:
            tools.add(folder)
        if told.st_mode & 0o6000:
            rights.append(path)
        parts[part(path)] = parts.get(part(path), 0) + told.st_blocks * 512
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    found = {
        "user": os.getuid(),
        "groups": sorted({os.getgid(), *os.getgroups()}),
        "capabilities": [status[name].strip() for name in ("CapEff", "CapPrm", "CapBnd")],
        "new_privileges": status["NoNewPrivs"].strip() == "0",
        "writable": [folder for folder in sys.argv[1:] if is_writable(folder)],
        "tools": sorted(tools),
        "rights": rights,
        "parts": parts,
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main()
