"""The Stability page in a real browser: points and poles are taken hold of."""

from __future__ import annotations

import re

import numpy as np
import pytest
from playwright.sync_api import expect

from layouts.figures import poles, stability_map
from layouts.text import significant
from tracker_core import Experiment, Gains, run_experiment
from tracker_core.merits import merits
from tracker_core.poles import characteristic_polynomial, gains_from_poles
from tracker_core.region import nearest_stable
from tracker_core.stability import jury_table

ORDER2 = "stability?order=2&design=manual&alpha=0.6&beta=0.3"
MAP, POLES = "#stability-map-card .handle", "#stability-poles-card .handle"


def shown_gains(page, count):
    """The gains as the link says them."""
    return [float(re.search(rf"[?&]{name}=([^&]+)", page.url)[1]) for name in ("alpha", "beta", "gamma", "eta")[:count]]


def middle(handle):
    """Where a handle is on the screen."""
    box = handle.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page, handle, steps):
    """Take a handle with the mouse and move it by steps of pixels."""
    handle.scroll_into_view_if_needed()
    x, y = middle(handle)
    page.mouse.move(x, y)
    page.mouse.down()
    for dx, dy in steps:
        page.mouse.move(x + dx, y + dy)
    page.mouse.up()


def to_pixels(page, plot, point):
    """Where a value of a plot is on the screen."""
    return page.evaluate(
        """([id, [x, y]]) => {const gd = document.querySelector(`#${id} .js-plotly-plot`);
        const {xaxis, yaxis} = gd._fullLayout, box = gd.getBoundingClientRect();
        return [box.left + xaxis._offset + xaxis.l2p(x), box.top + yaxis._offset + yaxis.l2p(y)]}""",
        [plot, point],
    )


def test_the_operating_point_is_dragged_with_the_mouse(open_page, plot, settle):
    page = open_page(ORDER2)
    handle = page.locator(MAP)
    before, path = plot(page, "response").line(2), plot(page, "path").line(3)
    drag(page, handle, [(i * 2, -i) for i in range(40)])
    settle(page)
    alpha, beta = shown_gains(page, 2)
    assert alpha > 0.7
    assert beta > 0.4
    # What the page says, what it draws, and where the handle stands are one.
    assert plot(page, "map").line(stability_map.POINT) == [[alpha], [beta]]
    assert plot(page, "map").meta["gains"] == [alpha, beta]
    assert middle(handle) == pytest.approx(to_pixels(page, "stability-map", (alpha, beta)), abs=1)
    assert float(page.input_value("#stability-alpha")) == pytest.approx(alpha, rel=1e-4)
    assert plot(page, "response").line(2) != before
    drawn = plot(page, "path").line(3)
    assert drawn != path
    expected = run_experiment(Experiment.from_dict({"order": 2, "alpha": alpha, "beta": beta}))
    assert drawn[0][500] == pytest.approx(expected.track.smoothed[500, 0, 0], rel=1e-5)
    found = page.inner_text('[data-metric="noise_gain"] .metric-value')
    assert found == significant(merits(expected.gains, 3.0)["noise_gain"])


def test_the_point_on_explore_moves_the_path_before_plotly_redraws(open_page, plot, settle):
    page = open_page("?order=2&design=manual&alpha=0.6&beta=0.3")
    path = plot(page, "path")
    before, meta = path.outline(3), path.meta
    page.evaluate(
        """() => {const gd = document.querySelector('#explore-path .js-plotly-plot');
        const line = gd.querySelector('.scatterlayer .trace' + gd._fullData[3].uid + ' .js-line');
        new MutationObserver(() => window.first ||= [gd._fullLayout.meta.seq, line.getAttribute('d')])
          .observe(line, {attributes: true})}"""
    )
    drag(page, page.locator("#explore-stability-card .handle"), [(0, -i) for i in range(20)])
    page.wait_for_function("() => window.first")
    seq, outline = page.evaluate("() => window.first")
    assert seq == meta["seq"]
    assert outline != before
    settle(page)
    alpha, beta = shown_gains(page, 2)
    assert alpha == pytest.approx(0.6, abs=0.02)
    assert beta > 0.4


