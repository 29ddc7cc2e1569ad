"""What the page says where a method chooses the gains: fields, level of the noise, what was found, verdict, menus."""

import re
from contextlib import suppress
from dataclasses import replace
from math import log10

import numpy as np
import pytest

from layouts.desk import answer
from layouts.filter_card import SLIDERS, design_menu
from layouts.pages import explore, stability, track
from layouts.pages.explore.answers import COMPARED, compared_rows, compared_text
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.readouts import fields_shown, formula_text, found_text, level_text, offers, owned, push_unit, status_text
from layouts.rules import presets
from layouts.shown import Shown
from layouts.state import Settings, View
from layouts.text import metric_text, significant
from tracker_core import DESIGNS, METRICS, STARTS, Experiment, InputError, run_experiment
from tracker_core.adaptive import METHODS, PARAMETERS
from tracker_core.fields import FIELDS
from tracker_core.manoeuvre import MANOEUVRES
from tracker_core.noise import NOISES, signal_to_noise, std_from_snr
from tracker_core.types import STATE_NAMES

NAMES = [name for name in METHODS if name not in DESIGNS]
SERVED = [(name, order) for name in NAMES for order in METHODS[name].orders]
OF_THE_TARGET = (
    "interval", "noise", "noise_level", "manoeuvre", "seed", "exaggerate", "with-truth", "without-truth",
)  # fmt: skip
ORACLES = ["linear-combination", "parallel-bank", "sample-search", "run-search"]
SHORT = {"samples": 80}


def run(**values):
    return run_experiment(Experiment.from_dict(values))


def shown(view=None, **values):
    """A run as Explore shows it, its counterpart beside it where the view says so."""
    result, view = run(**values), view or View()
    causal = result.experiment.counterpart() if view.beside else None
    beside = None if causal is None else run_experiment(causal)
    return Shown(result, Settings(result.experiment, view), "light", {}, beside=beside)


def number(text):
    """The first number of a text."""
    return float(re.search(r"-?[\d.]+(e-?\d+)?", text.replace("−", "-").replace(",", ""))[0])


# Fields ------------------------------------------------------------------------------------------------------------

BESIDE = {"data", "reading", "noise_correlation", "noise_std", "snr", "manoeuvre_std"}


@pytest.mark.parametrize(("method", "order"), [*SERVED, ("fading-memory", 3), ("benedict-bordner", 2)])
def test_the_fields_of_a_method_are_shown_and_those_of_no_other(method, order):
    gains = {"alpha": 0.1} if method == "benedict-bordner" else {}
    fields = fields_shown(Experiment.from_dict({"design": method, "order": order, **gains}))
    takes = set(METHODS[method].parameters) if method in NAMES else set()
    # Only a filter of order 4 has an eta to search.
    takes -= {"grid_eta"} if order == 3 else set()
    assert {name for name in PARAMETERS if fields[name]} == takes
    assert set(fields) == {*PARAMETERS, *BESIDE, *OF_THE_TARGET, "beside", "gate"}
    assert fields["beside"] == (method in ORACLES)
    # What no gains of its own has can be gated.
    assert fields["gate"] == (method not in set(METHODS) - set(DESIGNS))


@pytest.mark.parametrize("noise", [name for name in NOISES if name != "recorded"])
@pytest.mark.parametrize("level", ["std", "snr", "snr-decibel"])
@pytest.mark.parametrize("manoeuvre", MANOEUVRES)
def test_of_the_sensor_the_fields_are_shown_that_mean_something(noise, level, manoeuvre):
    fields = fields_shown(Experiment.from_dict({"noise": noise, "noise_level": level, "manoeuvre": manoeuvre}))
    assert {name for name in BESIDE if fields[name]} == {
        *(["noise_correlation"] if noise == "coloured" else []),
        "noise_std" if level == "std" else "snr",
        *([] if manoeuvre == "none" else ["manoeuvre_std"]),
    }


