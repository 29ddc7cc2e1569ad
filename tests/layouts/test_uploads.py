"""Files in and out over HTTP: what is taken, what is refused and how, what a browser is told to do with it."""

import asyncio
import gzip
import http.client
import threading
import time
from types import SimpleNamespace

import httpx
import pytest
import uvicorn
from fastapi import FastAPI

from layouts import uploads
from layouts.files import SUM, UNIT, Store
from layouts.uploads import Uploads
from server import metrics
from server.clients import CLIENT
from tests.serving import on_a_port
from tests.waiting import eventually
from tracker_core import measured
from tracker_core.measured import Shelf, content_name

HOST = "gainscope.test:8050"
TEXT = b"t,x,y\n" + b"".join(b"%d,%d,%d\n" % (row, 3 * row, row * row) for row in range(50))
LIMIT = 2000


@pytest.fixture
def shelf(monkeypatch):
    """Memory of this test alone."""
    own = Shelf(10_000)
    monkeypatch.setattr(uploads, "SHELF", own)
    monkeypatch.setattr(measured, "_sources", [own.fetch])
    return own


@pytest.fixture
def store(tmp_path, shelf):
    made = Store(tmp_path, most_bytes=4 * UNIT, longest_age_days=30)
    measured.look_in(made.fetch)
    return made


def server_for(store):
    server = FastAPI()
    Uploads(store, most_bytes=LIMIT).attach(server)
    return server


async def asked(server, method, path, *, client="a", **more):
    """A request of a client to a server without a network."""
    CLIENT.set(client)
    transport = httpx.ASGITransport(app=server)
    async with httpx.AsyncClient(transport=transport, base_url=f"http://{HOST}") as network:
        return await network.request(method, path, **more)


@pytest.fixture
def ask():
    """The same, and its answer."""
    return lambda *args, **more: asyncio.run(asked(*args, **more))


def put(ask, server, content=TEXT, *, name="log.csv", keep="store", **more):
    return ask(server, "PUT", "/recordings", params={"name": name, "keep": keep}, content=content, **more)


def inside(store):
    """What is in the folder beside the sum of it."""
    return sorted(path.name for path in store.directory.iterdir() if path.name != SUM)


def refusals(reason):
    """What was refused so far for a reason."""
    return metrics.REGISTRY.get_sample_value("gainscope_refusals_total", {"reason": reason}) or 0


# In and out ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("content", [TEXT, gzip.compress(TEXT, mtime=0), TEXT.decode().encode("utf-16")])
def test_what_goes_in_comes_out_as_it_was(ask, store, content):
    server = server_for(store)
    answer = put(ask, server, content)
    data = content_name(content)
    assert answer.status_code == 200
    assert answer.json() == {"data": data, "name": "log.csv", "bytes": len(content), "kept": "store"}
    assert inside(store) == [f"{data}.recording"]
    found = ask(server, "GET", f"/recordings/{data}")
    assert (found.status_code, found.content) == (200, content)
    assert found.headers["content-type"] == "application/octet-stream"
    assert found.headers["x-content-type-options"] == "nosniff"
    assert found.headers["content-disposition"].startswith('attachment; filename="log.csv"')
    there = ask(server, "HEAD", f"/recordings/{data}")
    assert (there.status_code, there.content) == (200, b"")


@pytest.mark.parametrize("keep", ["browser", "store"])
def test_what_is_not_to_be_kept_or_cannot_stays_in_memory(ask, shelf, store, keep):
    answer = put(ask, server_for(store if keep == "browser" else None), keep=keep)
    assert answer.json()["kept"] == "memory"
    assert inside(store) == []
    assert shelf.fetch(content_name(TEXT)).content == TEXT


