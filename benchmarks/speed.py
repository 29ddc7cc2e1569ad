"""The core against C and against other packages: five workloads, first that all agree, then how long they take.

C and Python take turns, call by call, so that a busy machine is busy for both. What a peer would need minutes for is
measured on a stated part of the work and scaled.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import solve_discrete_are

from benchmarks import c_code, peers
from tracker_core import Experiment, Gains, Measurements, Truth, run_filter
from tracker_core.adaptive import METHODS
from tracker_core.adaptive.sample_search import candidates
from tracker_core.batch import KINDS, Runs, errors_of_runs
from tracker_core.motion import transition
from tracker_core.optimal import process_input
from tracker_core.run import known_state, observe, observe_runs
from tracker_core.types import FloatArray

AGREED = 1e-9
FIGURES = ("total", "rmse", "max", "l2")
Work = Callable[[], Any]


@dataclass(frozen=True, slots=True)
class Peer:
    """Another way to do the same.

    Attributes:
        name: of the package, and how it is used.
        work: a part of the workload.
        share: which part.
        bound: how many times slower it must be at least.
        agree: what it and we find on something small, beside each other.
        ours: as much as it does; None where that is the workload.
    """

    name: str
    work: Work
    share: float
    bound: float
    agree: Callable[[], tuple[FloatArray, FloatArray]]
    ours: Work | None = None


@dataclass(frozen=True, slots=True)
class Workload:
    """One row of the table.

    Attributes:
        name: what is done.
        ours, c: do it.
        bound: how many times slower than C it may be at most.
        agree: what C and we find, beside each other.
        peers: others.
        rounds: how often ours and C's take turns.
        halves, c_halves: the work in two parts, for two threads.
    """

    name: str
    ours: Work
    c: Work
    bound: float
    agree: Callable[[], tuple[FloatArray, FloatArray]]
    peers: tuple[Peer, ...] = ()
    rounds: int = 15
    halves: tuple[Work, ...] = ()
    c_halves: tuple[Work, ...] = ()


def workloads() -> list[Workload]:
    """W1 to W5."""
    return [one_track(), long_track(), gain_map(), monte_carlo(), sample_search()]


def one_track() -> Workload:
    """W1: 1,000 samples of two axes, order 4, all states."""
    experiment = Experiment.from_dict({"order": 4, "xi": 0.74})
    measurements = observe(experiment)[1]
    z, t = np.ascontiguousarray(measurements.positions), experiment.interval
    gains = experiment.gains()
    third = Gains.normalised((0.6, 0.2, 0.05))
    return Workload(
        "W1 one track, 1,000 x 2, order 4, all states",
        lambda: run_filter(measurements, gains),
        lambda: c_code.track(z, t, gains.vector),
        2.0,
        lambda: (_states(measurements, gains), _stacked(c_code.track(z, t, gains.vector, keep=True))),
        (Peer("FilterPy GHKFilter (order 3)", lambda: peers.ghk_track(z, t, third.vector), 1.0, 50,
              lambda: (run_filter(measurements, third).smoothed[:, :, 0], peers.ghk_track(z, t, third.vector))),),
        rounds=200,
    )  # fmt: skip


def long_track() -> Workload:
    """W2: a million samples of one axis, order 3."""
    n, gains, t = 1_000_000, Gains.normalised((0.6, 0.2, 0.05)), 1.0
    z = np.cumsum(np.random.default_rng(1).standard_normal(n))[:, None]
    measurements = Measurements(np.arange(n) * t, z, t)
    part = Measurements(measurements.times[:50_000], z[:50_000], t)
    return Workload(
        "W2 one track, 1,000,000 x 1, order 3, all states",
        lambda: run_filter(measurements, gains),
        lambda: c_code.track(z, t, gains.vector),
        1.5,
        lambda: (_states(measurements, gains), _stacked(c_code.track(z, t, gains.vector, keep=True))),
        (Peer("FilterPy GHKFilter, 1/20 of it", lambda: peers.ghk_track(z[:50_000], t, gains.vector), 1 / 20, 80,
              lambda: (run_filter(part, gains).smoothed[:, :, 0], peers.ghk_track(z[:50_000], t, gains.vector))),),
    )  # fmt: skip


def gain_map() -> Workload:
    """W3: RMSE of 100 x 100 alpha-beta filters over 1,000 samples of two axes."""
    experiment = Experiment.from_dict({"order": 2, "xi": 0.6})
    truth, measurements, _ = observe(experiment)
    z, true = (np.ascontiguousarray(x) for x in (measurements.positions, truth.positions))
    t, alpha, beta = experiment.interval, np.linspace(0.05, 0.95, 100), np.linspace(0.02, 1.0, 100)
    gains = np.stack(np.meshgrid(alpha, beta), axis=-1).reshape(-1, 2)
    runs, few = Runs(z[None], true[None], t), gains[::500]

    def ours(sets: FloatArray = gains) -> FloatArray:
        return errors_of_runs(runs, sets, figures=("rmse",), kinds=("estimation",))["estimation"].rmse[:, 0]

    return Workload(
        "W3 map 100 x 100, 1,000 x 2, RMSE",
        ours,
        lambda: c_code.map_rmse(z, true, t, gains),
        1.5,
        lambda: (ours(), c_code.map_rmse(z, true, t, gains)),
        (
            Peer("FilterPy GHFilter, 1/500 of it", lambda: peers.gh_rmse(z, true, t, few), 1 / 500, 3_000,
                 lambda: (ours(few), peers.gh_rmse(z, true, t, few))),
            Peer("FilterPy GHFilter on arrays", lambda: peers.gh_arrays_rmse(z, true, t, gains), 1.0, 15,
                 lambda: (ours(), peers.gh_arrays_rmse(z, true, t, gains))),
        ),
        halves=(lambda: ours(gains[:5_000]), lambda: ours(gains[5_000:])),
        c_halves=(
            lambda: c_code.map_rmse(z, true, t, gains[:5_000]),
            lambda: c_code.map_rmse(z, true, t, gains[5_000:]),
        ),
    )  # fmt: skip


def monte_carlo() -> Workload:
    """W4: all figures of five filters in 1,000 runs of 1,000 samples of two axes, whose noise is drawn before."""
    experiment = Experiment.from_dict({"order": 4, "xi": 0.7, "interval": 1.0, "start": "known"})
    drawn, known = observe_runs(experiment, range(1, 1_001)), known_state(experiment)
    assert known is not None
    assert drawn.truth is not None
    state = np.ascontiguousarray(known)
    z, true = np.ascontiguousarray(drawn.positions), np.ascontiguousarray(drawn.truth[0])
    models = [_model(order, index) for order, index in ((2, 0.1), (2, 0.5), (3, 0.05), (3, 0.3), (4, 0.1))]
    gains = [prediction[:, 0] / (prediction[0, 0] + 1) for _, prediction in models]

    def ours(runs: Runs = drawn) -> dict[str, Any]:
        return errors_of_runs(runs, gains, start="known", initial_state=state)

    def rmse(runs: Runs = drawn) -> FloatArray:
        found = errors_of_runs(
            runs, gains, start="known", initial_state=state, figures=("rmse",), kinds=("estimation",)
        )
        return found["estimation"].rmse

    def all_figures() -> FloatArray:
        found = ours()
        return np.stack([np.stack([found[k].figures[f] for f in FIGURES], axis=-1) for k in KINDS], axis=2)

    def kalman() -> FloatArray:
        return peers.kalman_rmse(z, true, 1.0, models, state)

    few = slice(0, 100)
    return Workload(
        "W4 Monte Carlo 1,000 runs, 1,000 x 2, five filters, all figures",
        ours,
        lambda: c_code.monte_carlo(z, true, 1.0, gains, state),
        2.5,
        lambda: (all_figures(), c_code.monte_carlo(z, true, 1.0, gains, state)),
        (Peer("simdkalman, against RMSE alone", kalman, 1.0, 500,
              lambda: (rmse(replace(drawn, positions=z[few])), peers.kalman_rmse(z[few], true, 1.0, models, state)),
              ours=rmse),),
        halves=(
            lambda: ours(replace(drawn, positions=z[:500])),
            lambda: ours(replace(drawn, positions=z[500:])),
        ),
        c_halves=(
            lambda: c_code.monte_carlo(z[:500], true, 1.0, gains, state),
            lambda: c_code.monte_carlo(z[500:], true, 1.0, gains, state),
        ),
    )  # fmt: skip


def _model(order: int, index: float) -> tuple[FloatArray, FloatArray]:
    """Covariances of the process noise and of the steady prediction at T = 1, for a unit of measurement noise."""
    drive = index * process_input(order)
    process = np.outer(drive, drive)
    return process, solve_discrete_are(transition(order, 1.0).T, np.eye(1, order).T, process, np.eye(1))


def sample_search() -> Workload:
    """W5: Yu & Wu's search at every sample, 8,000 samples of two axes, all 384 sets."""
    experiment = Experiment.from_dict({"scenario": "yu-wu", "interval": 0.0125, "samples": 8_000, "noise_std": 10.0})
    truth, measurements, _ = observe(experiment)
    (sets, _), (tame, _) = (candidates(4, 4, 6, "interior", bound) for bound in ("printed", "exact"))
    search, which, t = METHODS["sample-search"], 2, experiment.interval
    z, wanted = (np.ascontiguousarray(x) for x in (measurements.positions, truth.states[:, :, which]))

    def ours(n: int = 8_000, bound: str = "printed") -> Any:
        seen = Measurements(measurements.times[:n], measurements.positions[:n], t)
        known = Truth(truth.times[:n], truth.states[:n])
        return search.run(seen, 4, truth=known, bound=bound, limit=1e300)

    def positions(n: int, bound: str) -> FloatArray:
        return ours(n, bound).track.smoothed[2:, :, 0]

    # With the sets that are unstable the states soon pass all bounds, and rounding decides: few samples are compared.
    return Workload(
        f"W5 search at every sample, 8,000 x 2, {len(sets)} sets",
        ours,
        lambda: c_code.sample_search(z, wanted, t, sets, which),
        3.0,
        lambda: (positions(8_000, "exact"), c_code.sample_search(z, wanted, t, tame, which)[1][:, 2:, 0].T),
        (
            Peer(
                "plain Python, 1/40 of it",
                lambda: plain_search(z[:200], wanted[:200], t, sets),
                1 / 40,
                100,
                lambda: (positions(200, "exact"), plain_search(z[:200], wanted[:200], t, tame)),
            ),
        ),
    )