def test_the_fields_of_a_recorded_run():
    fields = fields_shown(Experiment.from_dict({"scenario": "garg-accelerating"}))
    # Nobody pushes what was recorded.
    drawn = set(OF_THE_TARGET) - {"without-truth", "manoeuvre"}
    assert {name for name in fields if fields[name]} == {"noise_std", "gate", *drawn}


@pytest.mark.parametrize("manoeuvre", MANOEUVRES)
def test_pushes_have_the_unit_of_what_they_are(manoeuvre):
    said = {"none": "", "acceleration-pulses": " (m/s²)", "acceleration-jumps": " (m/s²)", "jerk-pulses": " (m/s³)"}
    assert push_unit(Experiment.from_dict({"manoeuvre": manoeuvre})) == said[manoeuvre]


# Level of the noise ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scenario", ["jeong-ship", "climbing-turn", "constant-acceleration"])
@pytest.mark.parametrize("noise", ["white", "coloured"])
@pytest.mark.parametrize(("level", "snr"), [("snr", 400.0), ("snr-decibel", 26.0), ("snr-decibel", -3.0)])
def test_a_ratio_is_told_as_a_standard_deviation(scenario, noise, level, snr):
    result = run(scenario=scenario, samples=50, noise=noise, noise_level=level, snr=snr)
    stds = std_from_snr(result.truth.positions, snr, decibel=level == "snr-decibel")
    parts = re.findall(r"([\d.,]+) m in (\w+)", level_text(result))
    assert [axis for _, axis in parts] == list(result.scenario.axes)
    assert [number(text) for text, _ in parts] == pytest.approx(stds, rel=5.1e-3)
    assert level_text(result).startswith("σ ")


@pytest.mark.parametrize("scenario", ["jeong-ship", "climbing-turn", "constant-acceleration"])
def test_a_standard_deviation_is_told_in_decibel(scenario):
    result = run(scenario=scenario, samples=50, noise_std=[7.0])
    ratios = signal_to_noise(result.truth.positions, (7.0,))
    parts = level_text(result).removeprefix("SNR ").split(", ")
    assert [part.partition(" dB in ")[2] for part in parts] == list(result.scenario.axes)
    assert [number(part) for part in parts] == pytest.approx([10 * log10(ratio) for ratio in ratios], abs=0.051)


def test_where_there_is_no_noise_its_level_is_not_told():
    for values in ({"noise": "none"}, {"noise": "none", "noise_level": "snr"}, {"scenario": "garg-accelerating"},
                   {"noise_std": [0.0]}):  # fmt: skip
        assert level_text(run(**values)) == ""
    assert level_text(run(noise_std=[0.0, 10.0], samples=50)).partition(" dB in ")[2] == "y"


# What was found, verdict, oracle -----------------------------------------------------------------------------------


def test_the_weight_found_is_told_per_axis():
    result = run(**SHORT, design="linear-combination")
    x, y = result.selection.found["weight"]
    assert x != y
    said = re.fullmatch(r"Found: w = ([\d.]+) in x, ([\d.]+) in y\.", found_text(result))
    assert (float(said[1]), float(said[2])) == pytest.approx((x, y), abs=1e-9)
    assert found_text(run(**SHORT, design="linear-combination", weight=0.3)) == ""


@pytest.mark.parametrize("convention", ["normalised", "half", "taylor"])
@pytest.mark.parametrize("order", [3, 4])
def test_the_gains_found_are_told_as_the_sliders_show_them(controls_for, order, convention):
    values = {**SHORT, "design": "run-search", "order": order, "convention": convention}
    controls, said = controls_for(**values), found_text(run(**values))
    parts = said.removeprefix("Found: ").removesuffix(".").split("; ")
    assert [part.partition(" = ")[0] for part in parts] == ["α", "β", "γ", "η"][:order]
    shown_gains = [controls[name] for name in ("alpha", "beta", "gamma", "eta")[:order]]
    assert [number(part) for part in parts] == pytest.approx(shown_gains, rel=5.1e-3)


@pytest.mark.parametrize(
    "method", [*(name for name in NAMES if name not in ("run-search", "linear-combination")), "fading-memory"]
)
def test_where_nothing_was_searched_nothing_was_found(method):
    assert found_text(run(**SHORT, design=method)) == ""


