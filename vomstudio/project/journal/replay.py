"""Interface of a journal, and replay of its rows into the records of a project."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.plain_data import PlainValues
from vomstudio.project.codec import decode_edit
from vomstudio.project.edit import Edit
from vomstudio.project.garbage_collection import pause_collection
from vomstudio.project.records import Record

RowKind = Literal["do", "amend", "undo", "redo", "save", "discard", "draft"]


@dataclass(frozen=True)
class JournalRow:
    """Row of a journal.

    The meaning of the fields depends on `kind`:

    - "do", "discard": `before` and `after` map an ID to None, a complete record, or its changed
      fields (`codec`). For "do", `of_seq` is the draft that the row finishes.
    - "amend": Like "do", but replaces the newest "do", which is row `of_seq`, as in repeated
      nudges.
    - "undo", "redo": `of_seq` is the row that is undone or redone.
    - "draft": `after` is the state of an unfinished tool, or None after the tool was cancelled.
    - "gap": Placeholder for missing rows, which is read but never written.
    """

    seq: int
    kind: str
    of_seq: int | None
    label: str
    before: PlainValues | None
    after: PlainValues | None
    time: str
    version: str
    settings: PlainValues | None
    problem: Finding | None = None
    """Reason why the row is not valid; such a row is reported and skipped."""
    notice: Finding | None = None
    """Problem before this row, which itself is valid, such as missing rows."""


class Journal(Protocol):
    """Append-only journal; a row is on disk when `append` returns."""

    def append(
        self,
        kind: RowKind,
        *,
        of_seq: int | None = None,
        label: str = "",
        before: Mapping[str, Any] | None = None,
        after: Mapping[str, Any] | None = None,
        settings: Mapping[str, Any] | None = None,
    ) -> int:
        """Append a row and return its number. Raises DocumentError if it cannot be written."""

    def rows(self) -> Iterator[JournalRow]: ...

    def close(self) -> None: ...


@dataclass(frozen=True)
class Draft:
    """State of an unfinished tool, such as its clicked points."""

    seq: int
    state: PlainValues


@dataclass
class Replay:
    """Result of a replay: the records with the undo and redo history.

    Attributes
    ----------
    done, undone : list of tuple of int and Edit
        Stacks of row numbers and edits, newest last.
    saved_records, saved_top
        Records at the last save, and the row that was on top of `done` then (0 if there was none).
    settings : dict
        Settings stored with the newest edit.
    problems : list of Finding
        Findings for rows that could not be read; all other data are complete.
    """

    records: dict[str, Record] = field(default_factory=dict)
    done: list[tuple[int, Edit]] = field(default_factory=list)
    undone: list[tuple[int, Edit]] = field(default_factory=list)
    saved_records: dict[str, Record] = field(default_factory=dict)
    saved_top: int = 0
    draft: Draft | None = None
    settings: PlainValues = field(default_factory=dict)
    problems: list[Finding] = field(default_factory=list)

    @property
    def top(self) -> int:
        return self.done[-1][0] if self.done else 0


def replay(rows: Iterable[JournalRow]) -> Replay:
    """Replay a journal from its first row. Damaged rows are reported and skipped."""
    with pause_collection():
        return _replay(rows)


def _replay(rows: Iterable[JournalRow]) -> Replay:
    result = Replay()
    for row in rows:
        if row.notice:
            result.problems.append(row.notice)
        try:
            if row.problem:
                raise DocumentError(row.problem)
            result.settings = _row_settings(row) or result.settings
            _apply_row(result, row)
        except DocumentError as error:
            result.problems.append(
                Finding(
                    "journal.row-unreadable",
                    row=row.seq,
                    kind=row.kind,
                    label=row.label,
                    reason=error,
                    reason_code=error.code,
                )
            )
    return result


def _row_settings(row: JournalRow) -> PlainValues | None:
    if row.settings is not None and not isinstance(row.settings, Mapping):
        raise DocumentError(Finding("record.wrong-value"), field="settings")
    return None if row.settings is None else dict(row.settings)


def _apply_row(result: Replay, row: JournalRow) -> None:
    if row.kind in ("do", "discard", "amend"):
        edit = decode_edit(row.label, row.before or {}, row.after or {}, result.records)
        edit.swap(result.records, strict=False)
        if row.kind == "amend":
            edit = _merge_amended(result, row, edit)
        result.done.append((row.seq, edit))
        result.undone.clear()
        if result.draft is not None and row.of_seq == result.draft.seq:
            result.draft = None
    elif row.kind == "undo":
        for seq, edit in _pop_until(result.done, row):
            edit.inverse().swap(result.records, strict=False)
            result.undone.append((seq, edit))
    elif row.kind == "redo":
        for seq, edit in _pop_until(result.undone, row):
            edit.swap(result.records, strict=False)
            result.done.append((seq, edit))
    elif row.kind == "save":
        result.saved_records = dict(result.records)
        result.saved_top = result.top
    elif row.kind == "draft":
        if row.after is not None and not isinstance(row.after, Mapping):
            raise DocumentError(Finding("record.wrong-value"), field="draft")
        result.draft = None if row.after is None else Draft(row.seq, row.after)
    elif row.kind != "gap":
        raise DocumentError(Finding("row.unknown-kind", kind=row.kind))


def _merge_amended(result: Replay, row: JournalRow, edit: Edit) -> Edit:
    """Merge an edit with the edit that it amends."""
    if not result.done or result.done[-1][0] != row.of_seq:
        # The amended row was damaged, so only the change itself is known.
        return edit
    _, earlier_edit = result.done.pop()
    return earlier_edit.merge_with(edit)


def _pop_until(stack: list[tuple[int, Edit]], row: JournalRow) -> list[tuple[int, Edit]]:
    """Pop steps down to row `of_seq`, newest first.

    The steps above it belong to damaged rows that were skipped. Raises DocumentError if the row is
    missing.
    """
    if all(seq != row.of_seq for seq, _ in stack):
        raise DocumentError(Finding("row.target-missing", row=row.of_seq))
    steps = [stack.pop()]
    while steps[-1][0] != row.of_seq:
        steps.append(stack.pop())
    return steps
