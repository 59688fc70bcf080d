"""Compiled kernels for textures."""

from __future__ import annotations

from vomstudio.geometry.kernels.jit import kernel, part
from vomstudio.photogrammetry.surface._triangle_parts import barycentric_weights, triangle_frame


@kernel("void(i4[::1], i4[::1], f4[::1], i4[:,::1], i8, f4[::1])")
def smooth_quality(starts, views, quality, neighbour_faces, rounds, scratch):  # type: ignore[no-untyped-def]
    """Average the qualities of each view over neighbouring faces that it sees.

    Entries of face f are starts[f] to starts[f + 1], sorted by view; `scratch` is as long as
    `quality`.
    """
    for _ in range(rounds):
        for f in range(len(neighbour_faces)):
            for e in range(starts[f], starts[f + 1]):
                total, weight = 2.0 * quality[e], 2.0
                for side in range(3):
                    g = neighbour_faces[f, side]
                    if g < 0:
                        continue
                    for o in range(starts[g], starts[g + 1]):
                        if views[o] == views[e]:
                            total += quality[o]
                            weight += 1.0
                            break
                scratch[e] = total / weight
        for e in range(len(quality)):
            quality[e] = scratch[e]


@kernel("void(i4[::1], i4[::1], f4[::1], i4[:,::1], f8, i8, i4[::1])")
def choose_views(starts, views, quality, neighbour_faces, equal_view_gain, max_sweeps, labels):  # type: ignore[no-untyped-def]
    """Select the view from which each face is drawn, or -1 if no view shows the face.

    The view maximises its quality relative to the best view of the face, plus `equal_view_gain` for
    each neighbour with the same view (iterated conditional modes).
    """
    for sweep in range(max_sweeps):
        changed_count = 0
        for f in range(len(labels)):
            start, stop = starts[f], starts[f + 1]
            if start == stop:
                labels[f] = -1
                continue
            max_quality = 1e-20
            for e in range(start, stop):
                max_quality = max(max_quality, quality[e])
            best_quality, best_view = -1.0, labels[f]
            for e in range(start, stop):
                value = quality[e] / max_quality
                if sweep > 0:
                    for side in range(3):
                        g = neighbour_faces[f, side]
                        if g >= 0 and labels[g] == views[e]:
                            value += equal_view_gain
                if value > best_quality + 1e-9:
                    best_quality, best_view = value, views[e]
            if best_view != labels[f]:
                labels[f] = best_view
                changed_count += 1
        if changed_count == 0:
            break


@kernel("void(i4[::1], i4[::1], i4[::1], b1[::1], f4[:,::1], f4[:,::1], i8)")
def diffuse(starts, links, vertices, is_counted, values, scratch, rounds):  # type: ignore[no-untyped-def]
    """Average the values of the given vertices with those of their counted neighbours.

    Other vertices are unchanged. `scratch` (len(vertices), c) is working space.
    """
    channels = values.shape[1]
    for _ in range(rounds):
        for k in range(len(vertices)):
            v = vertices[k]
            count = 1.0
            for c in range(channels):
                scratch[k, c] = values[v, c]
            for index in range(starts[v], starts[v + 1]):
                o = links[index]
                if is_counted[o]:
                    count += 1.0
                    for c in range(channels):
                        scratch[k, c] += values[o, c]
            for c in range(channels):
                scratch[k, c] /= count
        for k in range(len(vertices)):
            for c in range(channels):
                values[vertices[k], c] = scratch[k, c]


@kernel("void(i4[::1], i4[::1], b1[::1], f4[:,::1], i4[::1])")
def fill_outward(starts, links, is_known, values, queue):  # type: ignore[no-untyped-def]
    """Assign unknown vertices the mean of their known neighbours, ring by ring.

    `queue` (n,) is working space.
    """
    n = len(is_known)
    count = 0
    for v in range(n):
        if is_known[v]:
            queue[count] = v
            count += 1
    position = 0
    while position < count:
        v = queue[position]
        position += 1
        for k in range(starts[v], starts[v + 1]):
            o = links[k]
            if is_known[o]:
                continue
            total = 0.0
            for c in range(values.shape[1]):
                values[o, c] = 0.0
            for j in range(starts[o], starts[o + 1]):
                p = links[j]
                if is_known[p]:
                    total += 1.0
                    for c in range(values.shape[1]):
                        values[o, c] += values[p, c]
            for c in range(values.shape[1]):
                values[o, c] /= total
            is_known[o] = True
            queue[count] = o
            count += 1


