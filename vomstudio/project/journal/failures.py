"""Reasons why a journal cannot be written."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding

_LOST_CODES = frozenset({"journal.folder-gone", "journal.gone", "journal.replaced"})


def is_lost(failure: Finding) -> bool:
    """Return whether a failure means that the journal's file is missing or was replaced."""
    return failure.code in _LOST_CODES


class NotWritten(DocumentError):
    """Error raised if a row cannot be written to disk.

    Parameters
    ----------
    failure : Finding
        Reason: ``journal.folder-gone``, ``journal.gone``, ``journal.replaced``, ``disk.full``,
        ``disk.read-only``, ``disk.no-permission`` or ``journal.not-written``.
    path : Path
        Path of the journal.
    """

    def __init__(self, failure: Finding, path: Path) -> None:
        super().__init__(failure, file=path)
        self.failure = failure
