"""What planes by compass look like that do not agree with the others: a strike that was read as dip
direction, or the opposite direction.

The rotation that most planes agree on is found by least median of squares over pairs of planes
(Rousseeuw 1984); the others are held against it as they are, and with their azimuth read in another
way."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import numpy.typing as npt

from vomstudio.words import tr

Array = npt.NDArray[np.float64]

_FEWEST = 5
_TRIALS = 200
_FAR_DEG = 15.0
_TIMES = 5.0
_NAMED = 8
# Planes whose normals are nearer to each other fix no rotation.
_APART = np.sin(np.radians(15.0))
_TURNS = (90.0, -90.0, 180.0)


def said_of_azimuths(labels: Sequence[str], model: Array, world: Array) -> list[str]:
    """Of planes that agree with the others if their azimuth is read in another way.

    model, world : (n, 3) unit normals; a normal and its opposite are the same
    """
    if len(labels) < _FEWEST:
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
    said = []
    for turn, names in named.items():
        some = ", ".join(names[:_NAMED])
        if turn == 180.0:
            said.append(
                tr(
                    "{names}: would agree with the others if the plane dipped the opposite way. "
                    "Add 180° to the dip direction, or look it up.",
                    names=some,
                )
            )
        else:
            said.append(
                tr(
                    "{names}: would agree with the others if {turn:+.0f}° were added to the dip "
                    "direction: the strike may have been read as dip direction.",
                    names=some,
                    turn=turn,
                )
            )
    return said


def _turned(normal: Array, azimuth_deg: float) -> Array:
    """(1, 3) the normal of a plane with so much added to its azimuth."""
    c, s = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
    # Azimuths run clockwise.
    return np.array([[c * normal[0] + s * normal[1], c * normal[1] - s * normal[0], normal[2]]])


def _between(a: Array, b: Array) -> Array:
    """(n,) degrees between axes (n, 3)."""
    return np.asarray(np.degrees(np.arccos(np.clip(np.abs((a * b).sum(axis=1)), 0.0, 1.0))))


def _agreed(model: Array, world: Array) -> Array | None:
    """(3, 3) the rotation that leaves the least median angle."""
    chance = np.random.default_rng(0)
    best: tuple[float, Array] | None = None
    for _ in range(_TRIALS):
        i, k = chance.choice(len(model), 2, replace=False)
        here = _frame(model[i], model[k])
        if here is None:
            continue
        for first, second in product((1.0, -1.0), repeat=2):
            there = _frame(first * world[i], second * world[k])
            if there is None:
                continue
            rotation = there @ here.T
            middle = float(np.median(_between(model @ rotation.T, world)))
            if best is None or middle < best[0]:
                best = middle, rotation
    return None if best is None else best[1]


def _frame(a: Array, b: Array) -> Array | None:
    """(3, 3) axes by two directions, that treat both alike; None where they are nearly parallel."""
    across = np.cross(a, b)
    length = float(np.linalg.norm(across))
    if length < _APART:
        return None
    middle = a + b
    middle = middle / np.linalg.norm(middle)
    normal = across / length
    return np.column_stack([middle, normal, np.cross(middle, normal)])
