"""Observations that cannot be right: too far from where all others put them to be chance.

Each is left out in turn; its miss from what the others say is held against their error (the
deletion residual; Baarda 1968; Cook & Weisberg 1982, Residuals and Influence in Regression, 2.2.2),
and the worst one is removed as long as one is significant, since one mistake hides another.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from difflib import get_close_matches
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.registration.adjustment import AS_GOOD, Adjusted, adjust, weighed_rows
from vomstudio.registration.combined import Combined
from vomstudio.registration.compass_checks import azimuth_that_fits
from vomstudio.registration.observations import (
    Azimuths,
    Directions,
    KeptScale,
    LevelLines,
    Observed,
    PhotoUpright,
    PlumbLines,
    Points,
    Verticals,
)
from vomstudio.registration.similarity import Similarity, fit_robustly, fit_similarity

# Of the size of the model, or rad: closer than this is rounding.
_ROUNDING = 1e-9
# Of the whole set of a right registration one in a thousand is accused.
_BY_CHANCE = 0.001
# Points: of fewer nobody can say which agree. Of six, four agree so much better than all of them by
# chance (15 ways to choose them, 5 free misses) in less than one set in two thousand.
_FEWEST_TO_HIDE, _SIX_TO_HIDE, _BETTER_BY = 7, 6, 100.0
# Directions that are left out one by one: of fewer none can be wrong, of more the misses tell.
_FEWEST_DIRECTIONS, _FEW_DIRECTIONS = 4, 12
# What a reading is usually off, and how many misses that counts as beside those that are there: by
# four planes alone nobody could say that one of them is wrong.
_USUAL_RAD, _USUAL_COUNTS = np.radians(3.0), 4.0
_FITS_DEG = (10.0, 20.0)
_DIRECTIONS = Directions | Azimuths | LevelLines | PlumbLines | PhotoUpright | Verticals
# Misses that are so many times the usual are looked into.
_LARGE = 1.5


@dataclass(frozen=True)
class Blunder:
    """label : of the point or direction; photo : of the mark, None where no photos take part
    error_m : how far from where the others put it; error_deg : the same of a direction
    """

    label: str
    photo: str | None
    error_m: float | None
    error_deg: float | None = None

    def text(self) -> str:
        """Its label, and how far it is off where that is known."""
        if self.error_m is not None:
            return f"{self.label} ({self.error_m:.3g} m)"
        return self.label if self.error_deg is None else f"{self.label} ({self.error_deg:.2g}°)"


Single = tuple[int, int]
"""Number of its kind, and its row there."""


@dataclass(frozen=True)
class _Judged:
    """chance : of a miss as large; strength : its square over what is expected; of : so many are
    judged together"""

    single: Single
    chance: float
    strength: float
    of: int
    blunder: Blunder


@dataclass(frozen=True)
class Without:
    """The placement without one of a few directions. error_deg : how far that is from where the
    others put it; turned_deg : by how much the model turns without it; others_deg : how well the
    others then agree (RMS); weakest_95_deg : the worst error of the rotation then, None where that
    is not known; suspect : it is too far off to be chance; azimuth_off_deg : of a suspect,
    what added to its azimuth would make it agree, None where neither 90 nor 180 degrees would"""

    label: str
    error_deg: float
    turned_deg: float
    others_deg: float
    weakest_95_deg: float | None
    suspect: bool
    azimuth_off_deg: float | None = None


def find_blunders(
    kinds: Sequence[Observed], found: Adjusted, centre: FloatArray, size: float
) -> list[Blunder]:
    """The worst first; at most a third of all, since of more nobody can say which are right.

    One mistake makes others look wrong: what was named before the worst were out is held against
    the rest again, and cleared where it fits that.
    """
    named = _find_blunders(kinds, found, centre, size, trust_stated=True)
    if not np.isfinite(found.rows.sigma).any():
        return named or []
    if named is None or (named and not _explain_misfit(kinds, named, found, centre, size)):
        # The stated accuracies are too small, which is no blunder.
        named = _find_blunders(kinds, found, centre, size, trust_stated=False)
    return named or []


def _explain_misfit(
    kinds: Sequence[Observed],
    named: Sequence[Blunder],
    found: Adjusted,
    centre: FloatArray,
    size: float,
) -> bool:
    """Return whether the observations without the named ones agree with the stated accuracies.

    Those without the two worst or more may agree by chance, so the named ones must be farther off
    than the worst of so many are, whatever the accuracies.
    """
    from scipy.stats import f

    labels = {blunder.label for blunder in named}
    kinds = [chosen(kind, [label not in labels for label in kind.labels]) for kind in kinds]
    rest = adjust([kind for kind in kinds if len(kind.labels)], centre, size)
    if rest.overdrawn > 1.0 or len(named) == 1:
        return rest.overdrawn <= 1.0
    squares = [float(((each.rows.misses / each.sigma) ** 2).sum()) for each in (found, rest)]
    free = found.redundancy - rest.redundancy, rest.redundancy
    if min(free) < 1.0:
        return False
    ratio = (squares[0] - squares[1]) / free[0] / max(squares[1] / free[1], 1e-300)
    ways = math.comb(len(named) + sum(len(kind.labels) for kind in kinds), len(named))
    return ratio > float(f.isf(_BY_CHANCE / ways, *free))


def _find_blunders(
    kinds: Sequence[Observed],
    found: Adjusted,
    centre: FloatArray,
    size: float,
    *,
    trust_stated: bool,
) -> list[Blunder] | None:
    """trust_stated : residuals are compared with the stated errors, not with each other

    Returns None if more than a third would be named."""
    total = sum(len(kind.labels) for kind in kinds)
    out: list[Single] = []
    named: dict[Single, Blunder] = {}
    while len(named) < total // 3:
        worst = _worst(_judged(kinds, out, found, trust_stated=trust_stated))
        if worst is None:
            break
        out.append(worst.single)
        named[worst.single] = worst.blunder
        found = _adjusted(kinds, out, centre, size)
    else:
        # As many as can be named at all: then it is not these that are wrong.
        if total // 3 and _worst(_judged(kinds, out, found, trust_stated=trust_stated)) is not None:
            return None
    if not named and (hidden := _hidden(kinds)):
        # Mistakes that hide each other: each is held against those that agree.
        out = hidden
        named = {one: Blunder(kinds[one[0]].labels[one[1]], None, None) for one in hidden}
        _cleared(kinds, out, named, centre, size, trust_stated=trust_stated)
        return list(named.values())
    if len(out) > 1:
        _cleared(kinds, out, named, centre, size, trust_stated=trust_stated)
    return list(named.values())


def _hidden(kinds: Sequence[Observed]) -> list[Single]:
    """Points that a fit by most of them leaves out; none where they are more than can be named."""
    total = sum(len(kind.labels) for kind in kinds)
    found: list[Single] = []
    for at, kind in enumerate(kinds):
        if isinstance(kind, Points) and len(kind.labels) >= _SIX_TO_HIDE:
            try:
                fit, agree = fit_robustly(kind.model, kind.world)
            except GeometryError:
                continue
            if len(kind.labels) < _FEWEST_TO_HIDE and not _far_better(kind, fit, agree):
                continue
            found += [(at, int(row)) for row in np.flatnonzero(~agree)]
    return found if len(found) <= total // 3 else []


def _far_better(points: Points, fit: Similarity, agree: BoolArray) -> bool:
    """Whether those of the points that agree do so far better than all of them."""

    def variance(which: BoolArray, by: Similarity) -> float:
        misses = by(points.model[which]) - points.world[which]
        return float((misses**2).sum()) / (3 * int(which.sum()) - 7)

    every = np.ones(len(agree), np.bool_)
    whole = fit_similarity(points.model, points.world)
    return variance(every, whole) > _BETTER_BY * variance(agree, fit)


def _cleared(
    kinds: Sequence[Observed],
    out: list[Single],
    named: dict[Single, Blunder],
    centre: FloatArray,
    size: float,
    *,
    trust_stated: bool,
) -> None:
    """Takes out of both what fits the rest; the others are described by their miss from it."""
    total = sum(len(kind.labels) for kind in kinds)
    for single in [*out]:
        tried = [other for other in out if other != single]
        rest = _adjusted(kinds, tried, centre, size)
        again = _judged(kinds, tried, rest, trust_stated=trust_stated)
        judged = next((one for one in again if one.single == single), None)
        if judged is None:
            continue
        if judged.chance < _BY_CHANCE / total:
            named[single] = judged.blunder
        else:
            out.remove(single)
            del named[single]


def _adjusted(
    kinds: Sequence[Observed], out: Sequence[Single], centre: FloatArray, size: float
) -> Adjusted:
    return adjust([kind for _, kind, _ in _left(kinds, out)], centre, size)


def _left(
    kinds: Sequence[Observed], out: Sequence[Single]
) -> list[tuple[int, Observed, list[int]]]:
    """Number, what is left, and which rows these are, of each kind that has any left."""
    gone = set(out)
    found = []
    for at, kind in enumerate(kinds):
        rows = [row for row in range(len(kind.labels)) if (at, row) not in gone]
        if rows:
            keep = [(at, row) not in gone for row in range(len(kind.labels))]
            found.append((at, chosen(kind, keep), rows))
    return found


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


def _worst(judged: Sequence[_Judged]) -> _Judged | None:
    """The least likely one that chance does not explain. Chances of gross mistakes are all nought
    in figures of the machine; of these the one that is farthest out counts."""
    wrong = [one for one in judged if one.chance < _BY_CHANCE / one.of]
    return min(wrong, key=lambda one: (one.chance, -one.strength)) if wrong else None


def _judged(
    kinds: Sequence[Observed], out: Sequence[Single], found: Adjusted, *, trust_stated: bool
) -> list[_Judged]:
    """Each one that the others say something of, held against these."""
    from scipy.stats import chi2, f

    rows, sigma = found.rows, found.sigma
    stated = np.isfinite(rows.sigma) & trust_stated
    moves, covariance = weighed_rows(found)
    misses = rows.misses / sigma
    free = found.redundancy
    squares = float((misses**2).sum())
    left = _left(kinds, out)
    total = sum(len(kind.labels) for _, kind, _ in left)
    tested: list[tuple[Single, Observed, int, FloatArray]] = []
    statistics: list[tuple[float, int, bool]] = []
    for place, (at, kind, own) in enumerate(left):
        if isinstance(kind, KeptScale | PhotoUpright):
            continue
        first, last = found.begins[place], found.begins[place + 1]
        width = (last - first) // len(kind.labels)
        for number, row in enumerate(own):
            which = slice(first + number * width, first + (number + 1) * width)
            rest = np.eye(width) - moves[which] @ covariance @ moves[which].T
            if np.linalg.eigvalsh(rest)[0] < 1e-6 or free - width < 1:
                # Nothing else says where it should be.
                continue
            deleted = np.linalg.solve(rest, misses[which])
            if np.linalg.norm(deleted * sigma[which]) < _ROUNDING * max(found.size, 1.0):
                continue
            tested.append(((at, row), kind, number, deleted * sigma[which]))
            statistic = float(misses[which] @ deleted)
            statistics.append((statistic, width, bool(stated[which].all())))
    if not tested:
        return []
    squared, widths, known = (np.array(column) for column in zip(*statistics, strict=True))
    others = np.where(known, 1.0, np.maximum((squares - squared) / (free - widths), 1e-300))
    strength = squared / widths / others
    # All at once: a call of scipy's costs as much as the rest of a point.
    chance = np.where(
        known, chi2.sf(squared, widths), f.sf(strength, widths, np.maximum(free - widths, 1))
    )
    return [
        _Judged(single, float(p), float(s), total, _described(kind, kind.labels[number], miss))
        for (single, kind, number, miss), p, s in zip(tested, chance, strength, strict=True)
    ]


def _described(kind: Observed, label: str, error: FloatArray) -> Blunder:
    if isinstance(kind, Combined):
        return Blunder(label, None, *kind.size_of(error))
    size = float(np.linalg.norm(error))
    if isinstance(kind, Points) or hasattr(kind, "length"):
        return Blunder(label, None, size)
    return Blunder(label, None, None, float(np.degrees(size)))


def left_out(
    kinds: Sequence[Observed], check: Points | None, labels: Sequence[str]
) -> tuple[list[Observed], Points | None]:
    """The observations and check points without those of the labels. Raises UsageError for a label
    that is none of theirs."""
    every = [label for kind in kinds for label in kind.labels]
    every += [] if check is None else list(check.labels)
    for label in labels:
        if label not in every:
            near = get_close_matches(label, every, 3) or every[:8]
            raise UsageError(
                Finding("registration.unknown-label", label=label, known=", ".join(near)),
                field="--without",
            )

    def rest(kind: Observed) -> Observed:
        return chosen(kind, [label not in labels for label in kind.labels])

    left = [rest(kind) for kind in kinds]
    judges = None if check is None else rest(check)
    assert judges is None or isinstance(judges, Points)
    return [kind for kind in left if len(kind.labels)], judges


# --- few directions ---------------------------------------------------------------------------
def leave_one_out(
    kinds: Sequence[Observed], found: Adjusted, centre: FloatArray, size: float
) -> list[Without]:
    """A placement by a few directions alone, without each of them, the most suspicious first; empty
    where they agree, or where they are more, and misses tell.

    One wrong one of a few pulls the placement to itself and hides in what is left over; where no
    accuracies are stated, it also makes these seem as bad. So each is left out, and held against
    the others' own agreement, to which the usual error of a compass adds a few misses' worth.
    """
    total = sum(len(kind.labels) for kind in kinds if isinstance(kind, Directions))
    alone = all(isinstance(k, _DIRECTIONS) for k in kinds)
    if not alone or not _FEWEST_DIRECTIONS <= total <= _FEW_DIRECTIONS:
        return []
    usual = np.where(np.isfinite(found.rows.sigma), found.rows.sigma, _USUAL_RAD)
    whole = float(((found.rows.misses / usual) ** 2).sum())
    if found.redundancy < 3.0 or whole <= _LARGE**2 * found.redundancy:
        return []
    if found.ambiguous:
        # Of rotations that fit alike it is the one that tilts least, not the one that fits best.
        whole -= AS_GOOD
    return _one_by_one(kinds, found, centre, size, whole)


def _one_by_one(
    kinds: Sequence[Observed], found: Adjusted, centre: FloatArray, size: float, whole: float
) -> list[Without]:
    from scipy.spatial.transform import Rotation
    from scipy.stats import chi2, f

    stated = bool(np.isfinite(found.rows.sigma).all())
    tried: list[tuple[float, float, Without]] = []
    singles = [
        (at, row)
        for at, kind in enumerate(kinds)
        if isinstance(kind, Directions)
        for row in range(len(kind.labels))
    ]
    for single in singles:
        kind = kinds[single[0]]
        assert isinstance(kind, Directions)
        try:
            again = _adjusted(kinds, [single], centre, size)
        except GeometryError:
            continue
        usual = np.where(np.isfinite(again.rows.sigma), again.rows.sigma, _USUAL_RAD)
        rest = float(((again.rows.misses / usual) ** 2).sum())
        free = again.redundancy
        gain = max(whole - rest, 0.0)
        if stated:
            chance = float(chi2.sf(gain, 2))
        else:
            pooled = (rest + _USUAL_COUNTS) / (free + _USUAL_COUNTS)
            chance = float(f.sf(gain / 2.0 / pooled, 2, free + _USUAL_COUNTS))
        placed = again.fit.rotation @ kind.model[single[1]]
        others = float(np.degrees(np.sqrt((again.rows.misses**2).mean())))
        cosine = float(placed @ kind.world[single[1]])
        turned = Rotation.from_matrix(again.fit.rotation @ found.fit.rotation.T).magnitude()
        worst = 1.96 * float(np.degrees(np.sqrt(np.linalg.eigvalsh(again.rotation)[-1])))
        # The others, being few, do not say well where it should be.
        limit = float(np.clip(max(3.0 * others, 2.0 * worst), *_FITS_DEG))
        fits = azimuth_that_fits(placed, kind.world[single[1]], limit)
        tried.append(
            (
                rest,
                chance,
                Without(
                    kind.labels[single[1]],
                    float(
                        np.degrees(
                            np.arccos(np.clip(abs(cosine) if kind.axial else cosine, -1.0, 1.0))
                        )
                    ),
                    float(np.degrees(turned)),
                    others,
                    None if again.free[:3].size and np.abs(again.free[:3]).max() > 1e-6 else worst,
                    suspect=False,
                    azimuth_off_deg=fits,
                ),
            )
        )
    tried.sort(key=lambda each: each[0])
    found_out = [replace(each, azimuth_off_deg=None) for _, _, each in tried]
    if tried and tried[0][1] < _BY_CHANCE / len(tried):
        found_out[0] = replace(tried[0][2], suspect=True)
    return found_out
