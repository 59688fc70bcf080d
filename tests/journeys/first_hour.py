"""A geologist's first hour in the real window, by mouse and keyboard, on a screen of some size.

Run as `python -m tests.journeys.first_hour MODELS OUT --theme dark`, with the screen, its scale
(QT_SCALE_FACTOR) and the folders of a new user in the environment. With `--real OBJ` the model is
that of a real shore. The window fills the screen. A
picture of every step is kept where VOMSTUDIO_PICTURES says, and a line about it is printed; the
process ends with 0 where all was as it has to be.

The hour: open a model and declare its frame, ten traces of beds, joints and a fault, two patches, a
striation with its slip on the fault, sets, net, view along the fold axis, orthophoto, tables. After
every step the keyboard is the outcrop's, and every undo and redo names what it did.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
from pathlib import Path

import numpy as np
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractItemView, QApplication, QComboBox, QLineEdit, QWidget

from tests import driver
from tests.driver import CTRL, click, drag, key, look_at, move, pick, pixel, wait
from tests.journeys.conftest import bare_outcrop, read_picks
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.patch import Patch
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.ui.dialogs.orthophoto_dialog import OrthoDialog
from vomstudio.ui.panels.tools.line import LinePanel
from vomstudio.ui.panels.tools.plane import PlanePanel
from vomstudio.ui.panels.tools.trace import TracePanel
from vomstudio.ui.shell.main_window import MainWindow

SHIFT = Qt.KeyboardModifier.ShiftModifier
BEDS = ("B01", "B02", "B03", "B04", "B05", "B06")
FAULT = "B07"
JOINTS = (("B08", slice(None)), ("B02", slice(None, None, 2)), ("B05", slice(1, None, 2)))


class Hour:
    def __init__(self, window: MainWindow, models: Path, out: Path, name: str) -> None:
        self.window, self.studio, self.view = window, window.studio, window.viewport
        self.models, self.out, self.name = models, out, name
        self.picks = read_picks()
        self.number = 0

    def play(self) -> None:
        self.open()
        self.pick_traces()
        self.paint_patches()
        self.pick_slip()
        self.undo_everything_once()
        self.look_at_the_net()
        self.look_along_the_axis()
        self.make_orthophoto()
        self.write_tables()

    # --- between the steps -------------------------------------------------------------------
    def done(self, step: str) -> None:
        """A step is done: keep a picture, and see that the keys are the outcrop's."""
        self.number += 1
        wait(lambda: self.view.is_still, "the picture's rest")
        driver.pause(100)
        driver.keep_picture(self.window, f"hour_{self.name}_{self.number:02d}_{step}")
        focus = QApplication.focusWidget()
        assert focus is self.view, f"after {step} the keyboard is with {focus}"
        screen = self.window.screen().availableGeometry()
        assert screen.contains(self.window.geometry()), "the window does not fit the screen"
        assert self.view.width() > 300, self.view.width()
        assert self.view.height() > 200, self.view.height()
        print(f"{self.number:2d} {step}", flush=True)

    def undone(self, what: str) -> None:
        """One undo and one redo, of two keys each, which say what they did."""
        before = dict(self.studio.records)
        key(self.window, Qt.Key.Key_Z, CTRL)
        assert self.said() == f"Undone: {what}", self.said()
        assert dict(self.studio.records) != before
        key(self.window, Qt.Key.Key_Z, CTRL | SHIFT)
        assert self.said() == f"Redone: {what}", self.said()
        assert dict(self.studio.records) == before

    def said(self) -> str:
        return self.window.statusBar().currentMessage()

    def choose(self, box: QComboBox, data: object) -> None:
        """Open a list with the mouse and click the row; the keyboard goes back by itself."""
        self.show(box)
        QTest.mouseClick(box, driver.LEFT, driver.NONE, box.rect().center())
        rows = box.view()
        wait(rows.isVisible, "the list", 5.0)
        # Or the second click were a double click, which Qt takes for the first one's release.
        driver.pause(QApplication.doubleClickInterval() + 50)
        row = box.findData(data)
        assert row >= 0, data
        rows.scrollTo(rows.model().index(row, 0), QAbstractItemView.ScrollHint.EnsureVisible)
        at = rows.visualRect(rows.model().index(row, 0)).center()
        QTest.mouseMove(rows.viewport(), at)
        QTest.mouseClick(rows.viewport(), driver.LEFT, driver.NONE, at)
        wait(lambda: box.currentData() == data, f"the choice of {data}", 5.0)
        self.focus_outcrop()

    def type_into(self, field: QLineEdit, text: str) -> None:
        """Click into a field, type, and press Enter."""
        self.show(field)
        QTest.mouseClick(field, driver.LEFT, driver.NONE, field.rect().center())
        wait(field.hasFocus, "the field's focus", 5.0)
        field.selectAll()
        QTest.keyClick(field, Qt.Key.Key_Delete)
        QTest.keyClicks(field, text)
        QTest.keyClick(field, Qt.Key.Key_Return)
        self.focus_outcrop()

    def show(self, widget: QWidget) -> None:
        """Scroll a panel to what is going to be clicked; the whole of it is then in sight."""
        area = widget.parentWidget()
        while area is not None and not hasattr(area, "ensureWidgetVisible"):
            area = area.parentWidget()
        if area is not None:
            area.ensureWidgetVisible(widget)
            QApplication.processEvents()
        seen = widget.visibleRegion().boundingRect()
        assert seen.contains(widget.rect().center()), f"{widget.objectName()} cannot be reached"

    def focus_outcrop(self) -> None:
        wait(lambda: QApplication.focusWidget() is self.view, "the keyboard back", 5.0)

    # --- the steps ---------------------------------------------------------------------------
    def open(self) -> None:
        driver.pause(200)
        driver.keep_picture(self.window, f"hour_{self.name}_00_start")
        self.window.open_path(bare_outcrop(self.models))
        wait(lambda: driver.dialog_of(self.window), "the frame dialog")
        dialog = driver.dialog_of(self.window)
        driver.keep_picture(dialog, f"hour_{self.name}_00_frame")
        assert self.window.screen().availableGeometry().contains(dialog.frameGeometry())
        driver.declare(self.window)
        driver.settled(self.window)
        self.done("open")

    def spots(self, points: np.ndarray, apart: int = 14) -> np.ndarray:
        """The points that can be clicked: seen, and clear of each other on the screen."""
        look_at(self.window, points, 0.0, 10.0)
        pixels, seen = self.view.project(points)
        chosen: list[int] = []
        for i in range(len(points)):
            x, y = np.round(pixels[i])
            hit = self.view.pick(x, y) if seen[i] else None
            if hit is None or np.linalg.norm(self.view.world_position(hit) - points[i]) > 0.03:
                continue
            if all(np.hypot(*(pixels[i] - pixels[j])) > apart for j in chosen):
                chosen.append(i)
        return points[chosen]

    def trace(self, points: np.ndarray) -> None:
        chosen = self.spots(points)
        assert len(chosen) >= 5, len(chosen)
        pick(self.window, chosen)
        key(self.window, Qt.Key.Key_Return)

    def pick_traces(self) -> None:
        key(self.window, Qt.Key.Key_T)
        assert self.studio.tool_name == "trace"
        panel = driver.tool_panel(self.window, TracePanel)
        for name in BEDS:
            self.trace(self.picks[name])
        self.done("beds")
        self.undone("Bedding trace B06")
        self.choose(panel.type_box, "joint")
        self.type_into(panel.set_name_edit, "J1")
        for name, part in JOINTS:
            self.trace(self.picks[name][part])
        self.done("joints")
        self.undone("Joint trace J03")
        self.choose(panel.type_box, "fault")
        self.type_into(panel.set_name_edit, "")
        self.trace(self.picks[FAULT])
        self.done("fault")
        self.undone("Fault trace F01")
        made = driver.traces(self.window)
        assert [t.type_id for t in made] == ["bedding"] * 6 + ["joint"] * 3 + ["fault"]
        assert [t.set_name for t in made] == [""] * 6 + ["J1"] * 3 + [""]

    def paint_patches(self) -> None:
        wait(
            lambda: all(
                m.surface._faces_by_vertex is not None for m in self.studio.models.values()
            ),
            "the search structures",
        )
        key(self.window, Qt.Key.Key_P)
        panel = driver.tool_panel(self.window, PlanePanel)
        self.choose(panel.type_box, "bedding")
        for count, name in enumerate(("B01", "B04"), start=1):
            look_at(self.window, self.picks[name], 0.0, 10.0)
            at = pixel(self.window, np.median(self.picks[name], axis=0))
            drag(self.view, at, at + QPoint(50, 14))
            key(self.window, Qt.Key.Key_Return)
            assert len(self.studio.session.of(Patch)) == count
        self.done("patches")
        self.undone("Patch B08")

    def pick_slip(self) -> None:
        fault = driver.traces(self.window)[-1]
        key(self.window, Qt.Key.Key_L)
        panel = driver.tool_panel(self.window, LinePanel)
        points = self.spots(self.picks[FAULT], apart=40)
        self.choose(panel.plane_box, fault.id)
        self.choose(panel.slip_box, "normal")
        pick(self.window, points[[0, len(points) // 2]])
        key(self.window, Qt.Key.Key_Return)
        (made,) = self.studio.session.of(Lineation)
        assert (made.plane_id, made.slip) == (fault.id, "normal")
        self.done("slip")
        self.undone(f"Lineation {made.name}")

    def undo_everything_once(self) -> None:
        """Back to the open model and forth again: no step is lost, and each has a name."""
        before = dict(self.studio.records)
        said = []
        while self.studio.session.features():
            key(self.window, Qt.Key.Key_Z, CTRL)
            said.append(self.said())
        assert len(said) == len(set(said)), said
        assert all(text.startswith("Undone: ") and len(text) > 12 for text in said), said
        for _ in said:
            key(self.window, Qt.Key.Key_Z, CTRL | SHIFT)
        assert dict(self.studio.records) == before
        key(self.window, Qt.Key.Key_N)
        self.done("undone_and_redone")

    def look_at_the_net(self) -> None:
        key(self.window, Qt.Key.Key_3, CTRL)
        net = self.window.net
        wait(lambda: net.isVisible() and net.is_up_to_date and net.artists is not None, "the net")
        driver.pause(200)
        wait(lambda: net.is_up_to_date, "the net at its size")
        shown = net.contents()
        assert sum(map(len, shown.sets)) == 13
        assert shown.fold is not None
        # A pole that stands apart from the others is clicked.
        ids = [id_ for each in shown.sets for id_ in each.ids]
        poles = np.concatenate(net.artists.positions)
        apart = np.linalg.norm(poles[:, None] - poles, axis=2) + np.eye(len(poles))
        one = int(np.argmax(apart.min(axis=1)))
        pole = np.array(net.artists.centre_px) + net.artists.radius_px * poles[one]
        x, y = pole / net.canvas.devicePixelRatioF()
        click(net.canvas, QPoint(round(x), round(net.canvas.height() - y)))
        assert self.studio.selection.ids == (ids[one],)
        move(self.view, self.view.rect().center())
        driver.focus(self.window)
        self.done("net")

    def look_along_the_axis(self) -> None:
        key(self.window, Qt.Key.Key_B)
        wait(lambda: self.view.moves.orthographic, "the orthographic view")
        trend, plunge = self.view.moves.view_direction()
        axis = self.window.net.contents().fold.beta
        off = min(abs((trend - axis.trend_deg + 180) % 360 - 180), 180)
        assert min(off, 180 - off) < 0.01
        assert abs(abs(plunge) - axis.plunge_deg) < 0.01
        self.done("along_the_axis")
        key(self.window, Qt.Key.Key_Z, SHIFT)
        wait(lambda: not self.view.moves.orthographic, "the earlier view")
        key(self.window, Qt.Key.Key_Y, SHIFT)
        wait(lambda: self.view.moves.orthographic, "the later view")
        self.focus_outcrop()

    def make_orthophoto(self, gsd: str = "0.02") -> None:
        key(self.window, Qt.Key.Key_P, CTRL)
        wait(lambda: self.window.findChild(OrthoDialog), "the orthophoto's dialog")
        dialog = self.window.findChild(OrthoDialog)
        wait(dialog._start_button.isEnabled, "a proposed pixel size")
        assert self.window.screen().availableGeometry().contains(dialog.frameGeometry())
        for field, text in ((dialog.gsd, gsd), (dialog.target, str(self.out / "view.tif"))):
            field.setFocus()
            field.selectAll()
            QTest.keyClicks(field, text)
        driver.keep_picture(dialog, f"hour_{self.name}_{self.number:02d}_orthophoto_dialog")
        QTest.mouseClick(dialog._start_button, driver.LEFT)
        wait((self.out / "view.json").exists, "the orthophoto", 90.0)
        wait(lambda: not self.studio.jobs.visible(), "the end of the job")
        # What a window manager does when a dialog has closed.
        self.window.activateWindow()
        self.focus_outcrop()
        self.done("orthophoto")

    def export_rows(self) -> list[dict[str, str]]:
        """Save the project and export its planes; the rows of the table."""
        self.studio.save_as(self.out / "hour.vom")
        self.window.files.export_features("csv", self.out / "planes.csv")
        lines = (self.out / "planes.csv").read_text("utf-8").splitlines()
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))

    def write_tables(self) -> None:
        rows = self.export_rows()
        assert len(rows) == 13
        (slip,) = [row for row in rows if row["slip_sense"]]
        assert slip["slip_sense"] == "normal"
        assert [row["set"] for row in rows].count("J1") == 3
        key(self.window, Qt.Key.Key_2, CTRL)
        self.done("tables")


class RealHour(Hour):
    """The hour on a model of a rocky shore from photos of a drone, whose planes nobody knows."""

    def __init__(self, window: MainWindow, model: Path, out: Path, name: str) -> None:
        super().__init__(window, model.parent, out, f"real_{name}")
        self.model = model

    def play(self) -> None:
        self.open()
        self.pick_traces()
        self.grow_planes()
        self.look_at_the_net()
        self.make_orthophoto("0.2")
        self.write_tables()

    def open(self) -> None:
        self.window.open_path(self.model)
        driver.declare(self.window, "EPSG:32615")
        driver.settled(self.window)
        wait(
            lambda: all(
                m.surface._faces_by_vertex is not None for m in self.studio.models.values()
            ),
            "the search structures",
            120.0,
        )
        self.done("open")

    def rock(self, rows: int, columns: int) -> list[QPoint]:
        """Places on the rock in the middle of the view, which nothing covers."""
        place, found = self.view.rect(), []
        for row in range(rows):
            for column in range(columns):
                x = round(place.width() * (0.25 + 0.5 * column / max(columns - 1, 1)))
                y = round(place.height() * (0.35 + 0.4 * row / max(rows - 1, 1)))
                above = self.window.childAt(self.view.mapTo(self.window, QPoint(x, y)))
                if above is self.view and self.view.pick(x, y) is not None:
                    found.append(QPoint(x, y))
        return found

    def pick_traces(self) -> None:
        key(self.window, Qt.Key.Key_T)
        for number in range(3):
            places = self.rock(5, 5)[number::3]
            assert len(places) >= 4
            for at in places:
                click(self.view, at)
            key(self.window, Qt.Key.Key_Return)
            assert len(driver.traces(self.window)) == number + 1
        self.done("traces")

    def grow_planes(self) -> None:
        key(self.window, Qt.Key.Key_P)
        tool = self.studio.get_tool(PlaneTool)
        for at in self.rock(2, 4):
            click(self.view, at)
            wait(lambda: tool.count, "the plane")
            key(self.window, Qt.Key.Key_Return)
        assert len(self.studio.session.of(Patch)) >= 4
        key(self.window, Qt.Key.Key_N)
        self.done("planes")

    def look_at_the_net(self) -> None:
        key(self.window, Qt.Key.Key_3, CTRL)
        net = self.window.net
        wait(lambda: net.isVisible() and net.is_up_to_date and net.artists is not None, "the net")
        features = self.studio.session.features()
        assert sum(map(len, net.contents().sets)) == len(features)
        for measured in self.studio.measured(f.id for f in features).values():
            assert measured.plane is not None
            assert measured.verdict is not None
        self.done("net")

    def write_tables(self) -> None:
        assert len(self.export_rows()) == len(self.studio.session.features())
        self.done("tables")


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("models", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--theme", default="light")
    parser.add_argument("--real", type=Path)
    args = parser.parse_args()
    app = QApplication([])
    window = driver.make_window()
    window.actions_table.run(f"theme_{args.theme}")
    window.setGeometry(window.screen().availableGeometry())
    driver.focus(window)
    size = window.screen().size()
    name = f"{size.width()}x{size.height()}@{window.devicePixelRatioF():g}_{args.theme}"
    if args.real:
        RealHour(window, args.real, args.out, name).play()
    else:
        Hour(window, args.models, args.out, name).play()
    driver.dismiss(window)
    del app
    return 0


if __name__ == "__main__":
    sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    code = main()
    sys.stdout.flush()
    # What VTK and Qt take down at the very end is not the hour's matter.
    os._exit(code)
