"""What the photos show besides the outcrop: the ground before it, slopes beside and above it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import geology
from .cover import Face
from .geology import Array
from .pictures import SUN, Solid
from .relief import HEIGHT, LOWEST, WIDTH

Ints = npt.NDArray[np.int64]
TOP = LOWEST + HEIGHT
REACH = 26.0  # m beside, above and before the face
LAP, BEHIND = 0.5, 0.12  # m: the surroundings begin behind the face's edge


def surroundings(face: Face, noise: Solid) -> tuple[Array, Ints]:
    """Points (n, 3) relative to ORIGIN and triangles (m, 3) that turn toward the viewer."""
    side_s = np.concatenate([np.arange(0.0, 6.0, 0.3), np.linspace(6.0, REACH, 21)])
    heights = np.linspace(LOWEST, TOP, 65)
    rows = np.clip(((heights - LOWEST) / HEIGHT * (len(face.h) - 1)).astype(int), 0, None)
    sheets = []
    for left in (True, False):
        edge = face.out[rows, 0 if left else -1]
        edge = np.convolve(np.pad(edge, 3, "edge"), np.ones(7) / 7, "valid")
        away = side_s[None, :] - LAP
        share = _smooth(away / 5.0)
        slope = 1.6 - 0.95 * (heights[:, None] - 1.0)
        out = edge[:, None] + share * (slope - edge[:, None]) - BEHIND
        s = -away if left else WIDTH + away
        s, h = np.broadcast_arrays(s, heights[:, None])
        out = out + 0.35 * share * noise.octaves(geology.place(s, h, 0 * h), 2.4, 4)
        points = geology.place(s, h, out)
        sheets.append(points[:, ::-1] if left else points)
    # All along the foot and the crest, sides included.
    low = np.concatenate([sheets[0][0], _edge(face, 0), sheets[1][0]])
    high = np.concatenate([sheets[0][-1], _edge(face, -1), sheets[1][-1]])
    sheets.append(_ground(low, noise)[::-1])
    sheets.append(_hill(high, noise))
    first, points, triangles = 0, [], []
    for sheet in sheets:
        n, m, _ = sheet.shape
        at = first + np.arange(n * m).reshape(n, m)
        a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
        triangles += [np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
        points.append(sheet.reshape(-1, 3))
        first += n * m
    return np.concatenate(points), np.concatenate(triangles)


def _edge(face: Face, row: int) -> Array:
    every = slice(None, None, 16)
    out = np.convolve(np.pad(face.out[row], 8, "edge"), np.ones(17) / 17, "valid")[every]
    return geology.place(face.s[row, every], face.h[row, every], out)


def _ground(low: Array, noise: Solid) -> Array:
    """(k, n, 3) outward from the foot, first along it; it covers the lowest edge of the face."""
    r = np.concatenate([[0.0], np.geomspace(0.3, REACH, 44)])[:, None]
    s, out = low @ geology.ALONG, low @ geology.OUT
    # The foot's line straightens with distance.
    plain = np.full(len(s), np.median(out))
    out = plain + (out - plain) * np.exp(-r / 4.0) + r - LAP
    h = LOWEST + 0.16 - 0.012 * r + 0 * s
    s = np.broadcast_to(s, h.shape)
    rough = noise.octaves(geology.place(s, 0 * h, out), 1.3, 5)
    return geology.place(s, h + 0.07 * np.minimum(r, 1.0) * rough, out)


def _hill(high: Array, noise: Solid) -> Array:
    r = np.concatenate([[0.0], np.geomspace(0.3, REACH, 30)])[:, None]
    s, out = high @ geology.ALONG, high @ geology.OUT
    out = out - r - BEHIND
    h = TOP - LAP * 0.3 + 3.0 * (1 - np.exp(-r / 7.0)) + 0 * s
    s = np.broadcast_to(s, h.shape)
    rough = noise.octaves(geology.place(s, 0 * h, out), 1.9, 5)
    return geology.place(s, h + 0.16 * np.minimum(r, 1.0) * rough, out)


def _smooth(t: Array) -> Array:
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


def colors(points: Array, normals: Array, noise: Solid) -> Array:
    """(n, 3) 0..255 in daylight: gravel and dry grass below, grass and shrubs elsewhere."""
    h = points @ geology.UP
    low = np.clip(0.5 - 1.2 * (h - LOWEST - 0.2), 0, 1)
    patchy = noise.octaves(points, 1.7, 3)
    grit = np.array([150.0, 137.0, 116.0]) * (1 + 0.12 * noise.octaves(points, 0.5, 2)[:, None])
    fine = noise.octaves(points + 7, 0.055, 3)[:, None]
    grit = grit * (1 + 0.22 * fine).clip(0.4, 1.7)
    grass = np.array([112.0, 111.0, 72.0]) * (1 + 0.22 * fine).clip(0.4, 1.7)
    soil = np.array([122.0, 106.0, 78.0]) * (1 + 0.16 * noise.octaves(points, 0.4, 2)[:, None])
    soil = soil * (1 + 0.16 * fine).clip(0.4, 1.6)
    shrub = np.array([74.0, 82.0, 54.0]) * (1 + 0.25 * noise.octaves(points + 3, 0.2, 3)[:, None])
    shrub = shrub * (1 + 0.2 * fine)
    color = soil + (grass - soil) * np.clip(0.6 + 0.7 * patchy, 0, 1)[:, None]
    thick = np.clip(2.0 * noise.octaves(points + 29, 1.3, 2) - 0.9, 0, 1) * (1 - low)
    color = color + (shrub.clip(18, None) - color) * thick[:, None]
    bare = low * np.clip(0.9 + 0.6 * patchy, 0.1, 1)
    color = color + (grit - color) * bare[:, None]
    light = 0.45 + 0.2 * normals[:, 2].clip(0, 1) + 0.62 * (normals @ SUN).clip(0, 1)
    return np.asarray((color * light[:, None]).clip(0, 255))
