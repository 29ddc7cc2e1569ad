"""One line for whatever happens, as a JSON object or as text; nothing that a client sends can break or forge one."""

from __future__ import annotations

import json
import logging
import math
import sys
import threading
from collections.abc import Mapping
from datetime import UTC, datetime
from types import TracebackType
from typing import Any, TextIO

from server.problem import REQUEST

MOST_MESSAGE = 2_000
MOST_EXCEPTION = 20_000
"""Characters; of an exception the end is kept, which says what it was."""

MOST_ITEMS = 100
"""Values that a field may hold."""

QUIET = ("asyncio", "distributed", "httpx", "numba", "uvicorn", "viser", "websockets")
"""Loggers of others, of which warnings are enough."""

_ORDINARY = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName", "color_message"}
_LOG = logging.getLogger(__name__)


class Lines(logging.Formatter):
    """Records as lines.

    Args:
        form: "json": an object with `time` (ISO 8601, UTC), `level`, `logger`, `message`, then where there is one
            `request` (its number), the fields given as `extra`, and `exception`. "text": the same for people; the lines
            of an exception follow, indented.
    """

    def __init__(self, form: str = "json") -> None:
        super().__init__()
        self._form = form

    def format(self, record: logging.LogRecord) -> str:
        """The line of a record, without its end."""
        fields = _fields(record)
        return _as_json(fields) if self._form == "json" else _as_text(fields)


def start(form: str, level: str, stream: TextIO | None = None) -> None:
    """Let everything that is logged, warned of or raised in a thread go to one stream, by default standard error."""
    handler = logging.StreamHandler(stream)
    handler.setFormatter(Lines(form))
    logging.basicConfig(handlers=[handler], level=level.upper(), force=True)
    for name in QUIET:
        logging.getLogger(name).setLevel(max(logging.WARNING, logging.root.level))
    logging.captureWarnings(capture=True)
    sys.excepthook = _log_end
    threading.excepthook = _log_thread


def _log_end(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    if not issubclass(kind, KeyboardInterrupt):
        _LOG.critical("The program ends", exc_info=(kind, error, trace))


def _log_thread(raised: threading.ExceptHookArgs) -> None:
    name = raised.thread.name if raised.thread is not None else "unknown"
    if raised.exc_value is not None:
        error = (raised.exc_type, raised.exc_value, raised.exc_traceback)
        _LOG.error("A thread ended", exc_info=error, extra={"thread_name": name})


def _fields(record: logging.LogRecord) -> dict[str, Any]:
    try:
        message = record.getMessage()
    except (TypeError, ValueError, KeyError):
        # Arguments that do not fit: what was to be said is still worth something.
        message = f"{record.msg} {record.args}"
    fields: dict[str, Any] = {
        "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z"),
        "level": record.levelname.lower(),
        "logger": record.name,
        "message": _cut(message),
    }
    if REQUEST.get():
        fields["request"] = _cut(REQUEST.get())
    extra = {name: _plain(value) for name, value in vars(record).items() if name not in _ORDINARY}
    fields |= {name: value for name, value in extra.items() if name not in fields}
    if record.exc_info and record.exc_info[0] is not None:
        text = logging.Formatter().formatException(record.exc_info)
        fields["exception"] = text if len(text) <= MOST_EXCEPTION else f"…{text[-MOST_EXCEPTION:]}"
    return fields


def _cut(text: str) -> str:
    return text if len(text) <= MOST_MESSAGE else f"{text[:MOST_MESSAGE]}…"


def _plain(value: Any) -> Any:
    """A value as JSON has it, of bounded size."""
    if value is None or isinstance(value, bool | int) or (isinstance(value, float) and math.isfinite(value)):
        # An integer may have any number of digits.
        return value if not isinstance(value, int) or abs(value) < 2**63 else "a very large number"
    if isinstance(value, Mapping):
        return {_cut(str(name)): _cut(str(item)) for name, item in list(value.items())[:MOST_ITEMS]}
    try:
        return _cut(str(value))
    except Exception:  # noqa: BLE001 - whatever it is, the line must be written
        return f"a {type(value).__name__} that cannot be shown"


def _as_json(fields: Mapping[str, Any]) -> str:
    # Everything beyond ASCII is escaped, and with it whatever any reader takes for the end of a line.
    return json.dumps(fields, ensure_ascii=True, allow_nan=False)


def _as_text(fields: Mapping[str, Any]) -> str:
    more = dict(fields)
    exception = more.pop("exception", "")
    head = f"{more.pop('time')} {more.pop('level'):8} {_seen(more.pop('logger'))}: {_seen(more.pop('message'))}"
    tail = "".join(f" {_seen(name)}={_seen(str(value))}" for name, value in more.items())
    return f"{head}{tail}" + "".join(f"\n    {_seen(line)}" for line in exception.splitlines())


def _seen(text: str) -> str:
    """Text in which whatever cannot be seen is written out."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
