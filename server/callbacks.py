"""What Dash's script sends to have a callback answered, described, and compared with how the callback was declared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from msgspec import Meta, Raw, Struct

from server.typed import Reader, reader
from tracker_core.checks import InputError

_Text = Annotated[str, Meta(max_length=200)]


class Place(Struct, forbid_unknown_fields=True, frozen=True, rename={"name": "property"}):
    """A property of a component."""

    id: _Text
    name: _Text

    def __str__(self) -> str:
        return f"{self.id}.{self.name}"

    def plain(self) -> dict[str, Any]:
        """As Dash has it."""
        return {"id": self.id, "property": self.name}


class Given(Struct, forbid_unknown_fields=True, frozen=True, rename={"name": "property"}):
    """A property of a component with its value, which nobody has looked at."""

    id: _Text
    name: _Text
    value: Raw

    @property
    def place(self) -> Place:
        """Whose value it is."""
        return Place(self.id, self.name)


class Asked(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True, rename="camel"):
    """The body of the request."""

    output: Annotated[str, Meta(max_length=2_000)]
    outputs: Annotated[list[Place], Meta(max_length=50)] | Place
    inputs: Annotated[list[Given], Meta(max_length=50)]
    state: Annotated[list[Given], Meta(max_length=50)] = []
    changed_prop_ids: Annotated[list[_Text], Meta(max_length=50)] = []
    parsed_changed_props_ids: Annotated[list[_Text], Meta(max_length=50)] = []


read_asked: Reader[Asked] = reader(Asked, "body")


@dataclass(frozen=True, slots=True)
class Declared:
    """A callback that the server answers, as it was declared.

    Attributes:
        outputs: a list where it has several.
        inputs: that it is called for.
        state: that it is given beside them.
    """

    outputs: list[Place] | Place
    inputs: list[Place]
    state: list[Place]

    @classmethod
    def of(cls, callback: Mapping[str, Any]) -> Declared:
        """From an entry of Dash's map of callbacks."""
        output = callback["output"]
        outputs = [*map(_place, output)] if isinstance(output, list | tuple) else _place(output)
        inputs, state = (
            [Place(each["id"], each["property"]) for each in callback[name]] for name in ("inputs", "state")
        )
        return cls(outputs, inputs, state)

    def check(self, asked: Asked) -> None:
        """Whether it is asked as it was declared.

        Raises:
            InputError: naming the part of the body that is not as declared.
        """
        if asked.outputs != self.outputs:
            raise InputError("outputs", "must be those of the output, in their order", _named(asked.outputs))
        for field, given, places in (("inputs", asked.inputs, self.inputs), ("state", asked.state, self.state)):
            if (named := [each.place for each in given]) != places:
                raise InputError(field, f"must be {_named(places) or 'empty'}", _named(named))
        if not {*asked.changed_prop_ids} <= {*map(str, self.inputs)}:
            raise InputError("changedPropIds", f"must be among {_named(self.inputs)}", asked.changed_prop_ids)
        if asked.parsed_changed_props_ids not in ([], asked.changed_prop_ids):
            raise InputError("parsedChangedPropsIds", "must be the changedPropIds", asked.parsed_changed_props_ids)


def _place(output: Any) -> Place:
    return Place(output.component_id, output.component_property)


def _named(places: Sequence[Place] | Place) -> str:
    return ", ".join(map(str, [places] if isinstance(places, Place) else places))
