"""What every page with plots and sliders does: answers to a change of its controls, fast and in full.

A page declares its plots, its tables and what else it reports; the rest is the same everywhere. The counterpart in
the browser is assets/desk.js.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any
from urllib.parse import parse_qsl

from dash import Patch, dcc, no_update
from dash.development.base_component import Component

from layouts.controls import Resolution, controls_of, resolve
from layouts.figures.common import Figure, Path, coordinates, moving, moving_traces
from layouts.questions import Question, page_reader, theme_key
from layouts.readouts import common_report
from layouts.shown import Shown
from layouts.state import LINK_LIMIT, Settings, from_query
from layouts.text import error_text
from server.typed import Reader
from tracker_core import InputError, Result, run_experiment
from tracker_core.measured import DATA, known
from tracker_core.types import FloatArray


@dataclass(frozen=True, slots=True)
class Plot:
    """One plot of a page.

    Attributes:
        draw: makes its figure.
        moving: the parts of the figure that change with the gains.
        key: what must stay the same for all other parts to stay right, beside the theme.
        often: whether it follows every move of a slider; the others take turns.
    """

    draw: Callable[[Shown], Figure]
    moving: tuple[Path, ...]
    key: Callable[[Shown], str]
    often: bool = False


TOO_LONG = f"The link has more than {LINK_LIMIT:,} characters now; some programs cut such a link short."

Tables = Callable[[Result, Settings], list[Component]]


@dataclass(frozen=True, slots=True)
class Desk:
    """A page's answers.

    Attributes:
        page: prefix of its ids.
        plots: by id.
        tables: by id of the place they are put into; made only while they are looked at.
        report: what the page says beside what every page says (see `readouts.common_report`): `texts`, `cards`,
            `rows` of tables, draggable `handles` per plot, an `offer`, choices that menus `offers`, `fields` shown, the
            `filters` that are compared.
        sliders: what its sliders span.
        picture: what the page's scene in three dimensions shows of a run; None where it has none.
        show: shows a picture in the scene with a token; None where there is nobody to see it.
        beside: what the page says of its controls whether or not they can be run; None for nothing.
    """

    page: str
    plots: Mapping[str, Plot]
    tables: Mapping[str, Tables]
    report: Callable[[Shown], dict[str, Any]]
    sliders: Mapping[str, Any]
    picture: Callable[[Shown], Any] | None = None
    show: Callable[[str, Any], None] | None = None
    beside: Callable[[Mapping[str, Any]], dict[str, Any]] | None = None


def beginning(desk: Desk, query: Mapping[str, Any]) -> dict[str, Any]:
    """What the page's script starts from: the controls as a link describes them, and what the page has."""
    settings, notes = from_query({name: str(value) for name, value in query.items()})
    return {
        "page": desk.page,
        "missing": "" if settings.experiment.data else _missing(query.get("data", "")),
        "controls": controls_of(settings),
        "pins": [[pin.slot, pin.text()] for pin in settings.pins],
        "notes": notes,
        "sliders": desk.sliders,
        "often": [name for name, plot in desk.plots.items() if plot.often],
        "inTurn": [name for name, plot in desk.plots.items() if not plot.often],
        "tables": list(desk.tables),
    }


def _missing(data: Any) -> str:
    """What a recording is known by that is meant and that this server does not have; empty where there is none."""
    data = str(data or "")
    return data if DATA.fullmatch(data) and not known(data) else ""


def stores(desk: Desk, query: Mapping[str, Any]) -> list[Component]:
    """Where a page and its script meet."""
    names = ("begun", "request", "answer", "answered")
    return [
        dcc.Store(id=f"{desk.page}-beginning", data=beginning(desk, query)),
        *(dcc.Store(id=f"{desk.page}-{name}") for name in names),
    ]


def reader_of(desk: Desk) -> Reader[Question]:
    """What reads the page's questions."""
    return page_reader([*desk.plots, *desk.tables])


def drawing_keys(desk: Desk, shown: Shown) -> dict[str, str]:
    """Per plot what must stay the same for its unmoved parts to stay right."""
    return {name: theme_key(shown.theme) + plot.key(shown) for name, plot in desk.plots.items()}


def answer(desk: Desk, question: Question) -> tuple[list[Any], dict[str, Any]]:
    """What a page shows after a change of its controls.

    Args:
        desk: the page.
        question: how its controls stand, what has changed, and what it shows.

    Returns:
        One update per plot (a figure; a Patch where only lines have moved; no_update where nothing is wanted or
        something is wrong) and one per table, and the rest of the answer.
    """
    resolution = _resolution(question)
    if resolution.settings is None:
        return _kept(desk, question, resolution)
    try:
        shown = _shown(question, resolution.settings, live=False)
    except InputError as error:
        # What only the run finds out: too few measurements for the start, say.
        return _kept(desk, question, replace(resolution, errors=(error.kept(),)))
    keys, before = drawing_keys(desk, shown), question.drawn
    updates: list[Any] = []
    wanted = list(desk.plots) if question.want is None else question.want
    now: dict[str, str] = {}
    for name, plot in desk.plots.items():
        if name not in wanted:
            updates.append(no_update)
            continue
        figure = plot.draw(shown)
        updates.append(_patch(figure, plot.moving) if before.get(name) == keys[name] else figure)
        now[name] = keys[name]
    for place, tables in desk.tables.items():
        updates.append(tables(shown.result, shown.settings) if place in wanted else no_update)
        now |= {place: ""} if place in wanted else {}
    return updates, _report(desk, question, resolution, shown) | {"drawn": now}


