"""What the lessons compute: the numbers of their texts, the choice that comes true, the addresses of their steps.

By the same functions as on the pages that the steps lead to.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from layouts.pins import pin_of
from layouts.state import Settings, View, to_query
from layouts.text import significant
from layouts.tuning import Tuning
from tracker_core import Experiment, Gains, assess, run_experiment, variance_reduction
from tracker_core.metrics import distances
from tracker_core.responses import lag_coefficient
from tracker_core.stability import is_stable
from tracker_core.statistics import mean_interval
from tracker_core.tuning.evaluate import run_errors
from tracker_core.tuning.sweeps import Sweep, SweepOutcome, usual_values
from tracker_core.types import FloatArray


@dataclass(frozen=True, slots=True)
class Facts:
    """What a lesson comes to.

    Attributes:
        right: number of the choice that comes true.
        numbers: by the names under which the texts have them.
        ways: addresses of the first look and of every step.
    """

    right: int
    numbers: dict[str, Any]
    ways: tuple[str, ...]


def _experiment(**values: Any) -> Experiment:
    return Experiment.from_dict(values)


def _way(path: str, experiment: Experiment, view: View | None = None, **pinned: Experiment) -> str:
    pins = tuple(pin_of(slot, kept).named(name) for slot, (name, kept) in enumerate(pinned.items(), 1))
    return f"{path}?{to_query(Settings(experiment, view or View(), pins))}"


def _errors(experiment: Experiment) -> FloatArray:
    """Distance of the smoothed position from the truth at every sample of a run, shape (n,), m."""
    result = run_experiment(experiment)
    return distances(result.track.smoothed[:, :, 0] - result.truth.positions)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def noise_share(experiment: Experiment) -> float:
    """Variance of the smoothed position in the steady state, per variance of the measurements."""
    return float(variance_reduction(experiment.gains(), experiment.interval).smoothed[0])


def unit_lag(experiment: Experiment) -> float:
    """Steady lag of the smoothed position of order 2 under 1 m/s², m."""
    gains = experiment.gains()
    return abs(float(lag_coefficient(gains.vector))) * experiment.interval**gains.order


# Smooth or responsive -----------------------------------------------------------------------------------------------

SHORT, LONG = 0.5, 0.75
NOISE = 50.0


def flown(xi: float) -> Experiment:
    """Legs and turns, followed by a fading memory of order 2."""
    return _experiment(scenario="coordinated-turn", noise_std=NOISE, order=2, design="fading-memory", xi=xi)


RUNS = 20


def leg_errors(experiment: Experiment) -> tuple[float, float]:
    """RMS distance of the smoothed position from the truth on straight legs and in turns, m, over RUNS seeds."""
    turning = np.abs(run_experiment(experiment).truth.states[:, :, 2]).max(axis=1) > 0
    errors = np.array([_errors(replace(experiment, seed=experiment.seed + run)) for run in range(RUNS)])
    return _rms(errors[:, ~turning]), _rms(errors[:, turning])


def memory() -> Facts:
    """Noise against lag."""
    short, long = flown(SHORT), flown(LONG)
    before, after = leg_errors(short), leg_errors(long)
    smaller = after[0] < before[0], after[1] < before[1]
    return Facts(
        right=[(True, False), (False, True), (True, True), (False, False)].index(smaller),
        numbers={
            "runs": RUNS, "short": SHORT, "long": LONG, "noise": NOISE, "straight": before[0], "turning": before[1],
            "straight_after": after[0], "turning_after": after[1], "share": noise_share(short),
            "share_after": noise_share(long), "lag": unit_lag(short), "lag_after": unit_lag(long),
        },
        ways=(
            _way("/", short), _way("/", long), _way("/tune", short),
            _way("/stability", long, View(background="lag")),
        ),
    )  # fmt: skip


# What an acceleration costs -----------------------------------------------------------------------------------------

XI = 0.8
ALIKE = 0.8, 1.25
"""Between these a distance is the same as another, as a share of it."""


def accelerated(order: int, **values: Any) -> Experiment:
    """A target of constant acceleration, followed by a fading memory."""
    return _experiment(scenario="constant-acceleration", order=order, design="fading-memory", xi=XI, **values)


def lags(experiment: Experiment) -> tuple[float, float]:
    """How far the smoothed position is from the truth halfway through a run and at its end, m."""
    errors = _errors(experiment)
    return float(errors[len(errors) // 2]), float(errors[-1])


def order() -> Facts:
    """The lag of a filter whose order is too low."""
    lower, quiet, higher = accelerated(2), accelerated(2, noise="none"), accelerated(3)
    halfway, end = lags(quiet)
    strength = float(distances(run_experiment(quiet).truth.states[-1:, :, 2])[0])
    alpha, beta = lower.gains().values
    return Facts(
        right=1 if ALIKE[0] < end / halfway < ALIKE[1] else 0 if end < halfway else 2,
        numbers={
            "xi": XI, "strength": strength, "halfway": halfway, "end": end, "alpha": alpha, "beta": beta,
            "interval": lower.interval, "lag": strength * unit_lag(lower), "share": noise_share(lower),
            "share_higher": noise_share(higher),
        },
        ways=(
            _way("/", lower), _way("/", quiet), _way("/", higher),
            _way("/stability", lower, View(input="parabola")),
        ),
    )  # fmt: skip


# Where it breaks ----------------------------------------------------------------------------------------------------

MILD, STEADY, BREAKING = 0.5, 1.9, 2.1
SMALL, BEYOND = 0.2, 3.8
"""An alpha with more room, and a beta that is too large for it all the same."""

LIMITS = (1.0, 2.0, 4.0)
"""What may be predicted."""


def by_hand(alpha: float, beta: float) -> Experiment:
    """A target in straight flight, followed with two gains set by hand."""
    return _experiment(scenario="constant-velocity", order=2, design="manual", alpha=alpha, beta=beta)


def last_stable_beta(alpha: float) -> float:
    """The largest stable beta at an alpha, by halving."""
    low, high = 1e-6, 8.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if is_stable(Gains((alpha, middle))) else (low, middle)
    return low


def stability() -> Facts:
    """The border of the stable region."""
    limit = last_stable_beta(1.0)
    mild, below, above = (by_hand(1.0, beta) for beta in (MILD, STEADY, BREAKING))
    beyond = by_hand(SMALL, BEYOND)
    steady, broken, stop = assess(below.gains()), assess(above.gains()), run_experiment(beyond).track.stopped_at
    if stop is None:
        raise RuntimeError("the run was to be stopped")
    return Facts(
        right=next((index for index, value in enumerate(LIMITS) if abs(value - limit) < 1e-6), len(LIMITS)),
        numbers={
            "mild": MILD, "steady": STEADY, "breaking": BREAKING, "small": SMALL, "limits": LIMITS, "limit": limit,
            "limit_small": last_stable_beta(SMALL), "beyond": BEYOND, "sample": stop + 1,
            "pole": steady.spectral_radius, "pole_breaking": broken.spectral_radius,
            "fails": next(condition.text for condition in broken.conditions if not condition.holds),
        },
        ways=(_way("/stability", mild), _way("/stability", below), _way("/stability", above), _way("/", beyond)),
    )  # fmt: skip


# Can a filter be worse than its sensor? -----------------------------------------------------------------------------

EAGER, CALM = (0.9, 0.8), (0.3, 0.05)
AS_MUCH = 0.95, 1.05


def prediction() -> Facts:
    """A prediction that is worse than the measurements."""
    eager, calm = by_hand(*EAGER), by_hand(*CALM)
    gain = variance_reduction(eager.gains(), eager.interval).predicted
    return Facts(
        right=0 if gain < AS_MUCH[0] else 1 if gain < AS_MUCH[1] else 2,
        numbers={
            "eager": EAGER, "calm": CALM, "gain": significant(gain, 3), "share": noise_share(eager),
            "gain_calm": variance_reduction(calm.gains(), calm.interval).predicted,
        },
        ways=(_way("/", eager), _way("/", eager), _way("/", calm), _way("/stability", eager)),
    )  # fmt: skip


# One run proves little ----------------------------------------------------------------------------------------------

SEEDS = 100
FIRST, SECOND = 0.6, 0.75
OFTEN, SELDOM = 0.9, 0.1


def rivals() -> tuple[Experiment, Experiment]:
    """Two filters on the same short run, of which neither is much better."""
    values = {"scenario": "coordinated-turn", "samples": 60, "order": 2, "design": "fading-memory"}
    return _experiment(**values, xi=FIRST), _experiment(**values, xi=SECOND)


def rivalry() -> FloatArray:
    """Estimation RMSE of the two filters with many seeds, the first one's first, shape (2, SEEDS), m."""
    first, second = rivals()
    vectors = np.array([first.gains().vector, second.gains().vector])
    seeds = range(first.seed, first.seed + SEEDS)
    return run_errors(first, seeds, vectors, figures=("rmse",), kinds=("estimation",))["estimation"].rmse


