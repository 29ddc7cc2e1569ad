"""What every request passes: its number, its limits, what goes wrong with it. In the words of ASGI, on small routes."""

import asyncio
import json
import logging
from dataclasses import replace

import pytest
from dash.exceptions import PreventUpdate
from fastapi import FastAPI, HTTPException, Request
from fastapi.responses import StreamingResponse
from starlette.requests import ClientDisconnect

from server import exchange, guard, metrics
from server.clients import FORWARDED
from server.guard import Guard
from server.screen import LARGEST_HEADERS, LONGEST_ADDRESS, MOST_HEADERS
from server.settings import Settings
from tests.waiting import eventually

SHAPE = {"field", "rule", "received", "message", "request"}
SETTINGS = Settings(body_kb=1, requests_per_second=1e6, requests_at_once=1_000_000)
ELSEWHERE = "http://elsewhere.test"


class Swallowing:
    """Between the guard and the routes, like Dash's own: reads the body first, and answers what goes wrong there."""

    def __init__(self, app):
        self.app = app

    async def __call__(self, scope, receive, send):
        if scope["type"] != "http" or not scope["path"].startswith("/_dash-"):
            return await self.app(scope, receive, send)
        try:
            body = await Request(scope, receive).json()
        except Exception:  # noqa: BLE001 - as Dash does
            body = None
        scope["state"]["body"] = body
        try:
            await self.app(scope, receive, send)
        except PreventUpdate:
            await send({"type": "http.response.start", "status": 204, "headers": []})
            await send({"type": "http.response.body"})


def made(settings=SETTINGS):
    server = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    @server.get("/number/{value}")
    async def number(value: int, request: Request):
        client = request.scope["client"][0]
        return {"value": value, "client": client, "scheme": request.url.scheme, "request": request.state.request}

    @server.post("/body")
    @server.put("/own")
    async def body(request: Request):
        return {"bytes": len(await request.body())}

    @server.post("/_dash-update-component")
    async def callback(request: Request):
        if request.state.body["wanted"] == "nothing":
            raise PreventUpdate
        return {"bytes": request.state.body["wanted"] / 0}

    @server.get("/broken")
    async def broken():
        raise ZeroDivisionError("a secret")

    @server.get("/teapot")
    async def teapot():
        raise HTTPException(418, "is a teapot", {"X-Spout": "short"})

    @server.get("/late")
    async def late():
        async def parts():
            yield b"one"
            raise ZeroDivisionError("a secret")

        return StreamingResponse(parts())

    @server.get("/left")
    async def left():
        raise ClientDisconnect

    @server.get("/livez")
    async def livez():
        return {}

    metrics.attach(server, settings.metrics_token)
    server.add_middleware(Swallowing)
    guard.attach(server, settings, own_bounds={("PUT", "/own")})
    return server


@pytest.fixture(scope="module")
def app():
    return made()


def refused(answer, status, field):
    """What a refusal says, in the one shape of all of them."""
    assert answer.status == status
    assert answer.is_whole
    said = json.loads(answer.body)
    assert set(said) == SHAPE
    assert said["field"] == field
    assert said["request"] == answer.headers["x-request-id"]
    assert answer.headers["cache-control"] == "no-store"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert int(answer.headers["content-length"]) == len(answer.body)
    return said


# Numbers -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a", "0123abcd-ABCD", "x" * 64])
def test_a_number_of_a_known_proxy_is_kept(ask, name):
    behind = made(replace(SETTINGS, proxies="198.51.100.0/24, 192.0.2.7"))
    answer = ask(behind, path="/number/1", headers={"x-request-id": name})
    assert answer.headers["x-request-id"] == json.loads(answer.body)["request"] == name


@pytest.mark.parametrize(
    ("name", "proxies"),
    [("a", ""), ("a", "192.0.2.8"), ("", "192.0.2.7"), ("x" * 65, "192.0.2.7"), ("a b", "192.0.2.7"),
     ("a\nb", "192.0.2.7"), ("ä", "192.0.2.7")],
)  # fmt: skip
def test_any_other_number_is_replaced(ask, name, proxies):
    behind = made(replace(SETTINGS, proxies=proxies))
    numbers = [ask(behind, path="/number/1", headers={"x-request-id": name}).headers["x-request-id"] for _ in "ab"]
    assert numbers[0] != numbers[1]
    assert all(len(number) == 16 and int(number, 16) >= 0 for number in numbers)


