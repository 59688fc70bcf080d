"""A plane carried on beyond its points, with what its position is worth there.

The plane of a least-squares fit has at a place (u, v) along its axes, counted from the middle of
its points, the variance s^2 (1/n + u^2 / sum u^2 + v^2 / sum v^2) across itself: the middle is
known best, and the tilt opens the band with the distance (any textbook of regression; for planes on
outcrops Quinn & Ehlmann 2019, Earth and Space Science 6, doi 10.1029/2018EA000416, who draw it as
the sheets of a hyperboloid). s and the number of points are those that the fit stands for once
neighbours on a trace are allowed to be alike (`geometry.plane_errors`); the 95 % band at a place is
Student's t times the root of the variance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.plane_errors import LEVEL, joint_quantile
from vomstudio.geometry.planes import PlaneFit
from vomstudio.geometry.rotation_errors import CHI2_TWO

MOST_BEDS = 2000


@dataclass(frozen=True, eq=False)
class PlaneBelief:
    """A plane and how well it is known. World, m.

    middle : (3,) where it is known best; axes : (3, 3) rows: two directions in the plane and its
    upward normal; of_middle : variance of the position there, m2; of_tilts : (2,) variance of the
    slope along the two directions; free : degrees of freedom, infinite where variances are known
    """

    middle: FloatArray
    axes: FloatArray
    of_middle: float
    of_tilts: FloatArray
    free: float

    @property
    def plane(self) -> Plane:
        return Plane.from_normal(self.axes[2])

    def distances(self, points: FloatArray) -> FloatArray:
        """(n,) of points (n, 3), positive above the plane."""
        return np.asarray((points - self.middle) @ self.axes[2])

    def sd(self, points: FloatArray) -> FloatArray:
        """(n,) standard deviation of the plane's position beside points (n, 3), m."""
        flat = (points - self.middle) @ self.axes[:2].T
        return np.asarray(np.sqrt(self.of_middle + (flat**2) @ self.of_tilts))

    @property
    def t95(self) -> float:
        """Standard deviations either side that hold 95 % of one figure."""
        from scipy.special import ndtri, stdtrit

        level = 1.0 - LEVEL / 2.0
        return float(ndtri(level) if np.isinf(self.free) else stdtrit(self.free, level))


@dataclass(frozen=True, eq=False)
class Repeats:
    """A plane and others parallel to it at a thickness. numbers : (k,) steps upwards, 0 the plane
    itself; thickness_m : between neighbours, None for the plane alone; of_thickness : its variance,
    m2"""

    numbers: IntArray
    thickness_m: float | None
    of_thickness: float = 0.0

    def offset(self, number: int) -> float:
        return 0.0 if self.thickness_m is None else number * self.thickness_m

    def nearest(self, distances: FloatArray) -> IntArray:
        """(n,) number of the plane that each distance from the first is nearest to."""
        if self.thickness_m is None:
            return np.zeros(len(distances), np.int64)
        steps = np.round(distances / self.thickness_m).astype(np.int64)
        return np.clip(steps, int(self.numbers.min()), int(self.numbers.max()))


@dataclass(frozen=True, eq=False)
class Bands:
    """Of points (n,): bed, number of the nearest plane; distance_m from it, positive above;
    error95_m of its position there; inside : within that of the plane"""

    bed: IntArray
    distance_m: FloatArray
    error95_m: FloatArray

    @property
    def inside(self) -> BoolArray:
        return np.asarray(np.abs(self.distance_m) <= self.error95_m)


def belief_of_fit(fit: PlaneFit) -> PlaneBelief:
    """Of a fitted plane. Raises GeometryError where its errors are not known, as for three points
    or by regression."""
    largest, smallest = fit.max_confidence95_deg, fit.min_confidence95_deg
    if fit.long_roughness:
        # The wider of the two figures counts, see geometry/planes.py.
        largest = _wider(largest, fit.max_angular_error_deg)
        smallest = _wider(smallest, fit.min_angular_error_deg)
    if largest is None or smallest is None or fit.rms is None or fit.n_effective is None:
        raise GeometryError(Finding("plane.no-band"))
    if fit.method != "pca":
        raise GeometryError(Finding("plane.regression-band"))
    if not largest < 45.0:
        raise GeometryError(Finding("plane.too-uncertain", error_deg=largest))
    free = max(fit.n_effective - 3.0, 0.5)
    limit = float(joint_quantile(np.array([free]))[0]) * free
    tilts = np.asarray(np.tan(np.radians([smallest, largest])) ** 2 / limit)
    return PlaneBelief(
        np.asarray(fit.centroid, np.float64),
        _right_handed(np.asarray(fit.axes, np.float64)),
        fit.rms**2 / free,
        tilts,
        free,
    )


def belief_of_attitude(
    plane: Plane, through: FloatArray, error95_deg: float, error95_m: float = 0.0
) -> PlaneBelief:
    """Of a plane by dip direction and dip through a point (3,); error95_deg : half-angle of the
    joint 95 % region of its normal, alike to all sides; error95_m : of the point across it."""
    from vomstudio.geometry.rotation_errors import Z95

    normal = plane.normal()
    side = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u = np.asarray(side / np.linalg.norm(side))
    tilt = np.tan(np.radians(error95_deg)) ** 2 / CHI2_TWO
    return PlaneBelief(
        np.asarray(through, np.float64),
        np.stack([u, np.cross(normal, u), normal]),
        (error95_m / Z95) ** 2,
        np.array([tilt, tilt]),
        np.inf,
    )


def repeated(
    belief: PlaneBelief, points: FloatArray, thickness_m: float | None, error95_m: float = 0.0
) -> Repeats:
    """All planes at a thickness that reach between the points (n, 3) of a model; the plane alone
    without one. error95_m : of the thickness. Raises GeometryError for a thickness that makes more
    than MOST_BEDS."""
    from vomstudio.geometry.rotation_errors import Z95

    if thickness_m is None:
        return Repeats(np.zeros(1, np.int64), None)
    away = belief.distances(points)
    low, high = (
        float(np.floor(away.min() / thickness_m)),
        float(np.ceil(away.max() / thickness_m)),
    )
    if high - low > MOST_BEDS:
        raise GeometryError(
            Finding("beds.too-many", thickness_m=thickness_m, n=high - low + 1, maximum=MOST_BEDS),
            field="thickness",
        )
    numbers = np.arange(min(int(low), 0), max(int(high), 0) + 1)
    return Repeats(numbers, thickness_m, (error95_m / Z95) ** 2)


def bands(belief: PlaneBelief, repeats: Repeats, points: FloatArray) -> Bands:
    """How points (n, 3) lie to the nearest of the planes. The error of the k-th holds k times that
    of the thickness."""
    away = belief.distances(points)
    bed = repeats.nearest(away)
    offset: FloatArray = np.zeros(len(away))
    if repeats.thickness_m is not None:
        offset = bed.astype(np.float64) * repeats.thickness_m
    variance = belief.sd(points) ** 2 + bed.astype(np.float64) ** 2 * repeats.of_thickness
    return Bands(bed, away - offset, belief.t95 * np.sqrt(variance))


def _wider(one: float | None, other: float | None) -> float | None:
    known = [value for value in (one, other) if value is not None]
    return max(known) if known else None


def _right_handed(axes: FloatArray) -> FloatArray:
    made = axes.copy()
    if made[2, 2] < 0.0:
        made[2] = -made[2]
    made[1] = np.cross(made[2], made[0])
    return made
