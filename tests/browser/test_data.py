"""The Data page in a real browser: files in, read in another way, kept or not, missing, and everything out again."""

from __future__ import annotations

import csv
import io
import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from playwright.sync_api import expect

from benchmarks.serving import server, settle
from tracker_core.measured import content_name

RECORDINGS = Path(__file__).parents[2] / "assets" / "recordings"
HTML = "<img src=x onerror=alert(1)>"
OPACITY = """(element) => {
  let opacity = 1;
  for (; element; element = element.parentElement) opacity *= getComputedStyle(element).opacity;
  return opacity;
}"""
SHOWN = '#data[data-recording="shown"]'


def done(page):
    """The recording is shown, and the suggestion is there."""
    expect(page.locator(SHOWN)).to_have_count(1)
    settle(page)
    expect(page.locator('#data [data-study="done"]')).to_have_count(1)


def choose(page, name, content):
    page.set_input_files("#data-file", {"name": name, "mimeType": "text/csv", "buffer": content})


def rows(count=60, other=""):
    return "".join(f"{row},{row * row / 7:.3f},{(row * 31) % 11 - 3 * row}{other}\n" for row in range(count))


@pytest.fixture(scope="module")
def kept_in(tmp_path_factory):
    """A server that keeps recordings in a folder."""
    folder = tmp_path_factory.mktemp("kept")
    with server(GAINSCOPE_DATA=str(folder)) as port:
        yield port, folder


@pytest.mark.parametrize("example", ["good", "irregular", "dirty"])
def test_an_example_is_loaded_used_and_found_again_after_a_reload(open_page, kept_in, plot, example):
    port, folder = kept_in
    page = open_page("data", at=port)
    expect(page.locator("#data .load-words")).to_be_visible()
    expect(page.locator("#data .file-card")).to_be_hidden()
    page.click(f'[data-example="{example}.csv"]')
    done(page)
    data = content_name((RECORDINGS / f"{example}.csv").read_bytes())
    assert f"data={data}" in page.url
    assert (folder / f"{data}.recording").exists()
    expect(page.locator("#data-said")).to_contain_text("kept on this server")
    page.click("#data-use")
    settle(page)
    assert "design=steady-kalman" in page.url
    expect(page.locator("#data-taken")).to_have_text("This filter is in use, on every page.")
    gains = page.get_attribute("#data", "data-gains")
    page.reload()
    done(page)
    assert page.get_attribute("#data", "data-gains") == gains
    # Every page with a filter goes on with it.
    page.click("#to-explore")
    page.wait_for_selector("#explore[data-state=settled]")
    assert f"data={data}" in page.url
    assert page.get_attribute("#explore", "data-gains") == gains


def test_names_of_columns_ids_and_files_are_text_everywhere(open_page, port, plot):
    dialogs = []
    page = open_page("data", at=port, first=lambda page: page.on("dialog", lambda it: dialogs.append(it.dismiss())))
    content = f"{HTML} t,x,{HTML} y,{HTML} id\n" + rows(60, f",{HTML}") + rows(30, ",=1+1")
    choose(page, f"{HTML}.csv", content.encode())
    expect(page.locator('#data:not([data-recording="none"])')).to_have_count(1)
    settle(page)
    for name, value in (("read_time", "1"), ("read_at1", "2"), ("read_at2", "3"), ("read_track", "4")):
        page.select_option(f"#data-{name}", value)
        settle(page)
    done(page)
    expect(page.locator("#data-name")).to_have_text(f"{HTML}.csv")
    assert HTML in page.inner_text("#data-preview-head")
    assert HTML in page.inner_text("#data-read_at2")
    assert page.input_value("#data-read_only") == HTML
    for path in ("#to-explore", "#to-compare", "#to-track"):
        if page.locator(path).count():
            page.click(path)
            page.wait_for_selector(".desk[data-state=settled]")
            assert page.locator("img[src=x], .legend img, svg image[href=x]").count() == 0
    assert page.locator("img[src=x]").count() == 0
    assert dialogs == []


