"""The Papers page: everything that is printed is on it, and what it answers is what the core recomputes."""

from __future__ import annotations

import csv
import io
from urllib.parse import parse_qsl, urlsplit

import pytest
from dash import dcc, html
from dash._utils import to_json
from dash.development.base_component import Component

from layouts.pages.papers import answers
from layouts.pages.papers.answers import COLUMNS, answer, table_csv
from layouts.pages.papers.tables import KEYS, MARKS, cell_content, reasons, table_view, value_text
from layouts.pages.papers.view import explore_link, layout, read
from layouts.state import from_query
from layouts.text import subscripts
from layouts.theme import THEMES
from tracker_core.papers import NAMES, VERDICTS, Outcome, papers, reproduce
from tracker_core.papers.printed import EMPTY
from tracker_core.papers.recipes import cells
from tracker_core.papers.reproduce import Estimate

SHAPE = {"field", "rule", "received", "message", "request"}
EVERY_PAPER = pytest.mark.parametrize("name", NAMES)
RUNS = [(paper.name, run.name) for paper in papers().values() for run in paper.runs]


def parts_of(component, kind=Component):
    """Every component inside another, itself included."""
    return [part for part in (component, *component._traverse()) if isinstance(part, kind)]


def text_of(component):
    """The text that stands in a component, without what only a reader of the screen is told."""
    if isinstance(component, str):
        return component
    if isinstance(component, list | tuple):
        return "".join(map(text_of, component))
    if not isinstance(component, Component) or getattr(component, "className", "") == "visually-hidden":
        return ""
    return text_of(getattr(component, "children", None) or "")


def said(text):
    """A text as it stands on the page, subscripts without their sign."""
    return "".join(piece for piece, _ in subscripts(text))


def asked(paper, part, **options):
    return answer(paper, part, {"theme": "light", **{name: str(value) for name, value in options.items()}})


# What stands on the page -------------------------------------------------------------------------------------------


@EVERY_PAPER
def test_every_table_figure_and_erratum_has_its_place_and_a_way_to_it(name):
    paper, page = papers()[name], layout(paper=name)
    wanted = [
        *(f"table-{table.name}" for table in paper.tables),
        *(f"figure-{figure.name}" for figure in paper.figures),
        *(f"erratum-{erratum.number}" for erratum in paper.errata),
    ]
    assert [part["data-part"] for part in map(vars, parts_of(page)) if "data-part" in part] == wanted
    assert {part.id for part in parts_of(page) if isinstance(getattr(part, "id", None), str)} >= set(wanted)
    anchors = {link.href for link in parts_of(page, html.A)}
    assert anchors >= {f"#{part}" for part in wanted}
    text = text_of(page)
    for erratum in paper.errata:
        for words in (erratum.title, erratum.claim, erratum.evidence, erratum.consequence):
            assert said(words) in text
    assert paper.citation in text


@EVERY_PAPER
def test_every_printed_cell_is_there_with_room_for_the_recomputed_one(name):
    paper = papers()[name]
    for table in paper.tables:
        rows = parts_of(table_view(table), html.Tr)[2:]
        printed = [[text_of(cell) for cell in parts_of(row, html.Td)[::2]] for row in rows]
        assert printed == [list(row.cells) for row in table.rows]
        places = [getattr(cell, "data-cell", None) for row in rows for cell in parts_of(row, html.Td)[1::2]]
        assert [place for place in places if place] == [f"{c.row.name}|{c.column.name}" for c in cells(paper, table)]


@EVERY_PAPER
def test_every_recomputed_cell_has_a_mark_that_is_spelled_out(name):
    paper = papers()[name]
    for table in paper.tables:
        for outcome in reproduce(paper, table, 2):
            content = cell_content(outcome)
            assert content["cell"] == f"{outcome.row}|{outcome.column}"
            assert content["verdict"] == KEYS[outcome.verdict]
            assert content["mark"] == MARKS[outcome.verdict] + str(outcome.erratum or "")
            assert content["said"] == outcome.said
            assert outcome.reason in content["why"]
            assert (content["interval"] == "") == (outcome.estimate is None)


def test_marks_differ_without_colour():
    assert len(set(MARKS.values())) == len(MARKS) == len(VERDICTS)
    assert list(MARKS) == list(KEYS) == list(VERDICTS)


