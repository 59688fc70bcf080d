"""Compiled kernels of the visibility of a mesh in a photo."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel
from vomstudio.photogrammetry.surface._triangle_parts import barycentric_weights, triangle_frame


@kernel("void(f8[:,::1], f8[::1], i4[:,::1], i4[::1], f4[:,::1])")
def draw_depths(pixels, depths, faces, selection, depth_buffer):  # type: ignore[no-untyped-def]
    """Draw the nearest depth of each pixel into `depth_buffer` (h, w), initially infinity.

    pixels : (n, 2) vertices in the picture, x right and y down; the first pixel's centre is at 0.5
    depths : (n,) depths along the axis; inverse depths are interpolated linearly
    selection : rows of the faces to draw
    """
    h, w = depth_buffer.shape
    for row in range(len(selection)):
        f = selection[row]
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay = pixels[a, 0], pixels[a, 1]
        ex, ey, fx, fy, inverse_det, i0, i1, j0, j1 = triangle_frame(
            ax, ay, pixels[b, 0], pixels[b, 1], pixels[c, 0], pixels[c, 1], w, h
        )
        if inverse_det == 0.0:
            continue
        za, zb, zc = 1.0 / depths[a], 1.0 / depths[b], 1.0 / depths[c]
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                u, v = barycentric_weights(i, j, ax, ay, ex, ey, fx, fy, inverse_det)
                if u < -1e-9 or v < -1e-9 or u + v > 1.0 + 1e-9:
                    continue
                z = 1.0 / (za + u * (zb - za) + v * (zc - za))
                if z < depth_buffer[j, i]:
                    depth_buffer[j, i] = z


@kernel(
    "void(f8[:,::1], f8[::1], i4[:,::1], i4[::1], f4[:,::1], f4[:,::1], u1[:,::1], f8, f8, f8,"
    " f4[::1], f4[::1])"
)
def measure_visible_shares(  # type: ignore[no-untyped-def]
    pixels,
    depths,
    faces,
    selection,
    depth_buffer,
    nearest_depths,
    usable_mask,
    pixel_size,
    radius_px,
    depth_tolerance_px,
    visible_shares,
    clear_shares,
):
    """Compute the visible share of each selected face's pixels, with and without a margin.

    depth_buffer : result of `draw_depths`
    nearest_depths : minimum of `depth_buffer` within `radius_px` pixels
    usable_mask : 0 for masked pixels
    pixel_size : size of a pixel at depth 1
    depth_tolerance_px : pixels by which a surface may be behind the nearest one
    visible_shares, clear_shares : results without and with the margin
    """
    h, w = depth_buffer.shape
    for row in range(len(selection)):
        f = selection[row]
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay = pixels[a, 0], pixels[a, 1]
        ex, ey, fx, fy, inverse_det, i0, i1, j0, j1 = triangle_frame(
            ax, ay, pixels[b, 0], pixels[b, 1], pixels[c, 0], pixels[c, 1], w, h
        )
        if inverse_det == 0.0:
            continue
        za, zb, zc = 1.0 / depths[a], 1.0 / depths[b], 1.0 / depths[c]
        # Change of the inverse depth from pixel to pixel.
        gx = ((zb - za) * fy - (zc - za) * ey) * inverse_det
        gy = ((zc - za) * ex - (zb - za) * fx) * inverse_det
        slope = abs(gx) + abs(gy)
        total, visible_count, clear_count = 0, 0, 0
        for pass_number in range(2):
            if pass_number == 1:
                if total > 0:
                    break
                # The face does not contain a pixel's centre: use the pixel below its middle.
                i0 = i1 = math.floor(ax + (ex + fx) / 3.0)
                j0 = j1 = math.floor(ay + (ey + fy) / 3.0)
                if i0 < 0 or j0 < 0 or i0 >= w or j0 >= h:
                    break
            for j in range(j0, j1 + 1):
                for i in range(i0, i1 + 1):
                    u, v = barycentric_weights(i, j, ax, ay, ex, ey, fx, fy, inverse_det)
                    if pass_number == 1:
                        u = v = 1.0 / 3.0
                    elif u < 0.0 or v < 0.0 or u + v > 1.0:
                        continue
                    total += 1
                    if usable_mask[j, i] == 0:
                        continue
                    inverse_depth = za + u * (zb - za) + v * (zc - za)
                    z = 1.0 / inverse_depth
                    # The depth that this face's own slope allows nearby.
                    slope_tolerance = slope * z * z
                    tolerance = depth_tolerance_px * pixel_size * z + (
                        slope_tolerance if pass_number == 1 else 0.0
                    )
                    if z <= depth_buffer[j, i] + tolerance:
                        visible_count += 1
                        if z <= nearest_depths[j, i] + tolerance + radius_px * slope_tolerance:
                            clear_count += 1
        if total > 0:
            visible_shares[row] = visible_count / total
            clear_shares[row] = clear_count / total


@kernel("void(u1[:,:,::1], f8[:,::1], f4[:,::1])")
def interpolate_picture(picture, positions, values):  # type: ignore[no-untyped-def]
    """Interpolate a picture (h, w, c) at pixels (n, 2), clamped to its border.

    The centre of the first pixel is at 0.5.
    """
    h, w, channels = picture.shape
    for k in range(len(positions)):
        x = min(max(positions[k, 0] - 0.5, 0.0), w - 1.0)
        y = min(max(positions[k, 1] - 0.5, 0.0), h - 1.0)
        i, j = int(x), int(y)
        fx, fy = x - i, y - j
        i1, j1 = min(i + 1, w - 1), min(j + 1, h - 1)
        for c in range(channels):
            values[k, c] = (1 - fy) * (
                (1 - fx) * picture[j, i, c] + fx * picture[j, i1, c]
            ) + fy * ((1 - fx) * picture[j1, i, c] + fx * picture[j1, i1, c])
