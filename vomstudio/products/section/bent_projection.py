"""Lines projected onto a section with bends: each part onto the piece of the section before which
it lies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.products.ortho.interpretation import Flat, Item, flattened
from vomstudio.products.section.section_lines import Panel

PIECES = 256
"""Into so many steps a line is divided, to find where it passes from one piece to another."""
_JUMP = 2.0
"""A line is broken where a step is longer on the section, by this factor, than it is in space."""


def projected_along_bends(
    item: Item, panels: Sequence[Panel], along: FloatArray | None
) -> tuple[Flat, ...]:
    """The parts of a line or outline (n > 1 points) that lie before one of the panels. Where two
    have it before them it is on the nearer one: on the inner side of a bend it is broken there. On
    the outer side there is a wedge that lies before none, which is passed over. A part of an
    outline is a line."""
    points, own = _divided(item.points)
    best = np.full(len(points), np.inf)
    which = np.full(len(points), -1)
    flat = np.zeros((len(points), 2))
    away = np.zeros(len(points))
    for k, panel in enumerate(panels):
        one = flattened(replace(item, points=points), panel.origin, panel.right, panel.up, along)
        if one is None:
            continue
        x = one.points[:, 0]
        nearer = (x >= panel.low) & (x <= panel.high) & (np.abs(one.away) < best)
        best[nearer], which[nearer] = np.abs(one.away[nearer]), k
        away[nearer] = one.away[nearer]
        flat[nearer] = one.points[nearer] + [panel.start, panel.level]
    inside = np.flatnonzero(which >= 0)
    if len(inside) == len(points) and (which == which[0]).all():
        return (Flat(item, flat[own], away[own], None),)
    steps = np.linalg.norm(np.diff(points[inside], axis=0), axis=1)
    drawn = np.linalg.norm(np.diff(flat[inside], axis=0), axis=1)
    broken = np.flatnonzero(drawn > _JUMP * steps + 1e-12) + 1
    piece = replace(item, form="line", filled=False) if item.form == "ring" else item
    found = []
    for run in np.split(inside, broken):
        if len(run) < 2:
            continue
        # The vertices, both ends, and where the line passes from one piece to another.
        keep = own[run]
        keep[[0, -1]] = True
        passes = np.flatnonzero(np.diff(which[run]))
        keep[passes] = keep[passes + 1] = True
        rows = run[keep]
        found.append(Flat(piece, flat[rows], away[rows], None))
    return tuple(found)


def _divided(points: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Points with others between them, and which of them are the given ones."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    step = max(float(lengths.sum()) / PIECES, 1e-12)
    counts = np.maximum(1, np.ceil(lengths / step)).astype(int)
    parts, own = [], []
    for a, b, n in zip(points[:-1], points[1:], counts.tolist(), strict=True):
        parts.append(a + (b - a) * np.arange(n)[:, None] / n)
        own.append(np.arange(n) == 0)
    return np.concatenate([*parts, points[-1:]]), np.concatenate([*own, [True]])
