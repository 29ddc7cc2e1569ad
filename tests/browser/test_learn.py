"""The Learn page in a real browser: predict, see, follow, come back."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from layouts.pages.learn.lessons import lessons

LESSONS = lessons()
FIRST = LESSONS[0]
WRONG = next(index for index in range(len(FIRST.choices)) if index != FIRST.right)


def choice(page, lesson, index):
    return page.locator(f'[data-lesson="{lesson.name}"] [data-choice="{index}"]')


def answer(page, lesson):
    return page.locator(f'[data-lesson="{lesson.name}"] .lesson-answer')


def test_an_answer_shows_once_it_is_predicted(open_page):
    page = open_page("learn")
    for number, lesson in enumerate(LESSONS, 1):
        expect(answer(page, lesson)).to_be_hidden()
        choice(page, lesson, lesson.right).click()
        expect(answer(page, lesson)).to_be_visible()
        expect(answer(page, lesson).locator(".verdict-line")).to_have_text("As you predicted.")
        expect(page.locator("#learn-score")).to_have_text(f"{number} of {number} predicted rightly")
        expect(page.locator("#learn-said")).to_have_text(
            f"As you predicted. What happens: {lesson.choices[lesson.right]}"
        )
        for paragraph in lesson.answer:
            expect(answer(page, lesson)).to_contain_text(paragraph.replace("_", ""))


def test_a_wrong_prediction_shows_what_happens_and_stands(open_page):
    page = open_page("learn")
    choice(page, FIRST, WRONG).click()
    expect(choice(page, FIRST, WRONG)).to_contain_text("✗ predicted")
    expect(choice(page, FIRST, FIRST.right)).to_contain_text("✓ what happens")
    expect(answer(page, FIRST).locator(".verdict-line")).to_have_text("Not as you predicted.")
    # Afterwards everybody knows.
    choice(page, FIRST, FIRST.right).click(force=True)
    expect(page.locator("#learn-score")).to_have_text("0 of 1 predicted rightly")
    expect(choice(page, FIRST, WRONG)).to_have_attribute("aria-pressed", "true")
    page.click("#learn-again")
    expect(answer(page, FIRST)).to_be_hidden()
    expect(choice(page, FIRST, WRONG)).to_have_text(FIRST.choices[WRONG])
    expect(page.locator("#learn-score")).to_be_empty()


@pytest.mark.parametrize("lesson", [LESSONS[2], LESSONS[4]], ids=lambda lesson: lesson.name)
def test_a_step_leads_there_and_back(open_page, settle, lesson):
    page = open_page(f"learn#lesson-{lesson.name}")
    choice(page, lesson, lesson.right).press("Enter")
    step = lesson.steps[0]
    # The keyboard is where it was.
    expect(choice(page, lesson, lesson.right)).to_be_focused()
    answer(page, lesson).locator(".steps a").first.press("Enter")
    page.wait_for_selector(f"#{step.page.lower()}[data-state=settled]")
    settle(page)
    assert page.url.endswith(step.address)
    page.go_back()
    page.wait_for_selector("#learn[data-state=settled]")
    expect(answer(page, lesson)).to_be_visible()
    expect(page.locator("#to-learn")).to_have_attribute("aria-current", "page")


def test_what_the_browser_has_kept_may_be_anything(open_page):
    page = open_page("learn")
    for kept in (
        "no", "null", "[1]", '{"memory": 99, "nonsense": 1, "order": "x"}',
        '{"luck": null, "stability": "1", "toString": 0}', f'{{"{FIRST.name}": {WRONG}}}',
    ):  # fmt: skip
        page.evaluate("kept => sessionStorage.setItem('gainscope-learn', kept)", kept)
        page.reload()
        page.wait_for_selector("#learn[data-state=settled]")
        shown = int(kept == f'{{"{FIRST.name}": {WRONG}}}')
        expect(page.locator(".lesson-answer:visible")).to_have_count(shown)


def test_lessons_from_wide_to_narrow(open_page, check_look):
    page = open_page("learn")
    for lesson in LESSONS[::2]:
        choice(page, lesson, 0).click()
    check_look(page)
