"""Compiled kernels for textures."""

from __future__ import annotations

from vomstudio.geometry.kernels.jit import kernel, part
from vomstudio.photogrammetry.surface._triangle_parts import frame_of, weights_at


@kernel("void(i4[::1], i4[::1], f4[::1], i4[:,::1], i8, f4[::1])")
def smooth_quality(starts, views, quality, neighbour_faces, rounds, spare):  # type: ignore[no-untyped-def]
    """Average the qualities of each view over neighbouring faces that it sees.

    Entries of face f are starts[f] to starts[f + 1], sorted by view; `spare` is as long as
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
                spare[e] = total / weight
        for e in range(len(quality)):
            quality[e] = spare[e]


@kernel("void(i4[::1], i4[::1], f4[::1], i4[:,::1], f8, i8, i4[::1])")
def choose_views(starts, views, quality, neighbour_faces, joining, sweeps, labels):  # type: ignore[no-untyped-def]
    """Select the view from which each face is drawn, or -1 for a face without views.

    The view maximises its quality relative to the best view of the face, plus `joining` for each
    neighbour with the same view (iterated conditional modes).
    """
    for sweep in range(sweeps):
        changed_count = 0
        for f in range(len(labels)):
            first_neighbour, last_neighbour = starts[f], starts[f + 1]
            if first_neighbour == last_neighbour:
                labels[f] = -1
                continue
            top = 1e-20
            for e in range(first_neighbour, last_neighbour):
                top = max(top, quality[e])
            best_quality, best_view = -1.0, labels[f]
            for e in range(first_neighbour, last_neighbour):
                value = quality[e] / top
                if sweep > 0:
                    for side in range(3):
                        g = neighbour_faces[f, side]
                        if g >= 0 and labels[g] == views[e]:
                            value += joining
                if value > best_quality + 1e-9:
                    best_quality, best_view = value, views[e]
            if best_view != labels[f]:
                labels[f] = best_view
                changed_count += 1
        if changed_count == 0:
            break


@kernel("void(i4[::1], i4[::1], i4[::1], b1[::1], f4[:,::1], f4[:,::1], i8)")
def diffuse(starts, links, some, counts, values, spare, rounds):  # type: ignore[no-untyped-def]
    """Average the values of `some` vertices over themselves and linked ones that count.

    The others are unchanged; `spare` (len(some), c).
    """
    channels = values.shape[1]
    for _ in range(rounds):
        for k in range(len(some)):
            v = some[k]
            count = 1.0
            for c in range(channels):
                spare[k, c] = values[v, c]
            for index in range(starts[v], starts[v + 1]):
                o = links[index]
                if counts[o]:
                    count += 1.0
                    for c in range(channels):
                        spare[k, c] += values[o, c]
            for c in range(channels):
                spare[k, c] /= count
        for k in range(len(some)):
            for c in range(channels):
                values[some[k], c] = spare[k, c]


@kernel("void(i4[::1], i4[::1], b1[::1], f4[:,::1], i4[::1])")
def fill_outward(starts, links, known, values, queue):  # type: ignore[no-untyped-def]
    """Assign unknown vertices the mean of known neighbours, ring by ring (`queue` of n)."""
    n = len(known)
    count = 0
    for v in range(n):
        if known[v]:
            queue[count] = v
            count += 1
    position = 0
    while position < count:
        v = queue[position]
        position += 1
        for k in range(starts[v], starts[v + 1]):
            o = links[k]
            if known[o]:
                continue
            total = 0.0
            for c in range(values.shape[1]):
                values[o, c] = 0.0
            for j in range(starts[o], starts[o + 1]):
                p = links[j]
                if known[p]:
                    total += 1.0
                    for c in range(values.shape[1]):
                        values[o, c] += values[p, c]
            for c in range(values.shape[1]):
                values[o, c] /= total
            known[o] = True
            queue[count] = o
            count += 1


@part
def _sort(values, count):  # type: ignore[no-untyped-def]
    """Sort the first `count` values by Shell's method (Knuth, 1998, vol. 3, sec. 5.2.1).

    The method of NumPy would allocate memory, which requires numba's runtime.
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
def median_distances(starts, colors, distance, spread, values):  # type: ignore[no-untyped-def]
    """Compute distances of colours from the median of their vertex.

    Also the spread of the nearer half. Each in the worst channel; 0 with fewer than three entries.
    `values` is working space for the entries of one vertex.
    """
    for v in range(len(starts) - 1):
        first_neighbour, last_neighbour = starts[v], starts[v + 1]
        n = last_neighbour - first_neighbour
        for e in range(first_neighbour, last_neighbour):
            distance[e] = 0.0
            spread[e] = 0.0
        if n < 3:
            continue
        for c in range(3):
            for k in range(n):
                values[k] = colors[first_neighbour + k, c]
            _sort(values, n)
            centre = 0.5 * (values[(n - 1) // 2] + values[n // 2])
            for k in range(n):
                values[k] = abs(values[k] - centre)
            _sort(values, n)
            # Use the nearer half, so that outliers do not widen the spread.
            median = values[(n - 1) // 2]
            for e in range(first_neighbour, last_neighbour):
                distance[e] = max(distance[e], abs(colors[e, c] - centre))
                spread[e] = max(spread[e], median)


@kernel("void(f8[:,:,::1], f8, f8, i4[:,::1])")
def draw_faces(corners, left, top, owner):  # type: ignore[no-untyped-def]
    """Draw the face number at each texel's centre; `owner` is initialised with -1."""
    h, w = owner.shape
    for f in range(len(corners)):
        ax, ay = corners[f, 0, 0] - left, corners[f, 0, 1] - top
        bx, by = corners[f, 1, 0] - left, corners[f, 1, 1] - top
        cx, cy = corners[f, 2, 0] - left, corners[f, 2, 1] - top
        ex, ey, fx, fy, inverse, i0, i1, j0, j1 = frame_of(ax, ay, bx, by, cx, cy, w, h)
        if inverse == 0.0:
            continue
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                u, v = weights_at(i, j, ax, ay, ex, ey, fx, fy, inverse)
                if u >= -1e-9 and v >= -1e-9 and u + v <= 1.0 + 1e-9 and owner[j, i] < 0:
                    owner[j, i] = f


@kernel("void(i4[:,::1], i4[:,::1], i8)")
def grow_faces(owner, spare, rounds):  # type: ignore[no-untyped-def]
    """Extend faces to the texels around them, for the gutter."""
    h, w = owner.shape
    for _ in range(rounds):
        for j in range(h):
            for i in range(w):
                face = owner[j, i]
                if face < 0:
                    for q in range(8):
                        k = q if q < 4 else q + 1
                        y, x = j + k // 3 - 1, i + k % 3 - 1
                        if 0 <= y < h and 0 <= x < w and owner[y, x] >= 0:
                            face = owner[y, x]
                            break
                spare[j, i] = face
        for j in range(h):
            for i in range(w):
                owner[j, i] = spare[j, i]


@part
def _weight(t):  # type: ignore[no-untyped-def]
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
    owner,
    corners,
    left,
    top,
    entry,
    pixels,
    depths,
    weights,
    offsets,
    level,
    drawn_level,
    picture,
    gain,
    sharpening,
    total,
):
    """Add one view's colours to the texels whose faces are drawn from it.

    owner : (h, w) face of each texel; corners : (m, 3, 2) on the page
    entry : (m,) row of the face in the arrays below, -1 if this view does not draw it
    pixels (e, 3, 2), depths, weights (e, 3), offsets (e, 3, 3) : at the corners
    level : (e,) of the pyramid; only those equal to `drawn_level` are drawn, from `picture` (BGR)
    total : (h, w, 4) sums of RGB and of weights
    """
    h, w = owner.shape
    height, width = picture.shape[0], picture.shape[1]
    scale = 1.0 / 2.0**drawn_level
    for j in range(h):
        for i in range(w):
            f = owner[j, i]
            if f < 0:
                continue
            e = entry[f]
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
            nearest_depth = ct + cu + cv
            ct, cu, cv = ct / nearest_depth, cu / nearest_depth, cv / nearest_depth
            weight = ct * weights[e, 0] + cu * weights[e, 1] + cv * weights[e, 2]
            if weight <= 1e-6:
                continue
            weight = weight**sharpening
            za, zb, zc = t * depths[e, 0], u * depths[e, 1], v * depths[e, 2]
            z = za + zb + zc
            px = (za * pixels[e, 0, 0] + zb * pixels[e, 1, 0] + zc * pixels[e, 2, 0]) / z
            py = (za * pixels[e, 0, 1] + zb * pixels[e, 1, 1] + zc * pixels[e, 2, 1]) / z
            px, py = (px - 0.5) * scale, (py - 0.5) * scale
            px, py = min(max(px, 0.0), width - 1.0), min(max(py, 0.0), height - 1.0)
            i0, j0 = int(px), int(py)
            r = g = b = 0.0
            for dy in range(-1, 3):
                wy = _weight(py - (j0 + dy))
                if wy == 0.0:
                    continue
                jj = min(max(j0 + dy, 0), height - 1)
                for dx in range(-1, 3):
                    wx = _weight(px - (i0 + dx)) * wy
                    ii = min(max(i0 + dx, 0), width - 1)
                    b += wx * picture[jj, ii, 0]
                    g += wx * picture[jj, ii, 1]
                    r += wx * picture[jj, ii, 2]
            for c in range(3):
                value = r if c == 0 else (g if c == 1 else b)
                shift = ct * offsets[e, 0, c] + cu * offsets[e, 1, c] + cv * offsets[e, 2, c]
                total[j, i, c] += weight * (gain[c] * value + shift)
            total[j, i, 3] += weight


@kernel("void(i4[:,::1], f8[:,:,::1], f8, f8, f4[:,:,::1], f4[:,:,::1], u1[:,:,::1])")
def finish(owner, corners, left, top, fallback, total, rgb):  # type: ignore[no-untyped-def]
    """Compute the colours of texels: from the views, or interpolated without a view.

    fallback : (m, 3, 3) colours of the corners
    """
    h, w = owner.shape
    for j in range(h):
        for i in range(w):
            f = owner[j, i]
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
