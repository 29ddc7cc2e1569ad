"""The command `reproduce`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from typing import Any

from tracker_core.checks import InputError, check_choice
from tracker_core.commands.base import Commands, print_json
from tracker_core.papers import NAMES, Outcome, Paper, Table, count, papers, reproduce


def add(commands: Commands) -> None:
    """Add the command to a parser."""
    parser = commands.add_parser("reproduce", help="recompute the tables of a source document beside the printed cells")
    parser.add_argument(
        "paper", metavar="PAPER", nargs="?", help=f"{', '.join(NAMES)}; all, counted, where it is left out"
    )
    parser.add_argument("--table", metavar="N", help="one table only")
    parser.add_argument("--seeds", metavar="N", help="runs per simulated cell, instead of the table's own number")
    parser.set_defaults(action=_reproduce)


def _reproduce(options: argparse.Namespace) -> None:
    if options.paper is None and options.table is not None:
        raise InputError("table", "must be left out where no document is named", options.table)
    names = NAMES if options.paper is None else (check_choice("paper", options.paper, NAMES),)
    found: dict[str, dict[str, list[Outcome]]] = {}
    for name in names:
        paper = papers()[name]
        tables = paper.tables if options.table is None else (paper.table(options.table),)
        found[name] = {}
        for table in tables:
            _progress(f"{paper.title}, table {table.name} …")
            found[name][table.name] = reproduce(paper, table, options.seeds)
    _progress("")
    if options.json:
        print_json(_summary(found))
        return
    if options.paper is not None:
        for table_name, outcomes in found[options.paper].items():
            _print_table(papers()[options.paper], papers()[options.paper].table(table_name), outcomes)
    _print_counts(found)


def _progress(text: str) -> None:
    """What is being computed, on a line that the next text overwrites; nothing where nobody looks."""
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)


def _summary(found: dict[str, dict[str, list[Outcome]]]) -> dict[str, Any]:
    return {
        "papers": {
            name: {
                "tables": {table: [outcome.to_dict() for outcome in outcomes] for table, outcomes in tables.items()},
                "counts": count(_all(tables)),
            }
            for name, tables in found.items()
        },
        "counts": count(outcome for tables in found.values() for outcome in _all(tables)),
    }


def _all(tables: dict[str, list[Outcome]]) -> Iterable[Outcome]:
    return (outcome for outcomes in tables.values() for outcome in outcomes)


def _print_table(paper: Paper, table: Table, outcomes: list[Outcome]) -> None:
    print(f"{paper.title}, table {table.name}: {table.title}")
    print(table.note)
    titles = [("row", "column", "printed", "recomputed", "another run within", "difference", "verdict")]
    rows = [(o.row, o.column, o.printed, f"{o.value:.6g}", _interval(o), _difference(o), o.said) for o in outcomes]
    widths = [max(map(len, column)) for column in zip(*titles, *rows, strict=True)]
    for row in titles + rows:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    for reason in dict.fromkeys(outcome.reason for outcome in outcomes if outcome.reason):
        said = next(outcome.said for outcome in outcomes if outcome.reason == reason)
        print(f"{said}: {reason}")
    print()


def _interval(outcome: Outcome) -> str:
    found = outcome.estimate
    return "" if found is None else f"{found.low:.6g} … {found.high:.6g}"


def _difference(outcome: Outcome) -> str:
    return "" if outcome.difference is None else f"{100 * outcome.difference:+.3g} %"


def _print_counts(found: dict[str, dict[str, list[Outcome]]]) -> None:
    counts = {name: count(_all(tables)) for name, tables in found.items()}
    if len(counts) > 1:
        counts["all"] = count(outcome for tables in found.values() for outcome in _all(tables))
    width = max(map(len, counts))
    for name, verdicts in counts.items():
        print(f"{name:{width}}  {sum(verdicts.values()):4} cells  ", end="")
        print(", ".join(f"{number} {verdict}" for verdict, number in verdicts.items()))
