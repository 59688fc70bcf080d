"""Extension of a plane beyond its points, with the error of its position.

At a position (u, v) along the axes of a least-squares plane, measured from the centroid of its
points, the variance perpendicular to the plane is s^2 (1/n + u^2 / sum u^2 + v^2 / sum v^2). It is
smallest at the centroid, and the tilt widens the band with distance (see any textbook on
regression; for planes on outcrops Quinn & Ehlmann 2019, Earth and Space Science 6, doi
10.1029/2018EA000416, who draw it as the sheets of a hyperboloid). s and n are effective values that
allow for the correlation of neighbours on a trace (`geometry.plane_errors`). The 95 % band is
Student's t times the standard deviation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.plane_errors import SIGNIFICANCE, joint_quantile
from vomstudio.geometry.planes import FittedPlane
from vomstudio.geometry.rotation_errors import CHI2_TWO

MAX_BEDS = 2000


@dataclass(frozen=True, eq=False)
class PlaneEstimate:
    """Plane with the covariance of its position and attitude, in the World frame.

    Attributes
    ----------
    centroid : (3,) ndarray
        Point at which the position is known best, m.
    axes : (3, 3) ndarray
        Two directions in the plane and its upward normal, as rows.
    centre_variance : float
        Variance of the position at `centroid` along the normal, m2.
    tilt_variances : (2,) ndarray
        Variances of the slopes along the two directions in the plane.
    degrees_of_freedom : float
        Degrees of freedom; infinite if the variances are known.
    """

    centroid: FloatArray
    axes: FloatArray
    centre_variance: float
    tilt_variances: FloatArray
    degrees_of_freedom: float

    @property
    def plane(self) -> Plane:
        return Plane.from_normal(self.axes[2])

    def distances(self, points: FloatArray) -> FloatArray:
        """Return the signed distances (n,) of points (n, 3) in metres, positive above the plane."""
        return np.asarray((points - self.centroid) @ self.axes[2])

    def position_sd(self, points: FloatArray) -> FloatArray:
        """Return the standard deviations (n,) of the plane position at points (n, 3), m."""
        plane_points = (points - self.centroid) @ self.axes[:2].T
        return np.asarray(np.sqrt(self.centre_variance + (plane_points**2) @ self.tilt_variances))

    @property
    def t95(self) -> float:
        """Two-sided 95 % quantile in standard deviations."""
        from scipy.special import ndtri, stdtrit

        level = 1.0 - SIGNIFICANCE / 2.0
        return float(
            ndtri(level)
            if np.isinf(self.degrees_of_freedom)
            else stdtrit(self.degrees_of_freedom, level)
        )


@dataclass(frozen=True, eq=False)
class PlaneSeries:
    """Plane and its parallels at a constant spacing.

    Attributes
    ----------
    numbers : (k,) ndarray of int
        Numbers of the planes in upward order; 0 is the plane itself.
    thickness_m : float or None
        Distance between adjacent planes, m; None for a single plane.
    thickness_variance : float
        Variance of the thickness, m2.
    """

    numbers: IntArray
    thickness_m: float | None
    thickness_variance: float = 0.0

    def offset(self, number: int) -> float:
        return 0.0 if self.thickness_m is None else number * self.thickness_m

    def nearest_numbers(self, distances: FloatArray) -> IntArray:
        """Return the number (n,) of the nearest plane for distances (in metres) from plane 0."""
        if self.thickness_m is None:
            return np.zeros(len(distances), np.int64)
        steps = np.round(distances / self.thickness_m).astype(np.int64)
        return np.clip(steps, int(self.numbers.min()), int(self.numbers.max()))


@dataclass(frozen=True, eq=False)
class PlaneDistances:
    """Distances of n points from the nearest planes of a series.

    Attributes
    ----------
    bed : (n,) ndarray of int
        Number of the nearest plane.
    distance_m : (n,) ndarray
        Signed distance from the nearest plane, positive above, m.
    error95_m : (n,) ndarray
        95 % error of the position of the plane, m.
    is_in_band : (n,) ndarray of bool
        True if the distance is within this error.
    """

    bed: IntArray
    distance_m: FloatArray
    error95_m: FloatArray

    @property
    def is_in_band(self) -> BoolArray:
        return np.asarray(np.abs(self.distance_m) <= self.error95_m)


def plane_estimate_from_fit(fit: FittedPlane) -> PlaneEstimate:
    """Return a fitted plane with the covariance of its position and attitude.

    Raises
    ------
    GeometryError
        If the errors are unknown, as for three points or a regression, or reach 45 degrees.
    """
    major_deg, minor_deg = fit.max_confidence95_deg, fit.min_confidence95_deg
    if fit.long_roughness:
        # The larger of the two values applies, see geometry/planes.py.
        major_deg = _larger_known_error(major_deg, fit.max_angular_error_deg)
        minor_deg = _larger_known_error(minor_deg, fit.min_angular_error_deg)
    if major_deg is None or minor_deg is None or fit.rms is None or fit.n_effective is None:
        raise GeometryError(Finding("plane.no-band"))
    if fit.method != "pca":
        raise GeometryError(Finding("plane.regression-band"))
    if not major_deg < 45.0:
        raise GeometryError(Finding("plane.too-uncertain", error_deg=major_deg))
    dof = max(fit.n_effective - 3.0, 0.5)
    limit = float(joint_quantile(np.array([dof]))[0]) * dof
    tilt_variances = np.asarray(np.tan(np.radians([minor_deg, major_deg])) ** 2 / limit)
    return PlaneEstimate(
        np.asarray(fit.centroid, np.float64),
        _right_handed_axes(np.asarray(fit.axes, np.float64)),
        fit.rms**2 / dof,
        tilt_variances,
        dof,
    )


def plane_estimate_from_attitude(
    plane: Plane, point: FloatArray, error95_deg: float, error95_m: float = 0.0
) -> PlaneEstimate:
    """Return a plane of given attitude through a point, with its errors.

    Parameters
    ----------
    plane : Plane
    point : (3,) ndarray
        Point on the plane in the World frame, m.
    error95_deg : float
        Half-angle of the joint 95 % region of the normal in degrees, equal in all directions.
    error95_m : float
        95 % error of the point along the normal, m.

    Returns
    -------
    PlaneEstimate
    """
    from vomstudio.geometry.rotation_errors import Z95

    normal = plane.normal()
    tangent = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u = np.asarray(tangent / np.linalg.norm(tangent))
    tilt_variance = np.tan(np.radians(error95_deg)) ** 2 / CHI2_TWO
    return PlaneEstimate(
        np.asarray(point, np.float64),
        np.stack([u, np.cross(normal, u), normal]),
        (error95_m / Z95) ** 2,
        np.array([tilt_variance, tilt_variance]),
        np.inf,
    )


def repeat_planes(
    plane: PlaneEstimate, points: FloatArray, thickness_m: float | None, error95_m: float = 0.0
) -> PlaneSeries:
    """Return the parallels of a plane that cover the points of a model.

    Parameters
    ----------
    plane : PlaneEstimate
    points : (n, 3) ndarray
        Points of the model in the World frame, m.
    thickness_m : float or None
        Distance between adjacent planes, m. If None, only the plane itself is returned.
    error95_m : float
        95 % error of the thickness, m.

    Returns
    -------
    PlaneSeries

    Raises
    ------
    GeometryError
        If the thickness would result in more than `MAX_BEDS` planes.
    """
    from vomstudio.geometry.rotation_errors import Z95

    if thickness_m is None:
        return PlaneSeries(np.zeros(1, np.int64), None)
    distances = plane.distances(points)
    low, high = (
        float(np.floor(distances.min() / thickness_m)),
        float(np.ceil(distances.max() / thickness_m)),
    )
    if high - low > MAX_BEDS:
        raise GeometryError(
            Finding("beds.too-many", thickness_m=thickness_m, n=high - low + 1, maximum=MAX_BEDS),
            field="thickness",
        )
    indices = np.arange(min(int(low), 0), max(int(high), 0) + 1)
    return PlaneSeries(indices, thickness_m, (error95_m / Z95) ** 2)


def bands(plane: PlaneEstimate, repeats: PlaneSeries, points: FloatArray) -> PlaneDistances:
    """Measure the distances of points from the nearest planes of a series, with errors.

    The error of plane k includes k times the error of the thickness.

    Parameters
    ----------
    plane : PlaneEstimate
    repeats : PlaneSeries
        Series of parallel planes.
    points : (n, 3) ndarray

    Returns
    -------
    PlaneDistances
    """
    distances = plane.distances(points)
    bed = repeats.nearest_numbers(distances)
    offset: FloatArray = np.zeros(len(distances))
    if repeats.thickness_m is not None:
        offset = bed.astype(np.float64) * repeats.thickness_m
    variance = (
        plane.position_sd(points) ** 2 + bed.astype(np.float64) ** 2 * repeats.thickness_variance
    )
    return PlaneDistances(bed, distances - offset, plane.t95 * np.sqrt(variance))


def _larger_known_error(first_error: float | None, second_error: float | None) -> float | None:
    known_errors = [value for value in (first_error, second_error) if value is not None]
    return max(known_errors) if known_errors else None


def _right_handed_axes(axes: FloatArray) -> FloatArray:
    frame = axes.copy()
    if frame[2, 2] < 0.0:
        frame[2] = -frame[2]
    frame[1] = np.cross(frame[2], frame[0])
    return frame
