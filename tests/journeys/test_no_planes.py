"""Stations, contact lines and rock areas with mouse and keyboard, in the window that people use."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from tests import driver
from tests.driver import click, drag, key, look_at, wait
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.lithology import Lithology
from vomstudio.project.kinds.station import Station
from vomstudio.studio.tools import lithology
from vomstudio.studio.tools.contact import ContactTool
from vomstudio.studio.tools.lithology import LithologyTool
from vomstudio.ui.panels.features.table_model import COLUMNS
from vomstudio.ui.panels.tools.contact import ContactPanel
from vomstudio.ui.panels.tools.lithology import LithologyPanel
from vomstudio.ui.panels.tools.station import StationPanel

SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def opened(window, outcrop, picks):
    """The outcrop with a bed in view."""
    driver.open_outcrop(window, outcrop)
    look_at(window, picks["B01"], 0.0, 10.0)
    return window


def spots(window, *steps: tuple[int, int]) -> list[QPoint]:
    """Pixels about the middle of the outcrop, all on it."""
    middle = window.viewport.rect().center()
    found = [middle + QPoint(*step) for step in steps]
    assert all(window.viewport.pick(p.x(), p.y()) is not None for p in found)
    return found


def world(window, spot: QPoint) -> np.ndarray:
    return np.asarray(window.viewport.world_position(window.viewport.pick(spot.x(), spot.y())))


def painted_m2(drawing) -> float:
    edges = drawing.area.corners[:, 1:] - drawing.area.corners[:, :1]
    return 0.5 * float(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum())


def type_in(field, text: str) -> None:
    field.setFocus()
    field.setText(text)
    field.editingFinished.emit()


@pytest.mark.full
def test_each_click_adds_a_station_and_numbers_continue(opened):
    window, studio = opened, opened.studio
    key(window, Qt.Key.Key_D)
    panel = driver.tool_panel(window, StationPanel)
    assert not panel.visibleRegion().isEmpty()
    type_in(panel.number_edit, "KB-09")
    type_in(panel.photo_edit, "DSC_0412.jpg")
    driver.focus(window)
    at = spots(window, (-80, -10), (60, 10), (0, 0))
    click(window.viewport, at[0])
    panel.kind_box.setCurrentIndex(panel.kind_box.findData("sample"))
    panel.kind_box.activated.emit(panel.kind_box.currentIndex())
    driver.focus(window)
    click(window.viewport, at[1])
    first, second = studio.session.of(Station)
    assert (first.what, first.number, first.photo) == ("station", "KB-09", "DSC_0412.jpg")
    assert (second.what, second.number, second.photo) == ("sample", "KB-10", "")
    assert panel.number_edit.text() == "KB-11"
    assert first.name != second.name
    measured = studio.measured([first.id])[first.id]
    assert measured.points[0] == pytest.approx(world(window, at[0]), abs=1e-9)
    assert measured.plane is measured.line is measured.verdict is measured.problem is None
    driver.keep_picture(window, "no-planes-1-stations")
    # A click with no tool selects it; its fields are edits.
    key(window, Qt.Key.Key_N)
    click(window.viewport, at[0])
    assert studio.selection.ids == (first.id,) or list(studio.selection.ids) == [first.id]
    window.properties.fields["notes"].setText("ripple marks")
    window.properties.fields["notes"].setModified(True)
    window.properties.fields["notes"].finished.emit()
    assert studio.records[first.id].notes == "ripple marks"
    # It is moved by the same command as the others.
    window.actions_table.all["edit_feature"].trigger()
    click(window.viewport, at[2])
    key(window, Qt.Key.Key_Return)
    moved = studio.measured([first.id])[first.id].points
    assert moved[0] == pytest.approx(world(window, at[2]), abs=1e-9)
    for _ in range(4):
        key(window, Qt.Key.Key_Z, driver.CTRL)
    assert studio.session.of(Station) == []


@pytest.mark.full
def test_contact_line_has_length_but_no_plane(opened, picks):
    window, studio = opened, opened.studio
    key(window, Qt.Key.Key_E)
    assert not driver.tool_panel(window, ContactPanel).visibleRegion().isEmpty()
    at = spots(window, (-90, -20), (-30, -5), (40, 10), (90, 20))
    for spot in at:
        click(window.viewport, spot)
    drag(window.viewport, at[1], at[1] + QPoint(0, 9))
    driver.keep_picture(window, "no-planes-2-contact")
    key(window, Qt.Key.Key_Return)
    (made,) = studio.session.of(Contact)
    assert made.type_id == "contact"
    measured = studio.measured([made.id])[made.id]
    steps = np.diff(measured.points, axis=0)
    assert measured.dimension["length_m"] == pytest.approx(np.linalg.norm(steps, axis=1).sum())
    assert measured.plane is measured.line is measured.verdict is None
    key(window, Qt.Key.Key_Z, driver.CTRL)
    assert studio.session.of(Contact) == []
    key(window, Qt.Key.Key_Z, driver.CTRL | SHIFT)
    assert studio.session.of(Contact) == [made]


@pytest.mark.full
def test_a_contact_line_follows_the_contact(opened, picks):
    window, studio = opened, opened.studio
    key(window, Qt.Key.Key_E)
    tool = studio.get_tool(ContactTool)
    box = driver.tool_panel(window, ContactPanel).follow_box
    box.setCurrentIndex(box.findData("dark"))
    points = picks["B01"]
    for i in (0, -1):
        click(window.viewport, driver.pixel(window, points[i]))
    wait(lambda: tool.is_open and not tool.is_searching, "the way between the clicks")
    key(window, Qt.Key.Key_Return)
    (made,) = studio.session.of(Contact)
    assert len(made.vertices) > 20
    assert "2 way-points" in made.notes


@pytest.mark.full
# Its clicks count to the pixel: in a window whose panels were reset the left ones are 3 wider.
@pytest.mark.usefixtures("new_window")
def test_rock_area_on_large_model_is_computed_in_background(opened, monkeypatch):
    """The newest outline counts; what is finished before its area has come waits for it."""
    window, studio = opened, opened.studio
    monkeypatch.setattr(lithology, "MAX_SYNCHRONOUS_FACES", -1)
    tool = studio.get_tool(LithologyTool)
    for count in (1, 2):
        key(window, Qt.Key.Key_R, SHIFT)
        driver.focus(window)
        for spot in spots(window, (-90, -30), (90, -20), (80, 40), (-70, 45)):
            click(window.viewport, spot)
        if count == 1:
            wait(lambda: tool.is_open and not tool.is_searching, "the area")
            assert tool.measurement.dimension["area_m2"]
            key(window, Qt.Key.Key_Z, driver.CTRL)
            wait(lambda: not tool.is_searching, "the area of three corners")
            less = tool.measurement.dimension["area_m2"]
            click(window.viewport, spots(window, (-70, 45))[0])
            wait(lambda: not tool.is_searching, "the area of four corners")
            assert tool.measurement.dimension["area_m2"] > less
        key(window, Qt.Key.Key_Return)
        wait(lambda c=count: len(studio.session.of(Lithology)) == c, "the rock area")
        monkeypatch.setattr(lithology, "MAX_SYNCHRONOUS_FACES", 10**9)
    made = studio.session.of(Lithology)
    # Of the same clicks, at once: the same area.
    assert made[0].area == pytest.approx(made[1].area, rel=1e-12)
    key(window, Qt.Key.Key_R, SHIFT)
    monkeypatch.setattr(lithology, "MAX_SYNCHRONOUS_FACES", -1)
    for spot in spots(window, (-90, -30), (90, -20), (80, 40)):
        click(window.viewport, spot)
    key(window, Qt.Key.Key_Escape)
    driver.pause(300)
    assert not tool.is_open
    assert len(studio.session.of(Lithology)) == 2


@pytest.mark.full
def test_a_rock_area_is_measured_on_the_surface(opened):
    window, studio = opened, opened.studio
    key(window, Qt.Key.Key_R, SHIFT)
    panel = driver.tool_panel(window, LithologyPanel)
    panel.lithology_box.setCurrentIndex(panel.lithology_box.findData("sandstone"))
    panel.lithology_box.activated.emit(panel.lithology_box.currentIndex())
    driver.focus(window)
    for spot in spots(window, (-90, -30), (90, -20), (80, 40), (-70, 45)):
        click(window.viewport, spot)
    wait(lambda: studio.get_tool(LithologyTool).is_open, "the outline")
    driver.keep_picture(window, "no-planes-3-rock")
    key(window, Qt.Key.Key_Return)
    (made,) = studio.session.of(Lithology)
    assert made.lithology == "sandstone"
    figures = studio.measured([made.id])[made.id].dimension
    # A face is rough: its surface is larger than its outline laid flat, and not by much.
    assert 1.0 <= figures["area_m2"] / figures["outline_m2"] < 2.0
    # What it encloses is painted in the rock's colour, beside the window, and is as large as said.
    shown = window.viewport.features.drawings
    wait(lambda: shown[made.id].area is not None, "the rock is painted")
    assert painted_m2(shown[made.id]) == pytest.approx(figures["area_m2"], rel=1e-4)
    assert len(shown[made.id].line) == 5
    # A click on the paint selects it, one beside it nothing.
    key(window, Qt.Key.Key_N)
    inside, beside = spots(window, (0, 10), (0, 90))
    click(window.viewport, inside)
    assert list(studio.selection.ids) == [made.id]
    click(window.viewport, beside)
    assert not studio.selection.ids
    studio.selection.set([made.id])
    driver.keep_picture(window, "no-planes-4-selected")
    before = shown[made.id]
    field = window.properties.fields["lithology"]
    field.setCurrentIndex(field.findData("shale"))
    field.activated.emit(field.currentIndex())
    assert studio.records[made.id].lithology == "shale"
    assert shown[made.id].color != before.color
    assert shown[made.id].area is before.area
    key(window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    key(window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert made.id not in shown


@pytest.mark.full
def test_exported_features_are_imported_from_menu_in_one_step(opened, tmp_path):
    from vomstudio.project.exports.export import export_records
    from vomstudio.ui.commands.feature_import import FeatureListImport

    window, studio = opened, opened.studio
    key(window, Qt.Key.Key_D)
    click(window.viewport, spots(window, (0, 0))[0])
    key(window, Qt.Key.Key_R, SHIFT)
    for spot in spots(window, (-60, -30), (60, -20), (50, 40)):
        click(window.viewport, spot)
    key(window, Qt.Key.Key_Return)
    assert window.actions_table.all["import_listed"].isEnabled()
    export_records(studio.records, "gpkg", tmp_path / "o.gpkg")
    FeatureListImport(window, studio).import_file(tmp_path / "o.gpkg")
    assert len(studio.session.of(Station)) == 1, "the window does not wait for the file"
    driver.wait(lambda: len(studio.session.of(Station)) == 2, "the features")
    one, other = studio.session.of(Lithology)
    assert other.area == pytest.approx(one.area, rel=1e-6), "measured anew on the surface"
    assert len(studio.session.of(Station)) == 2
    assert len(studio.selection.ids) == 2
    key(window, Qt.Key.Key_Z, driver.CTRL)
    assert (len(studio.session.of(Station)), len(studio.session.of(Lithology))) == (1, 1)
    assert window.table.model.rowCount() == 2
    place = window.table.model.find_source_row(one.id)
    texts = [column.text(window.table.model.row(place)) for column in COLUMNS]
    shown = {column.title: text for column, text in zip(COLUMNS, texts, strict=True)}
    assert shown["Area"]
    assert shown["Orientation"] == shown["95 % error"] == shown["M"] == shown["Quality"] == ""
