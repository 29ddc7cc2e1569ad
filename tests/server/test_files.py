"""Files: what is served, in which coding, for how long it is kept, and that nothing else is reached."""

import asyncio
import gzip
import hashlib

import brotli
import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.responses import PlainTextResponse

from server.codings import COMPRESSED, preferred, write
from server.files import ASK, IMMUTABLE, Files, Serving
from server.routes import template

SCRIPT = b"'use strict'; // a script\n" * 200
OTHER = "another part of the server"


@pytest.fixture
def kept(tmp_path):
    return tmp_path / "kept"


@pytest.fixture
def files(kept, tmp_path):
    """A published script, and a page that is asked for anew every time."""
    (tmp_path / "script.js").write_bytes(SCRIPT)
    files = Files(kept)
    files.folder = files.publish("own", {"script.js": tmp_path / "script.js"})
    files.add("/", b"<!doctype html><title>A page</title>", "text/html; charset=utf-8", {"X-More": "yes"})
    files.close("/assets/")
    return files


def ask(files, path, method="GET", **headers):
    """The answer to a request: status, headers, body."""
    sent = []

    async def send(message):
        sent.append(message)

    scope = {
        "type": "http",
        "method": method,
        "path": path,
        "headers": [(name.lower().replace("_", "-").encode(), value.encode()) for name, value in headers.items()],
    }
    asyncio.run(Serving(PlainTextResponse(OTHER), files)(scope, None, send))
    answered = {name.decode(): value.decode() for name, value in sent[0]["headers"]}
    return sent[0]["status"], answered, b"".join(part.get("body", b"") for part in sent[1:])


@pytest.mark.parametrize(
    ("path", "name"), [("/", "/"), ("own", "/static/{file}"), ("/assets/x.js", "none"), ("/elsewhere", "none")]
)
def test_a_file_is_counted_by_what_kind_it_is(files, path, name):
    scope = {"type": "http", "method": "GET", "path": path if path != "own" else f"{files.folder}script.js"}
    found = scope | {"headers": []}
    asyncio.run(files.answer(found))
    assert template(found) == name


DECODED = {"br": brotli.decompress, "gzip": gzip.decompress, "identity": bytes}


@pytest.mark.parametrize("coding", [*COMPRESSED, "identity"])
def test_a_published_file_is_whole_in_every_coding_and_kept_for_ever(files, coding):
    status, headers, body = ask(files, f"{files.folder}script.js", accept_encoding=coding)
    assert status == 200
    assert headers.get("content-encoding", "identity") == coding
    assert DECODED[coding](body) == SCRIPT
    assert int(headers["content-length"]) == len(body)
    assert (len(body) < len(SCRIPT) / 10) == (coding != "identity")
    assert headers["cache-control"] == IMMUTABLE
    assert headers["content-type"] == "text/javascript; charset=utf-8"
    assert headers["vary"] == "Accept-Encoding"


def test_another_content_has_another_address(files, tmp_path):
    (tmp_path / "script.js").write_bytes(SCRIPT + b"// changed")
    folder = Files().publish("own", {"script.js": tmp_path / "script.js"})
    assert folder != files.folder
    (tmp_path / "script.js").write_bytes(SCRIPT)
    assert Files().publish("own", {"script.js": tmp_path / "script.js"}) == files.folder


def test_the_same_contents_under_other_names_are_another_folder(tmp_path):
    (tmp_path / "a").write_bytes(b"x")
    assert Files().publish("own", {"a": tmp_path / "a"}) != Files().publish("own", {"b": tmp_path / "a"})


@pytest.mark.parametrize("coding", [*COMPRESSED, "identity"])
def test_what_a_browser_has_is_not_sent_again(files, coding):
    _, headers, body = ask(files, "/", accept_encoding=coding)
    assert (headers["cache-control"], headers["x-more"], body != b"") == (ASK, "yes", True)
    tag = headers["etag"]
    for said in (tag, f"W/{tag}", f'"another", {tag}', "*"):
        status, again, body = ask(files, "/", accept_encoding=coding, if_none_match=said)
        assert (status, body) == (304, b""), said
        assert {name: again[name] for name in ("etag", "cache-control", "vary")} == {
            name: headers[name] for name in ("etag", "cache-control", "vary")
        }
    for said in ('"another"', tag.strip('"'), ""):
        assert ask(files, "/", accept_encoding=coding, if_none_match=said)[0] == 200, said


def test_every_coding_has_a_tag_of_its_own(files):
    tags = {ask(files, "/", accept_encoding=coding)[1]["etag"] for coding in (*COMPRESSED, "identity")}
    assert len(tags) == 3


def test_a_part_that_is_asked_for_is_the_whole(files):
    status, headers, body = ask(files, "/", range="bytes=0-3", accept_encoding="identity")
    assert (status, headers["accept-ranges"]) == (200, "none")
    assert body.startswith(b"<!doctype html>")


