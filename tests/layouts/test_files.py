"""The store of recordings: whole or not there, whatever happens; within its size and age; shared by several servers."""

import io
import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from layouts import files
from layouts.files import (
    COUNTED,
    HOUR,
    LEFT_OVER,
    PART,
    RECENT,
    SUFFIX,
    SUM,
    TOUCHED,
    UNIT,
    NoRoomError,
    Store,
    counted,
)
from layouts.incoming import MEGABYTE, Incoming
from tracker_core.checks import InputError
from tracker_core.measured import File, content_name

ROOT = Path(__file__).parents[2]
WAIT = 20
TEXT = b"t,x,y\n" + b"".join(b"%d,%d,%d\n" % (row, 3 * row, row * row) for row in range(50))


@pytest.fixture
def make(tmp_path):
    """A store in a folder of its own."""

    def store(most_bytes=10 * MEGABYTE, days=90, directory=tmp_path / "kept"):
        return Store(directory, most_bytes=most_bytes, longest_age_days=days)

    return store


def keep(store, content=TEXT, name="log.csv", most=MEGABYTE, chunk=7):
    with store.receive(name, most) as incoming:
        for start in range(0, len(content), chunk):
            incoming.write(content[start : start + chunk])
        return store.keep(incoming)


def entries(store):
    """What is in the folder beside the sum of it."""
    return sorted(path.name for path in store.directory.iterdir() if path.name != SUM)


def units(letter, number=1):
    """A content that is counted as so many units."""
    return letter * (number * UNIT - 100)


def age(store, data, seconds):
    """As if it had been used so long ago."""
    used = time.time() - seconds
    os.utime(store.directory / f"{data}{SUFFIX}", (used, used))


# In and out ----------------------------------------------------------------------------------------------------------


def test_a_file_is_found_again_by_what_it_holds_after_a_restart_too(make):
    store = make()
    assert store.problem == ""
    kept = keep(store, name="C:\\logs\\landing <b>1</b>\n.csv")
    # Of a path the last part, wherever it came from.
    assert kept == File("b> .csv", TEXT)
    assert kept.data == content_name(TEXT)
    for reader in (store, make()):
        assert reader.fetch(kept.data) == kept
    assert entries(store) == [f"{kept.data}{SUFFIX}"]


@pytest.mark.parametrize("content", [b"\n", b"\n\n{}\n", b'{"name": 1}\n', bytes(range(256)) * 40, b"x"])
def test_any_bytes_come_back_as_they_went_in(make, content):
    store = make()
    assert store.fetch(keep(store, content).data).content == content


@pytest.mark.parametrize("data", ["0" * 32, "", "..", "../" * 10, "A" * 32, "0" * 31, "0" * 32 + "\n", "é" * 32])
def test_what_is_not_there_is_none(make, data):
    assert make().fetch(data) is None


def test_the_first_name_of_a_content_stays(make):
    store = make()
    keep(store, name="first.csv")
    assert keep(store, name="second.csv").name == "first.csv"
    assert len(entries(store)) == 1


