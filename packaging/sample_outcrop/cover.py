"""What lies on the rock: boulders on the talus, bushes and grass. No geology, only its looks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import geology
from .geology import Array
from .relief import CREST, HEIGHT, LOWEST, WIDTH, Cliff

ROCK, SCREE, GREEN, SOIL = range(4)


@dataclass(frozen=True)
class Face:
    """The whole face on an even grid of s and h: how far it stands out, and what is there."""

    s: Array
    h: Array
    out: Array
    what: npt.NDArray[np.int8]
    shade: Array
    """Of each boulder or bush, a number of its own, -1 to 1."""

    def points(self) -> Array:
        return geology.place(self.s, self.h, self.out)


def make_face(
    cliff: Cliff, rng: np.random.Generator, rows: int, columns: int, keep_free: Array
) -> Face:
    """keep_free (n, 2): s and h of picked places, where nothing grows."""
    s, h = np.meshgrid(np.linspace(0.0, WIDTH, columns), np.linspace(LOWEST, LOWEST + HEIGHT, rows))
    out = np.empty(s.shape)
    over = np.empty(s.shape)
    for i in range(0, rows, 64):
        part = slice(i, i + 64)
        out[part], over[part] = cliff.surface(s[part], h[part])
    what = np.where(over > 0, SCREE, ROCK).astype(np.int8)
    what[(h > CREST + 0.55 + 0.25 * np.sin(1.7 * s)) & (over < 0)] = SOIL
    face = Face(s, h, out, what, np.zeros(s.shape))
    _boulders(face, rng, over)
    _bushes(face, rng, over, keep_free)
    return face


def _window(face: Face, s: float, h: float, reach: float) -> tuple[slice, slice] | None:
    step = face.s[0, 1] - face.s[0, 0]
    i, j = (h - LOWEST) / step, s / step
    n = reach / step
    rows = slice(max(0, int(i - n)), min(face.s.shape[0], int(i + n) + 2))
    columns = slice(max(0, int(j - n)), min(face.s.shape[1], int(j + n) + 2))
    return (rows, columns) if rows.stop > rows.start and columns.stop > columns.start else None


def _boulders(face: Face, rng: np.random.Generator, over: Array) -> None:
    for _ in range(5200):
        s, h = rng.uniform(0, WIDTH), LOWEST + 4.6 * rng.random() ** 1.6
        size = min(0.05 * (1 - rng.random()) ** -0.62, 0.5)
        window = _window(face, s, h, 1.3 * size)
        step = face.s[0, 1]
        here = over[int((h - LOWEST) / step), min(int(s / step), over.shape[1] - 1)]
        if window is None or here < (0.02 if size > 0.12 else -0.05):
            continue
        u, v = face.s[window] - s, face.h[window] - h
        turn = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.uniform(0.7, 1.6, 6))
        far = np.maximum.reduce([u * np.cos(a) + v * np.sin(a) * 1.2 for a in turn])
        slant = rng.normal(0, 0.35, 2)
        body = size * np.clip(1.5 * (1.0 - far / size), 0.0, rng.uniform(0.35, 0.75))
        body = body * (1 + slant[0] * u / size + slant[1] * v / size)
        ground = face.out[window]
        better = (body > 0.01) & (over[window] > -0.15)
        face.out[window] = np.where(better, ground + 0.6 * body, ground)
        face.what[window] = np.where(better, SCREE, face.what[window])
        face.shade[window] = np.where(better, rng.uniform(-1, 1), face.shade[window])


def _bushes(face: Face, rng: np.random.Generator, over: Array, keep_free: Array) -> None:
    places = [
        (s, CREST + rng.uniform(0.2, 1.4), rng.uniform(0.25, 0.75))
        for s in np.cumsum(rng.uniform(0.3, 1.6, 40))
        if s < WIDTH
    ]
    places += [
        (rng.uniform(0, WIDTH), rng.uniform(LOWEST, 0.7), rng.uniform(0.15, 0.5)) for _ in range(34)
    ]
    places += [
        (rng.uniform(0, WIDTH), rng.uniform(1, 11), rng.uniform(0.12, 0.34)) for _ in range(90)
    ]
    step = face.s[0, 1]
    for s, h, size in places:
        if len(keep_free) and np.hypot(*(keep_free - [s, h]).T).min() < size + 0.45:
            continue
        window = _window(face, s, h, 1.2 * size)
        i, j = int((h - LOWEST) / step), min(int(s / step), face.s.shape[1] - 1)
        if window is None or i >= face.s.shape[0]:
            continue
        # On the wall bushes hold on where there is a ledge.
        lower = face.out[max(0, i - int(0.25 / step)), j] - face.out[i, j]
        if 1.0 < h < CREST and lower < 0.1:
            continue
        lobes = rng.normal(0, 0.4 * size, (9, 3))
        radii = size * rng.uniform(0.35, 0.65, 9)
        u, v = face.s[window] - s, face.h[window] - h
        root = face.out[i, j]
        tops = []
        for (a, b, c), r in zip(lobes, radii, strict=True):
            inside = r * r - (u - a) ** 2 - (v - 0.3 * size - b) ** 2
            tops.append(
                np.where(
                    inside > 0,
                    root + 0.2 * size + 0.4 * c + 0.8 * np.sqrt(np.maximum(inside, 0)),
                    -np.inf,
                )
            )
        top = np.maximum.reduce(tops)
        top = top + rng.normal(0, 0.018, top.shape)
        better = top > face.out[window] + 0.01
        face.out[window] = np.where(better, top, face.out[window])
        face.what[window] = np.where(better, GREEN, face.what[window])
        face.shade[window] = np.where(better, rng.uniform(-1, 1), face.shade[window])
