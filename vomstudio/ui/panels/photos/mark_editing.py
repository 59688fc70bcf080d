"""Points and their marks as they are shown, placed, moved and removed in an opened photo."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.photogrammetry.georeferencing.mark_prediction import BAD_PX
from vomstudio.ui.base import file_filters
from vomstudio.ui.panels.photos.mark_canvas import MARK, MarkCanvas, ShownMark
from vomstudio.ui.panels.photos.opened_photo import OpenedPhoto
from vomstudio.ui.panels.photos.photo_marks import PhotoMarks
from vomstudio.ui.panels.photos.photo_tools import PhotoTools
from vomstudio.ui.panels.photos.points_box import PointsBox


class MarkEditing(QObject):
    """Edits the points and marks as the user clicks, drags and types.

    message : a sentence for the user, and its level
    """

    message = Signal(object, str)

    def __init__(
        self,
        marks: PhotoMarks,
        points: PointsBox,
        photo: OpenedPhoto,
        canvas: MarkCanvas,
        tools: PhotoTools,
    ) -> None:
        super().__init__()
        self._marks, self._points, self._photo = marks, points, photo
        self._canvas, self._tools = canvas, tools
        points.typed.connect(self._typed)
        tools.marked.connect(self._place)
        tools.moved.connect(self._moved)
        tools.picked.connect(points.choose)
        canvas.nudged.connect(self._nudge)
        photo.turned.connect(self._turned)

    # --- showing -----------------------------------------------------------------------------
    def show(self) -> None:
        """Draw the marks of this photo, the predicted positions of the other points, and the
        epipolar line of the chosen one."""
        marking, chosen, photo = self._marks.marking, self._points.label, self._photo.name
        there = marking.within(photo)
        shown = []
        for label, pixel in there.items():
            prediction = self._marks.prediction(label)
            residual, worst = prediction.residuals_px.get(photo), prediction.worst
            bad = worst is not None and worst[0] == photo and worst[1] > BAD_PX
            role = marking.role(label)
            shown.append(ShownMark(label, role, pixel, label == chosen, False, residual, bad))
        for label in marking.labels:
            if label not in there and (at := self._marks.prediction(label).expected.get(photo)):
                role = marking.role(label)
                shown.append(ShownMark(label, role, at, label == chosen, True))
        self._canvas.set_marks(shown)
        self._canvas.set_epipolar_line(self._marks.epipolar_line(chosen, photo))

    def look_at_point(self, *, again: bool = False) -> None:
        """While points are marked, the photo is opened where the point is, or should be."""
        label, photo = self._points.label, self._photo.name
        if self._canvas.tool != MARK or not label:
            return
        if self._photo.looks_at(label) and not again:
            return
        place = self._marks.marking.of(label).get(photo)
        place = place or self._marks.prediction(label).expected.get(photo)
        if place is not None:
            self._photo.look_at(label, place)

    def _turned(self) -> None:
        self.look_at_point(again=True)

    # --- points ------------------------------------------------------------------------------
    def why_no_point(self) -> Finding | None:
        """Return that no point is chosen; None if one is."""
        return None if self._points.label else Finding("action.no-point")

    def why_no_mark(self) -> Finding | None:
        """Return that the chosen point is not marked in this photo; None if it is."""
        if (reason := self.why_no_point()) is not None:
            return reason
        there = self._photo.name in self._marks.marking.of(self._points.label)
        return None if there else Finding("action.no-mark")

    def new_point(self) -> None:
        """Add a point with a free label, choose it and take up the mark tool."""
        label = self._marks.marking.free_label()
        made = self._marks.marking.begun_with(label)
        self._marks.change(tr("New point"), made)
        self._points.choose(label)
        self._tools.take_up(MARK)
        self._canvas.setFocus()

    def remove_point(self) -> None:
        """Remove the chosen point with all its marks."""
        label = self._points.label
        made = self._marks.marking.removed(label)
        self._marks.change(tr("Remove {label}", label=label), made)
        self._points.choose("")

    def import_table(self, folder: Path, parent: QWidget, *, marks: bool) -> None:
        """Ask for a file, beginning in `folder`, and import its control points or its marks."""
        title = tr("Import image marks") if marks else tr("Import control points")
        name, _ = QFileDialog.getOpenFileName(
            parent, title, str(folder), file_filters.ground_control()
        )
        if not name:
            return
        try:
            if marks:
                count, warning = self._marks.import_marks(Path(name))
                imported = Finding("marks.imported", count=count)
            else:
                count, warning = self._marks.import_points(Path(name)), None
                imported = Finding("points.imported", count=count)
        except VomError as error:
            self.message.emit(error, "error")
            return
        labels = self._marks.marking.labels
        if not self._points.label and labels:
            self._points.choose(labels[0])
        self.message.emit(imported, "info")
        if warning is not None:
            self.message.emit(warning, "warning")

    # --- marks -------------------------------------------------------------------------------
    def remove_mark(self) -> None:
        label, photo = self._points.label, self._photo.name
        made = self._marks.marking.unmarked(label, photo)
        self._marks.change(tr("Remove mark of {label}", label=label), made)

    def _place(self, x: float, y: float, join: str | None = None) -> None:
        """Mark the chosen point here; without one, a new tie point."""
        marking, photo = self._marks.marking, self._photo.name
        label = self._points.label or marking.free_label()
        key = None if join is None else (join, label, photo)
        made = marking.marked(label, photo, (x, y))
        self._photo.stay_at(label)
        self._marks.change(tr("Mark {label}", label=label), made, key)
        self._points.choose(label)

    def _typed(self, x: float, y: float) -> None:
        self._place(x, y, "typed")

    def _moved(self, label: str, x: float, y: float, goes_on: bool) -> None:
        photo = self._photo.name
        made = self._marks.marking.marked(label, photo, (x, y))
        self._marks.change(
            tr("Move {label}", label=label), made, ("drag", label, photo), goes_on=goes_on
        )

    def _nudge(self, dx: float, dy: float) -> None:
        row = self._photo.row
        pixel = self._marks.marking.of(self._points.label).get(self._photo.name)
        if pixel is not None and row is not None:
            x = min(max(pixel[0] + dx, 0.0), float(row.width))
            y = min(max(pixel[1] + dy, 0.0), float(row.height))
            self._place(x, y, "nudged")