def test_how_it_is_read_is_changed_refused_mended_and_taken_back(open_page, port):
    page = open_page("data", at=port)
    choose(page, "log.csv", b"t,x,y\n" + rows().encode())
    done(page)
    page.select_option("#data-read_at2", "0")
    settle(page)
    assert "at:2" in page.url
    assert "y" not in page.locator("#data-facts").inner_text().split("Axes")[1].split("\n")[0]
    link = page.url
    page.select_option("#data-read_clock", "iso")
    settle(page)
    expect(page.locator("#data-reading-error")).to_contain_text("must fit the file")
    expect(page.locator('#data[data-recording="refused"]')).to_have_count(1)
    # What is shown is not what the controls say: it is not taken home as that.
    expect(page.locator("[data-take]:enabled")).to_have_count(0)
    page.select_option("#data-read_clock", "seconds")
    done(page)
    expect(page.locator("[data-take]:disabled")).to_have_count(0)
    expect(page.locator("#data-reading-error")).to_have_text("")
    assert page.url == link
    page.click("#data-proposal")
    done(page)
    assert "at:" not in page.url
    assert page.evaluate("() => document.activeElement.textContent") == "Why this is proposed"
    page.click("#undo")
    settle(page)
    assert page.url == link
    # What is wrong can be read, and what is of an earlier reading says so.
    page.fill("#data-gate", "-1")
    page.press("#data-gate", "Enter")
    expect(page.locator("#data-gate-error")).to_contain_text("must be")
    assert page.locator("#data-gate-error").evaluate(OPACITY) == 1
    said = "title => getComputedStyle(title, '::after').content"
    assert "as of the last good reading" in page.locator("#data-path-title").evaluate(said)


def test_a_wrong_file_says_why_and_changes_nothing(open_page, port):
    page = open_page("data", at=port, refused=422)
    choose(page, "empty.csv", b"")
    expect(page.locator("#data-data-error")).to_contain_text("file must")
    expect(page.locator('#data[data-recording="none"]')).to_have_count(1)
    # What is plainly too large is not even sent.
    choose(page, "large.csv", b"1,2,3\n" * 1_700_000)
    expect(page.locator("#data-data-error")).to_contain_text("at most 10.0 MB")
    page.route("**/assets/recordings/good.csv", lambda route: route.fulfill(status=422))
    page.click('[data-example="good.csv"]')
    expect(page.locator("#data-data-error")).to_have_text("good.csv cannot be had: the server answered 422.")
    expect(page.locator('#data[data-recording="none"]')).to_have_count(1)


def test_the_newest_file_wins_and_a_page_that_is_left_waits_for_none(open_page, port):
    page = open_page("data", at=port)
    held = []
    # Playwright writes on the function.
    page.route("**/recordings?name=slow*", lambda route: held.append(route))  # noqa: PLW0108
    choose(page, "slow 1.csv", b"t,x,y\n" + rows(70).encode())
    expect(page.locator("#data-said")).to_contain_text("slow 1.csv")
    with page.expect_event("requestfailed") as ended:
        choose(page, "quick.csv", b"t,x,y\n" + rows().encode())
    assert ended.value == held[0].request
    done(page)
    expect(page.locator("#data-name")).to_have_text("quick.csv")
    choose(page, "slow 2.csv", b"t,x,y\n" + rows(80).encode())
    expect(page.locator("#data-said")).to_contain_text("slow 2.csv")
    with page.expect_event("requestfailed") as ended:
        page.click("#to-explore")
    assert ended.value == held[1].request
    page.wait_for_selector("#explore[data-state=settled]")
    assert page.input_value("#explore-samples") == "60"


