"""Importing a field book through the dialog, with mouse and keyboard."""

from __future__ import annotations

from html import unescape

import numpy as np
import pyogrio
import pytest
import shapely
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QComboBox, QDialogButtonBox

from tests import driver
from tests.messages import shown_codes
from tests.ui.conftest import add_bed, add_cliff
from tests.ui.test_panels import column
from vomstudio.core.errors import InputError
from vomstudio.geology.orientation import Plane, angle_between_planes
from vomstudio.geometry.frames import Frame
from vomstudio.io.text.tables import read_table
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.records import FeatureType
from vomstudio.project.tables.project_table import project_table
from vomstudio.ui.commands.net import import_readings
from vomstudio.ui.dialogs.readings_dialog import NEW_LINE, ReadingsDialog

BOOK = """# limb
name,kind,dip direction,dip,x,y,z
F1,Bedding,270,45,500010,5100010,1
F2,bedding,268,,500010,5100010,1
F3,Dyke,45,80,,,
F4,,132,41,500010,5100010,1
"""
UTM = Frame("crs", "EPSG:32633")


@pytest.fixture
def book(tmp_path):
    path = tmp_path / "book.csv"
    path.write_text(BOOK)
    return path


def ask(window, path) -> ReadingsDialog:
    import_readings(window, window.studio, path)
    dialog = window.findChildren(ReadingsDialog)[-1]
    driver.wait(dialog.isVisible, "the dialog")
    return dialog


def test_point_layer_is_read_as_a_field_book(window, studio, tmp_path):

    add_cliff(studio, UTM)
    path = tmp_path / "stations.gpkg"
    pyogrio.raw.write(
        path,
        geometry=shapely.to_wkb(shapely.points([[500010.0, 5100010.0, 1.0]])),
        field_data=[np.array([270.0]), np.array([45.0])],
        fields=["dip_dir", "dip"],
        geometry_type="Point Z",
        crs="EPSG:32633",
    )
    count = len(window.findChildren(ReadingsDialog))
    import_readings(window, studio, path)
    driver.wait(lambda: len(window.findChildren(ReadingsDialog)) > count, "the dialog")
    dialog = window.findChildren(ReadingsDialog)[-1]
    choose(dialog._north, "grid")
    QTest.mouseClick(ok(dialog), Qt.MouseButton.LeftButton)
    (reading,) = (r for r in studio.records.values() if isinstance(r, Reading))
    assert (reading.azimuth_deg, reading.inclination_deg) == (270.0, 45.0)
    assert reading.position == pytest.approx((500010.0, 5100010.0, 1.0))


def choose(combo: QComboBox, value: object) -> None:
    """As the keyboard does it: the list's own order, then activated."""
    combo.setFocus()
    place = combo.findData(value)
    assert place >= 0
    while combo.currentIndex() != place:
        down = combo.currentIndex() < place
        QTest.keyClick(combo, Qt.Key.Key_Down if down else Qt.Key.Key_Up)


def ok(dialog):
    return dialog._buttons.button(QDialogButtonBox.StandardButton.Ok)


@pytest.mark.full
def test_import_requires_a_north_reference_and_states_its_correction(window, studio, book):
    add_cliff(studio, UTM)
    dialog = ask(window, book)
    assert not ok(dialog).isEnabled()
    assert "reading.north-missing" in shown_codes(dialog._summary.text())
    choose(dialog._north, "magnetic")
    assert not ok(dialog).isEnabled()
    assert "reading.declination-missing" in shown_codes(unescape(dialog._summary.text()))
    QTest.keyClicks(dialog._declination, "2,6")
    assert "north.magnetic-corrected" in shown_codes(dialog._summary.text())
    correction = dialog.north_correction()
    assert correction.declination_deg == 2.6
    assert correction.convergence_deg is not None
    assert dialog._unreadable_list.toPlainText().startswith("Line 4: ")
    assert "reading.no-angle" in shown_codes(dialog._unreadable_list.toPlainText())
    assert dialog._unreadable_list.isVisible()
    assert ok(dialog).text() == "Add 3 readings"
    dialog.reject()
    assert not studio.session.of(Reading)


def test_import_is_one_edit_corrected_to_grid_north_and_compared_with_picks(window, studio, book):
    add_cliff(studio, UTM)
    bed = add_bed(studio, "t1", "B01", dip=1.0)
    plane = studio.measured([bed.id])[bed.id].plane
    dialog = ask(window, book)
    choose(dialog._north, "magnetic")
    QTest.keyClicks(dialog._declination, "10")
    turned = dialog.north_correction().deg
    assert turned == pytest.approx(10.0, abs=0.01)  # beside the central meridian
    QTest.mouseClick(ok(dialog), driver.LEFT)
    readings = studio.session.of(Reading)
    assert [r.name for r in readings[:2]] == ["F1", "F3"]
    assert [r.azimuth_deg for r in readings] == [
        pytest.approx(a + turned) for a in (270.0, 45.0, 132.0)
    ]
    assert {r.turned_deg for r in readings} == {turned}
    kinds = {k.id: k.name for k in studio.session.of(FeatureType)}
    assert [kinds[r.type_id] for r in readings] == ["Bedding", "Dyke", "Bedding"]
    assert studio.selection.ids == tuple(r.id for r in readings)
    first = readings[0]
    found = studio.nearest_pick(first.id)
    assert found.pick_id == bed.id
    expected = angle_between_planes(plane, Plane(270.0 + turned, 45.0))
    assert found.angle_deg == pytest.approx(expected)
    model = window.table.model
    shown = model.index(model.find_source_row(first.id), column("Nearest pick")).data()
    assert shown == f"{expected:.1f}°"
    studio.selection.set([first.id])
    assert f"{shown} from B01" in window.properties._description_label.text()
    assert "+10.0" in window.properties._description_label.text()
    assert "3 readings" in studio.notices[-1].text
    studio.undo()
    assert not studio.session.of(Reading)
    assert "Dyke" not in {k.name for k in studio.session.of(FeatureType)}
    studio.redo()
    assert len(studio.session.of(Reading)) == 3


