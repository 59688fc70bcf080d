"""Compiled kernels for texture atlases."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel
from vomstudio.photogrammetry.surface._triangle_parts import barycentric_weights, triangle_frame


@kernel("void(f8[:,::1], f8[:,::1], i4[:,::1], f8[:,::1], f8, f8, i8, i4[::1])")
def assign_labels(  # type: ignore[no-untyped-def]
    smoothed_normals,
    exact_normals,
    neighbour_faces,
    directions,
    min_cosine,
    equal_label_gain,
    max_sweeps,
    labels,
):
    """Assign each face the direction that suits it and its neighbours.

    The labels are optimised by iterated conditional modes.

    smoothed_normals, exact_normals : normals (m, 3), averaged over a neighbourhood and exact
    min_cosine : minimum cosine between a face and its direction
    equal_label_gain : gain if both faces of an edge have the same label
    """
    direction_count = len(directions)
    for _ in range(max_sweeps):
        changed_count = 0
        for f in range(len(labels)):
            best_score, best_label = -1e9, labels[f]
            for d in range(direction_count):
                ex, ey, ez = directions[d, 0], directions[d, 1], directions[d, 2]
                score = (
                    smoothed_normals[f, 0] * ex
                    + smoothed_normals[f, 1] * ey
                    + smoothed_normals[f, 2] * ez
                )
                cosine = (
                    exact_normals[f, 0] * ex + exact_normals[f, 1] * ey + exact_normals[f, 2] * ez
                )
                if cosine < min_cosine:
                    score -= 4.0 * (min_cosine - cosine) + 0.5
                for side in range(3):
                    g = neighbour_faces[f, side]
                    if g >= 0 and labels[g] == d:
                        score += equal_label_gain
                if score > best_score + 1e-12:
                    best_score, best_label = score, d
            if best_label != labels[f]:
                labels[f] = best_label
                changed_count += 1
        if changed_count == 0:
            break


@kernel("void(f8[:,:,::1], i4[::1], i4[:,::1], b1[::1])")
def find_overlap(corners, members, grid, is_overlapping):  # type: ignore[no-untyped-def]
    """Draw faces into a grid of texels (-1 if free), and mark faces that overlap others.

    corners : (m, 3, 2) corners of all faces in texels, x right and y down
    members : rows of the faces to draw
    """
    h, w = grid.shape
    for k in range(len(members)):
        f = members[k]
        ax, ay = corners[f, 0, 0], corners[f, 0, 1]
        bx, by = corners[f, 1, 0], corners[f, 1, 1]
        cx, cy = corners[f, 2, 0], corners[f, 2, 1]
        ex, ey, fx, fy, inverse_det, i0, i1, j0, j1 = triangle_frame(ax, ay, bx, by, cx, cy, w, h)
        if inverse_det == 0.0:
            continue
        has_overlap = False
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                u, v = barycentric_weights(i, j, ax, ay, ex, ey, fx, fy, inverse_det)
                if u > 1e-6 and v > 1e-6 and u + v < 1 - 1e-6 and grid[j, i] >= 0:
                    has_overlap = True
        if has_overlap:
            is_overlapping[f] = True
            continue
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                u, v = barycentric_weights(i, j, ax, ay, ex, ey, fx, fy, inverse_det)
                if u >= -1e-9 and v >= -1e-9 and u + v <= 1 + 1e-9:
                    grid[j, i] = f


@kernel("void(f8[:,:,::1], i4[::1], f8, f8, f8, b1[:,::1])")
def mark_covered_cells(corners, members, shift, gutter, cell_size, cells):  # type: ignore[no-untyped-def]
    """Mark the cells, `cell_size` texels wide, that faces and their gutters touch.

    shift : offset added to the corners, in texels
    """
    h, w = cells.shape
    for index in range(len(members)):
        f = members[index]
        ax, ay = corners[f, 0, 0] + shift, corners[f, 0, 1] + shift
        bx, by = corners[f, 1, 0] + shift, corners[f, 1, 1] + shift
        cx, cy = corners[f, 2, 0] + shift, corners[f, 2, 1] + shift
        i0 = max(math.floor((min(ax, bx, cx) - gutter) / cell_size), 0)
        i1 = min(math.floor((max(ax, bx, cx) + gutter) / cell_size), w - 1)
        j0 = max(math.floor((min(ay, by, cy) - gutter) / cell_size), 0)
        j1 = min(math.floor((max(ay, by, cy) + gutter) / cell_size), h - 1)
        det = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        sign = 1.0 if det >= 0 else -1.0
        half_side = 0.5 * cell_size + gutter
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                if cells[j, i]:
                    continue
                mx, my = (i + 0.5) * cell_size, (j + 0.5) * cell_size
                # The square is outside if all of it is beyond one edge.
                is_outside = False
                for k in range(3):
                    if k == 0:
                        px, py, qx, qy = ax, ay, bx, by
                    elif k == 1:
                        px, py, qx, qy = bx, by, cx, cy
                    else:
                        px, py, qx, qy = cx, cy, ax, ay
                    dx, dy = sign * (qx - px), sign * (qy - py)
                    value = dx * (my - py) - dy * (mx - px)
                    if value + half_side * (abs(dx) + abs(dy)) < 0:
                        is_outside = True
                        break
                if not is_outside:
                    cells[j, i] = True


@kernel("i8(b1[:,::1], b1[:,::1], i8, i8)")
def find_chart_position(page, chart, first_row, last_row):  # type: ignore[no-untyped-def]
    """Return the first free position of a chart on a page: row * width + column, or -1."""
    h, w = chart.shape
    column_count = page.shape[1]
    for j in range(first_row, min(last_row, page.shape[0] - h) + 1):
        for i in range(column_count - w + 1):
            is_free = True
            for y in range(h):
                for x in range(w):
                    if chart[y, x] and page[j + y, i + x]:
                        is_free = False
                        break
                if not is_free:
                    break
            if is_free:
                return j * column_count + i
    return -1