def test_the_server_says_what_it_keeps(ask, store, tmp_path):
    assert ask(server_for(store), "GET", "/recordings").json() == {"most_bytes": LIMIT, "problem": "", "days": 30}
    assert ask(server_for(None), "GET", "/recordings").json() == {
        "most_bytes": LIMIT, "problem": "it was told to keep nothing",
    }  # fmt: skip
    (tmp_path / "file").touch()
    broken = Store(tmp_path / "file", most_bytes=UNIT, longest_age_days=30)
    assert ask(server_for(broken), "GET", "/recordings").json()["problem"]
    assert put(ask, server_for(broken)).json()["kept"] == "memory"


NAMES = [
    ("<img src=x onerror=alert(1)>.csv", "<img src=x onerror=alert(1)>.csv", "_img_src_x_onerror_alert_1_.csv"),
    ('a"; filename="evil.exe', 'a"; filename="evil.exe', "a_filename_evil.exe"),
    ("../../etc/passwd", "passwd", "passwd"),
    ("C:\\data\\log.csv", "log.csv", "log.csv"),
    ("line\r\nSet-Cookie: a=b.csv", "line Set-Cookie: a=b.csv", "line_Set-Cookie_a_b.csv"),
    ("höhe über grund.csv", "höhe über grund.csv", "h_he_ber_grund.csv"),
    ("\u202eexe.csv", "exe.csv", "exe.csv"),
    ("", "recording", "recording"),
    ("n" * 500, "n" * 80, "n" * 80),
]


@pytest.mark.parametrize(("sent", "name", "plain"), NAMES)
def test_a_name_is_text_and_nothing_else(ask, store, sent, name, plain):
    server = server_for(store)
    answer = put(ask, server, name=sent).json()
    assert answer["name"] == name
    headers = ask(server, "GET", f"/recordings/{answer['data']}").headers
    said = headers["content-disposition"]
    assert said.startswith(f"attachment; filename=\"{plain}\"; filename*=UTF-8''")
    assert said.count('"') == 2
    assert "set-cookie" not in headers


# What is refused -----------------------------------------------------------------------------------------------------


def streamed(*chunks):
    async def stream():
        for chunk in chunks:
            yield chunk

    return stream()


@pytest.mark.parametrize("said", [True, False])
def test_too_much_is_refused_by_its_length_or_as_it_comes(ask, store, said):
    content = b"1,2,3\n" * 1000
    sent = content if said else streamed(*(content[at : at + 64] for at in range(0, len(content), 64)))
    answer = put(ask, server_for(store), sent)
    assert answer.status_code == 413
    rule = "must have at most 0.002 MB; leave out columns, rows or tracks that are not needed"
    assert answer.json() == {
        "field": "file", "rule": rule, "received": "'0.0 MB'", "message": f"file {rule}, got “0.0 MB”.", "request": "",
    }  # fmt: skip
    assert answer.headers["connection"] == "close"
    assert inside(store) == []


def test_the_bound_itself_is_taken(ask, store):
    content = TEXT + b"# " + b"x" * (LIMIT - len(TEXT) - 3) + b"\n"
    assert len(content) == LIMIT
    assert put(ask, server_for(store), content).status_code == 200
    assert put(ask, server_for(store), content + b"\n").status_code == 413


@pytest.mark.parametrize(
    "content", [b"", b"\x00\x01\x02" * 99, b"%PDF-1.4\n", gzip.compress(TEXT, mtime=0)[:40], b"\n\n\n"]
)
@pytest.mark.parametrize("keep", ["store", "browser"])
def test_what_is_no_table_is_not_kept(ask, shelf, store, content, keep):
    answer = put(ask, server_for(store), content, keep=keep)
    assert answer.status_code == 422
    assert answer.json().keys() == {"field", "rule", "received", "message", "request"}
    assert inside(store) == []
    assert shelf.fetch(content_name(content)) is None


def test_a_way_to_keep_that_is_none_is_refused(ask, store):
    answer = put(ask, server_for(store), keep="forever")
    assert (answer.status_code, answer.json()["field"]) == (422, "keep")


