"""What planes by compass look like that do not agree with the others: a strike that was read as dip
direction, or the opposite direction.

The rotation that most planes agree on is found by least median of squares over pairs of planes
(Rousseeuw 1984); the others are held against it as they are, and with their azimuth read in another
way."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding

FEWEST_PLANES = 5
"""Of fewer nobody can say which agree."""
_FEWEST_RADIANS = 3
_TRIALS = 100
_FAR_DEG = 15.0
_TIMES = 5.0
# Planes whose normals are nearer to each other fix no rotation.
_APART = np.sin(np.radians(15.0))
_TURNS = (90.0, -90.0, 180.0)


def azimuth_findings(labels: Sequence[str], model: FloatArray, world: FloatArray) -> list[Finding]:
    """Of planes that agree with the others if their azimuth is read in another way.

    model, world : (n, 3) unit normals; a normal and its opposite are the same
    """
    if len(labels) < FEWEST_PLANES:
        return []
    rotation = _agreed(model, world)
    if rotation is None:
        return []
    placed = model @ rotation.T
    off = _between(placed, world)
    usual = float(np.median(off))
    limit = max(_FAR_DEG, _TIMES * usual)
    if usual > _FAR_DEG / 3:
        # So few agree that none can be called the others.
        return []
    named: dict[float, list[str]] = {}
    for row in map(int, np.flatnonzero(off > limit)):
        fits = [
            (float(_between(placed[row : row + 1], _turned(world[row], turn))[0]), turn)
            for turn in _TURNS
        ]
        least, turn = min(fits)
        if least < limit / 2:
            named.setdefault(turn, []).append(labels[row])
    return [
        Finding("compass.other-azimuth", labels=names, turn_deg=turn)
        for turn, names in named.items()
    ]


def radian_findings(azimuth_deg: FloatArray, inclination_deg: FloatArray) -> list[Finding]:
    """Of angles (n,) that are all as small as radians are."""
    if len(azimuth_deg) < _FEWEST_RADIANS:
        return []
    if azimuth_deg.max() > 2.0 * np.pi + 0.01 or inclination_deg.max() > np.pi / 2.0 + 0.01:
        return []
    return [Finding("compass.radians")]


def azimuth_that_fits(placed: FloatArray, world: FloatArray, limit_deg: float) -> float | None:
    """What, added to the azimuth of a direction (3,), would put it where the others do; None where
    neither a strike read as dip direction nor the opposite direction would."""
    fits = [(float(_between(placed[None], _turned(world, turn))[0]), turn) for turn in _TURNS]
    least, turn = min(fits)
    return turn if least < limit_deg else None


def _turned(normal: FloatArray, azimuth_deg: float) -> FloatArray:
    """(1, 3) the normal of a plane with so much added to its azimuth."""
    c, s = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
    # Azimuths run clockwise.
    return np.array([[c * normal[0] + s * normal[1], c * normal[1] - s * normal[0], normal[2]]])


def _between(a: FloatArray, b: FloatArray) -> FloatArray:
    """(n,) degrees between axes (n, 3)."""
    return np.asarray(np.degrees(np.arccos(np.clip(np.abs((a * b).sum(axis=1)), 0.0, 1.0))))


def _agreed(model: FloatArray, world: FloatArray) -> FloatArray | None:
    """(3, 3) the rotation that leaves the least median angle."""
    best: tuple[float, FloatArray] | None = None
    for rotation in rotations_by_pairs(model, world):
        middle = float(np.median(_between(model @ rotation.T, world)))
        if best is None or middle < best[0]:
            best = middle, rotation
    return None if best is None else best[1]


def rotations_by_pairs(
    model: FloatArray, world: FloatArray, *, axial: bool = True
) -> list[FloatArray]:
    """(3, 3) each: the rotations that two directions of (n, 3) determine, of all pairs or, where
    these are many, of some by chance. axial : a direction and its opposite are the same"""
    pairs = list(combinations(range(len(model)), 2))
    if len(pairs) > _TRIALS:
        chosen = np.random.default_rng(0).choice(len(pairs), _TRIALS, replace=False)
        pairs = [pairs[int(i)] for i in chosen]
    signs = (1.0, -1.0) if axial else (1.0,)
    found = []
    for i, k in pairs:
        here = _frame(model[i], model[k])
        if here is None:
            continue
        for first, second in product(signs, repeat=2):
            there = _frame(first * world[i], second * world[k])
            if there is not None:
                found.append(there @ here.T)
    return found


def _frame(a: FloatArray, b: FloatArray) -> FloatArray | None:
    """(3, 3) axes by two directions, that treat both alike; None where they are nearly parallel."""
    across = np.cross(a, b)
    length = float(np.linalg.norm(across))
    if length < _APART:
        return None
    middle = a + b
    middle = middle / np.linalg.norm(middle)
    normal = across / length
    return np.column_stack([middle, normal, np.cross(middle, normal)])
