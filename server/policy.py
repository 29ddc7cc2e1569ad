"""The content security policies of documents: what a browser may load, run and connect to from them.

Who may show a document in a frame is a setting of whoever runs the server, and is added by whoever sends it.
"""

from __future__ import annotations

import base64
import hashlib
from html.parser import HTMLParser

RUN = ("", "module", "application/javascript", "text/javascript")
"""Types of scripts that are run; any other is data."""


def source(text: str) -> str:
    """How a policy names a script that stands in a document."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def inline_scripts(document: str) -> list[str]:
    """The texts of the scripts of a document that are run and stand in it."""
    scripts = _Scripts()
    scripts.feed(document)
    return scripts.texts


class _Scripts(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []
        self._inside = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        attributes = dict(attrs)
        self._inside = tag == "script" and "src" not in attributes and (attributes.get("type") or "") in RUN
        if self._inside:
            self.texts.append("")

    def handle_endtag(self, tag: str) -> None:  # noqa: ARG002
        self._inside = False

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.texts[-1] += data


def policy(*scripts: str, **more: str) -> str:
    """A policy under which a document gets everything from this server.

    Args:
        scripts: texts of the scripts that stand in it.
        more: other sources by directive, with _ for -, in the place of this server.
    """
    directives = {
        "default-src": "'self'",
        "script-src": "'self'",
        "object-src": "'none'",
        "base-uri": "'none'",
        "form-action": "'none'",
        **{name.replace("_", "-"): sources for name, sources in more.items()},
    }
    directives["script-src"] = " ".join((directives["script-src"], *map(source, scripts)))
    return "; ".join(f"{name} {sources}" for name, sources in directives.items())
