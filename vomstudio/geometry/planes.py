"""Planes through points: moment of inertia (PCA) and planar regression, many at once.

Everything is float64 in the World frame (x East, y North, z Up; metres). Points are centred before
anything else, so UTM coordinates lose no digits. Source of the two methods and of the indices:
Tavani, Corradetti, Mercuri & Seers, "Virtual outcrop models of geological structures", section 4.1,
equations 19 to 21; M and K after Woodcock (1977) and Fernandez (2005). The errors are explained
in plane_errors.py, their coverage in docs/plane_errors.md.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geometry import plane_errors
from vomstudio.geometry.vectors import (
    TILT_FLOOR,
    dip_of_normals,
    upward,
)

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]
Method = Literal["pca", "regression"]
Axis = Literal["x", "y", "z"]

TOO_FEW = "needs at least 3 points; pick more"
NOT_FINITE = "has coordinates that are not finite numbers, or beyond 1e150; remove those points"
IDENTICAL = "all points are at the same place; pick points farther apart"
COLLINEAR = "all points lie on one straight line, which many planes contain; pick one beside it"
PARALLEL = (
    "the plane is parallel to the {axis} axis, so it cannot be found by regression of {axis}; "
    "use another axis, or the moment of inertia (pca)"
)

# Squares of these stay in range.
LARGEST = 1e150
# Distances below this many roundings of the largest coordinate are rounding, not shape.
ROUNDINGS = 4.0
# Points repeated exactly are looked for in short traces only, where one of them matters.
COUNT_REPEATS_UP_TO = 16


@dataclass(frozen=True, eq=False)
class PlaneFit:
    """One fitted plane; None where a figure is undefined. Fields as in PlaneFits."""

    n: int
    centroid: Floats
    normal: Floats
    eigenvalues: Floats
    axes: Floats
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
    dip_direction_deg: float | None
    dip_deg: float | None
    undefined: bool
    error: str | None
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
    dip_direction_deg, dip_deg : (m,); undefined : (m,) horizontal, dip direction 0 by convention
    error : per plane, why there is none (its figures are then NaN), or None
    """

    n: Ints
    centroid: Floats
    normal: Floats
    eigenvalues: Floats
    axes: Floats
    trace: Floats
    rms: Floats
    residual: Floats
    extent: Floats
    max_coordinate: Floats
    coplanarity: Floats
    collinearity: Floats
    M: Floats
    K: Floats
    max_angular_error_deg: Floats
    min_angular_error_deg: Floats
    hyperbolic_overflow: Bools
    max_confidence95_deg: Floats
    min_confidence95_deg: Floats
    error_rake_deg: Floats
    dip_error_deg: Floats
    dip_direction_error_deg: Floats
    n_effective: Floats
    long_roughness: Bools
    dip_direction_deg: Floats
    dip_deg: Floats
    undefined: Bools
    error: tuple[str | None, ...]
    method: str
    ordered: bool

    def __len__(self) -> int:
        return len(self.n)

    def __getitem__(self, i: int) -> PlaneFit:
        values: dict[str, Any] = {
            f.name: value if isinstance(value, str | bool) else _scalar(value[i])
            for f in fields(self)
            for value in [getattr(self, f.name)]
        }
        return PlaneFit(**values)


