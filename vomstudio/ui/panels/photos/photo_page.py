"""An open photo, in which masks are drawn and points are marked."""

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
from vomstudio.ui.panels.photos.photo_document import photo_of
from vomstudio.ui.panels.photos.photo_list import PhotoList
from vomstudio.ui.panels.photos.photo_marks import PhotoMarks
from vomstudio.ui.panels.photos.photo_masks import PhotoMasks
from vomstudio.ui.panels.photos.photo_page_commands import (
    TOOLS,
    give_keys,
    look_commands,
    mask_commands,
    own_window_command,
    point_commands,
    undo_commands,
)
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.panels.photos.photo_tools import PhotoTools
from vomstudio.ui.panels.photos.points_box import PointsBox
from vomstudio.ui.widgets.messages_panel import MessageBar

# Narrower, the photo has the room of the list.
_LEAST_WITH_LIST = 1000


class PhotoPage(QWidget):
    """It stands in the middle of the main window, or is a window beside that. Every mask and mark
    is at once a step of the project's history, which both undo and redo.

    changed : another step would be undone or redone. hinted : its status line. wanted : it
    has something to say. other_place_wanted : in a window of its own, or back. closed : for good
    """

    changed = Signal()
    hinted = Signal(str)
    wanted = Signal()
    other_place_wanted = Signal()
    closed = Signal()

    def __init__(self, survey: PhotoSurvey) -> None:
        super().__init__()
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.is_open = True
        self.survey = survey
        assert survey.folder is not None
        self.folder = survey.folder
        self._stepping = False
        self._steps: list[Finding | str | None] = []
        self._changed_masks: set[str] = set()
        rows = {row.name: row for row in survey.rows}
        self.document = survey.document
        self.masks = PhotoMasks(survey.rows, self.document)
        self.marks = PhotoMarks(self.document, list(rows))
        self.canvas = MarkCanvas()
        self.shown = OpenedPhoto(rows, self.canvas)
        self.tools = PhotoTools(self.canvas, self.masks)
        self.list = PhotoList(survey.rows, self.marks)
        self.mask_box = MaskBox(self.canvas)
        self.points = PointsBox(self.marks)
        self._editing = MarkEditing(self.marks, self.points, self.shown, self.canvas, self.tools)
        self._make_actions()
        self._words = ""
        self._status = ElidedLabel()
        self._status.setObjectName("photo_status")
        self._arrange()
        self.bar = MessageBar(self._middle)
        self._background = QtBackground(self)
        self._connect()
        self._read_cameras()
        self.tools.take_up(LOOK)

    # --- parts -------------------------------------------------------------------------------
    def _make_actions(self) -> None:
        self.actions_table = Actions(self)
        for command in (
            *look_commands(self.list, self.canvas, self.tools),
            *undo_commands(self.masks, self.tools, self.document, self.undo),
            *mask_commands(self.masks, self.mask_box, self.canvas, self.shown),
            *point_commands(self._editing, self.folder, self),
            own_window_command(self, self.other_place_wanted.emit),
        ):
            self.actions_table.add(command)
        self.actions_table.assign_viewport_keys(self.canvas)
        self.mask_box.offer(self.actions_table.all)
        self.points.offer(self.actions_table.all)

    def _arrange(self) -> None:
        self.head = bar = QToolBar()
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
                self._title_place = bar.addWidget(self._title)
            else:
                bar.addAction(actions[name])
                button = bar.widgetForAction(actions[name])
                if isinstance(button, QToolButton) and name in (*TOOLS, "fit", "one_to_one"):
                    button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._middle = QWidget()
        middle = QVBoxLayout(self._middle)
        middle.setContentsMargins(0, 0, 0, 0)
        middle.setSpacing(0)
        middle.addWidget(self.canvas, 1)
        side = QWidget()
        column = QVBoxLayout(side)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.mask_box)
        column.addWidget(self.points, 1)
        split = QSplitter(Qt.Orientation.Horizontal)
        for widget in (self.list, self._middle, PanelScrollArea(side)):
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
        self.place_in_own_window(False)

    def place_in_own_window(self, own: bool) -> None:
        """Follow a change of place: the main window has a tab that says the photo's name, a status
        line, buttons that take a step back, and keys of its own."""
        give_keys(self.actions_table, in_own_window=own)
        for name in ("undo", "redo"):
            self.actions_table.all[name].setVisible(own)
        self._title_place.setVisible(own)
        self._status.setVisible(own)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self.list.setVisible(self.width() >= _LEAST_WITH_LIST)

    def _connect(self) -> None:
        self.list.opened.connect(self.show_photo)
        self.masks.drawn.connect(self._mask_drawn)
        self.masks.busy_changed.connect(self._refresh)
        # Another folder may have been opened meanwhile.
        self.masks.busy_changed.connect(self._survey_changed, Qt.ConnectionType.QueuedConnection)
        self.masks.message.connect(self.say)
        self.marks.message.connect(self.say)
        self.marks.changed.connect(self._show_marks)
        self.survey.exports.message.connect(self.say)
        self.survey.exports.mask_written.connect(self._mask_stored)
        self.points.message.connect(self.say)
        self.points.chosen.connect(self._point_chosen)
        self._editing.message.connect(self.say)
        self.tools.corners_changed.connect(self._refresh)
        self.tools.tool_changed.connect(self._tool_changed)
        self.canvas.pointed.connect(self._point_at)
        self.survey.history_changed.connect(self._refresh)
        self.survey.edited.connect(self._edited)
        # Where a run has found new cameras, and where another folder is looked at.
        self.survey.changed.connect(self._survey_changed)
        self.survey.rows_changed.connect(self._survey_changed)

    # --- the photo ---------------------------------------------------------------------------
    @property
    def photo(self) -> str:
        """The name of the photo that is shown."""
        return self.shown.name

    def show_photo(self, name: str) -> None:
        """Open the photo of this name."""
        if name == self.photo:
            self._editing.look_at_point()
            return
        self.shown.show(name)
        row = self.shown.rows[name]
        self.tools.set_photo(name, row.width, row.height)
        self.masks.open(name)
        if self.list.currentItem() is None or self.list.names[self.list.currentRow()] != name:
            self.list.open(name)
        short = name.rpartition("/")[2]
        self._title.setText(short)
        self.setWindowTitle(tr("{photo} – {folder}", photo=short, folder=self.folder.name))
        self.points.show_photo(name, row.width, row.height)
        self._show_marks()
        self._editing.look_at_point()

    # --- masks -------------------------------------------------------------------------------
    def _mask_drawn(self, name: str) -> None:
        if name == self.photo:
            used = self.masks.used(name)
            if used is not self.canvas.used:
                self.canvas.set_used(used)
            else:
                self.canvas.mask_changed()
            if not self.masks.drawing:
                self._refresh()

    def _mask_stored(self, name: str) -> None:
        self._changed_masks.add(name)
        self.list.refresh()
        self._refresh()

    # --- points ------------------------------------------------------------------------------
    def _show_marks(self) -> None:
        self._editing.show()
        self._refresh()

    def _point_chosen(self, label: str) -> None:
        self.list.set_label(label)
        if label and self.canvas.tool != MARK:
            self.tools.take_up(MARK)
        self._write(self._hint())
        self._show_marks()
        self._editing.look_at_point()

    # --- cameras -----------------------------------------------------------------------------
    def _read_cameras(self) -> None:
        out = self.survey.aligned_folder()
        self._cameras_of = _stamp(out)
        if out is None:
            self.marks.set_cameras(None)
            return

        self._background.run(
            lambda: PlacedPhotos.read(out),
            self.marks.set_cameras,
            lambda error: self.say(error, "warning"),
        )

    def _survey_changed(self) -> None:
        if self.survey.folder != self.folder:
            if self.is_open and not self.masks.busy:
                self.close()
        elif _stamp(self.survey.aligned_folder()) != self._cameras_of:
            self._read_cameras()

    # --- tools and keys ----------------------------------------------------------------------
    def _tool_changed(self) -> None:
        self._refresh()
        self._write(self._hint())

    def undo(self, again: bool = False) -> None:
        """Undo the last step, or the last vertex of a polygon; with `again` redo a step."""
        if self.tools.corners and not again:
            self.tools.take_back_corner()
            return
        self.tools.end_stroke()
        words = self.document.redo_label if again else self.document.undo_label
        if words is None:
            return
        self._stepping = True
        try:
            (self.document.redo if again else self.document.undo)()
        finally:
            self._stepping = False
        step = step_title(words)
        self.say(Finding("edit.redone" if again else "edit.undone", edit=step), "info")

    def _edited(self, edit: Edit) -> None:
        """A step that was taken back in another photo is shown there."""
        photo = photo_of(edit)
        if self._stepping and photo in self.shown.rows and photo != self.photo:
            self.show_photo(photo)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        if event.key() == Qt.Key.Key_Escape and self.tools.corners:
            self.tools.drop()
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.canvas.tool == POLYGON:
            self.tools.close_polygon()
        else:
            super().keyPressEvent(event)

    def say(self, message: Finding | VomError, level: str = "info") -> None:
        """Information goes into the status line, the rest into the bar over the photo."""
        if level == "info":
            self._write(str(message))
        else:
            self.bar.show_notice(Notice(message, level))

    def _point_at(self, event: object) -> None:
        x, y = getattr(event, "x", 0.0), getattr(event, "y", 0.0)
        self._say_status(f"x {x:.1f}  y {y:.1f}   {self._words}")

    def _write(self, words: str) -> None:
        """A hint or a message: it stays until the next, whatever the cursor does."""
        self._words = words
        self._say_status(words)

    def _say_status(self, text: str) -> None:
        self._status.setText(text)
        self.hinted.emit(text)

    @property
    def hint(self) -> str:
        """What its status line says."""
        return self._status.text()

    def _hint(self) -> str:
        return {
            "look": tr("Drag to pan, turn the wheel to zoom."),
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
            tell(name)
            for name in ("undo", "redo")
            for tell in (self.actions_table.why_not, self.actions_table.target)
        ]
        if steps != self._steps:
            # Not with every move of a mark: the main window has many commands.
            self._steps = steps
            self.changed.emit()
        used = self.masks.used(self.photo)
        if self.masks.busy is not None:
            words = self.masks.busy.message
        elif self.survey.exports.problem is not None:
            words = tr("Saved in the project, but not beside the photos.")
        elif used is None:
            words = tr("Reading…") if self.photo else ""
        else:
            share = 100.0 * (1.0 - float(used[::4, ::4].mean()))
            words = (
                tr("Nothing is masked.")
                if used.all()
                else tr("{share:.0f} % of this photo is masked.", share=max(share, 1.0))
            )
        self.mask_box.words.setText(words)

    # --- end ---------------------------------------------------------------------------------
    def may_close(self) -> bool:
        """Whether all drawing is finished; if not, the user is told."""
        self.tools.drop()
        if self.masks.busy is not None:
            self.wanted.emit()
            self.say(Finding("photo.busy", reason=self.masks.busy), "warning")
            return False
        return True

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        if not self.may_close():
            event.ignore()
            return
        event.accept()
        self.end()

    def end(self) -> None:
        """Let everything go, whatever fails of it: a page that is half closed would hold its tab.
        Calling it again does nothing."""
        if not self.is_open:
            return
        self.is_open = False
        with ExitStack() as steps:
            steps.callback(self.closed.emit)
            steps.callback(self._check_again)
            for signal, slot in (
                (self.survey.history_changed, self._refresh),
                (self.survey.edited, self._edited),
                (self.survey.rows_changed, self._survey_changed),
                (self.survey.changed, self._survey_changed),
            ):
                steps.callback(signal.disconnect, slot)
            for close in (self._background.stop, self.shown.close, self.survey.exports.finish):
                steps.callback(close)
            for part in (self.marks, self.masks):
                steps.callback(part.close)

    def _check_again(self) -> None:
        if self._changed_masks and self.survey.folder == self.folder:
            self.survey.check_again()


def _stamp(out: Path | None) -> object:
    """Changes when cameras are found anew."""
    try:
        return None if out is None else (out, (out / FILE_NAME).stat().st_mtime_ns)
    except OSError:
        return None
