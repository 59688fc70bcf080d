"""Fits of planes to many groups of points by PCA or planar regression.

All values are float64 in the World frame (x East, y North, z Up; metres). Points are centred first,
so UTM coordinates lose no digits. Both methods and the indices follow Tavani, Corradetti, Mercuri &
Seers, "Virtual outcrop models of geological structures", section 4.1, equations 19 to 21; M and K
follow Woodcock (1977) and Fernandez (2005). The errors are explained in plane_errors.py, and their
coverage in docs/plane_errors.md.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import AnyArray, BoolArray, FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.plane_figures import Method, figures, members
from vomstudio.geometry.plane_limits import MAX_COORDINATE, too_few_points_finding

Axis = Literal["auto", "x", "y", "z"]
_AXES: tuple[Axis, Axis, Axis] = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class FittedPlane:
    """One fitted plane with the fields of `PlaneFits`, and None for undefined figures."""

    n: int
    centroid: FloatArray
    normal: FloatArray
    eigenvalues: FloatArray
    axes: FloatArray
    trace: float | None
    rms: float | None
    residual: float | None
    extent: float | None
    max_coordinate: float | None
    coplanarity: float | None
    collinearity: float | None
    M: float | None
    K: float | None
    max_angular_error_deg: float | None
    min_angular_error_deg: float | None
    hyperbolic_overflow: bool
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    error_rake_deg: float | None
    dip_error_deg: float | None
    dip_direction_error_deg: float | None
    n_effective: float | None
    long_roughness: bool
    bow_tilt_deg: float | None
    dip_direction_deg: float | None
    dip_deg: float | None
    undefined: bool
    error: Finding | None
    method: str
    ordered: bool


@dataclass(frozen=True, eq=False)
class PlaneFits:
    """Fits of m planes; undefined figures are NaN, and an index may be infinite.

    Attributes
    ----------
    n : (m,) ndarray of int
        Number of points.
    centroid : (m, 3) ndarray
        Centroid of the points, m.
    normal : (m, 3) ndarray
        Unit normals with z >= 0; a horizontal normal points to an azimuth in [90, 270).
    eigenvalues : (m, 3) ndarray
        Eigenvalues of the covariance (divisor n), divided by their sum, descending (eq. 19).
    axes : (m, 3, 3) ndarray
        Unit eigenvectors e1, e2, e3 as rows; e3 points up and is the normal for "pca".
    trace : (m,) ndarray
        Sum of the eigenvalues before normalisation, m2.
    rms : (m,) ndarray
        Root mean square distance of the points from the plane (divisor n), m.
    residual : (m,) ndarray
        Root mean square residual along the minimised coordinate, m; equal to `rms` for "pca".
    extent : (m,) ndarray
        Extent of the points along e1, m.
    max_coordinate : (m,) ndarray
        Largest absolute coordinate, which determines the rounding error, m.
    coplanarity, collinearity : (m,) ndarray
        1 / l3 (eq. 20) and l1 / l2 (eq. 21).
    M, K : (m,) ndarray
        ln(l1 / l3) and ln(l1 / l2) / ln(l2 / l3).
    max_angular_error_deg, min_angular_error_deg : (m,) ndarray
        Hyperbolic error (Quinn & Ehlmann 2019), degrees.
    hyperbolic_overflow : (m,) ndarray of bool
        Whether the hyperbolic error has no bound below 90 degrees.
    max_confidence95_deg, min_confidence95_deg : (m,) ndarray
        Semi-axes of the joint 95 % region of the normal, as angles between normals, degrees.
    error_rake_deg : (m,) ndarray
        Rake [0, 180) from the right-hand-rule strike of the in-plane direction of the largest tilt.
    dip_error_deg, dip_direction_error_deg : (m,) ndarray
        Extent of the same region in dip and in dip direction, degrees; the error of the dip
        direction is undefined if the region contains the horizontal plane.
    n_effective : (m,) ndarray
        Number of independent points that would give the same region.
    long_roughness : (m,) ndarray of bool
        Whether the residuals drift on the scale of the trace, so that the larger of the two errors
        applies.
    bow_tilt_deg : (m,) ndarray
        95 % limit of the tilt caused by a bow of the trace that its points do not reveal, degrees.
    dip_direction_deg, dip_deg : (m,) ndarray
        Dip direction and dip, degrees.
    undefined : (m,) ndarray of bool
        Whether the plane is horizontal; its dip direction is then 0 by convention.
    error : tuple of Finding or None
        Reason why a plane could not be fitted (its figures are then NaN), or None.
    """

    n: IntArray
    centroid: FloatArray
    normal: FloatArray
    eigenvalues: FloatArray
    axes: FloatArray
    trace: FloatArray
    rms: FloatArray
    residual: FloatArray
    extent: FloatArray
    max_coordinate: FloatArray
    coplanarity: FloatArray
    collinearity: FloatArray
    M: FloatArray
    K: FloatArray
    max_angular_error_deg: FloatArray
    min_angular_error_deg: FloatArray
    hyperbolic_overflow: BoolArray
    max_confidence95_deg: FloatArray
    min_confidence95_deg: FloatArray
    error_rake_deg: FloatArray
    dip_error_deg: FloatArray
    dip_direction_error_deg: FloatArray
    n_effective: FloatArray
    long_roughness: BoolArray
    bow_tilt_deg: FloatArray
    dip_direction_deg: FloatArray
    dip_deg: FloatArray
    undefined: BoolArray
    error: tuple[Finding | None, ...]
    method: str
    ordered: bool

    def __len__(self) -> int:
        return len(self.n)

    def __getitem__(self, i: int) -> FittedPlane:
        return self.rows(range(i, i + 1))[0] if i >= 0 else self[i + len(self)]

    def rows(self, selected_rows: range | None = None) -> list[FittedPlane]:
        """Return all or the selected fits as a list, ten times faster than by indexing."""
        rows = range(len(self)) if selected_rows is None else selected_rows
        if len(rows) and not 0 <= min(rows) <= max(rows) < len(self):
            raise IndexError(rows)
        part = slice(rows.start, rows.stop, rows.step)
        columns = [
            _to_python_values(getattr(self, field.name), part, len(rows)) for field in fields(self)
        ]
        return [FittedPlane(*values) for values in zip(*columns, strict=True)]


def _to_python_values(column: Any, part: slice, count: int) -> list[Any]:
    """Convert a figure to plain Python values, with None for NaN and infinity.

    Vectors remain arrays.
    """
    if isinstance(column, str | bool):
        return [column] * count
    selected_values = column[part]
    if isinstance(selected_values, tuple) or selected_values.ndim > 1:
        return list(selected_values)
    values: list[Any] = selected_values.tolist()
    if selected_values.dtype.kind == "f" and not np.isfinite(selected_values).all():
        return [value if isfinite(value) else None for value in values]
    return values


def fit_plane(
    points: npt.ArrayLike,
    *,
    method: Method = "pca",
    axis: Axis = "auto",
    is_ordered: bool = True,
) -> FittedPlane:
    """Fit a plane to points.

    Parameters
    ----------
    points : (n, 3) array_like
        Points in the World frame, m.
    method, axis, is_ordered
        See `fit_planes`.

    Returns
    -------
    FittedPlane

    Raises
    ------
    GeometryError
        If the points do not determine a plane.
    """
    array = np.asarray(points, dtype=np.float64)
    if array.size == 0:
        array = array.reshape(0, 3)
    fits = fit_planes(
        array, np.array([0, len(array)]), method=method, axis=axis, is_ordered=is_ordered
    )
    if fits.error[0] is not None:
        raise GeometryError(fits.error[0])
    return fits[0]


def fit_planes(
    points: npt.ArrayLike,
    offsets: npt.ArrayLike,
    *,
    method: Method = "pca",
    axis: Axis = "auto",
    is_ordered: bool = True,
) -> PlaneFits:
    """Fit planes to many groups of points.

    Parameters
    ----------
    points : (N, 3) array_like
        Points in the World frame, m.
    offsets : (m + 1,) array_like of int
        Plane i is fitted to ``points[offsets[i]:offsets[i + 1]]``.
    method : {"pca", "regression"}
        "pca" minimises the distances from the plane, "regression" the residuals along `axis`.
    axis : {"auto", "x", "y", "z"}
        Axis of a regression. "auto" selects the axis nearest to the normal that "pca" gives. A
        regression along another axis attributes scatter to coordinates that it assumes to be exact,
        and underestimates the dip of steep planes. If an axis is named, planes that are parallel to
        it within their scatter are reported as errors.
    is_ordered : bool
        Whether the points follow a trace. If True, the correlation of neighbouring residuals is
        estimated and widens the confidence region. If False, the points are treated as independent.

    Returns
    -------
    PlaneFits

    Raises
    ------
    GeometryError
        If an argument is invalid.
    """
    xyz = np.asarray(points, dtype=np.float64)
    group_offsets = np.asarray(offsets, dtype=np.int64)
    if xyz.ndim != 2 or xyz.shape[1] != 3:
        raise GeometryError(Finding("points.invalid"), field="points")
    if method not in ("pca", "regression"):
        raise GeometryError(
            Finding("option.not-a-choice", value=method, choices=("pca", "regression")),
            field="method",
        )
    if axis not in ("auto", *_AXES):
        raise GeometryError(
            Finding("option.not-a-choice", value=axis, choices=("auto", *_AXES)), field="axis"
        )
    if (
        group_offsets.ndim != 1
        or len(group_offsets) < 1
        or group_offsets[0] < 0
        or group_offsets[-1] > len(xyz)
        or (np.any(np.diff(group_offsets) < 0))
    ):
        raise GeometryError(Finding("points.offsets"), field="offsets")
    counts = np.diff(group_offsets)
    if method == "regression" and axis == "auto":
        return _fit_along_nearest_axes(xyz, group_offsets, is_ordered)
    reasons, is_valid_group = _valid_groups(xyz, group_offsets, counts)
    result = _blank_figures(counts)
    if is_valid_group.any():
        if is_valid_group.all():
            points_used = xyz[group_offsets[0] : group_offsets[-1]]
        else:
            points_used = xyz[members(group_offsets[:-1][is_valid_group], counts[is_valid_group])]
        part, errors = figures(
            points_used, counts[is_valid_group], method, _axis_index(axis), is_ordered
        )
        rows = np.flatnonzero(is_valid_group)
        failed_rows = [i for i, error in enumerate(errors) if error is not None]
        for name, value in part.items():
            result[name][rows] = value
        for i in failed_rows:
            reasons[rows[i]] = errors[i]
            for name in part:
                default_value = False if result[name].dtype == bool else np.nan
                result[name][rows[i]] = default_value
    return PlaneFits(n=counts, error=tuple(reasons), method=method, ordered=is_ordered, **result)


def _axis_index(axis: Axis) -> int:
    return 2 if axis == "auto" else _AXES.index(axis)


def _fit_along_nearest_axes(
    xyz: FloatArray, group_offsets: IntArray, is_ordered: bool
) -> PlaneFits:
    """Fit regressions along the axis nearest to the PCA normal of each plane."""
    pca_fits = fit_planes(xyz, group_offsets, is_ordered=is_ordered)
    steepest_axes = np.abs(np.nan_to_num(pca_fits.normal)).argmax(axis=1)
    counts = np.diff(group_offsets)
    result = _blank_figures(counts)
    reasons: list[Finding | None] = [None] * len(counts)
    for k, axis in enumerate(_AXES):
        rows = np.flatnonzero(steepest_axes == k)
        if not len(rows):
            continue
        offsets = np.concatenate([[0], np.cumsum(counts[rows])])
        points_used = xyz[members(group_offsets[:-1][rows], counts[rows])]
        part = fit_planes(
            points_used, offsets, method="regression", axis=axis, is_ordered=is_ordered
        )
        for name in result:
            result[name][rows] = getattr(part, name)
        for row, reason in zip(rows, part.error, strict=True):
            reasons[row] = reason
    return PlaneFits(
        n=counts, error=tuple(reasons), method="regression", ordered=is_ordered, **result
    )


def _blank_figures(counts: IntArray) -> dict[str, AnyArray]:
    shapes = {"centroid": (3,), "normal": (3,), "eigenvalues": (3,), "axes": (3, 3)}
    flags = ("hyperbolic_overflow", "long_roughness", "undefined")
    m = len(counts)
    return {
        field.name: np.zeros(m, bool)
        if field.name in flags
        else np.full((m, *shapes.get(field.name, ())), np.nan)
        for field in fields(PlaneFits)
        if field.name not in ("n", "error", "method", "ordered")
    }


def _valid_groups(
    xyz: FloatArray, group_offsets: IntArray, counts: IntArray
) -> tuple[list[Finding | None], BoolArray]:
    """Return why each group cannot be fitted, and a mask of the valid groups.

    The reason is None for valid groups.
    """
    has_points = counts >= 3
    is_finite = np.ones(len(counts), bool)
    # One maximum suffices in the usual case, in which all points are valid. A comparison with NaN
    # is false.
    if len(xyz) and not np.abs(xyz).max() < MAX_COORDINATE:
        invalid_counts = np.concatenate(
            [[0], np.cumsum(~(np.abs(xyz) < MAX_COORDINATE).all(axis=1))]
        )
        is_finite = invalid_counts[group_offsets[1:]] == invalid_counts[group_offsets[:-1]]
    reasons: list[Finding | None] = [None] * len(counts)
    for i in np.flatnonzero(~(has_points & is_finite)).tolist():
        reasons[i] = (
            too_few_points_finding(int(counts[i])) if is_finite[i] else Finding("points.not-finite")
        )
    return reasons, has_points & is_finite