def test_head_says_what_get_does(files):
    get, head = (ask(files, "/", method, accept_encoding="br") for method in ("GET", "HEAD"))
    assert head[:2] == get[:2]


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_files_are_read_and_nothing_else(files, method):
    status, headers, _ = ask(files, "/", method)
    assert (status, headers["allow"]) == (405, "GET, HEAD")


NOT_THERE = [
    "/static/", "/static/x", "{folder}", "{folder}other.js", "{folder}../own/script.js", "{folder}script.js/",
    "{folder}..//script.js", "/static/../static/x", "{folder}./script.js", "{folder}script.js\0", "{folder}SCRIPT.JS",
    "/assets/", "/assets/../../etc/passwd", "/assets/%2e%2e/x", "/assets/\\..\\x",
]  # fmt: skip


@pytest.mark.parametrize("path", NOT_THERE)
def test_what_is_not_in_the_table_is_not_there(files, path):
    status, headers, body = ask(files, path.format(folder=files.folder))
    assert status == 404
    assert headers["content-type"] == "application/json"
    assert b'"field":"address"' in body


@pytest.mark.parametrize("path", ["/other", "/asset", "", "/statics", "//"])
def test_everything_else_is_answered_by_others(files, path):
    assert ask(files, path)[2] == OTHER.encode()


@given(st.text(max_size=40))
def test_no_address_reaches_a_file_that_was_not_added(path):
    files = Files()
    files.add("/", b"the page")
    status, _, body = ask(files, path)
    assert status in (200, 404)
    assert body == OTHER.encode() or path == "/" or path.startswith("/static/")


def test_a_file_is_compressed_once_and_kept_for_the_next_server(files, kept, monkeypatch):
    digest = hashlib.sha256(SCRIPT).hexdigest()[:32]
    _, _, body = ask(files, f"{files.folder}script.js", accept_encoding="br")
    assert (kept / f"{digest}.br").read_bytes() == body
    assert [path.name for path in kept.iterdir()] == [f"{digest}.br"]
    monkeypatch.setattr("server.files.write", lambda *_: pytest.fail("it is there"))
    assert ask(files, f"{files.folder}script.js", accept_encoding="br")[2] == body
    later = Files(kept)
    later.add("/script.js", SCRIPT)
    assert ask(later, "/script.js", accept_encoding="br")[2] == body


@pytest.mark.parametrize("coding", [*COMPRESSED, "identity"])
def test_all_who_are_sent_a_file_share_its_bytes(files, coding):
    async def crowd():
        file = files.at(f"{files.folder}script.js")
        return [await files._body(file, coding) for _ in range(3)]

    first, *others = asyncio.run(crowd())
    assert all(other is first for other in others)


def test_many_who_ask_at_once_wait_for_one(files, monkeypatch):
    made = []
    monkeypatch.setattr("server.files.write", lambda data, *_: made.append(data) or b"small")

    async def crowd():
        file = files.at(f"{files.folder}script.js")
        return await asyncio.gather(*(files._body(file, "br") for _ in range(50)))

    assert asyncio.run(crowd()) == [b"small"] * 50
    assert len(made) == 1


def test_without_a_folder_that_can_be_written_they_are_kept_in_memory(tmp_path):
    (tmp_path / "file").touch()
    for kept in (None, tmp_path / "file" / "kept"):
        files = Files(kept)
        files.add("/script.js", SCRIPT)
        assert brotli.decompress(ask(files, "/script.js", accept_encoding="br")[2]) == SCRIPT
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_what_is_prepared_is_what_is_served(files, kept):
    size = files.prepare(kept)
    assert size == sum(path.stat().st_size for path in kept.iterdir())
    # Every content in every coding: the script and the page.
    assert len(list(kept.iterdir())) == 2 * len(COMPRESSED)
    for coding in COMPRESSED:
        body = ask(files, f"{files.folder}script.js", accept_encoding=coding)[2]
        assert body == write(SCRIPT, coding, "best")
    assert files.prepare(kept) == size


PREFERRED = {
    "": "identity",
    "br": "br",
    "gzip, deflate, br, zstd": "br",
    "GZIP;Q=1, BR;Q=0.1": "br",
    "gzip": "gzip",
    "gzip;q=0.5, br;q=0": "gzip",
    "gzip; q=0 , identity": "identity",
    "*": "br",
    "*;q=0": "identity",
    "br;q=0, *": "gzip",
    "deflate": "identity",
    "br;q=much": "identity",
    "br;q=": "identity",
    "brr, xgzip": "identity",
    ";;;,,,=": "identity",
}


@pytest.mark.parametrize(("accepted", "coding"), PREFERRED.items())
def test_the_coding_is_one_that_the_client_reads(accepted, coding):
    assert preferred(accepted) == coding


@given(st.binary(max_size=5_000), st.sampled_from(COMPRESSED), st.sampled_from(["quick", "thorough", "best"]))
def test_what_is_written_can_be_read_and_is_always_the_same(data, coding, effort):
    written = write(data, coding, effort)
    assert DECODED[coding](written) == data
    assert write(data, coding, effort) == written
