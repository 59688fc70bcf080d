"""A survey planned in the window, with real keys: its figures are those of the formulas."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox, QToolButton

from tests import driver
from tests.messages import shown_codes
from vomstudio.io.photos.camera_table import find_camera
from vomstudio.ui.dialogs.command_palette import CommandPalette
from vomstudio.ui.dialogs.planner.planner_dialog import PlannerDialog


def retype(field, text: str) -> None:
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text) if text else QTest.keyClick(field, Qt.Key.Key_Delete)


def retype_option(dialog: PlannerDialog, name: str, text: str) -> None:
    retype(dialog.options.fields[name], text)


def settled(dialog: PlannerDialog) -> None:
    driver.wait(lambda: not dialog._compute_timer.isActive(), "the pause in typing")
    driver.wait(lambda: not dialog._requests.is_waiting, "the plan")


@pytest.fixture
def planner(window):
    window.docks.bring_forward("photos")
    button = next(
        b
        for b in window.photos_panel._pages.findChildren(QToolButton)
        if b.defaultAction() is window.actions_table.all["plan_survey"]
    )
    driver.keep_picture(window, "photos-empty")
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    driver.wait(lambda: window.findChildren(PlannerDialog), "the planner")
    (dialog,) = window.findChildren(PlannerDialog)
    QTest.qWaitForWindowExposed(dialog)
    settled(dialog)
    return dialog


@pytest.mark.full
def test_survey_is_planned_from_typed_values(planner, window, tmp_path) -> None:
    assert shown_codes(planner.problem.text()) == {"plan.no-camera"}
    assert not planner.save_button.isEnabled()
    # 36 mm of sensor, 6000 pixels and 30 mm of lens at 25 m: 36/30 * 25 / 6000 = 5 mm.
    retype(planner.camera, "36x24,30,6000x4000")
    retype_option(planner, "distance_m", "25")
    retype_option(planner, "width_m", "60")
    retype_option(planner, "height_m", "20")
    settled(planner)
    assert planner.figures["Pixel size (GSD)"].text() == "5 mm"
    assert planner.figures["Footprint"].text() == "30 x 20 m"
    # 30 % of the footprint is new at 70 % overlap.
    assert planner.figures["Spacing"].text() == "9 m along, 6 m up"
    assert planner.figures["Plane size, error"].text().endswith("5.0 m (1000 px) ± 0.3°")
    driver.keep_picture(planner, "planner")
    # What the receiver and the control are worth tells what the registration will be.
    by = ["Rotation (GPS)", "Rotation (control)"]
    before = [planner.figures[name].text() for name in by]
    retype_option(planner, "receiver_m", "0,02")
    retype_option(planner, "control_m", "0.1")
    settled(planner)
    after = [planner.figures[name].text() for name in by]
    assert all(a != b for a, b in zip(after, before, strict=True))
    driver.keep_picture(planner, "planner-accuracy")
    retype_option(planner, "receiver_m", "0")
    retype_option(planner, "control_m", "0")
    settled(planner)
    assert [planner.figures[name].text() for name in by] == before
    retype_option(planner, "overlap", "80")
    settled(planner)
    assert planner.figures["Spacing"].text() == "6 m along, 4 m up"
    sheet = tmp_path / "sheet.html"
    planner.save_field_sheet(sheet)
    driver.wait(sheet.exists, "the sheet")
    assert "30 x 20 m" in sheet.read_text()


@pytest.mark.full
def test_the_target_may_be_a_gsd_or_a_plane(planner) -> None:
    retype(planner.camera, "36x24,30,6000x4000")
    settled(planner)
    planner.target.setFocus()
    QTest.keyClick(planner.target, Qt.Key.Key_Down)
    assert planner.target.currentData() == "gsd_m"
    settled(planner)
    # The same plan, said in another quantity: 30 m are 6 mm.
    assert planner.options.options().gsd_m == 0.006
    retype_option(planner, "gsd_m", "4")
    settled(planner)
    assert planner.figures["Distance"].text() == "20 m"
    QTest.keyClick(planner.target, Qt.Key.Key_Down)
    settled(planner)
    retype_option(planner, "plane_m", "2,5")
    settled(planner)
    assert planner.figures["Distance"].text() == "12.5 m"
    assert planner.figures["Plane size, error"].text().endswith("2.5 m (1000 px) ± 0.3°")


@pytest.mark.full
def test_invalid_plan_input_is_reported_and_can_be_corrected(planner) -> None:
    retype(planner.camera, "no such camera")
    settled(planner)
    assert "plan.unknown-camera" in shown_codes(planner.problem.text())
    retype(planner.camera, "NIKON D90")
    settled(planner)
    assert "plan.no-focal-length" in shown_codes(planner.problem.text())
    retype_option(planner, "focal_mm", "35")
    settled(planner)
    assert planner.plan is not None
    assert planner.plan.camera.focal_mm == 35.0
    retype_option(planner, "distance_m", "0")
    settled(planner)
    assert shown_codes(planner.problem.text()) == {"number.not-positive"}
    retype_option(planner, "distance_m", "20")
    for invalid_text in ("-3", "x"):
        retype_option(planner, "height_m", invalid_text)
        settled(planner)
        assert planner.plan.height_m == 25.0
    retype(planner.camera, "a" * 5000)
    settled(planner)
    assert planner.plan is None


@pytest.mark.full
def test_camera_is_read_from_a_photo_and_plan_is_restored_on_reopening(
    window, planner, data_dir
) -> None:
    photo = min((data_dir / "brighton_beach" / "images").glob("*.*"))
    retype(planner.camera, str(photo))
    for _ in range(2):
        QTest.keyClick(planner.options.fields["manner"], Qt.Key.Key_Down)
    settled(planner)
    # README of the data: the focal length is 2222 pixels of 4000.
    c = planner.plan.camera
    assert c.focal_mm / c.sensor_width_mm * c.width_px == pytest.approx(2222, abs=12)
    assert planner.plan.manner == "terrain"
    driver.keep_picture(planner, "planner-terrain")
    planner.close()
    driver.wait(lambda: not window.findChildren(PlannerDialog), "its end")
    window.actions_table.run("plan_survey")
    (again,) = window.findChildren(PlannerDialog)
    settled(again)
    assert again.plan is not None
    assert again.plan.manner == "terrain"
    again.close()


@pytest.mark.full
def test_the_sheet_is_printed_on_one_page(planner, tmp_path) -> None:
    from PySide6.QtPrintSupport import QPrinter

    retype(planner.camera, "36x24,30,6000x4000")
    settled(planner)
    printer = QPrinter()
    printer.setOutputFormat(QPrinter.OutputFormat.PdfFormat)
    printer.setOutputFileName(str(tmp_path / "sheet.pdf"))
    planner.print_field_sheet(printer)
    data = (tmp_path / "sheet.pdf").read_bytes()
    assert data.startswith(b"%PDF")
    assert data.count(b"/Type /Page\n") == 1


@pytest.mark.full
def test_the_palette_finds_the_planner(window) -> None:
    from PySide6.QtCore import QTimer

    found = []

    def type_it() -> None:
        palette = QApplication.activeModalWidget()
        if not isinstance(palette, CommandPalette):
            QTimer.singleShot(25, type_it)
            return
        QTest.keyClicks(palette._search, "plan a survey")
        found.append(palette.selected_command)
        QTest.keyClick(palette._search, Qt.Key.Key_Return)

    QTimer.singleShot(25, type_it)
    QTest.keyClick(window, Qt.Key.Key_K, Qt.KeyboardModifier.ControlModifier)
    assert found == ["plan_survey"]
    driver.wait(lambda: window.findChildren(PlannerDialog), "the planner")
    (dialog,) = window.findChildren(PlannerDialog)
    dialog.close()


@pytest.mark.full
def test_choosing_a_drone_switches_the_survey_method(planner) -> None:
    retype(planner.camera, "")
    QTest.keyClicks(planner.camera, "dji mini")
    assert planner.camera.popup.isVisible()
    QTest.keyClick(planner.camera.popup, Qt.Key.Key_Down)
    QTest.keyClick(planner.camera.popup, Qt.Key.Key_Return)
    assert QApplication.activeModalWidget() is None, "Enter opens no file dialog"
    assert find_camera(planner.camera.text()).make == "DJI"
    assert planner.options.options().manner == "drone"
    settled(planner)
    assert planner.plan.camera.name
    retype(planner.camera, "NIKON D90")
    assert planner.options.options().manner == "handheld"


@pytest.mark.full
def test_existing_sheet_is_replaced_only_after_confirmation(planner, tmp_path, monkeypatch) -> None:
    retype(planner.camera, "36x24,30,6000x4000")
    settled(planner)
    there = tmp_path / "sheet.html"
    there.write_text("mine")
    # The name as it was typed, which Qt has asked about, is of no file.
    given = (str(tmp_path / "sheet"), "HTML (*.html)")
    answers = [given, ("", ""), given]
    proposed: list[str] = []

    def ask(*arguments: object) -> tuple[str, str]:
        proposed.append(str(arguments[2]))
        return answers.pop(0)

    monkeypatch.setattr(QFileDialog, "getSaveFileName", ask)
    seen: list[str] = []
    driver.answer(QMessageBox.StandardButton.No, seen)
    planner._save()
    assert "sheet.html already exists" in seen[0]
    assert proposed[1] == str(tmp_path / "sheet"), "No leads back to the dialog"
    assert there.read_text() == "mine"
    driver.answer(QMessageBox.StandardButton.Yes, seen)
    planner._save()
    driver.wait(lambda: there.read_text() != "mine", "the sheet")


@pytest.mark.full
def test_empty_plan_shows_a_hint_and_disables_its_buttons(planner) -> None:
    retype(planner.camera, "")
    settled(planner)
    assert planner.plan is None
    picture = planner.drawing.grab().toImage()
    colors = {
        picture.pixel(x, y) for y in range(picture.height()) for x in range(0, picture.width(), 2)
    }
    assert len(colors) > 2
    for button in (planner.save_button, planner.print_button):
        assert "Not now" in button.toolTip()
