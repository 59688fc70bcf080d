"""Fits of straight lines with the errors of their directions, and polyline geometry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.plane_errors import joint_quantile
from vomstudio.geometry.plane_limits import MAX_COORDINATE, MIN_EXTENT_ROUNDINGS


@dataclass(frozen=True, eq=False)
class FittedLine:
    """Line fitted in the World frame.

    Attributes
    ----------
    n : int
        Number of points.
    centroid : (3,) ndarray
        Centroid, m.
    direction : (3,) ndarray
        Unit vector that points down (axial).
    length, rms : float
        Length along the line and RMS distance from it, m.
    confidence95_deg : float or None
        Half-angle of the joint 95 % cone, degrees, or None for two points.
    """

    n: int
    centroid: FloatArray
    direction: FloatArray
    length: float
    rms: float
    confidence95_deg: float | None


def fit_line(points: npt.ArrayLike) -> FittedLine:
    """Fit a least-squares line to points (n, 3) in the World frame, m.

    Each point has errors in two directions across the line, so the residual variance has 2 n - 4
    degrees of freedom. With the sum of squares sxx along the line, the error of the direction is
    tan^2 t = 2 F(0.95; 2, 2 n - 4) s^2 / sxx, exact for equal independent errors in the limit of
    small angles.

    Raises
    ------
    GeometryError
        If there are fewer than 2 points, if all coincide, or if a coordinate is not finite.
    """
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    n = len(xyz)
    if n < 2:
        raise GeometryError(Finding("feature.too-few-points", count=2 - n, minimum=2))
    if not (np.abs(xyz) < MAX_COORDINATE).all():
        raise GeometryError(Finding("points.not-finite"))
    local_points = xyz - xyz[0]
    mean = local_points.mean(axis=0)
    local_points = local_points - mean
    _, singular_values, axes = np.linalg.svd(local_points, full_matrices=False)
    rounding = MIN_EXTENT_ROUNDINGS * float(np.finfo(np.float64).eps) * float(np.abs(xyz).max())
    if singular_values[0] <= rounding * np.sqrt(n):
        raise GeometryError(Finding("points.coincident"))
    direction = axes[0] if axes[0, 2] <= 0.0 else -axes[0]
    projections = local_points @ direction
    residual_squares = float((singular_values[1:] ** 2).sum())
    confidence = None
    if n > 2:
        dof = 2.0 * n - 4.0
        # joint_quantile is 2 F / dof, and s^2 = across / free.
        squared_tangent = (
            float(joint_quantile(np.array([dof]))[0])
            * residual_squares
            / float(singular_values[0] ** 2)
        )
        confidence = float(np.degrees(np.arctan(np.sqrt(squared_tangent))))
    return FittedLine(
        n=n,
        centroid=xyz[0] + mean,
        direction=direction,
        length=float(np.ptp(projections)),
        rms=float(np.sqrt(residual_squares / n)),
        confidence95_deg=confidence,
    )


def path_length(points: npt.ArrayLike) -> float:
    """Return the length of a polyline.

    Parameters
    ----------
    points : (n, 3) array_like

    Returns
    -------
    float
        In the unit of the points.
    """
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    return float(np.linalg.norm(np.diff(xyz, axis=0), axis=1).sum())


def path_lengths(lines: Sequence[FloatArray]) -> FloatArray:
    """Return the lengths of polylines.

    Parameters
    ----------
    lines : sequence of ndarray
        Vertices (n, 3) of each polyline.

    Returns
    -------
    (m,) ndarray
        In the unit of the points.
    """
    counts = np.array([len(line) for line in lines], np.int64)
    if not counts.sum():
        return np.zeros(len(counts))
    steps = np.linalg.norm(np.diff(np.concatenate(lines), axis=0), axis=1)
    ends = np.cumsum(counts)
    # Exclude steps from the end of one line to the start of the next.
    steps[ends[(ends > 0) & (ends < ends[-1])] - 1] = 0.0
    distances = np.concatenate([[0.0], np.cumsum(steps), [0.0]])
    lengths = distances[np.maximum(ends - 1, 0)] - distances[np.maximum(ends - counts, 0)]
    return np.where(counts > 0, lengths, 0.0)


@dataclass(frozen=True, eq=False)
class NearestApproach:
    """Nearest approach of two polylines.

    Attributes
    ----------
    midpoint : (3,) ndarray
        Nearest point on the second polyline.
    distance : float
        Distance between the polylines.
    distance_along_line : float
        Length of the first polyline up to its nearest point.
    """

    midpoint: FloatArray
    distance: float
    distance_along_line: float


def nearest_approach(line: npt.ArrayLike, other_line: npt.ArrayLike) -> NearestApproach:
    """Find the nearest approach of two polylines.

    The nearest points of all pairs of segments are computed (Ericson 2005, Real-Time Collision
    Detection, section 5.1.9).

    Parameters
    ----------
    line : (n, 3) array_like
        At least 2 vertices.
    other_line : (m, 3) array_like
        At least 2 vertices, in the same unit.

    Returns
    -------
    NearestApproach
    """
    base = np.asarray(line, np.float64)[0]
    p, q = (np.asarray(points, np.float64) - base for points in (line, other_line))
    steps = np.diff(q, axis=0)
    nearest: NearestApproach | None = None
    preceding_length = 0.0
    for start, end in pairwise(p):
        step = end - start
        first_fractions, second_fractions = _nearest_segment_fractions(start, step, q[:-1], steps)
        positions = q[:-1] + second_fractions[:, None] * steps
        gaps = np.linalg.norm(start + first_fractions[:, None] * step - positions, axis=1)
        i, length = int(np.argmin(gaps)), float(np.linalg.norm(step))
        if nearest is None or gaps[i] < nearest.distance:
            nearest = NearestApproach(
                positions[i] + base,
                float(gaps[i]),
                preceding_length + float(first_fractions[i]) * length,
            )
        preceding_length += length
    assert nearest is not None
    return nearest


def _nearest_segment_fractions(
    start: FloatArray, step: FloatArray, starts: FloatArray, steps: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the nearest points of one segment and each of k others.

    They are given as fractions 0 to 1 along the segments. `starts` and `steps` are (k, 3).
    """
    start_offsets = start - starts
    a, e = float(step @ step), np.einsum("ij,ij->i", steps, steps)
    b, c = steps @ step, start_offsets @ step
    f = np.einsum("ij,ij->i", steps, start_offsets)
    square = a * e - b * b
    is_nonparallel = square > MIN_EXTENT_ROUNDINGS * np.finfo(float).eps * a * e
    s = np.where(
        is_nonparallel,
        np.clip((b * f - c * e) / np.where(is_nonparallel, square, 1.0), 0.0, 1.0),
        0.0,
    )
    t = np.clip((b * s + f) / np.where(e > 0, e, 1.0), 0.0, 1.0)
    s = np.clip((b * t - c) / a, 0.0, 1.0) if a > 0 else np.zeros_like(t)
    return s, t


def ring_area(points: npt.ArrayLike) -> float:
    """Return the area of a closed ring, projected along its normal.

    Parameters
    ----------
    points : (n, 3) array_like

    Returns
    -------
    float
        Area in squared units of the points.
    """
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    local_points = xyz - xyz[0]
    return float(
        0.5 * np.linalg.norm(np.cross(local_points, np.roll(local_points, -1, axis=0)).sum(axis=0))
    )
