"""Compiled kernels of the visibility of a mesh in a photo."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel
from vomstudio.photogrammetry.surface._triangle_parts import frame_of, weights_at


@kernel("void(f8[:,::1], f8[::1], i4[:,::1], i4[::1], f4[:,::1])")
def draw_depths(pixels, depths, faces, selection, buffer):  # type: ignore[no-untyped-def]
    """Draw the nearest depth at each pixel's centre; `buffer` (h, w) starts with infinity.

    pixels (n, 2) : x right, y down, the first pixel's centre at 0.5
    depths (n,) : along the axis; their inverse is linear in a triangle's picture
    selection : rows of the faces to draw
    """
    h, w = buffer.shape
    for row in range(len(selection)):
        f = selection[row]
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay = pixels[a, 0], pixels[a, 1]
        ex, ey, fx, fy, inverse, i0, i1, j0, j1 = frame_of(
            ax, ay, pixels[b, 0], pixels[b, 1], pixels[c, 0], pixels[c, 1], w, h
        )
        if inverse == 0.0:
            continue
        za, zb, zc = 1.0 / depths[a], 1.0 / depths[b], 1.0 / depths[c]
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                u, v = weights_at(i, j, ax, ay, ex, ey, fx, fy, inverse)
                if u < -1e-9 or v < -1e-9 or u + v > 1.0 + 1e-9:
                    continue
                z = 1.0 / (za + u * (zb - za) + v * (zc - za))
                if z < buffer[j, i]:
                    buffer[j, i] = z


@kernel(
    "void(f8[:,::1], f8[::1], i4[:,::1], i4[::1], f4[:,::1], f4[:,::1], u1[:,::1], f8, f8, f8,"
    " f4[::1], f4[::1])"
)
def count_seen(  # type: ignore[no-untyped-def]
    pixels,
    depths,
    faces,
    selection,
    buffer,
    nearest,
    usable,
    pixel,
    radius,
    depth_tolerance,
    visible_counts,
    clear_counts,
):
    """Compute the visible share of each selected face's pixels, and that with a margin.

    buffer : of `draw_depths`; nearest : its minimum within `radius` pixels
    usable : 0 for masked pixels; pixel : size of a pixel at depth 1
    slack : pixels by which a surface may be behind the nearest one
    visible_counts, clear_counts : results
    """
    h, w = buffer.shape
    for row in range(len(selection)):
        f = selection[row]
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay = pixels[a, 0], pixels[a, 1]
        ex, ey, fx, fy, inverse, i0, i1, j0, j1 = frame_of(
            ax, ay, pixels[b, 0], pixels[b, 1], pixels[c, 0], pixels[c, 1], w, h
        )
        if inverse == 0.0:
            continue
        za, zb, zc = 1.0 / depths[a], 1.0 / depths[b], 1.0 / depths[c]
        # Change of the inverse depth from pixel to pixel.
        gx = ((zb - za) * fy - (zc - za) * ey) * inverse
        gy = ((zc - za) * ex - (zb - za) * fx) * inverse
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
                    u, v = weights_at(i, j, ax, ay, ex, ey, fx, fy, inverse)
                    if pass_number == 1:
                        u = v = 1.0 / 3.0
                    elif u < 0.0 or v < 0.0 or u + v > 1.0:
                        continue
                    total += 1
                    if usable[j, i] == 0:
                        continue
                    face_depth = za + u * (zb - za) + v * (zc - za)
                    z = 1.0 / face_depth
                    # The depth that this face's own slope allows nearby.
                    depth_tolerance_of_slope = slope * z * z
                    tolerance = depth_tolerance * pixel * z + (
                        depth_tolerance_of_slope if pass_number == 1 else 0.0
                    )
                    if z <= buffer[j, i] + tolerance:
                        visible_count += 1
                        if z <= nearest[j, i] + tolerance + radius * depth_tolerance_of_slope:
                            clear_count += 1
        if total > 0:
            visible_counts[row] = visible_count / total
            clear_counts[row] = clear_count / total


@kernel("void(u1[:,:,::1], f8[:,::1], f4[:,::1])")
def look_up(picture, positions, values):  # type: ignore[no-untyped-def]
    """Interpolate a picture (h, w, c) at pixels (n, 2), with the first centre at 0.5; clamped."""
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