def plain_search(positions: FloatArray, accelerations: FloatArray, t: float, sets: FloatArray) -> FloatArray:
    """The search at every sample as one would write it down: least error of the acceleration, order 4."""
    rows, found = sets.tolist(), []
    for axis in range(positions.shape[1]):
        z, wanted = positions[:, axis].tolist(), accelerations[:, axis].tolist()
        x, v, a, j = z[1], (z[1] - z[0]) / t, 0.0, 0.0
        smoothed = []
        for i in range(2, len(z)):
            x, v, a = x + t * v + t * t / 2 * a + t**3 / 6 * j, v + t * a + t * t / 2 * j, a + t * j
            e = z[i] - x
            g0, g1, g2, g3 = min(rows, key=lambda g: abs(a + g[2] * (e / t / t) - wanted[i]))
            x, v, a, j = x + g0 * e, v + g1 * e / t, a + g2 * e / t / t, j + g3 * e / t / t / t
            smoothed.append(x)
        found.append(smoothed)
    return np.array(found).T


def _states(measurements: Measurements, gains: Gains) -> FloatArray:
    found = run_filter(measurements, gains)
    return _stacked((found.predicted, found.smoothed, found.innovation))


def _stacked(parts: tuple[FloatArray, ...]) -> FloatArray:
    return np.concatenate([np.ravel(part) for part in parts])


