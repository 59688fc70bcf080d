"""Why a journal cannot be written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from vomstudio.errors import DocumentError

Cause = Literal["gone", "replaced", "full", "read-only", "failed"]


@dataclass(frozen=True)
class Trouble:
    """Why a journal cannot be written: the cause, and what happened in a sentence."""

    cause: Cause
    sentence: str

    @property
    def lost(self) -> bool:
        """What is at the journal's place is not what this program wrote, or nothing is."""
        return self.cause in ("gone", "replaced")


class NotWritten(DocumentError):
    """A row is not on the disk."""

    def __init__(self, trouble: Trouble, path: Path, advice: str) -> None:
        super().__init__(f"{trouble.sentence} {advice}", file=path)
        self.trouble = trouble