def luck() -> Facts:
    """One run and many."""
    first, second = rivals()
    errors = rivalry()
    better, worse = (1, 0) if errors[1, 0] < errors[0, 0] else (0, 1)
    wins = errors[better] < errors[worse]
    share = float(wins.mean())
    ahead = errors[worse] - errors[better]
    gain, width = (float(value) for value in mean_interval(ahead))
    both = _way("/compare", second, A=first)
    return Facts(
        right=0 if share >= OFTEN else 2 if share <= SELDOM else 1,
        numbers={
            "samples": first.samples, "seed": first.seed, "seeds": SEEDS, "xi": (FIRST, SECOND),
            "once": errors[:, 0], "means": errors.mean(axis=1), "often": OFTEN, "seldom": SELDOM,
            "better": "AB"[better], "worse": "AB"[worse], "wins": int(wins.sum()),
            "won": ahead[wins].mean(), "lost": -ahead[~wins].mean(),
            "by": 1 - errors[better, 0] / errors[worse, 0],
            "gain": significant(gain, 2), "low": significant(gain - width, 2), "high": significant(gain + width, 2),
            "verdict": "Zero lies within: these runs do not say whose error is smaller on average"
            if abs(gain) <= width
            else "Zero lies outside: so many runs do say whose error is smaller on average",
        },
        ways=(both, both, _way("/tune", second)),
    )  # fmt: skip