def test_the_operating_point_moves_by_arrow_keys(open_page, plot, settle):
    page = open_page(ORDER2)
    page.focus(MAP)
    for key, place in (
        ("ArrowRight", [0.63, 0.3]),
        ("ArrowUp", [0.63, 0.33]),
        ("ArrowLeft", [0.6, 0.33]),
        ("Shift+ArrowDown", [0.6, 0.327]),
    ):
        for _ in range(3):
            page.keyboard.press(key)
        settle(page)
        assert shown_gains(page, 2) == pytest.approx(place, abs=1e-12), key
        assert plot(page, "map").line(stability_map.POINT) == [[v] for v in shown_gains(page, 2)]
        assert page.evaluate("() => document.activeElement.classList.contains('handle')")
        assert "Operating point: α" in page.locator(MAP).get_attribute("aria-label")


def test_a_finger_drags_the_point(open_page, settle):
    page = open_page(ORDER2, size=(390, 844), has_touch=True, is_mobile=True)
    handle = page.locator(MAP)
    x, y = middle(handle)
    session = page.context.new_cdp_session(page)
    session.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x, "y": y}]})
    for i in range(1, 20):
        session.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [{"x": x + i, "y": y - 2 * i}]})
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    settle(page)
    alpha, beta = shown_gains(page, 2)
    assert alpha > 0.65
    assert beta > 0.5
    assert page.evaluate("() => scrollY") == 0


def test_a_pole_is_dragged_with_the_mouse_and_its_conjugate_follows(open_page, plot, settle):
    page = open_page(ORDER2)
    upper = page.locator(POLES).nth(0)
    assert plot(page, "poles").line(poles.POLES)[1][0] > 0
    x, y = middle(upper)
    tx, ty = to_pixels(page, "stability-poles", (0.5, 0.4))
    drag(page, upper, [((tx - x) * i / 10, (ty - y) * i / 10) for i in range(11)])
    settle(page)
    real, imaginary = plot(page, "poles").line(poles.POLES)
    assert real == pytest.approx([0.5, 0.5], abs=0.01)
    assert imaginary == pytest.approx([0.4, -0.4], abs=0.01)
    wanted = gains_from_poles([complex(real[0], imaginary[0]), complex(real[1], imaginary[1])])
    assert shown_gains(page, 2) == pytest.approx(wanted, abs=1e-9)
    assert plot(page, "map").line(stability_map.POINT) == [[v] for v in shown_gains(page, 2)]
    assert float(page.input_value("#stability-beta")) == pytest.approx(wanted[1], rel=1e-4)
    expect(page.locator("#stability-note")).to_contain_text("")


def test_poles_move_by_arrow_keys_along_the_axis_and_off_it(open_page, plot, settle):
    page = open_page("stability?order=3&xi=0.5&design=fading-memory")
    held = page.locator(POLES).nth(0)
    held.focus()
    for _ in range(10):
        page.keyboard.press("ArrowRight")
    settle(page)
    real, imaginary = plot(page, "poles").line(poles.POLES)
    assert sorted(real) == pytest.approx([0.5, 0.5, 0.6], abs=2e-3)
    assert np.abs(imaginary).max() < 2e-3
    # The focus went with the pole; pulled off the axis, it takes its neighbour along.
    label = page.evaluate("() => document.activeElement.getAttribute('aria-label')")
    assert "0.60" in label
    for _ in range(10):
        page.keyboard.press("ArrowUp")
    settle(page)
    real, imaginary = plot(page, "poles").line(poles.POLES)
    assert sorted(imaginary) == pytest.approx([-0.1, 0, 0.1], abs=2e-3)
    roots = [complex(*pair) for pair in zip(real, imaginary, strict=True)]
    assert shown_gains(page, 3) == pytest.approx(gains_from_poles(roots), abs=1e-9)
    assert page.input_value("#stability-design") == "manual"


