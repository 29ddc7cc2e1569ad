"""The Compare page in a real browser."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from tracker_core import Experiment, run_experiment

TWO = "compare?seed=3&pin1=fading-memory,xi:0.5&pin2=manual,alpha:0.8,beta:0.4,name:%3Cb%3EBold%3C/b%3E"


def names(page):
    return page.locator("#compare .filters li:not([hidden]) input[type=text]").evaluate_all(
        "all => all.map(each => each.value)"
    )


def test_from_nothing_to_three_pins_that_are_named_used_let_go_and_undone(open_page, plot, settle):
    page = open_page("compare")
    expect(page.locator("#compare-empty")).to_be_visible()
    page.click('[data-pinning="start"]')
    settle(page)
    expect(page.locator("#compare-empty")).to_be_hidden()
    assert page.evaluate("() => document.activeElement.id") == "compare-reference-0"
    assert len(names(page)) == 3
    page.fill('[data-slot="2"] input', "Optimal, with: <i>")
    page.press('[data-slot="2"] input', "Enter")
    settle(page)
    assert "name:Optimal,+with:+%3Ci%3E" in page.url
    expect(page.locator('[data-heading="2"]').first).to_have_text("Optimal, with: <i>")
    # What counts for nothing any more stays as it was left here, and is as usual on another page.
    page.fill("#compare-tracking_index", "0.3")
    page.press("#compare-tracking_index", "Enter")
    settle(page)
    page.click('button[data-pinning="use"][data-slot="1"]')
    settle(page)
    assert page.input_value("#compare-xi") == "0.5"
    page.click('button[data-pinning="remove"][data-slot="1"]')
    settle(page)
    page.click('button[data-pinning="remove"][data-slot="3"]')
    settle(page)
    assert names(page) == ["Optimal, with: <i>"]
    assert page.evaluate("() => document.activeElement.id") == "compare-pin"
    page.click("#undo")
    settle(page)
    assert len(names(page)) == 2
    link = page.url[page.url.index("?") :]
    other = open_page(f"compare{link}")
    assert names(other) == names(page)
    page.click("#to-explore")
    page.wait_for_selector("#explore[data-state=settled]")
    assert page.url.endswith(f"/{link}")
    expect(page.locator("#explore-since")).to_contain_text("since ")
    # To go to another page is no step.
    page.click("#redo")
    page.wait_for_function("() => location.search.split('pin').length === 2")


def test_the_present_filter_moves_among_the_pinned_ones(open_page, plot, settle):
    page = open_page(TWO)
    before = [plot(page, "path").outline(trace) for trace in (2, 5)]
    page.evaluate(
        """() => {const gd = document.querySelector('#compare-path .js-plotly-plot');
        const line = gd.querySelector('.scatterlayer .trace' + gd._fullData[2].uid + ' .js-line');
        window.seq = gd._fullLayout.meta.seq;
        new MutationObserver(() => window.first ||= gd._fullLayout.meta.seq).observe(line, {attributes: true})}"""
    )
    page.focus("#compare-xi-slider")
    page.keyboard.press("PageUp")
    page.wait_for_function("() => window.first")
    # Drawn by hand before plotly has drawn anything anew.
    assert page.evaluate("() => window.first === window.seq")
    settle(page)
    after = [plot(page, "path").outline(trace) for trace in (2, 5)]
    assert after[0] != before[0]
    assert after[1] == before[1]
    xi = float(page.input_value("#compare-xi"))
    row = page.locator("#compare-metrics tr", has_text="Estimation RMSE").first
    present = run_experiment(Experiment.from_dict({"seed": 3, "xi": xi})).metrics.estimation_rmse
    assert float(row.locator("td").first.inner_text().split()[0]) == pytest.approx(present, rel=1e-3)
    page.check("#compare-reference-2")
    settle(page)
    assert "reference=2" in page.url
    expect(row.locator("td").nth(2)).to_contain_text("reference")
    assert page.evaluate("() => document.querySelectorAll('#compare .plot-frame b, #compare-forest b').length") == 0
    # A click on a constant gain, of which a few points are drawn, chooses the sample at its time.
    x, y, sample = page.evaluate(
        """() => {const gd = document.querySelector('#compare-gains .js-plotly-plot');
        const {x, y} = gd._fullData[0], {xaxis, yaxis} = gd._fullLayout, box = gd.getBoundingClientRect();
        return [box.left + xaxis._offset + xaxis.l2p(x[3]), box.top + yaxis._offset + yaxis.l2p(y[3]), 1 + x[3] / 3]}"""
    )
    page.mouse.move(x, y)
    page.wait_for_selector("#compare-gains .hoverlayer .hovertext")
    page.mouse.click(x, y)
    expect(page.locator("#compare-at")).to_have_value(str(round(sample)))
    assert sample > 200


def test_a_study_streams_is_stopped_runs_again_and_is_refused_beside_its_field(open_page, settle):
    page = open_page(f"{TWO}&runs=20")
    card = page.locator("#compare [data-study]")
    expect(card).to_have_attribute("data-study", "done")
    stopped = page.locator("#compare-over-runs tr", has_text="Stopped runs").locator("td:visible")
    expect(stopped).to_have_count(3)
    page.evaluate(
        """() => {const said = document.getElementById('compare-study-said'); window.said = [];
        new MutationObserver(() => window.said.push(said.textContent)).observe(said, {childList: true})}"""
    )
    page.click('#compare button[aria-label="100,000 runs"]')
    expect(page.locator("#compare-study-text")).to_have_text(re.compile(r"\d+ %, about .* left"))
    expect(page.locator("#compare-runs-text")).to_contain_text("seeds 3 to")
    page.click("#compare-study-stop")
    expect(card).to_have_attribute("data-study", "stopped")
    expect(page.locator("#compare-study-text")).to_contain_text("Stopped at")
    # Of what moves all the time a screen reader is told quarters.
    *quarters, last = page.evaluate("() => window.said")
    assert last.startswith("Stopped at")
    shares = [int(said.partition(" %")[0]) // 25 for said in quarters if said[0].isdigit()]
    assert shares == sorted(set(shares) - {0})
    page.click("#compare-study-stop")
    expect(card).to_have_attribute("data-study", "running")
    page.fill("#compare-runs", "2000000")
    page.press("#compare-runs", "Enter")
    expect(page.locator("#compare-runs-error")).to_contain_text("<= 1,000,000")
    page.fill("#compare-runs", "20")
    page.press("#compare-runs", "Enter")
    settle(page)
    expect(card).to_have_attribute("data-study", "done")
    page.select_option("#compare-noise", "none")
    settle(page)
    expect(card).to_have_attribute("data-study", "refused")
    expect(page.locator("#compare-chance")).to_contain_text("nothing of this target and sensor is left to chance")


def test_it_looks_right_at_every_width_in_both_themes(open_page, check_look):
    check_look(open_page(f"{TWO}&pin4=growing-memory&pin6=moving-window,window:5000&runs=20"))
