"""Templates of source code: what is filled in, what is left out, and text that cannot break out of a comment."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping
from importlib.resources import files

WIDTH = 100
"""Columns of a comment."""


def render(name: str, parts: Mapping[str, str], facts: Mapping[str, bool]) -> str:
    """A template with its parts filled in.

    Args:
        name: file in the folder `templates`. There `@{part}` stands for a part, and the lines between `@if fact` (or
            `@if not fact`) and `@end` are kept where the fact holds.
        parts: texts by name; what they hold is not looked at again.
        facts: by name.
    """
    template = files(__package__).joinpath("templates", name).read_text(encoding="utf-8")
    kept, keeping = [], [True]
    for line in template.splitlines():
        words = line.split()
        if words[:1] == ["@if"]:
            holds = facts[words[-1]] != (words[1] == "not")
            keeping.append(keeping[-1] and holds)
        elif words == ["@end"]:
            keeping.pop()
        elif keeping[-1]:
            kept.append(line)
    return re.sub(r"@\{(\w+)\}", lambda found: parts[found[1]], "\n".join(kept) + "\n")


def comment(lines: Iterable[str], prefix: str) -> str:
    """Lines of any text as lines of a comment, indented as they are, after a prefix, and folded at WIDTH columns."""
    fold = textwrap.TextWrapper(
        WIDTH - len(prefix), subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
    folded = (fold.wrap(" " * (len(line) - len(line.lstrip(" "))) + harmless(line)) or [""] for line in lines)
    return "\n".join((prefix + line).rstrip() for several in folded for line in several)


def harmless(text: str) -> str:
    """Text on one line, without control characters, and without what begins or ends a comment of any language."""
    text = "".join(letter if letter.isprintable() else " " for letter in text)
    # A comment in C must hold neither its end nor its beginning, and no trigraph.
    for mark, instead in (("*/", "* /"), ("/*", "/ *"), ("??", "? ?")):
        while mark in text:
            text = text.replace(mark, instead)
    return " ".join(text.split())
