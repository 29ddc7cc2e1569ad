"""One place for colours, and colours that can be read."""

import ast
import re
from pathlib import Path

import pytest

from layouts import theme
from layouts.theme import LINES, PIN_LOOKS, THEMES, hollow, layout, line, tokens

ROOT = Path(__file__).parents[2]
STYLES = (ROOT / "assets" / "app.css").read_text(encoding="utf-8")
SOURCES = sorted(
    path.relative_to(ROOT)
    for path in [*ROOT.glob("layouts/**/*.py"), *ROOT.glob("assets/*.js"), *ROOT.glob("assets/*.css")]
    if path.name != "tokens.css"
)
COLOUR = re.compile(
    r"#(?:[0-9a-fA-F]{8}|[0-9a-fA-F]{6}|[0-9a-fA-F]{3,4})(?![\w-])|\b(?:rgb|hsl|hwb|oklch|oklab|lab)a?\("
)
TRANSPARENT = "rgba(0,0,0,0)"
PAINTED = re.compile(
    r"(?:^|[\s;{])((?:[\w-]*color|background|border[\w-]*|outline|fill|stroke|box-shadow)):\s*([^;}]+)"
)
WORDS = {
    "solid", "dashed", "dotted", "underline", "none", "transparent", "inherit", "collapse", "linear-gradient", "to",
    "right", "px", "important", "currentcolor",
}  # fmt: skip
OKABE_ITO = {"#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7", "#000000"}


