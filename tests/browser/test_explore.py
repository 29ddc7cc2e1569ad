"""The Explore page in a real browser."""

from __future__ import annotations

import math

import pytest
from playwright.sync_api import expect

from benchmarks.delay import Delay
from layouts.theme import tokens
from tracker_core import Experiment, run_experiment
from tracker_core.papers import papers

PLOTS = ("path", "close-up", "time", "error", "stability")
GAINS = ("alpha", "beta", "gamma", "eta", "xi", "tracking_index")


def test_every_id_stands_once(open_page):
    page = open_page()
    twice = page.evaluate(
        """() => {const ids = [...document.querySelectorAll('#explore [id]')].map(e => e.id)
        .filter(id => id.startsWith('explore')); return ids.filter((id, i) => ids.indexOf(id) !== i)}"""
    )
    assert twice == []


def drag(page, name, shares):
    """Drag a slider with the mouse over positions given as shares of its length."""
    slider = page.locator(f"#explore-{name}-slider")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + shares[0] * box["width"], y)
    page.mouse.down()
    for share in shares:
        page.mouse.move(box["x"] + share * box["width"], y)
    page.mouse.up()


def enter(page, name, text):
    """Type into a box and press Enter."""
    page.fill(f"#explore-{name}", text)
    page.press(f"#explore-{name}", "Enter")


def test_the_first_view_shows_a_run_before_anything_is_touched(open_page, plot):
    page = open_page()
    for name in PLOTS:
        assert plot(page, name).meta["stable"]
    for trace in range(4):
        x, y = plot(page, "path").line(trace)
        assert len(x) == len(y) > 300
    result = run_experiment(Experiment.from_dict({}))
    assert page.inner_text('[data-metric="tracking_total"] .metric-value') == f"{result.metrics.tracking_total:,.0f} m"
    expect(page.locator("#explore-status")).to_contain_text("Stable")


def test_dragging_xi_moves_gains_and_plots_and_the_last_value_wins(open_page, plot, settle):
    page = open_page()
    before = plot(page, "path").outline(3)
    drag(page, "xi", [0.64 + 0.02 * math.sin(i) + i / 200 for i in range(40)])
    settle(page)
    xi = float(page.input_value("#explore-xi"))
    assert xi > 0.7
    for name in PLOTS:
        alpha, beta, gamma = plot(page, name).meta["gains"]
        assert alpha == pytest.approx(1 - xi**3, abs=1e-12)
        assert beta == pytest.approx(1.5 * (1 - xi) ** 2 * (1 + xi), abs=1e-12)
        assert gamma == pytest.approx((1 - xi) ** 3, abs=1e-12)
    assert float(page.input_value("#explore-alpha")) == pytest.approx(1 - xi**3, rel=1e-4)
    assert plot(page, "path").outline(3) != before
    expected = run_experiment(Experiment.from_dict({"xi": xi}))
    drawn = plot(page, "path").line(3)
    assert drawn[0][500] == pytest.approx(expected.track.smoothed[500, 0, 0], rel=1e-6)
    assert page.url.endswith(f"?xi={xi}")


def test_on_a_slow_line_many_values_are_drawn_and_the_last_one_wins(open_page, plot, settle, port):
    with Delay(port, 0.08) as line:
        page = open_page(at=line.port)
        page.evaluate(
            """() => {window.seen = new Set();
            const page = document.getElementById('explore');
            new MutationObserver(() => window.seen.add(page.dataset.gains))
              .observe(page, {attributes: true, attributeFilter: ['data-seq']})}"""
        )
        drag(page, "xi", [0.3 + i / 300 for i in range(120)])
        settle(page)
        assert page.evaluate("() => window.seen.size") >= 5
        xi = float(page.input_value("#explore-xi"))
        assert plot(page, "path").meta["gains"][0] == pytest.approx(1 - xi**3, abs=1e-12)
        page.close()


def test_while_a_slider_moves_the_lines_follow_before_plotly_redraws(open_page, plot):
    page = open_page()
    path = plot(page, "path")
    before, meta = path.outline(3), path.meta
    page.evaluate(
        """() => {const gd = document.querySelector('#explore-path .js-plotly-plot');
        const line = gd.querySelector('.scatterlayer .trace' + gd._fullData[3].uid + ' .js-line');
        new MutationObserver(() => window.first ||= [gd._fullLayout.meta.seq, line.getAttribute('d')])
          .observe(line, {attributes: true})}"""
    )
    page.focus("#explore-xi-slider")
    page.keyboard.press("PageDown")
    page.wait_for_function("() => window.first")
    seq, outline = page.evaluate("() => window.first")
    assert seq == meta["seq"]
    assert outline != before


