"""Where a smooth function of one number is greatest, and where it falls to a level: each value is dear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt

import numpy as np

from tracker_core.types import FloatArray

_GOLDEN = (3 - sqrt(5)) / 2
_SPACING = 1.5


@dataclass(frozen=True, slots=True)
class Profile:
    """A function between two ends.

    Attributes:
        function: of places, shape (m,), to values of the same shape.
        low, high: the ends.
    """

    function: Callable[[FloatArray], FloatArray]
    low: float
    high: float

    def at(self, place: float) -> float:
        """Its value at one place."""
        return float(self.function(np.array([place]))[0])

    def peak(self, tolerance: float) -> tuple[float, float]:
        """Where it is greatest of all places, and its value there; the hills must be 1.5 wide or wider."""
        places = np.linspace(self.low, self.high, round((self.high - self.low) / _SPACING) + 1)
        values = self.function(places)
        best = int(np.argmax(values))
        low, high = places[max(0, best - 1)], places[min(len(places) - 1, best + 1)]
        return self._highest(float(low), float(places[best]), float(high), float(values[best]), tolerance)

    def peak_near(self, start: float, tolerance: float) -> tuple[float, float]:
        """The top of the hill that a place lies on, and its value there."""
        step, at, value = max(0.1, 10 * tolerance), start, self.at(start)
        while True:
            low, high = max(self.low, at - step), min(self.high, at + step)
            below, above = (float(one) for one in self.function(np.array([low, high])))
            if max(below, above) <= value or low == high:
                return self._highest(low, at, high, value, tolerance)
            at, value = (low, below) if below > above else (high, above)
            step *= 2

    def _highest(self, low: float, at: float, high: float, value: float, tolerance: float) -> tuple[float, float]:
        """Brent's method (1973, Algorithms for Minimization without Derivatives, chapter 5) from three places."""
        second = third = at
        second_value = third_value = value
        move = before = 0.0
        for _ in range(100):
            middle = (low + high) / 2
            if abs(at - middle) <= 2 * tolerance - (high - low) / 2:
                break
            # The vertex of the parabola through the three best, unless it leaves the bracket or hardly narrows it.
            r = (at - second) * (value - third_value)
            q = (at - third) * (value - second_value)
            p = (at - third) * q - (at - second) * r
            q = 2 * (q - r)
            p, q = (-p, q) if q > 0 else (p, -q)
            if abs(before) > tolerance and abs(p) < abs(q * before / 2) and q * (low - at) < p < q * (high - at):
                before, move = move, p / q
            else:
                before = (high if at < middle else low) - at
                move = _GOLDEN * before
            tried = at + (move if abs(move) >= tolerance else tolerance if move > 0 else -tolerance)
            new = self.at(tried)
            if new >= value:
                low, high = (at, high) if tried >= at else (low, at)
                third, third_value, second, second_value = second, second_value, at, value
                at, value = tried, new
            else:
                low, high = (low, tried) if tried >= at else (tried, high)
                if new >= second_value or second == at:
                    third, third_value, second, second_value = second, second_value, tried, new
                elif new >= third_value or third in {at, second}:
                    third, third_value = tried, new
        return at, value

    def crossing(self, at: float, value: float, level: float, end: float, tolerance: float) -> float | None:
        """Where it falls to a level, on the way from a place with a value above it to an end; None where it does not.

        The way is bracketed with growing steps and cut by the Illinois method (Dowell & Jarratt 1971, BIT 11, 168-174).
        """
        step, near, far = 0.2, (at, value - level), (at, value - level)
        while far[1] > 0:
            if far[0] == end:
                return None
            near = far
            place = min(end, far[0] + step) if end > at else max(end, far[0] - step)
            far = place, self.at(place) - level
            step *= 2
        (one, above), (other, below) = near, far
        side = 0
        for _ in range(60):
            if abs(other - one) <= tolerance:
                break
            tried = one + (other - one) * above / (above - below)
            new = self.at(tried) - level
            if abs(new) <= tolerance:
                return tried
            if new > 0:
                one, above, below = tried, new, below / 2 if side > 0 else below
                side = 1
            else:
                other, below, above = tried, new, above / 2 if side < 0 else above
                side = -1
        return (one + other) / 2
