"""Poles of folds whose shape is known, each strayed a little: for the verdicts on them."""

from __future__ import annotations

import numpy as np

from vomstudio.geology.orientation import normals_to_planes

Rng = np.random.Generator
Planes = tuple[np.ndarray, np.ndarray]


def planes(poles: np.ndarray) -> Planes:
    dip_direction, dip, _ = normals_to_planes(poles)
    return dip_direction, dip


def axis_frame(rng: Rng) -> np.ndarray:
    """Rows: an axis in any direction, and two directions across it."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return np.asarray(q.T)


def strayed(rng: Rng, poles: np.ndarray, noise_deg: float) -> np.ndarray:
    return np.asarray(poles + np.radians(noise_deg) * rng.normal(size=poles.shape))


def bent(
    rng: Rng, n: int, arc_deg: float, noise_deg: float, half_angle_deg: float = 90.0
) -> np.ndarray:
    """A cylinder, or a cone of this angle between its axis and the poles."""
    axis, first, second = axis_frame(rng)
    t = np.radians(rng.uniform(-arc_deg / 2, arc_deg / 2, n))[:, None]
    half = np.radians(half_angle_deg)
    across = np.cos(t) * first + np.sin(t) * second
    return strayed(rng, np.sin(half) * across + np.cos(half) * axis, noise_deg)


def chevron(rng: Rng, n: int, apart_deg: float, noise_deg: float) -> np.ndarray:
    """Two limbs, and no bed between them."""
    _, first, second = axis_frame(rng)
    t = np.radians(np.where(np.arange(n) < n // 2, -apart_deg / 2, apart_deg / 2))[:, None]
    return strayed(rng, np.cos(t) * first + np.sin(t) * second, noise_deg)


def one_and_the_other(rng: Rng, n: int, apart_deg: float, noise_deg: float) -> np.ndarray:
    """A limb of n beds, and one bed of another limb."""
    _, first, second = axis_frame(rng)
    t = np.radians(np.append(np.zeros(n), apart_deg))[:, None]
    return strayed(rng, np.cos(t) * first + np.sin(t) * second, noise_deg)


def two_folds(rng: Rng, n: int, arc_deg: float, noise_deg: float, apart_deg: float) -> np.ndarray:
    """Two cylinders whose axes are so far apart, each with half of the planes."""
    axis, first, second = axis_frame(rng)
    turn = np.radians(apart_deg)
    other = np.cross(np.cos(turn) * axis + np.sin(turn) * first, second)
    t = np.radians(rng.uniform(-arc_deg / 2, arc_deg / 2, n))[:, None]
    one = (np.arange(n) < n // 2)[:, None]
    poles = np.cos(t) * np.where(one, first, other) + np.sin(t) * second
    return strayed(rng, poles, noise_deg)


def one_dip(rng: Rng, n: int, noise_deg: float) -> np.ndarray:
    return strayed(rng, np.tile(axis_frame(rng)[0], (n, 1)), noise_deg)


def scatter(rng: Rng, n: int) -> np.ndarray:
    poles = rng.normal(size=(n, 3))
    return np.asarray(poles / np.linalg.norm(poles, axis=1)[:, None])


def fault_and_beds(
    rng: Rng, off_deg: float, noise_deg: float, turn_deg: float = 35.0
) -> dict[str, Planes]:
    """Fig. 31: footwall and fault in any attitude; the hanging wall turned about the line in which
    they meet (0: parallel beds, a; else oblique, b), and then tilted off that axis (c)."""
    axis, first, second = axis_frame(rng)

    def at(angle_deg: float, tilt_deg: float = 0.0) -> np.ndarray:
        t, w = np.radians([angle_deg, tilt_deg])
        return np.cos(w) * (np.cos(t) * first + np.sin(t) * second) + np.sin(w) * axis

    poles = {"footwall": at(0), "fault": at(75), "hanging wall": at(turn_deg, off_deg)}
    counts = {"footwall": 12, "fault": 4, "hanging wall": 12}
    return {
        name: planes(strayed(rng, np.tile(pole, (counts[name], 1)), noise_deg))
        for name, pole in poles.items()
    }
