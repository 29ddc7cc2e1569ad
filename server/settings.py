"""What whoever runs the server may set: `GAINSCOPE_` and the name in capitals, in the environment.

A field's one description is in its metadata: from it come what is read, what is refused and why, what is printed at the
start, and the table in the documentation.
"""

from __future__ import annotations

import dataclasses
import difflib
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from server.grammar import FRAMES_RULE, NETWORKS_RULE, check_frames, check_host, check_networks, without_password
from tracker_core.checks import Domain, Field, InputError, choice
from tracker_core.recordings.bounds import MOST_BYTES

PREFIX = "GAINSCOPE_"

OF_TOOLS = frozenset({"GAINSCOPE_CHROMIUM"})
"""Names that begin like a setting and are read by tests and scripts."""

DASH_TOOLS = ("DASH_DEBUG", "DASH_MCP_ENABLED")
"""What makes Dash show source code, or take orders from a language model."""

MOST_HELPERS = 3
"""Where nothing is set: each takes as much memory as the server."""

UNSEEN = "a value that is not shown"

_TEXT = Domain(0, 4096)


@dataclass(frozen=True, slots=True)
class _Description:
    """What is known of a setting.

    Attributes:
        field: what it is and what it may be.
        rule: what it may be, where the field does not say it all.
        check: the value as it is kept; raises InputError for what it may not be.
        shown: the value as it is printed.
        elsewhere: what is used where nothing is set, in words, where that depends on the machine.
    """

    field: Field
    rule: str = ""
    check: Callable[[str, str], str] | None = None
    shown: Callable[[str], str] | None = None
    elsewhere: str = ""

    @property
    def secret(self) -> bool:
        """Whether the value may hold what nobody else must read."""
        return self.shown is not None


def _set(usual: Any, field: Field, **more: Any) -> Any:
    return dataclasses.field(default=usual, metadata={"description": _Description(field, **more)})


def _text(sentence: str, domain: Domain = _TEXT) -> Field:
    return Field("", "", "", sentence, "text", domain)


def _number(sentence: str, unit: str, low: float, high: float, *, low_open: bool = False) -> Field:
    return Field("", "", unit, sentence, "number", Domain(low, high, low_open=low_open))


