"""Compiled kernels for depth maps."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel


@kernel("void(i2[:,::1], u1[:,::1], i8, i8, i8, i8, i8, f8[:,::1], f8[::1], u1[:,::1], f4[:,::1])")
def convert_disparities(  # type: ignore[no-untyped-def]
    disparities,
    other_mask,
    first_disparity,
    count,
    first_column,
    first_row,
    max_jump,
    rectification,
    coefficients,
    valid_mask,
    inverse_depths,
):
    """Convert disparities of a rectified pair to inverse depths in the photo.

    disparities : (H, W) disparities by SGBM, in sixteenths of a pixel
    other_mask : (H, W) mask of the second picture
    first_disparity, count : range of the searched disparities
    first_column, first_row : rectified coordinates of the centre of the first pixel
    max_jump : maximum difference between neighbours on one surface, in sixteenths of a pixel
    rectification : (3, 3) homography from the photo's pixel centres to rectified ones
    coefficients : alpha, beta and gamma of the reference plane's disparity, 1 / (f B), f, and the
        third row of the rotation from the rectified frame to the photo's frame
    valid_mask : (h, w) mask of the photo
    inverse_depths : (h, w) result, 0 if unknown
    """
    h, w = inverse_depths.shape
    height, width = disparities.shape
    alpha, beta, gamma, unit, f = (
        coefficients[0],
        coefficients[1],
        coefficients[2],
        coefficients[3],
        coefficients[4],
    )
    min_disparity, max_disparity = first_disparity * 16, (first_disparity + count - 1) * 16
    for j in range(h):
        for i in range(w):
            inverse_depths[j, i] = 0.0
            if valid_mask[j, i] == 0:
                continue
            x, y = i + 0.5, j + 0.5
            d = rectification[2, 0] * x + rectification[2, 1] * y + rectification[2, 2]
            if d <= 0.0:
                continue
            u = (rectification[0, 0] * x + rectification[0, 1] * y + rectification[0, 2]) / d
            v = (rectification[1, 0] * x + rectification[1, 1] * y + rectification[1, 2]) / d
            column, row = u - first_column, v - first_row
            c, r = math.floor(column), math.floor(row)
            if c < 0 or r < 0 or c >= width - 1 or r >= height - 1:
                continue
            low = min(
                disparities[r, c],
                disparities[r, c + 1],
                disparities[r + 1, c],
                disparities[r + 1, c + 1],
            )
            high = max(
                disparities[r, c],
                disparities[r, c + 1],
                disparities[r + 1, c],
                disparities[r + 1, c + 1],
            )
            a, b = column - c, row - r
            if low < min_disparity or high - low > max_jump:
                # At an edge, or at the border of the matches, use the nearest pixel only.
                value = float(disparities[r + (b >= 0.5), c + (a >= 0.5)])
                if value < min_disparity:
                    continue
            else:
                value = (disparities[r, c] * (1 - a) + disparities[r, c + 1] * a) * (1 - b)
                value += (disparities[r + 1, c] * (1 - a) + disparities[r + 1, c + 1] * a) * b
            if value > max_disparity:
                continue
            residual_disparity = value / 16.0
            partner_column = round(column - residual_disparity)
            if (
                partner_column < 0
                or partner_column >= width
                or other_mask[round(row), partner_column] == 0
            ):
                continue
            disparity = alpha * u + beta * v + gamma + (1.0 - alpha) * residual_disparity
            depth_factor = (coefficients[5] * u + coefficients[6] * v) / f + coefficients[7]
            if disparity > 0.0 and depth_factor > 0.0:
                inverse_depths[j, i] = disparity * unit / depth_factor


@kernel("void(f4[:,:,::1], f4[::1], f4, f4, f4, i8, f4[:,::1], u1[:,::1])")
def merge_depths(  # type: ignore[no-untyped-def]
    inverse_depths,
    steps,
    tolerance,
    min_inverse,
    max_inverse,
    min_count,
    merged_inverse_depths,
    agreement_counts,
):
    """Merge the inverse depths of the agreeing sources with the largest total weight.

    inverse_depths : (n, h, w), 0 if unknown
    steps : (n,) change of inverse depth per pixel of disparity
    tolerance : maximum difference of agreeing sources, pixels
    min_inverse, max_inverse : range of inverse depths
    min_count : minimum number of agreeing sources
    merged_inverse_depths : (h, w) mean of the agreeing sources, weighted by accuracy; 0 if unknown
    agreement_counts : (h, w) number of agreeing sources
    """
    n, h, w = inverse_depths.shape
    for j in range(h):
        for i in range(w):
            merged_inverse_depths[j, i] = 0.0
            agreement_counts[j, i] = 0
            best_score = 0.0
            for a in range(n):
                q = inverse_depths[a, j, i]
                if q < min_inverse or q > max_inverse:
                    continue
                weight, total, votes = 0.0, 0.0, 0
                for b in range(n):
                    p = inverse_depths[b, j, i]
                    if p < min_inverse or p > max_inverse:
                        continue
                    if abs(p - q) <= tolerance * max(steps[a], steps[b]):
                        inverse_variance = 1.0 / (steps[b] * steps[b])
                        weight += inverse_variance
                        total += inverse_variance * p
                        votes += 1
                if votes >= min_count and weight > best_score:
                    best_score = weight
                    merged_inverse_depths[j, i] = total / weight
                    agreement_counts[j, i] = votes


@kernel("void(f4[:,::1], f4, i8, i8, f8, f8, f8, f8, f4[:,:,::1], f4[:,::1])")
def fit_plane_normals(  # type: ignore[no-untyped-def]
    inverse_depths, max_steepness, radius, stride, fx, fy, cx, cy, normals, smoothed_inverse_depths
):
    """Fit planes, affine in inverse depth, and return unit normals towards the camera.

    inverse_depths : (h, w), 0 if unknown
    max_steepness : relative difference in inverse depth, per pixel of distance, that separates
        surfaces
    radius, stride : window radius and spacing of the neighbours, pixels
    cx, cy : principal point, counted from the centre of the first pixel
    normals : (h, w, 3) in the camera frame; 0 if there are too few neighbours
    smoothed_inverse_depths : (h, w) inverse depths of the planes; unchanged if there are too few
        neighbours
    """
    h, w = inverse_depths.shape
    for j in range(h):
        for i in range(w):
            normals[j, i, 0] = 0.0
            normals[j, i, 1] = 0.0
            normals[j, i, 2] = 0.0
            q = inverse_depths[j, i]
            smoothed_inverse_depths[j, i] = q
            if q <= 0.0:
                continue
            n, su, sv, sq = 0.0, 0.0, 0.0, 0.0
            suu, suv, svv, suq, svq = 0.0, 0.0, 0.0, 0.0, 0.0
            for dv in range(-radius, radius + 1, stride):
                y = j + dv
                if y < 0 or y >= h:
                    continue
                for du in range(-radius, radius + 1, stride):
                    x = i + du
                    if x < 0 or x >= w:
                        continue
                    p = inverse_depths[y, x]
                    if p <= 0.0:
                        continue
                    e = p - q
                    if abs(e) > max_steepness * q * (1 + max(abs(du), abs(dv))):
                        continue
                    n += 1.0
                    su += du
                    sv += dv
                    sq += e
                    suu += du * du
                    suv += du * dv
                    svv += dv * dv
                    suq += du * e
                    svq += dv * e
            if n < 6.0:
                continue
            suu -= su * su / n
            suv -= su * sv / n
            svv -= sv * sv / n
            suq -= su * sq / n
            svq -= sv * sq / n
            det = suu * svv - suv * suv
            if det < 1e-3 * n * n:
                continue
            a = (suq * svv - svq * suv) / det
            b = (svq * suu - suq * suv) / det
            smoothed_inverse_depths[j, i] = q + (sq - a * su - b * sv) / n
            # q = a u + b v + c is the plane (fx a, fy b, a cx + b cy + c) in the camera frame.
            nx, ny = fx * a, fy * b
            nz = q + a * (cx - i) + b * (cy - j)
            length = math.sqrt(nx * nx + ny * ny + nz * nz)
            if length == 0.0:
                continue
            normals[j, i, 0] = -nx / length
            normals[j, i, 1] = -ny / length
            normals[j, i, 2] = -nz / length
