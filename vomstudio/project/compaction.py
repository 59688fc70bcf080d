"""A project without the rows and files that nothing can reach any more.

Every step that can be undone or done again stays, as do the records of the last save and the
clicks of an unfinished tool. What goes is what was undone and then replaced by something else, and
steps that were joined to one. The journal of before stays beside the new one until the project is
closed, so that the compaction itself can be taken back.
"""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.errors import DocumentError, TargetError, VomError
from vomstudio.core.files.containment import make_folder, require_inside, special_files
from vomstudio.core.files.disk_errors import failure_reason, write_error
from vomstudio.core.findings import Finding
from vomstudio.project.assets import FOLDER
from vomstudio.project.codec import encode_edit
from vomstudio.project.edit import Edit
from vomstudio.project.journal.database import NAME, SqliteJournal
from vomstudio.project.journal.failures import NotWritten
from vomstudio.project.journal.file_watch import head_of
from vomstudio.project.journal.replay import RowKind
from vomstudio.project.session import Session
from vomstudio.project.verify import assets_of

BEFORE = "journal-before-compaction.sqlite"
NEW = "journal-compacted.sqlite"
_PUT_ASIDE = "assets-before-compaction"


@dataclass(frozen=True)
class Plan:
    """What a compaction would take away: rows of how many, and files with their bytes together."""

    rows: int
    of_rows: int
    assets: tuple[str, ...]
    asset_bytes: int

    @property
    def nothing(self) -> bool:
        return self.rows == 0 and not self.assets


def plan(folder: Path, session: Session, journal: SqliteJournal) -> Plan:
    """What would go, to be told before anything does."""
    rows = sum(1 for _ in journal.rows())
    kept = sum(1 for _ in _rows(session))
    unused = _unused(folder, session)
    return Plan(
        max(rows - kept, 0),
        rows,
        tuple(path.relative_to(folder).as_posix() for path in unused),
        sum(path.stat().st_size for path in unused),
    )


@dataclass(frozen=True)
class Compacted:
    """numbers: of the rows of the new journal by those of before; last: the number of its last row
    when it was made."""

    numbers: Mapping[int, int]
    last: int


def compact(folder: Path, session: Session, journal: SqliteJournal) -> Compacted:
    """Write the journal anew and put unused files aside. Raises DocumentError where something is
    not saved, TargetError where it cannot be written; then nothing has changed."""
    if session.dirty:
        raise DocumentError(Finding("compaction.unsaved"))
    if journal.waits:
        raise DocumentError(Finding("compaction.in-memory"))
    if session.problems:
        raise DocumentError(Finding("compaction.damaged"))
    new = folder / NEW
    try:
        numbers = write_anew(new, session, journal)
        journal.copy_to(folder / BEFORE)
        put_in_place(new, folder, session, journal, numbers)
    except TargetError:
        remove(new)
        remove(folder / BEFORE)
        raise
    aside = folder / _PUT_ASIDE
    # What stays where it was does no harm.
    with contextlib.suppress(OSError, TargetError):
        for path in _unused(folder, session):
            make_folder(aside, folder)
            path.replace(aside / path.name)
    return Compacted(numbers, journal.last)


def write_anew(
    new: Path,
    session: Session,
    journal: SqliteJournal | None,
    settings: Mapping[str, Any] | None = None,
) -> dict[int, int]:
    """A journal of what can be reached and no more; the numbers of its rows by those of before.
    journal: of before, with times and versions, where it can be read; settings: of now, where not.
    Raises TargetError."""
    remove(new)
    numbers: dict[int, int] = {}
    try:
        made = SqliteJournal(new, create=True)
    except VomError as error:
        remove(new)
        raise write_error(new, error.__cause__ or error) from error
    try:
        originals = {} if journal is None else {row.seq: row for row in journal.rows()}
        for row in _rows(session):
            of_seq = None if row.of is None else numbers[row.of]
            was = originals.get(row.seq)
            if was is None and row.kind == "do":
                number = made.append(
                    "do",
                    label=row.label,
                    before=row.before,
                    after=row.after,
                    settings=settings,
                )
            else:
                number = made.copy_row(row.kind, of_seq, row.label, row.before, row.after, was)
            if row.kind in ("do", "draft"):
                numbers[row.seq] = number
        if journal is not None:
            made.copy_views(journal)
    except NotWritten as error:
        made.close()
        remove(new)
        raise write_error(new, error.__cause__ or error) from error
    except BaseException:
        made.close()
        remove(new)
        raise
    made.close()
    if new.with_name(f"{new.name}-wal").exists():
        # It could not be folded in, and would not go along.
        remove(new)
        raise write_error(new, OSError(errno.EIO, os.strerror(errno.EIO)))
    return numbers


