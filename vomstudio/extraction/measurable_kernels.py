"""Compiled inner loop of the map of how well a plane could be measured."""

from __future__ import annotations

from vomstudio.geometry.kernels.jit import kernel


@kernel(
    "void(i8[::1], f8[:,::1], f8[:,::1], f8[::1], f8[::1], f8[::1], i8[::1], i8[::1],"
    "f8, f8, f8[:,::1])"
)
def line_moments(  # type: ignore[no-untyped-def]
    rows, own, slopes, steepness, areas, resolution, first, last, half, width, out
):
    """Moments of the line along which a plane through each of the places `rows` cuts the surface,
    within `half` of it.

    Pieces of the surface come in runs, first[i] to last[i] of piece i, of those that hang together
    near its plane, in the order of own[:, 3]. own : (n, 4) offset along the normal, two coordinates
    in the plane, and the coordinate that orders; slopes : (n, 2) how far a piece moves in the plane
    where it is brought to an offset higher by one along the surface; steepness : sine of the angle
    between surface and plane. A strip of the surface of `width` either side of the line counts.
    out : (len(rows), 9) area of the strip, mean of `resolution` by area, and mean and
    covariance (uu, vv, uv) of the line; number of pieces; the longest of them as a share
    """
    for at in range(len(rows)):
        i = rows[at]
        s, u, v, t = own[i, 0], own[i, 1], own[i, 2], own[i, 3]
        w, wl, wu, wv = 0.0, 0.0, 0.0, 0.0
        uu, vv, uv = 0.0, 0.0, 0.0
        number, most = 0.0, 0.0
        for way in range(2):
            step = 1 if way == 0 else -1
            j = i if way == 0 else i - 1
            while first[i] <= j < last[i]:
                if abs(own[j, 3] - t) > half + width:
                    break
                off = own[j, 0] - s
                if abs(off) <= width * steepness[j]:
                    x = own[j, 1] - u - off * slopes[j, 0]
                    y = own[j, 2] - v - off * slopes[j, 1]
                    if x * x + y * y <= half * half:
                        a = areas[j]
                        w += a
                        wl += a * resolution[j]
                        wu += a * x
                        wv += a * y
                        uu += a * x * x
                        vv += a * y * y
                        uv += a * x * y
                        number += 1.0
                        most = max(most, a)
                j += step
        out[at, 0] = w
        if w > 0.0:
            x, y = wu / w, wv / w
            out[at, 1] = wl / w
            out[at, 2], out[at, 3] = x, y
            out[at, 4], out[at, 5], out[at, 6] = uu / w - x * x, vv / w - y * y, uv / w - x * y
            out[at, 7], out[at, 8] = number, most / w


@kernel("void(f8[:,::1], i8[:,::1], f8[::1])")
def longest_sides(vertices, faces, out):  # type: ignore[no-untyped-def]
    """Of each face (k, 3) the square of its longest side."""
    for i in range(len(faces)):
        most = 0.0
        for k in range(3):
            a, b = faces[i, k], faces[i, (k + 1) % 3]
            x = vertices[a, 0] - vertices[b, 0]
            y = vertices[a, 1] - vertices[b, 1]
            z = vertices[a, 2] - vertices[b, 2]
            most = max(most, x * x + y * y + z * z)
        out[i] = most


@kernel("void(i4[:,::1], i8[:,::1], i8[::1])")
def clustered(cells, faces, root):  # type: ignore[no-untyped-def]
    """Of each vertex the first of those that hang together with it along edges of the faces (k, 3)
    whose ends are in one cell (n, 3)."""
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
    # The first of each comes before all others.
    for i in range(len(root)):
        root[i] = root[root[i]]


@kernel("void(f8[:,::1], i8[:,::1], i8[::1], f8[::1], f8[::1])")
def areas_of(vertices, faces, nodes, out, around):  # type: ignore[no-untyped-def]
    """Area of each face (k, 3), of which a third is added to the node of each of its corners."""
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
            around[nodes[faces[i, k]]] += area / 3.0
