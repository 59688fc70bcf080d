"""Tools of an open photo, which turn gestures into marks, polygon vertices or strokes."""

from __future__ import annotations

import math

from PySide6.QtCore import QObject, Signal

from vomstudio.geometry.pixel_areas import polygon_area, stroke_area
from vomstudio.photogrammetry.georeferencing.mark_prediction import Pixel
from vomstudio.studio.tools.interaction_types import Button, Pointer
from vomstudio.ui.panels.photos.mark_canvas import BRUSH, MARK, POLYGON, MarkCanvas
from vomstudio.ui.panels.photos.photo_masks import PhotoMasks
from vomstudio.ui.widgets.photo_canvas import PhotoPointer


class PhotoTools(QObject):
    """Tools of an open photo.

    Attributes
    ----------
    mark_requested : Signal
        Emitted with the position (x, y) at which the selected point is to be marked.
    mark_moved : Signal
        Emitted with the label, x and y of a mark, and whether the drag continues.
    mark_picked : Signal
        Emitted with the label of a mark that was clicked.
    """

    mark_requested = Signal(float, float)
    mark_moved = Signal(str, float, float, bool)
    mark_picked = Signal(str)
    corners_changed = Signal()
    tool_changed = Signal()

    def __init__(self, canvas: MarkCanvas, masks: PhotoMasks) -> None:
        super().__init__()
        self._canvas, self._masks = canvas, masks
        self.photo = ""
        self.size = (1, 1)
        self._corners: list[Pixel] = []
        self._last_point: Pixel | None = None
        self._dragged_label = ""
        canvas.pointed.connect(self._handle_pointer)

    @property
    def is_masking(self) -> bool:
        return self._canvas.is_masking

    @property
    def corner_count(self) -> int:
        return len(self._corners)

    def set_photo(self, name: str, width: int, height: int) -> None:
        self.cancel()
        self.photo, self.size = name, (width, height)

    def set_tool(self, tool: str) -> None:
        """Switch to LOOK, MARK, POLYGON or BRUSH, discarding an unfinished polygon."""
        self.cancel()
        self._canvas.set_tool(tool)
        self.tool_changed.emit()

    def cancel(self) -> None:
        """Discard the unfinished polygon and finish the stroke."""
        self.end_stroke()
        self._dragged_label = ""
        self._set_corners([])

    def end_stroke(self) -> None:
        """Finish the stroke, even if the button is still pressed."""
        if self._last_point is not None:
            self._last_point = None
            self._masks.end()

    def _handle_pointer(self, event: PhotoPointer) -> None:
        tool = self._canvas.tool
        if tool == MARK:
            self._handle_mark(event)
        elif tool == POLYGON:
            self._handle_polygon(event)
        elif tool == BRUSH:
            self._brush(event)

    # --- marks -------------------------------------------------------------------------------
    def _handle_mark(self, event: PhotoPointer) -> None:
        if event.button is not Button.LEFT:
            return
        marks, handle = self._canvas.marks, event.handle
        if event.kind is Pointer.CLICK:
            if handle is not None and not marks[handle].is_selected:
                self.mark_picked.emit(marks[handle].label)
            elif handle is None and self._is_inside(event):
                self.mark_requested.emit(event.x, event.y)
        elif event.kind is Pointer.DRAG_START and handle is not None:
            self._dragged_label = marks[handle].label
            self.mark_picked.emit(self._dragged_label)
        elif event.kind in (Pointer.DRAG_MOVE, Pointer.DRAG_END) and self._dragged_label:
            x, y = self._canvas.dragged_pixel((event.x, event.y))
            x, y = min(max(x, 0.0), self.size[0]), min(max(y, 0.0), self.size[1])
            is_ongoing = event.kind is Pointer.DRAG_MOVE
            if not event.is_continued:
                self.mark_moved.emit(self._dragged_label, x, y, is_ongoing)
            if not is_ongoing:
                self._dragged_label = ""

    def _is_inside(self, event: PhotoPointer) -> bool:
        return 0 <= event.x <= self.size[0] and 0 <= event.y <= self.size[1]

    # --- polygon -----------------------------------------------------------------------------
    def _handle_polygon(self, event: PhotoPointer) -> None:
        position = (event.x, event.y)
        if event.button is not Button.LEFT:
            return
        if event.kind is Pointer.CLICK:
            if event.handle == 0 and len(self._corners) > 2:
                self.close_polygon()
            elif event.handle is None:
                self._set_corners([*self._corners, position])
        elif event.kind is Pointer.DOUBLE_CLICK:
            # The first click of the double click has already added the last vertex.
            self.close_polygon()
        elif (
            event.kind is Pointer.DRAG_MOVE and event.handle is not None and not event.is_continued
        ):
            corners = list(self._corners)
            corners[event.handle] = position
            self._set_corners(corners)

    def close_polygon(self) -> None:
        """Mask or unmask the area of the polygon if it has at least three vertices."""
        if len(self._corners) > 2 and self._masks.used(self.photo) is not None:
            area = polygon_area(self._corners, *self.size)
            self._masks.draw_single_shape(self.photo, area, self.is_masking)
            self._set_corners([])

    def remove_last_corner(self) -> None:
        """Remove the last vertex of the polygon."""
        self._set_corners(self._corners[:-1])

    def _set_corners(self, corners: list[Pixel]) -> None:
        if corners or self._corners:
            self._corners = corners
            self._canvas.set_corners(corners)
            self.corners_changed.emit()

    # --- brush -------------------------------------------------------------------------------
    def _brush(self, event: PhotoPointer) -> None:
        if event.button is not Button.LEFT or self._masks.used(self.photo) is None:
            return
        position = (event.x, event.y)
        if event.kind is Pointer.CLICK:
            self._masks.begin(self.photo, self.is_masking)
            self._stamp(position, position)
            self._masks.end()
        elif event.kind is Pointer.DRAG_START:
            self._masks.begin(self.photo, self.is_masking)
            self._stamp(position, position)
            self._last_point = position
        elif event.kind is Pointer.DRAG_MOVE and self._last_point is not None:
            if (
                not event.is_continued
                or math.dist(position, self._last_point) > 0.3 * self._canvas.radius
            ):
                self._stamp(self._last_point, position)
                self._last_point = position
        elif event.kind is Pointer.DRAG_END and self._last_point is not None:
            self._stamp(self._last_point, position)
            self._last_point = None
            self._masks.end()

    def _stamp(self, a: Pixel, b: Pixel) -> None:
        self._masks.draw(stroke_area([a, b], self._canvas.radius, *self.size))
