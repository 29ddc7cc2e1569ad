"""The stable region: intervals, slices, the surface of order 3, and the way back into it.

Normalised gains throughout. Every gain enters every inequality of the region linearly, or quadratically with a
negative leading coefficient: given the others, one gain is stable on one interval, in closed form.
"""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from tracker_core.checks import InputError
from tracker_core.conventions import Gains
from tracker_core.poles import gains_from_poles
from tracker_core.stability import is_stable
from tracker_core.types import GAIN_NAMES, ORDERS, FloatArray

PLANES: dict[int, tuple[tuple[str, str], ...]] = {order: tuple(combinations(GAIN_NAMES[:order], 2)) for order in ORDERS}
"""The planes of two gains per order."""

BOX: dict[int, tuple[float, ...]] = {2: (2.0, 4.0), 3: (2.0, 4.0, 8.0), 4: (2.0, 16 / 3, 8.0, 16.0)}
"""Upper end of every gain over the whole region of an order; the lower end is 0."""

RADIUS = 0.99
"""Largest pole of the gains that `nearest_stable` gives: inside the region, not on its border."""

_SCAN = 300
_BISECTIONS = 60
_SWEEPS, _ALL_STARTS, _KEPT_STARTS = 500, 12, 6


def gain_interval(vectors: FloatArray, index: int) -> tuple[FloatArray, FloatArray]:
    """The open interval of one gain that is stable with the others.

    Args:
        vectors: normalised gains, shape (..., order); their own entry `index` is not used.
        index: 0 to order - 1 for alpha to eta.

    Returns:
        Lower and upper end, each of shape (...); both 0 where no value is stable.
    """
    low, high, possible = _bounds(np.asarray(vectors, dtype=np.float64), index)
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
    # Linear in g3: g0 (g2 - 6 g0) g3 + 6 g0 g1 g2 + 3 g0 g2^2 - 6 g2^2 > 0.
    slope, rest = g0 * (g2 - 6 * g0), g2 * (6 * g0 * g1 + 3 * g0 * g2 - 6 * g2)
    low = np.maximum(0.0, 24 * g0 + 12 * g1 - 48)
    high = np.minimum(3 * g1, np.where(slope < 0, rest / -slope, np.inf))
    return low, high, (g2 > 0) & (4 * g0 > g2) & ((slope < 0) | (rest > 0))


