"""Writes docs/licences.md: under which licences stands what the container image is made of, as the packages say it.

Run by hand after `make lock`, in the development environment; a test fails when the table is not what the lock says.
"""

from __future__ import annotations

import re
from importlib.metadata import metadata
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "requirements" / "serve.txt"
PAGE = ROOT / "docs" / "licences.md"

HEAD = """# Licences of what the image is made of

Every package of `requirements/serve.txt` with its licence, as the package itself says it; written by
`scripts/licences.py`. The texts are in the image: in each package's own folder `*.dist-info`, and beside the scripts
that a package brings for the browser (`*.LICENSE.txt`). Besides them the image holds Python and the Debian packages of
its base, whose licences are in `/usr/share/doc`.

| package | version | licence |
| --- | --- | --- |
"""

CLASSIFIER = "License :: OSI Approved :: "
LONGEST = 60
"""Characters; where there are more, a package has given the whole text in the place of a name."""


def licence(name: str) -> str:
    """What an installed package says of its licence."""
    told: dict[str, Any] = metadata(name).json
    classified = [text.removeprefix(CLASSIFIER) for text in told.get("classifier", []) if text.startswith(CLASSIFIER)]
    plain = told.get("license", "").strip()
    brief = plain if len(plain) <= LONGEST and "\n" not in plain else ""
    return told.get("license_expression") or brief or ", ".join(classified) or "see the package"


def locked() -> dict[str, str]:
    """Versions that the lock has, by names; those of other systems than Linux are left out."""
    found: dict[str, list[str]] = {}
    for name, version, condition in re.findall(r"^([a-z0-9-]+)==(\S+)(.*)", LOCK.read_text(), re.MULTILINE):
        if "win32" not in condition:
            found.setdefault(name, []).append(version)
    return {name: ", ".join(versions) for name, versions in found.items()}


def page() -> str:
    """The whole page."""
    return HEAD + "".join(f"| {name} | {version} | {licence(name)} |\n" for name, version in locked().items())


if __name__ == "__main__":
    PAGE.write_text(page())