@pytest.mark.parametrize(("paper", "run"), RUNS, ids=["-".join(ids) for ids in RUNS])
def test_open_in_explore_opens_that_run(paper, run):
    found = papers()[paper].run(run)
    link = explore_link(found)
    settings, notes = from_query(dict(parse_qsl(urlsplit(link).query)))
    assert notes == []
    assert settings.experiment == found.experiment
    links = {link.href for link in parts_of(layout(paper=paper), dcc.Link)}
    assert link in links


@pytest.mark.parametrize(
    ("query", "paper", "seeds", "said"),
    [
        ({}, "jeong2017", None, []),
        ({"paper": "yu2017", "seeds": "50"}, "yu2017", 50, []),
        ({"paper": "nobody"}, "jeong2017", None, ["paper must be one of"]),
        ({"paper": "garg2021", "seeds": "0"}, "garg2021", None, ["seeds must be a whole number"]),
        ({"seeds": "1e7"}, "jeong2017", None, ["seeds must be a whole number"]),
        ({"order": "3"}, "jeong2017", None, []),
    ],
)
def test_links_are_read_and_what_is_wrong_is_said(query, paper, seeds, said):
    found, runs, notes = read(query)
    assert (found.name, runs) == (paper, seeds)
    assert len(notes) == len(said)
    assert all(note.startswith(start) for note, start in zip(notes, said, strict=True))
    assert all(note in text_of(layout(**query)) for note in notes)


@EVERY_PAPER
def test_every_reason_is_said_once_and_names_its_cells(name):
    paper = papers()[name]
    for table in paper.tables:
        outcomes = reproduce(paper, table, 2)
        listed = reasons(table, outcomes)
        assert len({(each["said"], each["text"]) for each in listed}) == len(listed)
        for each in listed:
            of = [o for o in outcomes if o.said == each["said"] and o.reason.endswith(each["text"])]
            assert of
            assert (each["where"] == "") == (len(of) > 3)
        # What is left out stands under the table already.
        assert not any(table.left_out and table.left_out in each["text"] for each in listed)
        erratum = {each["said"] for each in listed if each["verdict"] == "erratum"}
        assert erratum == {o.said for o in outcomes if o.erratum is not None}


# Numbers -----------------------------------------------------------------------------------------------------------


def outcome(printed, value, estimate=None):
    return Outcome("row", "column", printed, value, estimate, None, "exact", None, "")


@pytest.mark.parametrize(
    ("printed", "value", "runs", "shown"),
    [
        ("0.5277", 0.527657, False, "0.5277"),
        ("3101.8", 3101.8098, False, "3,101.8"),
        ("-2.3659", -2.36594, False, "−2.3659"),
        ("4.4409 × 10⁻¹⁶", 0.0, False, "0"),
        ("8.0670e-008", 8.067e-8, False, "8.067e−8"),
        ("26,326", 23314.1, True, "23,314"),
        ("28.4589", 35.48123, True, "35.48"),
        ("0.62", 0.61, True, "0.61"),
        ("1", 1.0, True, "1"),
        ("2.5829e-006", 3.832e-6, True, "3.832e−6"),
    ],
)
def test_recomputed_numbers_have_the_digits_that_mean_something(printed, value, runs, shown):
    estimate = Estimate(value, value, value, 0.9, 20) if runs else None
    assert value_text(outcome(printed, value, estimate)) == shown


# What it answers ---------------------------------------------------------------------------------------------------


def test_a_table_comes_in_steps_and_ends_with_what_the_core_says(monkeypatch):
    monkeypatch.setattr(answers, "_REMEMBERED", {})
    monkeypatch.setattr(answers, "AT_ONCE", 0)
    seen = [asked("yu2017", "table-1", wanted=9)]
    monkeypatch.setattr(answers, "AT_ONCE", 10)
    seen.append(asked("yu2017", "table-1", wanted=5))
    seen.append(asked("yu2017", "table-1", wanted=9))
    assert [(each["runs"], each["wanted"]) for each in seen] == [(1, 9), (5, 5), (9, 9)]
    # What has been run is there at once.
    monkeypatch.setattr(answers, "AT_ONCE", 0)
    assert asked("yu2017", "table-1", wanted=9) == seen[-1]
    paper = papers()["yu2017"]
    assert seen[-1]["cells"] == [cell_content(outcome) for outcome in reproduce(paper, paper.table("1"), 9)]