def test_what_was_not_kept_leaves_nothing(make):
    store = make()
    with store.receive("log.csv", MEGABYTE) as incoming:
        incoming.write(TEXT)
        assert entries(store) != []
        assert incoming.content() == TEXT
    assert entries(store) == []
    with pytest.raises(ZeroDivisionError), store.receive("log.csv", MEGABYTE) as incoming:
        incoming.write(b"1" * (1 // 0))
    assert entries(store) == []


def test_too_much_is_refused_before_it_is_written(make):
    store = make()
    with store.receive("log.csv", 100) as incoming:
        incoming.write(b"x" * 100)
        with pytest.raises(InputError, match=r"file must have at most 0\.0001 MB"):
            incoming.write(b"y")
        assert incoming.content() == b"x" * 100
    with store.receive("log.csv", 0) as incoming:
        assert incoming.data == content_name(b"")


def test_a_name_in_memory_is_the_one_on_disk():
    stream = io.BytesIO()
    incoming = Incoming(stream, 1000, b"head\n")
    incoming.write(TEXT[:10])
    incoming.write(TEXT[10:])
    assert (incoming.data, incoming.content(), incoming.size) == (content_name(TEXT), TEXT, len(TEXT))


# Broken ones ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "broken",
    [
        b"",
        b'{"name": "log.csv"}\n' + TEXT[:-1],
        b'{"name": "log.csv"}\n' + TEXT.replace(b"3", b"4", 1),
        b'{"name": 7}\n' + TEXT,
        b'{"name": "a\\nb"}\n' + TEXT,
        b'{"other": "log.csv"}\n' + TEXT,
        b"[" * 100_000 + b"\n" + TEXT,
        b"log.csv\n" + TEXT,
        TEXT,
    ],
)
def test_a_broken_one_is_missing_and_goes(make, broken):
    store = make()
    data = keep(store).data
    (store.directory / f"{data}{SUFFIX}").write_bytes(broken)
    assert store.fetch(data) is None
    assert entries(store) == []
    # Loading the same file again mends it.
    assert keep(store).data == data
    assert store.fetch(data).content == TEXT


def test_what_somebody_else_has_put_there_meanwhile_stays(make, monkeypatch):
    store, other = make(), make()
    data = keep(store).data
    (store.directory / f"{data}{SUFFIX}").write_bytes(b'{"name": "log.csv"}\nbroken')

    def slow(content):
        monkeypatch.undo()
        keep(other)
        return content_name(content)

    monkeypatch.setattr(files, "content_name", slow)
    assert store.fetch(data) is None
    assert store.fetch(data).content == TEXT


# A kill in the middle ------------------------------------------------------------------------------------------------

WRITER = """
import sys
from pathlib import Path
from layouts.files import Store
store = Store(Path(sys.argv[1]), most_bytes=10**9, longest_age_days=90)
number = 0
while True:
    content = (b"t,x,y\\n" + b"%d,1,2\\n" % number) * 20_000
    with store.receive(f"log {number}.csv", 10**7) as incoming:
        for start in range(0, len(content), 4096):
            incoming.write(content[start : start + 4096])
        kept = store.keep(incoming)
    print(kept.data, flush=True)
    number += 1
"""


def test_a_kill_in_the_middle_leaves_whole_files_and_parts_that_go(make):
    store = make()
    parts = 0
    for attempt in range(4):
        with subprocess.Popen(
            [sys.executable, "-c", WRITER, str(store.directory)], cwd=ROOT, stdout=subprocess.PIPE, text=True
        ) as writer:
            said = [writer.stdout.readline().strip() for _ in range(2)]
            time.sleep(0.003 * attempt)
            writer.send_signal(signal.SIGKILL)
            said += writer.stdout.read().split()
        # What was acknowledged is there, what is there is whole.
        for data in said:
            assert store.fetch(data) is not None, data
        for path in store.directory.glob(f"*{SUFFIX}"):
            assert store.fetch(path.stem) is not None
        parts += len(list(store.directory.glob(f"*{PART}")))
    for path in store.directory.glob(f"*{PART}"):
        # Another server may still be writing: they go after an hour alone.
        make()
        assert path.exists()
        os.utime(path, (0, time.time() - LEFT_OVER - 1))
    (store.directory / f"left{PART}").touch()
    os.utime(store.directory / f"left{PART}", (0, time.time() - LEFT_OVER - 1))
    make()
    assert list(store.directory.glob(f"*{PART}")) == []


# Size and age --------------------------------------------------------------------------------------------------------


def test_the_longest_unused_make_room(make):
    store = make(most_bytes=5 * UNIT)
    first, second = (keep(store, units(letter, 2), chunk=UNIT).data for letter in (b"a", b"b"))
    age(store, first, 3 * HOUR)
    age(store, second, 5 * HOUR)
    third = keep(store, units(b"c", 2), chunk=UNIT).data
    assert store.fetch(second) is None
    assert [store.fetch(data) is not None for data in (first, third)] == [True, True]


def test_nothing_goes_that_is_in_use_nor_in_vain(make):
    store = make(most_bytes=2 * UNIT)
    old, new = (keep(store, letter * 400).data for letter in (b"a", b"b"))
    age(store, old, 5 * HOUR)
    # Even without the old one there is no room for so much.
    with pytest.raises(NoRoomError, match="this server keeps 0.131072 MB"):
        keep(store, units(b"c", 2), chunk=UNIT)
    assert entries(store) == sorted(f"{data}{SUFFIX}" for data in (old, new))
    # Its use is noted, and it stays.
    assert store.fetch(old) is not None
    with pytest.raises(NoRoomError):
        keep(store, b"c" * 400)
    age(store, old, RECENT + TOUCHED - 60)
    with pytest.raises(NoRoomError):
        keep(store, b"c" * 400)
    age(store, old, RECENT + TOUCHED + 60)
    keep(store, b"c" * 400)
    assert store.fetch(old) is None


@pytest.mark.parametrize(("size", "units"), [(0, 0), (1, 1), (UNIT, 1), (UNIT + 1, 2)])
def test_small_files_take_more_room_than_they_have_bytes(size, units):
    assert counted(size) == units * UNIT


def test_however_small_they_are_there_are_not_more_than_fit(make):
    store = make(most_bytes=3 * UNIT)
    for letter in (b"a", b"b", b"c"):
        keep(store, letter)
    assert store.size == 3 * UNIT
    with pytest.raises(NoRoomError):
        keep(store, b"d")


def test_servers_that_share_a_folder_share_its_size(make):
    here, there = (make(most_bytes=3 * UNIT) for _ in range(2))
    keep(here, b"a")
    keep(here, b"b")
    keep(there, b"c")
    assert there.size == 3 * UNIT
    for store in (here, there):
        with pytest.raises(NoRoomError):
            keep(store, b"d")


def test_what_fits_is_kept_without_a_look_at_all_that_is_there(make, monkeypatch):
    store = make()
    keep(store, b"a")
    monkeypatch.setattr(Store, "_count", lambda *_: pytest.fail("it has been counted"))
    # What is there already takes nothing.
    for letter in (b"b", b"c", b"b"):
        keep(store, letter)
    assert store.size == 3 * UNIT


def old_sum(store, text=None):
    """As if the sets had been counted long ago, or by somebody who left nonsense."""
    path = store.directory / SUM
    said = json.loads(path.read_text())
    path.write_text(json.dumps(said | {"at": time.time() - COUNTED - 1}) if text is None else text)


@pytest.mark.parametrize("text", [None, "", "nonsense", "[]", '{"size": "much", "at": 1}', "[" * 90])
def test_a_sum_that_is_old_or_none_is_made_anew(make, text):
    store = make(most_bytes=3 * UNIT)
    data = keep(store, b"a").data
    keep(store, b"b")
    # Somebody has made room by hand, and copied a set from elsewhere.
    for path in store.directory.glob(f"*{SUFFIX}"):
        path.unlink()
    (store.directory / f"{data}{SUFFIX}").write_bytes(b'{"name": "log.csv"}\na')
    store.look()
    assert store.size == 2 * UNIT
    old_sum(store, text)
    store.look()
    assert store.size == UNIT
    old_sum(store, text)
    keep(store, b"c")
    assert store.size == 2 * UNIT


def test_what_is_broken_or_too_old_is_not_counted_any_more(make):
    store = make(days=2)
    broken, old = keep(store, b"a").data, keep(store, b"b").data
    (store.directory / f"{broken}{SUFFIX}").write_bytes(b"broken")
    assert store.fetch(broken) is None
    assert store.size == UNIT
    age(store, old, 49 * HOUR)
    old_sum(store)
    store.look()
    assert (store.size, entries(store)) == (0, [])


def test_a_use_is_noted_once_in_a_while(make):
    store = make()
    data = keep(store).data
    path = store.directory / f"{data}{SUFFIX}"
    age(store, data, TOUCHED - 60)
    before = path.stat().st_mtime
    store.fetch(data)
    assert path.stat().st_mtime == before
    age(store, data, TOUCHED + 60)
    store.fetch(data)
    assert path.stat().st_mtime == pytest.approx(time.time(), abs=30)


def test_what_nobody_has_used_for_long_goes(make):
    store = make(days=2)
    old, new = (keep(store, letter * 40).data for letter in (b"a", b"b"))
    age(store, old, 49 * HOUR)
    age(store, new, 47 * HOUR)
    make(days=2)
    assert [store.fetch(data) is not None for data in (old, new)] == [False, True]
    age(store, new, 49 * HOUR)
    old_sum(store)
    keep(store, b"c" * 40)
    assert store.fetch(new) is None


# A folder that is none -----------------------------------------------------------------------------------------------


def test_a_folder_that_cannot_be_written_to_is_a_problem_and_no_crash(make, tmp_path):
    (tmp_path / "file").write_text("in the way")
    store = make(directory=tmp_path / "file" / "below")
    assert store.problem == "Not a directory"
    assert store.fetch("0" * 32) is None


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() == 0, reason="nothing is forbidden to root")
def test_a_folder_that_is_read_only_is_a_problem(make, tmp_path):
    (tmp_path / "closed").mkdir(mode=0o500)
    assert make(directory=tmp_path / "closed").problem == "Permission denied"


