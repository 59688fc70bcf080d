"""The discontinuities of a set: parallel planes told apart by their place, their spacing,
persistence and area.

Pieces of one set whose places along its mean normal differ by more than their own scatter allows
are different discontinuities; those that do not are pieces of one. This, with its threshold of 1.5,
is how Riquelme, Abellan, Tomas & Jaboyedoff (2014, Computers & Geosciences 68, 38-52) join clusters
of points; spacing is that of Riquelme, Abellan & Tomas (2015, Engineering Geology 195, 185-195),
with planes that reach past all others and with planes that end; persistence that of Riquelme,
Tomas, Cano, Pastor & Abellan (2018, Rock Mechanics and Rock Engineering 51, 3005-3028).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geology.orientation import normals_to_planes
from vomstudio.geometry.vectors import strike_and_dip_lines

JOINED = 1.5
"""Sums of two scatters within which places along the normal are one (Riquelme et al. 2014)."""
_ONE_FACE = 0.2
"""Of the second to the third spread of all places: an outcrop that is no thicker is one face."""
FEWEST_PLACES = 4


@dataclass(frozen=True, eq=False)
class Pieces:
    """m planes as pieces of surface, World, m.

    places : (m, 3) their middles, NaN where unknown
    scatters : (m, 3, 3) covariance of the points of each, NaN where unknown
    areas : (m,) m2, NaN where unknown
    rings : of each the corners of its border (k, 3), none where it is unknown
    """

    places: FloatArray
    scatters: FloatArray
    areas: FloatArray
    rings: tuple[FloatArray, ...]

    @property
    def are_more_than_places(self) -> bool:
        """Whether the scatter or the border of any is known, so that some may be one plane."""
        return bool(np.isfinite(self.scatters).any()) or any(len(ring) for ring in self.rings)

    def rows(self, chosen: IntArray) -> Pieces:
        return Pieces(
            self.places[chosen],
            self.scatters[chosen],
            self.areas[chosen],
            tuple(self.rings[i] for i in chosen.tolist()),
        )


@dataclass(frozen=True)
class Discontinuity:
    """One plane of a set.

    id : name of the set and number along the normal; n : pieces; offset_m : along the set's upward
    normal, from the middle of its planes
    persistence_dip_m, persistence_strike_m : length along the dip and the strike of the set
    persistence_max_m : longest chord; hull_m2 : convex hull of all pieces, in the plane of the set
    area_m2 : of the pieces; None where borders or areas are unknown. What the outcrop shows is the
    least that they can be.
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
    """How the planes of a set stand in space; None where places, borders or areas are unknown.

    discontinuities : how many; spacing_m, spacing_cv : mean gap along the normal, as if every plane
        reached past all others, and standard deviation of the gaps over it
    spacing_ending_m : mean gap to the nearest piece of another one, for planes that end
    persistence_dip_m, persistence_strike_m, persistence_max_m : means; area_m2 : of all pieces
    p32_1_per_m : area per volume if planes reach past all others, p32_low95_1_per_m and
        p32_high95_1_per_m its 95 % interval for places at random, to where no piece is of another's
        plane only because both lean out of the set; None where nothing but places is known and
        several picks, each counted as a plane of its own, may be of one;
        p32_exposed_1_per_m : area of the pieces in the volume that they span, which is the least it
        can be
    rests_on : "one face" or "several faces", which the places of all planes together make
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
class OnScanline:
    """Planes of a set along a straight line: n crossed, apparent_m their mean gap along it, true_m
    that along the normal of the set (apparent times the cosine of the angle between the two, as
    Priest & Hudson 1976, International Journal of Rock Mechanics 13, 135-148); None for fewer than
    two."""

    n: int
    apparent_m: float | None
    true_m: float | None


def split_by_position(
    offsets: FloatArray, scatters: FloatArray, joined: float = JOINED
) -> IntArray:
    """(m,) which discontinuity each piece of a set is of, counted from 0.

    offsets, scatters : (m,) place along the normal of the set and standard deviation of the points
    about it. A piece is of the one with the most scatter that lies within `joined` times the sum of
    the two: the largest first, so that no chain of small pieces joins what is apart.
    """
    label = np.full(len(offsets), -1, np.int64)
    leaders: list[int] = []
    for i in np.argsort(-scatters, kind="stable").tolist():
        lead = np.array(leaders, np.int64)
        near = np.abs(offsets[lead] - offsets[i]) <= joined * (scatters[lead] + scatters[i])
        # Places that are equal but for rounding are one without any scatter.
        near |= np.abs(offsets[lead] - offsets[i]) <= 1e-9 * (1.0 + abs(float(offsets[i])))
        if near.any():
            label[i] = int(np.argmax(near))
        else:
            label[i] = len(leaders)
            leaders.append(i)
    return label


def arrange(
    name: str, normal: FloatArray, poles: FloatArray, pieces: Pieces, rests_on: str | None
) -> tuple[Arrangement, tuple[Discontinuity, ...], IntArray]:
    """Of the m planes of one set: what is said of them, their discontinuities upwards, and the
    number of that of each, -1 for a plane without a place.

    normal : (3,) of the set; poles : (m, 3) of the planes, either end
    """
    upward = normal if normal[2] >= 0 else -normal
    known = np.flatnonzero(np.isfinite(pieces.places).all(axis=1))
    number = np.full(len(poles), -1, np.int64)
    if not len(known):
        return Arrangement(rests_on=rests_on), (), number
    own = pieces.rows(known)
    middle = own.places.mean(axis=0)
    offsets = (own.places - middle) @ upward
    along = np.einsum("i,mij,j->m", upward, own.scatters, upward)
    number[known] = split_by_position(offsets, np.sqrt(np.maximum(np.nan_to_num(along), 0.0)))
    apart = int(split_by_position(offsets, _thickness(own.scatters)).max()) + 1
    axes = np.concatenate(_strike_and_dip(upward))
    groups = [np.flatnonzero(number[known] == k) for k in range(int(number.max()) + 1)]
    where = [float(np.average(offsets[rows], weights=_weights(own.areas[rows]))) for rows in groups]
    found, shapes = [], []
    # The mean place of one with several pieces may lie beyond its neighbour's.
    for k, of in enumerate(np.argsort(where, kind="stable").tolist()):
        number[known[groups[of]]] = k
        made, shape = _discontinuity(
            f"{name}-{k + 1}", name, where[of], own.rows(groups[of]), axes, middle
        )
        found.append(made)
        shapes.append(shape)
    whole = _arrangement(found, shapes, poles @ upward, rests_on, apart)
    if not own.are_more_than_places and _may_be_fewer(offsets, own.places, upward, poles[known]):
        whole = replace(whole, p32_low95_1_per_m=None, p32_high95_1_per_m=None)
    return whole, tuple(found), number


def _thickness(scatters: FloatArray) -> FloatArray:
    """(m,) standard deviation of the points of each piece about its own plane."""
    known = np.isfinite(scatters).all(axis=(1, 2))
    own = np.zeros(len(scatters))
    own[known] = np.sqrt(np.maximum(np.linalg.eigvalsh(scatters[known])[:, 0], 0.0))
    return own


def _may_be_fewer(
    offsets: FloatArray, places: FloatArray, normal: FloatArray, poles: FloatArray
) -> bool:
    """Whether some picks, of which nothing but places is known, may be of one plane: those next to
    each other along the normal whose gap is no more than what planes that lean as the picks do make
    of their distance along the set, 95 %."""
    leans = np.sqrt(np.mean(np.maximum(1.0 - (poles @ normal) ** 2, 0.0)) / 2.0)
    order = np.argsort(offsets, kind="stable")
    step = np.diff(places[order], axis=0)
    gaps = np.diff(offsets[order])
    beside = np.linalg.norm(step - gaps[:, None] * normal, axis=1)
    return bool((gaps < 2.0 * leans * beside).any())


def rests_on(pieces: Pieces) -> str | None:
    """Whether the places and borders of all planes together are one face, or several."""
    known = pieces.places[np.isfinite(pieces.places).all(axis=1)]
    if len(known) < FEWEST_PLACES:
        return None
    rings = [ring for ring in pieces.rings if len(ring)]
    all_ = np.concatenate([known, *rings])
    spread = np.linalg.svd(all_ - all_.mean(axis=0), compute_uv=False)
    return "one face" if spread[2] <= _ONE_FACE * spread[1] else "several faces"


def on_scanline(
    normal: FloatArray, poles: FloatArray, places: FloatArray, line: FloatArray
) -> OnScanline:
    """Planes (m, 3) through places (m, 3) that reach past the line, from line[0] to line[1]."""
    step = line[1] - line[0]
    length = float(np.linalg.norm(step))
    down = poles @ step
    with np.errstate(divide="ignore", invalid="ignore"):
        share = ((places - line[0]) * poles).sum(axis=1) / down
    crossed = np.sort(share[np.isfinite(share) & (share >= 0.0) & (share <= 1.0)]) * length
    if len(crossed) < 2:
        return OnScanline(len(crossed), None, None)
    apparent = float(np.diff(crossed).mean())
    return OnScanline(len(crossed), apparent, apparent * abs(float(normal @ step)) / length)


def _weights(areas: FloatArray) -> FloatArray:
    known = np.isfinite(areas) & (areas > 0.0)
    return areas if known.all() else np.ones(len(areas))


def _strike_and_dip(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    direction, dip, _ = normals_to_planes(normal)
    return strike_and_dip_lines(direction, dip)


def _discontinuity(
    id_: str, set_: str, offset: float, members: Pieces, axes: FloatArray, middle: FloatArray
) -> tuple[Discontinuity, Any]:
    """And its pieces in the plane of the set, a shapely geometry; None where a border is unknown.
    axes : (2, 3) strike and dip of the set"""
    import shapely

    area = float(members.areas.sum())
    flat = [(ring - middle) @ axes.T for ring in members.rings]
    if not all(len(ring) >= 3 for ring in flat):
        return Discontinuity(
            id_,
            set_,
            len(flat),
            offset,
            None,
            None,
            None,
            None,
            area if math.isfinite(area) else None,
        ), None
    polygons = shapely.make_valid(np.array([shapely.Polygon(ring) for ring in flat]))
    corners = np.concatenate(flat)
    hull = shapely.convex_hull(shapely.multipoints(corners))
    size = np.ptp(corners, axis=0)
    return Discontinuity(
        id_,
        set_,
        len(flat),
        offset,
        float(size[1]),
        float(size[0]),
        _longest_chord(shapely.get_coordinates(hull)),
        float(hull.area),
        area if math.isfinite(area) else float(shapely.area(polygons).sum()),
    ), shapely.geometrycollections(polygons)


def _longest_chord(corners: FloatArray) -> float:
    """Between corners (k, 2) of a convex hull."""
    from scipy.spatial.distance import pdist

    return float(pdist(corners).max(initial=0.0))


def _arrangement(
    found: list[Discontinuity],
    shapes: list[Any],
    cosines: FloatArray,
    rests: str | None,
    apart: int,
) -> Arrangement:
    """found, shapes : upwards; cosines : (m,) of the planes with the normal of the set; apart : how
    many discontinuities there are if pieces that lean out of the set are joined only where they are
    thick enough"""
    import shapely

    offsets = np.array([one.offset_m for one in found])
    gaps = np.diff(offsets)
    mean = float(gaps.mean()) if len(gaps) and gaps.sum() > 0.0 else None
    cv = None
    if mean is not None and len(gaps) > 1:
        cv = float(gaps.std(ddof=1)) / mean
    area = _total([one.area_m2 for one in found])
    p32 = low = high = exposed = ending = None
    if mean is not None:
        leaning = float(np.mean(1.0 / np.maximum(np.abs(cosines), 0.1)))
        p32 = leaning / mean
        low = leaning * _rate95(len(gaps), float(gaps.sum()))[0]
        # Pieces that lean reach past others along the normal, which may be planes of their own.
        high = leaning * _rate95(max(len(gaps), apart - 1), float(gaps.sum()))[1]
        if area is not None and all(shape is not None for shape in shapes):
            ending = _ending_gap(offsets, shapes)
            region = float(shapely.convex_hull(shapely.geometrycollections(shapes)).area)
            if region > 0.0:
                exposed = area / (region * mean * len(found))
    return Arrangement(
        len(found),
        mean,
        cv,
        ending,
        _mean([one.persistence_dip_m for one in found]),
        _mean([one.persistence_strike_m for one in found]),
        _mean([one.persistence_max_m for one in found]),
        area,
        p32,
        low,
        high,
        exposed,
        rests,
    )


def _rate95(n: int, length: float) -> tuple[float, float]:
    """95 % interval of the rate of places at random, by n gaps of that length together: their sum
    is a gamma variable (Cox & Lewis 1966, The Statistical Analysis of Series of Events)."""
    from scipy.special import gammaincinv

    low, high = (float(gammaincinv(n, p)) / length for p in (0.025, 0.975))
    return low, high


def _ending_gap(offsets: FloatArray, shapes: list[Any]) -> float | None:
    """Mean distance along the normal from each to that of the ones above whose pieces come nearest
    (Riquelme et al. 2015, non-persistent). offsets, shapes : upwards"""
    import shapely

    gaps = []
    for i in range(len(offsets) - 1):
        best, gap = math.inf, 0.0
        for j in range(i + 1, len(offsets)):
            up = float(offsets[j] - offsets[i])
            if up >= best:
                break
            away = math.hypot(up, float(shapely.distance(shapes[i], shapes[j])))
            if away < best:
                best, gap = away, up
        gaps.append(gap)
    return float(np.mean(gaps)) if gaps else None


def _total(values: list[float | None]) -> float | None:
    known = [v for v in values if v is not None]
    return float(sum(known)) if len(known) == len(values) else None


def _mean(values: list[float | None]) -> float | None:
    known = [v for v in values if v is not None]
    return float(np.mean(known)) if known else None
