from __future__ import annotations

import pytest

from server.origin import same_origin


@pytest.mark.parametrize(
    ("origin", "host", "same"),
    [
        ("http://localhost:8050", "localhost:8050", True),
        ("https://localhost:8050", "localhost:8050", True),
        ("http://LocalHost:8050", "localhost:8050", True),
        ("http://localhost:8050", "LOCALHOST:8050", True),
        ("https://gainscope.example", "gainscope.example", True),
        ("http://[::1]:8050", "[::1]:8050", True),
        ("http://localhost:8051", "localhost:8050", False),
        ("http://localhost", "localhost:8050", False),
        ("http://127.0.0.1:8050", "localhost:8050", False),
        ("http://evil.example", "localhost:8050", False),
        ("http://localhost:8050.evil.example", "localhost:8050", False),
        ("http://evil.example/localhost:8050", "localhost:8050", False),
        ("http://evil.example#localhost:8050", "localhost:8050", False),
        ("http://localhost:8050@evil.example", "localhost:8050", False),
        ("localhost:8050", "localhost:8050", False),
        ("null", "localhost:8050", False),
        ("", "localhost:8050", False),
        (None, "localhost:8050", False),
        ("http://localhost:8050", None, False),
        (None, None, False),
    ],
)
def test_a_page_of_this_server_and_no_other_may_speak(origin, host, same):
    assert same_origin(origin, host) is same


@pytest.mark.parametrize("origin", ["http://[", "http://[gainscope]", "http://a\u2100b"])
def test_an_origin_that_cannot_be_read_is_a_foreign_one(origin):
    assert same_origin(origin, "localhost:8050") is False
