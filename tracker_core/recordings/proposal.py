"""A reading as it is being put together, with the reason for every choice."""

from __future__ import annotations

from dataclasses import dataclass, field

from tracker_core.recordings.layout import Layout


@dataclass(slots=True)
class Proposal:
    """Fields of a reading, and why.

    Attributes:
        format: what the file was recognised as.
        values: fields of Reading by name.
        why: a sentence for each of them that was chosen for a reason.
        ids: columns, from 1, that may tell tracks apart, the likeliest first.
    """

    format: str
    values: dict[str, object] = field(default_factory=dict)
    why: dict[str, str] = field(default_factory=dict)
    ids: list[int] = field(default_factory=list)

    @property
    def at(self) -> tuple[int, ...]:
        """Columns of the position, as far as they are chosen."""
        at = self.values.get("at", ())
        return at if isinstance(at, tuple) else ()

    def choose(self, name: str, value: object, why: str) -> None:
        """Set one field."""
        self.values[name] = value
        self.why[name] = why


def titled(layout: Layout, column: int) -> str:
    """The name of a column, counted from 0, as text for a sentence."""
    name = layout.names[column][:40]
    return f"“{name}”" if name else f"column {column + 1}"
