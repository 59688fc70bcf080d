"""What of a model is exposed rock, and how much of that is near-planar.

Tavani et al., section 4.1.3: where less than 30 % of the exposure is near-planar, planes found
automatically do not stand for the outcrop. Vegetation is what scatters in all directions at the
scale of the resolution (in a cloud), or is green and rough, or very green, as a lawn is; debris is
gentle ground whose pieces face all directions at a scale of twenty resolutions. No shape tells a
level bed from a sheet of gravel or asphalt, so how much is level is told beside the share.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array
from vomstudio.extraction.elements import NO_SURFACE, Elements, middle_of
from vomstudio.extraction.kernels import sums_in_cells
from vomstudio.geometry.kernels.cells import tabulate
from vomstudio.geometry.kernels.jit import for_kernels

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
# Ours: grass has 0.2 to 0.4; more than the second figure is the green of a drawn scale.
_GRASS = 0.14, 0.9
LEVEL_DEG = 10.0
"""Facets that dip by less may be ground."""
_WIDE = 20.0
_GENTLE_DEG = 40.0
_JUMBLED = 0.25


@dataclass(frozen=True)
class Exposure:
    """Areas in m2; shares None where there is nothing to divide by.

    coverage : of the whole model, the share that lies in facets
    near_planar_share : of the exposed rock, without vegetation and debris, the share in facets
        that are large beside the resolution
    level_share : of the exposed rock, the share in such facets that dip by less than LEVEL_DEG
    vegetation_share, debris_share : of the whole model
    exposed_m2 : of the exposed rock; by_facet_m2 : (facets,) what each of the facets that are large
        beside the resolution has of it
    covers : (elements,) int32 places in COVERS
    """

    area_m2: float
    coverage: float | None
    near_planar_share: float | None
    level_share: float | None
    vegetation_share: float
    debris_share: float
    exposed_m2: float
    by_facet_m2: FloatArray
    covers: Int32Array


def exposure_of(
    elements: Elements,
    labels: Int32Array,
    large: BoolArray,
    level: BoolArray,
    colors: FloatArray | None,
) -> Exposure:
    """labels : (n,) facet of each element, -1 for none; large : (n,) whether that facet is so large
    beside the resolution that its error can be believed: any surface is planar at the scale of its
    points; level : (n,) whether it dips by less than LEVEL_DEG; colors : (n, 3) 0 to 255 of the
    elements, or None."""
    area = np.where(np.isfinite(elements.areas), elements.areas, 0.0)
    inside = labels >= 0
    variation = _mean_of_neighbours(elements)
    volume = fills_volume(elements, variation)
    if volume.any() and not volume.all():
        # Of what fills a volume, or is far from all others, the distance to the next is no side of
        # a piece of a surface.
        area[volume] = np.minimum(area[volume], middle_of(area[~volume]))
    plants = ~inside & volume
    if colors is not None:
        green = _excess_green(colors) > _GREEN
        plants |= green & (variation > np.where(inside, 2.0 * _ROUGH, _ROUGH))
        plants |= is_grass(colors)
    rubble = _jumbled_ground(elements, ~(inside | plants))
    covers = np.where(inside, 0, 1).astype(np.int32)
    covers[plants], covers[rubble] = 2, 3
    by = np.bincount(covers + 4 * inside + 8 * large, area, 16).reshape(2, 2, 4)
    total, exposed = float(by.sum()), float(by[..., :2].sum())
    count = max(int(labels.max(initial=-1)) + 1, 0)
    own = np.where(large & (covers == 0), labels, -1)
    flat = float(area[large & level & (covers == 0)].sum())
    return Exposure(
        total,
        float(by[:, 1].sum()) / total if total > 0.0 else None,
        float(by[1, :, :2].sum()) / exposed if exposed > 0.0 else None,
        flat / exposed if exposed > 0.0 else None,
        float(by[..., 2].sum()) / total if total > 0.0 else 0.0,
        float(by[..., 3].sum()) / total if total > 0.0 else 0.0,
        exposed,
        np.bincount(own + 1, area, count + 1)[1:].astype(np.float64),
        covers,
    )


def fills_volume(
    elements: Elements, variation: FloatArray | None = None, skin: bool = False
) -> BoolArray:
    """(n,) which points scatter in all directions, or are no piece of a surface. variation : mean
    of the neighbours', if known; skin : at the border of a volume, too"""
    # Faces of a mesh at ledges face all directions as well.
    if elements.of != "point" or not elements.around:
        return np.zeros(len(elements), np.bool_)
    if variation is None:
        variation = _mean_of_neighbours(elements)
    limit = np.asarray(np.interp(elements.around, *_FILLED))
    if elements.fewer is not None:
        limit = np.where(elements.fewer, _FILLED[1][0], limit)
    limit = (_SKIN if skin else 1.0) * limit
    none = ~(elements.variation < NO_SURFACE)
    loose = np.flatnonzero((variation > _LOOSE) & ~none)
    none[loose] |= elements.areas[loose] > _SPARSE * elements.usual_area
    return np.asarray(none | (variation > limit))