@part
def _sort_values(values, count):  # type: ignore[no-untyped-def]
    """Sort the first `count` values by Shell's method (Knuth, 1998, vol. 3, sec. 5.2.1).

    NumPy's method would allocate memory, which requires Numba's runtime.
    """
    gap = 1
    while 3 * gap + 1 < count:
        gap = 3 * gap + 1
    while gap > 0:
        for i in range(gap, count):
            value, k = values[i], i
            while k >= gap and values[k - gap] > value:
                values[k] = values[k - gap]
                k -= gap
            values[k] = value
        gap //= 3


@kernel("void(i4[::1], f4[:,::1], f4[::1], f4[::1], f4[::1])")
def median_distances(starts, colors, distance, deviation, values):  # type: ignore[no-untyped-def]
    """Compute the distances of colours from the median colour of their vertex.

    The deviation is the median of these distances. Both are those of the worst channel, and 0 for
    vertices with fewer than three entries. `values` is working space for the entries of a vertex.
    """
    for v in range(len(starts) - 1):
        start, stop = starts[v], starts[v + 1]
        n = stop - start
        for e in range(start, stop):
            distance[e] = 0.0
            deviation[e] = 0.0
        if n < 3:
            continue
        for c in range(3):
            for k in range(n):
                values[k] = colors[start + k, c]
            _sort_values(values, n)
            median_color = 0.5 * (values[(n - 1) // 2] + values[n // 2])
            for k in range(n):
                values[k] = abs(values[k] - median_color)
            _sort_values(values, n)
            # Use the nearer half, so that outliers do not widen the spread.
            median_deviation = values[(n - 1) // 2]
            for e in range(start, stop):
                distance[e] = max(distance[e], abs(colors[e, c] - median_color))
                deviation[e] = max(deviation[e], median_deviation)


@kernel("void(f8[:,:,::1], f8, f8, i4[:,::1])")
def draw_faces(corners, left, top, texel_faces):  # type: ignore[no-untyped-def]
    """Set the face at each texel's centre; `texel_faces` must be initialised with -1."""
    h, w = texel_faces.shape
    for f in range(len(corners)):
        ax, ay = corners[f, 0, 0] - left, corners[f, 0, 1] - top
        bx, by = corners[f, 1, 0] - left, corners[f, 1, 1] - top
        cx, cy = corners[f, 2, 0] - left, corners[f, 2, 1] - top
        ex, ey, fx, fy, inverse_det, i0, i1, j0, j1 = triangle_frame(ax, ay, bx, by, cx, cy, w, h)
        if inverse_det == 0.0:
            continue
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                u, v = barycentric_weights(i, j, ax, ay, ex, ey, fx, fy, inverse_det)
                if u >= -1e-9 and v >= -1e-9 and u + v <= 1.0 + 1e-9 and texel_faces[j, i] < 0:
                    texel_faces[j, i] = f


@kernel("void(i4[:,::1], i4[:,::1], i8)")
def grow_faces(texel_faces, scratch, rounds):  # type: ignore[no-untyped-def]
    """Extend faces to the texels around them, for the gutter."""
    h, w = texel_faces.shape
    for _ in range(rounds):
        for j in range(h):
            for i in range(w):
                face = texel_faces[j, i]
                if face < 0:
                    for q in range(8):
                        k = q if q < 4 else q + 1
                        y, x = j + k // 3 - 1, i + k % 3 - 1
                        if 0 <= y < h and 0 <= x < w and texel_faces[y, x] >= 0:
                            face = texel_faces[y, x]
                            break
                scratch[j, i] = face
        for j in range(h):
            for i in range(w):
                texel_faces[j, i] = scratch[j, i]


@part
def _cubic_weight(t):  # type: ignore[no-untyped-def]
    """Return the weight of a cubic convolution at distance t (Keys 1981, a = -1/2)."""
    t = abs(t)
    if t < 1.0:
        return 1.0 + t * t * (1.5 * t - 2.5)
    if t < 2.0:
        return 2.0 - t * (4.0 - t * (2.5 - 0.5 * t))
    return 0.0


@kernel(
    "void(i4[:,::1], f8[:,:,::1], f8, f8, i4[::1], f4[:,:,::1], f4[:,::1], f4[:,::1],"
    " f4[:,:,::1], i4[::1], i8, u1[:,:,::1], f8[::1], f8, f4[:,:,::1])"
)
def add_view(  # type: ignore[no-untyped-def]
    texel_faces,
    corners,
    left,
    top,
    entry_rows,
    pixels,
    depths,
    weights,
    offsets,
    level,
    drawn_level,
    picture,
    gain,
    seam_exponent,
    total,
):
    """Add one view's colours to the texels whose faces are drawn from it.

    texel_faces : (h, w) face of each texel
    corners : (m, 3, 2) corners of the faces on the page
    entry_rows : (m,) row of the face in the arrays below, -1 if it is not drawn from this view
    pixels, depths, weights, offsets : (e, 3, 2), (e, 3), (e, 3), (e, 3, 3) values at the corners
    level : (e,) pyramid level of each face; only faces of `drawn_level` are drawn
    picture : BGR picture at `drawn_level`
    total : (h, w, 4) sums of RGB and of weights
    """
    h, w = texel_faces.shape
    height, width = picture.shape[0], picture.shape[1]
    scale = 1.0 / 2.0**drawn_level
    for j in range(h):
        for i in range(w):
            f = texel_faces[j, i]
            if f < 0:
                continue
            e = entry_rows[f]
            if e < 0 or level[e] != drawn_level:
                continue
            ax, ay = corners[f, 0, 0], corners[f, 0, 1]
            ex, ey = corners[f, 1, 0] - ax, corners[f, 1, 1] - ay
            fx, fy = corners[f, 2, 0] - ax, corners[f, 2, 1] - ay
            det = ex * fy - ey * fx
            x, y = left + i + 0.5 - ax, top + j + 0.5 - ay
            u = (x * fy - y * fx) / det
            v = (ex * y - ey * x) / det
            t = 1.0 - u - v
            # In the gutter beyond the face, use the weights of its border.
            cu, cv = min(max(u, 0.0), 1.0), min(max(v, 0.0), 1.0)
            ct = min(max(t, 0.0), 1.0)
            weight_sum = ct + cu + cv
            ct, cu, cv = ct / weight_sum, cu / weight_sum, cv / weight_sum
            weight = ct * weights[e, 0] + cu * weights[e, 1] + cv * weights[e, 2]
            if weight <= 1e-6:
                continue
            weight = weight**seam_exponent
            za, zb, zc = t * depths[e, 0], u * depths[e, 1], v * depths[e, 2]
            z = za + zb + zc
            px = (za * pixels[e, 0, 0] + zb * pixels[e, 1, 0] + zc * pixels[e, 2, 0]) / z
            py = (za * pixels[e, 0, 1] + zb * pixels[e, 1, 1] + zc * pixels[e, 2, 1]) / z
            px, py = (px - 0.5) * scale, (py - 0.5) * scale
            px, py = min(max(px, 0.0), width - 1.0), min(max(py, 0.0), height - 1.0)
            i0, j0 = int(px), int(py)
            r = g = b = 0.0
            for dy in range(-1, 3):
                wy = _cubic_weight(py - (j0 + dy))
                if wy == 0.0:
                    continue
                jj = min(max(j0 + dy, 0), height - 1)
                for dx in range(-1, 3):
                    wx = _cubic_weight(px - (i0 + dx)) * wy
                    ii = min(max(i0 + dx, 0), width - 1)
                    b += wx * picture[jj, ii, 0]
                    g += wx * picture[jj, ii, 1]
                    r += wx * picture[jj, ii, 2]
            for c in range(3):
                value = r if c == 0 else (g if c == 1 else b)
                offset = ct * offsets[e, 0, c] + cu * offsets[e, 1, c] + cv * offsets[e, 2, c]
                total[j, i, c] += weight * (gain[c] * value + offset)
            total[j, i, 3] += weight


@kernel("void(i4[:,::1], f8[:,:,::1], f8, f8, f4[:,:,::1], f4[:,:,::1], u1[:,:,::1])")
def compute_colors(texel_faces, corners, left, top, fallback, total, rgb):  # type: ignore[no-untyped-def]
    """Compute the colours of texels from the views or, if no view was added, by interpolation.

    fallback : (m, 3, 3) colours of the corners for the interpolation
    """
    h, w = texel_faces.shape
    for j in range(h):
        for i in range(w):
            f = texel_faces[j, i]
            if f < 0:
                continue
            weight = total[j, i, 3]
            if weight > 0.0:
                for c in range(3):
                    value = total[j, i, c] / weight + 0.5
                    rgb[j, i, c] = int(min(max(value, 0.0), 255.0))
                continue
            ax, ay = corners[f, 0, 0], corners[f, 0, 1]
            ex, ey = corners[f, 1, 0] - ax, corners[f, 1, 1] - ay
            fx, fy = corners[f, 2, 0] - ax, corners[f, 2, 1] - ay
            det = ex * fy - ey * fx
            x, y = left + i + 0.5 - ax, top + j + 0.5 - ay
            u = min(max((x * fy - y * fx) / det, 0.0), 1.0)
            v = min(max((ex * y - ey * x) / det, 0.0), 1.0 - u)
            for c in range(3):
                value = (
                    (1 - u - v) * fallback[f, 0, c]
                    + u * fallback[f, 1, c]
                    + (v * fallback[f, 2, c])
                )
                rgb[j, i, c] = int(min(max(value + 0.5, 0.0), 255.0))
