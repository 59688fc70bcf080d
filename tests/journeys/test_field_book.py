"""A field book beside the picks of the real window: imported, lassoed on the net, exported."""

from __future__ import annotations

import math
import re

import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialogButtonBox, QFileDialog

from tests import driver
from tests.driver import wait
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.dialogs.readings_dialog import ReadingsDialog

pytestmark = pytest.mark.full


def test_a_field_book_is_imported_lassoed_on_the_net_and_drawn(
    window, outcrop, picks, truth, tmp_path, monkeypatch
):
    model_id = driver.open_outcrop(window, outcrop)
    studio, net = window.studio, window.net
    name, points = next(iter(picks.items()))
    model = studio.records[model_id]
    trace = Trace(
        "t1",
        name,
        "bedding",
        model_id,
        model.content_hash,
        tuple(tuple(p) for p in points.tolist()),
    )
    assert studio.attempt(edits.add_trace, trace)

    azimuth, dip = truth[name]
    x, y, z = points[0]
    book = tmp_path / "book.csv"
    book.write_text(
        "name,dip direction,dip,x,y,z\n"
        f"F1,{azimuth:.2f},{dip:.2f},{x},{y},{z}\n"
        f"F2,{azimuth + 4:.2f},{dip:.2f},{x + 3},{y},{z}\n"
        f"F3,{(azimuth + 180) % 360:.2f},60,,,\n"
    )
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(book), ""))
    window.actions_table.all["import_readings"].trigger()
    dialog = window.findChildren(ReadingsDialog)[0]
    wait(dialog.isVisible, "the dialog")
    driver.keep_picture(dialog, "field_book_dialog")
    dialog._north.setFocus()
    for _ in range(3):
        QTest.keyClick(dialog._north, Qt.Key.Key_Down)
    assert dialog.north_correction().north == "grid"
    button = dialog._buttons.button(QDialogButtonBox.StandardButton.Ok)
    QTest.mouseClick(button, driver.LEFT, driver.NONE, button.rect().center())
    readings = studio.session.of(Reading)
    assert [r.name for r in readings] == ["F1", "F2", "F3"]
    found = studio.nearest_pick(readings[0].id)
    assert found.name == name
    assert found.distance_m < 1e-6
    assert found.angle_deg < 3.0
    assert studio.nearest_pick(readings[2].id).distance_m is None

    wait(lambda: net.is_up_to_date and "F1" not in net._corner_label.text(), "the net")
    QApplication.processEvents()
    # Around the two readings of the bed, by the pole of the first.
    cx, cy = net.artists.centre_px
    radius, trend = math.sqrt(2) * math.sin(math.radians(dip / 2)), math.radians(azimuth + 180)
    size, ratio = net.artists.radius_px, net.canvas.devicePixelRatioF()
    middle = (cx + size * radius * math.sin(trend), cy + size * radius * math.cos(trend))
    ring = [
        QPoint(
            round((middle[0] + 14 * math.cos(a)) / ratio),
            round(net.canvas.height() - (middle[1] + 14 * math.sin(a)) / ratio),
        )
        for a in (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    ]
    none = Qt.MouseButton.NoButton
    for kind, at, button, held in (
        (QEvent.Type.MouseButtonPress, ring[0], driver.LEFT, driver.LEFT),
        *((QEvent.Type.MouseMove, p, none, driver.LEFT) for p in ring[1:]),
        (QEvent.Type.MouseButtonRelease, ring[-1], driver.LEFT, none),
    ):
        event = QMouseEvent(
            kind, QPointF(at), QPointF(net.canvas.mapToGlobal(at)), button, held, driver.NONE
        )
        QApplication.sendEvent(net.canvas, event)
    chosen = {studio.records[i].name for i in studio.selection.ids}
    assert {"F1", "F2", name} >= chosen >= {"F1", name}
    driver.keep_picture(window, "field_book_net")

    figure = tmp_path / "net.svg"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(figure), ""))
    window.actions_table.all["export_net"].trigger()
    assert re.search(r"Bedding \(compass\)[^<]*\(n = 3\)", figure.read_text())
    chosen_file = tmp_path / "for_orient"
    monkeypatch.setattr(
        QFileDialog, "getSaveFileName", lambda *_: (str(chosen_file), "Orient (*.tsv)")
    )
    window.actions_table.all["export_program"].trigger()
    written = chosen_file.with_name("for_orient_orient.tsv").read_text("utf-8").splitlines()
    assert written[0].split("\t")[:5] == ["Station", "X", "Y", "Z", "Dip Direction"]
    assert len(written) > 3
    studio.undo()
    assert not studio.session.of(Reading)