def is_grass(colors: FloatArray) -> BoolArray:
    """(n,) which colours (n, 3), 0 to 255, are so green that no rock is, however smooth."""
    excess = _excess_green(colors)
    return np.asarray((excess > _GRASS[0]) & (excess < _GRASS[1]))


def _excess_green(colors: FloatArray) -> FloatArray:
    """Excess green (Woebbecke et al. 1995), of chromatic coordinates."""
    total = np.maximum(colors.sum(axis=1), 1.0)
    return np.asarray((3.0 * colors[:, 1] - total) / total)


def _mean_of_neighbours(elements: Elements) -> FloatArray:
    """Of the variation of each and its neighbours."""
    values = np.nan_to_num(elements.variation, nan=NO_SURFACE)
    number = np.diff(elements.starts)
    rows = np.flatnonzero(number)
    own = number[rows]
    begins = np.cumsum(own) - own
    if len(rows):
        sums = np.add.reduceat(values[elements.near], begins)
        values[rows] = (values[rows] + sums) / (own + 1.0)
    return values


def _jumbled_ground(elements: Elements, asked: BoolArray) -> BoolArray:
    """Which of the elements asked for are in cells of twenty resolutions that are gentle as a
    whole, and whose elements face all directions."""
    if not asked.any():
        return asked
    spacing = np.sqrt(elements.usual_area * (2.0 if elements.of == "face" else 1.0))
    per = 1.0 / max(_WIDE * float(spacing), 1e-12)
    rows = np.flatnonzero(asked)
    i, j, k = (elements.places[rows] * per).astype(np.int64).T & 0x1FFFFF
    named, which = np.unique((i << 42) | (j << 21) | k, return_inverse=True)
    count = len(named)
    size = 1 << (2 * count + 1).bit_length()
    names, ends = np.full(size, -1, np.int64), np.zeros((size, 2), np.int64)
    tabulate(named, np.arange(count + 1), names, ends)
    sums = np.zeros((count, 16))
    sums_in_cells(
        elements.places,
        for_kernels(elements.normals, np.float64),
        for_kernels(elements.areas, np.float64),
        per,
        names,
        ends,
        sums,
    )
    means = sums[:, 1:] / np.maximum(sums[:, :1], 1e-300)
    tensor, spread = np.empty((count, 3, 3)), np.empty((count, 3, 3))
    mean = means[:, 6:9]
    for at, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        tensor[:, i, j] = tensor[:, j, i] = means[:, at]
        spread[:, i, j] = spread[:, j, i] = means[:, 9 + at] - mean[:, i] * mean[:, j]
    # The share of the normals' squares across their common axis.
    jumbled = 1.0 - np.linalg.eigvalsh(tensor)[:, 2] > _JUMBLED
    upward = np.abs(np.linalg.eigh(spread)[1][:, 2, 0])
    gentle = upward >= np.cos(np.radians(_GENTLE_DEG))
    result = np.zeros(len(elements), np.bool_)
    result[rows[(jumbled & gentle)[which]]] = True
    return result
