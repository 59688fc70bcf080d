"""Surveyed targets on the sample outcrop: boards painted on flat places of the rock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from . import geology
from .cover import ROCK, Face
from .geology import Array
from .relief import HEIGHT, LOWEST, WIDTH

SIDE = 0.36  # m
SURVEY_SD = 0.004  # m, each coordinate
MARK_SD = 0.3  # pixels
PIXELS = 240

# Label, about where (s, h), and what for.
WANTED = (
    ("T1", 2.6, 2.0, "control"),
    ("T2", 6.6, 9.3, "control"),
    ("T3", 10.4, 2.6, "check"),
    ("T4", 14.3, 9.6, "check"),
    ("T5", 19.2, 5.4, "control"),
    ("T6", 22.6, 10.2, "control"),
    ("T7", 24.3, 3.0, "check"),
    ("T8", 28.3, 5.9, "control"),
)


@dataclass(frozen=True)
class Target:
    """A board: its label and use, its middle (3,) relative to ORIGIN, and the unit vectors (3,)
    across it (to the right, upward) and out of it."""

    label: str
    use: str
    middle: Array
    right: Array
    up: Array
    normal: Array
    picture: npt.NDArray[np.float32]

    def paint(self, points: Array) -> tuple[npt.NDArray[np.bool_], Array]:
        """Which points (n, 3) are on the board, and the brightness (k,), 0..1, of those."""
        away = points - self.middle
        x, y, z = away @ self.right, away @ self.up, away @ self.normal
        on = (np.abs(x) < SIDE / 2) & (np.abs(y) < SIDE / 2) & (np.abs(z) < 0.08)
        column = ((x[on] / SIDE + 0.5) * PIXELS).astype(int).clip(0, PIXELS - 1)
        row = ((0.5 - y[on] / SIDE) * PIXELS).astype(int).clip(0, PIXELS - 1)
        return on, self.picture[row, column]


def board(label: str) -> npt.NDArray[np.float32]:
    """Two black quarters of a disc on white that meet in the middle, and the label."""
    image = Image.new("L", (4 * PIXELS, 4 * PIXELS), 255)
    draw = ImageDraw.Draw(image)
    middle, radius = 2 * PIXELS, 1.36 * PIXELS
    box = (middle - radius, middle - radius, middle + radius, middle + radius)
    draw.pieslice(box, 0, 90, fill=0)
    draw.pieslice(box, 180, 270, fill=0)
    font = ImageFont.load_default(size=0.62 * PIXELS)
    draw.text((3.3 * PIXELS, 0.12 * PIXELS), label[1:], font=font, fill=0)
    small = image.resize((PIXELS, PIXELS), Image.Resampling.BOX)
    return np.asarray(np.asarray(small) / 255.0, np.float32)


def place_targets(face: Face, all_points: Array, keep_free: Array) -> list[Target]:
    """Targets on the flattest rock near where they are wanted, half a metre off every pick.

    all_points : (n, 3) dense on the surface of the model, relative to ORIGIN
    keep_free : (k, 2) s and h of picks
    """
    all_s, all_h = all_points @ geology.ALONG, all_points @ geology.UP
    row = ((all_h - LOWEST) / HEIGHT * (face.h.shape[0] - 1)).round().astype(int)
    column = (all_s / WIDTH * (face.s.shape[1] - 1)).round().astype(int)
    all_rock = face.what[row, column] == ROCK
    made = []
    for label, at_s, at_h, use in WANTED:
        best: tuple[float, Array, Array] | None = None
        window = (np.abs(all_s - at_s) < 1.9) & (np.abs(all_h - at_h) < 1.1)
        points, s, h, rock = all_points[window], all_s[window], all_h[window], all_rock[window]
        for ds in np.arange(-1.6, 1.61, 0.1):
            for dh in np.arange(-0.8, 0.81, 0.1):
                a, b = at_s + ds, at_h + dh
                if len(keep_free) and np.hypot(*(keep_free - [a, b]).T).min() < 0.5:
                    continue
                near = (np.abs(s - a) < 0.24) & (np.abs(h - b) < 0.24)
                if near.sum() < 40 or not rock[near].all():
                    continue
                middle = points[near].mean(axis=0)
                _, _, axes = np.linalg.svd(points[near] - middle, full_matrices=False)
                normal = axes[2] * np.sign(axes[2] @ geology.OUT)
                if normal @ geology.OUT < 0.85:
                    continue
                off = float(np.abs((points[near] - middle) @ normal).max())
                off += 0.01 * float(np.hypot(ds, dh))
                if best is None or off < best[0]:
                    best = off, middle, normal
        if best is None:
            raise RuntimeError(f"no flat rock for {label}")
        _, middle, normal = best
        # Its middle is a point of the surface.
        middle = points[np.linalg.norm(points - middle, axis=1).argmin()]
        right = np.cross(geology.UP, normal)
        right /= np.linalg.norm(right)
        made.append(
            Target(label, use, middle, right, np.cross(normal, right), normal, board(label))
        )
    return made