def live_answer(desk: Desk, question: Question) -> tuple[dict[str, Any], list[FloatArray]]:
    """What moves on a page while a slider does: the readouts, and the lines of the wanted plots.

    Args:
        desk: the page.
        question: as for `answer`; a plot in `want` gets its lines only if what it shows fits them.

    Returns:
        The rest of the answer, whose `lines` say per plot which traces follow, and their coordinates: x and y of each,
        32-bit floats.
    """
    resolution = _resolution(question)
    if resolution.settings is None:
        return _refusal(desk, question, resolution), []
    try:
        shown = _shown(question, resolution.settings, live=True)
    except InputError as error:
        return _refusal(desk, question, replace(resolution, errors=(error.kept(),))), []
    keys, before = drawing_keys(desk, shown), question.drawn
    lines: dict[str, list[list[int]]] = {}
    arrays: list[FloatArray] = []
    for name, plot in desk.plots.items():
        if name not in (question.want or ()) or before.get(name) != keys[name]:
            continue
        lines[name] = []
        figure = plot.draw(shown)
        for index in moving_traces(plot.moving):
            x, y = (coordinates(figure["data"][index][axis]) for axis in ("x", "y"))
            lines[name].append([index, len(x)])
            arrays += [x, y]
    outdated = [name for name in desk.plots if before.get(name) != keys[name]]
    return _report(desk, question, resolution, shown) | {"lines": lines, "outdated": outdated}, arrays


def _resolution(question: Question) -> Resolution:
    return resolve(question.controls, question.changed, question.pins, question.pinning)


def _shown(question: Question, settings: Settings, *, live: bool) -> Shown:
    experiment, view = settings.experiment, settings.view
    result = run_experiment(experiment).at(view.cursor(experiment.samples), view.axis)
    causal = experiment.counterpart() if view.beside else None
    meta = {
        "seq": question.seq,
        "gains": list(result.gains.values),
        "stable": result.verdict.stable,
        "theme": question.theme,
    }
    beside = None if causal is None else run_experiment(causal)
    return Shown(result, settings, question.theme, meta, live, question.scene, beside)


def _kept(desk: Desk, question: Question, refused: Resolution) -> tuple[list[Any], dict[str, Any]]:
    """The answer where something is wrong: what is shown stays, drawn anew where the page has another theme now."""
    updates: list[Any] = [no_update] * (len(desk.plots) + len(desk.tables))
    now: dict[str, str] = {}
    shown = _shown_before(question) if question.otherwise_drawn() else None
    if shown is not None:
        keys = drawing_keys(desk, shown)
        now = {name: keys[name] for name in question.otherwise_drawn()}
        updates = [desk.plots[name].draw(shown) if name in now else no_update for name in (*desk.plots, *desk.tables)]
        _show_scene(desk, shown)
    return updates, _refusal(desk, question, refused) | {"drawn": now}


def _shown_before(question: Question) -> Shown | None:
    """What the page shows although something is wrong; None where it says nothing that can still be run."""
    settings, notes = from_query(dict(parse_qsl(question.link or "")))
    if question.link is None or notes:
        return None
    try:
        return _shown(question, settings, live=False)
    except InputError:
        return None


def _patch(figure: Figure, paths: tuple[Path, ...]) -> Patch:
    patch = Patch()
    for path, value in moving(figure, paths):
        part = patch
        for step in path[:-1]:
            part = part[step]
        part[path[-1]] = value
    return patch


def _refusal(desk: Desk, question: Question, resolution: Resolution) -> dict[str, Any]:
    """The last good plot stays; the messages stand beside their fields."""
    wrong = {error.field: error_text(error) for error in resolution.errors}
    return {
        "seq": question.seq,
        "ok": False,
        "controls": resolution.controls,
        "errors": wrong,
        "note": resolution.note,
        "missing": _missing(resolution.controls.get("data")) if "data" in wrong else "",
        **({} if desk.beside is None else desk.beside(resolution.controls)),
    }


def _show_scene(desk: Desk, shown: Shown) -> None:
    if desk.picture is not None and desk.show is not None and shown.scene:
        desk.show(shown.scene, desk.picture(shown))


def _report(desk: Desk, question: Question, resolution: Resolution, shown: Shown) -> dict[str, Any]:
    _show_scene(desk, shown)
    rest = common_report(shown.result, shown.settings, live=shown.live)
    own = desk.report(shown)
    for part in ("texts", "offers", "fields"):
        rest[part] |= own.pop(part, {})
    return {
        "seq": question.seq,
        "ok": True,
        "controls": resolution.controls,
        "errors": {},
        "note": " ".join(filter(None, (resolution.note, TOO_LONG if len(rest["link"]) > LINK_LIMIT else ""))),
        "cards": {},
        "rows": {},
        "handles": {},
        "filters": [],
        **rest,
        **own,
        **({} if desk.beside is None else desk.beside(resolution.controls)),
    }
