"""Compiled loops that filter textures."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel, step

MAX_SAMPLES = 16

_ROUNDING = 1e-3
"""Maximum excess of the ratio of length to width over 1 for a footprint treated as a square."""

_BORDER_TOLERANCE_TEXELS = 2.0
"""Tolerance for texture coordinates outside the picture, due to rounding by the writer."""


@step
def _footprint(f, view, faces, uv, width, height, gsd):  # type: ignore[no-untyped-def]
    """Return the constants of a triangle in texels of the finest level, with y down.

    These are the first corner on the texture (x0, y0), the sides (ax, ay) and (bx, by), the lengths
    of the long and the short side of a pixel's footprint, and the direction of the long side.
    """
    p0, p1, p2 = faces[f, 0], faces[f, 1], faces[f, 2]
    x0, y0 = uv[p0, 0] * width, (1.0 - uv[p0, 1]) * height
    ax, ay = uv[p1, 0] * width - x0, (1.0 - uv[p1, 1]) * height - y0
    bx, by = uv[p2, 0] * width - x0, (1.0 - uv[p2, 1]) * height - y0
    # Texels per pixel: [[a, b], [c, d]] (column, row) of the picture to (x, y) of the texture.
    ex, ey = view[p1, 0] - view[p0, 0], view[p1, 1] - view[p0, 1]
    fx, fy = view[p2, 0] - view[p0, 0], view[p2, 1] - view[p0, 1]
    det = ex * fy - ey * fx
    size = math.sqrt((ex * ex + ey * ey) * (fx * fx + fy * fy))
    major, minor, sx, sy = 0.0, 0.0, 0.0, 0.0
    if abs(det) > 1e-9 * size:
        g = gsd / det
        a, b = g * (ax * fy - bx * ey), g * (bx * ex - ax * fx)
        c, d = g * (ay * fy - by * ey), g * (by * ex - ay * fx)
        p, q, r = a * a + b * b, c * c + d * d, a * c + b * d
        root = math.sqrt(0.25 * (p - q) ** 2 + r * r)
        major = math.sqrt(0.5 * (p + q) + root)
        minor = math.sqrt(max(0.5 * (p + q) - root, 0.0))
        if p >= q:
            sx, sy = 0.5 * (p - q) + root, r
        else:
            sx, sy = r, 0.5 * (q - p) + root
        length = math.hypot(sx, sy)
        if length > 0.0:
            sx, sy = sx / length, sy / length
    return x0, y0, ax, ay, bx, by, major, minor, sx, sy


@kernel(
    "void(u1[::1], i8[::1], i8[:,::1], f8, f8, i8[::1], i4[::1], f8[:,::1],"
    " f8[:,::1], i4[:,::1], f4[:,::1], f8, u1[:,::1])",
    fastmath=True,
)
def sample_texture(  # type: ignore[no-untyped-def]
    texels, offsets, sizes, width, height, rows, face, weights, view, faces, uv, gsd, rgb
):
    """Average the texels covered by each pixel.

    The footprint of a pixel on the texture is a parallelogram, which is the same throughout a
    triangle. Its short side selects the two pyramid levels between which the texture is
    interpolated. Up to MAX_SAMPLES samples along its long side are averaged, so that steep faces
    remain sharp across their slope.

    Parameters
    ----------
    texels, offsets, sizes
        Pyramid, stored row by row as RGB. Level k has sizes[k] = (w, h) texels, each covering 2**k
        by 2**k texels of the finest level.
    width, height
        Size of the finest level.
    rows, face, weights
        Pixels with their triangles and barycentric weights.
    view : (n, 3) array
        Vertices with x right and y down, m.
    faces : (m, 3) array
    uv : (n, 2) array
        Texture coordinates with the origin at the lower left.
    gsd : float
    rgb : array
        Output array for the colours.
    """
    levels = len(offsets)
    previous_face = -1
    x0, y0, ax, ay, bx, by = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    major, sx, sy, blend = 0.0, 0.0, 0.0, 0.0
    n, finest_level, is_repeated = 1, 0, False
    for index in range(len(rows)):
        k = rows[index]
        f = face[k]
        if f != previous_face:
            # Adjacent pixels usually belong to the same triangle.
            previous_face = f
            x0, y0, ax, ay, bx, by, major, minor, sx, sy = _footprint(
                f, view, faces, uv, width, height, gsd
            )
            anisotropy = major / max(minor, 1.0) - _ROUNDING
            n = max(int(min(math.ceil(anisotropy), MAX_SAMPLES)), 1)
            level = min(math.log2(max(minor, major / n, 1.0)), levels - 1.0)
            finest_level = int(level)
            blend = level - finest_level
            # If a triangle extends beyond the picture, the picture repeats.
            is_repeated = False
            for corner in range(3):
                for axis in range(2):
                    t = uv[faces[f, corner], axis]
                    margin = _BORDER_TOLERANCE_TEXELS / (height if axis else width)
                    is_repeated |= t < -margin or t > 1.0 + margin
        u, v = weights[k, 0], weights[k, 1]
        x, y = x0 + u * ax + v * bx, y0 + u * ay + v * by
        red, green, blue = 0.0, 0.0, 0.0
        for level_offset in range(2):
            weight = (blend if level_offset else 1.0 - blend) / n
            if weight == 0.0:
                continue
            o = finest_level + level_offset
            w, h, start = sizes[o, 0], sizes[o, 1], offsets[o]
            # This is exact, since it is a power of 2.
            level_scale = 1.0 / (1 << o)
            for i in range(n):
                major_offset = ((i + 0.5) / n - 0.5) * major
                tx, ty = x + major_offset * sx, y + major_offset * sy
                if is_repeated:
                    tx -= width * math.floor(tx / width)
                    ty -= height * math.floor(ty / height)
                # Texel coordinates at this level; (0, 0) is the outer corner.
                tx = min(max(tx * level_scale - 0.5, 0.0), w - 1.0)
                ty = min(max(ty * level_scale - 0.5, 0.0), h - 1.0)
                left, top = int(tx), int(ty)
                fx, fy = tx - left, ty - top
                right, next_row = min(left + 1, w - 1), min(top + 1, h - 1)
                p00, p10 = start + 3 * (top * w + left), start + 3 * (top * w + right)
                p01, p11 = start + 3 * (next_row * w + left), start + 3 * (next_row * w + right)
                w00, w10 = weight * (1 - fx) * (1 - fy), weight * fx * (1 - fy)
                w01, w11 = weight * (1 - fx) * fy, weight * fx * fy
                red += w00 * texels[p00] + w10 * texels[p10] + w01 * texels[p01] + w11 * texels[p11]
                p00, p10, p01, p11 = p00 + 1, p10 + 1, p01 + 1, p11 + 1
                green += (
                    w00 * texels[p00] + w10 * texels[p10] + w01 * texels[p01] + w11 * texels[p11]
                )
                p00, p10, p01, p11 = p00 + 1, p10 + 1, p01 + 1, p11 + 1
                blue += (
                    w00 * texels[p00] + w10 * texels[p10] + w01 * texels[p01] + w11 * texels[p11]
                )
        rgb[k, 0] = int(min(max(red + 0.5, 0.0), 255.0))
        rgb[k, 1] = int(min(max(green + 0.5, 0.0), 255.0))
        rgb[k, 2] = int(min(max(blue + 0.5, 0.0), 255.0))
