"""Kind and set of features in a table of points."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import TypeVar

from vomstudio.core.findings import Finding

GROUP_COLUMNS = ("kind", "set")

Group = TypeVar("Group", bound=Hashable)
Words = dict[str, dict[Group, str]]


def group_words(
    columns: Mapping[str, Sequence[str]], groups: Sequence[Group], is_used_row: Sequence[bool]
) -> tuple[Words[Group], list[Finding]]:
    """Return the word of each group in each column if it is the same for all points.

    Parameters
    ----------
    columns : mapping of str to sequence of str
        Words of each row, by column.
    groups : sequence of hashable
        Group of each row.
    is_used_row : sequence of bool
        Rows to use.

    Returns
    -------
    words : dict
        Words by column and group.
    findings : list of Finding
        Findings about groups with several words.
    """
    words_by_column: Words[Group] = {}
    findings = []
    for column, cells in columns.items():
        words_by_group: dict[Group, set[str]] = {}
        for group, word, is_used in zip(groups, cells, is_used_row, strict=True):
            if is_used:
                words_by_group.setdefault(group, set()).add(word.strip())
        words_by_column[column] = {
            name: min(words) for name, words in words_by_group.items() if len(words) == 1
        }
        ambiguous_names = [str(name) for name, words in words_by_group.items() if len(words) > 1]
        if ambiguous_names:
            findings.append(Finding("table.several-words", column=column, names=ambiguous_names))
    return words_by_column, findings
