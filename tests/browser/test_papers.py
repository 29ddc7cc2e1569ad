"""The Papers page in a real browser: every table, every figure, every erratum of every document."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pytest
from playwright.sync_api import expect

from layouts.pages.papers.tables import KEYS
from tracker_core.papers import NAMES, count, papers, reproduce
from tracker_core.papers.recipes import cells

COMPLETE = "() => document.querySelector('#papers-verdicts').dataset.complete === 'yes'"
SETTLED = "() => document.querySelector('#papers')?.dataset.state === 'settled'"


def look_at(page, part):
    """Bring a part into sight and wait until it is there."""
    page.evaluate("part => document.getElementById(part).scrollIntoView({block: 'center'})", part)
    page.wait_for_function(
        """part => {const place = document.querySelector(`[data-part="${part}"]`);
        return place.childElementCount && [...place.querySelectorAll('.found')].every(cell => cell.textContent !== '…')
          && [...document.querySelectorAll(`#${part} [data-plot]`)].every(gd => gd._fullLayout?.meta)}""",
        arg=part,
    )


def metas(page, part):
    """What the plots of a part say of themselves, and how many traces they have."""
    return page.evaluate(
        """part => [...document.querySelectorAll(`#${part} [data-plot]`)].map(gd => ({
        ...gd._fullLayout.meta, traces: gd._fullData.length}))""",
        part,
    )


@pytest.mark.parametrize("name", NAMES)
def test_every_table_figure_and_erratum_of_a_document(name, open_page):
    paper = papers()[name]
    page = open_page(f"papers?paper={name}")
    for table in paper.tables:
        look_at(page, f"table-{table.name}")
        assert page.locator(f"#table-{table.name} td .verdict").count() == len(cells(paper, table))
    for figure in paper.figures:
        part = f"figure-{figure.name}"
        look_at(page, part)
        (meta,) = metas(page, part)
        assert (meta["paper"], meta["figure"], meta["theme"]) == (name, figure.name, "light")
        assert meta["traces"] > 0
    for erratum in paper.errata:
        part = f"erratum-{erratum.number}"
        page.click(f"#{part} > summary")
        look_at(page, part)
        expect(page.locator(f"#{part} .proof-verdict")).to_have_text("The numbers prove it.")
    page.wait_for_function(COMPLETE)
    found = count(outcome for table in paper.tables for outcome in reproduce(paper, table))
    for verdict, number in found.items():
        assert page.inner_text(f'[data-count="{KEYS[verdict]}"]') == str(number)


def test_a_link_to_a_part_leads_to_it_and_can_be_shared(open_page):
    page = open_page("papers?paper=yu2017#erratum-5")
    expect(page.locator("#erratum-5 .proof-verdict")).to_be_visible()
    assert page.evaluate("() => Math.abs(document.getElementById('erratum-5').getBoundingClientRect().top) < 200")
    page.click("#table-1 >> text=Link")
    assert page.url.endswith("/papers?paper=yu2017#table-1")
    page.click("#table-1 tbody tr:nth-child(4) a.verdict")
    assert page.url.endswith("#erratum-5")
    other = open_page(page.url.split("/", 3)[3])
    expect(other.locator("#erratum-5")).to_have_attribute("open", "")


def test_a_hash_that_is_no_text_leads_nowhere(open_page):
    page = open_page("papers?paper=garg2021#%E0%A4%A")
    page.wait_for_function(SETTLED)
    assert page.evaluate("() => scrollY") == 0


def test_an_answer_that_comes_late_is_not_put_into_another_document(open_page):
    page = open_page("papers?paper=jeong2017")
    page.wait_for_function(COMPLETE)
    held = []

    def hold(route):
        held.append(route)

    page.route("**/papers/jeong2017/table-*.json*", hold)
    with page.expect_request("**/papers/jeong2017/table-*.json*"):
        page.select_option("#papers-seeds", "300")
    # The other document is there, its beginning not yet.
    page.evaluate("() => {dash_clientside.papers.begin = () => dash_clientside.no_update}")
    page.click(".documents >> text=Njonjo, Pan & Jeong")
    expect(page.locator(".paper-card h2")).to_have_text("Njonjo, Pan & Jeong")
    (route,) = held
    with page.expect_response("**/papers/jeong2017/table-*.json*"):
        route.continue_()
    page.wait_for_timeout(200)
    assert set(page.locator("td.found[data-cell]").all_inner_texts()) == {"…"}


def test_a_server_that_is_lost_is_named_and_asked_again(open_page):
    page = open_page("papers?paper=garg2021")
    page.wait_for_function(SETTLED)
    page.route("**/papers/garg2021/*.json*", lambda route: route.fulfill(body="gone"))
    page.evaluate("() => document.getElementById('figure-lag').scrollIntoView()")
    expect(page.locator("#papers[data-lost]")).to_be_visible()
    said = "gd => getComputedStyle(gd, '::before').content"
    assert page.locator("#figure-lag .plot-frame").evaluate(said) == '"Computing …"'
    page.unroute("**/papers/garg2021/*.json*")
    look_at(page, "figure-lag")
    assert page.get_attribute("#papers", "data-lost") is None


def test_a_table_is_downloaded_with_both_columns(open_page):
    page = open_page("papers?paper=alwagih")
    with page.expect_download() as download:
        page.click("#table-3 a[download]")
    assert download.value.suggested_filename == "alwagih-table-3.csv"
    rows = list(csv.DictReader(Path(download.value.path()).read_text(encoding="utf-8").splitlines()))
    (flipped,) = [row for row in rows if (row["row"], row["column"]) == ("m2-y", "m3")]
    assert (flipped["printed"], flipped["verdict"]) == ("3.5122", "erratum 3")
    assert float(flipped["recomputed"]) == pytest.approx(-3.4251, abs=5e-5)


def test_a_run_is_opened_in_explore_and_documents_lead_to_each_other(open_page):
    page = open_page("papers")
    expect(page.locator("#to-papers")).to_have_attribute("aria-current", "page")
    page.click(".documents >> text=Garg 2021")
    expect(page.locator(".paper-card h2")).to_have_text("Garg 2021")
    page.wait_for_function(SETTLED)
    expect(page.locator('.documents li[aria-current="page"]')).to_have_text("Garg 2021")
    page.click("#runs + .paper-listing tr:has-text('on the accelerating aircraft') a")
    page.wait_for_selector("#explore[data-state=settled]")
    assert page.input_value("#explore-scenario") == "garg-accelerating"
    assert page.input_value("#explore-order") == "2"
    page.click("#to-papers")
    page.wait_for_function(SETTLED)
    assert page.url.endswith("/papers")
    assert page.is_hidden("#undo")


def test_more_runs_show_progress_and_can_be_stopped(open_page):
    page = open_page("papers?paper=yu2017")
    progress, stop = page.locator("#table-1 .progress"), page.locator("#table-1 .stop")
    expect(progress).to_have_text("20 runs")
    page.select_option("#papers-seeds", "1000")
    expect(progress).to_have_text(re.compile(r"^\d+ of 1000 runs$"))
    assert "seeds=1000" in page.url
    stop.click()
    expect(progress).to_have_text(re.compile(r"^\d+ runs$"))
    expect(stop).to_have_text("Continue")
    for row in range(1, 6):
        assert page.locator(f"#table-1 tbody tr:nth-child({row}) .verdict").count() == 3
    stop.click()
    expect(progress).to_have_text(re.compile(r"^\d+ of 1000 runs$"))
    page.select_option("#papers-seeds", "20")
    expect(progress).to_have_text("20 runs")
    expect(stop).to_be_hidden()
    assert page.get_attribute("#table-1 a[download]", "href").endswith("table-1.csv?seeds=20")


def test_figures_and_proofs_take_the_other_theme(open_page):
    page = open_page("papers?paper=jeong2017#erratum-4")
    look_at(page, "erratum-4")
    look_at(page, "figure-11")
    page.click("#theme-switch")
    for part in ("erratum-4", "figure-11"):
        page.evaluate("part => document.getElementById(part).scrollIntoView({block: 'center'})", part)
        page.wait_for_function(
            """part => {const gd = document.querySelector(`#${part} [data-plot]`);
            return gd && gd._fullLayout && gd._fullLayout.meta.theme === 'dark'}""",
            arg=part,
        )
        assert [meta["theme"] for meta in metas(page, part)] == ["dark"]


def test_it_looks_right_at_every_width_in_both_themes(open_page, check_look):
    page = open_page("papers?paper=alwagih#erratum-3")
    look_at(page, "erratum-3")
    check_look(page)
