"""Compiled loops over the cells of a cloud and their points, which stand sorted by cells: the
points of cell c are points[begins[c]:begins[c + 1]]."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel

_FEW = 4
"""A cell with so many times fewer points than its neighbour is clutter beside it."""


@kernel(
    "void(f8[:,::1], i8[::1], i8[::1], i4[::1], i4[::1], f8[:,::1], f8[::1], f8, f8[:,::1],"
    "f8[:,::1], f8[::1], i4[::1], b1[::1])"
)
def hand_down(  # type: ignore[no-untyped-def]
    points,
    begins,
    starts,
    near,
    labels,
    normals,
    reach,
    least_cosine,
    centres,
    facing,
    limits,
    out,
    open_,
):
    """Give points to the nearest plane among those of their cell and of the cells around, or to
    none.

    labels (cells,) : facet of each cell, below 0 for none; centres, facing (f, 3), limits (f,) :
    of the facets' planes. open_ becomes whether a point must be looked at by itself: where cells
    around are of several facets or, with more than stray points, of none, or where the point is off
    its cell's plane.
    """
    for c in range(len(begins) - 1):
        one = labels[c]
        mixed = one < 0
        known = not mixed
        for at in range(starts[c], starts[c + 1]):
            other = labels[near[at]]
            if other >= 0:
                known = True
            elif _FEW * (begins[near[at] + 1] - begins[near[at]]) < begins[c + 1] - begins[c]:
                continue
            if other != one:
                mixed = True
        for p in range(begins[c], begins[c + 1]):
            out[p] = -1
            open_[p] = True
            if not known:
                continue
            best, least = -1, math.inf
            for at in range(starts[c] - 1, starts[c + 1]):
                f = one if at < starts[c] else labels[near[at]]
                if f < 0 or f == best:
                    continue
                off = abs(
                    (points[p, 0] - centres[f, 0]) * facing[f, 0]
                    + (points[p, 1] - centres[f, 1]) * facing[f, 1]
                    + (points[p, 2] - centres[f, 2]) * facing[f, 2]
                )
                limit = min(reach[c], limits[f])
                if f != one:
                    cosine = abs(
                        normals[c, 0] * facing[f, 0]
                        + normals[c, 1] * facing[f, 1]
                        + normals[c, 2] * facing[f, 2]
                    )
                    if not cosine >= least_cosine:
                        limit *= 0.5
                if off <= limit and off < least:
                    best, least = f, off
            out[p] = best
            open_[p] = mixed or best < 0


@kernel("void(i8[::1], f8[:,::1], f8[::1], f8[::1], f8[::1], f8[:,::1], f8[::1], f8[::1], f8[::1])")
def to_points(  # type: ignore[no-untyped-def]
    begins, normals, variation, areas, noise, own_normals, own_variation, own_areas, own_noise
):
    """Give each point what its cell has, and its share of the area."""
    for c in range(len(begins) - 1):
        x, y, z = normals[c, 0], normals[c, 1], normals[c, 2]
        share = areas[c] / (begins[c + 1] - begins[c])
        for p in range(begins[c], begins[c + 1]):
            own_normals[p, 0], own_normals[p, 1], own_normals[p, 2] = x, y, z
            own_variation[p], own_areas[p], own_noise[p] = variation[c], share, noise[c]


@kernel(
    "void(i8[::1], i8[::1], f8[:,::1], f8[:,::1], i8, f8, f8[:,::1], f8[::1], f8[::1], f8[::1])"
)
def cell_figures(  # type: ignore[no-untyped-def]
    begins, count, inner, spreads, fewest, thin, normals, area, variation, noise
):
    """Of each cell the area that a point stands for, the variation and the scatter about the plane
    of its surroundings, with their number of points and eigenvalues; points on a line tell no
    normal. fewest, thin : with so many points, and so flat, a cell tells its scatter itself"""
    for c in range(len(count)):
        least, middle, most = spreads[c, 0], spreads[c, 1], spreads[c, 2]
        x, y, z = normals[c, 0], normals[c, 1], normals[c, 2]
        # Of a disc of area A the variance along each diameter is A / (4 pi).
        area[c] = 4.0 * math.pi * math.sqrt(max(middle * most, 0.0)) / count[c]
        variation[c] = least / max(least + middle + most, 1e-300)
        square = least
        points = begins[c + 1] - begins[c]
        if not middle > 1e-9 * most:
            normals[c, 0], normals[c, 1], normals[c, 2] = math.nan, math.nan, math.nan
            x, y, z = 0.0, 0.0, 0.0
        if points >= fewest and variation[c] <= thin:
            # The scatter around is also relief, but where the cell cuts it.
            own = (
                inner[c, 0] * x * x
                + inner[c, 1] * y * y
                + inner[c, 2] * z * z
                + 2.0 * (inner[c, 3] * x * y + inner[c, 4] * x * z + inner[c, 5] * y * z)
            )
            square = min(square, own * points / max(points - 3.0, 1.0))
        noise[c] = math.sqrt(max(square, 0.0))