def test_the_client_is_who_a_known_proxy_says(ask):
    said = {"x-forwarded-for": "203.0.113.9, 198.51.100.1", "x-forwarded-proto": "https"}
    for proxies, client, scheme in [
        ("", "192.0.2.7", "http"),
        ("192.0.2.7", "198.51.100.1", "https"),
        ("192.0.2.7,198.51.100.0/24", "203.0.113.9", "https"),
    ]:
        seen = json.loads(ask(made(replace(SETTINGS, proxies=proxies)), path="/number/1", headers=said).body)
        assert (seen["client"], seen["scheme"]) == (client, scheme)


# What goes wrong ---------------------------------------------------------------------------------------------------


def test_an_error_is_logged_under_the_number_that_the_answer_has(app, ask, caplog, counted):
    labels = {"where": "route", "kind": "ZeroDivisionError"}
    counted("gainscope_errors_total", **labels)
    said = refused(ask(app, path="/broken"), 500, "server")
    assert "secret" not in json.dumps(said)
    (record,) = (record for record in caplog.records if record.name == "server.errors")
    assert said["request"] in record.getMessage()
    assert record.exc_info[0] is ZeroDivisionError
    assert counted("gainscope_errors_total", **labels) == 1


def test_an_error_of_a_callback_passes_by_what_would_answer_it(app, ask, caplog, counted):
    labels = {"where": "callback", "kind": "ZeroDivisionError"}
    counted("gainscope_errors_total", **labels)
    headers = {"content-length": 13}
    refused(ask(app, "POST", "/_dash-update-component", body=b'{"wanted": 1}', headers=headers), 500, "server")
    assert counted("gainscope_errors_total", **labels) == 1
    headers = {"content-length": 21}
    answer = ask(app, "POST", "/_dash-update-component", body=b'{"wanted": "nothing"}', headers=headers)
    assert answer.status == 204
    assert len([record for record in caplog.records if record.name == "server.errors"]) == 1


def test_an_answer_that_has_begun_breaks_off(app, ask, caplog):
    answer = ask(app, path="/late")
    assert (answer.status, answer.body, answer.is_whole) == (200, b"one", False)
    assert [record.name for record in caplog.records if record.levelno == logging.ERROR] == ["server.errors"]


def test_who_left_is_nobodys_error(app, ask, caplog, counted):
    labels = {"route": "/left", "method": "GET", "status": "499"}
    counted("gainscope_requests_total", **labels)
    assert ask(app, path="/left").sent == []
    headers = {"transfer-encoding": "chunked"}
    ask(app, "POST", "/_dash-update-component", body=[b'{"wan', None], headers=headers)
    assert counted("gainscope_requests_total", **labels) == 1
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]


@pytest.mark.parametrize(
    ("method", "path", "status", "field"),
    [
        ("GET", "/nowhere", 404, "address"),
        ("POST", "/number/1", 405, "method"),
        ("OPTIONS", "/body", 405, "method"),
        ("BREW", "/body", 405, "method"),
        ("GET", "/number/one", 422, "value"),
        ("GET", "/teapot", 418, "request"),
    ],
)
def test_what_routing_refuses_has_the_shape_of_every_refusal(app, ask, method, path, status, field):
    answer = ask(app, method, path)
    refused(answer, status, field)
    if status == 405:
        assert answer.headers["allow"] in ("GET", "POST")
    if status == 418:
        assert answer.headers["x-spout"] == "short"
        assert json.loads(answer.body)["rule"] == "is a teapot"


@pytest.mark.parametrize("path", ["/number/1", "/late", "/nowhere", "/broken", f"/{'x' * 9000}"])
def test_head_is_get_without_a_body(app, ask, path):
    one, other = ask(app, "GET", path), ask(app, "HEAD", path)
    assert other.status == one.status
    assert (other.body, other.is_whole) == (b"", True)
    assert set(other.headers) == set(one.headers)
    assert len(other.sent) == 2


# Limits ------------------------------------------------------------------------------------------------------------


def chunked(size, of=100):
    return [b"x" * min(of, size - at) for at in range(0, size, of)]


@pytest.mark.parametrize("path", ["/body", "/_dash-update-component"])
def test_a_body_that_says_it_is_too_large_is_refused_at_once(app, ask, counted, path):
    counted("gainscope_refusals_total", reason="body")
    answer = ask(app, "POST", path, body=[None], headers={"content-length": 1025})
    refused(answer, 413, "body")
    assert answer.headers["connection"] == "close"
    assert counted("gainscope_refusals_total", reason="body") == 1


