"""Which planes and intersections let a rock slope fail: kinematic analysis.

Kinematics asks only whether a block could move: whether the surface or line on which it would slide
comes out of the face (daylights) and is steeper than the friction angle. It knows no cohesion,
water or size.

- Planar sliding, wedges: Markland's test (Hoek & Bray 1981; Wyllie & Mah 2004, Rock Slope
  Engineering, ch. 2 and 6).
- Flexural toppling: Goodman & Bray 1976; Goodman 1980, Introduction to Rock Mechanics: layers slip
  on one another where their poles lie beyond the plane that dips like the face, by the friction
  angle less.
- Direct toppling: Hudson & Harrison 1997, Engineering Rock Mechanics, ch. 18.2: intersections that
  dip into the face, within the lateral limits, steeper than 90 degrees less the dip of the face.

Lateral limits of planes are small circles about the strike of the face ("curved", the usual ones of
programs for nets), or limits of their dip direction ("straight"); those of direct toppling are of
the trend. All limits are part of the zones.

The frame here is that of the face: x out of it (its dip direction), y along its strike, to the
left of x, z up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.geology.orientation import ANGLE_TOLERANCE_DEG, Plane, sin_cos_deg
from vomstudio.geology.slope_options import SlopeOptions

_EPS = 1e-10
"""Sine by which a limit may be missed through rounding."""
_PARALLEL = math.radians(ANGLE_TOLERANCE_DEG)
_AT_A_TIME = 100_000
"""Pairs of a step, whose arrays stay in the cache."""
_FACES_AT_A_TIME = 32


@dataclass(frozen=True)
class SlopeFace:
    """A face and the options of its analysis.

    Raises
    ------
    UsageError
        For a face without a dip direction.
    """

    plane: Plane
    options: SlopeOptions

    def __post_init__(self) -> None:
        if self.plane.undefined:
            raise UsageError(Finding("slope.horizontal-face"), field="--face")

    def axes(self) -> FloatArray:
        """(3, 3) rows: out of the face, along its strike, up; World."""
        sin_a, cos_a = sin_cos_deg(self.plane.dip_direction_deg)
        return np.array([[sin_a, cos_a, 0.0], [-cos_a, sin_a, 0.0], [0.0, 0.0, 1.0]])

    @property
    def slides(self) -> bool:
        """Whether the face is steeper than the friction angle: else nothing slides or bends."""
        return self.plane.dip_deg > self.options.friction_deg


class Zones(NamedTuple):
    """Which of n are in the critical zone, and which in the secondary one: planes outside the
    lateral limits; wedges that would slide on one of their planes; oblique toppling."""

    critical: BoolArray
    secondary: BoolArray


class Margins(NamedTuple):
    """By how much, as a sine, the conditions of a zone are met, and the lateral limits: negative
    outside. They are smooth, so that a zone's edge is where they are 0."""

    zone: FloatArray
    lateral: FloatArray

    def zones(self) -> Zones:
        """Inside both, and inside the zone but outside the lateral limits."""
        inside, within = self.zone >= -_EPS, self.lateral >= -_EPS
        return Zones(inside & within, inside & ~within)


def in_face_frame(face: SlopeFace, normals: npt.ArrayLike) -> FloatArray:
    """Upward unit normals (..., 3), World, in the frame of the face."""
    return np.asarray(np.asarray(normals, np.float64) @ face.axes().T)


def planar_margins(face: SlopeFace, normals: FloatArray) -> Margins:
    """Of `planar_sliding`."""
    x, y, z = np.moveaxis(normals, -1, 0)
    flat = np.hypot(x, y)
    sin_f, cos_f = _sin_cos(face.options.friction_deg)
    sin_d, cos_d = _sin_cos(face.plane.dip_deg)
    level = flat <= _PARALLEL
    # The line of dip (x z, y z, -flat^2) / flat, against the normal of the face.
    daylight = sin_d * x * z / np.where(level, 1.0, flat) - cos_d * flat
    slide = np.where(level, -1.0, flat * cos_f - z * sin_f)
    return Margins(np.minimum(daylight, slide), _lateral(face, x, y))


def planar_sliding(face: SlopeFace, normals: FloatArray) -> Zones:
    """Planes on which a block slides, of upward normals (..., 3) in the frame of the face. A
    horizontal plane, which has no dip direction, never slides."""
    return planar_margins(face, normals).zones()


def flexural_margins(face: SlopeFace, normals: FloatArray) -> Margins:
    """Of `flexural_toppling`."""
    x, y, z = np.moveaxis(normals, -1, 0)
    # Of the pole, which points down: into the face, where the plane dips away from it.
    out = np.where(z < _PARALLEL, np.abs(x), -x)
    limit = face.plane.dip_deg - face.options.friction_deg
    if limit <= ANGLE_TOLERANCE_DEG:
        return Margins(np.full(x.shape, -1.0), _lateral(face, out, y))
    sin_l, cos_l = _sin_cos(limit)
    return Margins(sin_l * out - cos_l * z, _lateral(face, out, y))


