"""Joint fit of parallel planes, and test whether two traces belong to the same bed.

Traces of beds that were deposited parallel to each other have a common normal, but individual
positions. The normal is determined by the scatter of all points about the centroids of their traces
(the grouped planes of Quinn & Ehlmann 2019, Earth and Space Science 6, doi 10.1029/2018EA000416).
Short traces that do not determine a plane individually can determine one together.

The errors are those of least squares with separate noise for each trace, correlated along the trace
as for single planes (`geometry.plane_errors.quantiles`). The error of the distance of a trace along
the normal combines the error of its centroid and the effect of the tilt over the distance in the
plane. Two traces are compared by Student's t test of these distances.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.plane_errors import joint_quantile, quantiles

MIN_TRACE_POINTS = 3
"""Minimum number of points for the scatter of a trace to be used."""
SIGNIFICANCE = 0.05
MIN_RELATIVE_SPREAD = 1e-6
"""Relative spread across the traces below which all points lie on a line."""
MIN_DEGREES_OF_FREEDOM = 3.0
"""Minimum degrees of freedom for the noise of a trace to be compared with that of others."""
MIN_P_VALUE = 1e-15
"""Smallest p-value that is reported if several variances contribute."""
MIN_WIDTH_RATIO = 3.0
"""Minimum ratio of trace width to scatter about the common plane for an individual plane."""
MIN_BEND_RATIO = 0.05
"""Minimum ratio of width to length for a trace that is not straight."""


@dataclass(frozen=True)
class Bed:
    """One of several traces of parallel beds.

    Attributes
    ----------
    n : int
        Number of points.
    distance_m : float
        Signed distance from the centroid of all points along the common upward normal, m.
    error95_m : float or None
        95 % error of the position along the normal, m; None if unknown.
    rms_m : float
        RMS distance of the points from the plane of the trace, m.
    """

    id: str
    n: int
    distance_m: float
    error95_m: float | None
    rms_m: float


@dataclass(frozen=True)
class SamePlaneTest:
    """Result of the test whether two traces lie in the same plane of the common attitude.

    Attributes
    ----------
    distance_m : float
        Distance of the second trace from the first along the normal, m.
    error95_m : float
        95 % error of the distance, m.
    p : float
        p-value for the hypothesis that both traces belong to the same bed.
    """

    first: str
    second: str
    distance_m: float
    error95_m: float
    p: float


@dataclass(frozen=True)
class ParallelBeds:
    """Parallel planes fitted to several traces.

    Attributes
    ----------
    dip_direction_deg, dip_deg, strike_rhr_deg, undefined
        Attitude of the common plane, degrees.
    max_confidence95_deg, min_confidence95_deg : float or None
        Semi-axes of the joint 95 % region of the common normal, degrees.
    p_parallel : float or None
        p-value for the hypothesis that the traces are parallel; None if too few traces determine
        a tilt.
    beds : tuple of Bed
        Traces in upward order along the normal.
    same : tuple of SamePlaneTest
        Tests of pairs of traces; empty if the errors are unknown.
    """

    n: int
    dip_direction_deg: float
    dip_deg: float
    strike_rhr_deg: float
    undefined: bool
    normal: tuple[float, float, float]
    rms_m: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    p_parallel: float | None
    beds: tuple[Bed, ...]
    same: tuple[SamePlaneTest, ...]
    warnings: tuple[Finding, ...]

    @property
    def plane(self) -> Plane:
        """Plane of the common attitude."""
        return Plane(self.dip_direction_deg, self.dip_deg)

    @property
    def are_parallel(self) -> bool:
        """Whether the angles between the traces are explained by their scatter."""
        return self.p_parallel is None or self.p_parallel >= SIGNIFICANCE


@dataclass(frozen=True, eq=False)
class _TraceErrors:
    """Errors of G traces in the axes of the common plane.

    Attributes
    ----------
    tilt_covariances : (G, 2, 2) ndarray
        Contribution of each trace to the covariance of the tilts of the normal;
        `total_tilt_covariance` is their sum.
    centre_variances : (G,) ndarray
        Variance of the position of each trace along the normal.
    axes : (G, 2, 2) ndarray
        Principal axes of each trace in the plane, as columns.
    sums, height_moments, spread : (G, 2) ndarray
        Sums of squares along these axes, products with the normal, and variances of the products.
    is_judged : (G, 2) ndarray of bool
        Axes along which each trace determines a tilt.
    degrees_of_freedom : (G,) ndarray
        Degrees of freedom of the noise, disregarding correlation, by which the variances are
        inflated.
    independent_counts : (G,) ndarray
        Degrees of freedom that remain after allowing for correlation.
    tilt_dof : float or None
        Degrees of freedom of the tilt errors if these are widened for misfit; otherwise None.
    """

    tilt_covariances: FloatArray
    centre_variances: FloatArray
    axes: FloatArray
    sums: FloatArray
    height_moments: FloatArray
    spread: FloatArray
    is_judged: BoolArray
    degrees_of_freedom: FloatArray
    independent_counts: FloatArray
    tilt_dof: float | None = None

    @property
    def total_tilt_covariance(self) -> FloatArray:
        return np.asarray(self.tilt_covariances.sum(axis=0))


def parallel_beds(
    ids: Sequence[str],
    points: npt.ArrayLike,
    offsets: npt.ArrayLike,
    *,
    is_ordered: bool = True,
    pairs: Sequence[tuple[str, str]] = (),
) -> ParallelBeds:
    """Fit parallel planes to several traces.

    Parameters
    ----------
    ids : sequence of str
        Ids of the G traces.
    points : (n, 3) array_like
        Points of all traces in the World frame, m.
    offsets : (G + 1,) array_like of int
        Trace i is ``points[offsets[i]:offsets[i + 1]]``.
    is_ordered : bool
        True if the points are in order along the traces, so that neighbours may be correlated.
    pairs : sequence of (str, str)
        Ids of the pairs of traces to compare; by default, each trace is compared with the next one
        upward.

    Returns
    -------
    ParallelBeds

    Raises
    ------
    GeometryError
        If there are fewer than two traces, if a trace is empty, or if the traces do not determine
        a plane.
    KeyError
        If `pairs` contains an id that is not in `ids`.
    """
    points = np.asarray(points, np.float64).reshape(-1, 3)
    offsets = np.asarray(offsets, np.int64)
    counts = np.diff(offsets)
    if len(ids) < 2:
        raise GeometryError(Finding("beds.too-few-traces"))
    if (counts < 1).any():
        raise GeometryError(Finding("beds.empty-trace"))
    starts = offsets[:-1]
    centres = np.add.reduceat(points, starts, axis=0) / counts[:, None]
    centred_points = points - np.repeat(centres, counts, axis=0)
    values, axes = np.linalg.eigh(centred_points.T @ centred_points / len(centred_points))
    if not values[1] > MIN_RELATIVE_SPREAD * values[2]:
        raise GeometryError(Finding("beds.one-direction"))
    basis = axes[:, [2, 1, 0]]
    if basis[2, 2] < 0.0:
        basis = -basis
    local_points = centred_points @ basis
    traces, p_parallel = _widen_for_misfit(_trace_errors(local_points, counts, starts, is_ordered))
    normal = basis[:, 2]
    projections = (centres - points.mean(axis=0)) @ normal
    has_errors = bool(np.isfinite(traces.total_tilt_covariance).all())
    error = _distance_errors95(traces)
    beds = [
        Bed(
            ids[i],
            int(counts[i]),
            float(projections[i]),
            float(error[i]) if has_errors else None,
            float(np.sqrt((local_points[starts[i] : offsets[i + 1], 2] ** 2).mean())),
        )
        for i in np.argsort(projections, kind="stable")
    ]
    major_deg, minor_deg = _semi_axes(traces) if has_errors else (None, None)
    rows = {id_: i for i, id_ in enumerate(ids)}
    selected_pairs = list(pairs) or [(first.id, second.id) for first, second in pairwise(beds)]
    same_plane_tests = [
        _compare_pair(
            traces,
            (rows[first], rows[second]),
            (first, second),
            (centres[rows[second]] - centres[rows[first]]) @ basis,
        )
        for first, second in (selected_pairs if has_errors else [])
    ]
    plane = Plane.from_normal(normal)
    return ParallelBeds(
        n=len(points),
        dip_direction_deg=plane.dip_direction_deg,
        dip_deg=plane.dip_deg,
        strike_rhr_deg=plane.strike_rhr_deg,
        undefined=plane.undefined,
        normal=(float(normal[0]), float(normal[1]), float(normal[2])),
        rms_m=float(np.sqrt((local_points[:, 2] ** 2).mean())),
        max_confidence95_deg=major_deg,
        min_confidence95_deg=minor_deg,
        p_parallel=p_parallel,
        beds=tuple(beds),
        same=tuple(same_plane_tests),
        warnings=tuple(_warnings(p_parallel, has_errors)),
    )


def _trace_errors(
    centred_points: FloatArray, counts: IntArray, starts: IntArray, is_ordered: bool
) -> _TraceErrors:
    """Compute the errors of traces from points (n, 3) about their centroids, in plane axes."""
    n_traces = len(counts)
    sums, height_moments, axes = (
        np.zeros((n_traces, 2)),
        np.zeros((n_traces, 2)),
        np.zeros((n_traces, 2, 2)),
    )
    rotated_points = np.empty_like(centred_points)
    for i, (start, count) in enumerate(zip(starts, counts, strict=True)):
        trace_points = centred_points[start : start + count]
        sums[i], axes[i] = np.linalg.eigh(trace_points[:, :2].T @ trace_points[:, :2])
        rotated_points[start : start + count, :2] = trace_points[:, :2] @ axes[i]
        rotated_points[start : start + count, 2] = trace_points[:, 2]
        height_moments[i] = rotated_points[start : start + count, :2].T @ trace_points[:, 2]
    is_informative = _informative_axes(rotated_points, sums, height_moments, counts, starts)
    squares = np.zeros(n_traces)
    for i, (start, count) in enumerate(zip(starts, counts, strict=True)):
        # Residuals from a plane through the trace, or from a line if the trace is too narrow.
        trace_points = rotated_points[start : start + count]
        is_used = is_informative[i] & (sums[i] > 0.0)
        trace_points[:, 2] -= (
            trace_points[:, :2][:, is_used]
            @ (height_moments[i] / np.where(is_used, sums[i], 1.0))[is_used]
        )
        squares[i] = float(trace_points[:, 2] @ trace_points[:, 2])
    trace_dof = np.where(counts > MIN_TRACE_POINTS, counts - 1.0 - is_informative.sum(axis=1), 0.0)
    has_scatter = trace_dof > 0.0
    pooled_variance = (
        float(squares[has_scatter].sum() / trace_dof[has_scatter].sum())
        if has_scatter.any()
        else np.nan
    )
    noise = np.where(has_scatter, squares / np.maximum(trace_dof, 1.0), pooled_variance)
    inflation, effective_counts = np.ones((n_traces, 2)), counts.astype(np.float64)
    if has_scatter.any():
        rows = np.flatnonzero(has_scatter)
        index = np.concatenate([np.arange(starts[i], starts[i] + counts[i]) for i in rows])
        first_rows = np.concatenate([[0], np.cumsum(counts[rows])[:-1]])
        # The eigenvector of the larger axis of a trace is the second one returned by eigh.
        u, v, r = rotated_points[index, 1], rotated_points[index, 0], rotated_points[index, 2]
        q1, q2, n_eff, _ = quantiles(u, v, r, first_rows, counts[rows], trace_dof[rows], is_ordered)
        white_quantiles = joint_quantile(trace_dof[rows])
        inflation[rows] = np.maximum(np.stack([q2, q1], axis=1) / white_quantiles[:, None], 1.0)
        effective_counts[rows] = n_eff
    # The mean is affected most by slow variations along a trace.
    centre_variances = noise * inflation.max(axis=1) / counts
    spread = noise[:, None] * inflation * sums
    inverse = np.linalg.inv(np.einsum("gik,gk,gjk->ij", axes, sums, axes))
    tilt_covariances = np.einsum("ij,gjk,gk,glk,lm->gim", inverse, axes, spread, axes, inverse)
    # The noise of a trace with too few points is pooled from all other traces.
    degrees_of_freedom = np.where(has_scatter, trace_dof, trace_dof.sum())
    independent_counts = np.maximum(effective_counts - (counts - trace_dof), 1.0)
    return _TraceErrors(
        tilt_covariances,
        centre_variances,
        axes,
        sums,
        height_moments,
        spread,
        is_informative & has_scatter[:, None],
        degrees_of_freedom,
        independent_counts,
    )


def _informative_axes(
    rotated_points: FloatArray,
    sums: FloatArray,
    height_moments: FloatArray,
    counts: IntArray,
    starts: IntArray,
) -> BoolArray:
    """Select the axes (G, 2) along which each trace determines the tilt of its plane.

    The narrow axis of a straight trace is ignored if its width is at most three times its scatter:
    such a trace follows the face that it crosses, so its width gives the attitude of the face.

    `rotated_points` (n, 3) are coordinates along the narrow and the long axis of each trace, and
    along the normal.
    """
    slope = height_moments[:, 1] / np.where(sums[:, 1] > 0.0, sums[:, 1], 1.0)
    residuals = rotated_points[:, 2] - np.repeat(slope, counts) * rotated_points[:, 1]
    scatter = np.add.reduceat(residuals**2, starts)
    is_wide = (sums[:, 0] > MIN_WIDTH_RATIO**2 * scatter) | (
        sums[:, 0] > MIN_BEND_RATIO**2 * sums[:, 1]
    )
    return np.stack([is_wide, sums[:, 1] > 0.0], axis=1)


def _distance_errors95(traces: _TraceErrors) -> list[float]:
    """Return the 95 % errors of the positions of the traces along the normal, m."""
    ones = np.ones(1)
    return [
        _weighted_t95(ones, np.array([dof])) * float(np.sqrt(variance))
        for variance, dof in zip(traces.centre_variances, traces.degrees_of_freedom, strict=True)
    ]


def _semi_axes(traces: _TraceErrors) -> tuple[float, float]:
    tilt_dof = traces.tilt_dof or _pooled_tilt_dof(traces)
    # `joint_quantile` is 2 F(2, dof) / dof.
    limit = float(joint_quantile(np.array([tilt_dof]))[0]) * tilt_dof
    minor_rad, major_rad = np.sqrt(
        np.maximum(np.linalg.eigvalsh(traces.total_tilt_covariance), 0.0) * limit
    )
    return float(np.degrees(np.arctan(major_rad))), float(np.degrees(np.arctan(minor_rad)))


def _pooled_tilt_dof(traces: _TraceErrors) -> float:
    """Return the degrees of freedom of the tilt covariance, pooled over the traces.

    See Krishnamoorthy & Yu 2004, Statistics & Probability Letters 66, 161.
    """
    total_covariance = traces.total_tilt_covariance
    if not np.linalg.det(total_covariance) > 0.0:
        return float(traces.degrees_of_freedom.sum())
    relative_covariances = traces.tilt_covariances @ np.linalg.inv(total_covariance)
    squares = (
        np.einsum("gij,gji->g", relative_covariances, relative_covariances)
        + np.einsum("gii->g", relative_covariances) ** 2
    )
    is_used = squares > 0.0
    return float(6.0 / (squares[is_used] / traces.degrees_of_freedom[is_used]).sum())


def _compare_pair(
    traces: _TraceErrors, rows: tuple[int, int], ids: tuple[str, str], offset: FloatArray
) -> SamePlaneTest:
    """Test whether two traces lie in the same plane.

    `offset` (3,) is the vector from the first to the second trace, in the plane axes.
    """
    tilt_variances = np.einsum("i,gij,j->g", offset[:2], traces.tilt_covariances, offset[:2])
    variance_parts, dof = tilt_variances, traces.degrees_of_freedom
    if traces.tilt_dof is not None:
        variance_parts, dof = (
            np.append(0.0 * tilt_variances, tilt_variances.sum()),
            np.append(dof, traces.tilt_dof),
        )
    variance_parts[list(rows)] += traces.centre_variances[list(rows)]
    variance, distance = float(variance_parts.sum()), float(offset[2])
    if not variance > 0.0:
        return SamePlaneTest(*ids, distance, 0.0, 0.0 if distance else 1.0)
    fractions, degrees_of_freedom = _pool_variances(variance_parts / variance, dof)
    t = abs(distance) / np.sqrt(variance)
    return SamePlaneTest(
        *ids,
        distance,
        _weighted_t95(fractions, degrees_of_freedom) * float(np.sqrt(variance)),
        _two_sided_p(t, fractions, degrees_of_freedom),
    )


def _pool_variances(
    fractions: FloatArray, degrees_of_freedom: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Pool the well-determined shares of a variance, with their degrees of freedom.

    See Satterthwaite 1946, Biometrics Bulletin 2, 110.
    """
    is_used = fractions > 0.0
    is_known = is_used & (degrees_of_freedom >= MIN_DEGREES_OF_FREEDOM)
    is_remaining = is_used & ~is_known
    if not is_known.any():
        return fractions[is_remaining], degrees_of_freedom[is_remaining]
    known_share = float(fractions[is_known].sum())
    pooled_dof = known_share**2 / float(
        (fractions[is_known] ** 2 / degrees_of_freedom[is_known]).sum()
    )
    return np.append(fractions[is_remaining], known_share), np.append(
        degrees_of_freedom[is_remaining], pooled_dof
    )


