"""What is set in the environment: what is taken, what is refused with which words, what is printed."""

from __future__ import annotations

import io
import string
from dataclasses import fields, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.grammar import check_frames, without_password
from server.settings import DASH_TOOLS, Settings, table
from tracker_core.checks import InputError

HERE = {"XDG_DATA_HOME": "/somebody"}
NAMES = [field.name for field in fields(Settings)]
VISIBLE = st.text(st.characters(exclude_categories=["C", "Z"]), max_size=50)
SECRETS = st.text(string.ascii_letters + string.digits, max_size=30).map("k3pt-from-all-".__add__)
HOSTS = st.sampled_from(["example.org", "*.example.org", "localhost", "10.0.0.1", "a-b.c"])
SOURCES = st.builds(
    "{}{}{}".format, st.sampled_from(["", "https://", "http://"]), HOSTS, st.sampled_from(["", ":8443", ":*"])
)
VALUES = {
    "host": st.sampled_from(["0.0.0.0", "::", "127.0.0.1", "localhost", "server-1.example.org"]),
    "proxies": st.lists(st.sampled_from(["10.0.0.0/8", "127.0.0.1", "::1", "fd00::/8"])).map(",".join),
    "frames": st.just("'none'") | st.lists(st.just("'self'") | SOURCES, min_size=1, max_size=5).map(" ".join),
    "dask_scheduler": st.builds("tcp://{}:8786".format, HOSTS),
    "data": VISIBLE,
    "metrics_token": st.just("") | SECRETS,
}


def values_of(name):
    field = next(field for field in fields(Settings) if field.name == name).metadata["description"].field
    if name in VALUES:
        return VALUES[name]
    if field.kind == "choice":
        return st.sampled_from(field.choices)
    low, high = field.domain.low, field.domain.high
    if field.kind == "whole":
        return st.integers(int(low), int(high))
    return st.floats(low, high, exclude_min=field.domain.low_open)


ALL = st.builds(Settings, **{name: values_of(name) for name in NAMES})


@given(ALL)
def test_what_the_environment_says_is_read_back(settings):
    assert Settings.from_environment(settings.environment()) == settings


@given(ALL, SECRETS, SECRETS)
def test_what_is_printed_holds_no_secret(settings, token, password):
    secret = replace(settings, metrics_token=token, dask_scheduler=f"tls://user:{password}@scheduler:8786")
    printed = repr(secret.shown())
    assert token not in printed
    assert password not in printed
    assert "tls://…@scheduler:8786" in printed
    assert list(secret.shown()) == list(secret.environment())


@given(SECRETS, VISIBLE, VISIBLE)
def test_a_password_stays_out_of_an_address_however_it_is_written(password, before, after):
    for address in (f"{before}:{password}@host", f"tcp://{before}:{password}@{after}@host", f"{password}@://host"):
        assert password not in without_password(address)


@pytest.mark.parametrize(("processors", "helpers"), [(1, 0), (2, 2), (3, 3), (16, 3)])
def test_where_nothing_is_set_there_is_a_helper_per_processor(monkeypatch, processors, helpers):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: set(range(processors)), raising=False)
    assert Settings.from_environment(HERE).helpers == helpers


def test_where_nothing_is_set_the_defaults_hold_but_for_what_the_machine_says(monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0}, raising=False)
    assert Settings.from_environment(HERE) == replace(Settings(), data="/somebody/gainscope", log="json")
    monkeypatch.setattr("sys.stderr", type("Terminal", (io.StringIO,), {"isatty": lambda self: True})())
    assert Settings.from_environment(HERE).log == "text"


def test_a_user_without_a_home_keeps_recordings_in_memory(monkeypatch):
    def nobody():
        raise RuntimeError

    monkeypatch.setattr("pathlib.Path.home", nobody)
    assert Settings.from_environment({}).data == ""


