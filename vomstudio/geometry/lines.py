"""A straight line through picked points, and how well its direction is known."""

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
from vomstudio.geometry.plane_limits import LARGEST, ROUNDINGS


@dataclass(frozen=True, eq=False)
class LineFit:
    """centroid (3,) and direction (3,), a unit vector that points down (axial), World; n points;
    length along the line and rms distance from it, m. confidence95_deg: half-angle of the joint
    95 % cone; None for two points, which leave no redundancy."""

    n: int
    centroid: FloatArray
    direction: FloatArray
    length: float
    rms: float
    confidence95_deg: float | None


def fit_line(points: npt.ArrayLike) -> LineFit:
    """The line of least squared distances through points (n, 3), World, m.

    Each point errs across the line in two directions, so the residual variance has 2 n - 4 degrees
    of freedom; with sxx the sum of squares along the line the direction is known to
    tan^2 t = 2 F(0.95; 2, 2 n - 4) s^2 / sxx, exact for equal independent errors in the limit of
    small angles. Raises GeometryError for fewer than 2 points, or all at one place.
    """
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    n = len(xyz)
    if n < 2:
        raise GeometryError(Finding("feature.too-few-points", count=2 - n, minimum=2))
    if not (np.abs(xyz) < LARGEST).all():
        raise GeometryError(Finding("points.not-finite"))
    local = xyz - xyz[0]
    mean = local.mean(axis=0)
    local = local - mean
    _, singular, axes = np.linalg.svd(local, full_matrices=False)
    rounding = ROUNDINGS * float(np.finfo(np.float64).eps) * float(np.abs(xyz).max())
    if singular[0] <= rounding * np.sqrt(n):
        raise GeometryError(Finding("points.coincident"))
    direction = axes[0] if axes[0, 2] <= 0.0 else -axes[0]
    along = local @ direction
    across = float((singular[1:] ** 2).sum())
    confidence = None
    if n > 2:
        free = 2.0 * n - 4.0
        # joint_quantile is 2 F / dof, and s^2 = across / free.
        tangent = float(joint_quantile(np.array([free]))[0]) * across / float(singular[0] ** 2)
        confidence = float(np.degrees(np.arctan(np.sqrt(tangent))))
    return LineFit(
        n=n,
        centroid=xyz[0] + mean,
        direction=direction,
        length=float(np.ptp(along)),
        rms=float(np.sqrt(across / n)),
        confidence95_deg=confidence,
    )


def path_length(points: npt.ArrayLike) -> float:
    """Length of the polyline through points (n, 3), in their unit."""
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    return float(np.linalg.norm(np.diff(xyz, axis=0), axis=1).sum())


def path_lengths(lines: Sequence[FloatArray]) -> FloatArray:
    """(m,) lengths of polylines, each (n, 3), in their unit."""
    counts = np.array([len(line) for line in lines], np.int64)
    if not counts.sum():
        return np.zeros(len(counts))
    steps = np.linalg.norm(np.diff(np.concatenate(lines), axis=0), axis=1)
    ends = np.cumsum(counts)
    # From the end of one line to the beginning of the next is no step.
    steps[ends[(ends > 0) & (ends < ends[-1])] - 1] = 0.0
    along = np.concatenate([[0.0], np.cumsum(steps), [0.0]])
    found = along[np.maximum(ends - 1, 0)] - along[np.maximum(ends - counts, 0)]
    return np.where(counts > 0, found, 0.0)


@dataclass(frozen=True, eq=False)
class Approach:
    """Where two polylines come nearest: place (3,) on the second one, distance between them there,
    along : the length of the first one up to there."""

    place: FloatArray
    distance: float
    along: float


def nearest_approach(line: npt.ArrayLike, other: npt.ArrayLike) -> Approach:
    """Of polylines through points (n, 3) and (m, 3), n and m at least 2, in their unit.

    The nearest points of every two of their segments, as in Ericson 2005, Real-Time Collision
    Detection, section 5.1.9.
    """
    base = np.asarray(line, np.float64)[0]
    p, q = (np.asarray(points, np.float64) - base for points in (line, other))
    steps = np.diff(q, axis=0)
    found: Approach | None = None
    done = 0.0
    for start, end in pairwise(p):
        step = end - start
        on_first, on_second = _nearest_of_segments(start, step, q[:-1], steps)
        places = q[:-1] + on_second[:, None] * steps
        gaps = np.linalg.norm(start + on_first[:, None] * step - places, axis=1)
        i, length = int(np.argmin(gaps)), float(np.linalg.norm(step))
        if found is None or gaps[i] < found.distance:
            found = Approach(places[i] + base, float(gaps[i]), done + float(on_first[i]) * length)
        done += length
    assert found is not None
    return found


def _nearest_of_segments(
    start: FloatArray, step: FloatArray, starts: FloatArray, steps: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Parts from 0 to 1 of one segment, and of each of (k, 3) others, at which they are nearest."""
    between = start - starts
    a, e = float(step @ step), np.einsum("ij,ij->i", steps, steps)
    b, c = steps @ step, between @ step
    f = np.einsum("ij,ij->i", steps, between)
    square = a * e - b * b
    skew = square > ROUNDINGS * np.finfo(float).eps * a * e
    s = np.where(skew, np.clip((b * f - c * e) / np.where(skew, square, 1.0), 0.0, 1.0), 0.0)
    t = np.clip((b * s + f) / np.where(e > 0, e, 1.0), 0.0, 1.0)
    s = np.clip((b * t - c) / a, 0.0, 1.0) if a > 0 else np.zeros_like(t)
    return s, t


def ring_area(points: npt.ArrayLike) -> float:
    """Area of the closed ring through points (n, 3), as seen from where it looks largest."""
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    local = xyz - xyz[0]
    return float(0.5 * np.linalg.norm(np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)))