def put_in_place(
    new: Path, folder: Path, session: Session, journal: SqliteJournal, numbers: Mapping[int, int]
) -> None:
    """The file `new` becomes the journal of the project, in which the session goes on. numbers: of
    its rows by those of before. Raises TargetError; then all goes on in the one of before, or in
    the new one where only that cannot be opened at once: it is with the next step."""
    head = head_of(new)
    # From here on a kill leaves one whole journal or the other.
    journal.let_go()
    try:
        new.replace(folder / NAME)
    except OSError as error:
        remove(new)
        with contextlib.suppress(VomError):
            journal.reopen()
        raise write_error(folder / NAME, error) from error
    session.use_journal(journal, numbers)
    try:
        journal.change_over(head)
    except VomError as error:
        raise write_error(folder / NAME, error.__cause__ or error) from error


def take_back(folder: Path, session: Session, journal: SqliteJournal, made: Compacted) -> None:
    """Bring back the journal and the files of before the compaction, with what was done since.
    Raises DocumentError where they are not there, TargetError where they cannot be written; then
    nothing has changed, and it can be tried again."""
    before, new = folder / BEFORE, folder / NEW
    if not before.is_file():
        raise DocumentError(Finding("compaction.none"))
    # First: a file too many does no harm, one that a record names and that is not there does.
    _bring_back_files(folder)
    remove(new)
    # A copy, to which a second try does not add the rows since then once more.
    kept = SqliteJournal(before)
    try:
        kept.copy_to(new)
    finally:
        kept.close()
    old = SqliteJournal(new)
    numbers = {new: seq for seq, new in made.numbers.items()}
    try:
        for row in journal.rows():
            if row.seq > made.last:
                of = None if row.of_seq is None else numbers.get(row.of_seq)
                numbers[row.seq] = old.copy_row(row.kind, of, row.label, row.before, row.after, row)
    except BaseException:
        old.close()
        remove(new)
        raise
    old.close()
    put_in_place(new, folder, session, journal, numbers)
    remove(before)


def _bring_back_files(folder: Path) -> None:
    """Raises TargetError."""
    aside = folder / _PUT_ASIDE
    if not aside.is_dir():
        return
    require_inside(aside, folder)
    try:
        make_folder(folder / FOLDER, folder)
        for path in aside.iterdir():
            path.replace(folder / FOLDER / path.name)
        aside.rmdir()
    except OSError as error:
        raise TargetError(
            Finding("output.unwritable", reason=failure_reason(folder, error)), file=folder / FOLDER
        ) from error


def forget(folder: Path) -> None:
    """The project is closed: the compaction cannot be taken back any more. What one that failed has
    left goes too."""
    remove(folder / BEFORE)
    remove(folder / NEW)
    aside = folder / _PUT_ASIDE
    # What a link leads to is not the project's.
    if aside.is_dir() and not special_files(str(folder), [_PUT_ASIDE]):
        for path in aside.iterdir():
            remove(path)
        with contextlib.suppress(OSError):
            aside.rmdir()


@dataclass(frozen=True)
class _NewRow:
    kind: RowKind
    seq: int
    of: int | None
    label: str
    before: Mapping[str, Any] | None
    after: Mapping[str, Any] | None


def _rows(session: Session) -> Iterator[_NewRow]:
    """The rows of a journal that holds what can be reached and no more."""
    steps, undone = session.done_steps(), session.undone_steps()
    if not steps:
        return
    for seq, edit in steps:
        yield _do(seq, edit)
        if seq == session.saved_top:
            yield _NewRow("save", 0, None, "", None, None)
    for seq, edit in reversed(undone):
        yield _do(seq, edit)
    for seq, edit in undone:
        yield _NewRow("undo", 0, seq, edit.label, None, None)
    if session.draft is not None:
        yield _NewRow("draft", session.draft.seq, None, "", None, session.draft.state)


def _do(seq: int, edit: Edit) -> _NewRow:
    before, after = encode_edit(edit)
    return _NewRow("do", seq, None, edit.label, before, after)


def _unused(folder: Path, session: Session) -> list[Path]:
    """Files of the project that nothing names which can be reached."""
    assets = folder / FOLDER
    # What a link leads to is not the project's.
    if not assets.is_dir() or special_files(str(folder), [FOLDER]):
        return []
    steps = [edit for _, edit in (*session.done_steps(), *session.undone_steps())]
    named = {
        asset.path for asset in assets_of(session.records.values(), session.saved.values(), steps)
    }
    return sorted(p for p in assets.iterdir() if p.relative_to(folder).as_posix() not in named)


def remove(path: Path) -> None:
    for ending in ("", "-wal", "-shm", "-journal"):
        with contextlib.suppress(OSError):
            path.with_name(path.name + ending).unlink(missing_ok=True)
