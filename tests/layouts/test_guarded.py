"""The guard around the application as it is: every route, whatever it answers."""

import json
import re

import pytest
from starlette.routing import Mount

from server.guard import Guard
from server.headers import UNUSED

HOST = "gainscope.test:8050"
ALWAYS = (
    "content-security-policy", "cross-origin-opener-policy", "cross-origin-resource-policy", "permissions-policy",
    "referrer-policy", "x-content-type-options", "x-frame-options", "x-request-id",
)  # fmt: skip
IN_WORDS = ("/readyz",)
"""Begin the addresses that say in words of their own what is not there."""

SHAPE = {"field", "rule", "received", "message", "request"}

ADDRESSES = [
    "/", "/stability", "/viser/dark/", "/assets/favicon.svg", "/_dash-layout", "/_dash-dependencies", "/recordings",
    "/livez", "/readyz", "/export/metrics.json?samples=20",
]  # fmt: skip
"""That are answered with what they are for."""


def paths(routes):
    """An address of every route; where a name stands in it, one that nothing is known by."""
    for route in routes:
        yield re.sub(r"{[^}]*}", "nothing", route.path) + ("/nothing" if isinstance(route, Mount) else "")


def looked_at(answer):
    assert set(ALWAYS) <= set(answer.headers)
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["content-security-policy"].endswith("frame-ancestors 'self'")
    assert all(f"{feature}=()" in answer.headers["permissions-policy"] for feature in UNUSED)
    assert len(answer.headers.get_list("content-security-policy")) == 1
    assert "server" not in answer.headers


def test_nothing_is_outside_the_guard(dash_app):
    assert dash_app.server.user_middleware[0].cls is Guard


@pytest.mark.parametrize("path", ADDRESSES)
def test_what_is_answered_has_the_headers(get, path):
    answer = get(path)
    assert answer.status_code in (200, 503)
    looked_at(answer)


@pytest.mark.parametrize("method", ["GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS"])
def test_every_route_has_them_whatever_it_answers(dash_app, http, method):
    found = sorted({path for path in paths(dash_app.server.routes) if path.startswith("/")})
    assert len(found) > 15
    for path in found:
        answer = http(method, path)
        looked_at(answer)
        is_page = answer.headers.get("content-type", "").startswith("text/html")
        if answer.status_code >= 400 and method != "HEAD" and not is_page and not path.startswith(IN_WORDS):
            said = answer.json()
            assert set(said) == SHAPE, path
            assert said["request"] == answer.headers["x-request-id"]


def test_a_page_of_another_server_changes_nothing(http):
    for method, path in (("PUT", "/recordings"), ("POST", "/_dash-update-component")):
        answer = http(method, path, headers={"origin": "http://elsewhere.test"})
        assert (answer.status_code, answer.json()["field"]) == (403, "origin")


def test_a_recording_may_be_larger_than_other_bodies(http):
    content = b"t,x\n" + b"".join(b"%d,%d\n" % (row, row) for row in range(60_000))
    assert len(content) > 256 * 1024
    assert http("PUT", "/recordings?keep=browser", content=content).status_code == 200
    answer = http("POST", "/_dash-update-component", content=content)
    assert (answer.status_code, answer.json()["field"]) == (413, "body")


def test_no_socket_opens_to_a_page_of_another_server(dash_app, talk):
    sockets = [path for path in paths(dash_app.server.routes) if path.endswith(("/live", "/study", "-ws-callback"))]
    assert len(sockets) > 5
    for path in [*sockets, "/viser/0123456789abcdef0123456789abcdef"]:
        assert talk(json.dumps({}), path=path, origin="http://elsewhere.test") == [
            {"type": "websocket.close", "code": 1008}
        ]
