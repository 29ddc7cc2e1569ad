"""The stable region: intervals, slices, the surface of order 3, and the way back into it.

Normalised gains throughout. Every gain enters every inequality of the region linearly, or quadratically with a
leading coefficient that is negative wherever anything is stable: given the others, one gain is stable on one interval.
With two gains free, the stable values of either make up one interval too (`_ends`); all ends are in closed form.
"""

from __future__ import annotations

from itertools import combinations, product
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from tracker_core.checks import Domain, InputError
from tracker_core.conventions import Gains
from tracker_core.poles import padded
from tracker_core.projection import nearest_within, scaled_poles
from tracker_core.stability import is_stable, stable
from tracker_core.types import GAIN_NAMES, ORDERS, FloatArray

PLANES: dict[int, tuple[tuple[str, str], ...]] = {order: tuple(combinations(GAIN_NAMES[:order], 2)) for order in ORDERS}
"""The planes of two gains per order."""

BOX: dict[int, tuple[float, ...]] = {2: (2.0, 4.0), 3: (2.0, 4.0, 8.0), 4: (2.0, 16 / 3, 8.0, 16.0)}
"""Upper end of every gain over the whole region of an order; the lower end is 0.

The convex hull of the coefficients of all stable polynomials of degree n is the simplex with the corners
(z - 1)^k (z + 1)^(n - k) (Fam & Meditch 1978, IEEE Trans. Automatic Control AC-23, 454-458), and gains are affine in
the coefficients: at order 4 the corners are 0, (2, 0, 0, 0), (0, 4, 0, 0), (2, 0, 8, 0) and (0, 16/3, 0, 16).
"""

POINTS = Domain(2, 1e6, whole=True)
RADIUS = 0.99
"""Largest pole of the gains that `nearest_stable` gives: inside the region, not on its border."""

WITHIN = Domain(0, 1, low_open=True, high_open=True)
STEPS = Domain(1, 1000, whole=True)


def gain_interval(vectors: FloatArray, index: int) -> tuple[FloatArray, FloatArray]:
    """The open interval of one gain that is stable with the others.

    Args:
        vectors: normalised gains, shape (..., order); their own entry `index` is not used.
        index: 0 to order - 1 for alpha to eta.

    Returns:
        Lower and upper end, each of shape (...); both 0 where no value is stable.

    Raises:
        InputError: for an index that the order does not have.
    """
    if index not in range(vectors.shape[-1]):
        raise InputError("index", f"must be one of 0 to {vectors.shape[-1] - 1}", index)
    low, high, possible = _bounds(vectors, index)
    possible = possible & (low < high)
    return np.where(possible, low, 0.0), np.where(possible, high, 0.0)


Interval = tuple[FloatArray, FloatArray, NDArray[np.bool_]]


