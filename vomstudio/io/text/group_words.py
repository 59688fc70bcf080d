"""What a table of points says of each feature beside its points: kind and set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vomstudio.words import tr

_COLUMNS = ("kind", "set")


class Table(Protocol):
    """What is needed of a table: columns by their names, and their words."""

    def has(self, name: str, /) -> bool: ...
    def find(self, key: str, /) -> int: ...
    def cells(self, column: int, /) -> list[str]: ...


def words_of_groups(
    table: Table,
    groups: Sequence[str],
    keep: NDArray[np.bool_],
    by: str | None,
    warnings: list[str],
) -> dict[str, Mapping[str, str]]:
    """By column `kind` or `set`, the word of each group in which all points have the same one.

    groups : of every row; keep : rows that count; by : the column that the groups are named by,
    which says nothing more of them; warnings : here is said which groups have several
    """
    found: dict[str, Mapping[str, str]] = {}
    for column in _COLUMNS:
        if by is None or by == column or not table.has(column):
            continue
        seen: dict[str, set[str]] = {}
        for group, word, counts in zip(
            groups, table.cells(table.find(column)), keep.tolist(), strict=True
        ):
            if counts:
                seen.setdefault(group, set()).add(word.strip())
        found[column] = {name: min(words) for name, words in seen.items() if len(words) == 1}
        several = [name for name, words in seen.items() if len(words) > 1]
        if several:
            warnings.append(
                tr(
                    "The points of {names} have more than one {column}, so that none is taken. "
                    "Give all points of one feature the same.",
                    names=", ".join(several[:5]),
                    column=column,
                )
            )
    return found