def test_a_full_store_says_so(ask, store):
    server = server_for(store)
    for letter in "abcd":
        assert put(ask, server, TEXT + b"# " + letter.encode(), client=letter).status_code == 200
    before = refusals("full")
    answer = put(ask, server, TEXT + b"# e", client="e")
    assert (answer.status_code, answer.json()["field"]) == (507, "file")
    assert "in this browser only" in answer.json()["message"]
    assert refusals("full") == before + 1


def test_one_client_has_half_of_the_store_kept_and_as_much_again_in_a_day(ask, store, monkeypatch):
    now = time.monotonic()
    monkeypatch.setattr(uploads, "time", SimpleNamespace(monotonic=lambda: now))
    server = server_for(store)
    # What is there already is not kept once more.
    for letter in (b"a", b"a", b"b"):
        assert put(ask, server, TEXT + b"# " + letter).status_code == 200
    before = refusals("kept")
    refused = put(ask, server, TEXT + b"# c")
    assert (refused.status_code, refused.json()["field"], refusals("kept")) == (429, "file", before + 1)
    assert refused.json()["message"] == (
        "file must wait, or be kept in this browser only: of one address at most 0.131072 MB a day are kept here, "
        "got “log.csv”."
    )
    assert put(ask, server, TEXT + b"# c", keep="browser").status_code == 200
    assert put(ask, server, TEXT + b"# c", client="b").status_code == 200
    now += int(refused.headers["retry-after"])
    assert put(ask, server, TEXT + b"# d").status_code == 200
    assert put(ask, server, TEXT + b"# e").status_code == 429


