"""Methods that choose their gains, in a real browser."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import expect

from tracker_core import Experiment, run_experiment
from tracker_core.adaptive import METHODS
from tracker_core.papers import papers

RUNS = {f"{paper.name}/{run.name}": run.experiment for paper in papers().values() for run in paper.runs}
BANK = {"scenario": "alwagih", "design": "parallel-bank"}


def numbers(values):
    """As the page holds them: NaN is None."""
    return [None if value != value else pytest.approx(value, rel=1e-5, abs=1e-4) for value in values]


def choose(page, name, value, settle):
    page.select_option(f"#explore-{name}", value)
    settle(page)


def test_a_method_brings_its_plot_its_parameters_and_its_trail(open_page, plot, settle):
    page = open_page("?order=2")
    gains = page.locator("#explore-gains-card")
    expect(gains).to_be_hidden()
    expect(page.locator("#explore .method .field-window")).to_be_hidden()
    choose(page, "design", "moving-window", settle)
    expect(gains).to_be_visible()
    expect(page.locator("#explore .method .field-window")).to_be_visible()
    expect(page.locator("#explore .method .field-members")).to_be_hidden()
    # A plot that was laid out just now fills its place.
    place, drawn = (gains.locator(part).bounding_box() for part in (".plot-frame", ".main-svg >> nth=0"))
    assert (drawn["width"], drawn["height"]) == pytest.approx((place["width"], place["height"]), abs=2)
    result = run_experiment(Experiment.from_dict({"order": 2, "design": "moving-window"}))
    for index in range(2):
        assert plot(page, "gains").line(index)[1] == numbers(result.selection.gains[:, 0, index])
    trail = np.array(plot(page, "stability").line(5), dtype=float).T
    used = result.selection.gains[2:, 0]
    assert len(trail) > 10
    assert all(np.abs(used - point).max(axis=1).min() < 1e-6 for point in trail)
    # Its own slider moves it, and the gains that its sliders show are where the hand takes over.
    page.focus("#explore-window-slider")
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    settle(page)
    window = int(page.input_value("#explore-window"))
    moved = run_experiment(Experiment.from_dict({"order": 2, "design": "moving-window", "window": window}))
    assert window == 25
    assert plot(page, "path").line(3)[0][500] == pytest.approx(moved.track.smoothed[500, 0, 0], rel=1e-6)
    beta = page.input_value("#explore-beta")
    page.focus("#explore-alpha-slider")
    page.keyboard.press("ArrowRight")
    settle(page)
    assert (page.input_value("#explore-design"), page.input_value("#explore-beta")) == ("manual", beta)
    expect(gains).to_be_hidden()


def test_an_oracle_says_so_and_its_causal_counterpart_stands_beside_it(open_page, plot, settle):
    page = open_page("?scenario=alwagih&design=parallel-bank")
    expect(page.locator("#explore-oracle")).to_contain_text("Oracle. The prediction is picked after the measurement")
    assert page.locator("#explore-design option[value=parallel-bank]").inner_text().startswith("◆")
    rows = page.locator("#explore-compared tr")
    expect(rows).to_have_count(2)
    page.check("#explore-beside")
    settle(page)
    expect(rows).to_have_count(3)
    oracle = Experiment.from_dict(BANK)
    causal = run_experiment(oracle.counterpart())
    for name, trace in (("path", 5), ("close-up", 5)):
        x, _ = plot(page, name).line(trace)
        shown = causal.track.smoothed[:, 0, 0] if name == "path" else causal.track.smoothed[85:116, 0, 0]
        assert x == numbers(shown)
    assert f"{causal.metrics.tracking_rmse:.2f} m" in rows.nth(1).inner_text()
    assert "beside=on" in page.url
    # It moves along while a slider does, and goes with the oracle.
    page.focus("#explore-members-slider")
    page.keyboard.press("ArrowLeft")
    settle(page)
    members = int(page.input_value("#explore-members"))
    fewer = run_experiment(Experiment.from_dict({**BANK, "members": members}).counterpart())
    assert members == 11
    assert plot(page, "path").line(5)[0] == numbers(fewer.track.smoothed[:, 0, 0])
    choose(page, "design", "parallel-bank-causal", settle)
    expect(page.locator("#explore-oracle")).to_be_hidden()
    expect(page.locator("#explore .compared-card")).to_be_hidden()
    assert plot(page, "path").line(5) == [[], []]


def test_with_measurement_noise_the_searches_are_hardly_better_or_worse_than_no_filter(open_page, settle):
    page = open_page("?beside=on")
    said = page.locator("#explore-compared-text")
    for name in ("delta", "gamma"):
        choose(page, "preset", f"yu2017/{name}-sigma-10", settle)
        metrics = run_experiment(RUNS[f"yu2017/{name}-sigma-10"]).metrics
        ratio = metrics.estimation_rmse / metrics.observation_rmse
        if name == "delta":
            expect(said).to_contain_text(f"is no better than the raw measurement: {ratio:.2f} times its error.")
        else:
            expect(said).to_contain_text(f"this removes {100 * (1 - ratio):.3g} % of the measurement's error.")
        expect(said).to_contain_text("Without it, the bank of critically damped filters removes")


def test_absurd_parameters_are_refused_beside_their_field(open_page, plot, settle):
    page = open_page("?scenario=alwagih&design=moving-window")
    meta = plot(page, "path").meta
    for name, text, message in (
        ("window", "200", "Window must be < 200, the number of samples"),
        ("window", "0", "Window must be a whole number >= 2 and <= 10,000"),
        ("levels", "0", "Levels of α must be a whole number >= 1"),
        ("fixed_alpha", "1.5", "Fixed α₀ must be a finite number > 0 and <= 1"),
    ):
        before = page.input_value(f"#explore-{name}")
        page.fill(f"#explore-{name}", text)
        page.press(f"#explore-{name}", "Enter")
        expect(page.locator(f"#explore-{name}-error")).to_contain_text(message)
        assert page.get_attribute(f"#explore-{name}", "aria-invalid") == "true"
        assert plot(page, "path").meta["seq"] == meta["seq"]
        page.fill(f"#explore-{name}", before)
        page.press(f"#explore-{name}", "Enter")
        expect(page.locator(f"#explore-{name}-error")).to_have_text("")
        settle(page)
        meta = plot(page, "path").meta


def test_every_method_is_drawn_from_the_menu_and_the_sample_chooses_its_gains(open_page, plot, settle):
    page = open_page("?scenario=yu-wu&samples=300&order=4")
    note = page.locator("#explore-note")
    for name, method in METHODS.items():
        before = int(page.input_value("#explore-order"))
        choose(page, "design", name, settle)
        # What was said of one choice goes with the next in the same menu.
        expect(note).to_contain_text("" if before in method.orders else "is a filter of order")
        if before in method.orders:
            expect(note).to_be_empty()
        if name != "benedict-bordner":
            assert page.get_attribute("#explore", "data-method") == name
            assert plot(page, "gains").meta["seq"] == plot(page, "path").meta["seq"]
        assert int(page.input_value("#explore-order")) in method.orders
    described = {"scenario": "yu-wu", "samples": 300, "order": int(page.input_value("#explore-order")), "design": name}
    result = run_experiment(Experiment.from_dict(described))
    page.locator("#explore-at-slider").focus()
    page.keyboard.press("Home")
    settle(page)
    assert plot(page, "path").meta["gains"] == pytest.approx(result.selection.gains_at(0, 0).tolist(), rel=1e-12)


def test_it_looks_right_at_every_width_in_both_themes(open_page, check_look):
    page = open_page("?scenario=alwagih&design=parallel-bank&beside=on&noise=coloured")
    # What it has beside the plain page stands at every width.
    check_look(page)
    for width in (390, 1000):
        page.set_viewport_size({"width": width, "height": 844})
        for card in (".metrics-card", ".compared-card"):
            assert page.locator(f"#explore {card}").bounding_box()["height"] < 400
        assert page.locator("#explore .compared-card .table-frame").evaluate(
            "frame => frame.scrollWidth <= frame.clientWidth"
        )
