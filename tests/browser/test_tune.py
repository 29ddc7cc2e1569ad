"""The Tune page in a real browser: studies are run, their best filter is taken, points are dragged, entries refused."""

import re

import pytest
from playwright.sync_api import expect

from layouts.pages.tune.content import begin
from layouts.questions import StudyQuestion
from tracker_core import Experiment
from tracker_core.tuning import Sweep
from tracker_core.tuning.sweeps import usual_values

SHORT = "samples=200"

NO_BETTER = """() => /the same as with the present|is shown to be better than the present/
    .test(document.getElementById('tune-best').textContent)"""


def study(page, state="done"):
    """Wait until the study is in that state and its plot shows the runs that the page says."""
    expect(page.locator(f'#tune [data-study="{state}"]')).to_have_count(1)


def meta(page):
    return page.evaluate("() => document.querySelector('#tune-plot .js-plotly-plot').layout.meta")


def present(page):
    """Where the line at the present value stands."""
    return page.evaluate(
        """() => {const {shapes, meta} = document.querySelector('#tune-plot .js-plotly-plot').layout;
        const {visible, x0} = shapes[meta.present]; return visible ? x0 : null}"""
    )


def words(query):
    """What the page should say, from a study of our own."""
    asked, show = begin(StudyQuestion(seq=1, query=query))
    *_, last = asked.stream()
    return show(last)["texts"]


def test_the_best_value_is_used_and_given_back(open_page, settle):
    page = open_page(f"tune?{SHORT}")
    study(page)
    experiment = Experiment.from_dict({"samples": 200})
    *_, last = Sweep(experiment, "xi", usual_values(experiment, "xi"), "estimation_rmse").stream()
    best = last.outcome.optimum()
    assert page.inner_text("#tune-best") == words(SHORT)["best"]
    assert page.inner_text("#tune-runs") == "20 runs"
    assert present(page) == 0.64
    # The line follows a slider.
    page.focus("#tune-xi-slider")
    page.keyboard.press("ArrowLeft")
    settle(page)
    assert present(page) == float(page.input_value("#tune-xi")) != 0.64
    page.click("#tune-use")
    settle(page)
    assert float(re.search(r"[?&]xi=([^&]+)", page.url)[1]) == pytest.approx(best.value, rel=1e-4)
    page.wait_for_function(NO_BETTER)
    assert present(page) == float(f"{best.value:.5g}")
    page.click("#undo")
    settle(page)
    page.click("#undo")
    settle(page)
    assert page.url.endswith(f"tune?{SHORT}")
    assert present(page) == 0.64


def test_gains_are_dragged_over_the_map_and_a_cell_is_taken(open_page, settle):
    page = open_page(f"tune?{SHORT}&order=2&cells=20&tune_runs=3")
    page.check("#tune-tune-map")
    settle(page)
    study(page)
    page.wait_for_function("() => document.querySelector('#tune-plot .js-plotly-plot').layout.meta.study === 'map'")
    assert "tune=map" in page.url
    handle = page.locator("#tune-plot ~ .handle")
    said = page.inner_text("#tune-best")
    box = handle.bounding_box()
    page.mouse.move(box["x"] + 13, box["y"] + 13)
    page.mouse.down()
    for step in range(1, 11):
        page.mouse.move(box["x"] + 13 + 4 * step, box["y"] + 13 - 6 * step)
    page.mouse.up()
    settle(page)
    alpha, beta = (float(re.search(rf"[?&]{name}=([^&]+)", page.url)[1]) for name in ("alpha", "beta"))
    assert alpha > 0.62
    assert beta > 0.3
    # The map is the same one, how much better its best cell is follows the gains.
    page.wait_for_function("(said) => document.getElementById('tune-best').textContent !== said", arg=said)
    assert page.inner_text("#tune-best").split(":")[1] == said.split(":")[1]
    # A click takes hold of a cell, a second one on the button uses it.
    x, y = page.evaluate(
        """() => {const gd = document.querySelector('#tune-plot .js-plotly-plot'), {xaxis, yaxis} = gd._fullLayout;
        const box = gd.getBoundingClientRect();
        return [box.left + xaxis._offset + xaxis.l2p(1.2), box.top + yaxis._offset + yaxis.l2p(0.6)]}"""
    )
    page.mouse.click(x, y)
    page.locator("#tune-cell").click()
    settle(page)
    alpha, beta = (float(re.search(rf"[?&]{name}=([^&]+)", page.url)[1]) for name in ("alpha", "beta"))
    assert alpha == pytest.approx(1.2, abs=0.06)
    assert beta == pytest.approx(0.6, abs=0.11)
    page.click("#tune-use")
    settle(page)
    page.wait_for_function(NO_BETTER)


