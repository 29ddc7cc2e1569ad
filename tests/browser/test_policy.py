"""What a content security policy could stand in the way of, and does not."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import expect

STARTS = {"svg": b"<svg", "png": b"\x89PNG\r\n"}


@pytest.mark.parametrize("kind", STARTS)
def test_a_figure_is_saved(open_page, kind):
    page = open_page("?samples=60")
    page.click("#explore-path-card .save summary")
    with page.expect_download() as download:
        page.click(f'#explore-path-card [data-save="{kind}"]')
    assert download.value.suggested_filename.endswith(f"-path.{kind}")
    data = Path(download.value.path()).read_bytes()
    assert data.startswith(STARTS[kind])
    assert len(data) > 5_000


def test_the_link_is_copied(open_page):
    page = open_page("?samples=60", permissions=["clipboard-write"])
    said = page.locator("#copy-said")
    # What has just been typed belongs to it.
    page.fill("#explore-xi", "0.5")
    page.click("#copy-link")
    expect(said).to_have_text("Copied")
    assert page.url.endswith("?samples=60&xi=0.5")
    # What is on the clipboard no page may ask for; a hand may paste it.
    page.evaluate("() => { const box = document.createElement('textarea'); document.body.append(box); box.focus(); }")
    page.keyboard.press("Control+V")
    assert page.evaluate("() => document.activeElement.value") == page.url
    expect(said).to_have_text("")
    page.fill("#explore-xi", "1")
    page.click("#copy-link")
    expect(said).to_have_text("Last good link copied")
    expect(page.locator("#copy-link")).to_have_text("Last good link copied")


TRIED = {
    # Later, since what the test says itself may do anything.
    "script-src": "setTimeout(() => { try { eval('window.ran = true'); } catch (error) { /* as it should be */ } })",
    "script-src-attr": """{
        document.body.insertAdjacentHTML("beforeend", '<button onclick="window.ran = true"></button>');
        document.body.lastElementChild.click();
    }""",
    "script-src-elem": """{
        const script = document.createElement("script");
        script.textContent = "window.ran = true";
        document.body.append(script);
    }""",
}


@pytest.mark.parametrize("directive", TRIED)
def test_no_text_becomes_code(browser, port, directive):
    context = browser.new_context()
    page = context.new_page()
    page.goto(f"http://127.0.0.1:{port}/papers")
    stopped = page.evaluate(
        f"""() => new Promise((resolve) => {{
            document.addEventListener("securitypolicyviolation", (event) => resolve(event.effectiveDirective));
            {TRIED[directive]};
        }})"""
    )
    assert stopped == directive
    assert page.evaluate("() => window.ran") is None
    context.close()