# Tuned without the truth --------------------------------------------------------------------------------------------

NEARLY = 0.03


def tuned_without_truth() -> SweepOutcome:
    """The innovations over xi, and beside them the errors of prediction and smoothed position: as on the Tune page."""
    experiment = flown(SHORT)
    values = usual_values(experiment, "xi")
    sweep = Sweep(experiment, "xi", values, "innovation_rmse", beside=("tracking_rmse", "estimation_rmse"))
    *_, last = sweep.stream()
    return last.outcome


def innovations() -> Facts:
    """Tuning without the truth."""
    experiment = flown(SHORT)
    found = tuned_without_truth()
    seen, predicted, smoothed = (found.optimum(row) for row in range(3))
    apart = seen.value - predicted.value
    blind = View(tuning=Tuning(objective="innovation_rmse", without_truth=True))
    return Facts(
        right=0 if abs(apart) <= NEARLY else 1 if apart > 0 else 2,
        numbers={
            "seen": seen.value, "predicted": predicted.value, "smoothed": smoothed.value, "least": seen.score.mean,
            "error": predicted.score.mean, "noise": NOISE * len(experiment.target.axes) ** 0.5,
        },
        ways=(_way("/tune", experiment), _way("/tune", experiment, blind), "/data"),
    )  # fmt: skip
