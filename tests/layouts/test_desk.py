"""What every page does with an entry that is refused, and with a link that grows long."""

from dataclasses import replace

import pytest
from dash import no_update

from layouts.desk import TOO_LONG, answer
from layouts.pages.compare.answers import DESK as COMPARE
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.state import LINK_LIMIT
from layouts.theme import tokens

REFUSED = {"xi": "lots"}
LIGHT = dict.fromkeys(EXPLORE.plots, "light|")


def ask(request_for, controls, **more):
    """The plots of Explore by name, and the rest of the answer; xi is refused."""
    updates, rest = answer(EXPLORE, request_for(controls, REFUSED, **more))
    assert list(rest["errors"]) == ["xi"]
    return dict(zip(EXPLORE.plots, updates, strict=False)), rest


@pytest.mark.parametrize("link", ["", "samples=60&xi=0.3&at=7"])
def test_a_refused_entry_leaves_the_plots_but_in_the_theme_of_the_page(controls_for, request_for, link):
    values = {"samples": 60, "xi": 0.3} if link else {}
    controls = controls_for(**values)
    plots, rest = ask(request_for, controls, theme="dark", drawn=LIGHT, link=link)
    usual, good = answer(EXPLORE, request_for(controls | ({"at": 7} if link else {}), theme="dark"))
    assert plots == dict(zip(EXPLORE.plots, usual, strict=False))
    assert plots["explore-path"]["layout"]["template"]["layout"]["paper_bgcolor"] == tokens("dark")["surface"]
    # The controls stay as they were entered.
    assert rest["controls"]["xi"] == "lots"
    assert rest["drawn"] == {name: good["drawn"][name] for name in EXPLORE.plots}


@pytest.mark.parametrize(
    "more",
    [
        {"drawn": LIGHT, "link": "samples=60"},
        {"drawn": LIGHT, "theme": "dark"},
        {"theme": "dark", "link": "samples=60"},
        # What is shown cannot be run any more: nothing else is drawn in its place.
        {"drawn": LIGHT, "theme": "dark", "link": f"data={'0' * 32}"},
    ],
    ids=["the same theme", "no link", "nothing drawn", "a recording that is gone"],
)
def test_where_there_is_nothing_to_draw_anew_nothing_is(controls_for, request_for, more):
    plots, rest = ask(request_for, controls_for(), **more)
    assert (set(map(id, plots.values())), rest["drawn"]) == ({id(no_update)}, {})


def test_a_scene_is_shown_in_the_other_theme_as_well(controls_for, request_for):
    seen, token = [], "0" * 32
    desk = replace(EXPLORE, picture=lambda shown: shown.theme, show=lambda *shown: seen.append(shown))
    question = request_for(controls_for(), REFUSED, theme="dark", drawn=LIGHT, link="samples=60", scene=token)
    answer(desk, question)
    assert seen == [(token, "dark")]


@pytest.mark.parametrize(("theme", "is_long"), [("light", False), ("dark", True)])
def test_drawing_anew_holds_nobody_up(controls_for, request_for, theme, is_long):
    # However long the run is that the page shows: the samples that were entered are not those.
    question = request_for(controls_for(), {"samples": "many"}, theme=theme, drawn=LIGHT, link="samples=200000")
    assert question.is_long == is_long


@pytest.mark.parametrize(("letters", "said"), [(2, False), (40, True)])
def test_a_link_that_some_programs_cut_short_is_told(controls_for, request_for, letters, said):
    pins = [[slot, f"fading-memory,xi:0.{slot},name:{'漢' * letters}"] for slot in range(1, 7)]
    _, rest = answer(COMPARE, request_for(controls_for(samples=60), pins=pins, want=[]))
    assert (len(rest["link"]) > LINK_LIMIT) == said
    assert (TOO_LONG in rest["note"]) == said
