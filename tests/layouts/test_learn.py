"""The lessons: every number and every right answer by another way; and where their steps lead."""

import math
import re
from urllib.parse import parse_qsl, urlsplit

import numpy as np
import pytest

from layouts.pages import compare, data, explore, learn, stability, tune
from layouts.pages.learn import facts
from layouts.pages.learn.lessons import lessons
from layouts.state import from_query, to_query
from tracker_core import Experiment, run_experiment

LESSONS = {lesson.name: lesson for lesson in lessons()}
EVERY_LESSON = pytest.mark.parametrize("lesson", LESSONS.values(), ids=LESSONS)
PAGES = {page.NAME: page for page in (explore, stability, tune, compare, data)}


def by_hand(measured, alpha, beta, interval):
    """Ten lines: predicted and smoothed positions of an α-β filter from two points, per axis."""
    position, velocity = measured[1], (measured[1] - measured[0]) / interval
    predicted, smoothed = [np.full(2, np.nan)] * 2, [measured[0], measured[1]]
    for z in measured[2:]:
        ahead = position + interval * velocity
        position, velocity = ahead + alpha * (z - ahead), velocity + beta * (z - ahead) / interval
        predicted.append(ahead)
        smoothed.append(position)
    return np.array(predicted), np.array(smoothed)


def followed(truth, measured, alpha, beta, interval):
    """Distance of the smoothed position from the truth."""
    return np.hypot(*(by_hand(measured, alpha, beta, interval)[1] - truth).T)


def faded(xi):
    return 1 - xi**2, (1 - xi) ** 2


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def smoothed_share(alpha, beta):
    """Steady variance of the smoothed position of order 2, per variance of the measurements, in closed form."""
    return (2 * alpha**2 + 2 * beta - 3 * alpha * beta) / (alpha * (4 - 2 * alpha - beta))


def of(experiment):
    result = run_experiment(experiment)
    return result.truth, result.measurements.positions


def test_there_are_six():
    assert len(LESSONS) == 6


@EVERY_LESSON
def test_a_lesson_is_whole(lesson):
    texts = [
        lesson.title, lesson.setting, lesson.question, *lesson.choices, *lesson.answer,
        *(step.sentence for step in (lesson.look, *lesson.steps)),
    ]  # fmt: skip
    assert all(texts)
    assert not any(re.search(r"[{}]|nan|None(?!:)|inf\b|\bTrue\b|array", text) for text in texts)
    assert len(set(lesson.choices)) == len(lesson.choices) >= 3
    assert 0 <= lesson.right < len(lesson.choices)
    assert len(lesson.steps) >= 2


@EVERY_LESSON
def test_steps_lead_to_what_they_name(lesson):
    for step in (lesson.look, *lesson.steps):
        parts = urlsplit(step.address)
        assert parts.path == PAGES[step.page].PATH
        settings, notes = from_query(dict(parse_qsl(parts.query)))
        assert notes == []
        assert to_query(settings) == parts.query or step.page == "Data"


def test_no_right_answer_has_a_place_of_its_own():
    assert len({lesson.right for lesson in LESSONS.values()}) >= 3


@pytest.mark.parametrize(("xi", "key"), [(facts.SHORT, ""), (facts.LONG, "_after")])
def test_memory(xi, key):
    numbers = facts.memory().numbers
    alpha, beta = faded(xi)
    runs = []
    for seed in range(1, 21):
        truth, measured = of(Experiment.from_dict(facts.flown(xi).to_dict() | {"seed": seed}))
        runs.append(followed(truth.positions, measured, alpha, beta, 1.0))
    heading = np.unwrap(np.arctan2(truth.states[:, 1, 1], truth.states[:, 0, 1]))
    # A leg begins at the sample at a joint.
    turning = np.append(np.abs(np.diff(heading)) > 1e-9, False)
    assert numbers["runs"] == len(runs)
    assert numbers[f"straight{key}"] == pytest.approx(rms(np.array(runs)[:, ~turning]), rel=1e-9)
    assert numbers[f"turning{key}"] == pytest.approx(rms(np.array(runs)[:, turning]), rel=1e-9)
    assert numbers[f"share{key}"] == pytest.approx(smoothed_share(alpha, beta), rel=1e-12)
    assert numbers[f"lag{key}"] == pytest.approx((1 - alpha) / beta, rel=1e-12)


def test_memory_has_one_price_for_the_other():
    assert LESSONS["memory"].choices[LESSONS["memory"].right] == "Smaller on the straight legs, larger in the turns"


def test_order():
    numbers = facts.order().numbers
    alpha, beta = faded(facts.XI)
    truth, _ = of(facts.accelerated(2))
    errors = followed(truth.positions, truth.positions, alpha, beta, 1.0)
    assert numbers["strength"] == pytest.approx(math.hypot(1.5, 1.0), rel=1e-12)
    assert numbers["halfway"] == pytest.approx(errors[100], rel=1e-9)
    assert numbers["end"] == pytest.approx(errors[-1], rel=1e-9)
    assert numbers["lag"] == pytest.approx(errors[-1], rel=1e-9)
    # Order 3 keeps up.
    quiet = run_experiment(facts.accelerated(3, noise="none"))
    assert np.abs(quiet.track.smoothed[-1, :, 0] - quiet.truth.positions[-1]).max() < 1e-6
    assert "same distance" in LESSONS["order"].choices[LESSONS["order"].right]