def printed_stable(alpha, beta, gamma):
    """The exact region of order 3 in normalised gains, written out."""
    return alpha > 0 and beta > 0 and gamma > 0 and 4 - 2 * alpha - beta > 0 and (
        2 * alpha * beta - gamma * (2 - alpha) > 0
    )  # fmt: skip


def test_the_verdict_names_the_sample_the_axis_and_the_share_of_unstable_corrections():
    """The bound as Yu & Wu print it admits unstable gains."""
    experiment = Experiment.from_dict({**SHORT, "design": "sample-search", "order": 3, "bound": "printed"})
    result = run_experiment(experiment)
    corrected = [row for row in result.selection.gains.reshape(-1, 3) if not np.isnan(row).any()]
    unstable = [row for row in corrected if not printed_stable(*row)]
    assert 0 < len(unstable) < len(corrected)
    assert result.unstable_share() == pytest.approx(len(unstable) / len(corrected), rel=1e-12)
    tones = set()
    for at in range(10, 60, 7):
        view = View(axis=1, at=at)
        tone, text = status_text(result.at(at, 1), Settings(experiment, view))
        assert (tone == "good") == printed_stable(*result.selection.gains[at, 1])
        verdict = "stable" if tone == "good" else "unstable"
        assert text.startswith(f"Gains at y, sample {at + 1}: {verdict}")
        told = re.search(r"([\d.]+) % of all corrections use gains that would be unstable if held\.$", text)[1]
        assert float(told) == pytest.approx(100 * len(unstable) / len(corrected), rel=0.051)
        tones.add(tone)
    assert tones == {"good", "bad"}


def test_a_method_whose_gains_are_all_stable_says_nothing_of_unstable_ones():
    experiment = Experiment.from_dict({**SHORT, "design": "sample-search", "order": 3})
    tone, text = status_text(run_experiment(experiment).at(40, 0), Settings(experiment))
    assert tone == "good"
    assert text.startswith("Gains at x, sample 41: stable: the largest pole has magnitude ")
    assert "unstable" not in text


@pytest.mark.parametrize(("method", "order"), SERVED)
def test_a_method_is_explained_and_an_oracle_says_why_it_is_one(controls_for, request_for, method, order):
    rest = answer(EXPLORE, request_for(controls_for(**SHORT, design=method, order=order), want=["explore-path"]))[1]
    assert rest["texts"]["formula"] == METHODS[method].sentence
    assert rest["method"] == method
    said = rest["texts"]["oracle"]
    assert said.startswith("Oracle. ") == (method in ORACLES)
    assert (said == "") == (method not in ORACLES)


def test_an_oracle_that_is_told_what_it_searched_is_none():
    given = Experiment.from_dict({"design": "linear-combination", "weight": 0.3})
    assert given.hindsight == ""
    assert not fields_shown(given)["beside"]
    assert given.counterpart() is None
    assert formula_text(given) == METHODS["linear-combination"].sentence


@pytest.mark.parametrize("scenario", ["yu-wu", "singer"])
@pytest.mark.parametrize("order", [3, 4])
def test_a_search_offers_the_objectives_that_it_accepts(scenario, order):
    experiment = Experiment.from_dict({"scenario": scenario, "design": "sample-search", "order": order})
    accepted = []
    for name in STATE_NAMES:
        with suppress(InputError):
            accepted.append(replace(experiment, objective=name).objective)
    assert offers(experiment)["objective"] == accepted


@pytest.mark.parametrize(("method", "order"), SERVED)
def test_a_method_offers_every_start_but_expanding_memory_and_owns_all_gains(method, order):
    experiment = Experiment.from_dict({"design": method, "order": order})
    assert offers(experiment)["start"] == [
        name for name, start in STARTS.items() if start.least_order <= order and name != "expanding"
    ]
    for start in offers(experiment)["start"]:
        assert replace(experiment, start=start).start == start
    states = ["computed"] * order + ["unused"] * (6 - order)
    assert list(owned(experiment).values()) == states