def test_moving_a_computed_gain_makes_the_design_manual_and_says_so(open_page, settle):
    page = open_page()
    drag(page, "beta", [0.3, 0.35, 0.4])
    settle(page)
    assert page.input_value("#explore-design") == "manual"
    expect(page.locator("#explore-note")).to_contain_text("You moved β: the design is now Manual.")
    drag(page, "xi", [0.6, 0.5])
    settle(page)
    assert page.input_value("#explore-design") == "fading-memory"


def test_changing_the_convention_rewrites_the_numbers_and_leaves_the_filter(open_page, plot, settle):
    page = open_page("?order=4&design=fading-memory&xi=0.8")
    before = plot(page, "path").line(3)
    gamma, eta = (float(page.input_value(f"#explore-{name}")) for name in ("gamma", "eta"))
    page.select_option("#explore-convention", "taylor")
    settle(page)
    assert float(page.input_value("#explore-gamma")) == pytest.approx(gamma / 2, rel=1e-3)
    assert float(page.input_value("#explore-eta")) == pytest.approx(eta / 6, rel=1e-3)
    assert plot(page, "path").line(3) == before


def test_the_link_gives_the_same_numbers_in_another_browser(open_page, plot, settle):
    page = open_page()
    drag(page, "gamma", [0.3, 0.33, 0.36])
    enter(page, "noise_std", "12, 7.5")
    page.click("#explore-new-seed")
    page.select_option("#explore-quantity", "velocity")
    settle(page)
    other = open_page(page.url[page.url.index("?") :])
    for each in (page, other):
        each.click("#explore-numbers-details summary")
        each.wait_for_selector("#explore-numbers table")
        settle(each)
    assert other.inner_text("#explore-numbers") == page.inner_text("#explore-numbers")
    assert plot(other, "path").line(3) == plot(page, "path").line(3)
    assert plot(other, "time").line(3) == plot(page, "time").line(3)
    assert other.url == page.url


def test_a_bad_link_falls_back_and_says_so(open_page):
    page = open_page("?alpha=lots&speed=3&samples=2")
    note = page.inner_text("#explore-note")
    for text in ("alpha", "'lots'", "speed", "samples must be a whole number >= 3", "the default is used"):
        assert text in note
    assert page.input_value("#explore-samples") == "1000"


def test_zoom_is_kept_while_sliders_move(open_page, plot, settle):
    page = open_page()
    page.evaluate(
        """() => Plotly.relayout(document.querySelector('#explore-path .js-plotly-plot'),
        {'xaxis.range': [5000, 9000], 'yaxis.range': [-1000, 1000]})"""
    )
    before = [plot(page, "path").range(axis) for axis in "xy"]
    drag(page, "xi", [0.6, 0.65, 0.7])
    settle(page)
    assert [plot(page, "path").range(axis) for axis in "xy"] == before
    assert before[0][0] > 3000


def test_bad_input_is_answered_beside_the_field_and_the_plot_stays(open_page, plot, settle):
    page = open_page()
    before = plot(page, "path").line(3)
    for name, text, said in (
        ("interval", "0", "T must be a finite number >= 1e-06"),
        ("samples", "2", "n must be a whole number >= 3 and <= 200,000, got “2”."),
        ("noise_std", "-1", "σ must be a finite number >= 0"),
        ("noise_std", "1, 2, 3", "σ must be one number, or 2 for the axes x, y"),
        ("xi", "1", "ξ must be a finite number >= 0 and < 1, got “1”."),
        ("seed", "x", "Seed must be a whole number"),
    ):
        good = page.input_value(f"#explore-{name}")
        enter(page, name, text)
        message = page.locator(f"#explore-{name}-error")
        expect(message).to_contain_text(said)
        expect(page.locator(f"#explore-{name}")).to_have_attribute("aria-invalid", "true")
        assert page.input_value(f"#explore-{name}") == text
        assert plot(page, "path").line(3) == before
        # What was refused is no step: the one before it is the last good state.
        page.click("#undo")
        expect(message).to_be_empty()
        settle(page)
        assert page.input_value(f"#explore-{name}") == good
        assert plot(page, "path").line(3) == before
    expect(page.locator("#undo")).to_be_disabled()


