"""Exposed rock of a model, and the share of it that is nearly planar.

According to Tavani et al., section 4.1.3, planes that are found automatically do not represent the
outcrop if less than 30 % of the exposure is nearly planar. Vegetation scatters in all directions at
the scale of the resolution (in a cloud), is green and rough, or is very green, like a lawn. Debris
is gently dipping ground whose elements face all directions at a scale of twenty resolutions. A
level bed has the same shape as a sheet of gravel or asphalt, so the level share is reported
separately.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array
from vomstudio.extraction.elements import NO_SURFACE, Elements, approximate_median
from vomstudio.extraction.kernels import add_to_cells
from vomstudio.geometry.kernels.cells import fill_row_table
from vomstudio.geometry.kernels.jit import to_kernel_array

MIN_NEAR_PLANAR_SHARE = 0.30
"""Minimum nearly planar share according to Tavani et al."""
# Not from the book. The surface variation of a plane is about 0, that of a ball of points 1/3, and
# that of a 90-degree edge 0.1.
_VOLUME_VARIATION = (16, 32, 64, 96), (0.11, 0.16, 0.20, 0.22)
"""Numbers of neighbouring points, and mean variations above which they fill a volume.

For points that fill a volume, 99 of 100 values exceed 0.13, 0.19, 0.23 and 0.25; the variation of
small samples of a ball is lower. For points that scatter about a plane by half of the spacing, the
values are 0.07, 0.04, 0.02, 0.02; for a whole spacing, they are 0.15, 0.13, 0.08, 0.06."""
_BORDER_FACTOR = 0.75
# A point with a sixteenth of the typical density is scattered rather than part of a sparsely
# covered surface if the points around it are not flat. The variation of rough rock is 0.05, that of
# its edges 0.1.
_MAX_AREA_RATIO, _MIN_LOOSE_VARIATION = 16.0, 0.08
_MIN_PLANT_VARIATION = 0.02
_MIN_PLANT_GREEN = 0.08
# Not from the book: the excess green of grass is 0.2 to 0.4; drawn scale bars exceed the second
# value.
_GRASS_GREEN_RANGE = 0.14, 0.9
MAX_LEVEL_DIP_DEG = 10.0
"""Maximum dip of facets that may be level ground."""
_CELL_RESOLUTIONS = 20.0
_MAX_GENTLE_DIP_DEG = 40.0
_MIN_JUMBLED_SHARE = 0.25


@dataclass(frozen=True)
class Exposure:
    """Areas of a model by cover.

    `coverage`, `near_planar_share` and `level_share` are None if their denominator is zero.

    Parameters
    ----------
    area_m2 : float
    coverage : float or None
        Share of the whole model that is part of facets.
    near_planar_share : float or None
        Share of the exposed rock (without vegetation and debris) in facets that are large relative
        to the resolution.
    level_share : float or None
        Share of the exposed rock in large facets that dip less than `MAX_LEVEL_DIP_DEG`.
    vegetation_share, debris_share : float
        Shares of the whole model.
    exposed_m2 : float
        Area of the exposed rock.
    exposed_by_facet_m2 : (facets,) array
        Exposed area of each large facet; 0 for other facets.
    cover_classes : (elements,) int32 array
        0 for a facet, 1 for other rock, 2 for vegetation, 3 for debris.
    """

    area_m2: float
    coverage: float | None
    near_planar_share: float | None
    level_share: float | None
    vegetation_share: float
    debris_share: float
    exposed_m2: float
    exposed_by_facet_m2: FloatArray
    cover_classes: Int32Array


def measure_exposure(
    elements: Elements,
    labels: Int32Array,
    is_in_large_facet: BoolArray,
    is_level: BoolArray,
    colors: FloatArray | None,
) -> Exposure:
    """Measure the exposed rock of a model and its nearly planar share.

    Parameters
    ----------
    elements : Elements
    labels : (n,) int32 array
        Facet of each element; -1 if it belongs to none.
    is_in_large_facet : (n,) bool array
        Whether the facet of each element is large enough for a reliable error; any surface is
        planar at the scale of its points.
    is_level : (n,) bool array
        Whether the facet of each element dips less than `MAX_LEVEL_DIP_DEG`.
    colors : (n, 3) array or None
        Colour components from 0 to 255.

    Returns
    -------
    Exposure
    """
    area = np.where(np.isfinite(elements.areas), elements.areas, 0.0)
    is_inside = labels >= 0
    variation = _smooth_variation(elements)
    is_in_volume = find_volume_elements(elements, variation)
    if is_in_volume.any() and not is_in_volume.all():
        # The distance between points that fill a volume or are isolated does not correspond to the
        # side of a surface element.
        area[is_in_volume] = np.minimum(area[is_in_volume], approximate_median(area[~is_in_volume]))
    is_plant = ~is_inside & is_in_volume
    if colors is not None:
        is_green = _excess_green(colors) > _MIN_PLANT_GREEN
        is_plant |= is_green & (
            variation > np.where(is_inside, 2.0 * _MIN_PLANT_VARIATION, _MIN_PLANT_VARIATION)
        )
        is_plant |= is_grass(colors)
    is_debris = _find_jumbled_areas(elements, ~(is_inside | is_plant))
    cover_classes = np.where(is_inside, 0, 1).astype(np.int32)
    cover_classes[is_plant], cover_classes[is_debris] = 2, 3
    areas = np.bincount(cover_classes + 4 * is_inside + 8 * is_in_large_facet, area, 16).reshape(
        2, 2, 4
    )
    total, exposed_area = float(areas.sum()), float(areas[..., :2].sum())
    count = max(int(labels.max(initial=-1)) + 1, 0)
    large_labels = np.where(is_in_large_facet & (cover_classes == 0), labels, -1)
    level_area = float(area[is_in_large_facet & is_level & (cover_classes == 0)].sum())
    return Exposure(
        total,
        float(areas[:, 1].sum()) / total if total > 0.0 else None,
        float(areas[1, :, :2].sum()) / exposed_area if exposed_area > 0.0 else None,
        level_area / exposed_area if exposed_area > 0.0 else None,
        float(areas[..., 2].sum()) / total if total > 0.0 else 0.0,
        float(areas[..., 3].sum()) / total if total > 0.0 else 0.0,
        exposed_area,
        np.bincount(large_labels + 1, area, count + 1)[1:].astype(np.float64),
        cover_classes,
    )


def find_volume_elements(
    elements: Elements, variation: FloatArray | None = None, includes_surface: bool = False
) -> BoolArray:
    """Find the points (n,) that scatter in all directions or are not part of a surface.

    Parameters
    ----------
    elements : Elements
    variation : (n,) array, optional
        Mean variation of each point and its neighbours, if already known.
    includes_surface : bool
        Whether to include the boundary of a volume.

    Returns
    -------
    (n,) bool array
        False for all elements of a mesh, and for all points if their neighbourhoods are wide.
    """
    # Meshes are excluded, because faces at ledges also face all directions.
    if elements.kind != "point" or not elements.around:
        return np.zeros(len(elements), np.bool_)
    if variation is None:
        variation = _smooth_variation(elements)
    limit = np.asarray(np.interp(elements.around, *_VOLUME_VARIATION))
    if elements.has_fewest_neighbours is not None:
        limit = np.where(elements.has_fewest_neighbours, _VOLUME_VARIATION[1][0], limit)
    limit = (_BORDER_FACTOR if includes_surface else 1.0) * limit
    is_isolated = ~(elements.variation < NO_SURFACE)
    loose_points = np.flatnonzero((variation > _MIN_LOOSE_VARIATION) & ~is_isolated)
    is_isolated[loose_points] |= (
        elements.areas[loose_points] > _MAX_AREA_RATIO * elements.typical_area
    )
    return np.asarray(is_isolated | (variation > limit))


def is_grass(colors: FloatArray) -> BoolArray:
    """Find colours that are greener than any rock, but less green than a drawn scale bar.

    Parameters
    ----------
    colors : (n, 3) ndarray
        Red, green and blue, 0 to 255.

    Returns
    -------
    (n,) ndarray of bool
    """
    excess = _excess_green(colors)
    return np.asarray((excess > _GRASS_GREEN_RANGE[0]) & (excess < _GRASS_GREEN_RANGE[1]))


def _excess_green(colors: FloatArray) -> FloatArray:
    """Return the excess green of the chromatic coordinates (Woebbecke et al. 1995)."""
    total = np.maximum(colors.sum(axis=1), 1.0)
    return np.asarray((3.0 * colors[:, 1] - total) / total)


def _smooth_variation(elements: Elements) -> FloatArray:
    """Average the variation of each element with its neighbours."""
    values = np.nan_to_num(elements.variation, nan=NO_SURFACE)
    number = np.diff(elements.starts)
    rows = np.flatnonzero(number)
    counts = number[rows]
    begins = np.cumsum(counts) - counts
    if len(rows):
        sums = np.add.reduceat(values[elements.neighbours], begins)
        values[rows] = (values[rows] + sums) / (counts + 1.0)
    return values


def _find_jumbled_areas(elements: Elements, is_candidate: BoolArray) -> BoolArray:
    """Find candidates whose normals face all directions within gently dipping cells.

    The cells are cubes with a side of twenty resolutions.
    """
    if not is_candidate.any():
        return is_candidate
    spacing = np.sqrt(elements.typical_area * (2.0 if elements.kind == "face" else 1.0))
    cells_per_unit = 1.0 / max(_CELL_RESOLUTIONS * float(spacing), 1e-12)
    rows = np.flatnonzero(is_candidate)
    i, j, k = (elements.places[rows] * cells_per_unit).astype(np.int64).T & 0x1FFFFF
    keys, cell_rows = np.unique((i << 42) | (j << 21) | k, return_inverse=True)
    count = len(keys)
    size = 1 << (2 * count + 1).bit_length()
    names, ends = np.full(size, -1, np.int64), np.zeros((size, 2), np.int64)
    fill_row_table(keys, np.arange(count + 1), names, ends)
    sums = np.zeros((count, 16))
    add_to_cells(
        elements.places,
        to_kernel_array(elements.normals, np.float64),
        to_kernel_array(elements.areas, np.float64),
        cells_per_unit,
        names,
        ends,
        sums,
    )
    means = sums[:, 1:] / np.maximum(sums[:, :1], 1e-300)
    tensor, covariance = np.empty((count, 3, 3)), np.empty((count, 3, 3))
    mean = means[:, 6:9]
    for position, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        tensor[:, i, j] = tensor[:, j, i] = means[:, position]
        covariance[:, i, j] = covariance[:, j, i] = means[:, 9 + position] - mean[:, i] * mean[:, j]
    # Share of the squared normals perpendicular to their common axis.
    is_scattered = 1.0 - np.linalg.eigvalsh(tensor)[:, 2] > _MIN_JUMBLED_SHARE
    upward_cosine = np.abs(np.linalg.eigh(covariance)[1][:, 2, 0])
    is_gentle = upward_cosine >= np.cos(np.radians(_MAX_GENTLE_DIP_DEG))
    result = np.zeros(len(elements), np.bool_)
    result[rows[(is_scattered & is_gentle)[cell_rows]]] = True
    return result
