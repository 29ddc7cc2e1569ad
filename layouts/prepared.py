"""Parts of a page that are the same for every visit, with their JSON worked out once.

To build such a part and to write it out again for every visitor costs more than all that a visit asks besides.
"""

from __future__ import annotations

from typing import Any

import orjson
from dash._utils import to_json
from dash.development.base_component import Component


def prepared(*parts: Component) -> tuple[Component, ...]:
    """The same parts, what is in them as ready JSON. They stand in many answers: nobody may change them any more."""
    for part in parts:
        described: dict[str, Any] = part.to_plotly_json()
        if "children" in described["props"]:
            described["props"]["children"] = orjson.Fragment(to_json(part.children))
        part.to_plotly_json = _always(described)  # type: ignore[method-assign]
    return parts


def _always(described: dict[str, Any]) -> Any:
    return lambda: described
