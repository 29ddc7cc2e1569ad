"""What the Stability page says beside its figures: merits, tests, the way back, tables, and the region's scene."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from dash import no_update
from msgspec import ValidationError

from layouts.controls import resolve
from layouts.desk import answer, live_answer
from layouts.numbers import MOST_ROWS
from layouts.pages.stability.answers import CARDS, DESK, NUMBERS, SPACE, picture
from layouts.readouts import distance_text, way_back
from layouts.rules import presets
from layouts.shown import Shown
from layouts.state import INPUTS, Settings, View
from layouts.text import change_text, metric_text, significant
from layouts.theme import THEMES
from tests.tables import cells
from tracker_core import CONVENTIONS, DESIGNS, Experiment, Gains, run_experiment
from tracker_core.merits import MERITS, merits
from tracker_core.optimal import distance_from_optimal
from tracker_core.poles import damping_class
from tracker_core.responses import frequency_response, time_response
from tracker_core.stability import assess, printed_conditions
from tracker_core.types import GAIN_NAMES, ORDERS

STABLE = {2: (0.6, 0.3), 3: (0.7, 0.4, 0.1), 4: (0.8, 0.6, 0.25, 0.05)}
UNSTABLE = {2: (1.9, 1.5), 3: (0.5, 0.2, 0.5), 4: (0.5, 0.2, 0.3, 0.9)}
# Through the border, far outside, on the wrong side of zero.
ASTRAY = [
    *UNSTABLE.values(), (2.5, -1.5), (0, 0), (1, 2), (-3, 7), (500, -900), (0.5, 0.3, -0.1), (2, 4, 8),
    (-1, -1, -1, -1), (3, 3, 3, 3), (0.6, 0.3, 0.1, -0.01),
]  # fmt: skip


def manual(gains, convention="normalised"):
    """What differs from the defaults for these normalised gains."""
    values = Gains(tuple(map(float, gains))).to(convention).values
    return {"design": "manual", "order": len(gains), "convention": convention,
            **dict(zip(GAIN_NAMES, values, strict=False))}  # fmt: skip


def radius(gains):
    """The largest pole, from the eigenvalues of the characteristic polynomial."""
    return assess(gains).spectral_radius


def ask(request_for, controls, moved=None, **more):
    return answer(DESK, request_for(controls, moved, **more))[1]


# Merits ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gains", [*STABLE.values(), *UNSTABLE.values()], ids=str)
def test_the_cards_are_the_merits_of_the_gains(controls_for, request_for, gains):
    rest = ask(request_for, controls_for(**manual(gains), interval=0.5))
    figures = merits(Gains(gains), 0.5)
    assert rest["cards"] == {name: [metric_text(MERITS[name], figures[name]), "", ""] for name in CARDS}
    assert set(CARDS) <= set(MERITS)
    unstable = [name for name, (text, *_) in rest["cards"].items() if text == "–"]
    assert unstable == ([] if gains in STABLE.values() else [name for name in CARDS if name != "spectral_radius"])


def test_the_cards_show_the_change_since_the_pin(controls_for, request_for):
    pin = Experiment.from_dict({"xi": 0.3})
    rest = ask(request_for, controls_for(), pins=[[1, "fading-memory,xi:0.3"]])
    now, then = (merits(e.gains(), e.interval) for e in (Experiment.from_dict({}), pin))
    for name, (value, *change) in rest["cards"].items():
        assert value == metric_text(MERITS[name], now[name])
        assert change == list(change_text(MERITS[name], now[name], then[name]))
    # A greater damping ratio is better, a greater noise gain is worse.
    assert rest["cards"]["noise_gain"][2] == "better"
    assert rest["cards"]["settling"][2] == "worse"


# The two tests -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gains", [*STABLE.values(), *UNSTABLE.values()], ids=str)
def test_every_inequality_is_listed_with_its_margin(controls_for, request_for, gains):
    rest = ask(request_for, controls_for(**manual(gains, "half")))
    verdict = assess(Gains(gains))
    groups = {"conditions": verdict.conditions, "printed": printed_conditions(Gains(gains)), "jury": verdict.jury}
    assert set(rest["rows"]) == set(groups)
    for name, conditions in groups.items():
        rows = rest["rows"][name]
        assert [row[0] for row in rows] == [condition.text for condition in conditions]
        for row, condition in zip(rows, conditions, strict=True):
            assert row[-2] == significant(condition.margin, 4)
            assert row[-1] == (["holds", "good"] if condition.margin > 0 else ["fails", "bad"])
    for row, condition in zip(rest["rows"]["jury"], verdict.jury, strict=True):
        assert row[1].split("  ") == [significant(number, 4) for number in condition.numbers]
    # Both tests come to the verdict; nothing is printed for order 2.
    held = {name: all(row[-1][0] == "holds" for row in rows) for name, rows in rest["rows"].items()}
    assert held["conditions"] == held["jury"] == verdict.stable == (rest["tone"] == "good")
    assert (len(rest["rows"]["printed"]) > 0) == (len(gains) > 2)


@pytest.mark.parametrize("order", ORDERS)
def test_how_the_filter_comes_back_and_where_it_lies_is_told(controls_for, request_for, order):
    texts = ask(request_for, controls_for(**manual(STABLE[order])))["texts"]
    assert texts["damping"] == damping_class(Gains(STABLE[order]))
    assert texts["space"] == SPACE[order]


def test_the_words_for_damping_are_those_of_the_map(controls_for, request_for):
    wanted = {(0.42, 1.45): "underdamped", (0.86, 0.14): "overdamped", (1.42, 0.5): "alternating"}
    for gains, word in wanted.items():
        assert ask(request_for, controls_for(**manual(gains)))["texts"]["damping"] == word


# The way back ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("gains", ASTRAY, ids=str)
def test_the_offer_makes_the_filter_stable_when_it_is_taken(controls_for, request_for, gains, convention):
    controls = controls_for(**manual(gains, convention))
    rest = ask(request_for, controls)
    offer = rest["offer"]
    # As the script takes it: one control after the other.
    got = resolve({**rest["controls"], **offer["controls"]}, list(offer["controls"]))
    experiment = got.settings.experiment
    present = resolve(controls, []).settings.experiment
    assert experiment == replace(present, **{n: v for n, v in offer["controls"].items() if n in GAIN_NAMES})
    # Four poles in one place are known to a thousandth.
    assert radius(experiment.gains()) <= 0.991
    assert got.note == ""
    assert ask(request_for, got.controls)["offer"] is None
    shown = [part.split(" ")[1] for part in offer["text"].partition(": ")[2].split(", ")]
    assert shown == [significant(offer["controls"][name], 3) for name in GAIN_NAMES[: len(gains)]]


@pytest.mark.parametrize("gains", list(UNSTABLE.values()), ids=str)
def test_the_offer_is_nearer_than_any_stable_gains_found_at_random(gains):
    offered = way_back(Gains(gains))["controls"]
    distance = np.linalg.norm(np.array([offered[name] for name in GAIN_NAMES[: len(gains)]]) - gains)
    rng = np.random.default_rng(1)
    near = np.array(gains) + rng.normal(size=(3000, len(gains))) * distance / 2
    closer = [vector for vector in near if np.linalg.norm(vector - gains) < 0.999 * distance]
    assert len(closer) > 300
    assert all(radius(Gains.normalised(vector)) > 0.99 for vector in closer)


def test_a_design_that_is_unstable_is_left_by_the_way_back(controls_for, request_for):
    controls = controls_for(design="benedict-bordner", order=2, alpha=1.6)
    offer = ask(request_for, controls)["offer"]
    got = resolve({**controls, **offer["controls"]}, list(offer["controls"]))
    assert (got.settings.experiment.design, got.settings.experiment.order) == ("manual", 2)
    assert radius(got.settings.experiment.gains()) < 1


def test_nothing_is_offered_to_stable_gains_or_while_a_slider_moves(controls_for, request_for):
    for gains in STABLE.values():
        assert ask(request_for, controls_for(**manual(gains)))["offer"] is None
    for gains in UNSTABLE.values():
        assert live_answer(DESK, request_for(controls_for(**manual(gains))))[0]["offer"] is None


# How far from the best ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("index", [1e-3, 0.1, 3])
def test_optimal_gains_are_called_optimal(order, index):
    gains = DESIGNS["steady-kalman"].gains(order, tracking_index=index)
    for values in ({"design": "steady-kalman", "order": order, "tracking_index": index}, manual(gains)):
        assert distance_text(run_experiment(Experiment.from_dict({**values, "samples": 3}))) == "optimal"


@pytest.mark.parametrize("gains", STABLE.values(), ids=str)
def test_other_gains_are_told_what_they_cost(controls_for, request_for, gains):
    text = ask(request_for, controls_for(**manual(gains)))["texts"]["distance"]
    percent = distance_from_optimal(Gains(gains)).percent
    assert text == f"{significant(percent, 3)} % more error variance than optimal"


@pytest.mark.parametrize("gains", UNSTABLE.values(), ids=str)
def test_unstable_gains_have_no_distance(controls_for, request_for, gains):
    assert ask(request_for, controls_for(**manual(gains)))["texts"]["distance"] == ""


# Tables ------------------------------------------------------------------------------------------------------------


def tables(request_for, controls):
    """Caption, heading and rows of every table."""
    updates, rest = answer(DESK, request_for(controls, want=[NUMBERS]))
    assert all(update is no_update for update in updates[:-1])
    assert rest["drawn"] == {NUMBERS: ""}
    return [cells(component) for component in updates[-1]]


def merit_tables(request_for, controls):
    """Those before the responses."""
    return [each for each in tables(request_for, controls) if not each[0].startswith(("Response", "Frequency"))]


def number(text):
    return float(text.replace(",", "").replace("−", "-"))


@pytest.mark.parametrize("gains", [*STABLE.values(), *UNSTABLE.values()], ids=str)
def test_the_poles_are_listed(controls_for, request_for, gains):
    caption, head, rows = tables(request_for, controls_for(**manual(gains)))[0]
    assert (caption, len(head)) == ("Poles", 3)
    poles = assess(Gains(gains)).poles
    for row, pole in zip(rows, poles, strict=True):
        assert number(row[1]) == pytest.approx(abs(pole), rel=1e-4)
        ratio = -np.log(abs(pole)) / np.hypot(np.log(abs(pole)), np.angle(pole))
        assert number(row[2]) == pytest.approx(ratio, rel=1e-3)


@pytest.mark.parametrize("order", ORDERS)
def test_the_variances_are_those_of_the_lyapunov_equation(controls_for, request_for, order):
    interval, g = 0.5, np.array(STABLE[order])
    _, (caption, _, rows), *_ = tables(request_for, controls_for(**manual(g), interval=interval))
    assert caption == "Variance per variance of the measurements"
    f = np.array([[interval ** (j - i) / [1, 1, 2, 6][j - i] if j >= i else 0 for j in range(order)]
                  for i in range(order)])  # fmt: skip
    k = g / interval ** np.arange(order)
    a = (np.eye(order) - np.outer(k, np.eye(order)[0])) @ f
    p = scipy.linalg.solve_discrete_lyapunov(a, np.outer(k, k))
    expected = [*np.diag(p), (f @ p @ f.T)[0, 0]]
    assert [number(row[1]) for row in rows] == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize("gains", UNSTABLE.values(), ids=str)
def test_unstable_gains_have_poles_and_no_more(controls_for, request_for, gains):
    assert [caption for caption, *_ in merit_tables(request_for, controls_for(**manual(gains)))] == ["Poles"]


@pytest.mark.parametrize("values", [{"noise": "none"}, {"noise_std": 0}], ids=str)
def test_without_noise_there_is_nothing_to_be_consistent_with(controls_for, request_for, values):
    assert len(merit_tables(request_for, controls_for(**values))) == 2


@pytest.mark.parametrize("key", presets())
def test_every_paper_run_with_noise_is_tested_for_consistency(controls_for, request_for, key):
    run = presets()[key]
    *_, (caption, head, rows) = merit_tables(request_for, controls_for(**run.to_dict()))
    settled = None if run.method else merits(run.gains(), 1.0)["settling"]
    if run.noise == "none" or run.method or settled is None or settled >= run.samples:
        # Nothing is left of it but its start, or its gains belong to no one model.
        assert not caption.startswith("Consistency")
        return
    assert caption.startswith("Consistency with the model of tracking index Λ = ")
    assert [len(row) for row in rows] == [len(head)] * 2
    # NEES of as many states as the filter has.
    assert rows[1][2] == f"{run.order} on average"


@pytest.mark.parametrize(
    ("scenario", "index", "word"),
    [
        # A target that never manoeuvres: the innovations are as small as a model of hardly any says.
        ("constant-velocity", 5e-4, "as the model says"),
        ("constant-velocity", 0.1, "smaller"),
        ("jeong-ship", 1e-3, "larger"),
    ],
)
def test_a_run_is_as_its_model_says_or_not(controls_for, request_for, scenario, index, word):
    values = {"scenario": scenario, "design": "kalata", "order": 2, "tracking_index": index, "samples": 20_000}
    *_, (caption, _, (nis, nees)) = merit_tables(request_for, controls_for(**values, start="known"))
    assert f"Λ = {significant(index, 3)}," in caption
    low, high = map(number, nis[2].split(" to "))
    # Two axes.
    assert low < 2 < high
    mean = number(nis[1])
    assert nis[3] == word == ("larger" if mean > high else "smaller" if mean < low else "as the model says")
    assert number(nees[3].removesuffix(" times")) == pytest.approx(number(nees[1]) / 2, rel=2e-3)


# The region's scene ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("gains", [*STABLE.values(), *UNSTABLE.values()], ids=str)
def test_the_scene_shows_the_first_three_gains(gains, theme):
    """A filter of order 2 lies on the floor."""
    experiment = Experiment.from_dict({**manual(gains, "taylor"), "samples": 5})
    made = picture(Shown(run_experiment(experiment), Settings(experiment), theme, {}))
    assert made.gains == (*gains, 0.0)[:3]
    assert made.stable == (gains in STABLE.values())
    assert made.theme == theme


@pytest.mark.parametrize("ask_for", [answer, live_answer], ids=["answer", "live"])
def test_a_scene_is_shown_what_the_page_shows_and_only_to_who_knows_its_secret(controls_for, request_for, ask_for):
    seen = []
    desk = replace(DESK, show=lambda token, picture: seen.append((token, picture.gains)))
    token = "0123456789abcdef" * 2
    controls = controls_for(View(), **manual(STABLE[3]))
    ask_for(desk, request_for(controls, scene=""))
    assert seen == []
    for scene in ("x", token + "0", token[:-1] + "/", "../" + token[:29], token + "\n"):
        with pytest.raises(ValidationError, match=r"scene"):
            request_for(controls, scene=scene)
    ask_for(desk, request_for(controls, {"alpha": "abc"}, scene=token))
    assert seen == []
    ask_for(desk, request_for(controls, {"alpha": 0.65}, scene=token))
    assert seen == [(token, (0.65, *STABLE[3][1:]))]


# The responses in numbers ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("order", "name"), [(2, "step"), (3, "ramp"), (4, "parabola")])
def test_the_responses_are_told_in_numbers(controls_for, request_for, order, name):
    interval, gains = 0.5, Gains(STABLE[order])
    *_, response, frequency = tables(
        request_for, controls_for(View(input=name), **manual(STABLE[order]), interval=interval)
    )
    assert response[0] == f"Response: {name}"
    degree = INPUTS.index(name)
    exact = time_response(gains, degree, 1_000)
    assert 20 < len(response[2]) <= MOST_ROWS
    for row in response[2]:
        time, *values = map(number, row)
        sample = round(time / interval)
        columns = (exact.input, exact.predicted, exact.smoothed)
        assert values == pytest.approx([column[sample] * interval**degree for column in columns], rel=1e-4, abs=1e-9)
    assert frequency[0] == "Frequency response"
    assert 20 < len(frequency[2]) <= MOST_ROWS
    for row in frequency[2]:
        hertz, predicted, smoothed, *_ = map(number, row)
        exact = frequency_response(gains, np.array([min(hertz * interval, 0.5)]))
        levels = 20 * np.log10(np.abs([exact.predicted[0], exact.smoothed[0]]))
        assert [predicted, smoothed] == pytest.approx(levels, rel=1e-3, abs=0.02)


def test_what_is_not_stable_has_no_frequency_response_to_tell(controls_for, request_for):
    captions = [caption for caption, *_ in tables(request_for, controls_for(**manual(UNSTABLE[2])))]
    assert captions == ["Poles", "Response: step"]


def test_nis_is_that_of_the_evidence_wherever_the_run_is_not_steady(controls_for, request_for):
    """With a gate that refused something the errors of the state have no steady covariance to be measured by."""
    values = {"scenario": "jeong-ship", "design": "steady-kalman", "order": 2, "tracking_index": 0.2, "gate": 2}
    *_, (caption, _, rows) = merit_tables(request_for, controls_for(**values))
    assert caption.startswith("Consistency")
    result = run_experiment(Experiment.from_dict(values))
    assert result.track.rejected.any()
    [(_, mean, between, _)] = rows
    nis = result.evidence().nis
    assert number(mean) == pytest.approx(nis.mean, rel=2e-3)
    assert [number(end) for end in between.split(" to ")] == pytest.approx([nis.low, nis.high], rel=2e-3)
