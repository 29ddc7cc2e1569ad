"""What comes from outside, read or refused: never anything but a value of the type or an InputError."""

import json
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import Meta, Struct

from server.typed import reader
from tracker_core.checks import InputError


class Point(Struct, forbid_unknown_fields=True):
    """Two numbers and a name."""

    x: float
    y: Annotated[int, Meta(ge=0, le=9)] = 0
    names: Annotated[dict[Annotated[str, Meta(max_length=3)], str], Meta(max_length=2)] = {}

    def __post_init__(self):
        if self.x == 13:
            raise InputError("x", "must not be 13", self.x)


read = reader(Point, "point")


def read_or_error(raw):
    try:
        return read(raw)
    except InputError as error:
        return error


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda deeper: st.lists(deeper, max_size=3) | st.dictionaries(st.sampled_from(["x", "y", "z"]), deeper, max_size=3),
    max_leaves=8,
)


def test_what_fits_is_read():
    assert read('{"x": 1, "names": {"a": "b"}}') == Point(1.0, 0, {"a": "b"})
    assert read(b'{"x": 1e3, "y": 9}') == Point(1000.0, 9)


@pytest.mark.parametrize(
    ("raw", "field", "rule"),
    [
        ("[]", "point", "must be object"),
        ("{}", "point", "must fit: Object missing required field x"),
        ('{"x": "1"}', "x", "must be float"),
        ('{"x": true}', "x", "must be float"),
        ('{"x": 1, "y": 10}', "y", "must be int <= 9"),
        ('{"x": 1, "y": 1.5}', "y", "must be int"),
        ('{"x": 1, "z": 1}', "point", "must fit: Object contains unknown field z"),
        ('{"x": 1, "names": {"long": ""}}', "names", "must be str of length <= 3"),
        ('{"x": 1, "names": {"a": 1}}', "names[...]", "must be str"),
        ('{"x": 1, "names": {"a": "", "b": "", "c": ""}}', "names", "must be object of length <= 2"),
        ('{"x": 13}', "x", "must not be 13"),
        ('{"x": 1e999}', "x", "must fit: Number out of range"),
        ('{"x": NaN}', "point", "must be JSON of a moderate depth"),
        ("", "point", "must be JSON of a moderate depth"),
        ('{"x": 1', "point", "must be JSON of a moderate depth"),
        (b'{"x": 1, "names": {"a": "\xff"}}', "point", "must be JSON of a moderate depth"),
        ('{"x": 1, "names": {"\ud800": "a"}}', "point", "must be JSON of a moderate depth"),
        (b'{"x": 1, "names": {"\\ud801": "a"}}', "point", "must be JSON of a moderate depth"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(raw, field, rule):
    with pytest.raises(InputError) as caught:
        read(raw)
    assert caught.value.field == field
    assert caught.value.rule == rule


def test_what_is_deep_is_refused_wherever_it_stands():
    anything = reader(list, "list")
    with pytest.raises(InputError, match="must be JSON of a moderate depth"):
        anything("[" * 100_000 + "]" * 100_000)


@given(raw=st.binary(max_size=40) | st.text(max_size=40) | JSON.map(json.dumps))
def test_anything_is_a_point_or_an_error(raw):
    found = read_or_error(raw)
    if isinstance(found, InputError):
        assert found.field
        assert found.rule.startswith("must ")
        assert len(str(found)) < 300
    else:
        assert isinstance(found, Point)
        assert type(found.x) is float
