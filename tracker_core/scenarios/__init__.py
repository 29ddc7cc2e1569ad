"""Targets: one file each family, and the ordered registry that menus, docs, command line and tests read."""

from tracker_core.scenarios import alwagih, climbing_turn, coordinated_turn, garg, jeong_ship, polynomial, singer, yu_wu
from tracker_core.scenarios.base import Recording, Scenario

SCENARIOS: dict[str, Scenario] = {
    scenario.name: scenario
    for scenario in (
        jeong_ship.SCENARIO,
        yu_wu.SCENARIO,
        alwagih.SCENARIO,
        climbing_turn.SCENARIO,
        coordinated_turn.SCENARIO,
        singer.SCENARIO,
        garg.CONSTANT_VELOCITY,
        garg.CONSTANT_VELOCITY_EARLIER,
        garg.ACCELERATING,
        garg.ACCELERATING_EARLIER,
        polynomial.CONSTANT_VELOCITY,
        polynomial.CONSTANT_ACCELERATION,
    )
}

__all__ = ["SCENARIOS", "Recording", "Scenario"]
