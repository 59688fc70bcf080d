"""Compiled parts of the depth maps."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel


@kernel("void(i2[:,::1], u1[:,::1], i8, i8, i8, i8, i8, f8[:,::1], f8[::1], u1[:,::1], f4[:,::1])")
def lift(found, other, lowest, count, left, top, jump, to_rect, how, valid, inverse):  # type: ignore[no-untyped-def]
    """Inverse depths in the photo from the disparities of a rectified pair.

    found : (H, W) 16ths of a pixel, from SGBM
    other : (H, W) where the second picture shows anything
    lowest, count : of the disparities that were searched
    left, top : rectified coordinates of the centre of found's first pixel
    jump : largest difference of neighbours on one surface, 16ths of a pixel
    to_rect : (3, 3) homography from the photo's pixels to rectified ones, coordinates of centres
    how : alpha, beta, gamma of the reference plane's disparity, 1 / (f B), f, and the third row of
        the rotation from the rectified frame to the photo's
    valid : (h, w) which pixels of the photo count
    inverse : (h, w) result, 0 where there is none
    """
    h, w = inverse.shape
    tall, wide = found.shape
    alpha, beta, gamma, unit, f = how[0], how[1], how[2], how[3], how[4]
    least, most = lowest * 16, (lowest + count - 1) * 16
    for j in range(h):
        for i in range(w):
            inverse[j, i] = 0.0
            if valid[j, i] == 0:
                continue
            x, y = i + 0.5, j + 0.5
            d = to_rect[2, 0] * x + to_rect[2, 1] * y + to_rect[2, 2]
            if d <= 0.0:
                continue
            u = (to_rect[0, 0] * x + to_rect[0, 1] * y + to_rect[0, 2]) / d
            v = (to_rect[1, 0] * x + to_rect[1, 1] * y + to_rect[1, 2]) / d
            column, row = u - left, v - top
            c, r = math.floor(column), math.floor(row)
            if c < 0 or r < 0 or c >= wide - 1 or r >= tall - 1:
                continue
            low = min(found[r, c], found[r, c + 1], found[r + 1, c], found[r + 1, c + 1])
            high = max(found[r, c], found[r, c + 1], found[r + 1, c], found[r + 1, c + 1])
            a, b = column - c, row - r
            if low < least or high - low > jump:
                # An edge, or the end of what matched: the nearest pixel alone.
                value = float(found[r + (b >= 0.5), c + (a >= 0.5)])
                if value < least:
                    continue
            else:
                value = (found[r, c] * (1 - a) + found[r, c + 1] * a) * (1 - b)
                value += (found[r + 1, c] * (1 - a) + found[r + 1, c + 1] * a) * b
            if value > most:
                continue
            delta = value / 16.0
            there = round(column - delta)
            if there < 0 or there >= wide or other[round(row), there] == 0:
                continue
            disparity = alpha * u + beta * v + gamma + (1.0 - alpha) * delta
            along = (how[5] * u + how[6] * v) / f + how[7]
            if disparity > 0.0 and along > 0.0:
                inverse[j, i] = disparity * unit / along


@kernel("void(f4[:,:,::1], f4[::1], f4, f4, f4, i8, f4[:,::1], u1[:,::1])")
def merge(inverse, steps, tolerance, least, most, fewest, merged, agreeing):  # type: ignore[no-untyped-def]
    """The inverse depth on which most sources agree.

    inverse : (n, h, w), 0 = none
    steps : (n,) change of inverse depth for a pixel of disparity
    tolerance : largest difference of agreeing sources, pixels
    least, most : inverse depths allowed
    fewest : sources that must agree
    merged : (h, w) their mean, weighted by accuracy; 0 = none
    agreeing : (h, w) their number
    """
    n, h, w = inverse.shape
    for j in range(h):
        for i in range(w):
            merged[j, i] = 0.0
            agreeing[j, i] = 0
            best = 0.0
            for a in range(n):
                q = inverse[a, j, i]
                if q < least or q > most:
                    continue
                weight, total, votes = 0.0, 0.0, 0
                for b in range(n):
                    p = inverse[b, j, i]
                    if p < least or p > most:
                        continue
                    if abs(p - q) <= tolerance * max(steps[a], steps[b]):
                        one = 1.0 / (steps[b] * steps[b])
                        weight += one
                        total += one * p
                        votes += 1
                if votes >= fewest and weight > best:
                    best = weight
                    merged[j, i] = total / weight
                    agreeing[j, i] = votes


@kernel("void(f4[:,::1], f4, i8, i8, f8, f8, f8, f8, f4[:,:,::1], f4[:,::1])")
def plane_normals(  # type: ignore[no-untyped-def]
    inverse, steepness, radius, stride, fx, fy, cx, cy, normals, fitted
):
    """Unit normals towards the camera, in its frame: planes are affine in inverse depth.

    inverse : (h, w), 0 = none
    steepness : neighbours whose inverse depth differs by more than this part of it for each pixel
        of distance lie on another surface
    radius, stride : of the neighbours, pixels
    cx, cy : from the centre of the first pixel
    normals : (h, w, 3), 0 where too few neighbours
    fitted : (h, w) inverse depths of the planes, as given where too few neighbours
    """
    h, w = inverse.shape
    for j in range(h):
        for i in range(w):
            normals[j, i, 0] = 0.0
            normals[j, i, 1] = 0.0
            normals[j, i, 2] = 0.0
            q = inverse[j, i]
            fitted[j, i] = q
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
                    p = inverse[y, x]
                    if p <= 0.0:
                        continue
                    e = p - q
                    if abs(e) > steepness * q * (1 + max(abs(du), abs(dv))):
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
            fitted[j, i] = q + (sq - a * su - b * sv) / n
            # q = a u + b v + c is the plane (fx a, fy b, a cx + b cy + c) in the camera's frame.
            nx, ny = fx * a, fy * b
            nz = q + a * (cx - i) + b * (cy - j)
            length = math.sqrt(nx * nx + ny * ny + nz * nz)
            if length == 0.0:
                continue
            normals[j, i, 0] = -nx / length
            normals[j, i, 1] = -ny / length
            normals[j, i, 2] = -nz / length
