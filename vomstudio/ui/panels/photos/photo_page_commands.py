"""Commands of an open photo."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.pixel_areas import whole_area
from vomstudio.studio.history import step_title
from vomstudio.ui.base.actions import Actions, Command
from vomstudio.ui.panels.photos.mark_canvas import BRUSH, LOOK, MARK, POLYGON, MarkCanvas
from vomstudio.ui.panels.photos.mark_editing import MarkEditing
from vomstudio.ui.panels.photos.mask_box import MaskBox
from vomstudio.ui.panels.photos.opened_photo import OpenedPhoto
from vomstudio.ui.panels.photos.photo_document import PhotoDocument
from vomstudio.ui.panels.photos.photo_list import PhotoList
from vomstudio.ui.panels.photos.photo_masks import PhotoMasks
from vomstudio.ui.panels.photos.photo_tools import PhotoTools

TOOLS = ("look", "mark", "polygon", "brush")
_BRUSH_STEP = 1.15
_WINDOW_KEYS = {
    "previous": ("PgUp", "Alt+Left"),
    "next": ("PgDown", "Alt+Right"),
    "undo": ("Ctrl+Z",),
    "redo": ("Ctrl+Shift+Z", "Ctrl+Y"),
}
# The main window has the other shortcuts and forwards them to the photo (`photo_command`).
_TAB_KEYS = {"previous": ("PgUp",), "next": ("PgDown",), "undo": (), "redo": ()}
_PHOTO_COMMANDS = {
    "undo": "undo",
    "redo": "redo",
    "previous_photo": "previous",
    "next_photo": "next",
    "fit_photo": "fit",
}


def set_shortcuts(table: Actions, *, is_own_window: bool) -> None:
    """Set the shortcuts that apply everywhere in the page.

    Parameters
    ----------
    table : Actions
    is_own_window : bool
        Whether the page is a separate window, in which no other widget uses these shortcuts.
    """
    keys: Mapping[str, tuple[str, ...]] = _WINDOW_KEYS if is_own_window else _TAB_KEYS
    for name, shortcuts in keys.items():
        action = table.all[name]
        action.setShortcutContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        action.setShortcuts([QKeySequence(key) for key in shortcuts])


def photo_command(command: Command, table: Callable[[], Actions | None]) -> Command:
    """Return a command of the main window that acts on the open photo while it is visible.

    Parameters
    ----------
    command : Command
    table : callable
        Returns the commands of the visible photo, or None if no photo is visible.
    """
    name = _PHOTO_COMMANDS.get(command.name)
    if name is None:
        return command

    def run() -> None:
        photo = table()
        if photo is None:
            command.run()
        else:
            photo.run(name)

    def disabled_reason() -> Finding | None:
        photo = table()
        return command.disabled_reason() if photo is None else photo.disabled_reason(name)

    def text() -> str:
        photo = table()
        if photo is None:
            return command.text if command.current_text is None else command.current_text()
        step = photo.target(name)
        if step is None:
            return command.text
        step_text = step_title(step).replace("&", "&&")
        return (
            tr("&Undo {step}", step=step_text)
            if name == "undo"
            else tr("&Redo {step}", step=step_text)
        )

    base = command if command.current_text is None else replace(command, current_text=text)
    return replace(base, run=run, disabled_reason=disabled_reason)


def own_window_command(page: QWidget, toggle_window: Callable[[], object]) -> Command:
    """Return the command that moves the page to a separate window, or back."""
    return Command(
        "own_window",
        tr("Separate window"),
        toggle_window,
        "open-in-new",
        (),
        tr("Show the photo in its own window, or put it back."),
        is_checked=page.isWindow,
    )


def view_commands(photos: PhotoList, canvas: MarkCanvas, tools: PhotoTools) -> list[Command]:
    """Return the commands that change the photo, the view or the tool."""

    def activate(name: str) -> Callable[[], None]:
        return lambda: tools.set_tool(name)

    def is_active_tool(name: str) -> Callable[[], bool]:
        return lambda: canvas.tool == name

    return [
        Command("previous", tr("Previous photo"), lambda: photos.step(-1), "chevron-left"),
        Command("next", tr("Next photo"), lambda: photos.step(1), "chevron-right"),
        Command(
            "look",
            tr("Navigate"),
            activate(LOOK),
            "hand-back-right-outline",
            "V",
            tr("Pan and zoom."),
            is_viewport_key=True,
            is_checked=is_active_tool(LOOK),
        ),
        Command(
            "mark",
            tr("Mark"),
            activate(MARK),
            "target",
            "M",
            tr("Mark control points, check points and tie points."),
            is_viewport_key=True,
            is_checked=is_active_tool(MARK),
        ),
        Command(
            "polygon",
            tr("Polygon"),
            activate(POLYGON),
            "vector-polygon",
            "P",
            tr("Mask or unmask a polygon."),
            is_viewport_key=True,
            is_checked=is_active_tool(POLYGON),
        ),
        Command(
            "brush",
            tr("Brush"),
            activate(BRUSH),
            "brush",
            "B",
            tr("Mask or unmask with a brush."),
            is_viewport_key=True,
            is_checked=is_active_tool(BRUSH),
        ),
        Command(
            "fit", tr("Whole photo"), canvas.fit, "fit-to-page-outline", "0", is_viewport_key=True
        ),
        Command(
            "one_to_one",
            "1 : 1",
            canvas.zoom_to_full_resolution,
            "magnify-plus-outline",
            "1",
            tr("Show one photo pixel as one screen pixel."),
            is_viewport_key=True,
        ),
    ]


def undo_commands(
    masks: PhotoMasks, tools: PhotoTools, document: PhotoDocument, undo: Callable[[bool], None]
) -> list[Command]:
    """Return the commands for undo and redo; `undo` is called with True to redo."""
    return [
        Command(
            "undo",
            tr("Undo"),
            lambda: undo(False),
            "undo",
            (),
            "",
            lambda: (
                masks.busy_reason
                or (
                    None
                    if tools.corner_count or document.undo_label
                    else Finding("edit.nothing-to-undo")
                )
            ),
            target=lambda: tr("Last vertex") if tools.corner_count else document.undo_label,
        ),
        Command(
            "redo",
            tr("Redo"),
            lambda: undo(True),
            "redo",
            (),
            "",
            lambda: (
                masks.busy_reason
                or (None if document.redo_label else Finding("edit.nothing-to-redo"))
            ),
            target=lambda: document.redo_label,
        ),
    ]


def mask_commands(
    masks: PhotoMasks, box: MaskBox, canvas: MarkCanvas, photo: OpenedPhoto
) -> list[Command]:
    """Return the commands that change the brush or the whole mask."""

    def mask_problem() -> Finding | None:
        if masks.busy_reason or masks.used(photo.name) is not None:
            return masks.busy_reason
        return Finding("mask.pending")

    def clear() -> None:
        used_pixels = masks.used(photo.name)
        if used_pixels is not None:
            masks.draw_single_shape(
                photo.name, whole_area(used_pixels.shape[1], used_pixels.shape[0]), is_masking=False
            )

    return [
        Command(
            "turn_over", tr("Mask or unmask"), box.toggle_masking, None, "X", is_viewport_key=True
        ),
        Command(
            "brush_smaller",
            tr("Smaller brush"),
            lambda: box.set_radius(canvas.radius / _BRUSH_STEP),
            None,
            "[",
            is_viewport_key=True,
        ),
        Command(
            "brush_larger",
            tr("Larger brush"),
            lambda: box.set_radius(canvas.radius * _BRUSH_STEP),
            None,
            "]",
            is_viewport_key=True,
        ),
        Command(
            "repeat_mask",
            tr("Apply to all"),
            masks.repeat,
            "image-multiple-outline",
            (),
            tr("Copy the last shape to all photos of this size."),
            masks.repeat_problem,
        ),
        Command(
            "invert_mask",
            tr("Invert"),
            lambda: masks.invert(photo.name),
            "invert-colors",
            (),
            tr("Invert the mask of the photo."),
            mask_problem,
        ),
        Command(
            "clear_mask",
            tr("Clear"),
            clear,
            "image-outline",
            (),
            tr("Unmask the whole photo."),
            mask_problem,
        ),
    ]


def point_commands(mark_editor: MarkEditing, folder: Path, parent: QWidget) -> list[Command]:
    """Return the commands for points and marks.

    Parameters
    ----------
    mark_editor : MarkEditing
    folder : Path
        Initial folder of the file dialogs.
    parent : QWidget
        Parent of the dialogs.
    """

    def import_table(is_mark_table: bool) -> Callable[[], None]:
        return lambda: mark_editor.import_table(folder, parent, is_mark_table=is_mark_table)

    return [
        Command(
            "new_point",
            tr("New point"),
            mark_editor.add_point,
            "plus",
            "N",
            tr("Add a tie point; with coordinates it becomes a control point."),
            is_viewport_key=True,
        ),
        Command(
            "remove_point",
            tr("Remove point"),
            mark_editor.remove_point,
            "delete-outline",
            (),
            tr("Remove the point with all its marks."),
            mark_editor.point_selection_problem,
        ),
        Command(
            "import_points",
            tr("Import points…"),
            import_table(False),
            "map-marker-plus-outline",
            (),
            tr("Import a table: label, x, y, z[, sigma][, use (control or check)]."),
        ),
        Command(
            "import_marks",
            tr("Import marks…"),
            import_table(True),
            "map-marker-multiple-outline",
            (),
            tr("Import a table of image marks: label, photo, x, y."),
        ),
        Command(
            "remove_mark",
            tr("Remove mark"),
            mark_editor.remove_mark,
            "close",
            "Del",
            tr("Remove the mark of the point in this photo."),
            mark_editor.mark_problem,
            is_viewport_key=True,
        ),
    ]
