"""Plane through three or more points, with its errors.

The errors cover all planes that are compatible with the points. A normal n is compatible if n' S n,
where S is the scatter matrix of the points about their mean, exceeds its minimum by no more than
the errors of the points allow (chi-square, or F if the errors are estimated from the misfit). These
normals fill an elliptic cone; if the points nearly lie on a line, they are the normals of all
planes that contain the line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import FLATTENED_IN_JSON
from vomstudio.geology.measured_value import CONE95
from vomstudio.geology.orientation import Plane, normals_to_planes
from vomstudio.geometry.rotation_errors import Z95

# Maximum ratio of width to length for points that nearly lie on a line.
MAX_COLLINEAR_RATIO = 0.05
MAX_ERROR_DEG = 30.0
# If the width of the points is due to chance, the dip direction would be wrong.
MAX_DIRECTION_ERROR_DEG = 20.0
# Probability that a width caused by errors alone is accepted as a plane.
SIGNIFICANCE = 0.02
EXAMPLE_ERROR_M = 0.01
CONE_ANGLES = np.linspace(0.0, 2.0 * np.pi, 1440, endpoint=False)


@dataclass(frozen=True, repr=False)
class ThreePoints(PrintableResult):
    """Plane through three points, or best-fit plane of more points, with 95 % errors.

    Attributes
    ----------
    dip_error_deg, dip_direction_error_deg : float or None
        Individual errors of dip and dip direction, degrees; the larger side if they are asymmetric,
        and None if the errors of the points are unknown.
        The error of the dip direction is undefined (None) if it exceeds 90 degrees, if the plane is
        uncertain by 20 degrees or more, and for four points with an estimated error.
    max_confidence95_deg : float or None
        Half-angle of the 95 % cone in the least certain direction, degrees; None if the errors of
        the points are unknown.
    n : int
        Number of points.
    rms_m : float or None
        RMS distance of the points from the plane, m; None for three points.
    sigma_m : float or None
        Standard deviation of each coordinate, given or estimated from more than three points, m;
        None if unknown.
    warnings : tuple of Finding
        Reasons to doubt the plane.
    dropped_lines : tuple of int
        Line numbers of the table that contain no coordinates.
    """

    plane: Plane = field(metadata=FLATTENED_IN_JSON)
    dip_error_deg: float | None
    dip_direction_error_deg: float | None
    max_confidence95_deg: float | None
    n: int = 3
    rms_m: float | None = None
    sigma_m: float | None = None
    warnings: tuple[Finding, ...] = ()
    dropped_lines: tuple[int, ...] = ()

    @property
    def dip_direction_deg(self) -> float:
        return self.plane.dip_direction_deg

    @property
    def dip_deg(self) -> float:
        return self.plane.dip_deg

    @property
    def strike_rhr_deg(self) -> float:
        return self.plane.strike_rhr_deg

    def with_table_findings(
        self, dropped_indices: tuple[int, ...], warnings: tuple[Finding, ...]
    ) -> ThreePoints:
        """Return a copy with the dropped lines and warnings of the table of points added."""
        return replace(self, dropped_lines=dropped_indices, warnings=(*warnings, *self.warnings))

    def to_dict(self) -> dict[str, Any]:
        """Return the result as a dictionary for JSON."""
        return super().to_dict() | {"strike_rhr_deg": self.strike_rhr_deg}


def plane_of_three_points(points: npt.ArrayLike, sigma_m: float = 0.0) -> ThreePoints:
    """Solve the three-point problem, or fit a least-squares plane to more points.

    Parameters
    ----------
    points : (n, 3) array_like
        At least three points on one surface, in the World frame, m.
    sigma_m : float
        Standard deviation of each coordinate, m. If 0, it is estimated from the misfit of more than
        three points, with n - 3 degrees of freedom.

    Returns
    -------
    ThreePoints

    Raises
    ------
    GeometryError
        If there are fewer than three points, if they lie on one line, or if one is not finite.
    """
    p = np.asarray(points, np.float64)
    if p.ndim != 2 or p.shape[1] != 3 or not np.isfinite(p).all():
        raise GeometryError(Finding("points.invalid"))
    n = len(p)
    if n < 3:
        raise GeometryError(Finding("feature.too-few-points", count=3 - n, minimum=3))
    centred_points = p - p.mean(axis=0)
    max_distance = float(np.linalg.norm(centred_points, axis=1).max())
    _, sizes, axes = np.linalg.svd(centred_points, full_matrices=False)
    if not max_distance or sizes[1] <= 1e-9 * max_distance:
        raise GeometryError(Finding("points.collinear", n=n))
    direction, dip, _ = normals_to_planes(axes[2])
    plane = Plane(float(direction[0]), float(dip[0]))
    rms = None if n == 3 else float(np.sqrt(((centred_points @ axes[2]) ** 2).mean()))
    sigma, single_quantile, joint_quantile = sigma_m, Z95, CONE95
    if rms is not None and not sigma_m:
        from scipy.stats import f, t

        sigma = rms * math.sqrt(n / (n - 3))
        single_quantile = float(t.ppf(0.975, n - 3))
        joint_quantile = math.sqrt(2.0 * float(f.ppf(0.95, 2, n - 3)))
    if rms is None and not sigma_m:
        return ThreePoints(plane, None, None, None, n, warnings=_collinearity_warnings(sizes, None))
    is_noise_only = n > 3 and _is_noise_only(sizes, n, sigma_m)
    dip_error, dip_direction_error = _angle_errors(
        plane, axes, _half_angles(sizes, single_quantile * sigma, is_noise_only=is_noise_only)
    )
    largest_error_deg = math.degrees(
        _half_angles(sizes, joint_quantile * sigma, is_noise_only=is_noise_only)[1]
    )
    if largest_error_deg >= MAX_DIRECTION_ERROR_DEG or (n == 4 and not sigma_m):
        dip_direction_error = None
    warnings = _collinearity_warnings(sizes, largest_error_deg)
    return ThreePoints(
        plane, dip_error, dip_direction_error, largest_error_deg, n, rms, sigma, warnings
    )


def _is_noise_only(sizes: FloatArray, n: int, sigma_m: float) -> bool:
    """Return whether the width of points about their line may be due to errors alone.

    The width is compared with the error, if given. Otherwise the roundness of the cross-section is
    tested: for two errors of equal size, W ** ((n - 3) / 2) is uniformly distributed, where W =
    4 a b / (a + b) ** 2 for the sums of squares a and b.
    """
    from scipy.stats import chi2

    a, b = float(sizes[1]) ** 2, float(sizes[2]) ** 2
    if sigma_m:
        return bool(a + b <= sigma_m**2 * float(chi2.ppf(1.0 - SIGNIFICANCE, 2 * (n - 2))))
    p = (4.0 * a * b / (a + b) ** 2) ** ((n - 3) / 2.0)
    return bool(p > SIGNIFICANCE)


def _half_angles(sizes: FloatArray, error: float, *, is_noise_only: bool) -> tuple[float, float]:
    """Return the maximum tilts of compatible planes along the long and short axis, radians.

    A tilt is a right angle if all planes are compatible. `is_noise_only` is True if the extent
    along the short axis is due to errors.
    """

    def tilt(size: float) -> float:
        corrected_square = size**2 - sizes[2] ** 2 - error**2
        return (
            math.atan(error / math.sqrt(corrected_square))
            if corrected_square > 0.0
            else math.pi / 2
        )

    return tilt(float(sizes[0])), math.pi / 2 if is_noise_only else tilt(float(sizes[1]))


def _angle_errors(
    plane: Plane, axes: FloatArray, tilts: tuple[float, float]
) -> tuple[float, float | None]:
    """Return the errors of dip and dip direction over the planes of a cone, degrees.

    An error of the dip direction that exceeds a right angle is returned as None. `tilts` are the
    tilts of the cone along the first two axes, radians.
    """
    normal = axes[2] if axes[2] @ plane.normal() > 0 else -axes[2]
    long_axis_tilt, short_axis_tilt = tilts
    if long_axis_tilt >= math.pi / 2:
        return max(plane.dip_deg, 90.0 - plane.dip_deg), None
    if short_axis_tilt >= math.pi / 2:
        # All planes that contain a line whose direction has the error `long`.
        plunge = math.degrees(math.asin(min(1.0, abs(float(axes[0, 2])))))
        min_dip_deg = max(0.0, plunge - math.degrees(long_axis_tilt))
        return max(plane.dip_deg - min_dip_deg, 90.0 - plane.dip_deg), None
    cone_normals = (
        np.outer(math.tan(long_axis_tilt) * np.cos(CONE_ANGLES), axes[0])
        + np.outer(math.tan(short_axis_tilt) * np.sin(CONE_ANGLES), axes[1])
        + normal
    )
    cone_normals /= np.linalg.norm(cone_normals, axis=1, keepdims=True)
    dips = np.degrees(np.arccos(np.clip(cone_normals[:, 2], -1.0, 1.0)))
    dip_error = float(np.abs(dips - plane.dip_deg).max())
    horizontal_part = (
        np.array([axes[0, 2] / math.tan(long_axis_tilt), axes[1, 2] / math.tan(short_axis_tilt)])
        if long_axis_tilt
        else None
    )
    if (
        horizontal_part is not None
        and normal[2] > 0
        and float(np.hypot(*horizontal_part)) <= normal[2]
    ):
        # A horizontal plane, which has no dip direction, is compatible.
        return min(max(dip_error, plane.dip_deg), 90.0), None
    if plane.undefined:
        return min(dip_error, 90.0), None
    azimuths = np.degrees(np.arctan2(cone_normals[:, 0], cone_normals[:, 1]))
    azimuth_offsets = (azimuths - plane.dip_direction_deg + 180.0) % 360.0 - 180.0
    angle = float(np.abs(azimuth_offsets).max())
    return min(dip_error, 90.0), angle if angle < 90.0 else None


def _collinearity_warnings(sizes: FloatArray, max_tilt_deg: float | None) -> tuple[Finding, ...]:
    """Warn about points that do not determine the rotation about their line, or any plane.

    `max_tilt_deg` is the error of the plane; None if unknown.
    """
    is_collinear = float(sizes[1]) < MAX_COLLINEAR_RATIO * float(sizes[0])
    if max_tilt_deg is None:
        if not is_collinear:
            return ()
        return (
            Finding(
                "points.nearly-collinear",
                error_m=EXAMPLE_ERROR_M,
                turn_deg=math.degrees(math.atan(EXAMPLE_ERROR_M / float(sizes[1]))),
            ),
        )
    if max_tilt_deg < MAX_ERROR_DEG:
        return ()
    if is_collinear or float(sizes[1]) < 0.3 * float(sizes[0]):
        return (Finding("points.uncertain-about-line", error_deg=max_tilt_deg),)
    return (Finding("points.too-near", error_deg=max_tilt_deg),)