def flexural_toppling(face: SlopeFace, normals: FloatArray) -> Zones:
    """Planes that slip on each other and topple, of upward normals (..., 3) in the frame of the
    face. Both ends of the pole of a vertical plane count."""
    return flexural_margins(face, normals).zones()


def wedge_margins(face: SlopeFace, lines: FloatArray) -> Margins:
    """Of `wedge_sliding`, which has no lateral limits."""
    x, _, z = np.moveaxis(lines, -1, 0)
    sin_f, _ = _sin_cos(face.options.friction_deg)
    sin_d, cos_d = _sin_cos(face.plane.dip_deg)
    daylight = np.where(z < -_PARALLEL, sin_d * x + cos_d * z, -1.0)
    return Margins(np.minimum(daylight, -z - sin_f), np.ones(x.shape))


def wedge_sliding(face: SlopeFace, lines: FloatArray) -> Zones:
    """Intersections along which a wedge slides, of downward unit vectors (..., 3) in the frame of
    the face; the secondary zone is that between the great circle of the friction angle and its
    cone, in which a wedge can slide on one of its planes."""
    x, _, z = np.moveaxis(lines, -1, 0)
    sin_f, cos_f = _sin_cos(face.options.friction_deg)
    sin_d, cos_d = _sin_cos(face.plane.dip_deg)
    daylights = (sin_d * x + cos_d * z >= -_EPS) & (z < -_PARALLEL)
    steep = -z >= sin_f - _EPS
    beyond = sin_f * x + cos_f * z <= _EPS
    return Zones(steep & daylights, ~steep & daylights & beyond)


def direct_margins(face: SlopeFace, lines: FloatArray) -> Margins:
    """Of the critical zone of `direct_toppling`."""
    x, y, z = np.moveaxis(lines, -1, 0)
    _, cos_d = _sin_cos(face.plane.dip_deg)
    sin_l, cos_l = _sin_cos(face.options.lateral_deg)
    into = np.where(-z < _PARALLEL, np.abs(x), -x)
    return Margins(-z - cos_d, into * sin_l - np.abs(y) * cos_l)


def direct_toppling(face: SlopeFace, lines: FloatArray) -> Zones:
    """Intersections about which blocks topple, of downward unit vectors (..., 3) in the frame of
    the face; the secondary zone is that of oblique toppling: within the friction angle of vertical,
    into the face, outside the lateral limits. Of downward poles the same zones tell which planes
    are bases of such blocks."""
    x, _, z = np.moveaxis(lines, -1, 0)
    _, cos_f = _sin_cos(face.options.friction_deg)
    margins = direct_margins(face, lines)
    into = np.where(-z < _PARALLEL, np.abs(x), -x)
    oblique = (-z >= cos_f - _EPS) & (into >= -_EPS) & (margins.lateral < -_EPS)
    return Zones(margins.zones().critical, oblique)


class PairCounts(NamedTuple):
    """Intersections of all pairs: how many, and how many of them are in the zones; one number for
    each of k drawings of the planes. parallel : pairs that do not meet"""

    of: IntArray
    parallel: IntArray
    wedge: IntArray
    wedge_secondary: IntArray
    toppling: IntArray
    oblique: IntArray


def count_pairs(
    face: SlopeFace,
    normals: FloatArray,
    progress: Progress | None = None,
    sets: IntArray | None = None,
) -> PairCounts:
    """Count the intersections in each zone, of upward normals (k, n, 3) in the frame of the face.

    `intersections` defines `sets`; the intersections that were computed are the steps of
    `progress`.
    """
    progress = progress or Silent()
    counts = np.zeros((6, len(normals)), np.int64)
    done = 0
    for lines, sound, _ in intersections(normals, sets):
        wedge, topple = wedge_sliding(face, lines), direct_toppling(face, lines)
        flags = (sound, ~sound, *(zone & sound for zone in (*wedge, *topple)))
        for row, flag in enumerate(flags):
            counts[row] += flag.sum(axis=1)
        done += sound.size
        progress.step(done)
    return PairCounts(*counts)


