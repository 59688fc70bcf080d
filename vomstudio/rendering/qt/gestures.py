"""Mouse gestures over the viewport: camera moves and events for the tools.

A click is a press and a release within `MAX_CLICK_PX`. A longer movement is a drag, whose action
is determined at its start.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Protocol

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt, QTimer, Signal
from PySide6.QtGui import QMouseEvent, QWheelEvent

from vomstudio.core.arrays import FloatArray
from vomstudio.rendering.qt.viewport_protocol import Pane
from vomstudio.rendering.view.camera import Camera
from vomstudio.studio.tools.interaction_types import (
    Button,
    Hit,
    Pointer,
    PointerEvent,
    Preview,
    is_click,
)

HANDLE_PICK_DISTANCE_PIXELS = 9.0
HOVER_INTERVAL_S = 0.016
STILL_DELAY_MS = 150
MAX_BRUSH_STEPS = 40
DEGREES_PER_PIXEL = 0.35
ZOOM_PER_NOTCH = 0.85

BUTTONS = {
    Qt.MouseButton.LeftButton: Button.LEFT,
    Qt.MouseButton.MiddleButton: Button.MIDDLE,
    Qt.MouseButton.RightButton: Button.RIGHT,
}


class GestureView(Pane, Protocol):
    """Protocol of the widget that receives gestures."""

    preview: Preview | None

    def pick(self, x: float, y: float) -> Hit | None: ...

    def world_position(self, hit: Hit) -> FloatArray: ...

    def hover(self, x: float, y: float, *, is_free: bool) -> None:
        """Handle the cursor at a pixel; `is_free` means that it is not over a preview vertex."""


class CameraMover(Protocol):
    """Protocol for camera moves."""

    camera: Camera

    def redraw(self) -> None:
        """Redraw after the camera has been moved."""

    def set_pivot(self, point_world: FloatArray) -> None: ...


class ClipFaces(Protocol):
    """Protocol for the handles on the faces of a box."""

    def face_at(self, x: float, y: float) -> int | None: ...

    def drag_face(self, face: int, x: float, y: float) -> None: ...

    def release_face(self) -> None: ...


class Gestures(QObject):
    """Mouse gestures of the viewport.

    Attributes
    ----------
    orbit_button : MouseButton
        Button that orbits. If it is the right button, drags with the left button are passed to
        the tool.
    tool_uses_modifiers : bool
        Whether the tool uses Shift with the left button, which otherwise pans, and Ctrl or Shift
        with the wheel.
    cursor : QPointF or None
        Position of the cursor, or None if it is outside the view.
    hovered_handle : int or None
        Vertex of the preview under the cursor.
    dragged_face : int or None
        Face of the clipping box that is being dragged.
    """

    pointer = Signal(object)
    """Emits the PointerEvents for the tool."""

    def __init__(
        self, view: GestureView, moves: CameraMover, faces: ClipFaces, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._view, self._moves, self._faces = view, moves, faces
        self._camera = moves.camera
        self.orbit_button = Qt.MouseButton.LeftButton
        self.tool_uses_modifiers = False
        self._turntable = True
        self.cursor: QPointF | None = None
        self.hovered_handle: int | None = None
        self.dragged_face: int | None = None
        self._press_position: QPointF | None = None
        self._button = Qt.MouseButton.NoButton
        self._dragged_handle: int | None = None
        self._last_position = QPointF()
        self._action: str | None = None
        self._action_depth: float | None = None
        self._is_after_double_click = False
        self._last_hover_time = 0.0
        self._hover_event: PointerEvent | None = None
        self._hover_timer = QTimer(self, singleShot=True)
        self._hover_timer.timeout.connect(self._emit_hover)
        # A tool whose measurements are delayed during a drag updates them when the cursor stops.
        self._still_timer = QTimer(self)
        self._still_timer.setInterval(STILL_DELAY_MS)
        self._still_timer.timeout.connect(self._emit_still)

    def set_turntable(self, is_enabled: bool) -> None:
        """Set whether orbiting keeps the z axis upright or is free, as with a trackball."""
        self._turntable = is_enabled

    def adopt_settings(self, other: Gestures) -> None:
        """Use the buttons, keys and rotation of another view."""
        self.orbit_button, self.tool_uses_modifiers = other.orbit_button, other.tool_uses_modifiers
        self._turntable = other._turntable

    def stop(self) -> None:
        self._hover_timer.stop()
        self._still_timer.stop()

    def handle_at(self, x: float, y: float) -> int | None:
        """Return the preview vertex at a pixel, or None."""
        preview = self._view.preview
        if preview is None or not len(preview.line):
            return None
        pixels, _ = self._camera.project(np.asarray(preview.line, float), self._view.extent())
        distance = np.hypot(pixels[:, 0] - x, pixels[:, 1] - y)
        distance = np.where(np.isfinite(distance), distance, np.inf)
        best_row = int(np.argmin(distance))
        return best_row if distance[best_row] <= HANDLE_PICK_DISTANCE_PIXELS else None

    def _event(
        self,
        kind: Pointer,
        position: QPointF,
        button: Qt.MouseButton,
        event: QMouseEvent,
        hit: bool = True,
    ) -> PointerEvent:
        modifiers = event.modifiers()
        return PointerEvent(
            kind,
            position.x(),
            position.y(),
            BUTTONS.get(button, Button.NONE),
            bool(modifiers & Qt.KeyboardModifier.ShiftModifier),
            bool(modifiers & Qt.KeyboardModifier.ControlModifier),
            self._view.pick(position.x(), position.y()) if hit else None,
            self.handle_at(position.x(), position.y()),
            alt=bool(modifiers & Qt.KeyboardModifier.AltModifier),
        )

    # -- drags and clicks

    def press(self, event: QMouseEvent) -> None:
        if self._press_position is not None:
            return
        position = event.position()
        self._press_position = self._last_position = position
        self._button = event.button()
        self._action = None
        is_left_button = event.button() == Qt.MouseButton.LeftButton
        has_shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        self._dragged_handle = (
            self.handle_at(position.x(), position.y()) if is_left_button and not has_shift else None
        )
        is_free = is_left_button and not has_shift and self._dragged_handle is None
        self.dragged_face = self._faces.face_at(position.x(), position.y()) if is_free else None
        event.accept()

    def _begin_action(self, event: QMouseEvent) -> None:
        """Determine the action of a drag once the cursor has moved far enough."""
        assert self._press_position is not None
        if self.dragged_face is not None:
            self._action = "face"
            return
        view = self._view
        has_shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        button = self._button
        hit = view.pick(self._press_position.x(), self._press_position.y())
        position = None if hit is None else view.world_position(hit)
        if self._dragged_handle is not None:
            self._action = "handle"
            start = self._event(Pointer.DRAG_START, self._press_position, button, event)
            self.pointer.emit(replace(start, handle=self._dragged_handle))
        elif button == Qt.MouseButton.MiddleButton or (
            button == Qt.MouseButton.LeftButton and has_shift and not self.tool_uses_modifiers
        ):
            self._action = "pan"
            self._action_depth = (
                None
                if position is None
                else float((position - self._camera.position) @ self._camera.direction)
            )
        elif button == self.orbit_button:
            self._action = "orbit"
            if position is not None:
                self._camera.set_pivot(position)
        elif button == Qt.MouseButton.LeftButton:
            self._action = "tool"
            self.pointer.emit(self._event(Pointer.DRAG_START, self._press_position, button, event))
        elif button == Qt.MouseButton.RightButton:
            self._action = "zoom"
            if position is not None:
                self._camera.set_pivot(position)
        else:
            self._action = "none"

    def move(self, event: QMouseEvent) -> None:
        position = event.position()
        self.cursor = position
        if self._press_position is None:
            self._schedule_hover(event)
            return
        if self._action is None:
            if is_click(
                position.x() - self._press_position.x(), position.y() - self._press_position.y()
            ):
                return
            self._begin_action(event)
            self._last_position = self._press_position
        dx, dy = position.x() - self._last_position.x(), position.y() - self._last_position.y()
        self._last_position = position
        if self._action == "face":
            assert self.dragged_face is not None
            self._faces.drag_face(self.dragged_face, position.x(), position.y())
        elif self._action == "handle":
            move = self._event(Pointer.DRAG_MOVE, position, self._button, event)
            self.pointer.emit(replace(move, handle=self._dragged_handle))
        elif self._action == "tool":
            self._drag_tool(event, position, position - QPointF(dx, dy))
        elif self._action != "none":
            self._move_camera(dx, dy)

    def _move_camera(self, dx: float, dy: float) -> None:
        camera = self._camera
        if self._action == "orbit":
            rotate = camera.orbit if self._turntable else camera.tumble
            rotate(dx * DEGREES_PER_PIXEL, dy * DEGREES_PER_PIXEL)
        elif self._action == "pan":
            camera.pan(dx, dy, self._view.extent()[1], self._action_depth)
        else:
            camera.zoom(ZOOM_PER_NOTCH ** (-dy / 30.0), camera.pivot)
        self._moves.redraw()

    def _drag_tool(
        self, event: QMouseEvent, cursor_position: QPointF, last_position: QPointF
    ) -> None:
        """Pass a drag to the tool, in steps that leave no gaps in a brush stroke."""
        movement, steps = cursor_position - last_position, 1
        preview, camera = self._view.preview, self._camera
        brush = preview.brush if preview is not None else None
        if brush is not None:
            depth = float((brush.centre - camera.position) @ camera.direction)
            pixels = brush.radius / camera.metres_per_pixel(self._view.extent()[1], depth)
            length = max(abs(movement.x()), abs(movement.y()))
            steps = min(max(1, math.ceil(2.0 * length / max(pixels, 2.0))), MAX_BRUSH_STEPS)
        self._still_timer.start()
        for step in range(1, steps + 1):
            position = last_position + movement * (step / steps)
            move = self._event(Pointer.DRAG_MOVE, position, self._button, event)
            self.pointer.emit(replace(move, handle=None, has_more_steps=step < steps))

    def _emit_still(self) -> None:
        if self._action != "tool" or self._press_position is None:
            self._still_timer.stop()
            return
        x, y = self._last_position.x(), self._last_position.y()
        button = BUTTONS.get(self._button, Button.NONE)
        self.pointer.emit(PointerEvent(Pointer.DRAG_MOVE, x, y, button, hit=self._view.pick(x, y)))

    def release(self, event: QMouseEvent) -> None:
        if self._press_position is None or event.button() != self._button:
            return
        action, self._action = self._action, None
        press, self._press_position = self._press_position, None
        face, self.dragged_face = self.dragged_face, None
        if face is not None:
            self._faces.release_face()
            return
        if action == "handle":
            end = self._event(Pointer.DRAG_END, event.position(), event.button(), event)
            self.pointer.emit(replace(end, handle=self._dragged_handle))
        elif action == "tool":
            end = self._event(Pointer.DRAG_END, event.position(), event.button(), event)
            self.pointer.emit(replace(end, handle=None))
        elif action is None and not self._is_after_double_click:
            click = self._event(Pointer.CLICK, press, event.button(), event)
            self.pointer.emit(click)
        self._is_after_double_click = False
        self._dragged_handle = None

    def double_click(self, event: QMouseEvent) -> None:
        if self.orbit_button != Qt.MouseButton.LeftButton:
            # Quick brush strokes are not double clicks.
            self.press(event)
            return
        self._press_position = self._last_position = event.position()
        self._button = event.button()
        self._action = None
        self._dragged_handle = None
        self._is_after_double_click = True
        pointer_event = self._event(Pointer.DOUBLE_CLICK, event.position(), event.button(), event)
        if event.button() == Qt.MouseButton.LeftButton and pointer_event.hit is not None:
            self._moves.set_pivot(self._view.world_position(pointer_event.hit))
        self.pointer.emit(pointer_event)

    def wheel(self, event: QWheelEvent) -> None:
        # Some systems report a horizontal wheel movement while Shift is held.
        wheel_angle = event.angleDelta()
        notches = (wheel_angle.y() or wheel_angle.x()) / 120.0
        if notches == 0.0:
            return
        view, position = self._view, event.position()
        keys, modifier = event.modifiers(), Qt.KeyboardModifier
        shift, ctrl = bool(keys & modifier.ShiftModifier), bool(keys & modifier.ControlModifier)
        if self.tool_uses_modifiers and (shift or ctrl):
            x, y = position.x(), position.y()
            self.pointer.emit(
                PointerEvent(Pointer.WHEEL, x, y, shift=shift, ctrl=ctrl, wheel_notches=notches)
            )
            event.accept()
            return
        hit = view.pick(position.x(), position.y())
        if hit is not None:
            centre = view.world_position(hit)
        else:
            centre = self._camera.point_at_depth(
                position.x(), position.y(), view.extent(), self._camera.distance
            )
        self._camera.zoom(ZOOM_PER_NOTCH**notches, centre)
        self._moves.redraw()
        event.accept()

    # -- hovering

    def _schedule_hover(self, event: QMouseEvent) -> None:
        self._hover_event = self._event(
            Pointer.MOVE, event.position(), Qt.MouseButton.NoButton, event, hit=False
        )
        wait = self._last_hover_time + HOVER_INTERVAL_S - time.perf_counter()
        if wait <= 0.0:
            self._emit_hover()
        elif not self._hover_timer.isActive():
            self._hover_timer.start(max(1, int(wait * 1000.0)))

    def _emit_hover(self) -> None:
        event, self._hover_event = self._hover_event, None
        if event is None or self._press_position is not None:
            return
        self._last_hover_time = time.perf_counter()
        if event.handle != self.hovered_handle:
            self.hovered_handle = event.handle
            self._view.update()
        self._view.hover(event.x, event.y, is_free=event.handle is None)
        self.pointer.emit(replace(event, hit=self._view.pick(event.x, event.y)))

    def leave(self) -> None:
        self.cursor = None
        self._hover_event = None