# Several at once -----------------------------------------------------------------------------------------------------


def test_what_is_acknowledged_does_not_go_meanwhile(make, monkeypatch):
    """One server makes room while another one is sent the very file that goes."""
    here, there = (make(most_bytes=2 * UNIT) for _ in range(2))
    old, new = (keep(here, content).data for content in (b"old", b"new"))
    age(here, old, 5 * HOUR)
    age(here, new, 4 * HOUR)
    acknowledged = []
    again = threading.Thread(target=lambda: acknowledged.append(keep(there, b"old").data))
    make_go = Store._make_go

    def slowly(store, each, sum_):
        monkeypatch.undo()
        again.start()
        again.join(0.1)
        # Nobody has said yet that it is there.
        assert acknowledged == []
        make_go(store, each, sum_)

    monkeypatch.setattr(Store, "_make_go", slowly)
    third = keep(here, b"third").data
    again.join(WAIT)
    # It was put there again, and the next one has gone.
    assert acknowledged == [old]
    assert [here.fetch(data) is not None for data in (old, new, third)] == [True, False, True]


def test_what_a_server_of_an_earlier_version_uses_meanwhile_stays(make, monkeypatch):
    store = make(most_bytes=2 * UNIT)
    old = keep(store, b"old").data
    keep(store, b"new")
    age(store, old, 5 * HOUR)
    make_go = Store._make_go

    def used(store, each, sum_):
        os.utime(each.path)
        make_go(store, each, sum_)

    monkeypatch.setattr(Store, "_make_go", used)
    with pytest.raises(NoRoomError):
        keep(store, b"third")
    assert store.fetch(old) is not None