def _bounds(g: FloatArray, index: int) -> Interval:
    """Lower and upper bound of one gain, and where the others admit any value of it at all."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return _interval3(g, index) if g.shape[-1] < 4 else _interval4(g, index)


def _interval3(g: FloatArray, index: int) -> Interval:
    """Orders 2 and 3: the triangle, g2 > 0 and 2 g0 g1 > g2 (2 - g0)."""
    g0, g1 = g[..., 0], g[..., 1]
    g2 = g[..., 2] if g.shape[-1] == 3 else np.zeros_like(g0)
    third = (g2 > 0) | (g.shape[-1] == 2)
    if index == 0:
        return 2 * g2 / (2 * g1 + g2), 2 - g1 / 2, third & (g1 > 0)
    if index == 1:
        low = np.zeros_like(g0) if g.shape[-1] == 2 else g2 * (2 - g0) / (2 * g0)
        return low, 4 - 2 * g0, third & (g0 > 0) & (g0 < 2)
    return np.zeros_like(g0), 2 * g0 * g1 / (2 - g0), (g0 > 0) & (g0 < 2) & (g1 > 0) & (4 - 2 * g0 - g1 > 0)


def _interval4(g: FloatArray, index: int) -> Interval:
    """Order 4: four linear inequalities, the triangle's counterpart, and one that is quadratic in g0 and in g2."""
    g0, g1, g2, g3 = np.moveaxis(g, -1, 0)
    roof = 48 + g3 - 24 * g0 - 12 * g1
    if index == 0:
        low, high = _between(-6 * g3, g2 * (6 * g1 + 3 * g2 + g3), -6 * g2**2)
        return (
            np.maximum(low, g2 / 4),
            np.minimum(high, (48 + g3 - 12 * g1) / 24),
            (g2 > 0) & (g3 > 0) & (3 * g1 > g3),
        )
    if index == 1:
        curve = g0 * g3 / g2 + g2 / g0 - g2 / 2 - g3 / 6
        return np.maximum(curve, g3 / 3), 4 - 2 * g0 + g3 / 12, (g2 > 0) & (g3 > 0) & (4 * g0 > g2)
    if index == 2:
        low, high = _between(3 * g0 - 6, g0 * (6 * g1 + g3), -6 * g0**2 * g3)
        # Outside 0 < g0 < 2 nothing is stable, and the parabola may open upwards.
        inside = (g0 > 0) & (g0 < 2) & (g3 > 0) & (3 * g1 > g3) & (roof > 0)
        return np.maximum(low, 0.0), np.minimum(high, 4 * g0), inside
    # Linear in g3: 6 g0 g1 g2 + 3 g0 g2^2 - 6 g2^2 > g0 (6 g0 - g2) g3.
    high = g2 * (6 * g0 * g1 + 3 * g0 * g2 - 6 * g2) / (g0 * (6 * g0 - g2))
    return np.maximum(0.0, 24 * g0 + 12 * g1 - 48), np.minimum(3 * g1, high), (g2 > 0) & (4 * g0 > g2)


