"""What the pages' scripts send, described once: for the callbacks, the socket of a moving slider and that of studies.

Only form and size are described here. A control that holds what means nothing (an alpha of "abc") is a good question,
and the answer says beside the field what is wrong.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Literal

from msgspec import Meta, Struct

from layouts.pinning import Action
from layouts.pins import SLOTS, TEXT_LENGTH, Slot
from layouts.reading import READING_FIELDS
from layouts.rules import OF_THE_MOMENT
from layouts.scenes import TOKEN
from layouts.state import LIMIT_FIELDS, VIEW_FIELDS
from server.typed import Reader, reader
from tracker_core.checks import InputError
from tracker_core.fields import FIELDS

CONTROLS = frozenset(
    (*FIELDS, *READING_FIELDS, *VIEW_FIELDS, *LIMIT_FIELDS, *OF_THE_MOMENT, "preset", "responsiveness", "written")
)
"""Every control there is, on whatever page."""

TEXT_LIMIT = 200
"""Characters in a control; assets/desk.js lets nobody type more."""

TEXT_LIMITS = {"reading": int(FIELDS["reading"].domain.high), "pole": 400}
"""Of those that may hold more."""

WHOLE = 2**63
"""Whole numbers beyond this are taken as a browser has them, with a few digits: an answer can say no longer ones."""

LINK_LENGTH = 8_000
"""Characters of a link, far more than one of ours has."""

LONG_RUN = 3_000
"""Runs of more samples than this leave the event loop to others."""

Number = Annotated[int, Meta(ge=0, le=2**53)]
Control = str | int | float | None
Name = Annotated[str, Meta(max_length=40)]
Names = Annotated[list[Name], Meta(max_length=len(CONTROLS))]
Key = Annotated[str, Meta(max_length=8_000)]
Theme = Literal["light", "dark"]


class Question(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """What a page with plots asks after a change of its controls.

    Attributes:
        seq: number of the question; the answer bears it.
        controls: every control as it stands, by name.
        changed: names of those that a hand has moved, in its order.
        pins: the pinned filters, pairs of slot and text.
        pinning: what is done with them.
        drawn: what the page shows: per plot the key that the answer gave it.
        link: that says what the page shows; None where it shows nothing yet, or a slider moves.
        want: plots and tables that are to be updated; all plots if left out.
        theme: of the plots.
        scene: the token of the page's scene in three dimensions; empty for none.
    """

    seq: Number
    controls: Annotated[dict[Name, Control], Meta(max_length=len(CONTROLS))]
    changed: Names = []
    pins: Annotated[list[tuple[Slot, Annotated[str, Meta(max_length=TEXT_LENGTH)]]], Meta(max_length=len(SLOTS))] = []
    pinning: Annotated[list[Action], Meta(max_length=100)] = []
    drawn: Annotated[dict[Name, Key], Meta(max_length=20)] = {}
    link: Annotated[str, Meta(max_length=LINK_LENGTH)] | None = None
    want: Annotated[list[Name], Meta(max_length=20)] | None = None
    theme: Theme = "light"
    scene: Annotated[str, Meta(pattern=rf"^({TOKEN.pattern})?\Z")] = ""

    def __post_init__(self) -> None:
        _check_names("controls", self.controls, CONTROLS)
        _check_names("changed", self.changed, CONTROLS)
        for name, value in self.controls.items():
            if isinstance(value, str) and len(value) > (limit := TEXT_LIMITS.get(name, TEXT_LIMIT)):
                raise InputError(f"controls.{name}", f"must have at most {limit} characters", value)
            if isinstance(value, int) and not -WHOLE <= value < WHOLE:
                self.controls[name] = _inexact(name, value)

    @property
    def is_long(self) -> bool:
        """Whether others would have to wait for the answer."""
        # Numba takes half a second to import, and a server that starts has better things to do.
        from tracker_core.kernels.loading import held

        # Of what is pinned every filter may run, a file may have to be read first, and where an entry is wrong it is
        # another run that is drawn in another theme.
        if self.pins or self.pinning or self.controls.get("data") or self.otherwise_drawn():
            return True
        try:
            return float(self.controls.get("samples") or 0) > LONG_RUN or held()
        except (ValueError, OverflowError):
            return False

    def otherwise_drawn(self) -> list[str]:
        """The plots that the page shows in another theme."""
        return [name for name, key in self.drawn.items() if key and not key.startswith(theme_key(self.theme))]


def theme_key(theme: str) -> str:
    """How the key of every plot in a theme begins."""
    return f"{theme}|"


def _inexact(name: str, value: int) -> float:
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"controls.{name}", "must have at most 308 digits", value) from None


class StudyQuestion(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """What a page asks about its study.

    Attributes:
        seq: number of the question; the answer bears it.
        query: the link that says which study.
        theme: of the plots.
        stop: whether it is to end.
        look: whether what it had come to when it was stopped is wanted, and nothing computed.
    """

    seq: Number
    query: Annotated[str, Meta(max_length=LINK_LENGTH)] = ""
    theme: Theme = "light"
    stop: bool = False
    look: bool = False


_read: Reader[Question] = reader(Question, "question")

read_study_question: Reader[StudyQuestion] = reader(StudyQuestion, "question")


def page_reader(parts: Collection[str]) -> Reader[Question]:
    """What reads the questions of the page that has these plots and tables; raises InputError."""
    known = frozenset(parts)

    def read(raw: bytes | str) -> Question:
        question = _read(raw)
        _check_names("want", question.want or (), known)
        _check_names("drawn", question.drawn, known)
        return question

    return read


def _check_names(field: str, names: Collection[str], known: frozenset[str]) -> None:
    if not known.issuperset(names):
        raise InputError(field, "must name what the page has", next(name for name in names if name not in known))