@pytest.mark.parametrize("path", ["/body", "/_dash-update-component"])
def test_one_that_does_not_is_refused_as_it_comes(app, ask, caplog, path):
    headers = {"transfer-encoding": "chunked"}
    refused(ask(app, "POST", path, body=chunked(2000), headers=headers), 413, "body")
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]


@pytest.mark.parametrize(
    ("size", "headers"), [(1024, {"content-length": 1024}), (1024, {"transfer-encoding": "chunked"})]
)
def test_one_that_is_as_large_as_may_be_is_taken(app, ask, size, headers):
    answer = ask(app, "POST", "/body", body=chunked(size), headers=headers)
    assert (answer.status, json.loads(answer.body)) == (200, {"bytes": size})


def test_what_has_a_bound_of_its_own_is_left_to_it(app, ask):
    answer = ask(app, "PUT", "/own", body=chunked(5000), headers={"content-length": 5000})
    assert json.loads(answer.body) == {"bytes": 5000}


def test_a_body_that_comes_too_slowly_is_refused(app, ask, monkeypatch, counted):
    counted("gainscope_refusals_total", reason="slow")
    monkeypatch.setattr(exchange.Exchange.bound, "__defaults__", (0.05,))

    async def dribble():
        parts = iter([b"x", b"x"])
        sent = []

        async def receive():
            part = next(parts, None)
            if part is None:
                await asyncio.sleep(3600)
            return {"type": "http.request", "body": part, "more_body": True}

        async def send(message):
            sent.append(message)

        scope = {
            "type": "http", "http_version": "1.1", "method": "POST", "path": "/body", "raw_path": b"/body",
            "query_string": b"", "root_path": "", "scheme": "http", "headers": [(b"content-length", b"3")],
            "client": ("192.0.2.7", 1), "server": ("127.0.0.1", 8050),
        }  # fmt: skip
        await app(scope, receive, send)
        return sent

    sent = asyncio.run(asyncio.wait_for(dribble(), 20))
    assert [message.get("status") for message in sent][:1] == [408]
    assert counted("gainscope_refusals_total", reason="slow") == 1


@pytest.mark.parametrize(
    ("more", "status", "field"),
    [
        ({"path": "/" + "x" * LONGEST_ADDRESS}, 414, "address"),
        ({"path": "/number/1", "query_string": b"x" * LONGEST_ADDRESS}, 414, "address"),
        ({"path": "/number/1", "headers": {"cookie": "x" * LARGEST_HEADERS}}, 431, "headers"),
        ({"path": "/number/1", "headers": {f"x-{i}": "" for i in range(MOST_HEADERS)}}, 431, "headers"),
    ],
)
def test_addresses_and_headers_have_an_end(app, ask, more, status, field):
    refused(ask(app, **more), status, field)


def test_a_client_has_its_share_and_then_waits(ask, counted):
    app = made(replace(SETTINGS, requests_per_second=0.1, requests_at_once=3))
    counted("gainscope_refusals_total", reason="rate")
    assert [ask(app, path="/number/1").status for _ in range(3)] == [200, 200, 200]
    answer = ask(app, path="/number/1")
    refused(answer, 429, "requests")
    assert answer.headers["retry-after"] == "10"
    assert counted("gainscope_refusals_total", reason="rate") == 1
    # Others have theirs.
    assert ask(app, path="/number/1", client=("192.0.2.8", 1)).status == 200
    one_network = [(f"2001:db8::{i}", 1) for i in range(1, 5)]
    assert [ask(app, path="/number/1", client=client).status for client in one_network] == [200, 200, 200, 429]


HERE, PROXY, ELSE = ("127.0.0.1", 1), ("192.0.2.7", 1), ("192.0.2.8", 1)


