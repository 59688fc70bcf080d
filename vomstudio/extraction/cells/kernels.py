"""Compiled loops over the cells of a cloud and its points, which are sorted by cell.

The points of cell c are points[cell_starts[c]:cell_starts[c + 1]].
"""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel

_CLUTTER_RATIO = 4
"""Minimum ratio of the number of points in a cell to that in a neighbour that is clutter."""


@kernel(
    "void(f8[:,::1], i8[::1], i8[::1], i4[::1], i4[::1], f8[:,::1], f8[::1], f8, f8[:,::1],"
    "f8[:,::1], f8[::1], i4[::1], b1[::1])"
)
def assign_points(  # type: ignore[no-untyped-def]
    points,
    cell_starts,
    starts,
    neighbours,
    labels,
    normals,
    max_distance,
    min_cosine,
    centres,
    plane_normals,
    limits,
    out,
    is_open,
):
    """Assign points to the nearest plane of their cell and the adjacent cells, or to none.

    `labels` (cells,) contains the facet of each cell, negative for none; `centres` and
    `plane_normals` (f, 3) and `limits` (f,) describe the planes of the facets. `is_open` receives
    whether a point must be analysed individually: if its cell has no facet, if an adjacent cell
    that is not clutter has another facet or none, or if the point is not on any of these planes.
    """
    for c in range(len(cell_starts) - 1):
        cell_label = labels[c]
        is_mixed = cell_label < 0
        is_known = not is_mixed
        for k in range(starts[c], starts[c + 1]):
            other_label = labels[neighbours[k]]
            if other_label >= 0:
                is_known = True
            elif (
                _CLUTTER_RATIO * (cell_starts[neighbours[k] + 1] - cell_starts[neighbours[k]])
                < cell_starts[c + 1] - cell_starts[c]
            ):
                continue
            if other_label != cell_label:
                is_mixed = True
        for p in range(cell_starts[c], cell_starts[c + 1]):
            out[p] = -1
            is_open[p] = True
            if not is_known:
                continue
            best_plane, min_distance = -1, math.inf
            for k in range(starts[c] - 1, starts[c + 1]):
                f = cell_label if k < starts[c] else labels[neighbours[k]]
                if f < 0 or f == best_plane:
                    continue
                distance = abs(
                    (points[p, 0] - centres[f, 0]) * plane_normals[f, 0]
                    + (points[p, 1] - centres[f, 1]) * plane_normals[f, 1]
                    + (points[p, 2] - centres[f, 2]) * plane_normals[f, 2]
                )
                limit = min(max_distance[c], limits[f])
                if f != cell_label:
                    cosine = abs(
                        normals[c, 0] * plane_normals[f, 0]
                        + normals[c, 1] * plane_normals[f, 1]
                        + normals[c, 2] * plane_normals[f, 2]
                    )
                    if not cosine >= min_cosine:
                        limit *= 0.5
                if distance <= limit and distance < min_distance:
                    best_plane, min_distance = f, distance
            out[p] = best_plane
            is_open[p] = is_mixed or best_plane < 0


@kernel("void(i8[::1], f8[:,::1], f8[::1], f8[::1], f8[::1], f8[:,::1], f8[::1], f8[::1], f8[::1])")
def copy_to_points(  # type: ignore[no-untyped-def]
    cell_starts,
    normals,
    variation,
    areas,
    noise,
    point_normals,
    point_variation,
    point_areas,
    point_noise,
):
    """Copy the values of each cell to its points, dividing the area equally."""
    for c in range(len(cell_starts) - 1):
        x, y, z = normals[c, 0], normals[c, 1], normals[c, 2]
        area_per_point = areas[c] / (cell_starts[c + 1] - cell_starts[c])
        for p in range(cell_starts[c], cell_starts[c + 1]):
            point_normals[p, 0], point_normals[p, 1], point_normals[p, 2] = x, y, z
            point_variation[p], point_areas[p], point_noise[p] = (
                variation[c],
                area_per_point,
                noise[c],
            )


@kernel(
    "void(i8[::1], i8[::1], f8[:,::1], f8[:,::1], i8, f8, f8[:,::1], f8[::1], f8[::1], f8[::1])"
)
def describe_cells(  # type: ignore[no-untyped-def]
    cell_starts,
    count,
    inner_moments,
    spreads,
    min_points,
    max_variation,
    normals,
    area,
    variation,
    noise,
):
    """Describe the neighbourhood of each cell, given its number of points and eigenvalues.

    The area per point, the variation and the scatter about the plane are written. The normal
    becomes NaN if the points are on a line. For a cell with at least `min_points` points and a
    variation of at most `max_variation`, the scatter within the cell is used if it is smaller.
    """
    for c in range(len(count)):
        smallest_eigenvalue, middle_eigenvalue, largest_eigenvalue = (
            spreads[c, 0],
            spreads[c, 1],
            spreads[c, 2],
        )
        x, y, z = normals[c, 0], normals[c, 1], normals[c, 2]
        # In a disc of area A, the variance along each diameter is A / (4 pi).
        area[c] = (
            4.0 * math.pi * math.sqrt(max(middle_eigenvalue * largest_eigenvalue, 0.0)) / count[c]
        )
        variation[c] = smallest_eigenvalue / max(
            smallest_eigenvalue + middle_eigenvalue + largest_eigenvalue, 1e-300
        )
        variance = smallest_eigenvalue
        points = cell_starts[c + 1] - cell_starts[c]
        if not middle_eigenvalue > 1e-9 * largest_eigenvalue:
            normals[c, 0], normals[c, 1], normals[c, 2] = math.nan, math.nan, math.nan
            x, y, z = 0.0, 0.0, 0.0
        if points >= min_points and variation[c] <= max_variation:
            # The scatter of the neighbourhood includes relief; the scatter within the cell does
            # not.
            scatter = (
                inner_moments[c, 0] * x * x
                + inner_moments[c, 1] * y * y
                + inner_moments[c, 2] * z * z
                + 2.0
                * (
                    inner_moments[c, 3] * x * y
                    + inner_moments[c, 4] * x * z
                    + inner_moments[c, 5] * y * z
                )
            )
            variance = min(variance, scatter * points / max(points - 3.0, 1.0))
        noise[c] = math.sqrt(max(variance, 0.0))
