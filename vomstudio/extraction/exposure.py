"""What of a model is exposed rock, and how much of that is near-planar.

Tavani et al., section 4.1.3: where less than 30 % of the exposure is near-planar, planes found
automatically do not stand for the outcrop. Vegetation is what scatters in all directions at the
scale of the resolution (in a cloud), or is green and rough; debris is gentle ground whose pieces
face all directions at a scale of twenty resolutions. What lies in a smooth facet is neither.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.extraction.elements import NO_SURFACE, Elements

Array = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Labels = npt.NDArray[np.int32]

COVERS = ("facet", "bare", "vegetation", "debris")
"""What an element of the surface may be: in a facet, rock in none, or no rock."""
NEAR_PLANAR_SHARE = 0.30
"""The book's."""
# Ours. A plane has a surface variation near 0, a ball of points 1/3, an edge of 90 degrees 0.1.
_FILLED = (16, 32, 64, 96), (0.11, 0.16, 0.20, 0.22)
"""Of so many points around, the mean variation of neighbours, which points that fill a volume are
above in 99 of 100 (0.13, 0.19, 0.23, 0.25), few points telling less of a ball; one that scatter
about a plane by half of the spacing are at 0.07, 0.04, 0.02, 0.02, by a whole one at 0.15, 0.13,
0.08, 0.06."""
_SKIN = 0.75
# A point with a sixteenth of the usual density around is scattered, and no thinly covered piece of
# a surface, where those around it are not flat; some of them are on surfaces, as of more points
# they are. Rough rock is at 0.05, its edges at 0.1.
_SPARSE, _LOOSE = 16.0, 0.08
_ROUGH = 0.02
_GREEN = 0.08
_WIDE = 20.0
_GENTLE_DEG = 40.0
_JUMBLED = 0.25


@dataclass(frozen=True)
class Exposure:
    """Areas in m2; shares None where there is nothing to divide by.

    coverage : of the whole model, the share that lies in facets
    near_planar_share : of the exposed rock, without vegetation and debris, the share in facets
        that are large beside the resolution
    vegetation_share, debris_share : of the whole model
    exposed_m2 : of the exposed rock; by_facet_m2 : (facets,) what each of the facets that are large
        beside the resolution has of it
    covers : (elements,) int32 places in COVERS
    """

    area_m2: float
    coverage: float | None
    near_planar_share: float | None
    vegetation_share: float
    debris_share: float
    exposed_m2: float
    by_facet_m2: Array
    covers: Labels


def exposure_of(elements: Elements, labels: Labels, large: Bools, colors: Array | None) -> Exposure:
    """labels : (n,) facet of each element, -1 for none; large : (n,) whether that facet is so large
    beside the resolution that its error can be believed: any surface is planar at the scale of its
    points; colors : (n, 3) 0 to 255 of the elements, or None."""
    area = np.where(np.isfinite(elements.areas), elements.areas, 0.0)
    inside = labels >= 0
    green = np.zeros(len(area), np.bool_) if colors is None else _green(colors)
    variation = _mean_of_neighbours(elements, np.nan_to_num(elements.variation, nan=NO_SURFACE))
    volume = fills_volume(elements, variation)
    if volume.any() and not volume.all():
        # Of what fills a volume, or is far from all others, the distance to the next is no side of
        # a piece of a surface.
        area[volume] = np.minimum(area[volume], np.median(area[~volume]))
    total = float(area.sum())
    plants = ~inside & (volume | (green & (variation > _ROUGH)))
    plants |= green & inside & (variation > 2.0 * _ROUGH)
    rubble = _jumbled_ground(elements, ~inside & ~plants)
    rock = ~(plants | rubble)
    exposed = float(area[rock].sum())
    own = rock & large & inside
    count = max(int(labels.max(initial=-1)) + 1, 0)
    return Exposure(
        total,
        float(area[inside].sum()) / total if total > 0.0 else None,
        float(area[rock & large].sum()) / exposed if exposed > 0.0 else None,
        float(area[plants].sum()) / total if total > 0.0 else 0.0,
        float(area[rubble].sum()) / total if total > 0.0 else 0.0,
        exposed,
        np.bincount(labels[own], area[own], count).astype(np.float64),
        np.where(plants, 2, np.where(rubble, 3, np.where(inside, 0, 1))).astype(np.int32),
    )


