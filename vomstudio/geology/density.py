"""How densely poles and lines lie on the lower hemisphere, as numbers: grids, levels, maxima.

Four ways to count, each of axial data. Kamb's (Kamb 1959, Journal of Geophysical Research 64,
1891-1909) counts in a circle that grows as the data become few, so that a uniform scatter is
expected to have `sigma` (3) of its own standard deviations in it; the linear and the exponential
kernel (Vollmer 1995, Computers & Geosciences 21, 31-49) smooth that count. Schmidt's counts in 1 %
of the hemisphere, whatever the number of data.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import to_translate
from vomstudio.geology.stereonet import unproject

DENSITY_METHODS = ("kamb", "exponential_kamb", "linear_kamb", "schmidt")
DENSITY_UNITS = {
    "kamb": to_translate("standard deviations"),
    "exponential_kamb": to_translate("standard deviations"),
    "linear_kamb": to_translate("standard deviations"),
    "schmidt": to_translate("% of data per 1 % area"),
}
SIGMA = 3.0
MOST_LEVELS = 8

_TILE = 8
_BLOCK = _TILE**2
_PAIRS = 100_000
"""Cosines at a time that stay in the cache."""
_NEGLIGIBLE = 30.0
"""Poles for which the exponent is below minus this add less than 1e-13 each, and are left out
where whole blocks of places are as far."""


def density(
    vectors: npt.ArrayLike,
    at: npt.ArrayLike,
    method: str = "exponential_kamb",
    sigma: float = SIGMA,
) -> FloatArray:
    """Density (m,) of axial data (n, 3) at unit vectors (m, 3).

    kamb: count in a circle whose area is sigma^2 / (n + sigma^2) of the hemisphere, in standard
    deviations of a uniform scatter (Kamb 1959): sigma where uniform; exponential_kamb and
    linear_kamb: the same with a smooth kernel (Vollmer 1995); schmidt: share of the data in 1 % of
    the area, that is 1 where uniform. Kamb's are lowered by half a count, as usual, and never
    below 0. Quickest where neighbours in `at` are neighbours on the sphere. Raises ValueError for
    another method.
    """
    kernel = _Kernel.of(method, np.atleast_2d(np.asarray(vectors)).shape[0], sigma)
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    g = np.atleast_2d(np.asarray(at, dtype=np.float64))
    total = np.zeros(len(g))
    for i in range(0, len(g), _BLOCK):
        near = _near(v, g[i : i + _BLOCK], kernel)
        step = max(1, _PAIRS // max(len(near), 1))
        for j in range(i, min(i + _BLOCK, len(g)), step):
            k = min(j + step, i + _BLOCK)
            total[j:k] = kernel.count(np.abs(g[j:k] @ near.T))
    lowered = 0.0 if method == "schmidt" else 0.5
    return np.maximum((total - lowered) / kernel.scale, 0.0)


@dataclass(frozen=True)
class _Kernel:
    """What a pole counts at a place, by the cosine of the angle between them.

    cap: area of the counting circle as a share of the hemisphere; reach_deg: no pole farther away
    counts; scale: the unit.
    """

    method: str
    cap: float
    steep: float
    scale: float
    reach_deg: float

    @classmethod
    def of(cls, method: str, n: int, sigma: float) -> _Kernel:
        if method not in DENSITY_METHODS:
            raise ValueError(f"unknown method {method!r}; use one of {DENSITY_METHODS}")
        cap = counting_area(n, method, sigma)
        if method == "schmidt":
            return cls(method, cap, 0.0, cap * n, _opening(cap))
        if method != "exponential_kamb":
            return cls(method, cap, 0.0, math.sqrt(n * cap * (1.0 - cap)), _opening(cap))
        steep = 2.0 * (1.0 + n / sigma**2)
        scale = math.sqrt(n * (steep / 2.0 - 1.0) / steep**2)
        return cls(method, cap, steep, scale, _opening(_NEGLIGIBLE / steep))

    def count(self, cosine: FloatArray) -> FloatArray:
        """Counts (m,) by the cosines (m, k)."""
        if self.method in ("schmidt", "kamb"):
            return np.asarray((cosine >= 1.0 - self.cap).sum(axis=1), dtype=np.float64)
        if self.method == "linear_kamb":
            over = np.maximum(cosine - (1.0 - self.cap), 0.0)
            return np.asarray(over.sum(axis=1) * (2.0 / self.cap))
        power = self.steep * (cosine - 1.0)
        return np.asarray(np.exp(power, out=power).sum(axis=1))


def counting_area(n: int, method: str = "exponential_kamb", sigma: float = SIGMA) -> float:
    """Area of the counting circle of n data, as a share of the hemisphere's."""
    return 0.01 if method == "schmidt" else sigma**2 / (n + sigma**2)


def _opening(cap: float) -> float:
    """Half-angle in degrees of a circle that covers this share of the hemisphere."""
    return math.degrees(math.acos(max(1.0 - cap, 0.0)))


def _near(vectors: FloatArray, block: FloatArray, kernel: _Kernel) -> FloatArray:
    """Those of the data (n, 3) that can count anywhere in a block of places (m, 3)."""
    middle = block.sum(axis=0)
    length = float(np.linalg.norm(middle))
    if length < 1e-9 or kernel.reach_deg >= 90.0:
        return vectors
    middle /= length
    widest = math.degrees(math.acos(min(max(float((block @ middle).min()), -1.0), 1.0)))
    reach = widest + kernel.reach_deg + 1e-6
    if reach >= 90.0:
        return vectors
    return np.asarray(vectors[np.abs(vectors @ middle) >= math.cos(math.radians(reach))])