def test_leaving_the_stable_region_is_said_with_the_sample_of_the_stop(open_page, settle):
    page = open_page("?order=2&design=manual&alpha=1.5&beta=0.5")
    page.focus("#explore-beta-slider")
    page.keyboard.press("End")
    settle(page)
    status = page.inner_text("#explore-status")
    result = run_experiment(
        Experiment.from_dict({"order": 2, "alpha": 1.5, "beta": float(page.input_value("#explore-beta"))})
    )
    assert "Unstable: 4 − 2α − β > 0 fails by 3.00" in status
    assert f"stopped at sample {result.track.stopped_at + 1}:" in status
    assert page.inner_text('[data-metric="tracking_total"] .metric-value') == "–"


def test_the_runs_of_the_papers_are_one_choice_away(open_page, settle):
    page = open_page()
    for paper in papers().values():
        # Of each document one run with every filter: the others differ in numbers alone.
        for run in {(run.experiment.design, run.experiment.order): run for run in reversed(paper.runs)}.values():
            page.select_option("#explore-preset", f"{paper.name}/{run.name}")
            settle(page)
            total = run_experiment(run.experiment).metrics.tracking_total
            shown = page.inner_text('[data-metric="tracking_total"] .metric-value')
            assert float(shown.removesuffix(" m").replace(",", "")) == pytest.approx(total, rel=5e-4), run.title
            assert "stable: the largest pole" in page.inner_text("#explore-status").lower()


def test_the_keyboard_reaches_and_moves_every_slider(open_page, settle):
    page = open_page("?order=4&design=manual&alpha=0.7&beta=0.3&gamma=0.06&eta=0.004")
    page.focus("#explore-design")
    reached = set()
    for _ in range(80):
        page.keyboard.press("Tab")
        name = page.evaluate("() => document.activeElement.type === 'range' ? document.activeElement.id : ''")
        if not name:
            continue
        reached.add(name)
        before = page.input_value(f"#{name}")
        page.keyboard.press("ArrowRight")
        assert page.input_value(f"#{name}") != before
        assert page.evaluate("() => document.activeElement.getAttribute('aria-label')")
        assert page.evaluate("() => document.activeElement.getAttribute('aria-valuetext')")
    assert reached == {f"explore-{name}-slider" for name in (*GAINS, "responsiveness", "at")}
    settle(page)


def test_boxes_take_arrow_keys_in_their_last_digit(open_page, settle):
    page = open_page()
    page.focus("#explore-xi")
    page.keyboard.press("ArrowUp")
    settle(page)
    assert page.input_value("#explore-xi") == "0.65"
    assert page.url.endswith("?xi=0.65")
    # What a slider has just moved is taken back, answered or not, and nothing before it.
    page.focus("#explore-xi-slider")
    page.keyboard.press("PageDown")
    page.keyboard.press("Control+z")
    settle(page)
    assert page.url.endswith("?xi=0.65")
    page.keyboard.press("Control+y")
    page.wait_for_function("() => document.querySelector('#explore-xi').value !== '0.65'")
    settle(page)
    assert page.url.endswith(f"?xi={page.input_value('#explore-xi')}")


def test_pinning_shows_every_change_until_unpinned(open_page, settle):
    page = open_page()
    page.click("#explore-pin")
    expect(page.locator('[data-metric="lag"] .metric-change')).to_have_text("no change")
    drag(page, "xi", [0.64, 0.5])
    settle(page)
    change = page.locator('[data-metric="lag"] .metric-change')
    expect(change).to_contain_text("−")
    expect(change).to_have_attribute("data-tone", "better")
    page.click("#explore-pin")
    settle(page)
    xi = page.input_value("#explore-xi")
    assert page.url.endswith(f"?xi={xi}&pin1=fading-memory,xi:0.64&pin2=fading-memory,xi:{xi}")
    expect(page.locator("#explore-since")).to_contain_text("since Fading memory ξ 0.49")
    page.click("#explore-unpin")
    expect(page.locator("#explore-since")).to_have_text("since Fading memory ξ 0.64")
    page.click("#explore-unpin")
    expect(change).to_be_empty()
    assert page.evaluate("() => document.activeElement.id") == "explore-pin"
    settle(page)
    assert "pin" not in page.url
    page.click("#undo")
    settle(page)
    assert page.url.endswith(f"?xi={xi}&pin1=fading-memory,xi:0.64")


