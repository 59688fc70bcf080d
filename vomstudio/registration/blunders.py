"""Observations that cannot be right: too far from where all others put them to be chance.

Each is left out in turn; its miss from what the others say is held against their error (the
deletion residual; Baarda 1968; Cook & Weisberg 1982, Residuals and Influence in Regression, 2.2.2),
and the worst one is removed as long as one is significant, since one mistake hides another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.registration.adjustment import Adjusted, adjust, weighed_rows
from vomstudio.registration.combined import Combined
from vomstudio.registration.observations import Observed, Points

Array = npt.NDArray[np.float64]

# Of the size of the model, or rad: closer than this is rounding.
_ROUNDING = 1e-9
# Of the whole set of a right registration one in a thousand is accused.
_BY_CHANCE = 0.001


@dataclass(frozen=True)
class Blunder:
    """label : of the point or direction; photo : of the mark, None where no photos take part
    error_m : how far from where the others put it; error_deg : the same of a direction
    """

    label: str
    photo: str | None
    error_m: float | None
    error_deg: float | None = None


def find_blunders(
    kinds: Sequence[Observed], found: Adjusted, centre: Array, size: float
) -> list[Blunder]:
    """The worst first; at most a third of all, since of more nobody can say which are right."""
    kinds = list(kinds)
    total = sum(len(kind.labels) for kind in kinds)
    named: list[Blunder] = []
    while len(named) < total // 3:
        worst = _worst(kinds, found)
        if worst is None:
            return named
        at, row, blunder = worst
        named.append(blunder)
        keep = [i != row for i in range(len(kinds[at].labels))]
        kinds[at] = chosen(kinds[at], keep)
        kinds = [kind for kind in kinds if len(kind.labels)]
        found = adjust(kinds, centre, size)
    # As many as can be named at all: then it is not these that are wrong.
    return [] if _worst(kinds, found) is not None else named


def chosen(kind: Observed, keep: Sequence[bool]) -> Observed:
    """The same kind of observation with the single ones that are kept."""
    which = np.flatnonzero(keep)
    n = len(kind.labels)
    changed: dict[str, Any] = {"labels": [kind.labels[int(i)] for i in which]}
    for field in fields(kind):  # type: ignore[arg-type]
        value = getattr(kind, field.name)
        if isinstance(value, np.ndarray) and len(value) == n:
            changed[field.name] = value[which]
    made: Observed = replace(kind, **changed)  # type: ignore[type-var]
    return made


def _worst(kinds: Sequence[Observed], found: Adjusted) -> tuple[int, int, Blunder] | None:
    """Kind, place in it and description of the least likely one that chance does not explain."""
    from scipy.stats import chi2, f

    rows, sigma = found.rows, found.sigma
    stated = np.isfinite(rows.sigma)
    moves, covariance = weighed_rows(found)
    misses = rows.misses / sigma
    free = found.redundancy
    squares = float((misses**2).sum())
    total = sum(len(kind.labels) for kind in kinds)
    best: tuple[float, int, int, Blunder] | None = None
    for at, kind in enumerate(kinds):
        first, last = found.begins[at], found.begins[at + 1]
        width = (last - first) // len(kind.labels)
        for row in range(len(kind.labels)):
            which = slice(first + row * width, first + (row + 1) * width)
            left = np.eye(width) - moves[which] @ covariance @ moves[which].T
            values = np.linalg.eigvalsh(left)
            if values[0] < 1e-6 or free - width < 1:
                # Nothing else says where it should be.
                continue
            deleted = np.linalg.solve(left, misses[which])
            if np.linalg.norm(deleted * sigma[which]) < _ROUNDING * max(found.size, 1.0):
                continue
            statistic = float(misses[which] @ deleted)
            if stated[which].all():
                chance = float(chi2.sf(statistic, width))
            else:
                rest = max((squares - statistic) / (free - width), 1e-300)
                chance = float(f.sf(statistic / width / rest, width, free - width))
            if chance < _BY_CHANCE / total and (best is None or chance < best[0]):
                error = deleted * sigma[which]
                best = chance, at, row, _described(kind, kind.labels[row], error)
    return None if best is None else best[1:]


def _described(kind: Observed, label: str, error: Array) -> Blunder:
    if isinstance(kind, Combined):
        return Blunder(label, None, *kind.size_of(error))
    size = float(np.linalg.norm(error))
    if isinstance(kind, Points) or hasattr(kind, "length"):
        return Blunder(label, None, size)
    return Blunder(label, None, None, float(np.degrees(size)))
