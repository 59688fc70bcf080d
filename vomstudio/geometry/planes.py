"""Planes through points: moment of inertia (PCA) and planar regression, many at once.

Everything is float64 in the World frame (x East, y North, z Up; metres). Points are centred before
anything else, so UTM coordinates lose no digits. Source of the two methods and of the indices:
Tavani, Corradetti, Mercuri & Seers, "Virtual outcrop models of geological structures", section 4.1,
equations 19 to 21; M and K after Woodcock (1977) and Fernandez (2005). The errors are explained
in plane_errors.py, their coverage in docs/plane_errors.md.
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
from vomstudio.geometry.plane_limits import LARGEST, too_few_points

Axis = Literal["auto", "x", "y", "z"]
_AXES: tuple[Axis, Axis, Axis] = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class PlaneFit:
    """One fitted plane; None where a figure is undefined. Fields as in PlaneFits."""

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
    """m fitted planes, as arrays. NaN where undefined, infinite where an index is.

    n : (m,) points per plane
    centroid : (m, 3) centre of the points
    normal : (m, 3) unit vectors, z >= 0; a horizontal one points to an azimuth in [90, 270)
    eigenvalues : (m, 3) of the covariance (divisor n), divided by their sum, descending (eq. 19)
    axes : (m, 3, 3) their unit vectors e1, e2, e3 as rows; e3 points up. e3 is the normal of "pca"
    trace : (m,) sum of the eigenvalues before the division, m2
    rms : (m,) root mean square distance of the points from the plane, divisor n, m
    residual : (m,) the same along the coordinate that was minimised: rms for "pca", m
    extent : (m,) length of the points along e1, m
    max_coordinate : (m,) largest absolute coordinate, which sets the rounding, m
    coplanarity, collinearity : (m,) 1 / l3 (eq. 20), l1 / l2 (eq. 21)
    M, K : (m,) ln(l1 / l3), ln(l1 / l2) / ln(l2 / l3)
    max_angular_error_deg, min_angular_error_deg : (m,) hyperbolic error (Quinn & Ehlmann 2019)
    hyperbolic_overflow : (m,) that error has no bound below 90 degrees
    max_confidence95_deg, min_confidence95_deg : (m,) semi-axes of the joint 95 % region of the
        normal, in terms of the angle between normals
    error_rake_deg : (m,) rake [0, 180) from the right-hand-rule strike of the in-plane direction in
        which the plane tilts most
    dip_error_deg, dip_direction_error_deg : (m,) the same region seen along and across the dip; the
        second is undefined where the region reaches the horizontal plane
    n_effective : (m,) number of independent points that would give the same region
    long_roughness : (m,) the residuals wander on the scale of the trace itself, so that neither
        figure can be trusted alone: the wider one counts
    bow_tilt_deg : (m,) tilt by a bow of the trace that its points do not show, 95 %
    dip_direction_deg, dip_deg : (m,); undefined : (m,) horizontal, dip direction 0 by convention
    error : per plane, why there is none (its figures are then NaN), or None
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

    def __getitem__(self, i: int) -> PlaneFit:
        return self.rows(range(i, i + 1))[0] if i >= 0 else self[i + len(self)]

    def rows(self, chosen: range | None = None) -> list[PlaneFit]:
        """One after the other, all or some: together they take a tenth of the time."""
        within = range(len(self)) if chosen is None else chosen
        if len(within) and not 0 <= min(within) <= max(within) < len(self):
            raise IndexError(within)
        part = slice(within.start, within.stop, within.step)
        columns = [_plain(getattr(self, f.name), part, len(within)) for f in fields(self)]
        return [PlaneFit(*values) for values in zip(*columns, strict=True)]


def _plain(column: Any, part: slice, count: int) -> list[Any]:
    """Plain Python values of one figure; None for NaN and infinity. Vectors stay arrays."""
    if isinstance(column, str | bool):
        return [column] * count
    own = column[part]
    if isinstance(own, tuple) or own.ndim > 1:
        return list(own)
    values: list[Any] = own.tolist()
    if own.dtype.kind == "f" and not np.isfinite(own).all():
        return [value if isfinite(value) else None for value in values]
    return values


def fit_plane(
    points: npt.ArrayLike,
    *,
    method: Method = "pca",
    axis: Axis = "auto",
    ordered: bool = True,
) -> PlaneFit:
    """The plane through points (n, 3); GeometryError with the reason where there is none.

    See fit_planes for the meaning of the options.
    """
    array = np.asarray(points, dtype=np.float64)
    if array.size == 0:
        array = array.reshape(0, 3)
    fits = fit_planes(array, np.array([0, len(array)]), method=method, axis=axis, ordered=ordered)
    if fits.error[0] is not None:
        raise GeometryError(fits.error[0])
    return fits[0]


