"""Writes docs/licences.md: under which licences stands what the container image is made of, as the packages say it.

Run by hand after `make lock`, in the development environment; a test fails when the table is not what the lock says.
"""

from __future__ import annotations

import re
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "requirements" / "serve.txt"
PAGE = ROOT / "docs" / "licences.md"

HEAD = """# Licences of what the image is made of

Every package of `requirements/serve.txt` with its licence, as the package itself says it; written by
`scripts/licences.py`. The texts are in the image, in each package's own folder `*.dist-info`. Besides them the image holds
Python and the Debian packages of its base, whose licences are in `/usr/share/doc`.

| package | version | licence |
| --- | --- | --- |
"""

CLASSIFIER = "License :: OSI Approved :: "
LONGEST = 60
"""Characters; where there are more, a package has given the whole text in the place of a name."""


def licence(name: str) -> str:
    """What an installed package says of its licence."""
    told = metadata(name)
    classified = [text.removeprefix(CLASSIFIER) for text in told.get_all("Classifier", []) if text.startswith(CLASSIFIER)]
    plain = (told.get("License") or "").strip()
    brief = plain if plain and len(plain) <= LONGEST and "\n" not in plain else ""
    return told.get("License-Expression") or brief or ", ".join(classified) or "see the package"


def locked() -> list[tuple[str, str]]:
    """Names and versions that the lock has; of several for several Pythons, the installed one."""
    found = dict.fromkeys(re.findall(r"^([a-z0-9-]+)==(\S+)", LOCK.read_text(), re.MULTILINE))
    names = dict.fromkeys(name for name, _ in found)
    rows = []
    for name in names:
        versions = [version for other, version in found if other == name]
        try:
            version = metadata(name)["Version"]
        except PackageNotFoundError:
            continue  # Not for this system.
        rows.append((name, version if version in versions else versions[0]))
    return rows


def page() -> str:
    """The whole page."""
    return HEAD + "".join(f"| {name} | {version} | {licence(name)} |\n" for name, version in locked())


if __name__ == "__main__":
    PAGE.write_text(page())