def _between(a: FloatArray, b: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where a x^2 + b x + c > 0 for a < 0, b > 0, c <= 0: its two roots, NaN where it never is."""
    root = np.sqrt(b * b - 4 * a * c)
    larger = -(b + root) / 2
    return c / larger, larger / a


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
        points: samples along the lower and along the upper border.

    Returns:
        Normalised coordinates of a closed polygon; both empty where nothing in the plane is stable.

    Raises:
        InputError: for a plane that the order does not have.
    """
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
    """First and last value of one gain for which some value of another is stable; found by scanning and bisecting."""
    top = BOX[len(vector)][across]
    grid = np.concatenate(
        ([0.0], top * np.geomspace(1e-12, 1, _SCAN), np.linspace(0, top, _SCAN)[1:-1], [vector[across]])
    )
    grid = np.unique(np.clip(grid, 0, top))

    def stable(x: FloatArray) -> NDArray[np.bool_]:
        vectors = np.repeat(vector[None], len(x), axis=0)
        vectors[:, across] = x
        low, high, possible = _bounds(vectors, up)
        return possible & (low < high)

    inside = np.flatnonzero(stable(grid))
    if not inside.size:
        return 0.0, 0.0
    good = grid[inside[[0, -1]]]
    bad = grid[[max(inside[0] - 1, 0), min(inside[-1] + 1, len(grid) - 1)]]
    for _ in range(_BISECTIONS):
        middle = (good + bad) / 2
        held = stable(middle)
        good, bad = np.where(held, middle, good), np.where(held, bad, middle)
    return float(good[0]), float(good[1])


def printed_slice(gains: Gains, plane: tuple[str, str] = ("alpha", "beta")) -> tuple[FloatArray, FloatArray]:
    """Border of what Yu & Wu 2017 print as stable (eq. 10-12, 21-23), through the present gamma.

    Their gamma < 4 alpha beta/(2 - alpha), in their convention, is g2 < 2 alpha beta/(2 - alpha); their upper bound on
    beta is 13/6 (4 - 2 alpha). Their bound on delta does not depend on beta.

    Args:
        gains: their order and gamma are used.
        plane: other planes than (alpha, beta) give nothing.

    Returns:
        Normalised coordinates of a closed polygon; both empty for order 2 and where nothing is left.
    """
    g = gains.vector
    if gains.order == 2 or tuple(plane) != ("alpha", "beta") or not g[2] > 0:
        return np.empty(0), np.empty(0)
    # The bounds on beta meet where 13/3 (2 - alpha) = g2 (2 - alpha)/(2 alpha).
    left, right = float(6 * g[2] / 52), 2.0
    if left >= right:
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
    """
    numbers: dict[tuple[float, float, float], int] = {}

    def vertex(alpha: float, share: float, height: float) -> int:
        """Number of the point at beta = share (4 - 2 alpha), gamma = height times the roof."""
        point = (alpha, share * (4 - 2 * alpha), height * 4 * alpha * share)
        return numbers.setdefault((round(point[0], 12), round(point[1], 12), round(point[2], 12)), len(numbers))

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
    return np.array(list(numbers)), np.array(faces, dtype=np.int32)


def nearest_stable(gains: Gains, radius: float = RADIUS) -> Gains:
    """The nearest gains, by Euclidean distance of the normalised vectors, whose poles all lie within a radius.

    The polynomials with all roots in the unit disc are the image of the box [-1, 1]^order of reflection coefficients
    under the step-up recursion, and gains are affine in the coefficients of the polynomial. The squared distance is a
    parabola in each reflection coefficient, so that it is minimised by turns exactly, from many starts.

    Args:
        gains: any set; comes back as it is where its poles already lie within the radius.
        radius: greatest magnitude of a pole, 0 < radius < 1.

    Returns:
        Gains in the convention of `gains`.

    Raises:
        InputError: for a radius outside (0, 1).
    """
    if not 0 < radius < 1:
        raise InputError("radius", "must be > 0 and < 1", radius)
    if is_stable(gains) and is_stable(_shrunk(gains, radius)):
        return gains
    order = gains.order
    powers = np.power(radius, np.arange(1.0, order + 1))
    base, matrix = _gains_of_coefficients(order)
    reflections = np.array(list(product((-0.9, -0.3, 0.3, 0.9), repeat=order)))
    target = gains.vector
    best = _miss(reflections, powers, base, matrix, target)
    for sweep in range(_SWEEPS):
        if sweep == _ALL_STARTS:
            reflections = reflections[np.argsort(best)[:_KEPT_STARTS]]
            best = _miss(reflections, powers, base, matrix, target)
        before = best
        for k in range(order):
            ends = []
            for end in (-1.0, 1.0):
                reflections[:, k] = end
                ends.append(_residual(reflections, powers, base, matrix, target))
            middle, slope = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2
            steep = np.einsum("ij,ij->i", slope, slope)
            wanted = -np.einsum("ij,ij->i", slope, middle) / np.where(steep > 0, steep, 1.0)
            reflections[:, k] = np.clip(wanted, -1, 1)
        best = _miss(reflections, powers, base, matrix, target)
        if np.max(before - best) <= 1e-13 * max(1.0, float(best.min())):
            break
    chosen = reflections[int(np.argmin(best))][None]
    found = _residual(chosen, powers, base, matrix, target)[0] + target
    return Gains.normalised(found).to(gains.convention)


def _shrunk(gains: Gains, radius: float) -> Gains:
    """Gains whose poles are those of `gains` divided by the radius: stable where all of those lie within it."""
    base, matrix = _gains_of_coefficients(gains.order)
    coefficients = np.linalg.solve(matrix.T, gains.vector - base)
    return Gains.normalised(base + (coefficients / radius ** np.arange(1, gains.order + 1)) @ matrix)


def _gains_of_coefficients(order: int) -> tuple[FloatArray, FloatArray]:
    """Gains as an affine map of the coefficients of z^order + c1 z^(order-1) + ...: base + c @ matrix."""
    at_zero = gains_from_poles([0j] * order)
    rows = []
    for k in range(1, order + 1):
        # The polynomial z^(order-k) (z^k - 1) has c_k = -1.
        roots = [np.exp(2j * np.pi * i / k) for i in range(k)] + [0j] * (order - k)
        rows.append(at_zero - gains_from_poles(roots))
    return at_zero, np.array(rows)


def _coefficients(reflections: FloatArray) -> FloatArray:
    """Step-up recursion: coefficients c1 ... of the polynomials with the given reflections, shape (n, order)."""
    polynomial = np.empty((len(reflections), 0))
    for k in range(reflections.shape[1]):
        last = reflections[:, k : k + 1]
        polynomial = np.hstack((polynomial + last * polynomial[:, ::-1], last))
    return polynomial


def _residual(
    reflections: FloatArray, powers: FloatArray, base: FloatArray, matrix: FloatArray, target: FloatArray
) -> FloatArray:
    return base + (_coefficients(reflections) * powers) @ matrix - target


def _miss(*arguments: FloatArray) -> FloatArray:
    residual = _residual(*arguments)
    return np.einsum("ij,ij->i", residual, residual)