def critical_lines(faces: Sequence[SlopeFace], lines: FloatArray) -> IntArray:
    """(faces, 2): how many of downward unit vectors (m, 3), World, are critical at each face, by
    `wedge_sliding` and by `direct_toppling`. The faces have the same friction and limits; all are
    looked at together, as products of matrices, for there may be thousands of them."""
    counts = np.zeros((len(faces), 2), np.int64)
    sin_f, _ = _sin_cos(faces[0].options.friction_deg)
    sin_l, cos_l = _sin_cos(faces[0].options.lateral_deg)
    steepness = -lines[:, 2]
    wedges = lines[(steepness >= sin_f - _EPS) & (steepness > _PARALLEL)]
    for start in range(0, len(faces), _FACES_AT_A_TIME):
        few = faces[start : start + _FACES_AT_A_TIME]
        part = slice(start, start + len(few))
        out, along, _ = np.moveaxis(np.stack([face.axes() for face in few]), 1, 0)
        sin_d, cos_d = sin_cos_deg(np.array([face.plane.dip_deg for face in few]))
        normals = np.column_stack([out[:, :2] * sin_d[:, None], cos_d])
        counts[part, 0] = (wedges @ normals.T >= -_EPS).sum(axis=0)
        tops = lines[steepness >= cos_d.min() - _EPS]
        into = -(tops @ out.T)
        level = -tops[:, 2] < _PARALLEL
        into[level] = np.abs(into[level])
        inside = -tops[:, 2:] - cos_d >= -_EPS
        within = into * sin_l - np.abs(tops @ along.T) * cos_l >= -_EPS
        counts[part, 1] = (inside & within).sum(axis=0)
    return counts


class PairMembers(NamedTuple):
    """In how many critical intersections each of n planes takes part."""

    wedge: IntArray
    toppling: IntArray


def pair_members(face: SlopeFace, normals: FloatArray, sets: IntArray | None = None) -> PairMembers:
    """Count the critical intersections of each plane, of upward normals (n, 3) in the frame of the
    face. `intersections` defines `sets`."""
    n = len(normals)
    counts = np.zeros((2, n), np.int64)
    for lines, sound, pairs in intersections(normals[None], sets):
        zones = (wedge_sliding(face, lines), direct_toppling(face, lines))
        for row, zone in enumerate(zones):
            counts[row] += np.bincount(pairs[:, (zone.critical & sound)[0]].ravel(), minlength=n)
    return PairMembers(*counts)


def pairs_of_sets(n: int, sets: IntArray | None) -> int:
    """Return the number of pairs of n planes that can meet: those not of one set."""
    total = n * (n - 1) // 2
    if sets is None:
        return total
    sizes = np.bincount(sets[sets >= 0])
    return total - int(np.sum(sizes * (sizes - 1) // 2))


def intersections(
    normals: FloatArray, sets: IntArray | None = None
) -> Iterator[tuple[FloatArray, BoolArray, IntArray]]:
    """Compute the intersections of all pairs of planes, in portions.

    Two planes of one set do not form a wedge: where they meet follows from their scatter about the
    mean of the set.

    Parameters
    ----------
    normals : (k, n, 3) float64
        Unit normals of k drawings of n planes.
    sets : (n,) int64, optional
        Set of each plane, negative for none. Pairs of one set are left out.

    Yields
    ------
    lines : (k, m, 3) float64
        Downward unit vectors.
    is_line : (k, m) bool
        False for parallel planes.
    planes : (2, m) int64
        Rows of the two planes.
    """
    n = normals.shape[1]
    first = 0
    while first < n - 1:
        # Several first planes together where few follow them.
        last = first + 1
        many = len(normals) * (n - 1 - first)
        while last < n - 1 and many < _AT_A_TIME:
            many += len(normals) * (n - 1 - last)
            last += 1
        a = np.concatenate([np.full(n - 1 - i, i) for i in range(first, last)])
        b = np.concatenate([np.arange(i + 1, n) for i in range(first, last)])
        first = last
        if sets is not None:
            different = (sets[a] != sets[b]) | (sets[a] < 0)
            a, b = a[different], b[different]
        x1, y1, z1 = np.moveaxis(normals[:, a], -1, 0)
        x2, y2, z2 = np.moveaxis(normals[:, b], -1, 0)
        x, y, z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
        length = np.sqrt(x * x + y * y + z * z)
        sound = length > _PARALLEL
        scale = np.where(z > 0, -1.0, 1.0) / np.where(sound, length, 1.0)
        yield np.stack([x * scale, y * scale, z * scale], axis=-1), sound, np.stack([a, b])


def _lateral(face: SlopeFace, out: FloatArray, along: FloatArray) -> FloatArray:
    """Margin of the lateral limits, of a unit vector's parts out of (or into) the face and along
    it."""
    sin_l, cos_l = _sin_cos(face.options.lateral_deg)
    if face.options.limits == "curved":
        return np.asarray(sin_l - np.abs(along))
    return np.asarray(out * sin_l - np.abs(along) * cos_l)


def _sin_cos(angle_deg: float) -> tuple[float, float]:
    sine, cosine = sin_cos_deg(angle_deg)
    return float(sine), float(cosine)
