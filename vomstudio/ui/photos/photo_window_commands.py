"""What can be done in the window of a photo."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from vomstudio.geometry.pixel_areas import whole_area
from vomstudio.ui.common.actions import Command
from vomstudio.ui.photos.mark_canvas import BRUSH, LOOK, MARK, POLYGON

if TYPE_CHECKING:
    from vomstudio.ui.photos.photo_window import PhotoWindow

TOOLS = ("look", "mark", "polygon", "brush")


def commands(w: PhotoWindow) -> list[Command]:
    """Of the photo's own window."""

    def is_tool(name: str) -> Callable[[], bool]:
        return lambda: w.canvas.tool == name

    def no_mask() -> str | None:
        return w.masks.busy or (None if w.masks.used(w.photo) is not None else "it is being read")

    def no_point() -> str | None:
        return None if w.points.label else "choose a point first"

    def no_mark() -> str | None:
        if (said := no_point()) is not None:
            return said
        there = w.photo in w.marks.marking.of(w.points.label)
        return None if there else "the point is not marked in this photo"

    def clear() -> None:
        used = w.masks.used(w.photo)
        if used is not None:
            w.masks.draw_once(w.photo, whole_area(used.shape[1], used.shape[0]), hides=False)

    return [
        Command("previous", "Previous photo", lambda: w.step(-1), "chevron-left",
                ("PgUp", "Alt+Left")),
        Command("next", "Next photo", lambda: w.step(1), "chevron-right", ("PgDown", "Alt+Right")),
        Command("look", "Look", lambda: w.set_tool(LOOK), "hand-back-right-outline", "V",
                "Move the photo and look closer", in_viewport=True, checked=is_tool(LOOK)),
        Command("mark", "Mark", lambda: w.set_tool(MARK), "target", "M",
                "Mark points: control, check and tie points",
                in_viewport=True, checked=is_tool(MARK)),
        Command("polygon", "Polygon", lambda: w.set_tool(POLYGON), "vector-polygon", "P",
                "Draw the outline of what is left out or kept",
                in_viewport=True, checked=is_tool(POLYGON)),
        Command("brush", "Brush", lambda: w.set_tool(BRUSH), "brush", "B",
                "Paint what is left out or kept",
                in_viewport=True, checked=is_tool(BRUSH)),
        Command("undo", "Undo", lambda: w.undo(), "undo", "Ctrl+Z", "",
                lambda: w.masks.busy or (
                    None if w.tools.corners or w.document.undo_words else "nothing was done"),
                what=lambda: w.document.undo_words),
        Command("redo", "Redo", lambda: w.undo(again=True), "redo", ("Ctrl+Shift+Z", "Ctrl+Y"), "",
                lambda: w.masks.busy or (
                    None if w.document.redo_words else "nothing was taken back"),
                what=lambda: w.document.redo_words),
        Command("fit", "Whole photo", lambda: w.canvas.fit(), "fit-to-page-outline", "0",
                in_viewport=True),
        Command("one_to_one", "1 : 1", lambda: w.canvas.one_to_one(), "magnify-plus-outline", "1",
                "One pixel of the photo on one of the screen", in_viewport=True),
        Command("turn_over", "Leave out or keep", lambda: w.mask_box.turn_over(), None, "X",
                in_viewport=True),
        Command("brush_smaller", "Smaller brush", lambda: w.mask_box.set_radius(
                w.canvas.radius / 1.15), None, "[", in_viewport=True),
        Command("brush_larger", "Larger brush", lambda: w.mask_box.set_radius(
                w.canvas.radius * 1.15), None, "]", in_viewport=True),
        Command("repeat_mask", "The same on all photos", lambda: w.masks.repeat(),
                "image-multiple-outline", (),
                "Draw the last shape into every photo of this size: for a thing that stands fixed "
                "in view, such as a leg of the drone", lambda: w.masks.why_not_repeat()),
        Command("invert_mask", "Invert", lambda: w.masks.invert(w.photo), "invert-colors", (),
                "Leave out what is kept, and keep what is left out", no_mask),
        Command("clear_mask", "Keep all", clear, "image-outline", (),
                "Leave out nothing in this photo", no_mask),
        Command("new_point", "New point", lambda: w.new_point(), "plus", "N",
                "A tie point; with coordinates it becomes a control point", in_viewport=True),
        Command("remove_point", "Remove point", lambda: w.remove_point(), "delete-outline", (),
                "The point with all its marks", no_point),
        Command("import_points", "Import points…", lambda: w.import_table(marks=False),
                "map-marker-plus-outline", (), "Control points: label, x, y, z and, if known, "
                "sigma and use (control or check)"),
        Command("import_marks", "Import marks…", lambda: w.import_table(marks=True),
                "map-marker-multiple-outline", (), "Marks: label, photo, x, y"),
        Command("remove_mark", "Remove mark", lambda: w.remove_mark(), "close", "Del",
                "The point's mark in this photo", no_mark, in_viewport=True),
    ]  # fmt: skip
