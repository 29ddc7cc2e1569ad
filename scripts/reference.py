"""Writes docs/reference.md from the registries: `python scripts/reference.py`. A test fails when it is stale."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tracker_core import CONVENTIONS, DESIGNS, METRICS, SCENARIOS, STARTS  # noqa: E402
from tracker_core.adaptive import METHODS  # noqa: E402
from tracker_core.experiment import DEFAULTS  # noqa: E402
from tracker_core.fields import FIELDS  # noqa: E402
from tracker_core.manoeuvre import MANOEUVRES  # noqa: E402
from tracker_core.noise import NOISES  # noqa: E402
from tracker_core.papers import papers  # noqa: E402

TARGET = ROOT / "docs" / "reference.md"


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines] + [""]


def reference() -> str:
    """The whole page."""
    parts = [
        "# Reference",
        "",
        "Written by `scripts/reference.py` from the registries that the menus, the command line and the tests read.",
        "",
        *_fields(),
        *_conventions(),
        *_designs(),
        *_methods(),
        *_noise(),
        *_scenarios(),
        *_starts(),
        *_metrics(),
        *_runs(),
    ]
    return "\n".join(parts)


def _fields() -> list[str]:
    rows = [
        [
            f"`{name}`",
            field.symbol,
            field.unit,
            field.sentence,
            ", ".join(f"`{choice}`" for choice in field.choices) or field.rule.removeprefix("must be "),
            f"`{_default(DEFAULTS[name])}`" if name in DEFAULTS else "",
        ]
        for name, field in FIELDS.items()
    ]
    return [
        "## Fields of an experiment",
        "",
        "Flags of the command line carry the same names with hyphens, links the same names as they are. What is left",
        "out comes from the scenario, then from the last column.",
        "",
        *table(["field", "symbol", "unit", "what it is", "admitted", "default"], rows),
    ]


def _conventions() -> list[str]:
    rows = [[f"`{c.name}`", " and ".join(c.terms), c.used_by] for c in CONVENTIONS.values()]
    return ["## Gain conventions", "", *table(["name", "γ and η multiply the innovation by", "used by"], rows)]


def _designs() -> list[str]:
    rows = [
        [
            f"`{d.name}`",
            str(order),
            ", ".join(f"`{name}` {domain.rule.removeprefix('must be ')}" for name, domain in d.parameters.items()),
            d.formula[order],
            d.source,
            d.remark,
        ]
        for d in DESIGNS.values()
        for order in d.orders
    ]
    return [
        "## Designs",
        "",
        "Formulas give normalised gains.",
        "",
        *table(["name", "order", "from", "formula", "source", "remark"], rows),
    ]


def _methods() -> list[str]:
    rows = [
        [
            f"`{m.name}`",
            ", ".join(map(str, m.orders)),
            ", ".join(f"`{name}` {_parameter(default)}" for name, default in m.parameters.items()) or "none",
            m.sentence,
            m.hindsight(m.defaults(1.0)),
            m.source,
        ]
        for m in METHODS.values()
    ]
    return [
        "## Methods that choose the gains as the filter runs",
        "",
        "What is left out takes its default; T is the interval. An oracle looks in hindsight: no tracker could run it.",
        "",
        *table(["name", "order", "parameters and defaults", "what it does", "oracle", "source"], rows),
    ]


def _noise() -> list[str]:
    pushes = [[f"`{m.name}`", m.formula or m.title, m.unit] for m in MANOEUVRES.values()]
    return [
        "## Noise",
        "",
        *table(["name", "what it is"], [[f"`{name}`", noise.title] for name, noise in NOISES.items()]),
        "Manoeuvre noise pushes the target, d(k+1) = F d(k) + G w(k):",
        "",
        *table(["name", "G", "unit of w"], pushes),
    ]


def _scenarios() -> list[str]:
    rows = [[f"`{s.name}`", ", ".join(s.axes), s.description, s.source] for s in SCENARIOS.values()]
    return ["## Scenarios", "", *table(["name", "axes", "what it is", "source"], rows)]


def _starts() -> list[str]:
    rows = [[f"`{s.name}`", s.sentence] for s in STARTS.values()]
    return ["## Starts", "", *table(["name", "what it does"], rows)]


def _metrics() -> list[str]:
    rows = [[f"`{name}`", m.unit, m.sentence, m.formula] for name, m in METRICS.items()]
    return [
        "## Metrics",
        "",
        "Sums and means run over the samples at which the error is defined: not before the filter predicts, not where",
        "a measurement is missing, not after a stop.",
        "",
        *table(["name", "unit", "what it is", "formula"], rows),
    ]


def _runs() -> list[str]:
    rows = [
        [p.title, r.title, ", ".join(f"{k} {v}" for k, v in r.experiment.to_dict(minimal=True).items()), r.note]
        for p in papers().values()
        for r in p.runs
    ]
    return ["## Runs of the source documents", "", *table(["document", "run", "experiment", "note"], rows)]


def _parameter(default: object) -> str:
    """A default in words; one that depends on the interval at two of them."""
    if callable(default):
        return f"{default(1.0):g} at T = 1 s, {default(0.1):g} at 0.1 s"
    return "searched" if default is None else str(default)


def _default(value: object) -> str:
    return ", ".join(f"{item:g}" for item in value) if isinstance(value, tuple) else str(value)


if __name__ == "__main__":
    TARGET.write_text(reference(), encoding="utf-8")