def test_what_cannot_be_done_is_refused_beside_the_field(open_page, settle):
    page = open_page(f"tune?{SHORT}&tune=map&cells=10&tune_runs=2")
    study(page)
    drawn, said = meta(page), page.inner_text("#tune-best")

    def refused(name, entry, message, mended):
        page.fill(f"#tune-{name}", entry)
        page.keyboard.press("Enter")
        expect(page.locator(f"#tune-{name}-error")).to_contain_text(message)
        # The last good plot stays, and the page goes on once the entry is mended.
        assert (meta(page), page.inner_text("#tune-best")) == (drawn, said)
        page.fill(f"#tune-{name}", mended)
        page.keyboard.press("Enter")
        expect(page.locator(f"#tune-{name}-error")).to_have_text("")
        settle(page)
        study(page)

    refused("cells", "10000", "Cells a side must be a whole number >= 2 and <= 200, got “10000”.", "10")
    # That runs are too many for a map is known to the study alone.
    message = "Runs must be a whole number >= 1 and <= 1,000, got “5000”."
    refused("tune_runs", "5000", message, "2")
    page.fill("#tune-tune_runs", "5000")
    page.keyboard.press("Enter")
    expect(page.locator("#tune-tune_runs-error")).to_contain_text(message)
    # What the study says stays beside what the page says.
    page.fill("#tune-seed", "x")
    page.keyboard.press("Enter")
    expect(page.locator("#tune-seed-error")).to_contain_text("Seed must be")
    expect(page.locator("#tune-tune_runs-error")).to_contain_text(message)
    page.click("#undo")
    expect(page.locator("#tune-seed-error")).to_have_text("")
    refused("tune_runs", "4000", message.replace("5000", "4000"), "2")
    page.check("#tune-tune-sweep")
    settle(page)
    study(page)
    drawn, said = meta(page), page.inner_text("#tune-best")
    refused("from", "-1", "The first value must be a finite number >= 0 and < 1, got “-1”.", "0.2")
    page.fill("#tune-tune_runs", "1000000000")
    page.keyboard.press("Enter")
    expect(page.locator("#tune-tune_runs-error")).to_contain_text("must be a whole number >= 1 and <= 10,000")


def test_without_the_truth_only_innovations_count(open_page, settle, check_look):
    small = f"{SHORT}&points=21&cells=12&tune_runs=4"
    page = open_page(f"tune?{small}")
    study(page)
    page.check("#tune-without_truth")
    settle(page)
    study(page)
    assert page.input_value("#tune-tune_for") == "innovation_rmse"
    offered = page.eval_on_selector_all("#tune-tune_for option:not([hidden])", "all => all.map(one => one.value)")
    assert offered == ["innovation_rmse", "innovation_total", "innovation_max", "innovation_l2"]
    assert page.inner_text("#tune-cost") == words(f"{small}&without_truth=on")["cost"]
    check_look(page)
    # The radio buttons are reached by the keyboard.
    page.focus("#tune-tune-sweep")
    page.keyboard.press("ArrowRight")
    settle(page)
    study(page)
    assert "tune=map" in page.url
    page.uncheck("#tune-without_truth")
    settle(page)
    assert page.input_value("#tune-tune_for") == "estimation_rmse"
    expect(page.locator("#tune-cost")).to_have_text("")
