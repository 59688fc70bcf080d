"""What the document asks of its journal, and how a journal becomes a document again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from vomstudio.document.codec import Plain, decode_changes
from vomstudio.document.edit import Edit
from vomstudio.document.records import Record
from vomstudio.errors import DocumentError

RowKind = Literal["do", "undo", "redo", "save", "discard", "draft"]


@dataclass(frozen=True)
class Row:
    """One line of the journal.

    do, discard: `before` and `after` are maps id -> record (None where there is none); `of_seq` of
    a do is the draft that it finishes. undo, redo: `of_seq` is the row taken back or done again.
    draft: `after` is the state of an unfinished tool, None once it is cancelled.
    """

    seq: int
    kind: str
    of_seq: int | None
    label: str
    before: Plain | None
    after: Plain | None
    time: str
    version: str
    settings: Plain | None


class Journal(Protocol):
    """Append-only; a row is on the disk when `append` returns."""

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
        """The new row's number. Raises DocumentError where it cannot be written."""

    def rows(self) -> Iterator[Row]: ...

    def close(self) -> None: ...


@dataclass(frozen=True)
class Draft:
    """The clicks of a tool that had not been finished."""

    seq: int
    state: Plain


@dataclass
class Replay:
    """What a journal says: the records, and the way back and forth from them.

    done, undone: stacks of (row number, edit), the newest last. saved: the records at the last
    save; saved_top: the row that stood on top of `done` then (0 for none). settings: those written
    beside the newest edit. problems: sentences
    about rows that could not be read; everything else is there.
    """

    records: dict[str, Record] = field(default_factory=dict)
    done: list[tuple[int, Edit]] = field(default_factory=list)
    undone: list[tuple[int, Edit]] = field(default_factory=list)
    saved: dict[str, Record] = field(default_factory=dict)
    saved_top: int = 0
    draft: Draft | None = None
    settings: Plain = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    @property
    def top(self) -> int:
        return self.done[-1][0] if self.done else 0


def replay(rows: Iterable[Row]) -> Replay:
    """Play a journal from its first row. A damaged row is named and left out."""
    result = Replay()
    for row in rows:
        result.settings = row.settings or result.settings
        try:
            _play(result, row)
        except DocumentError as error:
            result.problems.append(f"journal row {row.seq} ({row.kind} {row.label!r}): {error}")
    return result


def _play(result: Replay, row: Row) -> None:
    if row.kind in ("do", "discard"):
        edit = Edit(row.label, decode_changes(row.before or {}), decode_changes(row.after or {}))
        edit.swap(result.records, strict=False)
        result.done.append((row.seq, edit))
        result.undone.clear()
        if result.draft is not None and row.of_seq == result.draft.seq:
            result.draft = None
    elif row.kind == "undo":
        seq, edit = _take(result.done, row)
        edit.inverse().swap(result.records, strict=False)
        result.undone.append((seq, edit))
    elif row.kind == "redo":
        seq, edit = _take(result.undone, row)
        edit.swap(result.records, strict=False)
        result.done.append((seq, edit))
    elif row.kind == "save":
        result.saved = dict(result.records)
        result.saved_top = result.top
    elif row.kind == "draft":
        result.draft = None if row.after is None else Draft(row.seq, row.after)
    else:
        raise DocumentError("is of a kind that this version does not know")


def _take(stack: list[tuple[int, Edit]], row: Row) -> tuple[int, Edit]:
    if not stack or stack[-1][0] != row.of_seq:
        raise DocumentError(f"speaks of row {row.of_seq}, which is not the newest")
    return stack.pop()