# The oracle beside its counterpart ---------------------------------------------------------------------------------

COUNTERPARTS = {
    "linear-combination": "growing-memory", "parallel-bank": "parallel-bank-causal",
    "sample-search": "critically-damped-bank", "run-search": "critically-damped-bank",
}  # fmt: skip


def rmse(states, truth):
    """Root mean square of the distance to the truth over the samples where it is known."""
    squares = ((states - truth) ** 2).sum(axis=1)
    return float(np.sqrt(squares[~np.isnan(squares)].mean()))


@pytest.mark.parametrize("noise_std", [5.0, 200.0])
@pytest.mark.parametrize("method", ORACLES)
def test_an_oracle_is_compared_with_its_counterpart_and_the_measurement(method, noise_std):
    values = {"samples": 150, "design": method, "noise_std": [noise_std]}
    alone, both = shown(**values), shown(View(beside=True), **values)
    # The very same run, asked for by name.
    causal = run(samples=150, noise_std=[noise_std], design=COUNTERPARTS[method], order=alone.result.experiment.order)
    truth, oracle = alone.result.truth.positions, alone.result
    raw = METRICS["observation_rmse"], rmse(oracle.measurements.positions, truth)
    last = ["Measurement RMSE", "–", metric_text(*raw), "–"]

    def row(name, result):
        return [name, *(metric_text(METRICS[key], getattr(result.metrics, key)) for key in COMPARED)]

    assert compared_rows(alone) == [row("◆ Oracle", oracle), last]
    assert compared_rows(both) == [row("◆ Oracle", oracle), row("Causal", causal), last]
    # And by hand: the smoothed path of both.
    for result, cells in ((oracle, compared_rows(both)[0]), (causal, compared_rows(both)[1])):
        np.testing.assert_allclose(number(cells[2]), rmse(result.track.smoothed[:, :, 0], truth), rtol=1e-3)

    ratios = [rmse(result.track.smoothed[:, :, 0], truth) / raw[1] for result in (oracle, causal)]
    first, _, second = compared_text(both).partition(" Without it, the ")
    assert compared_text(alone) == first
    assert first.startswith("With the answer in hand this ")
    title = METHODS[COUNTERPARTS[method]].title
    assert second.startswith(title[0].lower() + title[1:])
    for said, ratio in zip((first.removeprefix("With the answer in hand this "), second), ratios, strict=True):
        if ratio < 1:
            told = float(re.search(r"removes ([\d.]+) % of the measurement's error\.$", said)[1])
            assert told == pytest.approx(100 * (1 - ratio), rel=5.1e-3)
        else:
            told = re.search(r"is no better than the raw measurement: ([\d.,]+) times its error\.$", said)[1]
            assert float(told.replace(",", "")) == pytest.approx(ratio, rel=5.1e-3)


@pytest.mark.parametrize(
    "values",
    [*({"design": name} for name in NAMES if name not in ORACLES), {"design": "linear-combination", "weight": 0.3}, {}],
    ids=str,
)
def test_a_causal_run_is_compared_with_nothing(values):
    for view in (View(), View(beside=True)):
        made = shown(view, **SHORT, **values)
        assert (made.beside, compared_rows(made), compared_text(made)) == (None, [], "")


def test_a_run_that_was_stopped_compares_with_nothing():
    """Where the target itself passes the limit, as far as it goes."""
    far = {"scenario": "constant-acceleration", "interval": 1e6, "samples": 300}
    made = shown(View(beside=True), **far, design="sample-search")
    assert made.result.track.stopped_at is not None
    assert made.beside.track.stopped_at is not None
    oracle, causal, raw = compared_rows(made)
    assert oracle == ["◆ Oracle", "–", "–", "–"]
    assert causal == ["Causal", "–", "–", "–"]
    assert raw[2] == metric_text(METRICS["observation_rmse"], made.result.metrics.observation_rmse)
    assert compared_text(made) == (
        "With the answer in hand this leaves the world: the run was stopped. "
        "Without it, the bank of critically damped filters leaves the world: the run was stopped."
    )