def test_the_sample_slider_and_a_click_on_a_plot_move_the_close_up(open_page, plot, settle):
    page = open_page()
    page.focus("#explore-at-slider")
    page.keyboard.press("Home")
    settle(page)
    assert plot(page, "close-up").line(1)[0][0] == pytest.approx(plot(page, "path").line(1)[0][0], abs=0.25)
    at, said = page.locator("#explore-at"), page.locator("#explore-at-text")
    expect(said).to_have_text("of 1,000, 0 s")
    # Every sample of a short run and of a long one is reached.
    for samples, leap in (("10", 2), ("8000", 800)):
        enter(page, "samples", samples)
        settle(page)
        page.focus("#explore-at-slider")
        page.keyboard.press("Home")
        for key, number in (("ArrowRight", 2), ("PageUp", 2 + leap), ("ArrowLeft", 1 + leap), ("PageDown", 1)):
            page.keyboard.press(key)
            expect(at).to_have_value(str(number))
            assert page.input_value("#explore-at-slider") == str(number - 1)
    enter(page, "at", "4567")
    expect(said).to_have_text("of 8,000, 13,698 s")
    enter(page, "at", "8001")
    expect(page.locator("#explore-at-error")).to_contain_text("The sample must be a whole number >= 1 and <= 8,000")
    enter(page, "at", "1")
    settle(page)
    frame = page.locator("#explore-time .nsewdrag").bounding_box()
    page.mouse.move(frame["x"] + frame["width"] / 2, frame["y"] + frame["height"] / 2)
    page.wait_for_selector("#explore-time .hoverlayer .hovertext")
    page.mouse.click(frame["x"] + frame["width"] / 2, frame["y"] + frame["height"] / 2)
    expect(at).not_to_have_value("1")
    settle(page)
    assert page.url.endswith(f"at={page.input_value('#explore-at')}")


def test_without_a_socket_sliders_work_through_callbacks(open_page, plot, settle):
    def refuse(page):
        page.route_web_socket("**/explore/live", lambda socket: socket.close())

    page = open_page(first=refuse)
    drag(page, "xi", [0.6, 0.5, 0.4])
    settle(page)
    xi = float(page.input_value("#explore-xi"))
    assert plot(page, "error").meta["gains"][0] == pytest.approx(1 - xi**3, abs=1e-12)


def test_one_axis_and_recorded_ranges(open_page, plot, settle):
    page = open_page("?scenario=garg-constant-velocity")
    assert [round(value, 1) for value in plot(page, "path").line(3)[1]] == pytest.approx(
        [30194.2, 30383.6, 30612.7, 30818.9, 31025.7, 31242.3, 31418.8, 31566.3, 31739.4, 31964.1], abs=0.06
    )
    options = page.evaluate(
        "() => [...document.querySelector('#explore-axis').options].filter(o => !o.disabled).map(o => o.value)"
    )
    assert options == ["range"]


def test_explanations_come_to_pointer_and_keyboard_and_go_by_escape(open_page):
    page = open_page("?samples=60", size=(360, 740))
    bubble, sentence = page.locator(".bubble"), "How many measurements are taken."
    for control in ("explore-samples", "explore-start", "explore-xi-slider"):
        about = page.locator(f"#{control.removesuffix('-slider')}-about").text_content()
        expect(page.locator(f"#{control}")).to_have_accessible_description(about)
    # The keyboard has it above its field.
    page.focus("#explore-scenario")
    expect(bubble).to_be_hidden()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Tab")
    expect(bubble).to_have_text("The target and its true motion, or your own recording.")
    page.keyboard.press("Escape")
    expect(bubble).to_be_hidden()
    # The pointer may go to it, and loses it elsewhere.
    page.clock.install()
    label = page.locator('label[for="explore-samples"]')
    label.hover()
    expect(bubble).to_have_text(sentence)
    box = bubble.bounding_box()
    assert box["y"] + box["height"] <= label.bounding_box()["y"]
    page.mouse.move(box["x"] + 8, box["y"] + 8)
    page.clock.fast_forward(1000)
    expect(bubble).to_have_text(sentence)
    page.mouse.move(1, 1)
    page.clock.fast_forward(1000)
    expect(bubble).to_be_hidden()
    label.hover()
    expect(bubble).to_be_visible()
    page.keyboard.press("Escape")
    expect(bubble).to_be_hidden()


