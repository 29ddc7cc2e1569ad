"""Requests and sockets without a network, in the words of ASGI, and over one; the same examples in every run."""

import asyncio
from dataclasses import replace

import pytest
from hypothesis import settings

from server import metrics
from server.lifecycle import config_of
from tests.serving import on_a_port

settings.register_profile("server", derandomize=True, deadline=None, max_examples=100, print_blob=True)
settings.load_profile("server")

HOST = "gainscope.test:8050"


def scope_of(kind, path, **more):
    headers = {"host": HOST, **more.pop("headers", {})}
    base = {
        "type": kind,
        "asgi": {"version": "3.0", "spec_version": "2.3"},
        "http_version": "1.1",
        "scheme": "http" if kind == "http" else "ws",
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"",
        "root_path": "",
        "headers": [(name.encode(), str(value).encode("latin-1")) for name, value in headers.items()],
        "client": ("192.0.2.7", 50_000),
        "server": ("127.0.0.1", 8050),
        "extensions": {"websocket.http.response": {}} if kind == "websocket" else {},
        **({"method": "GET"} if kind == "http" else {"subprotocols": []}),
    }
    return base | more


class Answer:
    """What came back of a request."""

    def __init__(self, sent):
        self.sent = sent
        start = next((message for message in sent if message["type"].endswith("response.start")), None)
        self.status = start and start["status"]
        self.headers = {name.decode(): value.decode() for name, value in (start["headers"] if start else ())}
        self.body = b"".join(message.get("body", b"") for message in sent if message["type"].endswith("response.body"))
        self.is_whole = bool(sent) and not sent[-1].get("more_body", False)


async def ask_async(app, method="GET", path="/", *, body=(), until=None, **more):
    """One request; None instead of a part of its body is that the client leaves; given up on at an event."""
    parts = [body] if isinstance(body, bytes) else list(body)
    scope = scope_of("http", path, method=method, **more)
    sent = []

    async def receive():
        if not parts:
            await asyncio.sleep(3600)
        part = parts.pop(0)
        if part is None:
            return {"type": "http.disconnect"}
        return {"type": "http.request", "body": part, "more_body": bool(parts)}

    async def send(message):
        sent.append(message)

    if not parts:
        parts.append(b"")
    task = asyncio.ensure_future(app(scope, receive, send))
    if until is not None:
        await until.wait()
        task.cancel()
    await task
    return Answer(sent)


@pytest.fixture
def counted():
    """By how much a figure has grown since it was looked at first."""
    before = {}

    def grown(name, **labels):
        key = (name, *sorted(labels.items()))
        now = metrics.REGISTRY.get_sample_value(name, labels) or 0
        return now - before.setdefault(key, now)

    return grown


@pytest.fixture(scope="session")
def ask():
    """One request and its answer: `ask(app, method, path, body=parts, headers={...})`."""
    return lambda app, *args, **more: asyncio.run(ask_async(app, *args, **more))


@pytest.fixture(scope="session")
def talk():
    """One socket: what the server sent to a client that said these texts and left."""

    async def once(app, path="/", *, said=(), **more):
        incoming = [
            {"type": "websocket.connect"},
            *({"type": "websocket.receive", "text": text} for text in said),
            {"type": "websocket.disconnect", "code": 1000},
        ]
        sent = []

        async def receive():
            return incoming.pop(0)

        async def send(message):
            sent.append(message)

        headers = {"origin": f"http://{HOST}", **more.pop("headers", {})}
        headers = {name: value for name, value in headers.items() if value is not None}
        await app(scope_of("websocket", path, headers=headers, **more), receive, send)
        return sent

    return lambda *args, **more: asyncio.run(once(*args, **more))


@pytest.fixture(scope="session")
def served():
    """An application on a port, as it is served for good: `with served(app, settings) as address: ...`."""
    return lambda app, settings: on_a_port(config_of(replace(settings, port=0), app))