@pytest.mark.parametrize(
    ("name", "text"),
    [
        *(("port", text) for text in ("0", "65536", "-1", "80.5", "http", "", "8050 8051", "nan", "inf", "1e9")),
        *(("host", text) for text in ("", "a b", "http://host", "host:80", "host\n", "-a")),
        ("mode", "debug"),
        *(("proxies", text) for text in ("*", "proxy", "10.0.0.1/8", "10.0.0.1,", "10.0.0.1 10.0.0.2", "300.0.0.1")),
        ("data_mb", "0"),
        ("data_mb", "much"),
        ("data_days", "0.5"),
        ("upload_mb", "0"),
        ("upload_mb", "11"),
        ("drain_seconds", "6"),
        ("sockets", "1.5"),
        ("log", "xml"),
        ("log_level", "INFO"),
        ("data", "a\nb"),
    ],
)
def test_a_value_that_is_none_is_refused_by_name(name, text):
    variable = f"GAINSCOPE_{name.upper()}"
    with pytest.raises(InputError, match=rf"^{variable} must be .*, got ") as refused:
        Settings.from_environment({**HERE, variable: text})
    assert refused.value.field == variable


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "'self' ", "'self'; script-src *", "'self',*", "'none' 'self'", "'unsafe-inline'", "https://a/b",
        "a.*.b", "**", "a\r\nSet-Cookie: b", "https://", "a:b", "'self'\t*.b", "data:", "exämple.org",
    ],
)  # fmt: skip
def test_nothing_but_sources_gets_into_the_policy(text):
    with pytest.raises(InputError, match="^GAINSCOPE_FRAMES must be "):
        Settings.from_environment({**HERE, "GAINSCOPE_FRAMES": text})


@given(st.text(st.sampled_from("'selfnone:/*.a-1 ;,\n\r\t\"")))
def test_what_stands_in_a_policy_ends_neither_directive_nor_header(text):
    try:
        taken = check_frames("frames", text)
    except InputError:
        return
    assert not set(taken) & set(';,\n\r\t"')


@given(SECRETS)
def test_a_value_that_may_be_secret_is_not_repeated(secret):
    for variable in ("GAINSCOPE_METRICS_TOKEN", "GAINSCOPE_DASK_SCHEDULER", "GAINSCOPE_METRICS_TOKN"):
        with pytest.raises(InputError, match=f"^{variable} must be") as refused:
            Settings.from_environment({**HERE, variable: f"{secret}\n"})
        assert secret not in f"{refused.value}{refused.value.received}"
        assert refused.value.__cause__ is None


@pytest.mark.parametrize(
    ("variable", "nearest"),
    [("GAINSCOPE_PROT", "PORT"), ("GAINSCOPE_DATA_GB", "DATA_MB"), ("GAINSCOPE_port", "PORT"), ("GAINSCOPE_", "")],
)
def test_a_name_that_is_none_stops_the_start_with_the_nearest(variable, nearest):
    with pytest.raises(InputError, match=rf"^{variable} must be left out: .* nearest is GAINSCOPE_{nearest}"):
        Settings.from_environment({**HERE, variable: "1"})


def test_names_of_tools_and_of_others_are_let_be():
    others = {"GAINSCOPE_CHROMIUM": "/usr/bin/chromium", "GAIN": "1", "PORT": "no"}
    assert Settings.from_environment({**HERE, **others}) == Settings.from_environment(HERE)


@pytest.mark.parametrize("variable", [*DASH_TOOLS, *(name.lower() for name in DASH_TOOLS)])
@pytest.mark.parametrize("text", ["1", "true", "True", "yes", "0"])
def test_no_tool_of_dash_runs_in_production(variable, text):
    """Dash takes "0" for true as well."""
    with pytest.raises(InputError, match=f"^{variable} must be false or left out in production, got '{text}'"):
        Settings.from_environment({**HERE, variable: text})
    assert Settings.from_environment({**HERE, variable: text, "GAINSCOPE_MODE": "development"}).mode == "development"


@pytest.mark.parametrize("text", ["", "false", "False"])
def test_a_tool_of_dash_that_is_off_is_no_matter(text):
    off = dict.fromkeys(DASH_TOOLS, text)
    assert Settings.from_environment({**HERE, **off}) == Settings.from_environment(HERE)


def test_dash_takes_the_same_words_for_true(monkeypatch):
    configs = pytest.importorskip("dash._configs")
    for text, on in [("", False), ("false", False), ("False", False), ("0", True), ("true", True), ("yes", True)]:
        for name in DASH_TOOLS:
            monkeypatch.setenv(name, text)
            assert bool(configs.get_combined_config(name.removeprefix("DASH_").lower(), None, False)) is on


def test_every_setting_is_in_the_table():
    rows = table().splitlines()
    assert len(rows) == 2 + len(NAMES)
    for name, row in zip(NAMES, rows[2:], strict=True):
        cells = row.removeprefix("| ").removesuffix(" |").split(" | ")
        assert cells[0] == f"`GAINSCOPE_{name.upper()}`"
        assert len(cells) == 4
        assert all(cells)
        assert cells[3].endswith(".")