def differ(pair: tuple[FloatArray, FloatArray]) -> float:
    """The greatest difference relative to the greatest number; infinite where one has a number and the other none."""
    ours, theirs = pair
    if ours.shape != theirs.shape or not np.array_equal(np.isnan(ours), np.isnan(theirs)):
        return np.inf
    return float(np.nanmax(np.abs(ours - theirs)) / np.nanmax(np.abs(theirs)))


def check(rows: list[Workload]) -> None:
    """Print how far ours is from C and from the peers; end where it is too far."""
    print(f"\n{'greatest relative difference, at most ' + format(AGREED, 'g'):<72}")
    for one in rows:
        for name, pair in [("C", one.agree), *((peer.name, peer.agree) for peer in one.peers)]:
            far = differ(pair())
            print(f"{one.name[:2]}  {name:<60} {far:8.1e}")
            if not far <= AGREED:
                raise SystemExit(f"{one.name}: ours and {name} do not agree")


def timed(work: Work) -> float:
    """Seconds of one call."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def in_turns(one: Work, other: Work, rounds: int) -> tuple[float, float, float]:
    """Median seconds of both, and the median of their ratios, call by call."""
    one(), other()
    pairs = [(timed(one), timed(other)) for _ in range(rounds)]
    first, second = zip(*pairs, strict=True)
    return statistics.median(first), statistics.median(second), statistics.median(a / b for a, b in pairs)


def measure_speed() -> None:
    """Agreement, then the times."""
    rows = workloads()
    check(rows)
    print(f"\n{c_code.compiler()}, {' '.join(c_code.FLAGS[:2])}; one thread")
    print(f"{'':<64} {'ours ms':>9} {'C ms':>9} {'ratio':>7}  bound")
    threads: list[str] = []
    for one in rows:
        ours, c, ratio = in_turns(one.ours, one.c, one.rounds)
        print(f"{one.name:<64} {ours * 1e3:9.3f} {c * 1e3:9.3f} {ratio:7.2f}  {_kept(ratio <= one.bound, one.bound)}")
        for peer in one.peers:
            took = min(timed(peer.work) for _ in range(2)) / peer.share
            times = took / (ours if peer.ours is None else statistics.median(timed(peer.ours) for _ in range(9)))
            line = f"{took * 1e3:9,.0f} {'':>9} {times:7,.0f}  "
            print(f"{'   ' + peer.name:<64} {line}{_kept(times >= peer.bound, peer.bound, 'at least')}")
        if one.halves:
            threads.append(two_threads(one))
    print("\n" + "\n".join(threads))


def two_threads(one: Workload) -> str:
    """How much faster two threads do the two halves than one thread both, in Python and in C on the same machine."""
    ours, c = (_gain_of_threads(halves, one.rounds) for halves in (one.halves, one.c_halves))
    said = f"{one.name[:2]}  two threads against one: {ours:.2f} times as fast, {_kept(ours >= 1.6, 1.6, 'at least')}"
    return f"{said}; C on this machine {c:.2f}"


def _gain_of_threads(halves: tuple[Work, ...], rounds: int) -> float:
    with ThreadPoolExecutor(2) as pool:

        def both() -> None:
            for future in [pool.submit(half) for half in halves]:
                future.result()

        def alone() -> None:
            for half in halves:
                half()

        return in_turns(alone, both, rounds)[2]


def _kept(kept: bool, bound: float, kind: str = "at most") -> str:
    return f"{kind} {bound:,g}{'' if kept else ': MISSED'}"
