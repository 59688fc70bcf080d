"""Parts of kernels that rasterise triangles; the first pixel has its centre at 0.5."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import part


@part
def triangle_frame(ax, ay, bx, by, cx, cy, w, h):  # type: ignore[no-untyped-def]
    """Return the edges, inverse determinant and pixel range of a triangle.

    The edges (ex, ey) and (fx, fy) start at the first corner. The inverse of their determinant
    is 0 for a degenerate triangle. The pixels are i0 to i1 and j0 to j1, inclusive.
    """
    ex, ey, fx, fy = bx - ax, by - ay, cx - ax, cy - ay
    det = ex * fy - ey * fx
    inverse_det = 0.0 if abs(det) < 1e-12 else 1.0 / det
    i0 = max(math.ceil(ax + min(0.0, ex, fx) - 0.5), 0)
    i1 = min(math.floor(ax + max(0.0, ex, fx) - 0.5), w - 1)
    j0 = max(math.ceil(ay + min(0.0, ey, fy) - 0.5), 0)
    j1 = min(math.floor(ay + max(0.0, ey, fy) - 0.5), h - 1)
    return ex, ey, fx, fy, inverse_det, i0, i1, j0, j1


@part
def barycentric_weights(i, j, ax, ay, ex, ey, fx, fy, inverse_det):  # type: ignore[no-untyped-def]
    """Return the weights of the second and third corner at the centre of a pixel."""
    x, y = i + 0.5 - ax, j + 0.5 - ay
    return (x * fy - y * fx) * inverse_det, (ex * y - ey * x) * inverse_det