def _scalar(value: Any) -> Any:
    """A plain Python value; None for NaN and infinity."""
    if isinstance(value, np.floating):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def fit_plane(
    points: npt.ArrayLike,
    *,
    method: Method = "pca",
    axis: Axis = "z",
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
        raise GeometryError(f"A plane through {len(array)} points: {fits.error[0]}.")
    return fits[0]


def fit_planes(
    points: npt.ArrayLike,
    offsets: npt.ArrayLike,
    *,
    method: Method = "pca",
    axis: Axis = "z",
    ordered: bool = True,
) -> PlaneFits:
    """Planes through many groups of points; plane i takes points[offsets[i]:offsets[i + 1]].

    points : (N, 3) World coordinates, m
    offsets : (m + 1,) non-decreasing
    method : "pca" minimises distances from the plane, "regression" those along `axis`
    ordered : the points follow a trace: how much the residuals of neighbours depend on each other
        is then estimated and widens the confidence. False: every point counts as independent.
    """
    xyz = np.asarray(points, dtype=np.float64)
    cuts = np.asarray(offsets, dtype=np.int64)
    if xyz.ndim != 2 or xyz.shape[1] != 3:
        raise GeometryError("Points need three coordinates each: x, y, z.", field="points")
    if method not in ("pca", "regression"):
        raise GeometryError(f"Unknown method {method!r}: use pca or regression.", field="method")
    if axis not in ("x", "y", "z"):
        raise GeometryError(f"Unknown axis {axis!r}: use x, y or z.", field="axis")
    if (
        cuts.ndim != 1
        or len(cuts) < 1
        or cuts[0] < 0
        or cuts[-1] > len(xyz)
        or (np.any(np.diff(cuts) < 0))
    ):
        raise GeometryError(
            "Offsets must rise from 0 to the number of points at most.", field="offsets"
        )
    counts = np.diff(cuts)
    reasons, keep = _sound_groups(xyz, cuts, counts)
    result = _blank(counts, method, ordered)
    if keep.any():
        if keep.all():
            chosen = xyz[cuts[0] : cuts[-1]]
        else:
            chosen = xyz[_members(cuts[:-1][keep], counts[keep])]
        part, errors = _fit(chosen, counts[keep], method, "xyz".index(axis), ordered)
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


def _blank(counts: Ints, method: str, ordered: bool) -> dict[str, npt.NDArray[Any]]:
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


def _members(starts: Ints, counts: Ints) -> Ints:
    """Indices of all points of the groups, group after group."""
    shift = np.repeat(starts - (np.cumsum(counts) - counts), counts)
    return np.arange(len(shift)) + shift


def _sound_groups(xyz: Floats, cuts: Ints, counts: Ints) -> tuple[list[str | None], Bools]:
    """The reason against each group that cannot be fitted whatever its shape, and the others."""
    many = counts >= 3
    finite = np.ones(len(counts), bool)
    # One maximum tells that all is well, which it nearly always is; NaN is not below the limit.
    if len(xyz) and not np.abs(xyz).max() < LARGEST:
        bad = np.concatenate([[0], np.cumsum(~(np.abs(xyz) < LARGEST).all(axis=1))])
        finite = bad[cuts[1:]] == bad[cuts[:-1]]
    reasons: list[str | None] = [None] * len(counts)
    for i in np.flatnonzero(~(many & finite)).tolist():
        reasons[i] = NOT_FINITE if not finite[i] else TOO_FEW
    return reasons, many & finite


def _fit(
    xyz: Floats, counts: Ints, method: Method, axis: int, ordered: bool
) -> tuple[dict[str, npt.NDArray[Any]], list[str | None]]:
    """All figures of groups that lie one after the other in xyz, each of at least 3 points."""
    m = len(counts)
    starts = np.cumsum(counts) - counts
    n = counts.astype(np.float64)

    def total(x: Floats) -> Floats:
        return np.add.reduceat(x, starts)

    def spread(x: Floats) -> Floats:
        return np.repeat(x, counts)

    # Off the first point first: that difference is exact or nearly so, the mean then small.
    first = xyz[starts]
    local = [xyz[:, i] - spread(first[:, i]) for i in range(3)]
    mean = [total(x) / n for x in local]
    local = [x - spread(c) for x, c in zip(local, mean, strict=True)]
    centroid = first + np.stack(mean, axis=1)
    max_coordinate = np.maximum.reduceat(np.abs(xyz).max(axis=1), starts)

    # A common length, so that squares of tiny and huge coordinates stay in range.
    size = np.maximum.reduceat(np.maximum.reduce([np.abs(x) for x in local]), starts)
    unit = np.where(size > 1.0 / LARGEST, size, 1.0)
    per_unit = spread(1.0 / unit)
    local = [x * per_unit for x in local]
    rounding = ROUNDINGS * np.finfo(np.float64).eps * max_coordinate / unit

    covariance = np.empty((m, 3, 3))
    for i in range(3):
        for j in range(i, 3):
            covariance[:, i, j] = covariance[:, j, i] = total(local[i] * local[j]) / n
    axes = np.linalg.eigh(covariance)[1].transpose(0, 2, 1)[:, ::-1]  # rows, descending
    axes, (u, v, r), values = _sharpen(axes, local, starts, counts, n)

    low, high = np.minimum.reduceat(u, starts), np.maximum.reduceat(u, starts)
    values[:, 2] = np.where(np.sqrt(values[:, 2]) <= rounding, 0.0, values[:, 2])
    errors: list[str | None] = [None] * m
    identical = (np.sqrt(values[:, 0]) <= rounding) | (size <= 1.0 / LARGEST)
    collinear = ~identical & (np.sqrt(values[:, 1]) <= rounding)
    for i in np.flatnonzero(identical | collinear).tolist():
        errors[i] = IDENTICAL if identical[i] else COLLINEAR

    tr = values.sum(axis=1)
    tr = np.where(tr > 0.0, tr, 1.0)
    axes = axes.copy()
    axes[:, 2] = upward(axes[:, 2])
    normal = axes[:, 2]
    rms = np.sqrt(values[:, 2])
    residual = rms
    leverage = None
    if method == "regression":
        normal, residual, parallel, leverage = _regress(covariance, axis, rounding)
        rms = residual * np.abs(normal[:, axis])
        for i in np.flatnonzero(parallel & ~identical & ~collinear).tolist():
            errors[i] = PARALLEL.format(axis="xyz"[axis])

    with np.errstate(divide="ignore", invalid="ignore"):
        l1, l2, l3 = values.T / tr
        coplanarity = 1.0 / l3
        collinearity = l1 / l2
        m_index = np.log(l1 / l3)
        k_index = np.log(collinearity) / np.log(l2 / l3)

        floor = np.maximum(TILT_FLOOR, rounding / np.sqrt(values[:, 1]))
        floor = np.where(np.isfinite(floor), np.minimum(floor, 1e-3), TILT_FLOOR)
    dip_direction, dip, flat = dip_of_normals(normal, floor)

    figures = _errors(
        u,
        v,
        r,
        starts,
        counts,
        values,
        axes,
        normal,
        dip_direction,
        dip,
        flat,
        _distinct(xyz, starts, counts),
        ordered,
        None if leverage is None else leverage * (residual**2)[:, None, None],
    )
    return {
        "centroid": centroid,
        "normal": normal,
        "eigenvalues": values / tr[:, None],
        "axes": axes,
        "trace": tr * unit**2,
        "rms": rms * unit,
        "residual": residual * unit,
        "extent": (high - low) * unit,
        "max_coordinate": max_coordinate,
        "coplanarity": coplanarity,
        "collinearity": collinearity,
        "M": m_index,
        "K": k_index,
        "dip_direction_deg": dip_direction,
        "dip_deg": dip,
        "undefined": flat,
        **figures,
    }, errors


def _sharpen(
    axes: Floats, local: list[Floats], starts: Ints, counts: Ints, n: Floats
) -> tuple[Floats, tuple[Floats, Floats, Floats], Floats]:
    """Axes, coordinates along them and variances, free of the rounding of the covariance.

    The covariance of a long straight trace holds its thickness only to 1e-8 of its length. In the
    frame of its eigenvectors that is no more so: there e2 and e3 are separated once more.
    """
    frame = axes
    u, v, r = _along(frame, local, counts)
    b22 = np.add.reduceat(v * v, starts) / n
    b33 = np.add.reduceat(r * r, starts) / n
    b23 = np.add.reduceat(v * r, starts) / n
    angle = 0.5 * np.arctan2(2.0 * b23, b22 - b33)
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    frame = np.stack(
        [frame[:, 0], c * frame[:, 1] + s * frame[:, 2], c * frame[:, 2] - s * frame[:, 1]], axis=1
    )
    u, v, r = _along(frame, local, counts)
    values = np.stack([np.add.reduceat(x * x, starts) / n for x in (u, v, r)], axis=1)
    return frame, (u, v, r), values


def _along(frame: Floats, local: list[Floats], counts: Ints) -> tuple[Floats, Floats, Floats]:
    def component(k: int) -> Floats:
        return sum(
            (np.repeat(frame[:, k, i], counts) * local[i] for i in range(1, 3)),
            start=np.repeat(frame[:, k, 0], counts) * local[0],
        )

    return component(0), component(1), component(2)


def _distinct(xyz: Floats, starts: Ints, counts: Ints) -> Ints:
    """Number of different points per group; a point clicked twice is no second witness."""
    distinct = counts.copy()
    short = counts <= COUNT_REPEATS_UP_TO
    if not short.any():
        return distinct
    group = np.repeat(np.flatnonzero(short), counts[short])
    part = xyz[_members(starts[short], counts[short])]
    order = np.lexsort((part[:, 2], part[:, 1], part[:, 0], group))
    same = (np.diff(part[order], axis=0) == 0.0).all(axis=1) & (np.diff(group[order]) == 0)
    np.subtract.at(distinct, group[order][1:][same], 1)
    return distinct


def _regress(
    covariance: Floats, axis: int, rounding: Floats
) -> tuple[Floats, Floats, Bools, Floats]:
    """Upward normals of the regressions of one coordinate, their residual, where parallel, and the
    covariance (m, 3, 3) of the normal's end for residuals of variance n."""
    a, b = (i for i in range(3) if i != axis)
    saa, sbb, sab = covariance[:, a, a], covariance[:, b, b], covariance[:, a, b]
    sac, sbc = covariance[:, a, axis], covariance[:, b, axis]
    determinant = saa * sbb - sab * sab
    # The smaller spread of the two other coordinates: zero for a plane parallel to the axis.
    spread = determinant / np.maximum(saa + sbb, np.finfo(np.float64).tiny)
    parallel = np.sqrt(np.maximum(spread, 0.0)) <= np.maximum(rounding, 1e-7)
    safe = np.where(parallel, 1.0, determinant)
    pa = (sbb * sac - sab * sbc) / safe
    pb = (saa * sbc - sab * sac) / safe
    normal = np.empty((len(pa), 3))
    normal[:, a], normal[:, b], normal[:, axis] = -pa, -pb, 1.0
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    square = covariance[:, axis, axis] - pa * sac - pb * sbc
    # (S^-1) of the slopes, carried over to the normal, of which slopes are the ratio.
    inverse = np.zeros((len(pa), 3, 3))
    inverse[:, a, a], inverse[:, b, b] = sbb / safe, saa / safe
    inverse[:, a, b] = inverse[:, b, a] = -sab / safe
    across = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    leverage = across @ inverse @ across * (normal[:, axis] ** 2)[:, None, None]
    return upward(normal), np.sqrt(np.maximum(square, 0.0)), parallel, leverage


def _errors(
    u: Floats,
    v: Floats,
    r: Floats,
    starts: Ints,
    counts: Ints,
    values: Floats,
    axes: Floats,
    normal: Floats,
    dip_direction: Floats,
    dip: Floats,
    flat: Bools,
    distinct: Ints,
    ordered: bool,
    regression: Floats | None,
) -> dict[str, npt.NDArray[Any]]:
    """Both angular errors and their split; NaN where fewer than 4 different points leave none."""
    known = distinct > 3
    n = np.where(known, counts, 4)
    dof = np.where(known, distinct - 3.0, 1.0)
    q1, q2, effective, long = plane_errors.quantiles(u, v, r, starts, counts, dof, ordered)
    # Points exactly in a plane have residuals of rounding alone, which tell of no roughness.
    exact = values[:, 2] == 0.0
    effective, long = np.where(exact, dof + 3.0, effective), long & ~exact
    h_max, h_min, overflow = plane_errors.hyperbolic(n, values)
    if regression is None:
        e1, e2 = axes[:, 0], axes[:, 1]
        largest, smallest = plane_errors.confidence_axes_rad(values, q1, q2)
    else:
        e1, e2, largest, smallest = plane_errors.regression_axes_rad(
            regression, normal, np.maximum(q1, q2)
        )
    dip_error, azimuth_error, rake = plane_errors.split_rad(
        e1, e2, dip_direction, dip, flat, largest, smallest
    )
    blank = np.where(known, 1.0, np.nan)
    return {
        "max_angular_error_deg": h_max * blank,
        "min_angular_error_deg": h_min * blank,
        "hyperbolic_overflow": overflow & known,
        "max_confidence95_deg": np.degrees(largest) * blank,
        "min_confidence95_deg": np.degrees(smallest) * blank,
        "error_rake_deg": np.degrees(rake) * blank,
        "dip_error_deg": np.degrees(dip_error) * blank,
        "dip_direction_error_deg": np.degrees(azimuth_error) * blank,
        "n_effective": effective * blank,
        "long_roughness": long & known,
    }