def test_dragging_works_without_a_socket(open_page, settle):
    def refuse(page):
        page.route_web_socket("**/stability/live", lambda socket: socket.close())

    page = open_page(ORDER2, first=refuse)
    drag(page, page.locator(MAP), [(i * 3, 0) for i in range(20)])
    settle(page)
    assert shown_gains(page, 2)[0] > 0.7


def test_leaving_the_region_offers_the_nearest_stable_gains(open_page, settle):
    page = open_page(ORDER2)
    offer = page.locator("#stability-offer")
    expect(offer).to_be_hidden()
    page.fill("#stability-beta", "3.5")
    page.press("#stability-beta", "Enter")
    settle(page)
    expect(page.locator("#stability-status")).to_contain_text("4 − 2α − β > 0 fails by 0.700")
    expect(page.locator("#stability-conditions")).to_contain_text("fails")
    expect(offer).to_be_visible()
    offer.click()
    settle(page)
    expect(offer).to_be_hidden()
    assert page.evaluate("() => document.activeElement.id") == "stability-verdict"
    expect(page.locator("#stability-status")).to_contain_text("Stable")
    assert shown_gains(page, 2) == pytest.approx(nearest_stable(Gains.normalised((0.6, 3.5))).values, abs=1e-12)


def test_the_tables_are_those_of_the_core(open_page):
    page = open_page("stability?order=4&design=fading-memory&xi=0.7")
    gains = Experiment.from_dict({"order": 4, "xi": 0.7, "design": "fading-memory"}).gains()
    rows = page.locator("#stability-jury tr")
    table = jury_table(characteristic_polynomial(gains))
    assert rows.count() == len(table)
    for i, condition in enumerate(table):
        cells = rows.nth(i).locator("th, td").all_inner_texts()
        assert cells[0] == condition.text
        assert cells[2:] == [significant(condition.margin, 4), "holds"]
    assert page.locator("#stability-conditions tr").count() == 6
    assert page.locator("#stability-printed tr").count() == 8


def test_plane_background_and_input_are_chosen_and_linked(open_page, plot, settle):
    page = open_page("stability?order=4&design=fading-memory&xi=0.7")
    for name, value in (("plane", "gamma-eta"), ("background", "noise"), ("input", "ramp")):
        page.select_option(f"#stability-{name}", value)
    settle(page)
    assert plot(page, "map").line(stability_map.POINT)[0] == pytest.approx([2 * 0.3**3 * 1.7])
    levels = page.evaluate(
        f"""() => document.querySelector('#stability-map .js-plotly-plot')._fullData[{stability_map.BACKGROUND}].z
        .flat().filter(Number.isFinite).length"""
    )
    assert levels > 500
    assert plot(page, "response").line(0)[1][-1] > 20
    other = open_page(page.url.split("/", 3)[3])
    assert other.input_value("#stability-plane") == "gamma-eta"
    assert plot(other, "map").line(0) == plot(page, "map").line(0)
    # Another order does not have this plane.
    other.select_option("#stability-order", "2")
    settle(other)
    assert other.input_value("#stability-plane") == "alpha-beta"


def test_limits_shade_what_they_forbid_and_errors_stand_beside_them(open_page, settle):
    page = open_page(ORDER2)
    count = f"""() => document.querySelector('#stability-map .js-plotly-plot')._fullData[{stability_map.FORBIDDEN}].z
      .flat().filter(v => v === 1).length"""
    assert page.evaluate(count) == 0
    page.fill("#stability-limit_noise", "0.5")
    page.press("#stability-limit_noise", "Enter")
    settle(page)
    some = page.evaluate(count)
    assert some > 300
    page.fill("#stability-limit_overshoot", "5")
    page.press("#stability-limit_overshoot", "Enter")
    settle(page)
    assert page.evaluate(count) > some
    assert "limit_noise=0.5&limit_overshoot=5" in page.url
    page.fill("#stability-limit_lag", "-1")
    page.press("#stability-limit_lag", "Enter")
    expect(page.locator("#stability-limit_lag-error")).to_contain_text("Greatest lag must be a finite number > 0")
    page.fill("#stability-limit_lag", "")
    page.press("#stability-limit_lag", "Enter")
    settle(page)
    expect(page.locator("#stability-limit_lag-error")).to_be_empty()


