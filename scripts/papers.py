"""Writes docs/papers.md, the source documents recomputed, and their counts in the README."""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from scripts.reference import table  # noqa: E402
from tracker_core.papers import VERDICTS, Erratum, Outcome, Paper, Table, count, papers, prove, reproduce  # noqa: E402

TARGET = ROOT / "docs" / "papers.md"
README = ROOT / "README.md"
BEGIN, END = "<!-- verdicts: written by scripts/papers.py -->", "<!-- end of verdicts -->"


def page() -> str:
    """The whole page."""
    parts = [
        "# The papers, recomputed",
        "",
        "Written by `scripts/papers.py` from the data in `tracker_core/papers/`; the page *Papers* shows the same with",
        "figures and runs, `python -m tracker_core reproduce` prints it. What the verdicts mean:",
        "",
        *(f"- **{verdict}**: {sentence}" for verdict, sentence in VERDICTS.items()),
        "",
        "A number that depends on noise is the median of runs with the seeds 1, 2, ... Beside it stands the interval",
        "in which another run falls with the probability of 90 % or a little more, whatever the distribution: of n",
        "runs sorted, the next one lies between the k-th least and the k-th greatest with (n + 1 − 2k)/(n + 1).",
        "",
        *counts(),
    ]
    for paper in papers().values():
        parts += _paper(paper)
    return "\n".join(parts)


def counts() -> list[str]:
    """How many cells of every document have each verdict."""
    rows, total = [], dict.fromkeys(VERDICTS, 0)
    for paper in papers().values():
        found = count(outcome for each in paper.tables for outcome in reproduce(paper, each))
        rows.append([paper.title, *map(str, found.values()), str(len(paper.errata))])
        total = {verdict: total[verdict] + found[verdict] for verdict in total}
    errata = sum(len(paper.errata) for paper in papers().values())
    rows.append(["all", *map(str, total.values()), str(errata)])
    return table(["document", *VERDICTS, "errata"], rows)


def _paper(paper: Paper) -> list[str]:
    parts = [f"## {paper.title}", "", f"{paper.summary} {paper.citation}", ""]
    parts += table(
        ["eq.", "formula", "what it is", "here"], [[e.name, e.formula, e.what, e.here] for e in paper.equations]
    )
    for each in paper.tables:
        parts += _table(each, reproduce(paper, each))
    for erratum in paper.errata:
        parts += _erratum(erratum)
    return parts


def _table(each: Table, outcomes: list[Outcome]) -> list[str]:
    name = f"Table {each.name}" if each.name[0].isdigit() else each.name.replace("-", " ").capitalize()
    titles = {row.name: row.title for row in each.rows}
    columns = {column.name: column.title for column in each.columns}
    rows = [[titles[o.row], columns[o.column], o.printed, f"{o.value:.5g}", _interval(o), o.said] for o in outcomes]
    left_out = ["Left open: " + each.left_out, ""] if each.left_out else []
    head = ["row", "column", "printed", "recomputed", "another run within", "verdict"]
    return [f"### {name}. {each.title}", "", each.note, "", *left_out, *table(head, rows)]


def _interval(outcome: Outcome) -> str:
    found = outcome.estimate
    return "" if found is None else f"{found.low:.4g} – {found.high:.4g}"


def _erratum(erratum: Erratum) -> list[str]:
    proof = prove(erratum.proof)
    return [
        f"### Erratum {erratum.number}. {erratum.title}",
        "",
        f"*{erratum.where}.* {erratum.claim} {erratum.evidence} {erratum.consequence}",
        "",
        f"{proof.formula}:",
        "",
        *(f"- {label}: {value}" for label, value in proof.lines),
        "",
    ]


def readme() -> str:
    """The README with the counts of today."""
    text = README.read_text(encoding="utf-8")
    written = "\n".join([BEGIN, "", *counts(), END])
    return re.sub(f"{re.escape(BEGIN)}.*?{re.escape(END)}", lambda _: written, text, flags=re.DOTALL)


if __name__ == "__main__":
    TARGET.write_text(page(), encoding="utf-8")
    README.write_text(readme(), encoding="utf-8")
