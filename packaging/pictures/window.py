"""The real window, driven with mouse and keys, for the pictures of the documents.

Run by `making.py` as a script on a screen of its own: OUT ACT [PROJECT or PHOTOS].
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from typing import Any

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QLineEdit, QToolTip

from tests.benchmarks.window_journey import MESSAGE_S, MIDDLE, Journey

SAMPLE = Path(__file__).resolve().parents[2] / "resources" / "sample"
ACTS = ("measured", "first", "photos")


class Pictures(Journey):
    """The sample project that the demo makes; the sample outcrop, with nothing measured yet; its
    photos."""

    def __init__(self, out: Path, act: str, opened: list[str]) -> None:
        super().__init__(out, act)
        self.opened = opened

    def words(self) -> list[str]:
        return self.opened

    def take(self, name: str, part: Any = None, quiet: float = 1.5) -> None:
        """The window as it is, or a part of it, once it is at rest."""
        QToolTip.hideText()
        self.stable(quiet)
        widget = self.window if part is None else part
        place = widget.mapToGlobal(widget.rect().topLeft())
        picture = self.grab().copy(place.x(), place.y(), widget.width(), widget.height())
        picture.save(str(self.out / f"{name}.png"))

    def look(self, trend: float, plunge: float, notches: int = 0) -> None:
        """Stand before the outcrop, and turn the wheel over the middle of it."""
        viewport = self.window.viewport
        viewport.moves.look_along(trend, plunge)
        self.wait(lambda: viewport.is_still, "the camera's rest")
        if notches:
            middle = viewport.mapToGlobal(viewport.rect().center())
            self.wheel(middle.x(), middle.y(), notches)

    def page(self, name: str) -> None:
        """Open a page of the drawer or inspector."""
        self.window.docks.bring_forward(name)

    def hide_joints(self) -> None:
        """Their zigzags over the facets tell little in a small picture."""
        table = self.named("orientation_table")
        words = self.dock("table").findChildren(QLineEdit)[0]
        self.write(words, "type:joint")
        self.wait(lambda: table.model().rowCount() < 15, "the joints")
        self.row(table, 0)
        last = table.model().index(table.model().rowCount() - 1, 0)
        table.scrollTo(last)
        place = table.viewport().mapToGlobal(table.visualRect(last).center())
        self.click(place.x(), place.y(), Qt.KeyboardModifier.ShiftModifier)
        self.run("hide_chosen")
        self.write(words, "")
        self.key("Backspace")
        self.wait(lambda: table.model().rowCount() > 15, "the whole table")

    def photos(self) -> None:
        verdict = self.named("survey_verdict")
        self.wait(lambda: verdict.text() and "…" not in verdict.text(), "the survey check")
        survey = self.window.survey
        self.wait(lambda: not survey.is_reading and not survey.is_forecasting, "the forecast")
        if self.window.docks.center_page != "photos":
            self.window.docks.toggle_center("photos")
        self.take("photos", None, MESSAGE_S)

    def pick(self, name: str, count: int) -> None:
        """Click some of the sample's own points of a trace, one after the other."""
        viewport = self.window.viewport
        pixels, _ = viewport.project(_points(name, count))
        for x, y in pixels:
            place = viewport.mapToGlobal(QPoint(round(float(x)), round(float(y))))
            self.click(place.x(), place.y())

    # --- the acts --------------------------------------------------------------------------------
    def measured(self) -> None:
        self.until_drawn(MIDDLE)
        self.page("table")
        self.hide_joints()
        self.look(40, 16, 2)
        self.row(self.named("orientation_table"), 8)
        self.page("properties")
        self.take("window", None, MESSAGE_S)
        self.run("along_beta")
        self.run("orthophoto")
        self.take("orthophoto_dialog", self.dialog())

    def first(self) -> None:
        self.run("open_sample")
        self.until_drawn(MIDDLE)
        self.take("first_opened", None, MESSAGE_S)
        self.look(31, 11)
        self.press("trace")
        self.pick("B09", 12)
        self.take("first_trace")
        self.key("Return")
        for name in ("B02", "B06", "B14", "B17"):
            self.pick(name, 9)
            self.key("Return")
        self.press("navigate")
        self.page("table")
        self.take("first_net", None, MESSAGE_S)


def _points(name: str, count: int) -> list[tuple[float, float, float]]:
    """World points of one of the sample's picks, evenly taken from all."""
    with open(SAMPLE / "picks.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    points = [tuple(float(r[axis]) for axis in "xyz") for r in rows if r["pick"] == name]
    return [points[round(i * (len(points) - 1) / (count - 1))] for i in range(count)]


if __name__ == "__main__":
    out, act, *opened = sys.argv[1:]
    sys.exit(Pictures(Path(out), act, opened).play())