def test_a_step_ends_soon(monkeypatch):
    """Time is looked at between runs: a table of a thousand is answered long before they are all there."""
    now = iter(range(1000))
    monkeypatch.setattr(answers, "_REMEMBERED", {})
    monkeypatch.setattr(answers, "perf_counter", lambda: next(now))
    found = asked("jeong2017", "table-5", wanted=1000)
    assert found["runs"] < 10
    assert len(found["cells"]) == 6
    # However slow, a run more: else the page would ask for ever.
    assert asked("jeong2017", "table-5", wanted=1000)["runs"] == found["runs"] + 1


def test_a_table_without_noise_comes_at_once():
    found = asked("alwagih", "table-3")
    assert (found["runs"], found["wanted"], len(found["cells"])) == (0, 0, 12)


@pytest.mark.parametrize("theme", THEMES)
def test_figures_and_proofs_follow_the_theme(theme):
    figure = asked("garg2021", "figure-alpha-beta", theme=theme)["figure"]
    assert figure["layout"]["meta"]["theme"] == theme
    proof = asked("jeong2017", "erratum-4", theme=theme)["proof"]
    assert proof["figure"]["layout"]["meta"]["theme"] == theme
    assert proof["holds"]
    assert len(proof["lines"]) > 2


@pytest.mark.parametrize(
    ("path", "status", "message"),
    [
        ("nobody/table-1.json?theme=light", 404, "paper must be one of"),
        ("jeong2017/table-9.json?theme=light", 404, "part must be one of"),
        ("jeong2017/figure-99.json?theme=light", 404, "part must be one of"),
        ("jeong2017/erratum-0.json?theme=light", 404, "part must be one of"),
        ("jeong2017/chapter-1.json?theme=light", 404, "part must be one of"),
        ("jeong2017/figure-1.json?theme=sepia", 400, "theme must be one of"),
        ("jeong2017/figure-1.json", 400, "theme must be one of"),
        ("jeong2017/table-5.json?wanted=1e9", 400, "wanted must be a whole number"),
        ("jeong2017/table-5.json?wanted=-1", 400, "wanted must be a whole number"),
        ("jeong2017/table-5.json?wanted=many", 400, "wanted must be a whole number"),
    ],
)
def test_what_is_not_there_is_refused(path, status, message, get):
    found = get(f"/papers/{path}")
    assert found.status_code == status
    assert found.headers["content-type"] == "application/json"
    assert found.json()["message"].startswith(message)
    assert found.json().keys() == SHAPE


def test_parts_are_served(get):
    assert get("/papers/alwagih/table-5.json").json()["runs"] == 0
    assert get("/papers/garg2021/figure-lag.json?theme=dark").json()["figure"]["layout"]["meta"]["theme"] == "dark"


# Tables as files ---------------------------------------------------------------------------------------------------


@EVERY_PAPER
def test_a_table_as_a_file_has_both_columns(name):
    paper = papers()[name]
    for table in paper.tables:
        rows = list(csv.DictReader(io.StringIO(table_csv(name, f"table-{table.name}", "2"))))
        outcomes = reproduce(paper, table, 2)
        assert [(row["printed"], float(row["recomputed"])) for row in rows] == [(o.printed, o.value) for o in outcomes]
        assert [row["verdict"] for row in rows] == [o.said for o in outcomes]
        assert all(row["runs"] in ("", "2") for row in rows)
        assert EMPTY not in {row["printed"] for row in rows}


def test_files_are_served(get):
    found = get("/papers/alwagih/table-5.csv")
    assert found.status_code == 200
    assert found.headers["content-type"] == "text/csv; charset=utf-8"
    assert found.headers["content-disposition"] == 'attachment; filename="alwagih-table-5.csv"'
    assert found.text.splitlines()[0] == ",".join(COLUMNS)
    for path, status, said in (
        ("/papers/nobody/table-1.csv", 404, "paper must be one of"),
        ("/papers/yu2017/table-9.csv", 404, "part must be one of"),
        ("/papers/yu2017/figure-1.csv", 404, "part must be one of"),
        ("/papers/yu2017/table-1.csv?seeds=0", 400, "seeds must be a whole number"),
        ("/papers/yu2017/table-1.csv?seeds=x", 400, "seeds must be a whole number"),
    ):
        refused = get(path)
        assert refused.status_code == status
        assert refused.json()["message"].startswith(said)
        assert refused.json().keys() == SHAPE


def test_a_document_is_smaller_than_what_a_page_may_weigh():
    for name in NAMES:
        size = len(to_json(layout(paper=name)))
        assert size < 400_000, (name, size)
