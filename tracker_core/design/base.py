"""What a gain design is: a formula, its domain, its source."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tracker_core.checks import Domain, InputError
from tracker_core.types import FloatArray


@dataclass(frozen=True, slots=True)
class Design:
    """A way of choosing the gains.

    Attributes:
        name: key in the registry.
        title: for menus.
        parameters: what it is computed from, each with its domain; names are fields of the experiment.
        formulas: per filter order, the function from the parameters to the normalised gain vector.
        formula: the same in mathematical notation, normalised gains.
        source: where it comes from.
        remark: what a user should know before using it; may be empty.
    """

    name: str
    title: str
    parameters: Mapping[str, Domain]
    formulas: Mapping[int, Callable[..., tuple[float, ...]]]
    formula: Mapping[int, str]
    source: str
    remark: str = ""

    @property
    def orders(self) -> tuple[int, ...]:
        """The filter orders that it serves, ascending."""
        return tuple(sorted(self.formulas))

    def gains(self, order: int | None = None, **parameters: Any) -> FloatArray:
        """Normalised gains for one order.

        Args:
            order: the filter order; may be left out where the design serves one only.
            parameters: a number for every name in `self.parameters`.

        Returns:
            g, shape (order,).

        Raises:
            InputError: for an order it does not serve, a missing or unknown parameter, or one outside its domain.
        """
        if order is None and len(self.formulas) == 1:
            order = self.orders[0]
        if order is None or order not in self.formulas:
            raise InputError("order", f"must be {_either(self.orders)} for the design '{self.name}'", order)
        for name, value in parameters.items():
            if name not in self.parameters:
                raise InputError(name, f"must be left out for the design '{self.name}'", value)
        numbers = {}
        for name, domain in self.parameters.items():
            if parameters.get(name) is None:
                raise InputError(name, f"must be given for the design '{self.name}'", None)
            numbers[name] = domain.check(name, parameters[name])
        return np.array(self.formulas[order](**numbers), dtype=np.float64)


def _either(orders: tuple[int, ...]) -> str:
    return " or ".join(str(order) for order in orders)