LOCKED = """
import fcntl, sys, time
with open(sys.argv[1], "r+b") as stream:
    fcntl.flock(stream, fcntl.LOCK_EX)
    print("locked", flush=True)
    time.sleep(60)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such lock")
def test_whoever_is_killed_lets_go_of_the_folder(make):
    store = make()
    with subprocess.Popen(
        [sys.executable, "-c", LOCKED, str(store.directory / SUM)], stdout=subprocess.PIPE, text=True
    ) as holder:
        assert holder.stdout.readline() == "locked\n"
        with ThreadPoolExecutor(1) as pool:
            keeping = pool.submit(keep, store)
            with pytest.raises(TimeoutError):
                keeping.result(0.05)
            holder.kill()
            assert keeping.result(WAIT).content == TEXT


def test_many_may_write_the_same_and_others_at_once(make):
    stores = [make() for _ in range(3)]
    contents = [bytes([65 + number]) * 50_000 for number in range(5)]
    stop = threading.Event()
    wrong = []

    def read():
        while not stop.is_set():
            for content in contents:
                found = stores[0].fetch(content_name(content))
                if found is not None and found.content != content:
                    wrong.append(found)

    with ThreadPoolExecutor(8) as pool:
        reading = pool.submit(read)
        jobs = [
            pool.submit(keep, store, content, f"{number}.csv", MEGABYTE, 5000)
            for number, content in enumerate(contents * 6)
            for store in stores
        ]
        assert {job.result().data for job in jobs} == {content_name(content) for content in contents}
        stop.set()
        reading.result()
    assert wrong == []
    assert entries(stores[0]) == sorted(f"{content_name(content)}{SUFFIX}" for content in contents)
