"""Compaction: removal of journal rows and files that can no longer be reached.

Every step that can be undone or redone is kept, as are the records of the last save and the
draft of an unfinished tool. Steps that were undone and then replaced are removed, and joined steps
are merged. The previous journal stays next to the new one until the project is closed, so that the
compaction itself can be undone.
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
from vomstudio.project.journal.database import SqliteJournal
from vomstudio.project.journal.failures import NotWritten
from vomstudio.project.journal.file_watch import read_journal_head
from vomstudio.project.journal.replay import RowKind
from vomstudio.project.paths import JOURNAL_NAME
from vomstudio.project.reconstructions import (
    delete_unused_stages,
    folder_bytes,
    unused_stages,
)
from vomstudio.project.session import Session
from vomstudio.project.verify import collect_assets

BACKUP_NAME = "journal-before-compaction.sqlite"
NEW_JOURNAL_NAME = "journal-compacted.sqlite"
_ASSETS_BACKUP = "assets-before-compaction"


@dataclass(frozen=True)
class CompactionPlan:
    """Rows and files that a compaction would remove, and the size of the files in bytes.

    `total_rows` is the number of rows before the compaction. `stages` are the folders of
    reconstructions with other photos or settings than the newest results.
    """

    rows: int
    total_rows: int
    assets: tuple[str, ...]
    asset_bytes: int
    stages: tuple[str, ...] = ()
    stage_bytes: int = 0

    @property
    def is_empty(self) -> bool:
        return self.rows == 0 and not self.assets and not self.stages


def plan(folder: Path, session: Session, journal: SqliteJournal) -> CompactionPlan:
    """Return the rows and files that a compaction would remove."""
    rows = sum(1 for _ in journal.rows())
    compacted_rows = sum(1 for _ in _rows(session))
    unused = _unused_files(folder, session)
    stages = unused_stages(folder)
    return CompactionPlan(
        max(rows - compacted_rows, 0),
        rows,
        tuple(path.relative_to(folder).as_posix() for path in unused),
        sum(path.stat().st_size for path in unused),
        tuple(path.relative_to(folder).as_posix() for path in stages),
        folder_bytes(stages),
    )


@dataclass(frozen=True)
class CompactionResult:
    """Result of a compaction.

    Attributes
    ----------
    seq_map : mapping of int to int
        Row numbers in the new journal by row number in the previous one.
    last : int
        Number of the last row at the time of the compaction.
    """

    seq_map: Mapping[int, int]
    last: int


def compact(folder: Path, session: Session, journal: SqliteJournal) -> CompactionResult:
    """Rewrite the journal, move unused files to a backup folder, and delete unused stages.

    Unused stages are deleted without a backup, because they can be computed again.

    Raises
    ------
    DocumentError
        If there are unsaved changes, if steps exist only in memory, or if the journal is damaged.
    TargetError
        If the project cannot be written. In this case nothing has changed.
    """
    if session.dirty:
        raise DocumentError(Finding("compaction.unsaved"))
    if journal.has_pending_rows:
        raise DocumentError(Finding("compaction.in-memory"))
    if session.problems:
        raise DocumentError(Finding("compaction.damaged"))
    new_path = folder / NEW_JOURNAL_NAME
    try:
        seq_map = write_compacted_journal(new_path, session, journal)
        journal.copy_to(folder / BACKUP_NAME)
        replace_journal(new_path, folder, session, journal, seq_map)
    except TargetError:
        remove(new_path)
        remove(folder / BACKUP_NAME)
        raise
    backup = folder / _ASSETS_BACKUP
    # A file that cannot be moved is harmless.
    with contextlib.suppress(OSError, TargetError):
        for path in _unused_files(folder, session):
            make_folder(backup, folder)
            path.replace(backup / path.name)
    delete_unused_stages(folder)
    return CompactionResult(seq_map, journal.last_number)


def write_compacted_journal(
    new_path: Path,
    session: Session,
    journal: SqliteJournal | None,
    settings: Mapping[str, Any] | None = None,
) -> dict[int, int]:
    """Write a journal that contains only the reachable rows.

    Parameters
    ----------
    new_path : Path
        File to write.
    session : Session
        Session whose reachable rows are written.
    journal : SqliteJournal or None
        Previous journal with times and versions, or None if it cannot be read.
    settings : mapping or None
        Current settings, used if `journal` is None.

    Returns
    -------
    dict of int to int
        Row numbers in the new journal by row number in the previous one.

    Raises
    ------
    TargetError
        If the journal cannot be written.
    """
    remove(new_path)
    seq_map: dict[int, int] = {}
    try:
        compacted = SqliteJournal(new_path, is_new=True)
    except VomError as error:
        remove(new_path)
        raise write_error(new_path, error.__cause__ or error) from error
    try:
        originals = {} if journal is None else {row.seq: row for row in journal.rows()}
        for row in _rows(session):
            of_seq = None if row.of is None else seq_map[row.of]
            original = originals.get(row.seq)
            if original is None and row.kind == "do":
                seq = compacted.append(
                    "do",
                    label=row.label,
                    before=row.before,
                    after=row.after,
                    settings=settings,
                )
            else:
                seq = compacted.copy_row(
                    row.kind, of_seq, row.label, row.before, row.after, original
                )
            if row.kind in ("do", "draft"):
                seq_map[row.seq] = seq
        if journal is not None:
            compacted.copy_views(journal)
    except NotWritten as error:
        compacted.close()
        remove(new_path)
        raise write_error(new_path, error.__cause__ or error) from error
    except BaseException:
        compacted.close()
        remove(new_path)
        raise
    compacted.close()
    if new_path.with_name(f"{new_path.name}-wal").exists():
        # The write-ahead log could not be merged and would be lost.
        remove(new_path)
        raise write_error(new_path, OSError(errno.EIO, os.strerror(errno.EIO)))
    return seq_map


def replace_journal(
    new_path: Path,
    folder: Path,
    session: Session,
    journal: SqliteJournal,
    seq_map: Mapping[int, int],
) -> None:
    """Replace the project's journal with the file `new_path` and continue the session in it.

    Parameters
    ----------
    new_path : Path
        File that replaces the journal.
    folder : Path
        Project folder.
    session : Session
    journal : SqliteJournal
    seq_map : mapping of int to int
        Row numbers in the new journal by row number in the previous one.

    Raises
    ------
    TargetError
        If the journal cannot be replaced; the session then continues in the previous one. It is
        also raised if the new journal cannot be opened immediately; the journal is then opened
        with the next step.
    """
    head = read_journal_head(new_path)
    # From here on, killing the process leaves either of the two journals complete.
    journal.close_file()
    try:
        new_path.replace(folder / JOURNAL_NAME)
    except OSError as error:
        remove(new_path)
        with contextlib.suppress(VomError):
            journal.reopen()
        raise write_error(folder / JOURNAL_NAME, error) from error
    session.use_journal(journal, seq_map)
    try:
        journal.reopen_after_replacement(head)
    except VomError as error:
        raise write_error(folder / JOURNAL_NAME, error.__cause__ or error) from error


def undo_compaction(
    folder: Path, session: Session, journal: SqliteJournal, compacted: CompactionResult
) -> None:
    """Restore the previous journal and files, followed by the steps made since the compaction.

    Raises
    ------
    DocumentError
        If the backup is missing.
    TargetError
        If the project cannot be written. In this case nothing has changed, and the call can be
        repeated.
    """
    backup_path, new_path = folder / BACKUP_NAME, folder / NEW_JOURNAL_NAME
    if not backup_path.is_file():
        raise DocumentError(Finding("compaction.none"))
    # Restore the files first: a superfluous file is harmless, but a missing one is not.
    _restore_assets(folder)
    remove(new_path)
    # Work on a copy so that a second attempt does not append the new rows twice.
    backup = SqliteJournal(backup_path)
    try:
        backup.copy_to(new_path)
    finally:
        backup.close()
    old_journal = SqliteJournal(new_path)
    seq_map = {new_path: seq for seq, new_path in compacted.seq_map.items()}
    try:
        for row in journal.rows():
            if row.seq > compacted.last:
                undone_seq = None if row.of_seq is None else seq_map.get(row.of_seq)
                seq_map[row.seq] = old_journal.copy_row(
                    row.kind, undone_seq, row.label, row.before, row.after, row
                )
    except BaseException:
        old_journal.close()
        remove(new_path)
        raise
    old_journal.close()
    replace_journal(new_path, folder, session, journal, seq_map)
    remove(backup_path)


def _restore_assets(folder: Path) -> None:
    backup = folder / _ASSETS_BACKUP
    if not backup.is_dir():
        return
    require_inside(backup, folder)
    try:
        make_folder(folder / FOLDER, folder)
        for path in backup.iterdir():
            path.replace(folder / FOLDER / path.name)
        backup.rmdir()
    except OSError as error:
        raise TargetError(
            Finding("output.unwritable", reason=failure_reason(folder, error)), file=folder / FOLDER
        ) from error


def discard_backup(folder: Path) -> None:
    """Delete the backup and the remains of a failed compaction when the project is closed."""
    remove(folder / BACKUP_NAME)
    remove(folder / NEW_JOURNAL_NAME)
    backup = folder / _ASSETS_BACKUP
    # The target of a link does not belong to the project.
    if backup.is_dir() and not special_files(str(folder), [_ASSETS_BACKUP]):
        for path in backup.iterdir():
            remove(path)
        with contextlib.suppress(OSError):
            backup.rmdir()


@dataclass(frozen=True)
class _NewRow:
    kind: RowKind
    seq: int
    of: int | None
    label: str
    before: Mapping[str, Any] | None
    after: Mapping[str, Any] | None


def _rows(session: Session) -> Iterator[_NewRow]:
    """Yield the rows of a journal that contains only reachable steps."""
    steps, undone_steps = session.done_steps(), session.undone_steps()
    if not steps:
        return
    for seq, edit in steps:
        yield _do_row(seq, edit)
        if seq == session.saved_top:
            yield _NewRow("save", 0, None, "", None, None)
    for seq, edit in reversed(undone_steps):
        yield _do_row(seq, edit)
    for seq, edit in undone_steps:
        yield _NewRow("undo", 0, seq, edit.label, None, None)
    if session.draft is not None:
        yield _NewRow("draft", session.draft.seq, None, "", None, session.draft.state)


def _do_row(seq: int, edit: Edit) -> _NewRow:
    old_values, new_values = encode_edit(edit)
    return _NewRow("do", seq, None, edit.label, old_values, new_values)


def _unused_files(folder: Path, session: Session) -> list[Path]:
    """Return the asset files that no reachable record references."""
    assets = folder / FOLDER
    # The target of a link does not belong to the project.
    if not assets.is_dir() or special_files(str(folder), [FOLDER]):
        return []
    steps = [edit for _, edit in (*session.done_steps(), *session.undone_steps())]
    named_paths = {
        asset.path
        for asset in collect_assets(session.records.values(), session.saved_records.values(), steps)
    }
    return sorted(
        path for path in assets.iterdir() if path.relative_to(folder).as_posix() not in named_paths
    )


def remove(path: Path) -> None:
    """Remove a journal and its auxiliary files."""
    for suffix in ("", "-wal", "-shm", "-journal"):
        with contextlib.suppress(OSError):
            path.with_name(path.name + suffix).unlink(missing_ok=True)
