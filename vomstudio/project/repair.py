"""Repair of a journal with damaged rows by a new journal of all readable rows.

The content of the damaged rows is lost and reported. The damaged journal is kept next to the new
one.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.project import compaction
from vomstudio.project.journal.database import SqliteJournal, read_replay
from vomstudio.project.session import Session


@dataclass(frozen=True)
class RepairResult:
    """Result of a repair.

    Attributes
    ----------
    backup : Path
        Path of the damaged journal.
    loss_findings : tuple of Finding
        Findings about the data that could not be read.
    """

    backup: Path
    loss_findings: tuple[Finding, ...]


def repair(folder: Path, session: Session, journal: SqliteJournal) -> RepairResult:
    """Rewrite the journal without its damaged rows.

    Raises
    ------
    DocumentError
        If there is nothing to repair, or the content of the new journal would differ.
    TargetError
        If the journal cannot be written. In this case nothing has changed.
    """
    problems = tuple(session.problems)
    if not problems:
        raise DocumentError(Finding("journal.sound"))
    new_path = folder / compaction.NEW_JOURNAL_NAME
    seq_map = compaction.write_compacted_journal(new_path, session, journal)
    repaired_replay = read_replay(new_path)
    if repaired_replay.records != dict(session.records) or repaired_replay.saved_records != dict(
        session.saved_records
    ):
        compaction.remove(new_path)
        raise DocumentError(Finding("journal.inconsistent"))
    backup = _free_name(folder)
    journal.copy_to(backup)
    compaction.replace_journal(new_path, folder, session, journal, seq_map)
    session.problems = ()
    return RepairResult(backup, problems)


def _free_name(folder: Path) -> Path:
    suffix = 1
    while (path := folder / f"journal-damaged-{suffix}.sqlite").exists():
        suffix += 1
    return path