def _whole(sentence: str, low: int, high: int) -> Field:
    return Field("", "", "", sentence, "whole", Domain(low, high, whole=True))


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything that may be set, with what is used where nothing is; `table` says what each is."""

    host: str = _set(
        "127.0.0.1", _text("Address to listen at.", Domain(1, 253)), rule="name or address", check=check_host
    )
    port: int = _set(8050, _whole("Port to listen at.", 1, 65535))
    mode: str = _set(
        "production",
        choice("", "In development Dash's own tools may be switched on.", ("production", "development")),
    )
    proxies: str = _set(
        "",
        _text("Proxies whose word is taken for who the client is; others' X-Forwarded-For and the like do not count."),
        rule=NETWORKS_RULE,
        check=check_networks,
    )  # fmt: skip
    frames: str = _set(
        "'self'",
        _text("Sources that may show pages in a frame, as in frame-ancestors of a content security policy."),
        rule=FRAMES_RULE,
        check=check_frames,
    )
    dask_scheduler: str = _set(
        "",
        _text("Address of a Dask scheduler whose workers compute long studies; empty for this machine."),
        shown=without_password,
    )
    data: str = _set(
        "",
        _text("Folder that recordings are kept in; empty for memory alone."),
        elsewhere="gainscope in the user's data",
    )
    data_mb: float = _set(1000.0, _number("Size of all recordings together.", "MB", 1, 1e9))
    data_days: float = _set(90.0, _number("How long a recording is kept that nobody uses.", "days", 1, 36_525))
    upload_mb: float = _set(10.0, _number("Size of one recording.", "MB", 0, MOST_BYTES / 1e6, low_open=True))
    body_kb: float = _set(256.0, _number("Size of any other request's body.", "kB", 1, 1e5))
    requests_per_second: float = _set(100.0, _number("Requests of one client, for long.", "1/s", 0.1, 1e6))
    requests_at_once: int = _set(2000, _whole("Requests of one client, in a burst.", 1, 1_000_000))
    sockets: int = _set(2000, _whole("Sockets that may be open at a time.", 1, 100_000))
    sockets_per_client: int = _set(500, _whole("Sockets of one client that may be open at a time.", 1, 100_000))
    scenes: int = _set(
        150, _whole("Scenes in three dimensions that may be open at a time, half of them one client's.", 0, 10_000)
    )
    helpers: int = _set(
        0,
        _whole("Other processes that compute answers too while one processor is not enough.", 0, 64),
        elsewhere="as many as processors, 3 at most; none with one",
    )
    work_seconds: float = _set(30.0, _number("Time that one answer may take.", "s", 0.1, 3600))
    study_minutes: float = _set(60.0, _number("Time that one study may take.", "min", 0.01, 10_080))
    studies_waiting: int = _set(100, _whole("Studies that may wait for their turn.", 0, 100_000))
    drain_seconds: float = _set(
        1.0, _number("Time for which requests are still taken after the server was told to stop.", "s", 0, 5)
    )
    metrics_token: str = _set(
        "",
        _text("Password that /metrics asks for; without one it answers this machine alone.", Domain(0, 512)),
        shown=lambda value: "set" if value else "not set",
    )
    log: str = _set(
        "json",
        choice("", "How the log is written: one JSON object a line, or text.", ("json", "text")),
        elsewhere="text on a terminal, else json",
    )
    log_level: str = _set(
        "info", choice("", "The least that is logged.", ("debug", "info", "warning", "error"))
    )  # fmt: skip

    @classmethod
    def from_environment(cls, environment: Mapping[str, str]) -> Settings:
        """What is set in an environment, and what is usual on this machine for the rest.

        Raises:
            InputError: naming the variable: for a value that is none, a name that is none, and where a tool of Dash is
                switched on that does not belong into production.
        """
        described = _described()
        known = {PREFIX + name.upper(): name for name in described}
        for variable in sorted(environment):
            if variable.startswith(PREFIX) and variable not in known and variable not in OF_TOOLS:
                raise _unknown(variable, list(known))
        values = _usual(environment)
        for variable, name in known.items():
            if variable in environment:
                values[name] = _read(variable, described[name], environment[variable])
        settings = cls(**values)
        if settings.mode == "production":
            _refuse_tools(environment)
        return settings

    def environment(self) -> dict[str, str]:
        """The variables that say the same."""
        return {PREFIX + name.upper(): _plain(getattr(self, name)) for name in _described()}

    def shown(self) -> dict[str, str]:
        """The variables as they may be printed: without secrets."""
        values = self.environment()
        for name, description in _described().items():
            if description.shown is not None:
                values[PREFIX + name.upper()] = description.shown(getattr(self, name))
        return values


_DEFAULTS = Settings()


def table() -> str:
    """All settings as a table in Markdown: name, what is usual, what it may be, what it is."""
    rows = [("Variable", "Usual", "May be", "What it is"), ("---",) * 4]
    for name, description in _described().items():
        usual = description.elsewhere or _plain(getattr(_DEFAULTS, name)) or "none"
        unit = f" {description.field.unit}" if description.field.unit else ""
        rows.append((f"`{PREFIX}{name.upper()}`", usual + unit, _rule(description), description.field.sentence))
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def _described() -> dict[str, _Description]:
    return {field.name: field.metadata["description"] for field in fields(Settings)}


def _plain(value: Any) -> str:
    """As short as it can be read again."""
    return str(int(value)) if isinstance(value, float) and value.is_integer() and abs(value) < 1e15 else str(value)


def _rule(description: _Description) -> str:
    field = description.field
    if field.kind == "choice":
        return ", ".join(field.choices)
    rule = description.rule or ("text" if field.kind == "text" else field.domain.rule)
    return rule.removeprefix("must be ")


def _read(variable: str, description: _Description, text: str) -> Any:
    try:
        value = description.field.read(variable, text)
        return value if description.check is None else description.check(variable, value)
    except InputError as error:
        if description.secret:
            raise InputError(variable, error.rule, UNSEEN) from None
        raise


def _unknown(variable: str, known: list[str]) -> InputError:
    near = difflib.get_close_matches(variable.upper(), known, 1, 0.0)
    # Whose value it is nobody knows, so it is not shown.
    return InputError(variable, f"must be left out: there is no such setting; the nearest is {near[0]}", UNSEEN)


def _usual(environment: Mapping[str, str]) -> dict[str, Any]:
    """What depends on the machine where nothing is set."""
    try:
        home = environment.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    except RuntimeError:
        # There is no such user.
        data = ""
    else:
        data = str(Path(home) / "gainscope")
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    helpers = min(processors, MOST_HELPERS) if processors > 1 else 0
    return {
        "data": data,
        "helpers": helpers,
        "log": "text" if sys.stderr is not None and sys.stderr.isatty() else "json",
    }


def _refuse_tools(environment: Mapping[str, str]) -> None:
    for name in DASH_TOOLS:
        for variable in (name, name.lower()):
            # Dash takes any other word for true.
            if environment.get(variable, "").lower() not in ("", "false"):
                raise InputError(variable, "must be false or left out in production", environment[variable])
