"""Compiled kernels for the fusion of depth maps."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel, step


@step
def _intersect_ray(depth, n0, n1, n2, b0, b1, right, down, gx, gy):  # type: ignore[no-untyped-def]
    """Return the depth at which the ray (b0, b1, 1) intersects the plane of a pixel.

    The result is 0 if the ray grazes the plane. If it differs by more than 2 % from the depth of
    the pixel, that depth is returned.

    right, down : offset of the pixel from the principal point
    """
    ray_slope = n0 * b0 + n1 * b1 + n2
    ray_depth = 0.0
    if not ray_slope > -0.05:
        pixel_slope = n0 * right / gx + n1 * down / gy + n2
        ray_depth = depth * pixel_slope / ray_slope
        if abs(ray_depth - depth) > 0.02 * depth:
            ray_depth = float(depth)
    return ray_depth


@kernel(
    "void(f4[:,::1], f4[:,:,::1], f8[::1], f4[:,::1], f4[:,:,::1], u1[:,::1], f8[::1],"
    " f8[:,::1], b1, f8[::1], f4[:,:,::1], u1[:,:,::1])"
)
def compare(  # type: ignore[no-untyped-def]
    depth,
    normals,
    lens,
    other_depths,
    other_normals,
    other_confidence,
    other_lens,
    transform,
    is_later,
    limits,
    sums,
    votes,
):
    """Compare another depth map with each pixel of this one.

    depth, normals, lens : map of this photo: (h, w), (h, w, 3), (fx, fy, cx, cy)
    other_depths, other_normals, other_confidence, other_lens : map of the other photo
    transform : (3, 4) transformation from this camera's frame to the other's
    is_later : whether the other photo comes later, which decides between equal footprints
    limits : distance in pixels, relative depth, cosine between normals, ratio of equal footprints
    sums : (h, w, 6) weight, weight x offset along the normal, 1 - confidence, normal
    votes : (h, w, 3) number of agreeing views, number of views that see through the point, and 1 if
        the point is taken from another view
    """
    h, w = depth.shape
    height, width = other_depths.shape
    fx, fy, cx, cy = lens[0], lens[1], lens[2], lens[3]
    gx, gy, dx, dy = other_lens[0], other_lens[1], other_lens[2], other_lens[3]
    max_distance_px, max_depth_share, min_cosine = limits[0], limits[1], limits[2]
    unit = 1.0 / math.log(limits[3])
    for j in range(h):
        for i in range(w):
            z = depth[j, i]
            if z <= 0.0:
                continue
            x = (i + 0.5 - cx) / fx * z
            y = (j + 0.5 - cy) / fy * z
            b2 = transform[2, 0] * x + transform[2, 1] * y + transform[2, 2] * z + transform[2, 3]
            if b2 <= 0.0:
                continue
            b0 = (
                transform[0, 0] * x + transform[0, 1] * y + transform[0, 2] * z + transform[0, 3]
            ) / b2
            b1 = (
                transform[1, 0] * x + transform[1, 1] * y + transform[1, 2] * z + transform[1, 3]
            ) / b2
            u, v = gx * b0 + dx, gy * b1 + dy
            c, r = math.floor(u), math.floor(v)
            if c < 0 or r < 0 or c >= width or r >= height:
                continue
            other_depth = other_depths[r, c]
            if other_depth <= 0.0:
                continue
            n0, n1, n2 = other_normals[r, c, 0], other_normals[r, c, 1], other_normals[r, c, 2]
            ray_depth = _intersect_ray(
                other_depth, n0, n1, n2, b0, b1, c + 0.5 - dx, r + 0.5 - dy, gx, gy
            )
            if ray_depth <= 0.0:
                continue
            # Project the point of the other surface into this photo.
            e = ray_depth - b2
            p0 = transform[0, 0] * b0 + transform[1, 0] * b1 + transform[2, 0]
            p1 = transform[0, 1] * b0 + transform[1, 1] * b1 + transform[2, 1]
            p2 = transform[0, 2] * b0 + transform[1, 2] * b1 + transform[2, 2]
            new_depth = z + e * p2
            if new_depth <= 0.0:
                continue
            offset_x = fx * ((x + e * p0) / new_depth - x / z)
            offset_y = fy * ((y + e * p1) / new_depth - y / z)
            distance_px = math.sqrt(offset_x * offset_x + offset_y * offset_y)
            if distance_px > max_distance_px or abs(e) > max_depth_share * b2:
                is_too_large = distance_px > 3.0 * max_distance_px or e > 3.0 * max_depth_share * b2
                if e > 0.0 and is_too_large and votes[j, i, 1] < 254:
                    votes[j, i, 1] += 1
                continue
            m0, m1, m2 = normals[j, i, 0], normals[j, i, 1], normals[j, i, 2]
            t0 = transform[0, 0] * m0 + transform[0, 1] * m1 + transform[0, 2] * m2
            t1 = transform[1, 0] * m0 + transform[1, 1] * m1 + transform[1, 2] * m2
            t2 = transform[2, 0] * m0 + transform[2, 1] * m1 + transform[2, 2] * m2
            if t0 * n0 + t1 * n1 + t2 * n2 < min_cosine:
                continue
            confidence = other_confidence[r, c] / 255.0
            weight = confidence * (gx / other_depth) ** 2
            sums[j, i, 0] += weight
            sums[j, i, 1] += weight * (t0 * b0 + t1 * b1 + t2) * e
            sums[j, i, 2] *= 1.0 - confidence
            sums[j, i, 3] += weight * (
                transform[0, 0] * n0 + transform[1, 0] * n1 + transform[2, 0] * n2
            )
            sums[j, i, 4] += weight * (
                transform[0, 1] * n0 + transform[1, 1] * n1 + transform[2, 1] * n2
            )
            sums[j, i, 5] += weight * (
                transform[0, 2] * n0 + transform[1, 2] * n1 + transform[2, 2] * n2
            )
            if votes[j, i, 0] < 254:
                votes[j, i, 0] += 1
            level = math.floor(math.log(z / fx) * unit)
            other_level = math.floor(math.log(other_depth / gx) * unit)
            if other_level < level or (other_level == level and not is_later):
                votes[j, i, 2] = 1
