"""What a source document is: citation, runs, tables as printed, figures, errata; read from one TOML file each."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from tracker_core.checks import check_choice
from tracker_core.experiment import Experiment

NAMES = ("jeong2017", "njonjo2016", "yu2017", "alwagih", "garg2021")


@dataclass(frozen=True, slots=True)
class Run:
    """One run that a document reports.

    Attributes:
        name: key within the document.
        title: for menus.
        note: what to look at, or where the document and the run differ.
        experiment: its description.
    """

    name: str
    title: str
    note: str
    experiment: Experiment


@dataclass(frozen=True, slots=True)
class Equation:
    """One equation of a document, or several that belong together.

    Attributes:
        name: as the document counts it.
        formula: what it says, in the symbols of the document.
        what: what it is.
        here: what implements it.
        errata: numbers of the errata about it.
    """

    name: str
    formula: str
    what: str
    here: str
    errata: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table.

    Attributes:
        name: key within the table.
        title: as the heading says it.
        unit: SI symbol; empty for a pure number.
        recipe: how its cells are recomputed, a name in `recipes`.
        options: what the recipe is told.
    """

    name: str
    title: str
    unit: str
    recipe: str
    options: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Row:
    """One row of a table.

    Attributes:
        name: key within the table.
        title: as it stands before the cells.
        cells: one per column, as printed; EMPTY where nothing is.
        run: name of the run that the row reports; empty for none.
        recipe: recomputes the cells instead of the columns' recipes; empty for none.
        recipes: the same for single cells, by column.
        options: what the recipe is told beside the columns' options.
    """

    name: str
    title: str
    cells: tuple[str, ...]
    run: str
    recipe: str
    recipes: Mapping[str, str]
    options: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Table:
    """One table of a document, or numbers that its text prints.

    Attributes:
        name: as the document counts it, or a word.
        title: what it shows.
        note: with which settings it is recomputed.
        left_out: what the document does not say, and its cells therefore cannot be determined; empty where it says
            everything.
        caveat: what must be said with every cell that lies within its interval; empty for nothing.
        comparable: whether a printed number may be compared with the recomputed interval at all.
        seeds: how many runs a simulated cell is recomputed from by default; 0 where nothing is simulated.
        variants: settings that the document leaves open: a name, a title and the fields of the experiment to change.
        columns: from left to right.
        rows: from top to bottom.
    """

    name: str
    title: str
    note: str
    left_out: str
    caveat: str
    comparable: bool
    seeds: int
    variants: tuple[Mapping[str, Any], ...]
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]

    def column(self, name: str) -> int:
        """Index of a column."""
        return [column.name for column in self.columns].index(name)

    def row(self, name: str) -> Row:
        """A row by name."""
        return next(row for row in self.rows if row.name == name)

    def printed(self, row: str, column: str) -> str:
        """A cell as printed."""
        return self.row(row).cells[self.column(column)]


@dataclass(frozen=True, slots=True)
class Illustration:
    """One figure of a document.

    Attributes:
        name: as the document counts it, or a word.
        title: what it shows.
        note: what it is drawn from, and what to look at.
        kind: how it is drawn.
        options: what the drawing is told; `runs` are names of runs.
    """

    name: str
    title: str
    note: str
    kind: str
    options: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Erratum:
    """One place where a document is wrong, or says less than it needs.

    Attributes:
        number: counted within the document.
        title: in one line.
        where: equations, tables, sections.
        claim: what the document prints.
        evidence: what is found instead, and how one sees it.
        consequence: what follows for the reader.
        cells: the cells that it explains, as (table, row, column).
        proof: name of its proof, a name in `proofs`.
        runs: names of runs that show it.
    """

    number: int
    title: str
    where: str
    claim: str
    evidence: str
    consequence: str
    cells: tuple[tuple[str, str, str], ...]
    proof: str
    runs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Paper:
    """One source document.

    Attributes:
        name: key in the registry.
        title: short, for menus.
        citation: in full.
        summary: what it does, in a sentence or two.
        runs, equations, tables, figures, errata: in the order of the document.
    """

    name: str
    title: str
    citation: str
    summary: str
    runs: tuple[Run, ...]
    equations: tuple[Equation, ...]
    tables: tuple[Table, ...]
    figures: tuple[Illustration, ...]
    errata: tuple[Erratum, ...]

    def run(self, name: str) -> Run:
        """A run by name."""
        return next(run for run in self.runs if run.name == name)

    def table(self, name: str) -> Table:
        """A table by name.

        Raises:
            InputError: naming the tables that there are.
        """
        check_choice("table", name, [table.name for table in self.tables])
        return next(table for table in self.tables if table.name == name)

    def erratum(self, table: str, row: str, column: str) -> Erratum | None:
        """The erratum that explains a cell."""
        return next((erratum for erratum in self.errata if (table, row, column) in erratum.cells), None)


@cache
def papers() -> dict[str, Paper]:
    """All source documents by name."""
    return {name: _load(name) for name in NAMES}


def _load(name: str) -> Paper:
    data: dict[str, Any] = tomllib.loads(files(__package__).joinpath(f"{name}.toml").read_text(encoding="utf-8"))
    return Paper(
        name,
        data["title"],
        data["citation"],
        data["summary"],
        tuple(
            Run(run["name"], run["title"], run["note"], Experiment.from_dict(run["experiment"])) for run in data["runs"]
        ),
        tuple(
            Equation(each["name"], each["formula"], each["what"], each["here"], tuple(each["errata"]))
            for each in data["equations"]
        ),
        tuple(_table(table) for table in data["tables"]),
        tuple(_illustration(dict(figure)) for figure in data["figures"]),
        tuple(_erratum(number, erratum) for number, erratum in enumerate(data["errata"], 1)),
    )


def _table(data: dict[str, Any]) -> Table:
    return Table(
        name=data["name"],
        title=data["title"],
        note=data["note"],
        left_out=data.get("left_out", ""),
        caveat=data.get("caveat", ""),
        comparable=data.get("comparable", True),
        seeds=data.get("seeds", 0),
        variants=tuple(data.get("variants", ())),
        columns=tuple(_column(dict(column)) for column in data["columns"]),
        rows=tuple(_row(dict(row)) for row in data["rows"]),
    )


def _column(data: dict[str, Any]) -> Column:
    name, title = data.pop("name"), data.pop("title")
    return Column(name, title, data.pop("unit", ""), data.pop("recipe", ""), data)


def _row(data: dict[str, Any]) -> Row:
    name, title, cells = data.pop("name"), data.pop("title"), tuple(data.pop("cells"))
    return Row(name, title, cells, data.pop("run", ""), data.pop("recipe", ""), data.pop("recipes", {}), data)


def _illustration(data: dict[str, Any]) -> Illustration:
    name, title, note, kind = (data.pop(key) for key in ("name", "title", "note", "kind"))
    return Illustration(name, title, note, kind, data)


def _erratum(number: int, data: dict[str, Any]) -> Erratum:
    return Erratum(
        number=number,
        title=data["title"],
        where=data["where"],
        claim=data["claim"],
        evidence=data["evidence"],
        consequence=data["consequence"],
        cells=tuple((table, row, column) for table, row, column in data.get("cells", ())),
        proof=data["proof"],
        runs=tuple(data.get("runs", ())),
    )