@pytest.mark.parametrize("alpha", [0.05, facts.SMALL, 1.0, 1.7])
def test_stability(alpha):
    limit = facts.last_stable_beta(alpha)
    radius = [max(abs(np.roots([1, alpha + beta - 2, 1 - alpha]))) for beta in (limit - 1e-6, limit + 1e-6)]
    assert radius[0] < 1 < radius[1]
    assert limit == pytest.approx(4 - 2 * alpha, rel=1e-12)


def test_where_it_breaks_is_what_may_be_predicted():
    found = facts.stability()
    assert facts.LIMITS[found.right] == pytest.approx(facts.last_stable_beta(1.0))
    assert found.numbers["pole"] == pytest.approx(facts.STEADY - 1, rel=1e-12)
    assert found.numbers["pole_breaking"] == pytest.approx(facts.BREAKING - 1, rel=1e-12)
    assert found.numbers["fails"] == "4 − 2α − β > 0"
    # At α = 1 only predictions run away; where the step leads the run is stopped.
    truth, measured = of(facts.by_hand(1.0, facts.BREAKING))
    errors = followed(truth.positions, measured, 1.0, facts.BREAKING, 1.0)[:60]
    np.testing.assert_allclose(errors, np.hypot(*(measured - truth.positions)[:60].T), rtol=1e-9)
    last = run_experiment(Experiment.from_dict(dict(parse_qsl(urlsplit(found.ways[-1]).query))))
    truth, measured = of(facts.by_hand(facts.SMALL, facts.BEYOND))
    errors = followed(truth.positions, measured, facts.SMALL, facts.BEYOND, 1.0)
    assert last.track.stopped_at == found.numbers["sample"] - 1 == int(np.argmax(errors > last.track.limit * 0.99))


def test_prediction():
    numbers = facts.prediction().numbers
    for (alpha, beta), said in ((facts.EAGER, numbers["gain"]), (facts.CALM, numbers["gain_calm"])):
        predicted = (2 * alpha**2 + alpha * beta + 2 * beta) / (alpha * (4 - 2 * alpha - beta))
        assert float(said) == pytest.approx(predicted, abs=5e-3)
    assert numbers["share"] == pytest.approx(smoothed_share(*facts.EAGER), rel=1e-12)
    assert LESSONS["prediction"].choices[LESSONS["prediction"].right] == "Larger"


def test_luck():
    errors = np.empty((2, facts.SEEDS))
    for row, (filtered, xi) in enumerate(zip(facts.rivals(), (facts.FIRST, facts.SECOND), strict=True)):
        for run in range(facts.SEEDS):
            seeded = Experiment.from_dict(filtered.to_dict() | {"seed": 1 + run})
            truth, measured = of(seeded)
            errors[row, run] = rms(followed(truth.positions, measured, *faded(xi), 1.0))
    np.testing.assert_allclose(facts.rivalry(), errors, rtol=1e-9)
    numbers = facts.luck().numbers
    better, worse = ("AB".index(numbers[key]) for key in ("better", "worse"))
    assert errors[better, 0] < errors[worse, 0]
    assert numbers["wins"] == np.sum(errors[better] < errors[worse])
    # What the lesson is about: the first seed is no proof.
    assert facts.SELDOM < numbers["wins"] / facts.SEEDS < facts.OFTEN
    assert float(numbers["low"].replace("−", "-")) < 0 < float(numbers["high"])
    assert "Zero lies within" in numbers["verdict"]
    ahead = errors[worse] - errors[better]
    assert numbers["won"] == pytest.approx(ahead[ahead > 0].mean())
    assert numbers["lost"] == pytest.approx(-ahead[ahead < 0].mean())


def test_innovations():
    """The sum of squares that the lesson speaks of, by runs of our own."""
    found = facts.innovations().numbers
    grid = np.linspace(0.55, 0.8, 26)
    seen, predicted = np.zeros((2, 20, len(grid)))
    for run in range(20):
        truth, measured = of(Experiment.from_dict(facts.flown(0.5).to_dict() | {"seed": 1 + run}))
        for place, xi in enumerate(grid):
            ahead = by_hand(measured, *faded(xi), 1.0)[0][2:]
            seen[run, place] = rms(np.hypot(*(measured[2:] - ahead).T))
            predicted[run, place] = rms(np.hypot(*(truth.positions[2:] - ahead).T))
    seen, predicted = seen.mean(axis=0), predicted.mean(axis=0)
    assert abs(grid[np.argmin(seen)] - found["seen"]) <= 0.015
    assert abs(grid[np.argmin(predicted)] - found["predicted"]) <= 0.015
    assert found["least"] == pytest.approx(seen.min(), rel=1e-3)
    assert found["error"] == pytest.approx(predicted.min(), rel=1e-3)
    assert found["noise"] == pytest.approx(50 * math.sqrt(2))
    assert abs(found["seen"] - found["predicted"]) <= facts.NEARLY
    assert LESSONS["innovations"].choices[LESSONS["innovations"].right].startswith("… the same")


def test_the_page_tells_the_browser_what_comes_true():
    beginning = next(part for part in learn.layout()._traverse() if getattr(part, "id", "") == "learn-beginning")
    assert beginning.data == {name: lesson.right for name, lesson in LESSONS.items()}