@pytest.mark.full
def test_difference_to_the_nearest_pick_follows_edits(window, studio, book):
    add_cliff(studio, UTM)
    dialog = ask(window, book)
    choose(dialog._north, "grid")
    QTest.mouseClick(ok(dialog), driver.LEFT)
    first = studio.session.of(Reading)[0]
    model = window.table.model
    cell = model.index(model.find_source_row(first.id), column("Nearest pick"))
    assert cell.data() == "–"
    add_bed(studio, "t1", "B01", dip=1.0)
    assert cell.data() not in ("–", "")
    studio.undo()
    assert model.index(model.find_source_row(first.id), column("Nearest pick")).data() == "–"


@pytest.mark.full
def test_missing_crs_gives_no_convergence_and_is_reported(window, studio, book):
    add_cliff(studio)
    dialog = ask(window, book)
    choose(dialog._north, "true")
    assert dialog.north_correction().deg == 0.0
    assert "north.true-unchanged" in shown_codes(dialog._summary.text())
    dialog.reject()


def test_unknown_type_can_be_mapped_to_an_existing_type(window, studio, book):
    add_cliff(studio)
    dialog = ask(window, book)
    choose(dialog._new_type_boxes["dyke"], "vein")
    choose(dialog._north, "grid")
    QTest.mouseClick(ok(dialog), driver.LEFT)
    assert [r.type_id for r in studio.session.of(Reading)] == ["bedding", "vein", "bedding"]


@pytest.mark.full
def test_ambiguous_azimuth_requires_a_selection(window, studio, tmp_path):
    path = tmp_path / "two.txt"
    path.write_text("40 50\n42 52\n")
    add_cliff(studio)
    dialog = ask(window, path)
    choose(dialog._north, "grid")
    assert not ok(dialog).isEnabled()
    assert shown_codes(dialog._summary.text()) == {"reading.notation-missing"}
    choose(dialog._notation, "strike/dip")
    assert dialog._role_boxes[0].currentText() == "Strike (right-hand)"
    QTest.mouseClick(ok(dialog), driver.LEFT)
    assert [r.azimuth_deg for r in studio.session.of(Reading)] == [130.0, 132.0]


def test_a_role_belongs_to_one_column(window, studio, book):
    add_cliff(studio)
    dialog = ask(window, book)
    choose(dialog._role_boxes[6], "inclination")
    assert dialog.columns()["inclination"] == 6
    assert dialog._role_boxes[3].currentData() == ""
    dialog.reject()


def test_file_that_is_not_a_table_is_reported(window, studio, tmp_path):
    add_cliff(studio)
    path = tmp_path / "sheet.csv"
    path.write_bytes(b"PK\x03\x04" + bytes(100))
    import_readings(window, window.studio, path)
    with pytest.raises(InputError) as refused:
        read_table(path)
    assert (refused.value.code, refused.value.values["kind"]) == ("file.other-kind", "zip")
    assert studio.notices[-1].text == str(refused.value)
    assert not window.findChildren(ReadingsDialog)


def test_export_notes_state_the_correction_and_the_nearest_pick(window, studio, book):
    add_cliff(studio, UTM)
    add_bed(studio, "t1", "B01", dip=1.0)
    dialog = ask(window, book)
    choose(dialog._north, "magnetic")
    QTest.keyClicks(dialog._declination, "10")
    QTest.mouseClick(ok(dialog), driver.LEFT)
    rows = {row["name"]: row for row in project_table(studio.records).rows}
    assert " +10.00 deg" in rows["F1"]["notes"]
    assert "from B01" in rows["F1"]["notes"]
    assert rows["B01"]["notes"] is None


@pytest.mark.full
def test_ambiguous_line_type_requires_a_selection_and_is_reported(window, studio, tmp_path):
    path = tmp_path / "faults.csv"
    path.write_text(
        "station,kind,dip direction,dip\nA,Fault,132,41\nA,Slickenside,140,40\n"
        "A,Stria,150,38\nA,Lineation,150,38\n"
    )
    add_cliff(studio)
    dialog = ask(window, path)
    choose(dialog._north, "grid")
    assert not ok(dialog).isEnabled()
    assert "reading.type-unclear" in shown_codes(dialog._summary.text())
    assert dialog._new_type_boxes["stria"].currentData() == NEW_LINE
    choose(dialog._new_type_boxes["slickenside"], NEW_LINE)
    assert "reading.lines-by-type" in shown_codes(unescape(dialog._summary.text()))
    QTest.mouseClick(ok(dialog), driver.LEFT)
    kinds = {k.id: k for k in studio.session.of(FeatureType)}
    readings = studio.session.of(Reading)
    assert [r.geometry for r in readings] == ["plane", "line", "line", "line"]
    assert [kinds[r.type_id].geometry for r in readings] == ["plane", "line", "line", "line"]
    assert {r.station for r in readings} == {"A"}
    assert len({r.name for r in readings}) == 4
    codes = [code for notice in studio.notices[-4:] for code in shown_codes(notice.text)]
    assert "reading.new-types" in codes
    assert "feature.same-names" not in codes
