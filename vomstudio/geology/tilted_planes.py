"""Random draws of planes within their errors and the errors of their registrations.

The joint 95 % region of the orientation of a plane is that of a normal distribution about it
(chi-square with two degrees of freedom), wrapped onto the sphere along great circles. The part of
the total error that exceeds the errors of the fit and the registration is isotropic
(`geometry.rotation_errors.enlarged_semi_axes`). Planes with the same registration rotate together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import UsageError
from vomstudio.geology.common_rotation_errors import RotationErrors
from vomstudio.geology.orientation import planes_to_normals, sin_cos_deg
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geometry.rotation_errors import CHI2_TWO, enlarged_semi_axes

MAX_SEMI_AXIS_DEG = 89.9


@dataclass(frozen=True, eq=False)
class TiltedPlanes:
    """Planes with the errors of their orientations.

    Attributes
    ----------
    normals : (n, 3) ndarray
        Upward normals in the World frame.
    axes : (n, 2, 3) ndarray
        Tangent vectors with the length of one standard deviation, radians; zero if there is no
        error.
    rotation_errors : RotationErrors or None
        See `OrientationRows`.
    """

    normals: FloatArray
    axes: FloatArray
    rotation_errors: RotationErrors | None = None

    @property
    def has_known_error(self) -> BoolArray:
        """Whether any error of each plane (n,) is known."""
        has_individual_error = np.asarray(self.axes.any(axis=(1, 2)))
        return (
            has_individual_error
            if self.rotation_errors is None
            else has_individual_error | (self.rotation_errors.group >= 0)
        )

    def draw(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Draw random upward unit normals (count, n, 3)."""
        n = len(self.normals)
        displacement = np.einsum(
            "knj,njc->knc", generator.standard_normal((count, n, 2)), self.axes
        )
        if self.rotation_errors is not None and self.rotation_errors.has_known_errors:
            group = self.rotation_errors.group
            covariance_roots = np.array(
                [_covariance_root(covariance) for covariance in self.rotation_errors.rotations]
            )
            normal_draws = generator.standard_normal((count, len(covariance_roots), 3))
            rotations = np.einsum("gij,kgj->kgi", covariance_roots, normal_draws)
            rotated_normals = np.cross(rotations[:, np.maximum(group, 0)], self.normals)
            displacement += np.where((group >= 0)[:, None], rotated_normals, 0.0)
        angle = np.linalg.norm(displacement, axis=-1, keepdims=True)
        direction = displacement / np.maximum(angle, 1e-300)
        drawn_normals = np.cos(angle) * self.normals + np.sin(angle) * direction
        return np.asarray(np.where(drawn_normals[..., 2:] < 0.0, -drawn_normals, drawn_normals))


def tilted_planes(table: OrientationRows, rows: IntArray) -> TiltedPlanes:
    """Return the planes of a table with their errors.

    The errors are read from the columns `max_confidence95_deg`, `min_confidence95_deg`,
    `error_rake_deg` and `total95_deg`; if the rake is missing, the larger error applies to all
    directions. If these columns are missing, the errors are read from `dip_error_deg` and
    `dip_direction_error_deg`.

    Parameters
    ----------
    table : OrientationRows
    rows : (n,) ndarray of int
        Row indices of the planes.

    Returns
    -------
    TiltedPlanes
    """
    azimuth, dip = table.dip_direction_deg[rows], table.dip_deg[rows]
    rotation_errors = None if table.rotation_errors is None else table.rotation_errors.of(rows)
    registration_deg = np.zeros(len(rows))
    if rotation_errors is not None:
        # Exclude the common rotation from the errors of the individual planes.
        registration = np.nan_to_num(column_numbers(table, rows, "registration_error_deg"))
        registration_deg = np.where(rotation_errors.group >= 0, registration, 0.0)
    axes = _axes(table, rows, registration_deg)
    return TiltedPlanes(planes_to_normals(azimuth, dip), axes, rotation_errors)


def axes_without_registration(table: OrientationRows, rows: IntArray) -> FloatArray:
    """Return the tangent axes of the errors, excluding those of the registration.

    The errors of the registration are removed from `total95_deg`.

    Parameters
    ----------
    table : OrientationRows
    rows : (n,) ndarray of int
        Row indices of the planes.

    Returns
    -------
    (n, 2, 3) ndarray
        See `TiltedPlanes`.
    """
    registration = np.nan_to_num(column_numbers(table, rows, "registration_error_deg"))
    return _axes(table, rows, registration)


