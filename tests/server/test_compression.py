"""Answers on their way out: smaller where that helps, the same in the end, and untouched where they are streams."""

import asyncio
import json

import brotli
import httpx
import pytest
from fastapi import FastAPI
from hypothesis import given
from hypothesis import strategies as st
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse

from server import compression
from server.compression import LEAST, LONG, Compression, Memory

LARGE = {"numbers": list(range(1_000))}


@pytest.fixture(scope="module")
def get():
    """Asks a server with answers of several kinds; the request has no header that is not given."""
    app = FastAPI()
    app.add_middleware(Compression)
    answers = {
        "json": lambda: JSONResponse(LARGE),
        "text": lambda: PlainTextResponse("word " * 1_000),
        "untyped": lambda: Response(json.dumps(LARGE)),
        "small": lambda: JSONResponse({"a": 1}),
        "zip": lambda: Response(b"PK" * 1_000, media_type="application/zip"),
        "stream": lambda: StreamingResponse(iter([b"word " * 1_000] * 3), media_type="text/csv"),
        "done": lambda: Response(b"x" * 5_000, media_type="text/plain", headers={"Content-Encoding": "br"}),
        "other": lambda: JSONResponse(LARGE, headers={"Vary": "Cookie"}, status_code=422),
    }

    @app.api_route("/{name}", methods=["GET", "HEAD"])
    async def answer(name: str) -> Response:
        return answers[name]()

    def ask(name, accepted="br", method="GET"):
        async def once():
            transport = httpx.ASGITransport(app=app)
            async with (
                httpx.AsyncClient(transport=transport, base_url="http://gainscope.test") as client,
                client.stream(method, f"/{name}", headers={"Accept-Encoding": accepted}) as answer,
            ):
                return answer.status_code, answer.headers, b"".join([part async for part in answer.aiter_raw()])

        return asyncio.run(once())

    return ask


@pytest.mark.parametrize("name", ["json", "text", "untyped"])
@pytest.mark.parametrize("coding", ["br", "gzip"])
def test_text_is_sent_smaller_and_is_the_same(get, name, coding):
    _, plain, body = get(name, "identity")
    _, headers, small = get(name, coding)
    assert headers["content-encoding"] == coding
    assert "content-encoding" not in plain
    assert int(headers["content-length"]) == len(small) < len(body)
    assert headers["vary"] == "Accept-Encoding"
    assert httpx.Response(200, headers=headers, content=small).content == body


def test_what_stands_in_other_headers_stays(get):
    status, headers, _ = get("other")
    assert status == 422
    assert {part.strip() for part in headers["vary"].split(",")} == {"Cookie", "Accept-Encoding"}


@pytest.mark.parametrize("name", ["small", "zip", "stream", "done"])
def test_what_gains_nothing_or_is_a_stream_passes(get, name):
    _, plain, body = get(name, "identity")
    _, headers, same = get(name, "br")
    assert same == body
    assert headers.get("content-encoding") == plain.get("content-encoding")


def test_an_answer_without_a_body_is_left_alone(get):
    assert "content-encoding" not in get("json", method="HEAD")[1]


BODY = json.dumps(LARGE).encode()


def test_what_comes_again_is_compressed_thoroughly_and_then_remembered(monkeypatch):
    efforts = []
    real = compression.write
    monkeypatch.setattr(compression, "write", lambda *asked: efforts.append(asked[2]) or real(*asked))
    memory = Memory()

    async def times(count):
        return [await memory.written(BODY, "br") for _ in range(count)]

    written = asyncio.run(times(5))
    assert efforts == ["quick", "thorough"]
    assert len(written[1]) < len(written[0])
    assert written[1:] == [written[1]] * 4
    assert {brotli.decompress(data) for data in written} == {BODY}


def test_codings_are_remembered_apart():
    memory = Memory()
    for _ in range(3):
        assert asyncio.run(memory.written(BODY, "br")) != asyncio.run(memory.written(BODY, "gzip"))


@given(st.lists(st.tuples(st.integers(0, 9), st.sampled_from(["br", "gzip"])), max_size=60))
def test_the_memory_is_bounded_and_never_wrong(asked):
    bodies = [bytes([number]) * (LEAST + 7_000 * number) + bytes(range(number)) for number in range(10)]
    memory = Memory(most=4, most_bytes=120)

    async def ask_all():
        for number, coding in asked:
            answer = await memory.written(bodies[number], coding)
            headers = {"content-encoding": coding}
            assert httpx.Response(200, headers=headers, content=answer).content == bodies[number]
            assert len(memory._known) <= 4
            assert memory._bytes == sum(map(len, memory._known.values())) <= 120

    asyncio.run(ask_all())


def test_slow_work_is_not_done_where_others_wait(monkeypatch):
    threads = []
    real = asyncio.to_thread
    monkeypatch.setattr(asyncio, "to_thread", lambda *asked: threads.append(asked[2:]) or real(*asked))
    body = bytes(range(256)) * (LONG // 256 + 1)
    for _ in range(2):
        asyncio.run(Memory().written(body, "br"))
        asyncio.run(Memory().written(body, "gzip"))
    assert threads == [("gzip", "quick")] * 2