def fit_planes(
    points: npt.ArrayLike,
    offsets: npt.ArrayLike,
    *,
    method: Method = "pca",
    axis: Axis = "auto",
    ordered: bool = True,
) -> PlaneFits:
    """Planes through many groups of points; plane i takes points[offsets[i]:offsets[i + 1]].

    points : (N, 3) World coordinates, m
    offsets : (m + 1,) non-decreasing
    method : "pca" minimises distances from the plane, "regression" those along `axis`
    axis : "auto" takes for each group the one that is nearest the normal of its plane by "pca": a
        regression along another attributes scatter to the coordinates that it takes for exact, and
        makes steep planes too gentle. A named one is refused for a plane that is parallel to it
        within its scatter
    ordered : the points follow a trace: how much the residuals of neighbours depend on each other
        is then estimated and widens the confidence. False: every point counts as independent.
    """
    xyz = np.asarray(points, dtype=np.float64)
    cuts = np.asarray(offsets, dtype=np.int64)
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
        cuts.ndim != 1
        or len(cuts) < 1
        or cuts[0] < 0
        or cuts[-1] > len(xyz)
        or (np.any(np.diff(cuts) < 0))
    ):
        raise GeometryError(Finding("points.offsets"), field="offsets")
    counts = np.diff(cuts)
    if method == "regression" and axis == "auto":
        return _along_nearest_axes(xyz, cuts, ordered)
    reasons, keep = _sound_groups(xyz, cuts, counts)
    result = _blank(counts, method, ordered)
    if keep.any():
        if keep.all():
            chosen = xyz[cuts[0] : cuts[-1]]
        else:
            chosen = xyz[members(cuts[:-1][keep], counts[keep])]
        part, errors = figures(chosen, counts[keep], method, _axis_index(axis), ordered)
        rows = np.flatnonzero(keep)
        failed = [i for i, error in enumerate(errors) if error is not None]
        for name, value in part.items():
            result[name][rows] = value
        for i in failed:
            reasons[rows[i]] = errors[i]
            for name in part:
                blank = False if result[name].dtype == bool else np.nan
                result[name][rows[i]] = blank
    return PlaneFits(n=counts, error=tuple(reasons), method=method, ordered=ordered, **result)


def _axis_index(axis: Axis) -> int:
    return 2 if axis == "auto" else _AXES.index(axis)


def _along_nearest_axes(xyz: FloatArray, cuts: IntArray, ordered: bool) -> PlaneFits:
    """Regressions, each along the axis nearest the normal of its plane by inertia."""
    upright = fit_planes(xyz, cuts, ordered=ordered)
    nearest = np.abs(np.nan_to_num(upright.normal)).argmax(axis=1)
    counts = np.diff(cuts)
    result = _blank(counts, "regression", ordered)
    reasons: list[Finding | None] = [None] * len(counts)
    for k, axis in enumerate(_AXES):
        rows = np.flatnonzero(nearest == k)
        if not len(rows):
            continue
        offsets = np.concatenate([[0], np.cumsum(counts[rows])])
        chosen = xyz[members(cuts[:-1][rows], counts[rows])]
        part = fit_planes(chosen, offsets, method="regression", axis=axis, ordered=ordered)
        for name in result:
            result[name][rows] = getattr(part, name)
        for row, reason in zip(rows, part.error, strict=True):
            reasons[row] = reason
    return PlaneFits(n=counts, error=tuple(reasons), method="regression", ordered=ordered, **result)


def _blank(counts: IntArray, method: str, ordered: bool) -> dict[str, AnyArray]:
    shapes = {"centroid": (3,), "normal": (3,), "eigenvalues": (3,), "axes": (3, 3)}
    flags = ("hyperbolic_overflow", "long_roughness", "undefined")
    m = len(counts)
    return {
        f.name: np.zeros(m, bool)
        if f.name in flags
        else np.full((m, *shapes.get(f.name, ())), np.nan)
        for f in fields(PlaneFits)
        if f.name not in ("n", "error", "method", "ordered")
    }


def _sound_groups(
    xyz: FloatArray, cuts: IntArray, counts: IntArray
) -> tuple[list[Finding | None], BoolArray]:
    """The reason against each group that cannot be fitted whatever its shape, and the others."""
    many = counts >= 3
    finite = np.ones(len(counts), bool)
    # One maximum tells that all is well, which it nearly always is; NaN is not below the limit.
    if len(xyz) and not np.abs(xyz).max() < LARGEST:
        bad = np.concatenate([[0], np.cumsum(~(np.abs(xyz) < LARGEST).all(axis=1))])
        finite = bad[cuts[1:]] == bad[cuts[:-1]]
    reasons: list[Finding | None] = [None] * len(counts)
    for i in np.flatnonzero(~(many & finite)).tolist():
        reasons[i] = too_few_points(int(counts[i])) if finite[i] else Finding("points.not-finite")
    return reasons, many & finite
