"""How a process asks for memory, and how soon the collector looks at what has become old."""

import ctypes
import subprocess
import sys
from pathlib import Path

import pytest

from server import memory

ROOT = Path(__file__).parents[2]

PROGRAM = """
import gc
from server import memory

start = [[] for _ in range(1_000_000)]
memory.settle()
looked = gc.get_stats()[2]["collections"]
lasting = [[] for _ in range({more})]
print(gc.get_freeze_count() >= len(start), gc.get_stats()[2]["collections"] - looked)
"""

ALL_OF_IT = (memory.YOUNG + 1) * ((memory.MIDDLE + 2) * (memory.OLD + 1) + 1)
"""Lasting values after which the collector has looked at everything: it does so the next time after the last of so many
looks at less, and each of those the next time after so many at the youngest."""


@pytest.mark.parametrize(("more", "times"), [(memory.YOUNG // 2, 0), (ALL_OF_IT + memory.YOUNG, 1)])
def test_how_often_it_looks_depends_on_what_came_after_the_start(more, times):
    said = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(more=more)], cwd=ROOT, capture_output=True, check=True, text=True
    )
    assert said.stdout.split() == ["True", str(times)]


CIRCLES = """
import gc, time, weakref
from server import memory

class Circle:
    def __init__(self):
        self.own = self

memory.EVERY = 0.05
memory.settle()
memory.settle()
circle = Circle()
gc.collect(0), gc.collect(1)
seen = weakref.ref(circle)
del circle
until = time.monotonic() + 20
while seen() is not None and time.monotonic() < until:
    time.sleep(0.01)
print(seen() is None, [thread.name for thread in memory.threading.enumerate()].count("memory"))
"""


def test_it_looks_at_what_is_old_where_nothing_more_becomes_old():
    said = subprocess.run([sys.executable, "-c", CIRCLES], cwd=ROOT, capture_output=True, check=True, text=True)
    assert said.stdout.split() == ["True", "1"]


HOLES = """
import gc, sys
from server import memory

def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096 / 1e6

memory.settle()
before = resident()
# One in ten of many pieces stays, and the last of them lies above all that goes.
pieces = [bytearray(60_000) for _ in range(2_000)]
kept = pieces[9::10]
del pieces
gc.collect({generation})
print(resident() - before)
"""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "malloc_trim"), reason="this allocator cannot be told to")
@pytest.mark.parametrize(("generation", "least", "most"), [(1, 100, 130), (2, 8, 25)])
def test_after_a_full_collection_the_system_has_what_was_let_go(generation, least, most):
    """Of 120 MB a tenth stays, evenly spread."""
    program = HOLES.format(generation=generation)
    said = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, check=True, text=True)
    assert least < float(said.stdout) < most


def test_where_the_allocator_has_no_arenas_nothing_happens(monkeypatch):
    asked = []

    class Other:
        def __getattr__(self, name):
            asked.append(name)
            raise AttributeError(name)

    monkeypatch.setattr(memory.ctypes, "CDLL", lambda _: Other())
    memory.share()
    assert asked == ["mallopt"]


def test_threads_share_as_many_arenas_as_are_said(monkeypatch):
    told = []

    class Allocator:
        def mallopt(self, name, value):
            told.append((name, value))

    monkeypatch.setattr(memory.ctypes, "CDLL", lambda _: Allocator())
    memory.share()
    # M_ARENA_MAX of malloc.h.
    assert told == [(-8, memory.ARENAS)]
