"""The profile of verdicts, chosen in the window."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests.messages import figures, shown_codes
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, TEXTBOOK_THRESHOLDS
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import PROFILE_ID, Model
from vomstudio.ui.dialogs.profile_dialog import ProfileDialog
from vomstudio.ui.panels.features.table_model import COLUMNS, QUALITY


@pytest.fixture
def dialog(window: Any, studio: Any) -> ProfileDialog:
    session = studio.session
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64)
    session.apply(edits.add_model(session.records, model))
    random = np.random.default_rng(1)
    for number, thick in enumerate((0.01, 0.5)):
        xyz = random.uniform(-2, 2, (60, 3)) * [1, 0.9, 0] + random.normal(0, 1, (60, 3)) * thick
        session.apply(
            edits.add_trace(
                session.records,
                Trace(
                    f"t{number}",
                    "",
                    "bedding",
                    "m1",
                    "0" * 64,
                    tuple(map(tuple, xyz.tolist())),
                    0.01,
                    axis="auto",
                ),
            )
        )
    window.actions_table.run("verdict_profile")
    (made,) = window.findChildren(ProfileDialog)
    return made


def choose(dialog: ProfileDialog, profile: str) -> None:
    dialog.profile.setCurrentIndex(dialog.profile.findData(profile))
    dialog.profile.activated.emit(dialog.profile.currentIndex())


def shown_verdict(window: Any) -> list[str]:
    """Of the selected feature in Properties, and in the cell of the table: word and tooltip."""
    word = window.properties._fit._verdict
    table = window.table.view.model()
    column = next(i for i, c in enumerate(COLUMNS) if c is QUALITY)
    tip = table.data(table.index(0, column), Qt.ItemDataRole.ToolTipRole)
    assert word.toolTip() in tip
    return [word.text(), word.toolTip()]


def qualities(studio: Any) -> list[str]:
    return [m.verdict.quality for m in studio.measured(["t0", "t1"]).values()]


@pytest.mark.full
def test_textbook_profile_is_applied_in_one_undoable_step(
    dialog: ProfileDialog, studio: Any, window: Any
) -> None:
    before = qualities(studio)
    assert not dialog.apply_button.isEnabled()
    assert shown_codes(dialog.apply_button.toolTip()) == {"edit.no-change"}
    choose(dialog, "textbook")
    assert dialog.apply_button.isEnabled()
    assert dialog.form.isRowVisible(dialog.boxes["least_coplanarity"])
    assert not dialog.form.isRowVisible(dialog.boxes["good_confidence95_deg"])
    QTest.mouseClick(dialog.apply_button, Qt.MouseButton.LeftButton)
    assert studio.records[PROFILE_ID].limits == TEXTBOOK_THRESHOLDS
    assert qualities(studio) == ["good", "doubtful"]
    studio.selection.set(["t0"])
    for word in ("good", TEXTBOOK_THRESHOLDS.description):
        assert word in shown_verdict(window)
    studio.undo()
    assert DEFAULT_THRESHOLDS.description in shown_verdict(window)
    assert PROFILE_ID not in studio.records
    assert qualities(studio) == before
    assert dialog.profile.currentData() == "error"


def test_profile_preview_matches_the_result(dialog: ProfileDialog, studio: Any) -> None:
    choose(dialog, "textbook")
    assert figures(dialog.effect.text().split(":")[-1]) == [1, 1, 0]


def test_typed_limits_are_kept_while_features_are_edited(
    dialog: ProfileDialog, studio: Any
) -> None:
    choose(dialog, "textbook")
    dialog.boxes["least_coplanarity"].setValue(7.0)
    studio.attempt(edits.set_attributes, ["t0"], notes="the same bed")
    assert dialog.boxes["least_coplanarity"].value() == 7.0
    assert dialog.limits().by == "shape"


def test_changed_limit_creates_a_custom_profile_that_is_saved(
    dialog: ProfileDialog, studio: Any
) -> None:
    choose(dialog, "textbook")
    dialog.boxes["least_coplanarity"].setValue(5.0)
    assert dialog.name.text() == "custom limits"
    dialog.name.selectAll()
    QTest.keyClicks(dialog.name, "rough outcrops")
    QTest.mouseClick(dialog.apply_button, Qt.MouseButton.LeftButton)
    limits = studio.records[PROFILE_ID].limits
    assert (limits.profile, limits.by, limits.least_coplanarity) == ("rough outcrops", "shape", 5.0)
    assert qualities(studio) == ["good", "good"]
    assert studio.settings.profiles == {"rough outcrops": asdict(limits)}
    assert dialog.profile.findData("rough outcrops") >= 0
