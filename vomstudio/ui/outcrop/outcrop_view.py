"""View of the outcrop for the menus, panels and tools of the window."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Qt, QTimer, Signal

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate
from vomstudio.geometry import transform
from vomstudio.project.records import Model
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.studio.tools.interaction_types import Hit, PointerEvent
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.number_formatting import extent_points
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.camera_view import CameraView
from vomstudio.ui.outcrop.extended_plane_drawings import ExtendedPlaneDrawings
from vomstudio.ui.outcrop.face_grid_drawings import FaceGridDrawings
from vomstudio.ui.outcrop.proposed_trace_drawings import ProposedTraceDrawings
from vomstudio.ui.outcrop.scene_presenter import FeatureView, ScenePresenter
from vomstudio.ui.outcrop.view_history import ViewHistory

# (name, text, key)
STANDARD_VIEWS = (
    ("top", to_translate("From above"), "Alt+1"),
    ("north", to_translate("Looking north"), "Alt+2"),
    ("east", to_translate("Looking east"), "Alt+3"),
    ("south", to_translate("Looking south"), "Alt+4"),
    ("west", to_translate("Looking west"), "Alt+5"),
    ("bottom", to_translate("From below"), "Alt+6"),
)
_SAVE_CAMERA_DELAY_MS = 500
NORMAL_RADIUS_SPACINGS = 10.0
"""Radius, in point spacings, within which the normal of the surface is determined."""
_READING_HELP_TOPIC = "numbers.md#the-live-reading"


class OutcropView(QObject):
    """Connection of the viewport with the studio.

    The window is created before its viewport. Methods have no effect before `attach_viewport`.
    """

    direction_changed = Signal(float, float, bool)
    """Emits the trend and plunge of the view direction in degrees, and whether it is
    orthographic."""
    state_changed = Signal()
    """Emitted when the camera starts to move, stops, or changes its projection."""

    def __init__(self, studio: Studio, cameras: CameraView) -> None:
        super().__init__()
        self._studio, self._cameras = studio, cameras
        self.viewport: Viewport | None = None
        self._presenter: ScenePresenter | None = None
        self.history = ViewHistory(studio)
        self.history.changed.connect(self._emit_direction)
        self.history.changed.connect(self.state_changed)
        self._was_orthographic = False
        self._camera_timer = QTimer(self, singleShot=True, interval=_SAVE_CAMERA_DELAY_MS)
        self._camera_timer.timeout.connect(self.save_camera)

    def attach_viewport(self, viewport: Viewport) -> None:
        """Show the project of the studio in a viewport."""
        self.viewport = viewport
        self._presenter = ScenePresenter(self._studio, viewport)
        self._presenter.rebuild()
        viewport.set_label_mode(self._studio.settings.labels)
        self._grid_drawings = FaceGridDrawings(self._studio, viewport)
        self._proposed_trace_drawings = ProposedTraceDrawings(self._studio, viewport)
        self._extended_plane_drawings = ExtendedPlaneDrawings(self._studio, viewport)
        elements = self._studio.workspace.elements
        elements.look = viewport.view_snapshot
        self._studio.hidden_elements_changed.connect(
            lambda id_: viewport.models.hide_elements(id_, elements.hidden(id_))
        )
        self._cameras.watch(viewport)
        set_help_topic(
            viewport, lambda _: _READING_HELP_TOPIC if viewport.reading_position.box else None
        )

    def feature_at(self, x: float, y: float) -> str | None:
        """Return the id of the feature at a viewport pixel, or None if no feature is there."""
        if self._presenter is None or self.viewport is None:
            return None
        return self._presenter.feature_at(self.viewport, x, y)

    def set_edit_callback(self, callback: Callable[[], object]) -> None:
        """Set the function that edits the selected feature after a double click."""
        if self._presenter is not None:
            self._presenter.edit_callback = callback

    def look_along_normal(self, hit: Hit) -> Finding | None:
        """Look perpendicular to the surface at a hit; return why this is impossible, or None."""
        surface = self._studio.surface(hit.model_id)
        model = self._studio.records.get(hit.model_id)
        open_model = self._studio.models.get(hit.model_id)
        if self.viewport is None or surface is None or open_model is None:
            return Finding("model.not-open", model=hit.model_id)
        radius = NORMAL_RADIUS_SPACINGS * (open_model.resolution or 0.0)
        normal = surface.local_normal(hit.index, hit.position, radius)
        if normal is None or not isinstance(model, Model):
            return Finding("view.no-normal")
        direction = -transform.rotate(model.to_world, [normal])[0]
        if direction @ self.viewport.camera.direction < 0.0:
            direction = -direction
        trend = float(np.degrees(np.arctan2(direction[0], direction[1])) % 360.0)
        plunge = float(np.degrees(np.arcsin(np.clip(-direction[2], -1.0, 1.0))))
        self.viewport.moves.set_pivot(self.viewport.world_position(hit))
        self.look_along(trend, plunge)
        return None

    def connect_camera(self) -> None:
        """Emit `direction_changed` at every move of the camera, and apply the settings."""
        if self.viewport is not None:
            settings = self._studio.settings
            # Before `_camera_changed`, so that the command for the earlier view is up to date.
            self.history.watch(self.viewport)
            self.viewport.camera_changed.connect(self._handle_camera_change)
            self.viewport.problem.connect(lambda finding: self._studio.warn(finding))
            self.viewport.models.point_budget = settings.point_budget
            self.viewport.gestures.set_turntable(settings.turntable)
            self._handle_camera_change()

    def disabled_reason(self) -> Finding | None:
        """Return why the view cannot be changed now, or None if it can."""
        if self.viewport is None or not self._studio.models:
            return Finding("action.no-model")
        return None

    # --- directions --------------------------------------------------------------------------
    @property
    def is_orthographic(self) -> bool:
        """Whether the view is orthographic."""
        return self.viewport is not None and self.viewport.moves.orthographic

    def toggle_orthographic(self) -> None:
        """Switch between orthographic and perspective projection."""
        if self.viewport is not None:
            self.viewport.moves.set_orthographic(not self.viewport.moves.orthographic)

    def look_along(self, trend_deg: float, plunge_deg: float) -> None:
        """Look along a direction in an orthographic view; angles are in degrees."""
        if self.viewport is not None:
            self.viewport.moves.set_orthographic(True)
            self.viewport.moves.look_along(trend_deg, plunge_deg)

    def view_direction(self) -> tuple[float, float] | None:
        """Return the trend and plunge of the view in degrees, or None if there is no view."""
        return None if self.viewport is None else self.viewport.moves.view_direction()

    def view_state(self) -> tuple[dict[str, Any], dict[str, Any] | None] | None:
        """Return the camera and clipping box for `restore_view`, or None if no model is open."""
        if self.viewport is None or not self._studio.models:
            return None
        box = self._studio.display.effective_clip
        return self.viewport.moves.camera_state(), None if box is None else box.to_dict()

    def restore_view(self, camera: dict[str, Any], box: dict[str, Any] | None) -> None:
        """Restore a camera and clipping box. Raises ValueError if they are not valid."""
        if self.viewport is None:
            return
        clip_box = None if box is None else ClipBox.from_dict(box)
        try:
            self.viewport.moves.set_camera_state(camera)
        except (KeyError, TypeError) as error:
            raise ValueError(str(error)) from error
        self._studio.display.set_clip(clip_box or self._studio.display.box, clip_box is not None)

    def set_standard_view(self, name: str) -> None:
        """Look in one of the standard directions, such as "north"."""
        if self.viewport is not None:
            self.viewport.moves.set_standard_view(name)

    def set_label_mode(self, mode: str) -> None:
        """Set which features are labelled: "auto", "all", "selected" or "none"."""
        if self.viewport is not None:
            self.viewport.set_label_mode(mode)

    def set_turntable(self, is_enabled: bool) -> None:
        """Set whether the z axis stays upright when the view is rotated."""
        if self.viewport is not None:
            self.viewport.gestures.set_turntable(is_enabled)

    # --- visible extent ----------------------------------------------------------------------
    def frame_all(self) -> None:
        """Show all visible models and cameras."""
        if self._presenter is not None:
            self._presenter.frame_all(self._cameras.frusta_points())

    def frame_selection(self) -> None:
        """Show the selected features."""
        measurements = self._studio.measured(self._studio.selection.ids).values()
        points = [p for m in measurements if len(p := extent_points(m))]
        if self.viewport is not None and points:
            self.viewport.moves.frame(np.concatenate(points))

    def models_box(self) -> ClipBox | None:
        """Return the bounding box of all visible models, or None if no model is visible."""
        return None if self._presenter is None else self._presenter.models_box()

    def has_content_in_clip_box(self) -> bool:
        """Return whether the clipping box intersects the bounding box of the visible models."""
        box, bounds = self._studio.display.box, self.models_box()
        return box is not None and bounds is not None and box.intersects_box(bounds)

    def select_at(self, view: FeatureView, event: PointerEvent) -> None:
        """Select the feature at a click in another view of the outcrop."""
        if self._presenter is not None:
            self._presenter.select_at(view, event)

    # --- tools -------------------------------------------------------------------------------
    def apply_tool(self, tool: str) -> None:
        """Set the cursor, the mouse buttons and the keys for a tool."""
        if self.viewport is not None:
            active_tool = self._studio.tools.get(tool)
            arrow_cursor, cross_cursor = Qt.CursorShape.ArrowCursor, Qt.CursorShape.CrossCursor
            self.viewport.setCursor(arrow_cursor if active_tool is None else cross_cursor)
            is_painting = active_tool is not None and active_tool.can_paint
            self.viewport.gestures.orbit_button = (
                Qt.MouseButton.RightButton if is_painting else Qt.MouseButton.LeftButton
            )
            modifier_tool_names = {entry.name for entry in TOOLS if entry.uses_modifiers}
            self.viewport.gestures.tool_uses_modifiers = tool in modifier_tool_names

    # --- the camera --------------------------------------------------------------------------
    def _handle_camera_change(self) -> None:
        self._emit_direction()
        is_first_step = not self._camera_timer.isActive()
        self._camera_timer.start()
        if is_first_step or self._was_orthographic != self.is_orthographic:
            self._was_orthographic = self.is_orthographic
            self.state_changed.emit()

    def _emit_direction(self) -> None:
        if self.viewport is not None:
            trend, plunge = self.viewport.moves.view_direction()
            self.direction_changed.emit(trend, plunge, self.viewport.moves.orthographic)

    def save_camera(self) -> None:
        """Save the camera in the project, so that it opens with the same view."""
        # Without a model, the camera shows nothing, so the saved camera is kept.
        if self.viewport is not None and self._studio.models:
            self._studio.project.journal.set_view("camera", self.viewport.moves.camera_state())

    def close(self) -> None:
        """Stop drawing before the window is closed."""
        self._camera_timer.stop()
        self.history.stop()
        if self.viewport is not None:
            # Otherwise an error within a Qt event would not be reported to the caller.
            try:
                self.viewport.shutdown()
            finally:
                self.viewport.close()