def _weighted_t95(fractions: FloatArray, degrees_of_freedom: FloatArray) -> float:
    """Return the mean of Student's quantiles, weighted by the shares of the variance.

    See Cochran & Cox 1957, Experimental Designs, section 4.14. Averaged degrees of freedom would be
    too high if a share has a single degree of freedom and is small by chance.
    """
    from scipy.special import stdtrit

    return float(fractions @ stdtrit(degrees_of_freedom, 1.0 - SIGNIFICANCE / 2.0))


def _two_sided_p(t: float, fractions: FloatArray, degrees_of_freedom: FloatArray) -> float:
    """Return the two-sided p-value of t from a weighted mean of Student's t quantiles."""
    from scipy.optimize import brentq
    from scipy.special import stdtr, stdtrit

    if len(degrees_of_freedom) == 1:
        return 2.0 * float(stdtr(degrees_of_freedom[0], -t))
    if t <= 0.0:
        return 1.0
    if not float(fractions @ -stdtrit(degrees_of_freedom, MIN_P_VALUE)) > t:
        return 2.0 * MIN_P_VALUE
    # Solve for the logarithm, because p may be very small.
    low, high = np.log(MIN_P_VALUE), np.log(0.5)
    return 2.0 * float(
        np.exp(brentq(lambda x: fractions @ -stdtrit(degrees_of_freedom, np.exp(x)) - t, low, high))
    )


