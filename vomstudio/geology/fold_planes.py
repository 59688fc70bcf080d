"""Selection of the planes for a fold axis, shared by tables, nets, statistics and views.

Planes have equal weights regardless of their errors, because the scatter of real folds exceeds the
errors. Every axis is therefore reported with the number of planes whose verdict is not good.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

VERDICT_NAMES = ("good", "doubtful", "poor")
MIN_QUALITIES = VERDICT_NAMES[:2]
"""Verdicts that can be required as a minimum."""


@dataclass(frozen=True)
class FoldFilter:
    """Filter for the planes from which a fold axis is computed.

    Parameters
    ----------
    min_quality : {"good", "doubtful"} or None
        Worst verdict to accept. If None, any verdict is accepted.
    set_name : str or None
        Name of the only set to use. If None, all sets are used.
    """

    min_quality: str | None = None
    set_name: str | None = None

    def __post_init__(self) -> None:
        if self.min_quality not in (None, *MIN_QUALITIES):
            raise ValueError(f"unknown quality {self.min_quality!r}; use one of {MIN_QUALITIES}")


@dataclass(frozen=True)
class ExcludedRows:
    """Number of excluded rows, with their description and the reason for the exclusion."""

    what: str
    n: int
    reason: Finding


@dataclass(frozen=True, eq=False)
class SelectedPlanes:
    """Result of `select_planes`.

    Attributes
    ----------
    is_used : (n,) ndarray of bool
    left_out : tuple of ExcludedRows
    not_good : int or None
        Number of selected planes whose verdict is not good; None if no plane has a verdict.
    """

    is_used: BoolArray
    left_out: tuple[ExcludedRows, ...]
    not_good: int | None


def parse_verdict(word: str | None) -> str:
    """Parse the verdict in a table cell.

    Parameters
    ----------
    word : str or None

    Returns
    -------
    str
        The verdict, or "" if the cell does not contain one.
    """
    text = (word or "").strip().casefold()
    return text if text in VERDICT_NAMES else ""


def select_planes(
    qualities: Sequence[str | None], sets: Sequence[str], selection: FoldFilter
) -> SelectedPlanes:
    """Select the planes of one kind from which a fold axis is computed.

    Planes without a verdict, such as compass readings, are used only if no plane has a verdict and
    no verdict is required.

    Parameters
    ----------
    qualities : (n,) sequence of str or None
        Verdicts; other texts are ignored.
    sets : (n,) sequence of str
        Name of the set of each plane; "" if it has none.
    selection : FoldFilter

    Returns
    -------
    SelectedPlanes
    """
    verdicts = np.array([parse_verdict(quality) for quality in qualities], np.str_)
    is_used = np.ones(len(verdicts), bool)
    excluded_rows = []

    def exclude_rows(is_excluded: BoolArray, subject: str, reason: Finding) -> None:
        nonlocal is_used
        if count := int((is_used & is_excluded).sum()):
            excluded_rows.append(ExcludedRows(subject, count, reason))
        is_used = is_used & ~is_excluded

    if selection.set_name is not None:
        name = selection.set_name.strip().casefold()
        is_other_set = np.array([item.strip().casefold() != name for item in sets], bool)
        exclude_rows(
            is_other_set, tr("other sets"), Finding("fold.only-set", set=selection.set_name)
        )
    has_verdict = verdicts != ""
    if (has_verdict & is_used).any() or selection.min_quality is not None:
        exclude_rows(~has_verdict, tr("without a verdict"), Finding("fold.only-picks"))
    if selection.min_quality is not None:
        for quality in VERDICT_NAMES[VERDICT_NAMES.index(selection.min_quality) + 1 :]:
            reason = Finding("fold.only-quality", quality=selection.min_quality)
            exclude_rows(verdicts == quality, quality, reason)
    is_judged = has_verdict & is_used
    not_good = int((is_judged & (verdicts != "good")).sum()) if is_judged.any() else None
    return SelectedPlanes(is_used, tuple(excluded_rows), not_good)
