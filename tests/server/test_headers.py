"""Headers of answers: what is added, and that what a page says itself stands."""

import pytest

from server.headers import UNUSED, USED, Headers, with_ancestors

PAGE = (b"content-type", b"text/html; charset=utf-8")
DATA = (b"content-type", b"application/json")


def completed(headers, *own, status=200):
    names = [name for name, _ in headers.complete(status, own, b"number")]
    assert len(names) == len(set(names))
    return {name.decode(): value.decode() for name, value in headers.complete(status, own, b"number")}


def test_everything_has_all_of_them():
    found = completed(Headers(), DATA)
    assert found["x-content-type-options"] == "nosniff"
    assert found["referrer-policy"] == "same-origin"
    assert found["cross-origin-opener-policy"] == found["cross-origin-resource-policy"] == "same-origin"
    assert found["x-request-id"] == "number"
    features = dict(feature.split("=") for feature in found["permissions-policy"].split(", "))
    assert features == dict.fromkeys(UNUSED, "()") | dict.fromkeys(USED, "(self)")


@pytest.mark.parametrize(
    ("own", "status", "policy"),
    [
        ([PAGE], 200, "default-src 'none'; frame-ancestors 'self'"),
        ([DATA], 200, "default-src 'none'; frame-ancestors 'self'"),
        ([], 405, "default-src 'none'; frame-ancestors 'self'"),
        # It would change the policy of the page that the browser has.
        ([], 304, None),
        ([(b"content-security-policy", b"sandbox")], 304, "sandbox; frame-ancestors 'self'"),
        ([PAGE, (b"content-security-policy", b"img-src blob:")], 200, "img-src blob:; frame-ancestors 'self'"),
    ],
)
def test_what_has_no_policy_of_its_own_may_do_nothing(own, status, policy):
    assert completed(Headers(), *own, status=status).get("content-security-policy") == policy


@pytest.mark.parametrize(
    ("frames", "ancestors", "older"),
    [
        ("'self'", "'self'", "SAMEORIGIN"),
        ("'none'", "'self'", "SAMEORIGIN"),
        ("", "'self'", "SAMEORIGIN"),
        ("https://moodle.example", "'self' https://moodle.example", None),
        ("'self' https://a.example https://*.b.example", "'self' https://a.example https://*.b.example", None),
    ],
)
def test_who_may_show_pages_in_a_frame_is_a_setting(frames, ancestors, older):
    headers = Headers(frames)
    viser = (b"content-security-policy", b"default-src 'none'; frame-ancestors 'self'; img-src blob:")
    for own in ([PAGE], [DATA], [viser, PAGE]):
        found = completed(headers, *own)
        assert found["content-security-policy"].endswith(f"; frame-ancestors {ancestors}")
        assert found["content-security-policy"].count("frame-ancestors") == 1
        assert found.get("x-frame-options") == older


def test_what_an_answer_says_itself_stands():
    found = completed(Headers(), (b"referrer-policy", b"no-referrer"), (b"cache-control", b"private"))
    assert (found["referrer-policy"], found["cache-control"]) == ("no-referrer", "private")


@pytest.mark.parametrize("policy", [b"", b" ; ", b"Frame-Ancestors *", b"frame-ancestors", b";frame-ancestors  a  b;"])
def test_a_policy_of_nothing_else_says_who_may_show_the_page(policy):
    assert with_ancestors(policy, "'self'") == b"frame-ancestors 'self'"
