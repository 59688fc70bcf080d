"""Dialogs beside the window: one of each kind, and one that is closed is gone."""

from __future__ import annotations

import gc
import weakref

import pytest
from PySide6.QtCore import QCoreApplication, QEvent
from PySide6.QtWidgets import QDialog

from tests.tiers import first_in_default_tier


def shown(window) -> list[QDialog]:
    return [d for d in window.findChildren(QDialog) if d.isVisible()]


def delete_later() -> None:
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


@pytest.mark.parametrize(
    "name", first_in_default_tier(["plan_survey", "video_frames", "feature_types"], 1)
)
def test_open_dialog_is_raised_and_a_closed_one_is_recreated(window, name):
    window.actions_table.run(name)
    (first,) = shown(window)
    window.actions_table.run(name)
    assert shown(window) == [first]
    first.close()
    window.actions_table.run(name)
    (second,) = shown(window)
    assert second is not first
    second.close()


def test_closed_dialog_is_disconnected_from_jobs_and_released(window, studio):
    window.actions_table.run("video_frames")
    (dialog,) = shown(window)
    dialog.close()
    delete_later()
    studio.workspace.jobs.changed.emit()
    gone = weakref.ref(dialog)
    del dialog
    gc.collect()
    assert gone() is None


@pytest.mark.full
def test_frame_dialog_does_not_shrink_fields_below_their_minimum_size(studio, window):
    from PySide6.QtWidgets import QApplication, QComboBox

    from vomstudio.geometry.frames import Frame
    from vomstudio.project import edits
    from vomstudio.project.records import Model
    from vomstudio.ui.dialogs.frame_dialog import FrameDialog

    model = Model("m9", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("undeclared"))
    studio.attempt(edits.add_model, model)
    window.files.declare_frame("m9")
    (dialog,) = window.findChildren(FrameDialog)
    for text in ("", "EPSG:32633", "no system of this world is called like that"):
        dialog._crs_button.click()
        dialog._crs.setText(text)
        dialog._check()
        QApplication.processEvents()
        for box in dialog.findChildren(QComboBox):
            assert box.height() >= box.minimumSizeHint().height()
    dialog.close()
