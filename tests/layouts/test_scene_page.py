"""viser's page: made to fit, the same for everyone, and allowed to do what it needs alone."""

import re
from importlib import resources

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layouts.scenes.page import DIGITS, number, page_policy, publish, unpacked
from layouts.theme import THEMES, tokens
from server.files import ASK, Files
from server.policy import source

VISER = resources.files("viser")


@pytest.fixture(scope="module")
def files():
    """The page in every theme."""
    files = Files()
    publish(files)
    return files


@pytest.fixture(scope="module")
def original():
    """The page as viser has it."""
    return VISER.joinpath("client", "build", "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("theme", THEMES)
def test_the_page_is_in_the_colours_of_the_theme_and_hides_what_is_visers(files, theme):
    page = files.at(f"/viser/{theme}/")
    assert (page.media, page.keep) == ("text/html; charset=utf-8", ASK)
    assert page.headers["Referrer-Policy"] == "no-referrer"
    text = page.read().decode()
    head = text[: text.index("data-p=")]
    assert f"background:{tokens(theme)['surface']}!important" in head
    assert f"darkMode:{str(theme == 'dark').lower()}" in head
    assert ".mantine-Paper-root" in head
    assert "document.hasFocus=" in head


def test_the_shaders_that_are_recoloured_are_visers_still():
    """Else labels would be black on white in the dark."""
    text = VISER.joinpath("client", "src", "label", "LabelRenderer.tsx").read_text(encoding="utf-8")
    assert "vec4(0.0, 0.0, 0.0, a)" in text
    assert "vec4(1.0, 1.0, 1.0, 0.85 * vAlpha)" in text


def test_it_connects_to_its_own_address_still(original):
    """The page gives itself the address of its socket."""
    text = VISER.joinpath("client", "src", "App.tsx").read_text(encoding="utf-8")
    assert "let server = window.location.href;" in text
    assert "window.location.href" in unpacked(original)


def test_its_worker_says_whether_it_is_connected_still(files):
    """Whoever shows the page in a frame is told what the worker tells the page."""
    text = VISER.joinpath("client", "src", "WebsocketClientWorker.ts").read_text(encoding="utf-8")
    page = files.at("/viser/light/").read().decode()
    for state in ("connected", "closed"):
        assert f'type: "{state}"' in text
        assert f's==="{state}"' in page


@pytest.mark.parametrize("theme", THEMES)
def test_its_policy_names_what_it_runs(files, original, theme):
    page = files.at(f"/viser/{theme}/")
    policy = {part.split()[0]: part.split()[1:] for part in page.headers["Content-Security-Policy"].split("; ")}
    scripts = re.findall(r"<script[^>]*>(.*?)</script>", page.read().decode(), re.DOTALL)
    # What is put in, what unpacks, and what is unpacked.
    assert len(scripts) == 2
    assert policy["script-src"] == ["'wasm-unsafe-eval'", *map(source, scripts), source(unpacked(original))]
    assert policy["default-src"] == policy["object-src"] == policy["base-uri"] == policy["form-action"] == ["'none'"]
    # Nothing but its own socket and what it carries itself.
    assert policy["connect-src"] == ["'self'", "blob:", "data:"]
    assert not [name for name, sources in policy.items() if {"*", "https:", "http:", "ws:", "wss:"} & set(sources)]


def test_another_code_is_another_policy():
    assert page_policy("<script>a</script>", "b") != page_policy("<script>a</script>", "c")


def digits(data):
    """The same number, written as viser's page is built."""
    text = ""
    for start in range(0, len(data), 4):
        group = data[start : start + 4]
        value, places = int.from_bytes(group, "big"), len(group) + 1
        text += "".join(chr(DIGITS[value // 88**place % 88]) for place in reversed(range(places)))
    return text


@given(st.binary(max_size=200))
def test_a_number_of_base_88_is_read(data):
    assert len(DIGITS) == 88
    assert number(digits(data)) == data


@pytest.mark.parametrize("text", ["&&&&&", "abc d", "é!!!!"])
def test_what_is_no_number_is_refused(text):
    with pytest.raises(ValueError, match="no number of base 88"):
        number(text)


def test_a_page_that_is_packed_in_another_way_is_refused(original):
    with pytest.raises(ValueError, match="packed in another way"):
        unpacked("<html><script>all plain</script></html>")
    with pytest.raises(ValueError, match="how long its parts are"):
        unpacked(re.sub(r'data-cs="\d+"', 'data-cs="9"', original))
