"""Discontinuities of a set, that is, its parallel planes: spacing, persistence and area.

Pieces of one set whose positions along the mean normal of the set differ by more than their scatter
belong to different discontinuities; other pieces belong to the same one. Riquelme, Abellan, Tomas &
Jaboyedoff (2014, Computers & Geosciences 68, 38-52) join clusters of points in this way, with the
same threshold of 1.5. Spacing follows Riquelme, Abellan & Tomas (2015, Engineering Geology 195,
185-195) for persistent and non-persistent planes; persistence follows Riquelme, Tomas, Cano, Pastor
& Abellan (2018, Rock Mechanics and Rock Engineering 51, 3005-3028).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geology.orientation import normals_to_planes
from vomstudio.geometry.vectors import strike_and_dip_lines

MAX_JOINED_SCATTER = 1.5
"""Maximum distance along the normal between pieces of one discontinuity, as a multiple of the sum
of their scatters (Riquelme et al. 2014).
"""
MAX_FACE_THICKNESS = 0.2
"""Maximum ratio of the third to the second spread of all positions for a single outcrop face."""
MIN_POSITIONS = 4


@dataclass(frozen=True, eq=False)
class Pieces:
    """Planes as m pieces of surface, in the World frame, m.

    Attributes
    ----------
    places : (m, 3) ndarray
        Midpoints of the pieces; NaN if unknown.
    scatters : (m, 3, 3) ndarray
        Covariances of the points of the pieces; NaN if unknown.
    areas : (m,) ndarray
        Areas in m2; NaN if unknown.
    rings : tuple of (k, 3) ndarray
        Vertices of the boundaries; empty if unknown.
    """

    places: FloatArray
    scatters: FloatArray
    areas: FloatArray
    rings: tuple[FloatArray, ...]

    @property
    def has_extents(self) -> bool:
        """Whether any scatter or boundary is known, so that pieces can be joined."""
        return bool(np.isfinite(self.scatters).any()) or any(len(ring) for ring in self.rings)

    def rows(self, rows: IntArray) -> Pieces:
        return Pieces(
            self.places[rows],
            self.scatters[rows],
            self.areas[rows],
            tuple(self.rings[i] for i in rows.tolist()),
        )


@dataclass(frozen=True)
class Discontinuity:
    """Discontinuity of a set.

    The outcrop only shows minimum values of persistence and area.

    Attributes
    ----------
    id : str
        Name of the set and number in order along the normal.
    n : int
        Number of pieces.
    offset_m : float
        Position along the upward normal of the set, relative to the middle of its planes, m.
    persistence_dip_m, persistence_strike_m : float or None
        Lengths along the dip and the strike of the set, m; None if a boundary is unknown.
    persistence_max_m : float or None
        Longest chord, m; None if a boundary is unknown.
    hull_m2 : float or None
        Area of the convex hull of all pieces in the plane of the set, m2; None if a boundary is
        unknown.
    area_m2 : float or None
        Total area of the pieces, m2; None if both areas and boundaries are unknown.
    """

    id: str
    set: str
    n: int
    offset_m: float
    persistence_dip_m: float | None
    persistence_strike_m: float | None
    persistence_max_m: float | None
    hull_m2: float | None
    area_m2: float | None


@dataclass(frozen=True)
class Arrangement:
    """Arrangement of the planes of a set, with None for values whose inputs are unknown.

    Attributes
    ----------
    discontinuities : int
        Number of discontinuities.
    spacing_m, spacing_cv : float
        Mean gap along the normal for persistent planes, m, and the standard deviation of the gaps
        divided by this mean.
    spacing_ending_m : float
        Mean gap to the nearest piece of another plane for non-persistent planes, m.
    persistence_dip_m, persistence_strike_m, persistence_max_m : float
        Mean values of the discontinuities, m.
    area_m2 : float
        Total area of all pieces, m2.
    p32_1_per_m, p32_low95_1_per_m, p32_high95_1_per_m : float
        Area per volume for persistent planes, with the 95 % interval for random positions. For the
        upper limit, pieces that are joined only because of their tilt are counted separately. There
        is no interval if only positions are known and several picks, each counted as a plane, may
        belong to the same plane.
    p32_exposed_1_per_m : float
        Area of the pieces divided by the volume that they span, a lower limit.
    rests_on : {"one face", "several faces"}
        Whether the planes of all sets are on one outcrop face or on several.
    """

    discontinuities: int | None = None
    spacing_m: float | None = None
    spacing_cv: float | None = None
    spacing_ending_m: float | None = None
    persistence_dip_m: float | None = None
    persistence_strike_m: float | None = None
    persistence_max_m: float | None = None
    area_m2: float | None = None
    p32_1_per_m: float | None = None
    p32_low95_1_per_m: float | None = None
    p32_high95_1_per_m: float | None = None
    p32_exposed_1_per_m: float | None = None
    rests_on: str | None = None


@dataclass(frozen=True)
class ScanlineSpacing:
    """Spacing of n planes of a set along a straight line; the values are None if n < 2.

    `apparent_m` is the mean gap along the line, `true_m` the mean gap along the normal of the set
    (the apparent gap times the cosine of the angle between line and normal: Priest & Hudson 1976,
    International Journal of Rock Mechanics 13, 135-148).
    """

    n: int
    apparent_m: float | None
    true_m: float | None


def split_by_position(
    offsets: FloatArray, scatters: FloatArray, max_scatter: float = MAX_JOINED_SCATTER
) -> IntArray:
    """Assign the pieces of a set to discontinuities by their positions along the normal.

    A piece joins the discontinuity with the largest scatter that is closer than `max_scatter` times
    the sum of both scatters. The largest pieces are processed first, so that chains of small pieces
    do not join distinct planes.

    Parameters
    ----------
    offsets, scatters : (m,) ndarray
        Positions of the pieces and standard deviations of their points, m.
    max_scatter : float

    Returns
    -------
    (m,) ndarray of int
        Index of the discontinuity of each piece, from 0.
    """
    label = np.full(len(offsets), -1, np.int64)
    leaders: list[int] = []
    for i in np.argsort(-scatters, kind="stable").tolist():
        leader_rows = np.array(leaders, np.int64)
        is_near = np.abs(offsets[leader_rows] - offsets[i]) <= max_scatter * (
            scatters[leader_rows] + scatters[i]
        )
        # Treat positions that differ only by rounding as equal.
        is_near |= np.abs(offsets[leader_rows] - offsets[i]) <= 1e-9 * (
            1.0 + abs(float(offsets[i]))
        )
        if is_near.any():
            label[i] = int(np.argmax(is_near))
        else:
            label[i] = len(leaders)
            leaders.append(i)
    return label


def arrange_planes(
    name: str, normal: FloatArray, poles: FloatArray, pieces: Pieces, faces: str | None
) -> tuple[Arrangement, tuple[Discontinuity, ...], IntArray]:
    """Group the m planes of one set into discontinuities and compute their arrangement.

    Parameters
    ----------
    name : str
    normal : (3,) ndarray
        Normal of the set.
    poles : (m, 3) ndarray
        Poles of the planes, pointing up or down.
    pieces : Pieces
    faces : str or None
        Result of `describe_faces`.

    Returns
    -------
    arrangement : Arrangement
    discontinuities : tuple of Discontinuity
        Discontinuities in upward order.
    number : (m,) ndarray of int
        Discontinuity of each plane; -1 if its position is unknown.
    """
    upward_normal = normal if normal[2] >= 0 else -normal
    located_rows = np.flatnonzero(np.isfinite(pieces.places).all(axis=1))
    labels = np.full(len(poles), -1, np.int64)
    if not len(located_rows):
        return Arrangement(rests_on=faces), (), labels
    members = pieces.rows(located_rows)
    centre = members.places.mean(axis=0)
    offsets = (members.places - centre) @ upward_normal
    projections = np.einsum("i,mij,j->m", upward_normal, members.scatters, upward_normal)
    labels[located_rows] = split_by_position(
        offsets, np.sqrt(np.maximum(np.nan_to_num(projections), 0.0))
    )
    n_separate = int(split_by_position(offsets, _thickness(members.scatters)).max()) + 1
    axes = np.concatenate(_strike_and_dip(upward_normal))
    groups = [np.flatnonzero(labels[located_rows] == k) for k in range(int(labels.max()) + 1)]
    group_offsets = [
        float(np.average(offsets[rows], weights=_weights(members.areas[rows]))) for rows in groups
    ]
    discontinuities, shapes = [], []
    # The mean position of several pieces can lie beyond that of a neighbour.
    for k, group in enumerate(np.argsort(group_offsets, kind="stable").tolist()):
        labels[located_rows[groups[group]]] = k
        discontinuity, shape = _build_discontinuity(
            f"{name}-{k + 1}", name, group_offsets[group], members.rows(groups[group]), axes, centre
        )
        discontinuities.append(discontinuity)
        shapes.append(shape)
    arrangement = _summarize(discontinuities, shapes, poles @ upward_normal, faces, n_separate)
    if not members.has_extents and _may_share_planes(
        offsets, members.places, upward_normal, poles[located_rows]
    ):
        arrangement = replace(arrangement, p32_low95_1_per_m=None, p32_high95_1_per_m=None)
    return arrangement, tuple(discontinuities), labels


def _thickness(scatters: FloatArray) -> FloatArray:
    """Return the standard deviations (m,) of the points of the pieces about their planes."""
    is_known = np.isfinite(scatters).all(axis=(1, 2))
    thickness = np.zeros(len(scatters))
    thickness[is_known] = np.sqrt(np.maximum(np.linalg.eigvalsh(scatters[is_known])[:, 0], 0.0))
    return thickness


def _may_share_planes(
    offsets: FloatArray, positions: FloatArray, normal: FloatArray, poles: FloatArray
) -> bool:
    """Return whether some located picks may belong to the same plane.

    These are neighbours along the normal whose gap may be caused by their tilt and lateral distance
    (95 %).
    """
    mean_tilt = np.sqrt(np.mean(np.maximum(1.0 - (poles @ normal) ** 2, 0.0)) / 2.0)
    order = np.argsort(offsets, kind="stable")
    step = np.diff(positions[order], axis=0)
    gaps = np.diff(offsets[order])
    lateral_distances = np.linalg.norm(step - gaps[:, None] * normal, axis=1)
    return bool((gaps < 2.0 * mean_tilt * lateral_distances).any())


def describe_faces(pieces: Pieces) -> str | None:
    """Return whether all planes lie on one face or on several; None if there are too few.

    Parameters
    ----------
    pieces : Pieces

    Returns
    -------
    str or None
    """
    located_positions = pieces.places[np.isfinite(pieces.places).all(axis=1)]
    if len(located_positions) < MIN_POSITIONS:
        return None
    rings = [ring for ring in pieces.rings if len(ring)]
    points = np.concatenate([located_positions, *rings])
    singular_values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return (
        "one face"
        if singular_values[2] <= MAX_FACE_THICKNESS * singular_values[1]
        else "several faces"
    )


def measure_scanline_spacing(
    normal: FloatArray, poles: FloatArray, locations: FloatArray, line: FloatArray
) -> ScanlineSpacing:
    """Measure the spacing of persistent planes along a scanline.

    Parameters
    ----------
    normal : (3,) ndarray
        Mean normal of the set.
    poles, locations : (m, 3) ndarray
        Poles of the planes, and one point on each plane.
    line : (2, 3) ndarray
        End points of the line.

    Returns
    -------
    ScanlineSpacing
    """
    step = line[1] - line[0]
    length = float(np.linalg.norm(step))
    denominators = poles @ step
    with np.errstate(divide="ignore", invalid="ignore"):
        fraction = ((locations - line[0]) * poles).sum(axis=1) / denominators
    positions = (
        np.sort(fraction[np.isfinite(fraction) & (fraction >= 0.0) & (fraction <= 1.0)]) * length
    )
    if len(positions) < 2:
        return ScanlineSpacing(len(positions), None, None)
    apparent = float(np.diff(positions).mean())
    return ScanlineSpacing(len(positions), apparent, apparent * abs(float(normal @ step)) / length)


def _weights(areas: FloatArray) -> FloatArray:
    is_known = np.isfinite(areas) & (areas > 0.0)
    return areas if is_known.all() else np.ones(len(areas))


def _strike_and_dip(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    direction, dip, _ = normals_to_planes(normal)
    return strike_and_dip_lines(direction, dip)


def _build_discontinuity(
    id_: str, set_name: str, offset: float, members: Pieces, axes: FloatArray, centre: FloatArray
) -> tuple[Discontinuity, Any]:
    """Return a discontinuity and its pieces in the plane of the set.

    `axes` (2, 3) are the strike and dip directions of the set; the pieces are a shapely geometry,
    or None if boundaries are missing.
    """
    import shapely

    area = float(members.areas.sum())
    plane_rings = [(ring - centre) @ axes.T for ring in members.rings]
    if not all(len(ring) >= 3 for ring in plane_rings):
        return Discontinuity(
            id_,
            set_name,
            len(plane_rings),
            offset,
            None,
            None,
            None,
            None,
            area if math.isfinite(area) else None,
        ), None
    polygons = shapely.make_valid(np.array([shapely.Polygon(ring) for ring in plane_rings]))
    corners = np.concatenate(plane_rings)
    hull = shapely.convex_hull(shapely.multipoints(corners))
    size = np.ptp(corners, axis=0)
    return Discontinuity(
        id_,
        set_name,
        len(plane_rings),
        offset,
        float(size[1]),
        float(size[0]),
        _longest_chord(shapely.get_coordinates(hull)),
        float(hull.area),
        area if math.isfinite(area) else float(shapely.area(polygons).sum()),
    ), shapely.geometrycollections(polygons)


def _longest_chord(corners: FloatArray) -> float:
    """Return the longest chord between the vertices (k, 2) of a convex hull."""
    from scipy.spatial.distance import pdist

    return float(pdist(corners).max(initial=0.0))


def _summarize(
    discontinuities: list[Discontinuity],
    shapes: list[Any],
    cosines: FloatArray,
    faces: str | None,
    n_separate: int,
) -> Arrangement:
    """Summarize the discontinuities, given in upward order.

    `cosines` (m,) are the cosines between the normals of the planes and of the set. `n_separate` is
    the number of discontinuities if inclined pieces are joined only on account of their thickness.
    """
    import shapely

    offsets = np.array([discontinuity.offset_m for discontinuity in discontinuities])
    gaps = np.diff(offsets)
    mean = float(gaps.mean()) if len(gaps) and gaps.sum() > 0.0 else None
    cv = None
    if mean is not None and len(gaps) > 1:
        cv = float(gaps.std(ddof=1)) / mean
    area = _total([discontinuity.area_m2 for discontinuity in discontinuities])
    p32 = low = high = exposed_p32 = ending_spacing = None
    if mean is not None:
        obliquity_factor = float(np.mean(1.0 / np.maximum(np.abs(cosines), 0.1)))
        p32 = obliquity_factor / mean
        low = obliquity_factor * _rate95(len(gaps), float(gaps.sum()))[0]
        # Inclined pieces overlap others along the normal, although they may be separate planes.
        high = obliquity_factor * _rate95(max(len(gaps), n_separate - 1), float(gaps.sum()))[1]
        if area is not None and all(shape is not None for shape in shapes):
            ending_spacing = _ending_gap(offsets, shapes)
            region = float(shapely.convex_hull(shapely.geometrycollections(shapes)).area)
            if region > 0.0:
                exposed_p32 = area / (region * mean * len(discontinuities))
    return Arrangement(
        len(discontinuities),
        mean,
        cv,
        ending_spacing,
        _mean([discontinuity.persistence_dip_m for discontinuity in discontinuities]),
        _mean([discontinuity.persistence_strike_m for discontinuity in discontinuities]),
        _mean([discontinuity.persistence_max_m for discontinuity in discontinuities]),
        area,
        p32,
        low,
        high,
        exposed_p32,
        faces,
    )


def _rate95(n: int, length: float) -> tuple[float, float]:
    """Return the 95 % interval of the rate of random positions, from n gaps of a total length.

    The sum of the gaps follows a gamma distribution (Cox & Lewis 1966, The Statistical Analysis of
    Series of Events).
    """
    from scipy.special import gammaincinv

    low, high = (float(gammaincinv(n, p)) / length for p in (0.025, 0.975))
    return low, high


def _ending_gap(offsets: FloatArray, shapes: list[Any]) -> float | None:
    """Return the mean distance along the normal to the nearest pieces above.

    This is the non-persistent spacing of Riquelme et al. 2015. `offsets` and `shapes` are in upward
    order. None if there is only one discontinuity.
    """
    import shapely

    gaps = []
    for i in range(len(offsets) - 1):
        nearest_distance, gap = math.inf, 0.0
        for j in range(i + 1, len(offsets)):
            height = float(offsets[j] - offsets[i])
            if height >= nearest_distance:
                break
            distance = math.hypot(height, float(shapely.distance(shapes[i], shapes[j])))
            if distance < nearest_distance:
                nearest_distance, gap = distance, height
        gaps.append(gap)
    return float(np.mean(gaps)) if gaps else None


def _total(values: list[float | None]) -> float | None:
    known_values = [value for value in values if value is not None]
    return float(sum(known_values)) if len(known_values) == len(values) else None


def _mean(values: list[float | None]) -> float | None:
    known_values = [value for value in values if value is not None]
    return float(np.mean(known_values)) if known_values else None
