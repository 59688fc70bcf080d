"""Compiled tests whether elements are inside a shape drawn over the picture.

Optionally, an element must also be visible. The functions write only to `out`.
"""

from __future__ import annotations

from vomstudio.geometry.kernels.jit import kernel, step


@step
def _is_inside(x, y, z, m, scale, is_parallel, shape, max_depths, depth_tolerance):  # type: ignore[no-untyped-def]
    """Return whether a point is inside the shape and not hidden.

    `m` (3, 4) transforms from the file frame to right, up and depth in front of the eye. `scale` is
    the number of pixels per metre at depth 1, or at any depth in a parallel view. `shape` (h, w) is
    non-zero inside. `max_depths` (h, w) is the depth beyond which a point is hidden; if it is
    empty, no point is hidden.
    """
    depth = m[2, 0] * x + m[2, 1] * y + m[2, 2] * z + m[2, 3]
    if not depth > 0.0:
        return False
    s = scale if is_parallel else scale / depth
    height, width = shape.shape
    column = 0.5 * width + s * (m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3])
    row = 0.5 * height - s * (m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3])
    # A comparison with NaN is false.
    if not (column >= 0.0 and column < width and row >= 0.0 and row < height):
        return False
    i, j = int(row), int(column)
    if shape[i, j] == 0:
        return False
    return len(max_depths) == 0 or depth <= max_depths[i, j] + depth_tolerance


@kernel("void(f8[:,::1], f8[:,::1], f8, b1, u1[:,::1], f4[:,::1], f8, b1[::1])")
def select_points_in_shape(  # type: ignore[no-untyped-def]
    points, m, scale, is_parallel, shape, max_depths, depth_tolerance, out
):
    """Test points (n, 3). See `_is_inside`."""
    for p in range(len(points)):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        out[p] = _is_inside(x, y, z, m, scale, is_parallel, shape, max_depths, depth_tolerance)


@kernel("void(f8[:,::1], i4[:,::1], f8[:,::1], f8, b1, u1[:,::1], f4[:,::1], f8, b1[::1])")
def select_faces_in_shape(  # type: ignore[no-untyped-def]
    vertices, faces, m, scale, is_parallel, shape, max_depths, depth_tolerance, out
):
    """Test the centroids of faces (n, 3). See `_is_inside`."""
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        x = (vertices[a, 0] + vertices[b, 0] + vertices[c, 0]) / 3.0
        y = (vertices[a, 1] + vertices[b, 1] + vertices[c, 1]) / 3.0
        z = (vertices[a, 2] + vertices[b, 2] + vertices[c, 2]) / 3.0
        out[f] = _is_inside(x, y, z, m, scale, is_parallel, shape, max_depths, depth_tolerance)
