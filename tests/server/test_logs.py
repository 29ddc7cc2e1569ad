"""Lines of the log: always one, always to be read again, whatever is in them."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
from datetime import datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.logs import MOST_EXCEPTION, MOST_MESSAGE, Lines
from server.problem import REQUEST

ANYTHING = st.text(st.characters(), max_size=200)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | ANYTHING | st.binary(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(ANYTHING, inner, max_size=3),
    max_leaves=5,
)
ORDINARY = set(vars(logging.makeLogRecord({})))
EXTRA = st.dictionaries(ANYTHING.filter(lambda name: name not in ORDINARY), VALUES, max_size=4)


class CannotBeShown:
    def __str__(self):
        raise RuntimeError("never")


def record_of(message, extra=(), arguments=(), error=None):
    record = logging.LogRecord("a.logger", logging.WARNING, "file.py", 1, message, arguments, error)
    vars(record).update(extra)
    return record


def raised(text):
    try:
        raise ValueError(text)
    except ValueError:
        return sys.exc_info()


@given(ANYTHING, EXTRA, ANYTHING, ANYTHING)
def test_a_line_is_one_json_object_whatever_was_sent(message, extra, error, request_id):
    token = REQUEST.set(request_id)
    try:
        line = Lines("json").format(record_of(message, extra, error=raised(error)))
    finally:
        REQUEST.reset(token)
    assert line.isascii()
    assert line.isprintable()
    read = json.loads(line, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert read["message"] == message
    assert read.get("request", "") == (request_id or str(extra.get("request", "")))
    assert read["exception"].endswith(f"ValueError: {error}") or not error
    assert {"time", "level", "logger", "message", "exception", *extra} <= read.keys()


@given(ANYTHING, EXTRA, ANYTHING)
def test_in_text_nothing_begins_a_line_but_a_record(message, extra, error):
    first, *others = Lines("text").format(record_of(message, extra, error=raised(error))).split("\n")
    assert first.isprintable()
    assert " warning  a.logger: " in first
    assert others
    for line in others:
        assert line.startswith("    ")
        assert line.isprintable()


def test_what_a_line_says():
    record = record_of("%s of %d", {"seconds": 0.5, "settings": {"A": 1}}, ("two", 3))
    record.created = 1_700_000_000.125
    assert json.loads(Lines("json").format(record)) == {
        "time": "2023-11-14T22:13:20.125Z",
        "level": "warning",
        "logger": "a.logger",
        "message": "two of 3",
        "seconds": 0.5,
        "settings": {"A": "1"},
    }
    said = "2023-11-14T22:13:20.125Z warning  a.logger: two of 3 seconds=0.5 settings={'A': '1'}"
    assert Lines("text").format(record) == said
    assert datetime.fromisoformat(said.split(maxsplit=1)[0]).tzinfo is not None


def test_a_field_does_not_replace_what_every_line_has():
    read = json.loads(Lines("json").format(record_of("said", {"level": "none", "time": "never", "logger": ""})))
    assert (read["level"], read["logger"], read["message"]) == ("warning", "a.logger", "said")
    assert read["time"] != "never"


def test_what_is_long_is_cut():
    extra = {"many": dict.fromkeys(range(10_000), "x" * 10_000), "digits": 10**5000, "text": "y" * 10**6}
    read = json.loads(Lines("json").format(record_of("z" * 10**6, extra, error=raised("w" * 10**6 + "end"))))
    assert read["message"] == "z" * MOST_MESSAGE + "…"
    assert read["text"] == "y" * MOST_MESSAGE + "…"
    assert read["exception"] == "…" + ("w" * MOST_EXCEPTION + "end")[-MOST_EXCEPTION:]
    assert read["digits"] == "a very large number"
    assert len(read["many"]) == 100


def test_what_cannot_be_said_is_still_logged():
    for record in (record_of("%d", arguments=("no number",)), record_of("of %s", {"it": CannotBeShown()})):
        for form in ("json", "text"):
            assert Lines(form).format(record)
    read = json.loads(Lines("json").format(record_of("%d", arguments=("no number",))))
    assert read["message"] == "%d ('no number',)"


SCRIPT = """
import logging, sys, threading, warnings
from server.logs import start
start("json", "info")
logging.getLogger("uvicorn.error").warning("from uvicorn")
logging.getLogger("uvicorn.error").info("too much")
logging.getLogger("server").info("from us")
logging.getLogger("server").debug("too little")
warnings.warn("deprecated\\nfor long")
thread = threading.Thread(target=lambda: 1 / 0, name="worker\\n")
thread.start(); thread.join()
raise SystemError("the end")
"""


def test_everything_goes_one_way_and_nothing_another():
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, encoding="utf-8", check=False)
    assert (done.returncode, done.stdout) == (1, "")
    lines = [json.loads(line) for line in done.stderr.splitlines()]
    said = [(line["level"], line["logger"], line["message"].splitlines()[0]) for line in lines]
    assert said[:2] == [("warning", "uvicorn.error", "from uvicorn"), ("info", "server", "from us")]
    assert said[2][:2] == ("warning", "py.warnings")
    assert "deprecated\nfor long" in lines[2]["message"]
    assert said[3:] == [
        ("error", "server.logs", "A thread ended"),
        ("critical", "server.logs", "The program ends"),
    ]
    assert lines[3]["thread_name"] == "worker\n"
    assert "ZeroDivisionError" in lines[3]["exception"]
    assert lines[4]["exception"].endswith("SystemError: the end")
