"""What can be done in the window of a photo."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.geometry.pixel_areas import whole_area
from vomstudio.ui.common.actions import Command
from vomstudio.ui.photos.mark_canvas import BRUSH, LOOK, MARK, POLYGON, MarkCanvas
from vomstudio.ui.photos.mark_editing import MarkEditing
from vomstudio.ui.photos.mask_box import MaskBox
from vomstudio.ui.photos.opened_photo import OpenedPhoto
from vomstudio.ui.photos.photo_document import PhotoDocument
from vomstudio.ui.photos.photo_list import PhotoList
from vomstudio.ui.photos.photo_masks import PhotoMasks
from vomstudio.ui.photos.photo_tools import PhotoTools

TOOLS = ("look", "mark", "polygon", "brush")
_BRUSH_STEP = 1.15


def look_commands(photos: PhotoList, canvas: MarkCanvas, tools: PhotoTools) -> list[Command]:
    """Going from photo to photo, looking closer, and taking up a tool."""

    def take_up(name: str) -> Callable[[], None]:
        return lambda: tools.take_up(name)

    def is_tool(name: str) -> Callable[[], bool]:
        return lambda: canvas.tool == name

    return [
        Command("previous", "Previous photo", lambda: photos.step(-1), "chevron-left",
                ("PgUp", "Alt+Left")),
        Command("next", "Next photo", lambda: photos.step(1), "chevron-right",
                ("PgDown", "Alt+Right")),
        Command("look", "Look", take_up(LOOK), "hand-back-right-outline", "V",
                "Move the photo and look closer", in_viewport=True, checked=is_tool(LOOK)),
        Command("mark", "Mark", take_up(MARK), "target", "M",
                "Mark points: control, check and tie points",
                in_viewport=True, checked=is_tool(MARK)),
        Command("polygon", "Polygon", take_up(POLYGON), "vector-polygon", "P",
                "Draw the outline of what is left out or kept",
                in_viewport=True, checked=is_tool(POLYGON)),
        Command("brush", "Brush", take_up(BRUSH), "brush", "B",
                "Paint what is left out or kept",
                in_viewport=True, checked=is_tool(BRUSH)),
        Command("fit", "Whole photo", canvas.fit, "fit-to-page-outline", "0",
                in_viewport=True),
        Command("one_to_one", "1 : 1", canvas.one_to_one, "magnify-plus-outline", "1",
                "One pixel of the photo on one of the screen", in_viewport=True),
    ]  # fmt: skip


def undo_commands(
    masks: PhotoMasks, tools: PhotoTools, document: PhotoDocument, undo: Callable[[bool], None]
) -> list[Command]:
    """undo : takes the last step back, or with True does it again"""
    return [
        Command("undo", "Undo", lambda: undo(False), "undo", "Ctrl+Z", "",
                lambda: masks.busy or (
                    None if tools.corners or document.undo_words else "nothing was done"),
                what=lambda: document.undo_words),
        Command("redo", "Redo", lambda: undo(True), "redo", ("Ctrl+Shift+Z", "Ctrl+Y"), "",
                lambda: masks.busy or (None if document.redo_words else "nothing was taken back"),
                what=lambda: document.redo_words),
    ]  # fmt: skip


def mask_commands(
    masks: PhotoMasks, box: MaskBox, canvas: MarkCanvas, photo: OpenedPhoto
) -> list[Command]:
    def no_mask() -> str | None:
        return masks.busy or (None if masks.used(photo.name) is not None else "it is being read")

    def clear() -> None:
        used = masks.used(photo.name)
        if used is not None:
            masks.draw_once(photo.name, whole_area(used.shape[1], used.shape[0]), hides=False)

    return [
        Command("turn_over", "Leave out or keep", box.turn_over, None, "X", in_viewport=True),
        Command("brush_smaller", "Smaller brush",
                lambda: box.set_radius(canvas.radius / _BRUSH_STEP), None, "[", in_viewport=True),
        Command("brush_larger", "Larger brush",
                lambda: box.set_radius(canvas.radius * _BRUSH_STEP), None, "]", in_viewport=True),
        Command("repeat_mask", "The same on all photos", masks.repeat,
                "image-multiple-outline", (),
                "Draw the last shape into every photo of this size: for a thing that stands fixed "
                "in view, such as a leg of the drone", masks.why_not_repeat),
        Command("invert_mask", "Invert", lambda: masks.invert(photo.name), "invert-colors", (),
                "Leave out what is kept, and keep what is left out", no_mask),
        Command("clear_mask", "Keep all", clear, "image-outline", (),
                "Leave out nothing in this photo", no_mask),
    ]  # fmt: skip


def point_commands(editing: MarkEditing, folder: Path, parent: QWidget) -> list[Command]:
    """folder : where tables are looked for first. parent : of the dialogs"""

    def import_table(marks: bool) -> Callable[[], None]:
        return lambda: editing.import_table(folder, parent, marks=marks)

    return [
        Command("new_point", "New point", editing.new_point, "plus", "N",
                "A tie point; with coordinates it becomes a control point", in_viewport=True),
        Command("remove_point", "Remove point", editing.remove_point, "delete-outline", (),
                "The point with all its marks", editing.why_no_point),
        Command("import_points", "Import points…", import_table(False),
                "map-marker-plus-outline", (), "Control points: label, x, y, z and, if known, "
                "sigma and use (control or check)"),
        Command("import_marks", "Import marks…", import_table(True),
                "map-marker-multiple-outline", (), "Marks: label, photo, x, y"),
        Command("remove_mark", "Remove mark", editing.remove_mark, "close", "Del",
                "The point's mark in this photo", editing.why_no_mark, in_viewport=True),
    ]  # fmt: skip
