"""The camera that photographed the sample outcrop, and where it stood.

Pixels: x to the right, y down, the middle of the first pixel is (0.5, 0.5). Camera frame: x to the
right, y down, z forward. The lens is Brown's, in the order of OpenCV.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import geology
from .geology import Array

MAKE, MODEL = "Handlens", "Face 24"
WIDTH, HEIGHT = 1500, 1000
SENSOR_MM = 23.6
FOCAL_MM, FOCAL_35_MM = 18.0, 27
"""As the photos state them; the lens is a little longer than its name."""
LENS = {
    "fx": 1151.70,
    "fy": 1151.70,
    "cx": 752.60,
    "cy": 498.10,
    "k1": -0.0580,
    "k2": 0.0210,
    "p1": 0.0,
    "p2": 0.0,
}


def bend(x: Array, y: Array) -> tuple[Array, Array]:
    """Through the lens: image coordinates (...) in units of the focal length."""
    k1, k2, p1, p2 = (LENS[name] for name in ("k1", "k2", "p1", "p2"))
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * k2)
    return (
        x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
    )


def straighten(x: Array, y: Array) -> tuple[Array, Array]:
    """The inverse of `bend`."""
    u, v = x.copy(), y.copy()
    for _ in range(60):
        a, b = bend(u, v)
        u, v = u + (x - a), v + (y - b)
        if max(np.abs(x - a).max(), np.abs(y - b).max()) < 1e-13:
            break
    return u, v


@dataclass(frozen=True)
class Shot:
    """One photo: its name, centre (3,) relative to ORIGIN, and rotation (3, 3) from the axes east,
    north, up to the camera's. `exposure` brightens the picture; `seconds` after the first."""

    name: str
    centre: Array
    rotation: Array
    exposure: float
    seconds: int

    def project(self, points: Array) -> tuple[Array, Array]:
        """Pixels (n, 2) and depths (n,) of points (n, 3) relative to ORIGIN."""
        x, y, z = ((points - self.centre) @ self.rotation.T).T
        a, b = bend(x / z, y / z)
        pixels = np.stack([LENS["fx"] * a + LENS["cx"], LENS["fy"] * b + LENS["cy"]], axis=-1)
        return pixels, z


def facing(turn_deg: float, rise_deg: float, roll_deg: float) -> Array:
    """Rotation of a camera that looks at the face, turned to the right of its normal, tilted
    upward, and rolled clockwise."""
    azimuth = geology.FACE_AZIMUTH_DEG + 180.0 + turn_deg
    forward = geology.direction(azimuth, -rise_deg)
    right = geology.direction(azimuth + 90.0, 0.0)
    down = np.cross(forward, right)
    roll = np.radians(roll_deg)
    right, down = (
        np.cos(roll) * right + np.sin(roll) * down,
        np.cos(roll) * down - np.sin(roll) * right,
    )
    return np.stack([right, down, forward])


# s, h and out of the cliff's plane, m; degrees to the right, upward, clockwise. The lower row with
# the arms raised, from left to right; the upper row from the air, back again.
PLACES = (
    (3.3, 0.7, 14.6, 15.0, 9.0, 0.6),
    (7.9, 0.4, 15.4, 8.5, 8.0, -1.1),
    (12.4, 0.8, 14.3, 3.0, 9.5, 0.9),
    (17.6, 0.6, 15.2, -2.5, 8.0, -0.4),
    (22.7, 0.3, 14.4, -8.0, 10.0, 1.7),
    (27.4, 0.9, 15.0, -14.5, 8.5, -0.8),
    (26.0, 8.9, 16.4, -12.5, -5.0, 0.4),
    (21.2, 9.4, 15.3, -7.5, -6.5, -0.7),
    (16.7, 8.6, 16.8, -3.5, -4.5, 0.2),
    (12.1, 9.1, 15.6, 2.0, -6.0, 1.2),
    (7.3, 8.7, 16.6, 7.0, -5.0, -0.3),
    (4.2, 9.3, 15.7, 13.0, -6.0, -1.4),
)


def shots(rng: np.random.Generator) -> list[Shot]:
    """All photos in the order in which they were taken."""
    made = []
    seconds = 0
    for i, (s, h, out, turn, rise, roll) in enumerate(PLACES):
        seconds += int(rng.integers(9, 24)) + (240 if i == len(PLACES) // 2 else 0)
        shake = rng.normal(0.0, (0.15, 0.08, 0.15, 0.8, 0.6, 0.3))
        s, h, out, turn, rise, roll = np.array([s, h, out, turn, rise, roll]) + shake
        centre = geology.place(np.array(s), np.array(h), np.array(out))
        exposure = float(np.exp(rng.normal(0.0, 0.05)))
        made.append(Shot(f"HL_{2041 + i}.jpg", centre, facing(turn, rise, roll), exposure, seconds))
    return made
