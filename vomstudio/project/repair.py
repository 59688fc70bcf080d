"""A journal with damaged rows, written anew with all that could be read.

What stood in the damaged rows is lost, and is named; the journal as it was is kept beside the new
one for whoever can read more of it.
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
class Repaired:
    """kept : the damaged journal; lost : what could not be read"""

    kept: Path
    lost: tuple[Finding, ...]


def repair(folder: Path, session: Session, journal: SqliteJournal) -> Repaired:
    """Raises DocumentError where there is nothing to repair, or where the new journal would say
    something else, TargetError where it cannot be written; then nothing has changed."""
    lost = tuple(session.problems)
    if not lost:
        raise DocumentError(Finding("journal.sound"))
    new = folder / compaction.NEW
    numbers = compaction.write_anew(new, session, journal)
    written = read_replay(new)
    if written.records != dict(session.records) or written.saved != dict(session.saved):
        compaction.remove(new)
        raise DocumentError(Finding("journal.inconsistent"))
    kept = _free_name(folder)
    journal.copy_to(kept)
    compaction.put_in_place(new, folder, session, journal, numbers)
    session.problems = ()
    return Repaired(kept, lost)


def _free_name(folder: Path) -> Path:
    number = 1
    while (path := folder / f"journal-damaged-{number}.sqlite").exists():
        number += 1
    return path