def fills_volume(elements: Elements, variation: Array | None = None, skin: bool = False) -> Bools:
    """(n,) which points scatter in all directions, or are no piece of a surface. variation : mean
    of the neighbours', if known; skin : at the border of a volume, too"""
    # Faces of a mesh at ledges face all directions as well.
    if elements.of != "point" or not elements.around:
        return np.zeros(len(elements), np.bool_)
    own = np.nan_to_num(elements.variation, nan=NO_SURFACE)
    if variation is None:
        variation = _mean_of_neighbours(elements, own)
    limit = np.interp(elements.around, *_FILLED)
    if elements.fewer is not None:
        limit = np.where(elements.fewer, _FILLED[1][0], limit)
    limit = (_SKIN if skin else 1.0) * limit
    sparse = elements.areas > _SPARSE * np.median(elements.areas)
    return np.asarray((variation > limit) | (own >= NO_SURFACE) | (sparse & (variation > _LOOSE)))


def _green(colors: Array) -> Bools:
    """Excess green (Woebbecke et al. 1995), of chromatic coordinates."""
    total = np.maximum(colors.sum(axis=1), 1.0)
    return np.asarray((3.0 * colors[:, 1] - total) / total > _GREEN)


def _mean_of_neighbours(elements: Elements, values: Array) -> Array:
    number = np.diff(elements.starts)
    source = np.repeat(np.arange(len(values)), number)
    sums = np.bincount(source, values[elements.near], len(values))
    return np.asarray((values + sums) / (number + 1.0))


def _jumbled_ground(elements: Elements, asked: Bools) -> Bools:
    """Which of the elements asked for are in cells of twenty resolutions that are gentle as a
    whole, and whose elements face all directions."""
    if not asked.any():
        return asked
    side = _WIDE * float(np.median(elements.spacing))
    cell = (elements.places * (1.0 / max(side, 1e-12))).astype(np.int64) & 0x1FFFFF
    key = (cell[:, 0] << 42) | (cell[:, 1] << 21) | cell[:, 2]
    named = np.unique(key[asked])
    which = np.minimum(np.searchsorted(named, key), len(named) - 1)
    rows = np.flatnonzero(named[which] == key)
    which, count = which[rows], len(named)
    known = np.isfinite(elements.normals[rows, 0])
    places, normals = elements.places[rows], np.nan_to_num(elements.normals[rows])
    weight = np.where(known, elements.areas[rows], 0.0)
    total = np.maximum(np.bincount(which, weight, count), 1e-300)
    tensor, spread = np.empty((count, 3, 3)), np.empty((count, 3, 3))
    mean = np.stack([np.bincount(which, weight * places[:, i], count) / total for i in range(3)], 1)
    off = places - mean[which]
    for i in range(3):
        for j in range(i, 3):
            n = np.bincount(which, weight * normals[:, i] * normals[:, j], count) / total
            s = np.bincount(which, weight * off[:, i] * off[:, j], count) / total
            tensor[:, i, j] = tensor[:, j, i] = n
            spread[:, i, j] = spread[:, j, i] = s
    # The share of the normals' squares across their common axis.
    jumbled = 1.0 - np.linalg.eigvalsh(tensor)[:, 2] > _JUMBLED
    upward = np.abs(np.linalg.eigh(spread)[1][:, 2, 0])
    gentle = upward >= np.cos(np.radians(_GENTLE_DEG))
    result = np.zeros(len(elements), np.bool_)
    result[rows] = (jumbled & gentle)[which]
    return result & asked