def test_it_looks_right_at_every_width_in_both_themes(open_page, check_look):
    check_look(open_page("?order=2&design=manual&alpha=1.9&beta=1&foo=1"))


def test_on_a_phone_the_path_stays_in_sight_while_xi_moves(open_page, settle):
    page = open_page(size=(390, 844))
    page.locator("#explore-xi-slider").scroll_into_view_if_needed()
    path, slider = (page.locator(s).bounding_box() for s in ("#explore-path", "#explore-xi-slider"))
    assert -10 <= path["y"] < 200
    assert slider["y"] > path["y"] + path["height"]
    assert slider["y"] + slider["height"] <= 844
    # The keyboard goes as the eye does: from the header to the path, which stands above the controls.
    page.focus("#theme-switch")
    page.keyboard.press("Tab")
    assert page.evaluate("() => document.activeElement.id") == "explore-exaggerate"


def test_the_theme_follows_the_switch_and_is_remembered(open_page, plot, settle):
    page = open_page()
    page.click("#theme-switch")
    settle(page)
    assert page.evaluate("() => document.documentElement.dataset.theme") == "dark"
    for name in PLOTS:
        assert plot(page, name).meta["theme"] == "dark"
    colour = page.evaluate("() => document.querySelector('#explore-path .js-plotly-plot')._fullLayout.paper_bgcolor")
    assert colour == tokens("dark")["surface"]
    page.reload()
    settle(page)
    assert plot(page, "path").meta["theme"] == "dark"
    # A refused entry stays, in either theme.
    enter(page, "samples", "2")
    expect(page.locator("#explore-samples-error")).not_to_be_empty()
    page.click("#theme-switch")
    for name in PLOTS:
        page.wait_for_function(
            "name => document.querySelector(`#explore-${name} .js-plotly-plot`)._fullLayout.meta.theme === 'light'",
            arg=name,
        )
    expect(page.locator("#explore-samples-error")).not_to_be_empty()


ANSWERS = """() => {
  const {fetch} = window;
  window.asked = [];
  window.answers = [];
  window.fetch = (...all) => {
    if (!String(all[0]).includes("_dash-update-component")) return fetch(...all);
    window.asked.push(JSON.parse(all[1].body).inputs[0].value);
    return (window.answers.shift() ?? fetch)(...all);
  };
}"""
"""Answers in the place of the server's, the next one first; before the page's own scripts."""


def test_an_answer_that_takes_long_is_waited_for_and_one_that_is_lost_is_asked_for_again(open_page, settle):
    held, ways = [], []

    def route(socket):
        ways.append(socket.connect_to_server())
        # Playwright writes on the function.
        socket.on_message(lambda message: held.append(message))  # noqa: PLW0108

    def prepare(page):
        page.clock.install()
        page.add_init_script(f"({ANSWERS})()")
        page.route_web_socket("**/explore/live", route)

    page = open_page(first=prepare)
    asked, note = "() => window.asked.map(each => each.changed)", page.locator("#explore-note")
    before = page.evaluate(asked)
    page.evaluate("() => window.answers.push(() => Promise.reject(new TypeError('gone')), () => new Promise(() => {}))")
    enter(page, "beta", "0.4")
    expect(note).to_have_text("The server does not answer: it cannot be reached; trying again.")
    page.clock.fast_forward(3000)
    page.wait_for_function("count => window.asked.length === count", arg=len(before) + 2)
    # As long as the server may take, nothing else is asked, whatever is moved.
    page.clock.fast_forward(20_000)
    enter(page, "seed", "5")
    page.clock.fast_forward(10_000)
    assert page.evaluate(asked) == [*before, ["beta"], ["beta"]]
    page.clock.fast_forward(6000)
    settle(page)
    assert page.evaluate(asked)[: len(before) + 3] == [*before, ["beta"], ["beta"], ["beta", "seed"]]
    assert page.input_value("#explore-design") == "manual"
    assert page.input_value("#explore-beta") == "0.4"
    assert page.input_value("#explore-seed") == "5"
    expect(note).to_contain_text("You moved β")
    # Of a question that has been asked twice the first answer is taken, whichever way it comes.
    page.evaluate("() => {window.asked = []; window.answers.push(() => new Promise(() => {}))}")
    page.focus("#explore-xi-slider")
    page.keyboard.press("ArrowRight")
    page.clock.fast_forward(36_000)
    page.wait_for_function("() => window.asked.length === 1")
    ways[0].send(held[0])
    settle(page)
    assert page.url.endswith(f"xi={page.input_value('#explore-xi')}")


