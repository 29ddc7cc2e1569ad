"""Long work in real browsers: two studies at a time, a queue, an end with the page, the same numbers after a reload."""

from __future__ import annotations

from playwright.sync_api import expect

from benchmarks.serving import server

TWO = "compare?order=2&xi=0.6&pin1=kalata,order:2,tracking_index:0.5"


def card(page):
    return page.locator("[data-study]")


WAITS = "Other studies are running; place {} in the queue. Shown: the answer to the question before."

SEEN = """() => {
  const body = document.querySelector('#compare-over-runs');
  const heads = [...body.parentElement.querySelectorAll('thead th')], {cells} = body.rows[0];
  const seen = (cell) => cell.checkVisibility({visibilityProperty: true}) ? cell.innerText : '';
  const shown = heads.map((head, i) => [head, cells[i]]).slice(1).filter(([head]) => !head.hidden);
  return Object.fromEntries(shown.map(([head, cell]) => [head.dataset.ofSlot, seen(cell)]));
}"""


def cells(page):
    """What is seen of the first metric over many seeds, by the slot that its heading is of."""
    return page.evaluate(SEEN)


def test_two_run_a_third_waits_until_one_page_goes_away(open_page, settle):
    third, fourth = open_page(f"{TWO}&runs=20&seed=3"), open_page("tune?samples=100&tune_runs=3")
    for page in (third, fourth):
        expect(card(page)).to_have_attribute("data-study", "done")
    # Another seed is another study.
    first, second = (open_page(f"{TWO}&runs=1000000&seed={seed}") for seed in (1, 2))
    for page in (first, second):
        expect(card(page)).to_have_attribute("data-study", "running")
    seen = cells(third)
    assert list(seen) == ["0", "1"]
    third.click('button[data-pinning="remove"][data-slot="1"]')
    third.click("#compare-pin")
    third.fill("#compare-xi", "0.5")
    third.press("#compare-xi", "Enter")
    third.click("#compare-pin")
    settle(third)
    expect(card(third)).to_have_attribute("data-study", "queued")
    expect(third.locator("#compare-study-text")).to_have_text(WAITS.format(1))
    # What was found of other filters stands under none of the present names.
    assert cells(third) == {"0": "", "1": "", "2": ""}
    fourth.click("#tune-new-seed")
    expect(fourth.locator("#tune-study-text")).to_have_text(WAITS.format(2))
    use, gains = fourth.locator("#tune-use"), fourth.get_attribute("#tune", "data-gains")
    expect(use).to_be_disabled()
    use.dispatch_event("click")
    # Leaving for a page without a study is enough.
    first.click("#to-explore")
    for page in (third, fourth):
        expect(card(page)).to_have_attribute("data-study", "done")
        assert card(page).get_attribute("data-stale") is None
    assert all("±" in cell for cell in cells(third).values())
    assert cells(third)["1"] != seen["1"]
    assert fourth.get_attribute("#tune", "data-gains") == gains
    use.click()
    fourth.wait_for_function("gains => document.getElementById('tune').dataset.gains !== gains", arg=gains)
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
