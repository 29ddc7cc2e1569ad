"""A hundred browsers that come and go leave no scene behind, and the memory as it was after the first ten."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

ALLOCATOR = {"MALLOC_ARENA_MAX": "1", "MALLOC_MMAP_THRESHOLD_": "65536"}
"""Gives back what is freed: otherwise the holes that remain are measured, which the next browser fills."""

PROGRAM = """
import asyncio, ctypes, gc, json, secrets
import numpy as np
import app
from benchmarks.scene_browser import View, scene
from benchmarks.scenes import serving
from layouts.scenes import RegionPicture, Scenes, TrackPicture

times = np.arange(1000.0)
truth = np.stack((np.cos(times / 99), np.sin(times / 99)), axis=1) * 1e4

def memory():
    gc.collect()
    # What the allocator keeps for later is nobody's.
    getattr(ctypes.CDLL(None), "malloc_trim", int)(0)
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))

async def visit(scenes, port):
    token = secrets.token_hex(16)
    scenes.show(token, TrackPicture("run", times, truth, truth + 9, truth + 5, truth + 2, 20, True))
    async with scene(port, token) as socket:
        view = await View().until(socket, lambda view: "/smoothed" in view.nodes)
        scenes.show(token, RegionPicture((0.5, 0.3, 0.05), True))
        await view.until(socket, lambda view: "/gains" in view.nodes)

async def settled(scenes):
    while scenes.stats().sessions or scenes._server.get_clients() or scenes._server._websock_server._live_connections:
        await asyncio.sleep(0.02)
    # viser's loop has to let go of the last ones.
    await asyncio.sleep(0.5)

async def main(scenes, port):
    for _ in range(10):
        await visit(scenes, port)
    await settled(scenes)
    before = memory()
    for _ in range(100):
        await visit(scenes, port)
    await settled(scenes)
    after = memory()
    kinds = [type(thing).__name__ for thing in gc.get_objects()]
    left = {name: kinds.count(name) for name in ("TrackScene", "RegionScene", "Session", "ClientHandle")}
    print(json.dumps({"before": before, "after": after, "left": left, "sessions": scenes.stats().sessions}))

# The memory of a server is that of the whole application.
app.build()
scenes = Scenes()
with serving(scenes) as port:
    asyncio.run(main(scenes, port))
"""


def test_a_hundred_browsers_leave_nothing_behind():
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        cwd=ROOT,
        env=os.environ | ALLOCATOR,
        capture_output=True,
        encoding="utf-8",
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    outcome = json.loads(done.stdout)
    assert outcome["sessions"] == 0
    assert not any(outcome["left"].values()), outcome["left"]
    assert outcome["after"] <= 1.1 * outcome["before"], outcome