@pytest.mark.parametrize("sigma", [1, 10, 50])
@pytest.mark.parametrize("order", ["gamma", "delta"])
def test_with_measurement_noise_the_searches_are_hardly_better_or_worse_than_no_filter(order, sigma):
    run = presets()[f"yu2017/{order}-sigma-{sigma}"]
    made = shown(View(beside=True), **run.to_dict())
    metrics = run_experiment(run).metrics
    ratio = metrics.estimation_rmse / metrics.observation_rmse
    if order == "delta":
        assert ratio > 5
        said = f"is no better than the raw measurement: {significant(ratio, 3)} times its error."
    else:
        assert 0.85 < ratio < 1
        said = f"removes {significant(100 * (1 - ratio), 3)} % of the measurement's error."
    assert compared_text(made).startswith(
        f"With the answer in hand this {said} Without it, the bank of critically damped"
    )
    assert [row[0] for row in compared_rows(made)] == ["◆ Oracle", "Causal", "Measurement RMSE"]


def test_without_noise_nothing_is_gained():
    made = shown(View(beside=True), **SHORT, design="sample-search", noise="none")
    assert compared_text(made).startswith("The measurements carry no error")
    assert compared_rows(made)[-1][:3] == ["Measurement RMSE", "–", "0 m"]


# Menu and fields ---------------------------------------------------------------------------------------------------


def test_the_menu_has_every_design_and_method_once_and_marks_the_oracles():
    options, headings = design_menu()
    names = [name for name, _ in options]
    assert sorted(names) == sorted({"manual", *DESIGNS, *METHODS})
    assert sorted(names) == sorted(FIELDS["design"].choices)
    assert {name for name, title in options if title.startswith("◆ ")} == set(ORACLES)
    assert {name for (name, _), heading in zip(options, headings, strict=True) if heading.startswith("◆")} == set(
        ORACLES
    )
    groups = dict(zip(names, headings, strict=True))
    assert groups["manual"] == ""
    assert {groups[name] for name in DESIGNS} == {"Constant gains"}
    assert {groups[name] for name in NAMES if name not in ORACLES} == {"Chosen as it runs"}
    titles = [title.removeprefix("◆ ") for _, title in options]
    assert len(set(titles)) == len(titles)


def walk(part):
    """Every component of a tree."""
    if isinstance(part, list | tuple):
        for child in part:
            yield from walk(child)
    elif hasattr(part, "to_plotly_json"):
        yield part
        yield from walk(getattr(part, "children", None))


@pytest.mark.parametrize("page", [explore, stability, track], ids=lambda page: page.__name__)
def test_every_page_has_a_field_for_every_parameter(page):
    parts = list(walk(page.layout()))
    for name, field in PARAMETERS.items():
        (place,) = (part for part in parts if f"field-{name}" in (getattr(part, "className", "") or "").split())
        inside = [part.to_plotly_json() for part in walk(place)]
        kinds = [item["props"].get("data-input", item["type"]) for item in inside
                 if item["props"].get("data-control") == name]  # fmt: skip
        assert kinds == (["Select"] if field.kind == "choice" else ["slider", "box"])
        if field.kind == "choice":
            values = [item["props"]["value"] for item in inside if item["type"] == "Option"]
            assert values == list(field.choices)


@pytest.mark.parametrize("name", [name for name, field in PARAMETERS.items() if field.kind != "choice"])
def test_a_slider_spans_what_its_field_admits(name):
    span, field = SLIDERS[name], PARAMETERS[name]
    assert span["low"] < span["high"]
    for end in ("low", "high"):
        assert field.read(name, span[end]) == span[end]
    assert span.get("whole", False) == (field.kind == "whole")
    if span.get("whole"):
        assert all(isinstance(span[end], int) for end in ("low", "high"))
    if span["curve"] == "log":
        assert span["low"] > 0
    defaults = [method.defaults(interval)[name] for method in METHODS.values() for interval in (0.1, 3.0)
                if name in method.defaults(interval)]  # fmt: skip
    assert all(span["low"] <= default <= span["high"] for default in defaults)
