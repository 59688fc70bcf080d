"""Compacting a project in the window: told before, taken back until it is closed."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QMessageBox

from tests.messages import figures
from tests.samples import bed
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.compaction import CompactionPlan
from vomstudio.project.records import Model
from vomstudio.ui.commands.compaction import commands, compaction_text

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))


def rows(studio) -> int:
    return sum(1 for _ in studio.project.journal.rows())


@pytest.mark.full
def test_compaction_is_confirmed_done_and_undone(studio, monkeypatch, qtbot):
    session = studio.session
    if "m1" not in session.records:
        session.apply(edits.add_model(session.records, MODEL))
    for number in range(5):
        session.apply(edits.add_trace(session.records, bed(f"new{number}")))
        session.undo()
    session.apply(edits.add_trace(session.records, bed("last")))
    asked: list[str] = []

    def yes(parent, title, text):
        asked.append(text)
        return QMessageBox.StandardButton.Yes

    monkeypatch.setattr(QMessageBox, "question", yes)
    compact, back = commands(studio, None)
    assert compact.disabled_reason() == Finding("compaction.unsaved")
    assert back.disabled_reason() == Finding("compaction.not-done")
    session.save()
    assert compact.disabled_reason() is None
    before, records = rows(studio), dict(session.records)
    question = compaction_text(studio.project.compaction())
    compact.run()
    assert asked == [question]
    assert rows(studio) <= before - 10
    assert dict(session.records) == records
    assert back.disabled_reason() is None
    back.run()
    assert rows(studio) == before
    assert dict(session.records) == records
    compact.run()
    assert len(asked) == 2


def test_compaction_without_effect_is_not_confirmed(studio, monkeypatch, qtbot):
    monkeypatch.setattr(QMessageBox, "question", lambda *_: 1 / 0)
    studio.session.save()
    studio.project.compact()
    commands(studio, None)[0].run()


def test_compaction_text_states_the_removed_amounts():
    words = compaction_text(CompactionPlan(12, 40, ("assets/a.png", "assets/b.png"), 2_500_000))
    assert figures(words) == [12, 40, 2, 2.5]
