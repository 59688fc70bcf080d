"""Why a journal cannot be written."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding

_LOST_CODES = frozenset({"journal.folder-gone", "journal.gone", "journal.replaced"})


def is_lost(failure: Finding) -> bool:
    """Return whether the journal's path has no file, or one that this program did not write."""
    return failure.code in _LOST_CODES


class NotWritten(DocumentError):
    """A row could not be written to the disk.

    Parameters
    ----------
    failure : Finding
        Reason: ``journal.folder-gone``, ``journal.gone``, ``journal.replaced``,
        ``disk.full``, ``disk.read-only``, ``disk.no-permission`` or
        ``journal.not-written``.
    path : Path
        The journal.
    """

    def __init__(self, failure: Finding, path: Path) -> None:
        super().__init__(failure, file=path)
        self.failure = failure
