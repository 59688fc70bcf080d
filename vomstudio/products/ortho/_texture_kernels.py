"""Compiled filtering of textures."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel, part

MAX_SAMPLES = 16

_OUTSIDE_TEXELS = 2.0
"""Texture coordinates this little beyond the picture are rounding of whoever wrote them."""


@part
def _add_bilinear(texels, at, w, h, x, y, weight, total):  # type: ignore[no-untyped-def]
    """Add the colour at (x, y), texels of this level, y down, (0, 0) the outer corner."""
    x = min(max(x - 0.5, 0.0), w - 1.0)
    y = min(max(y - 0.5, 0.0), h - 1.0)
    i, j = int(x), int(y)
    fx, fy = x - i, y - j
    i1, j1 = min(i + 1, w - 1), min(j + 1, h - 1)
    p00, p10 = at + 3 * (j * w + i), at + 3 * (j * w + i1)
    p01, p11 = at + 3 * (j1 * w + i), at + 3 * (j1 * w + i1)
    w00, w10 = weight * (1 - fx) * (1 - fy), weight * fx * (1 - fy)
    w01, w11 = weight * (1 - fx) * fy, weight * fx * fy
    for c in range(3):
        total[c] += (
            w00 * texels[p00 + c]
            + w10 * texels[p10 + c]
            + w01 * texels[p01 + c]
            + w11 * texels[p11 + c]
        )


@kernel(
    "void(u1[::1], i8[::1], i8[:,::1], f8, f8, i8[::1], i4[::1], f8[:,::1],"
    " f8[:,::1], i4[:,::1], f4[:,::1], f8, u1[:,::1], f8[::1])"
)
def sample(  # type: ignore[no-untyped-def]
    texels, offsets, sizes, width, height, rows, face, weights, view, faces, uv, gsd, rgb, sums
):
    """Colours of the pixels `rows`, averaged over the texels that each pixel covers.

    A pixel's footprint on the texture is a parallelogram, the same all over a triangle. Its short
    side chooses the level of the pyramid, between two of which is interpolated; along its long side
    up to MAX_SAMPLES samples are averaged, so that steep faces stay sharp across their slope.

    texels, offsets, sizes : the pyramid, row by row, RGB; level k has sizes[k] = (w, h) texels of
    2**k by 2**k of the finest, which is width x height
    view : (n, 3) vertices, x right, y down in metres. uv : (n, 2), origin lower left
    sums : (3,) to work with
    """
    levels = len(offsets)
    for at in range(len(rows)):
        k = rows[at]
        f = face[k]
        p0, p1, p2 = faces[f, 0], faces[f, 1], faces[f, 2]
        x0, y0 = uv[p0, 0] * width, (1.0 - uv[p0, 1]) * height
        ax, ay = uv[p1, 0] * width - x0, (1.0 - uv[p1, 1]) * height - y0
        bx, by = uv[p2, 0] * width - x0, (1.0 - uv[p2, 1]) * height - y0
        u, v = weights[k, 0], weights[k, 1]
        x, y = x0 + u * ax + v * bx, y0 + u * ay + v * by
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
        n = int(min(math.ceil(major / max(minor, 1.0)), MAX_SAMPLES))
        n = max(n, 1)
        level = math.log2(max(minor, major / n, 1.0))
        level = min(level, levels - 1.0)
        fine = int(level)
        blend = level - fine
        # A triangle that reaches beyond the picture repeats it.
        repeat = False
        for corner in range(3):
            for axis in range(2):
                t = uv[faces[f, corner], axis]
                beyond = _OUTSIDE_TEXELS / (height if axis else width)
                repeat |= t < -beyond or t > 1.0 + beyond
        sums[0] = sums[1] = sums[2] = 0.0
        for i in range(n):
            along = ((i + 0.5) / n - 0.5) * major
            tx, ty = x + along * sx, y + along * sy
            if repeat:
                tx, ty = tx - width * math.floor(tx / width), ty - height * math.floor(ty / height)
            for step in range(2):
                weight = (blend if step else 1.0 - blend) / n
                if weight == 0.0:
                    continue
                o = fine + step
                _add_bilinear(
                    texels, offsets[o], sizes[o, 0], sizes[o, 1],
                    tx / 2.0**o, ty / 2.0**o, weight, sums,
                )  # fmt: skip
        for c in range(3):
            rgb[k, c] = int(min(max(sums[c] + 0.5, 0.0), 255.0))
