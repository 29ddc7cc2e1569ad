"""Writes the table of settings in docs/server.md."""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from server.settings import table  # noqa: E402

TARGET = ROOT / "docs" / "server.md"
BEGIN, END = "<!-- settings: written by scripts/settings.py -->", "<!-- end of settings -->"


def page() -> str:
    """The whole page, with the table as it has to be."""
    between = re.compile(f"(?<={re.escape(BEGIN)}\n).*?(?={re.escape(END)})", re.DOTALL)
    return between.sub(lambda _: f"\n{table()}\n", TARGET.read_text(encoding="utf-8"))


if __name__ == "__main__":
    TARGET.write_text(page(), encoding="utf-8")
