"""Compiled inner loops of the map of measurable planes."""

from __future__ import annotations

from vomstudio.geometry.kernels.jit import kernel


@kernel(
    "void(i8[::1], f8[:,::1], f8[:,::1], f8[::1], f8[::1], f8[::1], i8[::1], i8[::1],"
    "f8, f8, f8[:,::1])"
)
def line_moments(  # type: ignore[no-untyped-def]
    rows, coordinates, slopes, steepnesses, areas, resolution, first, last, half_length, width, out
):
    """Compute the moments of the lines along which planes through pieces cut the surface.

    Only the part of a line within `half_length` of the piece is used. The pieces of the surface are
    sorted by coordinates[:, 3] in runs of connected pieces near the plane; the run of piece i
    extends from first[i] to last[i].

    Parameters
    ----------
    rows : (k,) array
        Rows of the pieces for which the line is computed.
    coordinates : (n, 4) array
        Offset along the normal, two coordinates in the plane, and the sort coordinate.
    slopes : (n, 2) array
        Shift of a piece within the plane per unit of offset along the surface.
    steepnesses : (n,) array
        Sine of the angle between the surface and the plane.
    areas, resolution : (n,) arrays
    first, last : (n,) arrays
    half_length, width : float
        Half the length of the line, and half the width of the strip of surface around it.
    out : (k, 9) array
        Results: area of the strip, area-weighted mean of `resolution`, mean (2) and covariance (uu,
        vv, uv) of the line, number of pieces, and share of the largest piece.
    """
    for k in range(len(rows)):
        i = rows[k]
        s, u, v, t = coordinates[i, 0], coordinates[i, 1], coordinates[i, 2], coordinates[i, 3]
        w, wl, wu, wv = 0.0, 0.0, 0.0, 0.0
        uu, vv, uv = 0.0, 0.0, 0.0
        number, largest_area = 0.0, 0.0
        for side in range(2):
            step = 1 if side == 0 else -1
            j = i if side == 0 else i - 1
            while first[i] <= j < last[i]:
                if abs(coordinates[j, 3] - t) > half_length + width:
                    break
                offset = coordinates[j, 0] - s
                if abs(offset) <= width * steepnesses[j]:
                    x = coordinates[j, 1] - u - offset * slopes[j, 0]
                    y = coordinates[j, 2] - v - offset * slopes[j, 1]
                    if x * x + y * y <= half_length * half_length:
                        a = areas[j]
                        w += a
                        wl += a * resolution[j]
                        wu += a * x
                        wv += a * y
                        uu += a * x * x
                        vv += a * y * y
                        uv += a * x * y
                        number += 1.0
                        largest_area = max(largest_area, a)
                j += step
        out[k, 0] = w
        if w > 0.0:
            x, y = wu / w, wv / w
            out[k, 1] = wl / w
            out[k, 2], out[k, 3] = x, y
            out[k, 4], out[k, 5], out[k, 6] = uu / w - x * x, vv / w - y * y, uv / w - x * y
            out[k, 7], out[k, 8] = number, largest_area / w


@kernel("void(f8[:,::1], i8[:,::1], f8[::1])")
def square_longest_sides(vertices, faces, out):  # type: ignore[no-untyped-def]
    """Write the squared length of the longest side of each face (k, 3)."""
    for i in range(len(faces)):
        max_length = 0.0
        for k in range(3):
            a, b = faces[i, k], faces[i, (k + 1) % 3]
            x = vertices[a, 0] - vertices[b, 0]
            y = vertices[a, 1] - vertices[b, 1]
            z = vertices[a, 2] - vertices[b, 2]
            max_length = max(max_length, x * x + y * y + z * z)
        out[i] = max_length


@kernel("void(i4[:,::1], i8[:,::1], i8[::1])")
def cluster_vertices(cells, faces, root):  # type: ignore[no-untyped-def]
    """Cluster the vertices that are connected within one cell.

    `cells` (n, 3) contains the cell indices of each vertex. `root` receives the first vertex of the
    cluster of each vertex.
    """
    for i in range(len(root)):
        root[i] = i
    for i in range(len(faces)):
        for k in range(3):
            a, b = faces[i, k], faces[i, (k + 1) % 3]
            if (
                cells[a, 0] != cells[b, 0]
                or cells[a, 1] != cells[b, 1]
                or cells[a, 2] != cells[b, 2]
            ):
                continue
            while root[a] != a:
                root[a] = root[root[a]]
                a = root[a]
            while root[b] != b:
                root[b] = root[root[b]]
                b = root[b]
            if a < b:
                root[b] = a
            elif b < a:
                root[a] = b
    # Each root is the first vertex of its cluster.
    for i in range(len(root)):
        root[i] = root[root[i]]


@kernel("void(f8[:,::1], i8[:,::1], i8[::1], f8[::1], f8[::1])")
def accumulate_areas(vertices, faces, nodes, out, node_areas):  # type: ignore[no-untyped-def]
    """Write the area of each face (k, 3), and add a third of it to the node of each corner."""
    for i in range(len(faces)):
        a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
        px, py, pz = (
            vertices[b, 0] - vertices[a, 0],
            vertices[b, 1] - vertices[a, 1],
            vertices[b, 2] - vertices[a, 2],
        )
        qx, qy, qz = (
            vertices[c, 0] - vertices[a, 0],
            vertices[c, 1] - vertices[a, 1],
            vertices[c, 2] - vertices[a, 2],
        )
        x, y, z = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
        area = 0.5 * (x * x + y * y + z * z) ** 0.5
        out[i] = area
        for k in range(3):
            node_areas[nodes[faces[i, k]]] += area / 3.0
