"""Kinematic analysis of rock slopes: planes and lines along which a slope can fail.

A kinematic analysis tests only whether a block can move: whether the surface or line of sliding
daylights in the face and is steeper than the friction angle. It does not consider cohesion, water
or block size.

- Planar sliding, wedges: Markland's test (Hoek & Bray 1981; Wyllie & Mah 2004, Rock Slope
  Engineering, ch. 2 and 6).
- Flexural toppling: Goodman & Bray 1976; Goodman 1980, Introduction to Rock Mechanics: layers slip
  on one another if their poles lie beyond the plane that dips in the direction of the face at the
  dip of the face minus the friction angle.
- Direct toppling: Hudson & Harrison 1997, Engineering Rock Mechanics, ch. 18.2: intersections that
  dip into the face within the lateral limits and are steeper than 90 degrees minus the dip of the
  face.

The lateral limits of planes are small circles about the strike of the face ("curved", usual in
stereonet programs) or limits of the dip direction ("straight"). The lateral limits of direct
toppling apply to the trend. All limits belong to the zones.

The frame used here is that of the face: x points out of the face (along its dip direction), y along
its strike to the left of x, and z up.
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
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.geology.orientation import ANGLE_TOLERANCE_DEG, Plane, sin_cos_deg
from vomstudio.geology.slope_options import SlopeOptions

MAX_ROUNDING_SINE = 1e-10
"""Tolerance of the limits for rounding errors, as a sine."""
MIN_ANGLE_RAD = math.radians(ANGLE_TOLERANCE_DEG)
PAIRS_PER_BLOCK = 100_000
"""Number of pairs processed in one step, so that the arrays fit in the cache."""
FACES_PER_BLOCK = 32


@dataclass(frozen=True)
class SlopeFace:
    """Slope face with the options of its analysis.

    Raises
    ------
    UsageError
        If the face has no dip direction.
    """

    plane: Plane
    options: SlopeOptions

    def __post_init__(self) -> None:
        if self.plane.undefined:
            raise UsageError(Finding("slope.horizontal-face"), field="--face")

    def axes(self) -> FloatArray:
        """Return the axes (3, 3) of the face as rows, in the World frame.

        They point out of the face, along its strike, and up.
        """
        sin_a, cos_a = sin_cos_deg(self.plane.dip_direction_deg)
        return np.array([[sin_a, cos_a, 0.0], [-cos_a, sin_a, 0.0], [0.0, 0.0, 1.0]])

    @property
    def can_slide(self) -> bool:
        """Whether the face is steeper than the friction angle.

        Otherwise no block slides or topples by flexure.
        """
        return self.plane.dip_deg > self.options.friction_deg


class Zones(NamedTuple):
    """Membership of n planes or lines in the critical and the secondary zone.

    The secondary zone contains planes outside the lateral limits, wedges that slide on one of their
    two planes, or oblique toppling.
    """

    critical: BoolArray
    secondary: BoolArray


class Margins(NamedTuple):
    """Margins to the conditions and lateral limits of a zone, as sines; negative outside.

    The margins are smooth, so their zero contour is the edge of the zone.
    """

    zone: FloatArray
    lateral: FloatArray

    def zones(self) -> Zones:
        """Return the zone inside both limits, and the zone outside the lateral limits only."""
        is_inside, is_within_limits = (
            self.zone >= -MAX_ROUNDING_SINE,
            self.lateral >= -MAX_ROUNDING_SINE,
        )
        return Zones(is_inside & is_within_limits, is_inside & ~is_within_limits)


def to_face_frame(face: SlopeFace, normals: npt.ArrayLike) -> FloatArray:
    """Transform upward normals to the frame of a face.

    Parameters
    ----------
    face : SlopeFace
    normals : (..., 3) array_like
        Unit vectors in the World frame.

    Returns
    -------
    (..., 3) ndarray
    """
    return np.asarray(np.asarray(normals, np.float64) @ face.axes().T)


def planar_margins(face: SlopeFace, normals: FloatArray) -> Margins:
    """Return the margins of `planar_sliding`.

    Parameters
    ----------
    face : SlopeFace
    normals : (..., 3) ndarray
        Upward normals in the frame of the face.

    Returns
    -------
    Margins
    """
    x, y, z = np.moveaxis(normals, -1, 0)
    sines = np.hypot(x, y)
    sin_f, cos_f = _sin_cos(face.options.friction_deg)
    sin_d, cos_d = _sin_cos(face.plane.dip_deg)
    is_level = sines <= MIN_ANGLE_RAD
    # Scalar product of the dip line (x z, y z, -flat^2) / flat and the normal of the face.
    daylight_margin = sin_d * x * z / np.where(is_level, 1.0, sines) - cos_d * sines
    sliding_margin = np.where(is_level, -1.0, sines * cos_f - z * sin_f)
    return Margins(np.minimum(daylight_margin, sliding_margin), _lateral_margin(face, x, y))


def planar_sliding(face: SlopeFace, normals: FloatArray) -> Zones:
    """Find the planes on which a block slides.

    A horizontal plane, which has no dip direction, never slides.

    Parameters
    ----------
    face : SlopeFace
    normals : (..., 3) ndarray
        Upward normals in the frame of the face.

    Returns
    -------
    Zones
    """
    return planar_margins(face, normals).zones()


def flexural_margins(face: SlopeFace, normals: FloatArray) -> Margins:
    """Return the margins of `flexural_toppling`.

    Parameters
    ----------
    face : SlopeFace
    normals : (..., 3) ndarray
        Upward normals in the frame of the face.

    Returns
    -------
    Margins
    """
    x, y, z = np.moveaxis(normals, -1, 0)
    # Horizontal component of the downward pole; it points into the face if the plane dips away from
    # it.
    outward_sines = np.where(z < MIN_ANGLE_RAD, np.abs(x), -x)
    limit = face.plane.dip_deg - face.options.friction_deg
    if limit <= ANGLE_TOLERANCE_DEG:
        return Margins(np.full(x.shape, -1.0), _lateral_margin(face, outward_sines, y))
    sin_l, cos_l = _sin_cos(limit)
    return Margins(sin_l * outward_sines - cos_l * z, _lateral_margin(face, outward_sines, y))


def flexural_toppling(face: SlopeFace, normals: FloatArray) -> Zones:
    """Find the planes along which layers slip and topple.

    Both ends of the pole of a vertical plane are tested.

    Parameters
    ----------
    face : SlopeFace
    normals : (..., 3) ndarray
        Upward normals in the frame of the face.

    Returns
    -------
    Zones
    """
    return flexural_margins(face, normals).zones()


def wedge_margins(face: SlopeFace, lines: FloatArray) -> Margins:
    """Return the margins of `wedge_sliding`, which has no lateral limits.

    Parameters
    ----------
    face : SlopeFace
    lines : (..., 3) ndarray
        Downward unit vectors in the frame of the face.

    Returns
    -------
    Margins
    """
    x, _, z = np.moveaxis(lines, -1, 0)
    sin_f, _ = _sin_cos(face.options.friction_deg)
    sin_d, cos_d = _sin_cos(face.plane.dip_deg)
    daylight_margin = np.where(z < -MIN_ANGLE_RAD, sin_d * x + cos_d * z, -1.0)
    return Margins(np.minimum(daylight_margin, -z - sin_f), np.ones(x.shape))


def wedge_sliding(face: SlopeFace, lines: FloatArray) -> Zones:
    """Find the intersections along which a wedge slides.

    The secondary zone lies between the great circle of the friction angle and the friction cone;
    there a wedge can slide on one of its planes.

    Parameters
    ----------
    face : SlopeFace
    lines : (..., 3) ndarray
        Downward unit vectors in the frame of the face.

    Returns
    -------
    Zones
    """
    x, _, z = np.moveaxis(lines, -1, 0)
    sin_f, cos_f = _sin_cos(face.options.friction_deg)
    sin_d, cos_d = _sin_cos(face.plane.dip_deg)
    is_daylighting = (sin_d * x + cos_d * z >= -MAX_ROUNDING_SINE) & (z < -MIN_ANGLE_RAD)
    is_steep = -z >= sin_f - MAX_ROUNDING_SINE
    is_beyond = sin_f * x + cos_f * z <= MAX_ROUNDING_SINE
    return Zones(is_steep & is_daylighting, ~is_steep & is_daylighting & is_beyond)


def direct_margins(face: SlopeFace, lines: FloatArray) -> Margins:
    """Return the margins of the critical zone of `direct_toppling`.

    Parameters
    ----------
    face : SlopeFace
    lines : (..., 3) ndarray
        Downward unit vectors in the frame of the face.

    Returns
    -------
    Margins
    """
    x, y, z = np.moveaxis(lines, -1, 0)
    _, cos_d = _sin_cos(face.plane.dip_deg)
    sin_l, cos_l = _sin_cos(face.options.lateral_deg)
    sines_into_slope = np.where(-z < MIN_ANGLE_RAD, np.abs(x), -x)
    return Margins(-z - cos_d, sines_into_slope * sin_l - np.abs(y) * cos_l)


def direct_toppling(face: SlopeFace, lines: FloatArray) -> Zones:
    """Find the intersections about which blocks topple.

    The secondary zone is oblique toppling: lines that dip into the face within the friction angle
    of vertical, but outside the lateral limits. Applied to downward poles, the same zones contain
    the base planes of such blocks.

    Parameters
    ----------
    face : SlopeFace
    lines : (..., 3) ndarray
        Downward unit vectors in the frame of the face.

    Returns
    -------
    Zones
    """
    x, _, z = np.moveaxis(lines, -1, 0)
    _, cos_f = _sin_cos(face.options.friction_deg)
    margins = direct_margins(face, lines)
    sines_into_slope = np.where(-z < MIN_ANGLE_RAD, np.abs(x), -x)
    is_oblique = (
        (-z >= cos_f - MAX_ROUNDING_SINE)
        & (sines_into_slope >= -MAX_ROUNDING_SINE)
        & (margins.lateral < -MAX_ROUNDING_SINE)
    )
    return Zones(margins.zones().critical, is_oblique)


class PairCounts(NamedTuple):
    """Numbers of intersections of all pairs, and of those inside the zones, for k draws.

    `parallel` is the number of pairs without an intersection.
    """

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
    """Count the intersections of planes in each zone.

    Parameters
    ----------
    face : SlopeFace
    normals : (k, n, 3) ndarray
        Upward normals in the frame of the face.
    progress : Progress, optional
        Its steps are the intersections computed so far.
    sets : (n,) ndarray of int, optional
        See `intersections`.

    Returns
    -------
    PairCounts
    """
    progress = progress or SilentProgress()
    counts = np.zeros((6, len(normals)), np.int64)
    done_count = 0
    for lines, is_line, _ in intersections(normals, sets):
        wedge, topple = wedge_sliding(face, lines), direct_toppling(face, lines)
        flags = (is_line, ~is_line, *(zone & is_line for zone in (*wedge, *topple)))
        for row, flag in enumerate(flags):
            counts[row] += flag.sum(axis=1)
        done_count += is_line.size
        progress.step(done_count)
    return PairCounts(*counts)


def count_critical_lines(faces: Sequence[SlopeFace], lines: FloatArray) -> IntArray:
    """Count the critical intersection lines of each face.

    Matrix products make this fast enough for thousands of faces.

    Parameters
    ----------
    faces : sequence of SlopeFace
        All faces have the same friction angle and limits.
    lines : (m, 3) ndarray
        Downward unit vectors in the World frame.

    Returns
    -------
    (faces, 2) ndarray of int
        Number of critical lines for `wedge_sliding` (column 0) and `direct_toppling` (column 1).
    """
    counts = np.zeros((len(faces), 2), np.int64)
    sin_f, _ = _sin_cos(faces[0].options.friction_deg)
    sin_l, cos_l = _sin_cos(faces[0].options.lateral_deg)
    plunge_sines = -lines[:, 2]
    wedges = lines[(plunge_sines >= sin_f - MAX_ROUNDING_SINE) & (plunge_sines > MIN_ANGLE_RAD)]
    for start in range(0, len(faces), FACES_PER_BLOCK):
        block = faces[start : start + FACES_PER_BLOCK]
        rows = slice(start, start + len(block))
        out, strike_axes, _ = np.moveaxis(np.stack([face.axes() for face in block]), 1, 0)
        sin_d, cos_d = sin_cos_deg(np.array([face.plane.dip_deg for face in block]))
        normals = np.column_stack([out[:, :2] * sin_d[:, None], cos_d])
        counts[rows, 0] = (wedges @ normals.T >= -MAX_ROUNDING_SINE).sum(axis=0)
        steep_lines = lines[plunge_sines >= cos_d.min() - MAX_ROUNDING_SINE]
        sines_into_slope = -(steep_lines @ out.T)
        is_level = -steep_lines[:, 2] < MIN_ANGLE_RAD
        sines_into_slope[is_level] = np.abs(sines_into_slope[is_level])
        is_inside = -steep_lines[:, 2:] - cos_d >= -MAX_ROUNDING_SINE
        is_within_limits = (
            sines_into_slope * sin_l - np.abs(steep_lines @ strike_axes.T) * cos_l
            >= -MAX_ROUNDING_SINE
        )
        counts[rows, 1] = (is_inside & is_within_limits).sum(axis=0)
    return counts


class PairMembers(NamedTuple):
    """Numbers of critical intersections that each of n planes takes part in."""

    wedge: IntArray
    toppling: IntArray


def count_pair_members(
    face: SlopeFace, normals: FloatArray, sets: IntArray | None = None
) -> PairMembers:
    """Count the critical intersections that each plane takes part in.

    Parameters
    ----------
    face : SlopeFace
    normals : (n, 3) ndarray
        Upward normals in the frame of the face.
    sets : (n,) ndarray of int, optional
        See `intersections`.

    Returns
    -------
    PairMembers
    """
    n = len(normals)
    counts = np.zeros((2, n), np.int64)
    for lines, is_line, pairs in intersections(normals[None], sets):
        zones = (wedge_sliding(face, lines), direct_toppling(face, lines))
        for row, zone in enumerate(zones):
            counts[row] += np.bincount(pairs[:, (zone.critical & is_line)[0]].ravel(), minlength=n)
    return PairMembers(*counts)


def count_pairs_between_sets(n: int, sets: IntArray | None) -> int:
    """Return the number of pairs of planes that do not belong to the same set.

    Parameters
    ----------
    n : int
        Number of planes.
    sets : (n,) ndarray of int or None
        Set of each plane; -1 if it belongs to none.

    Returns
    -------
    int
    """
    pair_count = n * (n - 1) // 2
    if sets is None:
        return pair_count
    sizes = np.bincount(sets[sets >= 0])
    return pair_count - int(np.sum(sizes * (sizes - 1) // 2))


def intersections(
    normals: FloatArray, sets: IntArray | None = None
) -> Iterator[tuple[FloatArray, BoolArray, IntArray]]:
    """Compute the intersections of all pairs of planes in blocks.

    Two planes of the same set do not form a wedge: the direction of their intersection only
    reflects the scatter of the set about its mean.

    Parameters
    ----------
    normals : (k, n, 3) float64
        Unit normals of n planes in k random draws.
    sets : (n,) int64, optional
        Set of each plane; negative if it belongs to none. Pairs within a set are omitted.

    Yields
    ------
    lines : (k, m, 3) float64
        Downward unit vectors.
    is_line : (k, m) bool
        False for parallel planes.
    planes : (2, m) int64
        Row indices of the two planes.
    """
    n = normals.shape[1]
    start = 0
    while start < n - 1:
        # Process several first planes together if few planes follow them.
        last = start + 1
        n_pairs = len(normals) * (n - 1 - start)
        while last < n - 1 and n_pairs < PAIRS_PER_BLOCK:
            n_pairs += len(normals) * (n - 1 - last)
            last += 1
        a = np.concatenate([np.full(n - 1 - i, i) for i in range(start, last)])
        b = np.concatenate([np.arange(i + 1, n) for i in range(start, last)])
        start = last
        if sets is not None:
            is_different = (sets[a] != sets[b]) | (sets[a] < 0)
            a, b = a[is_different], b[is_different]
        x1, y1, z1 = np.moveaxis(normals[:, a], -1, 0)
        x2, y2, z2 = np.moveaxis(normals[:, b], -1, 0)
        x, y, z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
        length = np.sqrt(x * x + y * y + z * z)
        is_line = length > MIN_ANGLE_RAD
        scale = np.where(z > 0, -1.0, 1.0) / np.where(is_line, length, 1.0)
        yield np.stack([x * scale, y * scale, z * scale], axis=-1), is_line, np.stack([a, b])


def _lateral_margin(
    face: SlopeFace, outward_sines: FloatArray, lateral_cosines: FloatArray
) -> FloatArray:
    """Return the margin to the lateral limits.

    `outward_sines` is the component out of (or into) the face, `lateral_cosines` the component
    along it.
    """
    sin_l, cos_l = _sin_cos(face.options.lateral_deg)
    if face.options.limits == "curved":
        return np.asarray(sin_l - np.abs(lateral_cosines))
    return np.asarray(outward_sines * sin_l - np.abs(lateral_cosines) * cos_l)


def _sin_cos(angle_deg: float) -> tuple[float, float]:
    sine, cosine = sin_cos_deg(angle_deg)
    return float(sine), float(cosine)