def test_a_disk_that_fails_says_so(ask, store, monkeypatch):
    def full(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("layouts.files.os.fsync", full)
    answer = put(ask, server_for(store))
    assert (answer.status_code, answer.json()["received"]) == (507, "'No space left on device'")
    assert inside(store) == []


@pytest.mark.parametrize("data", ["0" * 32, "nonsense", "..", "%2e%2e%2fetc", "<b>"])
def test_what_is_not_there_is_said_to_be_missing(ask, store, data):
    answer = ask(server_for(store), "GET", f"/recordings/{data}")
    assert answer.status_code == 404
    assert ask(server_for(store), "HEAD", f"/recordings/{data}").status_code == 404


def test_too_slow_ones_are_refused_and_leave_their_place(ask, store, monkeypatch):
    async def slow():
        yield TEXT
        await asyncio.sleep(60)

    monkeypatch.setattr(uploads, "AT_ONCE", 1)
    monkeypatch.setattr(uploads, "DEADLINE", 0.05)
    server = server_for(store)
    assert put(ask, server, slow()).status_code == 408
    assert inside(store) == []
    monkeypatch.setattr(uploads, "DEADLINE", 60)
    assert put(ask, server).status_code == 200


@pytest.mark.parametrize("way", ["in", "out"])
def test_a_client_that_takes_its_places_leaves_the_others_theirs(store, monkeypatch, way):
    monkeypatch.setattr(uploads, "AT_ONCE", 2)
    monkeypatch.setattr(uploads, "OUT_AT_ONCE", 2)
    monkeypatch.setattr(uploads, "WAITING", 4)
    server, begun = server_for(store), []
    data = content_name(TEXT)

    async def slowly(going_on, name):
        begun.append(name)
        yield TEXT
        await going_on.wait()

    async def takes_slowly(going_on, name):
        """A client that is sent a file, and takes nothing of it for a while."""
        CLIENT.set(name[0])
        told = []

        async def take(message):
            told.append(message)
            if message.get("status") == 200:
                begun.append(name)
                await going_on.wait()

        scope = {
            "type": "http", "method": "GET", "path": f"/recordings/{data}", "query_string": b"", "headers": [],
            "asgi": {"version": "3.0", "spec_version": "2.3"}, "http_version": "1.1", "state": {}, "root_path": "",
        }  # fmt: skip
        await server(scope, asyncio.Event().wait, take)
        return told[0]["status"]

    async def visit(going_on, name):
        if way == "out":
            return await takes_slowly(going_on, name)
        params = {"name": name, "keep": "browser"}
        content = slowly(going_on, name)
        return (await asked(server, "PUT", "/recordings", client=name[0], params=params, content=content)).status_code

    async def play():
        await asked(server, "PUT", "/recordings?name=log.csv", content=TEXT)
        going_on = asyncio.Event()
        visits = [asyncio.create_task(visit(going_on, name)) for name in ("a1", "a2", "a3", "a4", "b1")]
        await eventually(lambda: len(begun) == 2)
        # Two wait, the last one of the first client finds no room even for that, the other client comes in.
        assert sorted(begun) == ["a1", "b1"]
        assert await visits[3] == 503
        going_on.set()
        return await asyncio.gather(*visits)

    assert asyncio.run(play()) == [200, 200, 200, 503, 200]
    assert begun[2:] == ["a2", "a3"]


def test_who_waits_in_vain_is_told_when_to_try_again(ask, store, monkeypatch):
    monkeypatch.setattr(uploads, "AT_ONCE", 0)
    monkeypatch.setattr(uploads, "OUT_AT_ONCE", 0)
    monkeypatch.setattr(uploads, "PATIENCE", 0.02)
    server, before = server_for(store), refusals("busy")
    for answer in (put(ask, server), ask(server, "GET", f"/recordings/{'0' * 32}")):
        assert (answer.status_code, answer.headers["retry-after"]) == (503, "5")
        assert answer.json()["rule"].startswith("must wait")
    assert refusals("busy") == before + 2


def test_the_figure_of_what_is_kept_is_brought_up_to_date_by_a_thread(ask, store, monkeypatch):
    looks = []
    monkeypatch.setattr(uploads, "SEEN_AFTER", -1)
    monkeypatch.setattr(store, "look", lambda: looks.append(threading.current_thread().name))
    server = server_for(store)
    put(ask, server)
    assert metrics.REGISTRY.get_sample_value("gainscope_recordings_kept_bytes") == store.size == UNIT
    asyncio.run(eventually(lambda: looks))
    assert looks[0].startswith("disk")


# Over a network ------------------------------------------------------------------------------------------------------


@pytest.fixture
def address(store):
    """A server on a port."""
    config = uvicorn.Config(server_for(store), host="127.0.0.1", port=0, log_level="error", lifespan="off")
    with on_a_port(config) as address:
        yield address


def test_who_sends_too_much_hears_it_even_while_sending(address):
    for size in (3 * LIMIT, 6 * LIMIT):
        connection = http.client.HTTPConnection(*address, timeout=20)
        connection.request("PUT", "/recordings?name=log.csv", body=b"1,2,3\n" * (size // 6))
        answer = connection.getresponse()
        assert answer.status == 413
        assert b'"field":"file"' in answer.read()
        connection.close()


def test_who_goes_away_in_the_middle_leaves_nothing(address, store):
    connection = http.client.HTTPConnection(*address, timeout=20)
    connection.putrequest("PUT", "/recordings?name=log.csv")
    connection.putheader("Content-Length", str(LIMIT))
    connection.endheaders(TEXT[:100])
    asyncio.run(eventually(lambda: inside(store)))
    connection.close()
    asyncio.run(eventually(lambda: not inside(store)))


def test_memory_lets_go_of_what_nobody_asks_for(ask, shelf, monkeypatch):
    """The browser that keeps it sends it again."""
    server = server_for(None)
    data = put(ask, server, keep="browser").json()["data"]
    assert shelf.fetch(data)
    monkeypatch.setattr(shelf, "lifetime", shelf.lifetime - uploads.LIFETIME)
    assert shelf.fetch(data) is None
    assert put(ask, server, keep="browser").json()["data"] == data
