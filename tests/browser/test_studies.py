"""Long work in real browsers: two studies at a time, a queue, an end with the page, the same numbers after a reload."""

from __future__ import annotations

from playwright.sync_api import expect

from benchmarks.serving import server

TWO = "compare?order=2&xi=0.6&pin1=kalata,order:2,tracking_index:0.5"


def card(page):
    return page.locator("[data-study]")


def test_two_run_a_third_waits_until_one_page_goes_away(open_page):
    # Another seed is another study.
    first, second = (open_page(f"{TWO}&runs=1000000&seed={seed}") for seed in (1, 2))
    for page in (first, second):
        expect(card(page)).to_have_attribute("data-study", "running")
    third = open_page(f"{TWO}&runs=20&seed=3")
    expect(third.locator("#compare-study-text")).to_have_text("Two studies are running; place 1 in the queue.")
    assert card(third).get_attribute("data-study") == "queued"
    # Leaving for a page without a study is enough.
    first.click("#to-explore")
    expect(card(third)).to_have_attribute("data-study", "done")
    second.click("#compare-study-stop")
    expect(card(second)).to_have_attribute("data-study", "stopped")


def test_a_server_started_anew_finds_the_same_study_with_the_same_numbers(open_page):
    page = open_page(f"{TWO}&runs=300")
    expect(card(page)).to_have_attribute("data-study", "done")
    numbers = page.locator("#compare-over-runs").inner_text()
    assert "±" in numbers
    with server() as port:
        again = open_page(page.url.partition("/compare")[2].join(("compare", "")), at=port)
        expect(card(again)).to_have_attribute("data-study", "done")
        assert again.locator("#compare-over-runs").inner_text() == numbers