def test_the_knob_moves_along_the_optimal_filters(open_page, plot, settle):
    page = open_page("stability")
    expect(page.locator("#stability-distance")).to_contain_text("% more error variance than optimal")
    page.focus("#stability-responsiveness-slider")
    page.keyboard.press("PageUp")
    settle(page)
    assert page.input_value("#stability-design") == "steady-kalman"
    expect(page.locator("#stability-distance")).to_have_text("optimal")
    smooth = plot(page, "map").meta["gains"][0]
    page.keyboard.press("End")
    settle(page)
    assert plot(page, "map").meta["gains"][0] > smooth
    assert page.input_value("#stability-tracking_index") == "100"


def test_undo_and_redo_go_through_what_the_page_showed(open_page, plot, settle):
    page = open_page(ORDER2)
    expect(page.locator("#undo")).to_be_disabled()
    page.focus(MAP)
    page.keyboard.press("ArrowRight")
    settle(page)
    page.select_option("#stability-order", "3")
    settle(page)
    page.click("#undo")
    settle(page)
    assert shown_gains(page, 2) == pytest.approx([0.61, 0.3])
    page.keyboard.press("Control+z")
    settle(page)
    assert shown_gains(page, 2) == [0.6, 0.3]
    assert plot(page, "map").meta["gains"] == [0.6, 0.3]
    expect(page.locator("#undo")).to_be_disabled()
    page.keyboard.press("Control+Shift+Z")
    settle(page)
    page.click("#redo")
    settle(page)
    assert page.input_value("#stability-order") == "3"
    expect(page.locator("#redo")).to_be_disabled()


def test_the_pages_share_the_filter(open_page, plot, settle):
    page = open_page(ORDER2)
    page.focus(MAP)
    page.keyboard.press("ArrowUp")
    settle(page)
    page.click("#to-explore")
    page.wait_for_selector("#explore[data-state=settled]")
    assert plot(page, "path").meta["gains"] == [0.6, 0.31]
    expect(page.locator("#to-explore")).to_have_attribute("aria-current", "page")
    page.click("#to-stability")
    page.wait_for_selector("#stability[data-state=settled]")
    assert plot(page, "map").meta["gains"] == [0.6, 0.31]
    assert page.title() == "Gainscope: stability you can take hold of"


def test_handles_stay_on_their_points_when_plots_are_zoomed_and_resized(open_page):
    page = open_page(ORDER2)
    page.evaluate(
        """() => Plotly.relayout(document.querySelector('#stability-map .js-plotly-plot'),
        {'xaxis.range': [0.4, 0.8], 'yaxis.range': [0, 1]})"""
    )
    assert middle(page.locator(MAP)) == pytest.approx(to_pixels(page, "stability-map", (0.6, 0.3)), abs=1)
    page.set_viewport_size({"width": 1100, "height": 900})
    page.wait_for_function(
        """() => {const gd = document.querySelector('#stability-map .js-plotly-plot');
        return Math.abs(gd._fullLayout.width - gd.clientWidth) < 2}"""
    )
    page.wait_for_timeout(300)
    assert middle(page.locator(MAP)) == pytest.approx(to_pixels(page, "stability-map", (0.6, 0.3)), abs=1)
    page.evaluate(
        """() => Plotly.relayout(document.querySelector('#stability-map .js-plotly-plot'), {'xaxis.range': [1, 2]})"""
    )
    # Outside, it stands at the edge.
    left = to_pixels(page, "stability-map", (1, 0.3))
    assert middle(page.locator(MAP)) == pytest.approx(left, abs=1)
    expect(page.locator(MAP)).to_have_attribute("data-outside", "yes")


def test_it_looks_right_at_every_width_in_both_themes(open_page, check_look):
    check_look(open_page("stability?order=2&design=manual&alpha=1.9&beta=1&background=noise"))