@pytest.mark.parametrize(
    ("path", "client", "headers", "token", "statuses"),
    [
        ("/livez", HERE, {}, "", {200}),
        ("/livez", ("::1", 1), {}, "", {200}),
        ("/livez", PROXY, {}, "", {200}),
        ("/livez", ELSE, {}, "", {200, 429}),
        ("/livez", None, {}, "", {200, 429}),
        *(("/livez", client, {name.decode(): "192.0.2.9"}, "", {200, 429})
          for client in (HERE, PROXY) for name in FORWARDED),
        ("/metrics", HERE, {}, "", {200}),
        ("/metrics", ELSE, {}, "", {404, 429}),
        ("/metrics", ELSE, {"authorization": "Bearer secret"}, "secret", {200}),
        ("/metrics", ELSE, {"authorization": "Bearer guess"}, "secret", {401, 429}),
        ("/metrics", HERE, {}, "secret", {401, 429}),
        ("/number/1", HERE, {}, "", {200, 429}),
    ],
)  # fmt: skip
def test_machines_that_have_to_may_ask_at_any_rate(ask, caplog, path, client, headers, token, statuses):
    caplog.set_level(logging.INFO, "server.access")
    rare = replace(SETTINGS, requests_per_second=0.1, requests_at_once=2, proxies="192.0.2.7", metrics_token=token)
    app = made(rare)
    assert {ask(app, path=path, client=client, headers=headers).status for _ in range(4)} == statuses
    assert bool(caplog.records) == (max(statuses) >= 400)


@pytest.mark.parametrize(
    ("headers", "is_let_in"),
    [
        ({}, True),
        ({"origin": "http://gainscope.test:8050"}, True),
        ({"origin": "http://gainscope.test:8050", "sec-fetch-site": "same-origin"}, True),
        ({"sec-fetch-site": "none"}, True),
        ({"origin": ELSEWHERE}, False),
        ({"origin": "null"}, False),
        ({"sec-fetch-site": "cross-site"}, False),
        ({"origin": "http://gainscope.test:8050", "sec-fetch-site": "same-site"}, False),
    ],
)
def test_no_page_of_another_server_changes_anything(app, ask, headers, is_let_in):
    for method, path in (("POST", "/body"), ("PUT", "/own"), ("PATCH", "/body"), ("DELETE", "/body")):
        answer = ask(app, method, path, headers=headers)
        if is_let_in:
            assert answer.status in (200, 405)
        else:
            refused(answer, 403, "origin")
    assert ask(app, path="/number/1", headers=headers).status == 200


@pytest.mark.parametrize("status", [None, 200])
def test_what_is_given_up_on_is_answered_unless_it_has_an_answer(ask, counted, status):
    """As uvicorn gives up on what is in flight when the server has to stop."""
    counted("gainscope_refusals_total", reason="ended")
    at_work = asyncio.Event()

    async def working(scope, receive, send):
        if status is not None:
            await send({"type": "http.response.start", "status": status, "headers": []})
            await send({"type": "http.response.body", "body": b"a part", "more_body": True})
        at_work.set()
        await asyncio.sleep(3600)

    answer = ask(Guard(working, SETTINGS), until=at_work)
    if status is None:
        refused(answer, 503, "server")
        assert answer.headers["retry-after"] == "5"
    else:
        assert (answer.status, answer.body, answer.is_whole) == (status, b"a part", False)
    assert counted("gainscope_refusals_total", reason="ended") == (status is None)


# Beginning and end -------------------------------------------------------------------------------------------------


def test_nothing_is_kept_of_what_passes():
    """A part of an answer goes on before the next one is there."""
    steps = []

    async def app(scope, receive, send):
        await send({"type": "http.response.start", "status": 200, "headers": []})
        for part in (b"a", b"b"):
            steps.append(("said", part))
            await send({"type": "http.response.body", "body": part, "more_body": part == b"a"})

    async def play():
        async def send(message):
            if message["type"] == "http.response.body":
                steps.append(("sent", message["body"]))

        scope = {"type": "http", "http_version": "1.1", "method": "GET", "path": "/", "raw_path": b"/",
                 "query_string": b"", "headers": [], "client": None}  # fmt: skip
        await Guard(app, SETTINGS)(scope, None, send)

    asyncio.run(play())
    assert steps == [("said", b"a"), ("sent", b"a"), ("said", b"b"), ("sent", b"b")]


def test_how_late_the_loop_is_shows_while_the_server_runs(counted):
    async def app(scope, receive, send):
        counted("gainscope_event_loop_lateness_seconds_count")
        await eventually(lambda: counted("gainscope_event_loop_lateness_seconds_count"))

    async def play():
        await asyncio.wait_for(Guard(app, SETTINGS)({"type": "lifespan"}, None, None), 20)
        return [
            task.get_name() for task in asyncio.all_tasks() if task.get_name() == "lateness" and not task.cancelling()
        ]

    assert asyncio.run(play()) == []
