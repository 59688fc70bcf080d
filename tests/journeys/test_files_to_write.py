"""The dialogs that ask for a file to write: its ending follows the chosen format, and nothing that
is there is replaced unasked."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QFileDialog, QLineEdit, QMessageBox

from tests import driver
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace

pytestmark = pytest.mark.full

ZIGZAG = tuple((float(i), (i % 3) * 0.7, 0.4 * i + (i % 2)) for i in range(9))


def in_dialog(typed: str, kind: str = "") -> list[str]:
    """Type a name into the next file dialog, after choosing a format by its ending, and press
    Enter; the name that was proposed comes into the list."""
    proposed: list[str] = []

    def look() -> None:
        dialog = QApplication.activeModalWidget()
        shown = isinstance(dialog, QFileDialog)
        field = dialog.findChild(QLineEdit, "fileNameEdit") if shown else None
        if field is None or not field.hasFocus():
            QTimer.singleShot(25, look)
            return
        proposed.append(field.text())
        if kind:
            formats = dialog.findChild(QComboBox, "fileTypeCombo")
            assert formats is not None
            row = next(i for i in range(formats.count()) if kind in formats.itemText(i))
            formats.setCurrentIndex(row)
            formats.activated.emit(row)
        field.selectAll()
        QTest.keyClicks(field, typed)
        QTest.keyClick(field, Qt.Key.Key_Return)

    QTimer.singleShot(25, look)
    return proposed


@pytest.fixture
def opened(window, outcrop):
    driver.open_outcrop(window, outcrop)
    model = driver.model(window)
    low = window.studio.models[model.id].data.bounds[0]
    points = tuple((low[0] + x, low[1] + y, low[2] + z) for x, y, z in ZIGZAG)
    trace = Trace("t1", "B01", "bedding", model.id, model.content_hash, points)
    assert window.studio.attempt(edits.add_trace, trace)
    return window


def cancel_after(seen: list[str]) -> None:
    """Cancel the file dialog that comes again once a question was answered."""

    def look() -> None:
        dialog = QApplication.activeModalWidget()
        if seen and isinstance(dialog, QFileDialog):
            dialog.reject()
        else:
            QTimer.singleShot(25, look)

    QTimer.singleShot(25, look)


def replaced_only_when_asked(there: Path, ask: Callable[[], object], typed: str) -> None:
    there.write_text("mine")
    seen: list[str] = []
    in_dialog(typed)
    driver.answer(QMessageBox.StandardButton.No, seen)
    cancel_after(seen)
    ask()
    assert there.name in seen[0]
    assert there.read_text() == "mine"
    in_dialog(typed)
    driver.answer(QMessageBox.StandardButton.Yes, seen)
    ask()
    driver.wait(lambda: there.read_bytes() != b"mine", "the file")


@pytest.mark.parametrize("ending", ["csv", "dxf"])
def test_existing_table_is_replaced_only_after_asking_if_extension_is_added(
    opened, tmp_path, ending
) -> None:
    run = opened.actions_table.all[f"export_{ending}"].trigger
    replaced_only_when_asked(tmp_path / f"planes.{ending}", run, str(tmp_path / "planes"))


def test_existing_figure_and_command_table_are_replaced_only_after_asking(opened, tmp_path) -> None:
    run = opened.actions_table.all["export_net"].trigger
    replaced_only_when_asked(tmp_path / "net.svg", run, str(tmp_path / "net"))
    run = opened.net.command.click
    replaced_only_when_asked(tmp_path / "planes.csv", run, str(tmp_path / "planes"))


def test_existing_error_report_is_replaced_only_after_asking(opened, tmp_path) -> None:
    run = opened.actions_table.all["save_report"].trigger
    replaced_only_when_asked(tmp_path / "report.txt", run, str(tmp_path / "report"))


def test_existing_project_report_is_replaced_only_after_asking(opened, tmp_path) -> None:
    run = opened.actions_table.all["project_report"].trigger
    path = tmp_path / "project.html"
    replaced_only_when_asked(path, run, str(tmp_path / "project"))
    driver.wait(lambda: opened.files.missing_export_finding() is None, "the end of the report")
    text = path.read_text("utf-8")
    names = [feature.name for feature in opened.studio.session.features()]
    assert names
    assert all(f"<td>{name}</td>" in text for name in names)
    opened.actions_table.all["copy_export"].trigger()
    copied = QGuiApplication.clipboard().text()
    assert " project " in copied
    assert f" report -o {path}" in copied


def test_a_model_is_exported_in_the_format_that_is_chosen(opened, tmp_path) -> None:
    run = opened.actions_table.all["export_model"].trigger
    proposed = in_dialog(str(tmp_path / "cliff"), ".glb")
    run()
    driver.wait((tmp_path / "cliff.glb").exists, "the model")
    # What is proposed can be accepted as it stands.
    assert proposed[0].endswith(".obj")
    in_dialog(str(tmp_path / "other.ply"), ".obj")
    run()
    driver.wait((tmp_path / "other.ply").exists, "the model")


def test_export_for_other_programs_uses_the_extension_of_the_selected_format(
    opened, tmp_path
) -> None:
    run = opened.actions_table.all["export_program"].trigger
    in_dialog(str(tmp_path / "beds"), ".tsv")
    run()
    assert (tmp_path / "beds_orient.tsv").read_text().startswith("Station")
