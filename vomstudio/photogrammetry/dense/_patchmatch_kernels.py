"""Compiled kernels for PatchMatch."""

from __future__ import annotations

import math

import numpy as np

from vomstudio.geometry.kernels.jit import fastmath_part, kernel, step

RADIUS = 4
STRIDE = 2
PATCH_SAMPLES = (2 * RADIUS // STRIDE + 1) ** 2
MAX_COST = 2.0
"""Cost of pixels that cannot be compared, and of opposite patches."""

# Decay of a neighbour's weight: it halves over a seventh of the brightness range.
_WEIGHT_DECAY = 5.0


@fastmath_part
def _random(seeds, position):  # type: ignore[no-untyped-def]
    """Return a random number in [0, 1) from Marsaglia's xorshift, with one state per pixel."""
    # Numba widens shifted integers, so truncate them to 32 bits.
    x = np.uint32(seeds[position])
    x = np.uint32(x ^ np.uint32((x << np.uint32(13)) & np.uint32(0xFFFFFFFF)))
    x = np.uint32(x ^ (x >> np.uint32(17)))
    x = np.uint32(x ^ np.uint32((x << np.uint32(5)) & np.uint32(0xFFFFFFFF)))
    seeds[position] = x
    return np.float32(x >> np.uint32(8)) * np.float32(1.0 / 16777216.0)


@fastmath_part
def _patch_cost(  # type: ignore[no-untyped-def]
    u, v, rx, ry, z, nx, ny, nz, source, width, height, a, b, lens, patch, weights, moments
):
    """Return 1 minus the weighted correlation of a patch with its projection into one source.

    The patch is projected by the plane at depth z with normal (nx, ny, nz).
    """
    d = z * (nx * rx + ny * ry + nz)
    if d > np.float32(-1e-20):
        return np.float32(MAX_COST)
    g0, g1 = nx * lens[0] / d, ny * lens[1] / d
    g2 = nz / d - g0 * lens[2] - g1 * lens[3]
    h00, h01, h02 = a[0, 0] + b[0] * g0, a[0, 1] + b[0] * g1, a[0, 2] + b[0] * g2
    h10, h11, h12 = a[1, 0] + b[1] * g0, a[1, 1] + b[1] * g1, a[1, 2] + b[1] * g2
    h20, h21, h22 = a[2, 0] + b[2] * g0, a[2, 1] + b[2] * g1, a[2, 2] + b[2] * g2
    unity = np.float32(1.0)
    s1, s2, s12 = np.float32(0.0), np.float32(0.0), np.float32(0.0)
    k = 0
    for dy in range(-RADIUS, RADIUS + 1, STRIDE):
        y = v + np.float32(dy)
        for dx in range(-RADIUS, RADIUS + 1, STRIDE):
            if weights[k] == np.float32(0.0):
                k += 1
                continue
            x = u + np.float32(dx)
            w = h20 * x + h21 * y + h22
            if w <= np.float32(1e-6):
                return np.float32(MAX_COST)
            w = unity / w
            p, q = (h00 * x + h01 * y + h02) * w, (h10 * x + h11 * y + h12) * w
            if not (p >= 0.0 and q >= 0.0 and p < width - 1 and q < height - 1):
                return np.float32(MAX_COST)
            i, j = int(p), int(q)
            fx, fy = p - np.float32(i), q - np.float32(j)
            upper_value = source[j, i] + (source[j, i + 1] - source[j, i]) * fx
            lower_value = source[j + 1, i] + (source[j + 1, i + 1] - source[j + 1, i]) * fx
            value = upper_value + (lower_value - upper_value) * fy
            weighted_value = weights[k] * value
            s1 += weighted_value
            s2 += weighted_value * value
            s12 += weighted_value * patch[k]
            k += 1
    variance = s2 - s1 * s1
    if variance < np.float32(1e-5) or moments[1] < np.float32(1e-5):
        return np.float32(MAX_COST)
    r = (s12 - s1 * moments[0]) / math.sqrt(variance * moments[1])
    return min(max(unity - r, np.float32(0.0)), np.float32(MAX_COST))


@fastmath_part
def _read_patch(reference, x, y, patch, weights, moments):  # type: ignore[no-untyped-def]
    """Read the patch around a pixel: values, normalised bilateral weights, mean and variance."""
    h, w = reference.shape
    centre, total, k = reference[y, x], np.float32(0.0), 0
    for dy in range(-RADIUS, RADIUS + 1, STRIDE):
        for dx in range(-RADIUS, RADIUS + 1, STRIDE):
            value = reference[min(max(y + dy, 0), h - 1), min(max(x + dx, 0), w - 1)]
            squared_distance = np.float32(dx * dx + dy * dy) * np.float32(0.5 / (RADIUS * RADIUS))
            weight = math.exp(-abs(value - centre) * np.float32(_WEIGHT_DECAY) - squared_distance)
            if y + dy < 0 or x + dx < 0 or y + dy >= h or x + dx >= w:
                # Areas outside the photo are not similar to anything in the other photos.
                weight = 0.0
            patch[k], weights[k] = value, weight
            total += weight
            k += 1
    mean, mean_square = np.float32(0.0), np.float32(0.0)
    for k in range(PATCH_SAMPLES):
        weights[k] /= total
        mean += weights[k] * patch[k]
        mean_square += weights[k] * patch[k] * patch[k]
    moments[0], moments[1] = mean, mean_square - mean * mean


@step
def _select_sources(trial, selection, count):  # type: ignore[no-untyped-def]
    """Select the sources in which the current plane fits best.

    Returns the sum of the costs of the plane in these sources; the costs in `trial` are
    overwritten.
    """
    best_cost = np.float32(0.0)
    for k in range(count):
        c = 0
        for s in range(1, len(trial)):
            if trial[s] < trial[c]:
                c = s
        selection[k] = c
        best_cost += trial[c]
        trial[c] = np.float32(9.0)
    return best_cost


@step
def _neighbour_pixel(k, x, y, radius):  # type: ignore[no-untyped-def]
    """Return a neighbour of a pixel, one of the four adjacent or the four distant ones."""
    distance = 1 if k < 4 else radius
    side = k % 4
    i = x + (distance if side == 0 else (-distance if side == 1 else 0))
    j = y + (distance if side == 2 else (-distance if side == 3 else 0))
    return i, j


@step
def _random_trial(k, q, random, low, high, unit, spread):  # type: ignore[no-untyped-def]
    """Return the inverse depth and the tilt of the normal for a random trial.

    The ninth trial changes only the depth, the tenth only the normal, and the eleventh both. While
    `spread` is 0.2 or more, the eleventh covers the complete range of depths.
    """
    tilt = spread
    if k == 8:
        q += np.float32(2.0) * spread * unit * (np.float32(2.0) * random - np.float32(1.0))
        tilt = np.float32(0.0)
    elif k == 10:
        if spread < np.float32(0.2):
            q += np.float32(0.3) * spread * unit * (np.float32(2.0) * random - np.float32(1.0))
            tilt = np.float32(0.3) * spread
        else:
            q = low + (high - low) * random
            tilt = np.float32(1.0)
    return q, tilt


@step
def _ray_depth(ax, ay, az, neighbour_depth, p, q, fx, fy, rx, ry):  # type: ignore[no-untyped-def]
    """Return the depth at which a ray (rx, ry, 1) intersects the plane of a neighbour.

    Returns 0 if the ray grazes the plane.

    neighbour_depth : depth of the neighbour on the ray (p fx, q fy, 1)
    """
    scaled_depth = ax * p * fx
    scaled_depth += ay * q * fy + az
    direction_product = ax * rx + ay * ry + az
    return (
        np.float32(0.0)
        if direction_product > np.float32(-0.05)
        else neighbour_depth * scaled_depth / direction_product
    )


@step
def _tilt_normal(nx, ny, nz, tilt, a, b, c):  # type: ignore[no-untyped-def]
    """Tilt a normal at random; a, b and c are random numbers from 0 to 1."""
    ax = nx + tilt * (np.float32(2.0) * a - np.float32(1.0))
    ay = ny + tilt * (np.float32(2.0) * b - np.float32(1.0))
    az = nz + tilt * (np.float32(2.0) * c - np.float32(1.0))
    length = math.sqrt(ax * ax + ay * ay + az * az) + np.float32(1e-9)
    return ax / length, ay / length, az / length


@kernel(
    "void(f4[:,::1], f4[:,:,::1], i8[:,::1], f4[:,:,::1], f4[:,::1], f4[::1], u1[:,::1],"
    " f4[:,::1], f4[:,:,::1], f4[:,:,::1], u4[::1], f4, f4, f4, f4, i8, i8, i8, i8, i8,"
    " f4[:,::1], f4[::1], i8[::1])",
    fastmath=True,
)
def sweep_planes(  # type: ignore[no-untyped-def]
    reference,
    sources,
    sizes,
    rotations,
    shifts,
    lens,
    is_active,
    depth,
    normal,
    costs,
    seeds,
    min_depth,
    max_depth,
    unit,
    spread,
    max_sources,
    radius,
    parity,
    first,
    last,
    samples,
    trial,
    selection,
):
    """Improve the planes of every second pixel in the rows `first` to `last`, in place.

    reference : (h, w) picture, 0 to 1
    sources : (n, H, W) other pictures, padded
    sizes : (n, 2) widths and heights of these pictures
    rotations, shifts : (n, 3, 3) K' R K^-1 and (n, 3) K' t, for pixels counted from their centres
    lens : 1 / fx, 1 / fy, cx, cy
    is_active : (h, w) mask of the pixels to improve; other pixels only propagate their planes
    depth, normal : (h, w), (h, w, 3) planes, which are set for all pixels
    costs : (h, w, n) costs of the plane in each source
    min_depth, max_depth : range of depths
    unit : change of inverse depth per pixel of disparity
    spread : size of the random changes, initially 1
    max_sources : number of best sources that are used
    radius : odd distance of the farther neighbours whose planes are tried, or 0
    samples, trial, selection : working space, (3, PATCH_SAMPLES), (n,) and (n,)
    """
    h, w = reference.shape
    n = len(sources)
    patch, weights, moments = samples[0], samples[1], samples[2]
    low, high = np.float32(1.0) / max_depth, np.float32(1.0) / min_depth
    count = min(n, max_sources)
    fraction = np.float32(1.0) / np.float32(count)
    for y in range(first, last):
        for x in range((y + parity) % 2, w, 2):
            if is_active[y, x] == 0:
                continue
            position = y * w + x
            _read_patch(reference, x, y, patch, weights, moments)
            u, v = np.float32(x), np.float32(y)
            rx, ry = (u - lens[2]) * lens[0], (v - lens[3]) * lens[1]
            z = depth[y, x]
            nx, ny, nz = normal[y, x, 0], normal[y, x, 1], normal[y, x, 2]
            for s in range(n):
                costs[y, x, s] = _patch_cost(
                    u,
                    v,
                    rx,
                    ry,
                    z,
                    nx,
                    ny,
                    nz,
                    sources[s],
                    sizes[s, 0],
                    sizes[s, 1],
                    rotations[s],
                    shifts[s],
                    lens,
                    patch,
                    weights,
                    moments,
                )
                trial[s] = costs[y, x, s]
            best_cost = fraction * _select_sources(trial, selection, count)
            for k in range(11):
                if k < 8:
                    i, j = _neighbour_pixel(k, x, y, radius)
                    if (i == x and j == y) or i < 0 or j < 0 or i >= w or j >= h:
                        continue
                    ax, ay, az = normal[j, i, 0], normal[j, i, 1], normal[j, i, 2]
                    p, q = np.float32(i) - lens[2], np.float32(j) - lens[3]
                    d = _ray_depth(ax, ay, az, depth[j, i], p, q, lens[0], lens[1], rx, ry)
                    is_similar_depth = abs(d - z) < np.float32(0.05) * unit * z * z
                    if is_similar_depth and ax * nx + ay * ny + az * nz > np.float32(0.9998):
                        continue
                else:
                    random_number = np.float32(0.0) if k == 9 else _random(seeds, position)
                    q, tilt = _random_trial(
                        k, np.float32(1.0) / z, random_number, low, high, unit, spread
                    )
                    d = np.float32(1.0) / max(q, np.float32(1e-20))
                    a, b, c = (
                        _random(seeds, position),
                        _random(seeds, position),
                        _random(seeds, position),
                    )
                    ax, ay, az = _tilt_normal(nx, ny, nz, tilt, a, b, c)
                    size = math.sqrt(rx * rx + ry * ry + np.float32(1.0))
                    if ax * rx + ay * ry + az > np.float32(-0.15) * size:
                        continue
                if d < min_depth or d > max_depth:
                    continue
                total = np.float32(0.0)
                for m in range(count):
                    s = selection[m]
                    total += fraction * _patch_cost(
                        u,
                        v,
                        rx,
                        ry,
                        d,
                        ax,
                        ay,
                        az,
                        sources[s],
                        sizes[s, 0],
                        sizes[s, 1],
                        rotations[s],
                        shifts[s],
                        lens,
                        patch,
                        weights,
                        moments,
                    )
                    if total >= best_cost:
                        break
                if total < best_cost:
                    best_cost, z = total, d
                    nx, ny, nz = ax, ay, az
                    # The next sweep, or `measure_costs`, updates the costs in the other sources.
            depth[y, x] = z
            normal[y, x, 0], normal[y, x, 1], normal[y, x, 2] = nx, ny, nz


@kernel(
    "void(f4[:,::1], f4[:,:,::1], i8[:,::1], f4[:,:,::1], f4[:,::1], f4[::1], u1[:,::1],"
    " f4[:,::1], f4[:,:,::1], f4[:,:,::1], i8, i8, f4[:,::1])",
    fastmath=True,
)
def measure_costs(  # type: ignore[no-untyped-def]
    reference,
    sources,
    sizes,
    rotations,
    shifts,
    lens,
    is_active,
    depth,
    normal,
    costs,
    first,
    last,
    samples,
):
    """Compute the costs of the planes in each source for the rows `first` to `last`.

    `samples` (3, PATCH_SAMPLES) is working space.
    """
    w = reference.shape[1]
    patch, weights, moments = samples[0], samples[1], samples[2]
    for y in range(first, last):
        for x in range(w):
            if is_active[y, x] == 0:
                continue
            _read_patch(reference, x, y, patch, weights, moments)
            u, v = np.float32(x), np.float32(y)
            rx, ry = (u - lens[2]) * lens[0], (v - lens[3]) * lens[1]
            for s in range(len(sources)):
                costs[y, x, s] = _patch_cost(
                    u,
                    v,
                    rx,
                    ry,
                    depth[y, x],
                    normal[y, x, 0],
                    normal[y, x, 1],
                    normal[y, x, 2],
                    sources[s],
                    sizes[s, 0],
                    sizes[s, 1],
                    rotations[s],
                    shifts[s],
                    lens,
                    patch,
                    weights,
                    moments,
                )
