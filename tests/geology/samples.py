"""Orientations drawn at random after known laws."""

from __future__ import annotations

import math

import numpy as np


def fisher_sample(
    rng: np.random.Generator, n: int, kappa: float, mean: np.ndarray | None = None
) -> np.ndarray:
    """Directions after Fisher's law (Fisher, Lewis & Embleton 1987, sect. 3.6.2)."""
    cosine = 1 + np.log(rng.random(n) * (1 - math.exp(-2 * kappa)) + math.exp(-2 * kappa)) / kappa
    turn = rng.uniform(0, 2 * math.pi, n)
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    local = np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=1)
    return local @ frame(np.array([0, 0, 1.0]) if mean is None else mean)


def frame(axis: np.ndarray) -> np.ndarray:
    """Rows: two unit vectors across the axis, then the axis."""
    q, _ = np.linalg.qr(np.column_stack([axis, np.eye(3)[np.argmin(np.abs(axis))], [1, 2, 3.5]]))
    q[:, 0] = axis / np.linalg.norm(axis)
    return np.array([q[:, 1], np.cross(q[:, 0], q[:, 1]), q[:, 0]])


def bingham_sample(rng: np.random.Generator, n: int, k1: float, k2: float) -> np.ndarray:
    """Axes after Bingham's law, k1 along x and k2 along y, by rejection from an angular Gaussian
    (Kent, Ganeiber & Mardia 2018, Journal of Computational and Graphical Statistics 27, 291)."""
    kept: list[np.ndarray] = []
    while sum(map(len, kept)) < n:
        x = rng.normal(size=(4 * n + 100, 3)) / np.sqrt(1 + 2 * np.array([-k1, -k2, 0.0]))
        x /= np.linalg.norm(x, axis=1)[:, None]
        power = -k1 * x[:, 0] ** 2 - k2 * x[:, 1] ** 2
        share = np.exp(1 - power) * ((1 + 2 * power) / 3) ** 1.5
        kept.append(x[rng.random(len(x)) < share])
    return np.vstack(kept)[:n]