def _between(a: FloatArray, b: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where a x^2 + b x + c > 0 for a < 0, b >= 0, c <= 0: its two roots, equal where it never is."""
    root = np.sqrt(np.maximum(b * b - 4 * a * c, 0.0))
    larger = -(b + root) / 2
    return np.where(larger == 0, 0.0, c / larger), larger / a


def alpha_bounds(gains: Gains) -> tuple[float, float]:
    """The open interval of alpha for which some beta is stable, with the given gamma and eta.

    The two bounds on beta meet where (eta/gamma + 2) alpha^2 - (4 + gamma/2 + eta/4) alpha + gamma = 0, and that
    factors: alpha = gamma/4 and alpha = 4 gamma/(eta + 2 gamma). The second is 2 for order 3.

    Args:
        gains: their order, gamma and eta are used; alpha and beta are not.

    Returns:
        Lower and upper bound; no alpha is stable where the lower one is not below the upper one.
    """
    g = gains.vector
    if gains.order == 2:
        return 0.0, 2.0
    eta = g[3] if gains.order == 4 else 0.0
    if g[2] <= 0 or (gains.order == 4 and eta <= 0):
        return 0.0, 0.0
    return float(g[2] / 4), float(4 * g[2] / (eta + 2 * g[2]))


def region_slice(
    gains: Gains, plane: tuple[str, str] = ("alpha", "beta"), points: int = 200
) -> tuple[FloatArray, FloatArray]:
    """Border of the stable region in a plane of two gains, through the other gains.

    Args:
        gains: the two gains of the plane are not used.
        plane: the names of the horizontal and the vertical gain, one of PLANES.
        points: samples along the lower and along the upper border, 2 to a million.

    Returns:
        Normalised coordinates of a closed polygon; both empty where nothing in the plane is stable.

    Raises:
        InputError: for a plane that the order does not have, and a number of points that makes no border.
    """
    points = int(POINTS.check("points", points))
    if tuple(plane) not in PLANES[gains.order]:
        raise InputError("plane", f"must be two gains of order {gains.order}", plane)
    across, up = (GAIN_NAMES.index(name) for name in plane)
    vector = gains.vector
    ends = alpha_bounds(gains) if (across, up) == (0, 1) else _ends(vector, across, up)
    if ends[0] >= ends[1]:
        return np.empty(0), np.empty(0)
    # Closer samples where the border bends, towards the ends.
    x = ends[0] + (ends[1] - ends[0]) * (1 - np.cos(np.linspace(0, np.pi, points))) / 2
    x[-1] = ends[1]
    vectors = np.repeat(vector[None], points, axis=0)
    vectors[:, across] = x
    low, high, _ = _bounds(vectors, up)
    # Where the two meet, rounding may have them cross.
    high = np.maximum(low, high)
    return np.concatenate((x, x[::-1], x[:1])), np.concatenate((low, high[::-1], low[:1]))


def _ends(vector: FloatArray, across: int, up: int) -> tuple[float, float]:
    """The interval of one gain for which some value of another is stable; (0, 0) where there is none.

    With r = g2/g0 and w = 2 - g0 the region of order 4 is 0 < r < 4, 0 < g3 < 3 g1, 12 g1 < 24 w + g3 and
    6 r g1 - (6 - r) g3 > 3 r^2 w. For a fixed r all of this is linear, and eliminating the second gain of a plane
    leaves bounds of the first that hold together on one interval.
    """
    g0, g1, g2, g3 = padded(vector)
    w = 2 - g0
    low, high = 0.0, 0.0
    match len(vector), across, up:
        case (3, 0, 2) if g1 > 0:
            high = 2 - g1 / 2
        case (3, 1, 2) if g0 > 0:
            high = 2 * w
        case (4, 0, 2) if 0 < g3 < 3 * g1:
            # The least of 3 g0 = 6 - (6 g1 + g3)/r + 6 g3/r^2 over r.
            low, high = max(0.0, 2 - (6 * g1 + g3) ** 2 / (72 * g3)), 2 - g1 / 2 + g3 / 24
        case (4, 0, 3) if g1 > 0 and g2 > 0:
            # 12 g0^2 + (6 g1 + g2 - 24) g0 < 2 g2
            half = 3 * g1 + g2 / 2 - 12
            root = sqrt(half**2 + 24 * g2)
            low, high = max(g2 / 4, 2 * g2 / (2 * g1 + g2)), 2 * g2 / (half + root) if half > 0 else (root - half) / 12
        case (4, 1, 2) if g0 > 0 and 0 < g3 < 8 * w:
            low, high = sqrt(2 * g3 * w) - g3 / 6, 2 * w + g3 / 12
        case (4, 1, 3) if 0 < g2 < 4 * g0 and w > 0:
            low, high = g2 / g0 * w / 2, (g2 / g0 + 12) * w / 6
        case (4, 2, 3) if 0 < g0 < 2 and g1 > 0:
            low, high = g0 * max(0.0, 6 * g1 / w - 12), g0 * min(4.0, 2 * g1 / w)
    return (low, high) if low < high else (0.0, 0.0)


def printed_slice(gains: Gains, plane: tuple[str, str] = ("alpha", "beta")) -> tuple[FloatArray, FloatArray]:
    """Border of what Yu & Wu 2017 print as stable (eq. 10-12, 21-24), through the present gamma and eta.

    Their gamma < 4 alpha beta/(2 - alpha), in their convention, is g2 < 2 alpha beta/(2 - alpha); their upper bound on
    beta is 13/6 (4 - 2 alpha); their delta < 24 (2 - alpha) is g3 < 4 (2 - alpha), which bounds alpha alone.

    Args:
        gains: their order, gamma and eta are used.
        plane: other planes than (alpha, beta) give nothing.

    Returns:
        Normalised coordinates of a closed polygon; both empty for order 2 and where nothing is left.
    """
    g = gains.vector
    if gains.order == 2 or tuple(plane) != ("alpha", "beta") or not g[2] > 0:
        return np.empty(0), np.empty(0)
    # The bounds on beta meet where 13/3 (2 - alpha) = g2 (2 - alpha)/(2 alpha).
    left, right = float(3 * g[2] / 26), float(2 - g[3] / 4) if gains.order == 4 else 2.0
    if left >= right or right > 2 or (gains.order == 4 and g[3] <= 0):
        return np.empty(0), np.empty(0)
    alpha = left + (right - left) * (1 - np.cos(np.linspace(0, np.pi, 100))) / 2
    low, high = g[2] * (2 - alpha) / (2 * alpha), 13 / 6 * (4 - 2 * alpha)
    return np.concatenate((alpha, alpha[::-1], alpha[:1])), np.concatenate((low, high[::-1], low[:1]))


def region_surface(rows: int = 24, columns: int = 48) -> tuple[FloatArray, NDArray[np.int32]]:
    """The border of the region of order 3 as a closed surface of triangles.

    Floor gamma = 0, wall beta = 4 - 2 alpha, roof gamma = 2 alpha beta/(2 - alpha). With beta = s (4 - 2 alpha) the
    roof is gamma = 4 alpha s: it meets the floor in the edges alpha = 0 and s = 0, the wall in s = 1, and at alpha = 2
    all values of s fall on the edge from (2, 0, 0) to (2, 0, 8).

    Args:
        rows: steps of s from 0 to 1.
        columns: steps of alpha from 0 to 2.

    Returns:
        Vertices, shape (n, 3): normalised alpha, beta, gamma; and triangles, shape (m, 3): indices of their corners,
        counter-clockwise seen from outside.

    Raises:
        InputError: for a number of steps that is not a whole number from 1 on.
    """
    rows, columns = int(STEPS.check("rows", rows)), int(STEPS.check("columns", columns))
    points: list[tuple[float, float, float]] = []
    numbers: dict[tuple[float, ...], int] = {}

    def vertex(alpha: float, share: float, height: float) -> int:
        """Number of the point at beta = share (4 - 2 alpha), gamma = height times the roof."""
        point = (alpha, share * (4 - 2 * alpha), height * 4 * alpha * share)
        # Points that differ by rounding alone are one; kept in full, since a double pole feels the square root of it.
        key = tuple(round(coordinate, 12) for coordinate in point)
        if key not in numbers:
            numbers[key] = len(points)
            points.append(point)
        return numbers[key]

    alphas = [2 * i / columns for i in range(columns + 1)]
    shares = [j / rows for j in range(rows + 1)]
    faces: list[tuple[int, int, int]] = []

    def sheet(corner: list[list[int]], *, flip: bool) -> None:
        for i, j in product(range(len(corner) - 1), range(len(corner[0]) - 1)):
            a, b, c, d = corner[i][j], corner[i + 1][j], corner[i + 1][j + 1], corner[i][j + 1]
            both = ((a, b, c), (a, c, d))
            # Where an edge has shrunk to a point, one of the two is nothing.
            faces.extend(part[::-1] if flip else part for part in both if len(set(part)) == 3)

    sheet([[vertex(alpha, share, 1) for share in shares] for alpha in alphas], flip=False)
    sheet([[vertex(alpha, share, 0) for share in shares] for alpha in alphas], flip=True)
    sheet([[vertex(alpha, 1, share) for share in shares] for alpha in alphas], flip=True)
    return np.array(points), np.array(faces, dtype=np.int32)


def nearest_stable(gains: Gains, radius: float = RADIUS) -> Gains:
    """The nearest gains, by Euclidean distance of the normalised vectors, whose poles all lie within a radius.

    Args:
        gains: any set; comes back as it is where its poles already lie within the radius.
        radius: greatest magnitude of a pole, 0 < radius < 1.

    Returns:
        Gains in the convention of `gains`.

    Raises:
        InputError: for a radius outside (0, 1).
    """
    radius = WITHIN.check("radius", radius)
    # Poles lie within the radius where the gains that have them divided by it are stable; a billionth is let pass, so
    # that what this function gives comes back from it as it is.
    if is_stable(gains) and stable(scaled_poles(gains.vector, (1 - 1e-9) / radius)):
        return gains
    return Gains.normalised(nearest_within(gains.vector, radius)).to(gains.convention)
