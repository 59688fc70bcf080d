"""A journal in memory and a project with one model, without a disk."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.journal.replay import JournalRow
from vomstudio.project.records import Model
from vomstudio.project.session import Session


class MemoryJournal:
    """A `Journal` that forgets when the test ends; `refuse` makes it fail like a full disk."""

    def __init__(self) -> None:
        self.kept: list[JournalRow] = []
        self.refuse: Exception | None = None

    def append(self, kind, *, of_seq=None, label="", before=None, after=None, settings=None):
        if self.refuse is not None:
            raise self.refuse
        seq = len(self.kept) + 1
        self.kept.append(JournalRow(seq, kind, of_seq, label, before, after, "", "0", settings))
        return seq

    def rows(self) -> Iterator[JournalRow]:
        return iter(list(self.kept))

    def close(self) -> None:
        return


MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))


@pytest.fixture
def journal() -> MemoryJournal:
    return MemoryJournal()


@pytest.fixture
def session(journal: MemoryJournal) -> Session:
    session = Session(journal)
    session.apply(edits.add_model(session.records, MODEL))
    return session