def _widen_for_misfit(traces: _TraceErrors) -> tuple[_TraceErrors, float | None]:
    """Widen the tilt error by the misfit of traces that are not exactly parallel.

    The error is scaled by Birge's ratio (Birge 1932, Physical Review 40, 207) if the misfit is
    significant. The p-value for the hypothesis that the traces are parallel is also returned; it is
    None if too few tilts are known. Each trace is compared with the best common plane, weighted by
    its own noise: one outlier tilts the common plane without showing that the others are rotated.
    The uncertainty of the weights is taken into account (Johansen 1980, Biometrika 67, 85; here
    with one variance per trace, shared by its axes).
    """
    from scipy.special import fdtrc

    is_judged = traces.is_judged & (traces.spread > 0.0)
    # Noise estimates with one or two degrees of freedom are so often too small by chance that their
    # trace would outweigh all others.
    is_reliable = is_judged & (traces.independent_counts >= MIN_DEGREES_OF_FREEDOM)[:, None]
    is_judged = is_reliable if is_reliable.sum() > 2 else is_judged
    judged_count = int(is_judged.sum())
    if judged_count <= 2:
        return traces, None
    weight = np.where(is_judged, traces.sums**2 / np.where(is_judged, traces.spread, 1.0), 0.0)
    slopes = np.where(is_judged, traces.height_moments / np.where(is_judged, traces.sums, 1.0), 0.0)
    weights = np.einsum("gik,gk,gjk->gij", traces.axes, weight, traces.axes)
    total_weights = weights.sum(axis=0)
    if not np.linalg.det(total_weights) > (MIN_RELATIVE_SPREAD * np.trace(total_weights)) ** 2:
        return traces, None
    common_slope = np.linalg.solve(
        total_weights, np.einsum("gik,gk,gk->i", traces.axes, weight, slopes)
    )
    residuals = slopes - np.einsum("gik,i->gk", traces.axes, common_slope)
    statistic = float((weight * residuals**2).sum())
    fractions = np.linalg.solve(total_weights, weights)
    rank = is_judged.sum(axis=1)
    residual_traces = rank - np.einsum("gii->g", fractions)
    squared_residual_traces = (
        rank - 2.0 * np.einsum("gii->g", fractions) + np.einsum("gij,gji->g", fractions, fractions)
    )
    numerator_dof = judged_count - 2.0
    has_slopes = rank > 0
    a, b = (
        (item[has_slopes] / traces.independent_counts[has_slopes]).sum()
        for item in (squared_residual_traces, residual_traces**2)
    )
    dof = numerator_dof * (numerator_dof + 2.0) / float(2.0 * a + b)
    expected_misfit = numerator_dof + 2.0 * a - 2.0 * (2.0 * a + b) / (numerator_dof + 2.0)
    p = float(fdtrc(numerator_dof, dof, statistic / expected_misfit))
    if p >= SIGNIFICANCE:
        return traces, p
    widened_errors = replace(
        traces,
        tilt_covariances=traces.tilt_covariances * max(statistic / expected_misfit, 1.0),
        tilt_dof=min(numerator_dof, dof),
    )
    return widened_errors, p


def _warnings(p_parallel: float | None, has_errors: bool) -> list[Finding]:
    warnings: list[Finding] = []
    if not has_errors:
        warnings.append(Finding("beds.no-errors"))
    if p_parallel is not None and p_parallel < SIGNIFICANCE:
        warnings.append(Finding("beds.not-parallel", p=p_parallel))
    return warnings
