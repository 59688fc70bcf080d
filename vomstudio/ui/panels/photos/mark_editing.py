"""Editing of points and marks in an open photo."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.photogrammetry.georeferencing.mark_prediction import MAX_GOOD_RESIDUAL_PX
from vomstudio.ui.base import file_filters
from vomstudio.ui.panels.photos.mark_canvas import MARK, MarkCanvas, ShownMark
from vomstudio.ui.panels.photos.opened_photo import OpenedPhoto
from vomstudio.ui.panels.photos.photo_marks import PhotoMarks
from vomstudio.ui.panels.photos.photo_tools import PhotoTools
from vomstudio.ui.panels.photos.points_box import PointsBox


class MarkEditing(QObject):
    """Editor of points and marks that responds to mouse and keyboard.

    Attributes
    ----------
    message : Signal
        Emitted with a message for the user and its level.
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
        points.mark_edited.connect(self._place_typed_mark)
        tools.mark_requested.connect(self._place_mark)
        tools.mark_moved.connect(self._move_mark)
        tools.mark_picked.connect(points.select_point)
        canvas.nudged.connect(self._nudge)
        photo.orientation_changed.connect(self._refocus)

    # --- display -----------------------------------------------------------------------------
    def show(self) -> None:
        """Draw the marks, the predicted positions, and the epipolar line of the selected point."""
        marking, selected_label, photo = self._marks.marking, self._points.label, self._photo.name
        pixels = marking.marks_in_photo(photo)
        symbols = []
        for label, pixel in pixels.items():
            prediction = self._marks.prediction(label)
            residual, worst_mark = prediction.residuals_px.get(photo), prediction.worst_mark
            is_inaccurate = (
                worst_mark is not None
                and worst_mark[0] == photo
                and worst_mark[1] > MAX_GOOD_RESIDUAL_PX
            )
            role = marking.role(label)
            symbols.append(
                ShownMark(
                    label=label,
                    role=role,
                    pixel=pixel,
                    is_selected=label == selected_label,
                    is_predicted=False,
                    residual_px=residual,
                    is_worst=is_inaccurate,
                )
            )
        for label in marking.labels:
            if label not in pixels and (
                position := self._marks.prediction(label).expected.get(photo)
            ):
                role = marking.role(label)
                symbols.append(
                    ShownMark(
                        label=label,
                        role=role,
                        pixel=position,
                        is_selected=label == selected_label,
                        is_predicted=True,
                    )
                )
        self._canvas.set_marks(symbols)
        self._canvas.set_epipolar_line(self._marks.epipolar_line(selected_label, photo))

    def look_at_point(self, *, is_forced: bool = False) -> None:
        """Zoom to the selected point if the mark tool is active.

        The view does not move if it already shows the point, unless `is_forced` is True.
        """
        label, photo = self._points.label, self._photo.name
        if self._canvas.tool != MARK or not label:
            return
        if self._photo.is_viewing_point(label) and not is_forced:
            return
        pixel = self._marks.marking.of(label).get(photo)
        pixel = pixel or self._marks.prediction(label).expected.get(photo)
        if pixel is not None:
            self._photo.zoom_to_point(label, pixel)

    def _refocus(self) -> None:
        self.look_at_point(is_forced=True)

    # --- points ------------------------------------------------------------------------------
    def point_selection_problem(self) -> Finding | None:
        """Return a finding if no point is selected, otherwise None."""
        return None if self._points.label else Finding("action.no-point")

    def mark_problem(self) -> Finding | None:
        """Return a finding if the selected point is not marked in this photo, otherwise None."""
        if (reason := self.point_selection_problem()) is not None:
            return reason
        is_marked = self._photo.name in self._marks.marking.of(self._points.label)
        return None if is_marked else Finding("action.no-mark")

    def add_point(self) -> None:
        """Add a tie point with an unused label, select it and activate the mark tool."""
        label = self._marks.marking.free_label()
        new_marking = self._marks.marking.add_label(label)
        self._marks.change(tr("New point"), new_marking)
        self._points.select_point(label)
        self._tools.set_tool(MARK)
        self._canvas.setFocus()

    def remove_point(self) -> None:
        """Remove the selected point and all its marks."""
        label = self._points.label
        new_marking = self._marks.marking.remove_point(label)
        self._marks.change(tr("Remove {label}", label=label), new_marking)
        self._points.select_point("")

    def import_table(self, folder: Path, parent: QWidget, *, is_mark_table: bool) -> None:
        """Import control points or marks from a file that the user selects.

        Parameters
        ----------
        folder : Path
            Initial folder of the file dialog.
        parent : QWidget
        is_mark_table : bool
            Whether to import marks instead of control points.
        """
        title = tr("Import image marks") if is_mark_table else tr("Import control points")
        name, _ = QFileDialog.getOpenFileName(
            parent, title, str(folder), file_filters.ground_control()
        )
        if not name:
            return
        try:
            if is_mark_table:
                count, warning = self._marks.import_marks(Path(name))
                notice = Finding("marks.imported", count=count)
            else:
                count, warning = self._marks.import_points(Path(name)), None
                notice = Finding("points.imported", count=count)
        except VomError as error:
            self.message.emit(error, "error")
            return
        labels = self._marks.marking.labels
        if not self._points.label and labels:
            self._points.select_point(labels[0])
        self.message.emit(notice, "info")
        if warning is not None:
            self.message.emit(warning, "warning")

    # --- marks -------------------------------------------------------------------------------
    def remove_mark(self) -> None:
        label, photo = self._points.label, self._photo.name
        new_marking = self._marks.marking.remove_mark(label, photo)
        self._marks.change(tr("Remove mark of {label}", label=label), new_marking)

    def _place_mark(self, x: float, y: float, merge_key: str | None = None) -> None:
        """Mark the selected point, or a new tie point if no point is selected."""
        marking, photo = self._marks.marking, self._photo.name
        label = self._points.label or marking.free_label()
        key = None if merge_key is None else (merge_key, label, photo)
        new_marking = marking.set_mark(label, photo, (x, y))
        self._photo.set_viewed_point(label)
        self._marks.change(tr("Mark {label}", label=label), new_marking, key)
        self._points.select_point(label)

    def _place_typed_mark(self, x: float, y: float) -> None:
        self._place_mark(x, y, "typed")

    def _move_mark(self, label: str, x: float, y: float, is_ongoing: bool) -> None:
        photo = self._photo.name
        new_marking = self._marks.marking.set_mark(label, photo, (x, y))
        self._marks.change(
            tr("Move {label}", label=label),
            new_marking,
            ("drag", label, photo),
            is_ongoing=is_ongoing,
        )

    def _nudge(self, dx: float, dy: float) -> None:
        row = self._photo.row
        pixel = self._marks.marking.of(self._points.label).get(self._photo.name)
        if pixel is not None and row is not None:
            x = min(max(pixel[0] + dx, 0.0), float(row.width))
            y = min(max(pixel[1] + dy, 0.0), float(row.height))
            self._place_mark(x, y, "nudged")
