"""Page of an open photo, in which masks are drawn and points are marked."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QCloseEvent, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import (
    QSplitter,
    QToolBar,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.photos.cameras_file import FILE_NAME
from vomstudio.photogrammetry.georeferencing.mark_prediction import PlacedPhotos
from vomstudio.project.edit import Edit
from vomstudio.studio.history import step_title
from vomstudio.ui.base import theme
from vomstudio.ui.base.actions import Actions
from vomstudio.ui.base.controls import ElidedLabel, Label, PanelScrollArea
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Notice
from vomstudio.ui.panels.photos.mark_canvas import LOOK, MARK, POLYGON, MarkCanvas
from vomstudio.ui.panels.photos.mark_editing import MarkEditing
from vomstudio.ui.panels.photos.mask_box import MaskBox
from vomstudio.ui.panels.photos.opened_photo import OpenedPhoto
from vomstudio.ui.panels.photos.photo_document import edited_photo
from vomstudio.ui.panels.photos.photo_list import PhotoList
from vomstudio.ui.panels.photos.photo_marks import PhotoMarks
from vomstudio.ui.panels.photos.photo_masks import PhotoMasks
from vomstudio.ui.panels.photos.photo_page_commands import (
    TOOLS,
    mask_commands,
    own_window_command,
    point_commands,
    set_shortcuts,
    undo_commands,
    view_commands,
)
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.panels.photos.photo_tools import PhotoTools
from vomstudio.ui.panels.photos.points_box import PointsBox
from vomstudio.ui.widgets.messages_panel import MessageBar

# On narrower pages the list is hidden.
_MIN_WIDTH_WITH_LIST_PX = 1000


class PhotoPage(QWidget):
    """Page of an open photo, as a tab of the main window or as a separate window.

    Each change of a mask shape or a point mark is one edit in the history of the project.

    Attributes
    ----------
    changed : Signal
        Emitted when the next undo or redo step has changed.
    hint_changed : Signal
        Emitted with the text of the status line.
    attention_requested : Signal
        Emitted when the page has a message that the user must see.
    window_toggle_requested : Signal
        Emitted to move the page to a separate window, or back to the main window.
    closed : Signal
        Emitted once when the page closes.
    """

    changed = Signal()
    hint_changed = Signal(str)
    attention_requested = Signal()
    window_toggle_requested = Signal()
    closed = Signal()

    def __init__(self, survey: PhotoSurvey) -> None:
        super().__init__()
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.is_open = True
        self.survey = survey
        assert survey.folder is not None
        self.folder = survey.folder
        self._is_stepping = False
        self._steps: list[Finding | str | None] = []
        self._changed_masks: set[str] = set()
        rows = {row.name: row for row in survey.rows}
        self.document = survey.document
        self.masks = PhotoMasks(survey.rows, self.document)
        self.marks = PhotoMarks(self.document, list(rows))
        self.canvas = MarkCanvas()
        self.opened_photo = OpenedPhoto(rows, self.canvas)
        self.tools = PhotoTools(self.canvas, self.masks)
        self.list = PhotoList(survey.rows, self.marks)
        self.mask_box = MaskBox(self.canvas)
        self.points = PointsBox(self.marks)
        self._editing = MarkEditing(
            marks=self.marks,
            points=self.points,
            photo=self.opened_photo,
            canvas=self.canvas,
            tools=self.tools,
        )
        self._make_actions()
        self._status_text = ""
        self._status = ElidedLabel()
        self._status.setObjectName("photo_status")
        self._arrange_widgets()
        self.bar = MessageBar(self._middle)
        self._background = QtBackground(self)
        self._connect_signals()
        self._read_cameras()
        self.tools.set_tool(LOOK)

    # --- parts -------------------------------------------------------------------------------
    def _make_actions(self) -> None:
        self.actions_table = Actions(self)
        for command in (
            *view_commands(self.list, self.canvas, self.tools),
            *undo_commands(self.masks, self.tools, self.document, self.undo),
            *mask_commands(self.masks, self.mask_box, self.canvas, self.opened_photo),
            *point_commands(self._editing, self.folder, self),
            own_window_command(self, self.window_toggle_requested.emit),
        ):
            self.actions_table.add(command)
        self.actions_table.assign_viewport_keys(self.canvas)
        self.mask_box.set_actions(self.actions_table.all)
        self.points.set_actions(self.actions_table.all)

    def _arrange_widgets(self) -> None:
        self.toolbar = bar = QToolBar()
        bar.setIconSize(QSize(18, 18))
        theme.highlight_toggles(bar)
        bar.setMovable(False)
        actions = self.actions_table.all
        self._title = Label()
        self._title.setObjectName("photo_title")
        for name in (
            "previous",
            "next",
            "*title",
            "|",
            *TOOLS,
            "|",
            "undo",
            "redo",
            "|",
            "fit",
            "one_to_one",
            "|",
            "own_window",
        ):
            if name == "|":
                bar.addSeparator()
            elif name == "*title":
                self._title.setMinimumWidth(self.fontMetrics().horizontalAdvance("M" * 16))
                self._title.setContentsMargins(6, 0, 6, 0)
                self._title_action = bar.addWidget(self._title)
            else:
                bar.addAction(actions[name])
                button = bar.widgetForAction(actions[name])
                if isinstance(button, QToolButton) and name in (*TOOLS, "fit", "one_to_one"):
                    button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._middle = QWidget()
        middle_layout = QVBoxLayout(self._middle)
        middle_layout.setContentsMargins(0, 0, 0, 0)
        middle_layout.setSpacing(0)
        middle_layout.addWidget(self.canvas, 1)
        side_widget = QWidget()
        column = QVBoxLayout(side_widget)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.mask_box)
        column.addWidget(self.points, 1)
        split = QSplitter(Qt.Orientation.Horizontal)
        for widget in (self.list, self._middle, PanelScrollArea(side_widget)):
            split.addWidget(widget)
        split.setStretchFactor(1, 1)
        split.setSizes([250, 830, 310])
        split.setChildrenCollapsible(False)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(6, 2, 6, 4)
        layout.setSpacing(4)
        layout.addWidget(bar)
        layout.addWidget(split, 1)
        layout.addWidget(self._status)
        self.set_own_window(False)

    def set_own_window(self, is_own_window: bool) -> None:
        """Adapt the page to a separate window or to the main window.

        The main window has its own tab with the name of the photo, status line, undo buttons and
        shortcuts.
        """
        set_shortcuts(self.actions_table, is_own_window=is_own_window)
        for name in ("undo", "redo"):
            self.actions_table.all[name].setVisible(is_own_window)
        self._title_action.setVisible(is_own_window)
        self._status.setVisible(is_own_window)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self.list.setVisible(self.width() >= _MIN_WIDTH_WITH_LIST_PX)

    def _connect_signals(self) -> None:
        self.list.opened.connect(self.show_photo)
        self.masks.mask_changed.connect(self._update_mask)
        self.masks.busy_changed.connect(self._refresh)
        # Another folder may have been opened in the meantime.
        self.masks.busy_changed.connect(self._survey_changed, Qt.ConnectionType.QueuedConnection)
        self.masks.message.connect(self.show_message)
        self.marks.message.connect(self.show_message)
        self.marks.changed.connect(self._show_marks)
        self.survey.exports.message.connect(self.show_message)
        self.survey.exports.mask_written.connect(self._note_stored_mask)
        self.points.message.connect(self.show_message)
        self.points.point_selected.connect(self._select_point)
        self._editing.message.connect(self.show_message)
        self.tools.corners_changed.connect(self._refresh)
        self.tools.tool_changed.connect(self._handle_tool_change)
        self.canvas.pointed.connect(self._show_position)
        self.survey.history_changed.connect(self._refresh)
        self.survey.edited.connect(self._follow_edit)
        # Emitted after a new alignment, or when another folder is opened.
        self.survey.changed.connect(self._survey_changed)
        self.survey.rows_changed.connect(self._survey_changed)

    # --- photo -------------------------------------------------------------------------------
    @property
    def photo(self) -> str:
        """Name of the open photo."""
        return self.opened_photo.name

    def show_photo(self, name: str) -> None:
        """Open the photo with this name."""
        if name == self.photo:
            self._editing.look_at_point()
            return
        self.opened_photo.show(name)
        row = self.opened_photo.rows[name]
        self.tools.set_photo(name, row.width, row.height)
        self.masks.open(name)
        if self.list.currentItem() is None or self.list.names[self.list.currentRow()] != name:
            self.list.open(name)
        short_name = name.rpartition("/")[2]
        self._title.setText(short_name)
        self.setWindowTitle(tr("{photo} – {folder}", photo=short_name, folder=self.folder.name))
        self.points.show_photo(name, row.width, row.height)
        self._show_marks()
        self._editing.look_at_point()

    # --- masks -------------------------------------------------------------------------------
    def _update_mask(self, name: str) -> None:
        if name == self.photo:
            used_pixels = self.masks.used(name)
            if used_pixels is not self.canvas.used:
                self.canvas.set_used(used_pixels)
            else:
                self.canvas.update_mask()
            if not self.masks.is_drawing:
                self._refresh()

    def _note_stored_mask(self, name: str) -> None:
        self._changed_masks.add(name)
        self.list.refresh()
        self._refresh()

    # --- points ------------------------------------------------------------------------------
    def _show_marks(self) -> None:
        self._editing.show()
        self._refresh()

    def _select_point(self, label: str) -> None:
        self.list.set_label(label)
        if label and self.canvas.tool != MARK:
            self.tools.set_tool(MARK)
        self._set_status(self._current_hint())
        self._show_marks()
        self._editing.look_at_point()

    # --- cameras -----------------------------------------------------------------------------
    def _read_cameras(self) -> None:
        out = self.survey.alignment_folder()
        self._camera_stamp = _stamp(out)
        if out is None:
            self.marks.set_cameras(None)
            return

        self._background.run(
            lambda: PlacedPhotos.read(out),
            self.marks.set_cameras,
            lambda error: self.show_message(error, "warning"),
        )

    def _survey_changed(self) -> None:
        if self.survey.folder != self.folder:
            if self.is_open and not self.masks.busy_reason:
                self.close()
        elif _stamp(self.survey.alignment_folder()) != self._camera_stamp:
            self._read_cameras()

    # --- tools and keys ----------------------------------------------------------------------
    def _handle_tool_change(self) -> None:
        self._refresh()
        self._set_status(self._current_hint())

    def undo(self, is_redo: bool = False) -> None:
        """Undo the last edit or the last polygon vertex; redo if `is_redo` is True."""
        if self.tools.corner_count and not is_redo:
            self.tools.remove_last_corner()
            return
        self.tools.end_stroke()
        label = self.document.redo_label if is_redo else self.document.undo_label
        if label is None:
            return
        self._is_stepping = True
        try:
            (self.document.redo if is_redo else self.document.undo)()
        finally:
            self._is_stepping = False
        step = step_title(label)
        self.show_message(Finding("edit.redone" if is_redo else "edit.undone", edit=step), "info")

    def _follow_edit(self, edit: Edit) -> None:
        """Show the photo to which an undone or redone edit belongs."""
        photo = edited_photo(edit)
        if self._is_stepping and photo in self.opened_photo.rows and photo != self.photo:
            self.show_photo(photo)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        if event.key() == Qt.Key.Key_Escape and self.tools.corner_count:
            self.tools.cancel()
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.canvas.tool == POLYGON:
            self.tools.close_polygon()
        else:
            super().keyPressEvent(event)

    def show_message(self, message: Finding | VomError, level: str = "info") -> None:
        """Show information in the status line, and messages of other levels in the message bar."""
        if level == "info":
            self._set_status(str(message))
        else:
            self.bar.show_notice(Notice(message, level))

    def _show_position(self, event: object) -> None:
        x, y = getattr(event, "x", 0.0), getattr(event, "y", 0.0)
        self._show_status(f"x {x:.1f}  y {y:.1f}   {self._status_text}")

    def _set_status(self, text: str) -> None:
        """Show a hint or message next to the cursor position until the next one replaces it."""
        self._status_text = text
        self._show_status(text)

    def _show_status(self, text: str) -> None:
        self._status.setText(text)
        self.hint_changed.emit(text)

    @property
    def hint(self) -> str:
        """Text of the status line."""
        return self._status.text()

    def _current_hint(self) -> str:
        return {
            "look": tr("Drag to pan, use the wheel to zoom."),
            "mark": tr(
                "Click to mark {point}. Drag a mark to move it (slowly with Shift), or press an "
                "arrow key for 0.1 px.",
                point=self.points.label,
            )
            if self.points.label
            else tr("Click to mark a new tie point."),
            "polygon": tr(
                "Click to add vertices. Press Enter, double-click or click the first vertex to "
                "close the polygon."
            ),
            "brush": tr(
                "Paint with the left button, pan with the right button. Brush size: [ and ]. Mask "
                "or unmask: X."
            ),
        }[self.canvas.tool]

    def _refresh(self) -> None:
        self.actions_table.refresh()
        steps: list[Finding | str | None] = [
            query(name)
            for name in ("undo", "redo")
            for query in (self.actions_table.disabled_reason, self.actions_table.target)
        ]
        if steps != self._steps:
            # Refreshing the commands of the main window at each step of a dragged mark would be
            # slow.
            self._steps = steps
            self.changed.emit()
        used_pixels = self.masks.used(self.photo)
        if self.masks.busy_reason is not None:
            text = self.masks.busy_reason.message
        elif self.survey.exports.problem is not None:
            text = tr("Saved in the project, but not next to the photos.")
        elif used_pixels is None:
            text = tr("Reading…") if self.photo else ""
        else:
            masked_percent = 100.0 * (1.0 - float(used_pixels[::4, ::4].mean()))
            text = (
                tr("Nothing is masked.")
                if used_pixels.all()
                else tr("{share:.0f} % of this photo is masked.", share=max(masked_percent, 1.0))
            )
        self.mask_box.status_label.setText(text)

    # --- closing -----------------------------------------------------------------------------
    def may_close(self) -> bool:
        """Return whether the page may be closed; warn the user if masks are being written."""
        self.tools.cancel()
        if self.masks.busy_reason is not None:
            self.attention_requested.emit()
            self.show_message(Finding("photo.busy", reason=self.masks.busy_reason), "warning")
            return False
        return True

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        if not self.may_close():
            event.ignore()
            return
        event.accept()
        self.end()

    def end(self) -> None:
        """Release all resources, even if releasing one fails. Further calls have no effect."""
        if not self.is_open:
            return
        self.is_open = False
        with ExitStack() as steps:
            steps.callback(self.closed.emit)
            steps.callback(self._repeat_check)
            for signal, slot in (
                (self.survey.history_changed, self._refresh),
                (self.survey.edited, self._follow_edit),
                (self.survey.rows_changed, self._survey_changed),
                (self.survey.changed, self._survey_changed),
            ):
                steps.callback(signal.disconnect, slot)
            for close_step in (
                self._background.stop,
                self.opened_photo.close,
                self.survey.exports.finish,
            ):
                steps.callback(close_step)
            for part in (self.marks, self.masks):
                steps.callback(part.close)

    def _repeat_check(self) -> None:
        if self._changed_masks and self.survey.folder == self.folder:
            self.survey.repeat_check()


def _stamp(out: Path | None) -> object:
    """Return a value that changes with the camera file, or None if the file is missing."""
    try:
        return None if out is None else (out, (out / FILE_NAME).stat().st_mtime_ns)
    except OSError:
        return None
