"""Which planes a fold axis is computed from: one rule for tables, net, statistics and views.

Planes count alike, whatever their errors, since the scatter of real folds exceeds these. How many
of them are not good is therefore stated with every axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

VERDICTS = ("good", "doubtful", "poor")
MIN_QUALITIES = VERDICTS[:2]
"""Worst verdicts that can be required."""


@dataclass(frozen=True)
class FoldFilter:
    """Planes that a fold axis may be computed from.

    Parameters
    ----------
    min_quality : {"good", "doubtful"} or None
        Worst verdict that is used; None for any.
    set_name : str or None
        Only this set, in any case; None for all.
    """

    min_quality: str | None = None
    set_name: str | None = None

    def __post_init__(self) -> None:
        if self.min_quality not in (None, *MIN_QUALITIES):
            raise ValueError(f"unknown quality {self.min_quality!r}; use one of {MIN_QUALITIES}")


@dataclass(frozen=True)
class LeftOut:
    """So many rows that were not used, what they are, and why."""

    what: str
    n: int
    reason: Finding


@dataclass(frozen=True, eq=False)
class ChosenPlanes:
    """Result of `choose_planes`.

    Parameters
    ----------
    use : (n,) bool
    left_out : tuple of LeftOut
    not_good : int or None
        Planes in use whose verdict is not good; None if none of them has a verdict.
    """

    use: BoolArray
    left_out: tuple[LeftOut, ...]
    not_good: int | None


def verdict_in(word: str | None) -> str:
    """Return the verdict that a cell contains, "" for none."""
    text = (word or "").strip().casefold()
    return text if text in VERDICTS else ""


def choose_planes(
    qualities: Sequence[str | None], sets: Sequence[str], which: FoldFilter
) -> ChosenPlanes:
    """Choose the planes of one kind that a fold axis is computed from.

    Planes without a verdict, such as compass readings, are used only if none has one.

    Parameters
    ----------
    qualities : (n,) verdicts; None and other words are no verdicts
    sets : (n,) names of their sets, "" for none
    which : FoldFilter
    """
    verdict = np.array([verdict_in(quality) for quality in qualities], np.str_)
    use = np.ones(len(verdict), bool)
    left_out = []

    def leave_out(bad: BoolArray, what: str, reason: Finding) -> None:
        nonlocal use
        if count := int((use & bad).sum()):
            left_out.append(LeftOut(what, count, reason))
        use = use & ~bad

    if which.set_name is not None:
        name = which.set_name.strip().casefold()
        other = np.array([each.strip().casefold() != name for each in sets], bool)
        leave_out(other, tr("other sets"), Finding("fold.only-set", set=which.set_name))
    judged = verdict != ""
    if (judged & use).any() or which.min_quality is not None:
        leave_out(~judged, tr("without a verdict"), Finding("fold.only-picks"))
    if which.min_quality is not None:
        for quality in VERDICTS[VERDICTS.index(which.min_quality) + 1 :]:
            reason = Finding("fold.only-quality", quality=which.min_quality)
            leave_out(verdict == quality, quality, reason)
    known = judged & use
    not_good = int((known & (verdict != "good")).sum()) if known.any() else None
    return ChosenPlanes(use, tuple(left_out), not_good)
