"""Files in and out over HTTP: what is taken, what is refused and how, what a browser is told to do with it."""

import asyncio
import gzip
import http.client
import threading
import time

import httpx
import pytest
import uvicorn
from fastapi import FastAPI

from layouts import uploads
from layouts.files import Store
from layouts.uploads import Uploads
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
    made = Store(tmp_path, most_bytes=5000, longest_age_days=30)
    measured.look_in(made.fetch)
    return made


def server_for(store):
    server = FastAPI()
    Uploads(store, most_bytes=LIMIT).attach(server)
    return server


@pytest.fixture
def ask():
    """A request to a server without a network."""

    def request(server, method, path, **more):
        async def once():
            transport = httpx.ASGITransport(app=server)
            async with httpx.AsyncClient(transport=transport, base_url=f"http://{HOST}") as client:
                return await client.request(method, path, **more)

        return asyncio.run(once())

    return request


def put(ask, server, content=TEXT, *, name="log.csv", keep="store", **more):
    return ask(server, "PUT", "/recordings", params={"name": name, "keep": keep}, content=content, **more)


def inside(store):
    return sorted(path.name for path in store.directory.iterdir())


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
    broken = Store(tmp_path / "file", most_bytes=5000, longest_age_days=30)
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
    for letter in (b"a", b"b"):
        assert put(ask, server, TEXT + b"# " + letter * 1200).status_code == 200
    for letter in (b"c", b"d", b"e"):
        answer = put(ask, server, TEXT + b"# " + letter * 1200)
    assert (answer.status_code, answer.json()["field"]) == (507, "file")
    assert "in this browser only" in answer.json()["message"]


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


def test_too_many_at_once_and_too_slow_ones_are_refused(ask, store, monkeypatch):
    monkeypatch.setattr(uploads, "AT_ONCE", 0)
    assert put(ask, server_for(store)).status_code == 503

    async def slow():
        yield TEXT
        await asyncio.sleep(60)

    monkeypatch.setattr(uploads, "AT_ONCE", 1)
    monkeypatch.setattr(uploads, "DEADLINE", 0.05)
    server = server_for(store)
    assert put(ask, server, slow()).status_code == 408
    assert inside(store) == []
    monkeypatch.undo()
    # The place of the one before is free again.
    monkeypatch.setattr(uploads, "AT_ONCE", 1)
    assert put(ask, server).status_code == 200


# Over a network ------------------------------------------------------------------------------------------------------


@pytest.fixture
def address(store):
    """A server on a port."""
    config = uvicorn.Config(server_for(store), host="127.0.0.1", port=0, log_level="error", lifespan="off")
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    yield server.servers[0].sockets[0].getsockname()
    server.should_exit = True
    thread.join()


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
    time.sleep(0.2)
    connection.close()
    for _ in range(200):
        if not inside(store):
            break
        time.sleep(0.02)
    assert inside(store) == []