def luminance(colour):
    """Relative luminance of a colour, as WCAG defines it."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one, other):
    """Contrast ratio, as WCAG defines it."""
    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def test_contrast_is_measured_as_in_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21)
    assert contrast("#767676", "#ffffff") == pytest.approx(4.54, abs=0.01)


# Tokens ------------------------------------------------------------------------------------------------------------


def test_every_token_of_the_style_sheet_exists():
    used = set(re.findall(r"var\(--([\w-]+)", STYLES))
    local = set(re.findall(r"(?m)^\s*--([\w-]+):", STYLES))
    assert used
    assert used <= set(tokens("light")) | local
    # The style sheet decides nothing that tokens.css decides.
    assert not local & set(tokens("light"))


def test_every_token_of_the_sources_exists_and_none_is_idle():
    python = "\n".join(path.read_text(encoding="utf-8") for path in ROOT.glob("layouts/**/*.py"))
    named = set(re.findall(r"\bt(?:okens\(theme\))?\[\"([\w-]+)\"\]", python))
    assert {"surface", "marker", "observed"} <= named <= set(tokens("light"))
    # Of every kind of line its own colour, and with an ending: tokens(theme)[f"{kind}-faint"].
    endings = {"", *re.findall(r"\[f\"\{kind\}(-[\w-]+)\"\]", python)}
    used = named | set(re.findall(r"var\(--([\w-]+)", STYLES))
    used |= {kind + ending for kind in LINES for ending in endings}
    # The colours of the design curves by number.
    used |= {f"curve-{number}" for number in range(1, 5) if 't[f"curve-{index % 4 + 1}"]' in python}
    assert set(tokens("light")) - used == set()


@pytest.mark.parametrize("kind", LINES)
@pytest.mark.parametrize("name", THEMES)
def test_every_kind_of_line_has_its_colour(name, kind):
    assert line(kind, name) == {**LINES[kind], "color": tokens(name)[kind]}
    assert hollow(name)["color"] == tokens(name)["observed"]


def test_the_dark_theme_decides_every_colour_anew():
    light, dark = tokens("light"), tokens("dark")
    colours = {name for name, value in light.items() if COLOUR.match(value)}
    assert set(light) == set(dark)
    assert {name for name in light if light[name] != dark[name]} == colours


def test_the_tokens_are_written_as_the_reader_expects():
    """Nothing in tokens.css escapes the two blocks that are read."""
    text = re.sub(r"/\*.*?\*/", "", theme.TOKENS.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert re.findall(r"([^{}]+)\{", text.replace("\n", "")) == [":root ", ':root[data-theme="dark"] ']
    light, dark = (len(re.findall(r"--[\w-]+:", body)) for body in re.findall(r"\{([^}]*)\}", text))
    assert len(tokens("light")) == light
    assert sum(tokens("light")[name] != value for name, value in tokens("dark").items()) == dark


# Colours have one home ---------------------------------------------------------------------------------------------


def test_the_search_for_colours_finds_them():
    found = COLOUR.findall("a { color: #fff; b: #12ab34cd; c: rgba(1, 2, 3, 0.4); } #explore-path #add-on #decade1")
    assert len(found) == 3


def said(path):
    """What a source says to a browser: of Python its strings but for the docstrings, of anything else everything."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return text
    tree = ast.parse(text)
    explained = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    strings = [node for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    return "\n".join(node.value for node in strings if id(node) not in explained)


def test_of_python_the_strings_are_searched(tmp_path):
    path = tmp_path / "module.py"
    path.write_text('"""Like #ffffff."""\nx = rgb(1)\ny = ["#123456", f"rgb({x})"]\n', encoding="utf-8")
    assert COLOUR.findall(said(path)) == ["#123456", "rgb("]


@pytest.mark.parametrize("path", SOURCES, ids=str)
def test_no_colour_is_decided_outside_the_tokens(path):
    text = said(ROOT / path).replace(TRANSPARENT, "")
    assert COLOUR.findall(text) == []


def test_the_style_sheet_names_no_colour():
    text = re.sub(r"/\*.*?\*/", "", STYLES, flags=re.DOTALL)
    values = [value for name, value in PAINTED.findall(text) if name not in ("border-radius", "border-collapse")]
    assert len(values) > 30
    for value in values:
        rest = re.sub(r"var\(--[\w-]+\)|[\d.]+(?:px|rem|%)?", " ", value)
        assert set(re.findall(r"[a-z-]+", rest)) <= WORDS, value


# Colours can be read -----------------------------------------------------------------------------------------------

TEXT = [
    ("ink", ["page", "surface", "raised", "good-soft", "bad-soft"]),
    ("ink-soft", ["page", "surface", "raised"]),
    ("good", ["page", "surface", "raised", "good-soft"]),
    ("bad", ["page", "surface", "raised", "bad-soft"]),
    ("accent", ["page", "surface", "raised"]),
    # The link to the content, and the tooltips.
    ("accent-ink", ["accent"]),
    ("surface", ["ink"]),
]
SHAPES = [
    "truth", "observed", "predicted", "smoothed", "marker", "region-line", "control", "accent", "good", "bad",
    *(f"pin-{slot}" for slot in PIN_LOOKS),
]  # fmt: skip


@pytest.mark.parametrize(("text", "ground"), [(text, ground) for text, grounds in TEXT for ground in grounds])
@pytest.mark.parametrize("name", THEMES)
def test_text_stands_out(name, text, ground):
    t = tokens(name)
    assert contrast(t[text], t[ground]) >= 4.5


def channels(colour):
    """Red, green, blue and how much of it there is."""
    if colour[0] == "#":
        return [int(colour[i : i + 2], 16) for i in (1, 3, 5)], 1.0
    *parts, alpha = map(float, re.findall(r"[\d.]+", colour))
    return parts, alpha


def laid(colour, ground):
    """A colour over an opaque one."""
    (parts, alpha), (below, _) = channels(colour), channels(ground)
    return "#" + "".join(f"{round(alpha * a + (1 - alpha) * b):02x}" for a, b in zip(parts, below, strict=True))


@pytest.mark.parametrize("regions", range(3))
@pytest.mark.parametrize("name", THEMES)
def test_the_trail_of_the_gains_stands_out_wherever_it_lies(name, regions):
    """The stable region is tinted, and within it once more where the poles are complex."""
    t = tokens(name)
    ground = t["surface"]
    for _ in range(regions):
        ground = laid(t["region"], ground)
    assert contrast(laid(t["trail"], ground), ground) >= 3


@pytest.mark.parametrize("name", THEMES)
def test_the_mark_of_an_oracle_stands_out(name):
    rules = dict(re.findall(r"(?m)^(\.oracle(?:::before)?) \{([^}]*)\}", STYLES))
    ground = re.search(r"background: var\(--([\w-]+)\)", rules[".oracle"])[1]
    mark = re.search(r"color: var\(--([\w-]+)\)", rules[".oracle::before"])[1]
    assert contrast(tokens(name)[mark], tokens(name)[ground]) >= 3


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", THEMES)
def test_data_and_controls_stand_out(name, shape):
    t = tokens(name)
    assert contrast(t[shape], t["surface"]) >= 3


def test_light_data_colours_are_those_of_okabe_and_ito():
    """But for the truth, which is a dark grey."""
    t = tokens("light")
    colours = [t[name] for name in ("observed", "predicted", "smoothed", "marker", "region-line")]
    assert set(colours) <= OKABE_ITO
    assert len(set(colours)) == 4
    for name, solid in (("region", "region-line"), ("predicted-faint", "predicted"), ("smoothed-faint", "smoothed")):
        parts = ", ".join(str(int(t[solid][i : i + 2], 16)) for i in (1, 3, 5))
        assert t[name].startswith(f"rgba({parts}, 0.")
    red, green, blue = (int(t["truth"][i : i + 2], 16) for i in (1, 3, 5))
    assert max(red, green, blue) - min(red, green, blue) < 32


# Plots -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", THEMES)
def test_a_layout_takes_its_colours_from_the_theme(name):
    made = layout(name, showlegend=False, margin={"l": 1})
    t, look = tokens(name), made["template"]["layout"]
    assert (look["paper_bgcolor"], look["plot_bgcolor"]) == (t["surface"], t["surface"])
    assert look["font"]["color"] == t["ink-soft"]
    assert look["xaxis"]["gridcolor"] == look["yaxis"]["gridcolor"] == t["grid"]
    assert (made["showlegend"], made["margin"]) == (False, {"l": 1})
    assert look["font"]["family"] == t["font"]
