"""Compiled loops over the cells of a cloud and their points, which stand sorted by cells: the
points of cell c are points[begins[c]:begins[c + 1]]."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.cells import eigen_of
from vomstudio.geometry.kernels.jit import kernel

_FEW = 4
"""A cell with so many times fewer points than its neighbour is clutter beside it."""


@kernel("void(f8[:,::1], i8[::1], f8[:,::1], f8[:,::1])")
def cell_moments(points, begins, means, inner):  # type: ignore[no-untyped-def]
    """Of each cell's points the mean, and the covariance about it (xx, yy, zz, xy, xz, yz)."""
    for c in range(len(begins) - 1):
        first, last = begins[c], begins[c + 1]
        n = last - first
        x, y, z = points[first, 0], points[first, 1], points[first, 2]
        sx, sy, sz = 0.0, 0.0, 0.0
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for p in range(first + 1, last):
            dx, dy, dz = points[p, 0] - x, points[p, 1] - y, points[p, 2] - z
            sx, sy, sz = sx + dx, sy + dy, sz + dz
            xx, yy, zz = xx + dx * dx, yy + dy * dy, zz + dz * dz
            xy, xz, yz = xy + dx * dy, xz + dx * dz, yz + dy * dz
        sx, sy, sz = sx / n, sy / n, sz / n
        means[c, 0], means[c, 1], means[c, 2] = x + sx, y + sy, z + sz
        inner[c, 0], inner[c, 1], inner[c, 2] = (
            xx / n - sx * sx, yy / n - sy * sy, zz / n - sz * sz
        )  # fmt: skip
        inner[c, 3], inner[c, 4], inner[c, 5] = (
            xy / n - sx * sy, xz / n - sx * sz, yz / n - sy * sz
        )  # fmt: skip


@kernel(
    "void(i8, i8, i8[::1], f8[:,::1], f8[:,::1], i8[::1], i4[::1], i8[::1], f8[:,::1], f8[:,::1])"
)
def block_planes(  # type: ignore[no-untyped-def]
    first, last, begins, means, inner, starts, near, count, normals, spreads
):
    """Of the points in each of the cells first to last and those around it: how many, the unit
    normal of their plane, and the eigenvalues of their covariance, from the least on."""
    for c in range(first, last):
        x, y, z = means[c, 0], means[c, 1], means[c, 2]
        n = 0.0
        sx, sy, sz = 0.0, 0.0, 0.0
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for at in range(starts[c] - 1, starts[c + 1]):
            o = c if at < starts[c] else near[at]
            w = float(begins[o + 1] - begins[o])
            dx, dy, dz = means[o, 0] - x, means[o, 1] - y, means[o, 2] - z
            n += w
            sx, sy, sz = sx + w * dx, sy + w * dy, sz + w * dz
            xx, yy = xx + w * (dx * dx + inner[o, 0]), yy + w * (dy * dy + inner[o, 1])
            zz, xy = zz + w * (dz * dz + inner[o, 2]), xy + w * (dx * dy + inner[o, 3])
            xz, yz = xz + w * (dx * dz + inner[o, 4]), yz + w * (dy * dz + inner[o, 5])
        sx, sy, sz = sx / n, sy / n, sz / n
        found = eigen_of(
            xx / n - sx * sx, yy / n - sy * sy, zz / n - sz * sz,
            xy / n - sx * sy, xz / n - sx * sz, yz / n - sy * sz,
        )  # fmt: skip
        count[c] = int(n)
        normals[c, 0], normals[c, 1], normals[c, 2] = found[0], found[1], found[2]
        spreads[c, 0], spreads[c, 1], spreads[c, 2] = max(found[3], 0.0), found[4], found[5]


@kernel(
    "void(f8[:,::1], i8[::1], i8[::1], i4[::1], i4[::1], f8[:,::1], f8[::1], f8, f8[:,::1],"
    "f8[:,::1], f8[::1], i4[::1], b1[::1])"
)
def hand_down(  # type: ignore[no-untyped-def]
    points, begins, starts, near, labels, normals, reach, least_cosine, centres, facing, limits,
    out, open_
):  # fmt: skip
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