def test_what_stays_in_the_browser_survives_a_server_that_has_forgotten_it(open_page):
    content = b"t,x,y\n" + rows(70).encode()
    data = content_name(content)
    with server() as port:
        page = open_page("data", at=port)
        page.check("#data-keep-browser")
        choose(page, "mine.csv", content)
        done(page)
        expect(page.locator("#data-browser-list")).to_contain_text("mine.csv")
        query = page.url.partition("?")[2]
        page.goto("about:blank")
    with server(GAINSCOPE_PORT=str(port)):
        page.goto(f"http://127.0.0.1:{port}/?{query}")
        # The browser sends it by itself, and the page is built anew.
        expect(page.locator("#explore-scenario")).to_have_value("recording")
        settle(page)
        assert f"data={data}" in page.url
        expect(page.locator("#missing-recording")).to_be_hidden()
        page.goto(f"http://127.0.0.1:{port}/data?{query}")
        done(page)
        page.click(f'[data-forget="{data}"]')
        expect(page.locator("#data-browser")).to_be_hidden()
        page.goto("about:blank")


def test_a_missing_recording_is_said_plainly_and_comes_back_with_its_file(open_page, port):
    content = b"t,x,y\n" + rows(80).encode()
    data = content_name(content)
    page = open_page(f"?data={data}&xi=0.5", at=port)
    banner = page.locator("#missing-recording")
    expect(banner).to_contain_text("is not kept on this server, or no longer: load the file again")
    # The link stays as it is.
    assert f"data={data}" in page.url
    banner.locator("a").click()
    page.wait_for_selector("#data[data-state=settled]")
    assert f"data={data}" in page.url
    choose(page, "again.csv", content)
    done(page)
    assert f"data={data}" in page.url
    assert "xi=0.5" in page.url
    expect(banner).to_be_hidden()


def test_a_track_and_findings_are_taken_home(open_page, port):
    page = open_page("data", at=port)
    page.click('[data-example="dirty.csv"]')
    done(page)
    page.click("#data-use")
    settle(page)
    with page.expect_download() as download:
        page.click('[data-take="export/track.csv"]')
    assert download.value.suggested_filename == "dirty-track.csv"
    table = list(csv.DictReader(io.StringIO(Path(download.value.path()).read_text())))
    assert len(table) == 420
    with page.expect_download() as download:
        page.click("#data-path-card .save summary")
        page.click('#data-path-card [data-save="svg"]')
    assert download.value.suggested_filename == "dirty-path.svg"
    assert Path(download.value.path()).read_text().startswith("<svg")


def test_everything_in_one_zip_and_its_filter_tests_itself(open_page, port, tmp_path):
    page = open_page("data", at=port)
    page.click('[data-example="dirty.csv"]')
    done(page)
    page.click("#data-use")
    settle(page)
    # What has just been typed is in it.
    page.fill("#data-gate", "5")
    with page.expect_download() as download:
        page.click('[data-take="export.zip"]')
    assert download.value.suggested_filename == "dirty.zip"
    with zipfile.ZipFile(download.value.path()) as archive:
        archive.extractall(tmp_path)
        names = archive.namelist()
    [python] = [name for name in names if name.endswith("tuned_filter.py")]
    ran = subprocess.run([sys.executable, tmp_path / python], capture_output=True, text=True, timeout=60, check=False)
    assert ran.returncode == 0, ran.stderr
    [experiment] = [name for name in names if name.endswith("experiment.json")]
    assert json.loads((tmp_path / experiment).read_text())["gate"] == 5


def test_the_page_can_be_used_by_keyboard_and_looks_right_everywhere(open_page, port, check_look):
    page = open_page("data", at=port)
    check_look(page)
    page.focus("#data-file")
    page.keyboard.press("Tab")
    assert page.evaluate("() => document.activeElement.name") == "data-keep"
    page.focus('[data-example="dirty.csv"]')
    page.keyboard.press("Enter")
    done(page)
    page.focus("#data-use")
    page.keyboard.press("Enter")
    settle(page)
    page.set_viewport_size({"width": 1440, "height": 900})
    check_look(page)
    assert re.search(r"gate=4", page.url)
