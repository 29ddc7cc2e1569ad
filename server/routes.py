"""By what name a route is counted and logged."""

from __future__ import annotations

from dataclasses import dataclass

from starlette.types import Scope

NONE = "none"
"""Of what no route was found for, or looked for."""

METHODS = frozenset(("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"))


@dataclass(frozen=True, slots=True)
class Served:
    """What stands in a scope, as a route does, where something was served that has none.

    Attributes:
        path: its template.
    """

    path: str


def template(scope: Scope) -> str:
    """The path of the route that was found, with names in place of what differs."""
    route = scope.get("route")
    if route is not None:
        return getattr(route, "path", NONE)
    # A folder of files has no route of its own, but routing says where it begins.
    return scope.get("root_path") or NONE if "endpoint" in scope else NONE