def _axes(table: OrientationRows, rows: IntArray, excluded_deg: FloatArray) -> FloatArray:
    """Return the tangent axes of the errors.

    `excluded_deg` (n,) are 95 % half-angles that are removed from the total error.
    """
    azimuth, dip = table.dip_direction_deg[rows], table.dip_deg[rows]
    major_deg, minor_deg, total_deg, rake = (
        column_numbers(table, rows, name)
        for name in (
            "max_confidence95_deg",
            "min_confidence95_deg",
            "total95_deg",
            "error_rake_deg",
        )
    )
    dip_errors_deg, direction_errors_deg = (
        column_numbers(table, rows, name) for name in ("dip_error_deg", "dip_direction_error_deg")
    )
    # An error of the dip direction tilts the plane along its strike by the sine of the dip.
    direction_errors_deg = direction_errors_deg * np.sin(np.radians(dip))
    has_split_errors = (
        ~np.isfinite(major_deg) & ~np.isfinite(total_deg) & np.isfinite(dip_errors_deg)
    )
    major_deg = np.where(has_split_errors, dip_errors_deg, major_deg)
    minor_deg = np.where(
        has_split_errors,
        np.where(np.isfinite(direction_errors_deg), direction_errors_deg, dip_errors_deg),
        minor_deg,
    )
    minor_deg = np.where(np.isfinite(rake) | has_split_errors, minor_deg, major_deg)
    rake = np.where(has_split_errors, 90.0, rake)
    known_major_deg = np.nan_to_num(major_deg)
    known_minor_deg = np.where(np.isfinite(minor_deg), minor_deg, known_major_deg)
    semi_axes_deg = np.stack(
        enlarged_semi_axes(
            known_major_deg, known_minor_deg, np.nan_to_num(total_deg), excluded_deg
        ),
        axis=-1,
    )
    sigma = np.radians(np.minimum(semi_axes_deg, MAX_SEMI_AXIS_DEG)) / math.sqrt(CHI2_TWO)
    return np.asarray(sigma[..., None] * _frames(azimuth, dip, np.nan_to_num(rake)))


def _frames(azimuth_deg: FloatArray, dip_deg: FloatArray, rake_deg: FloatArray) -> FloatArray:
    """Return unit vectors (n, 2, 3) in the planes: at the given rake, and perpendicular to it."""
    strike_deg = np.where(dip_deg >= 90.0, np.mod(azimuth_deg - 90.0, 180.0), azimuth_deg - 90.0)
    sin_s, cos_s = sin_cos_deg(strike_deg)
    sin_d, cos_d = sin_cos_deg(dip_deg)
    sin_r, cos_r = (part[:, None] for part in sin_cos_deg(rake_deg))
    strike = np.stack([sin_s, cos_s, np.zeros_like(sin_s)], axis=-1)
    # The horizontal dip direction is (cos, -sin) of the strike.
    down = np.stack([cos_s * cos_d, -sin_s * cos_d, -sin_d], axis=-1)
    return np.stack([cos_r * strike + sin_r * down, cos_r * down - sin_r * strike], axis=1)


def column_numbers(table: OrientationRows, rows: IntArray, name: str) -> FloatArray:
    """Return the half-angles or rakes in a column, degrees.

    Parameters
    ----------
    table : OrientationRows
    rows : (n,) ndarray of int
    name : str
        Name of the column.

    Returns
    -------
    (n,) ndarray
        Values of the given rows; NaN if missing or not between 0 and 180.
    """
    try:
        cells = table.column(name)
    except UsageError:
        return np.full(len(rows), np.nan)
    return np.array([_number(cells[row]) for row in rows], np.float64)


def _number(cell: str) -> float:
    try:
        value = float(cell.replace(",", "."))
    except ValueError:
        return math.nan
    return value if 0.0 <= value <= 180.0 else math.nan


def _covariance_root(covariance: FloatArray) -> FloatArray:
    """Return a matrix whose product with its transpose is the covariance."""
    values, axes = np.linalg.eigh(covariance)
    return np.asarray(axes * np.sqrt(np.maximum(values, 0.0)))