def density_grid(
    vectors: npt.ArrayLike,
    method: str = "exponential_kamb",
    projection: str = "area",
    size: int | None = None,
    sigma: float = SIGMA,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """x (size,), y (size,) and density (size, size), rows along y, over the square about the net.

    size : None for as many places as the counting circle of these data needs (`grid_size`).
    Beyond the primitive circle the values are those of the nearest point on it, so that contours
    reach it cleanly and can be clipped by it.
    """
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    n = grid_size(len(v), method, sigma) if size is None else size
    axis = np.linspace(-1.0, 1.0, n)
    x, y = np.meshgrid(axis, axis)
    radius = np.hypot(x, y)
    reach = 1.0 + 3.0 * (axis[1] - axis[0])
    # Tile by tile: the places of a block lie together, and few of the data count in it.
    row, column = np.indices(x.shape)
    tile = (row // _TILE) * n + column // _TILE
    order = np.argsort(tile.ravel(), kind="stable")
    order = order[radius.ravel()[order] <= reach]
    inward = np.maximum(radius.ravel()[order], 1.0)
    points = np.stack([x.ravel()[order] / inward, y.ravel()[order] / inward], axis=-1)
    values = np.zeros(n * n)
    values[order] = density(v, unproject(points, projection), method, sigma)
    return axis, axis, values.reshape(n, n)


def grid_size(n: int, method: str = "exponential_kamb", sigma: float = SIGMA) -> int:
    """Places along a side of the grid, 61 to 181: a third of the counting circle's radius apart on
    an equal-area net, on which the circle has the square root of its share of the area."""
    apart = math.sqrt(counting_area(n, method, sigma)) / 3.0
    return int(min(max(2 * round(1.0 / apart) + 1, 61), 181))


def round_levels(top: float, method: str) -> list[float]:
    """At most 8 round levels below the highest density: every 2 (or more) standard deviations, or
    round shares."""
    steps = (2, 4, 5, 10, 20, 50, 100, 200, 500) if method != "schmidt" else (1, 2, 5, 10, 20, 50)
    for step in steps:
        if top / step <= MOST_LEVELS:
            count = math.ceil(top / step) - 1
            return [float(step * (i + 1)) for i in range(max(count, 0))]
    return [float(steps[-1])]


def densest(
    vectors: npt.ArrayLike, method: str = "exponential_kamb", sigma: float = SIGMA
) -> tuple[FloatArray, float]:
    """Where axial data (n, 3) lie densest: a unit vector (3,) that points down, and the density
    there. Of a place that all around is as dense (the counts of Kamb and Schmidt have steps), the
    middle, where that is as dense too."""
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    places = _side_by_side(np.vstack([_lattice(4000), v[:: max(1, len(v) // 2000)]]))
    found = density(v, places, method, sigma)
    best, top = places[int(np.argmax(found))], float(found.max())
    opening = _opening(counting_area(len(v), method, sigma))
    if method in ("kamb", "schmidt"):
        alike = places[found >= top - 1e-9]
        alike = alike * np.where(alike @ best < 0.0, -1.0, 1.0)[:, None]
        near = math.cos(math.radians(min(2.0 * opening, 90.0)))
        middle = alike[alike @ best >= near].sum(axis=0)
        middle /= np.linalg.norm(middle)
        if density(v, middle, method, sigma)[0] >= top - 1e-9:
            best = middle
    else:
        best = _climbed(v, best, _Kernel.of(method, len(v), sigma))
        top = max(top, float(density(v, best, method, sigma)[0]))
    return (-best if best[2] > 0 else best), top


def _lattice(n: int) -> FloatArray:
    """n unit vectors (n, 3), spread evenly over the lower hemisphere along a spiral."""
    i = np.arange(n) + 0.5
    z, turn = -i / n, np.pi * (1.0 + math.sqrt(5.0)) * i
    h = np.sqrt(1.0 - z**2)
    return np.stack([h * np.cos(turn), h * np.sin(turn), z], axis=-1)


def _side_by_side(places: FloatArray) -> FloatArray:
    """Axes (n, 3) in an order in which most of a block lie together on the net."""
    down = np.where(places[:, 2:] > 0.0, -places, places)
    flat = down[:, :2] / np.sqrt(1.0 - np.minimum(down[:, 2:], 0.0))
    column, row = np.floor((flat + 1.0) * 8.0).astype(int).T
    return np.asarray(down[np.lexsort((row, column))])


def _climbed(vectors: FloatArray, start: FloatArray, kernel: _Kernel) -> FloatArray:
    """The top of the hill of density that a unit vector stands on. Both smooth kernels are convex
    in the place, so that the sum of the data, each by its kernel's slope, never leads down."""
    place = start
    # The hill is no wider than the kernel: a few times its reach holds all that counts on the way.
    aside = min(3.0 * kernel.reach_deg, 90.0)
    vectors = vectors[np.abs(vectors @ start) >= math.cos(math.radians(aside)) - 1e-12]
    for _ in range(2000):
        cosine = vectors @ place
        if kernel.method == "linear_kamb":
            slope = (np.abs(cosine) >= 1.0 - kernel.cap).astype(np.float64)
        else:
            slope = np.exp(kernel.steep * (np.abs(cosine) - 1.0))
        new = (slope * np.where(cosine < 0.0, -1.0, 1.0)) @ vectors
        new /= np.linalg.norm(new)
        moved = float(np.abs(new - place).max())
        place = new
        if moved < 1e-12:
            break
    return np.asarray(place)