BOUNDS = """() => Object.fromEntries(['path', 'close-up', 'time', 'error', 'stability'].map(name => {
  const gd = document.querySelector(`#explore-${name} .js-plotly-plot`);
  return [name, gd._fullData.map(trace => {
    const group = trace.uid && gd.querySelector('.scatterlayer .trace' + trace.uid);
    const line = group && group.querySelector('.js-line, .point');
    if (!line) return null;
    const box = line.getBBox(), at = line.transform.baseVal.consolidate();
    const [x, y] = at ? [at.matrix.e, at.matrix.f] : [0, 0];
    return [box.x + x, box.y + y, box.x + box.width + x, box.y + box.height + y];
  })];
}))"""


@pytest.mark.parametrize(
    "query", ["", "?order=2&design=manual&alpha=0.6&beta=0.3", "?scenario=garg-accelerating", "?quantity=acceleration"]
)
def test_what_is_drawn_during_a_drag_lies_where_plotly_draws_it(open_page, settle, query):
    page = open_page(query)
    slider = page.locator("#explore-alpha-slider")
    box = slider.bounding_box()
    x, y = box["x"] + box["width"] * 0.3, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    # Several steps to one value, since the plots take turns; then the lines as they are before plotly redraws them.
    page.evaluate(
        f"""() => {{window.live = {{}}; const seen = {BOUNDS};
        const page = document.getElementById('explore');
        new MutationObserver(() => window.live[page.dataset.seq] = seen())
          .observe(page, {{attributes: true, attributeFilter: ['data-seq']}})}}"""
    )
    for step in (1, 2, 1, 2, 1, 2, 1):
        page.mouse.move(x + step, y)
        page.wait_for_timeout(60)
    page.mouse.up()
    settle(page)
    rest, live = page.evaluate(BOUNDS), page.evaluate("() => window.live")
    path = [moment["path"][3] for moment in live.values()]
    assert any(boxes == pytest.approx(rest["path"][3], abs=1) for boxes in path[:-5])
    for name in rest:
        for trace, place in enumerate(rest[name]):
            if place is not None:
                drawn = [moment[name][trace] for moment in live.values() if moment[name][trace] is not None]
                assert any(boxes == pytest.approx(place, abs=1.5) for boxes in drawn), (name, trace)


def test_a_refused_entry_is_not_asked_again_and_again(open_page):
    page = open_page("?order=2&design=benedict-bordner&alpha=0.8")
    asked = []
    page.on("request", lambda request: asked.append(request.url) if "_dash-update" in request.url else None)
    page.focus("#explore-alpha-slider")
    page.keyboard.press("End")
    expect(page.locator("#explore-alpha-error")).to_contain_text("α must be a finite number > 0 and < 2")
    page.wait_for_function("() => document.querySelector('#explore').dataset.state === 'settled'")
    page.wait_for_timeout(1000)
    assert len(asked) <= 3


def test_what_is_typed_last_is_what_is_pinned_and_linked(open_page, settle):
    page = open_page()
    page.fill("#explore-xi", "0.7")
    page.click("#explore-pin")
    settle(page)
    assert page.url.endswith("?xi=0.7&pin1=fading-memory,xi:0.7")


def test_edits_after_a_preset_win_over_it(open_page, settle, port):
    with Delay(port, 0.4) as line:
        page = open_page(at=line.port)
        page.select_option("#explore-preset", "garg2021/constant-velocity")
        enter(page, "alpha", "0.6")
        settle(page)
        assert page.input_value("#explore-alpha") == "0.6"
        assert page.input_value("#explore-scenario") == "garg-constant-velocity"
        page.close()


def test_the_skip_link_leads_to_the_page_and_leaves_it(open_page, plot):
    page = open_page()
    seq = plot(page, "path").meta["seq"]
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    assert page.evaluate("() => document.activeElement.id") == "main"
    assert plot(page, "path").meta["seq"] == seq
