"""What a table of points says of each feature beside its points: kind and set."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import TypeVar

from vomstudio.core.findings import Finding

COLUMNS = ("kind", "set")

Group = TypeVar("Group", bound=Hashable)
Words = dict[str, dict[Group, str]]


def words_of_groups(
    columns: Mapping[str, Sequence[str]], groups: Sequence[Group], keep: Sequence[bool]
) -> tuple[Words[Group], list[Finding]]:
    """By column, the word of each group in which all points have the same one; and sentences on
    those whose points have several.

    columns : words of every row, by the names of the columns; groups : of every row; keep : rows
    that count
    """
    found: Words[Group] = {}
    said = []
    for column, cells in columns.items():
        seen: dict[Group, set[str]] = {}
        for group, word, counts in zip(groups, cells, keep, strict=True):
            if counts:
                seen.setdefault(group, set()).add(word.strip())
        found[column] = {name: min(words) for name, words in seen.items() if len(words) == 1}
        several = [str(name) for name, words in seen.items() if len(words) > 1]
        if several:
            said.append(Finding("table.several-words", column=column, names=several))
    return found, said
