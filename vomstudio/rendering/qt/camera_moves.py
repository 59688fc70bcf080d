"""Camera moves of the view, except those made with the mouse."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Signal

from vomstudio.core.arrays import FloatArray
from vomstudio.rendering.qt.viewport_protocol import Pane, Redrawable
from vomstudio.rendering.view.camera import STANDARD_VIEWS, VIEW_ALIASES, Camera


class CameraMoves(QObject):
    """Camera moves. Callers that move the camera directly must call `redraw`."""

    changed = Signal()
    restored = Signal()
    """Emitted when a stored view has been restored."""

    def __init__(
        self,
        camera: Camera,
        pane: Pane,
        scene_bounds: Callable[[], FloatArray],
        picture: Redrawable,
        parent: QObject,
    ) -> None:
        """Create the moves of a camera.

        Parameters
        ----------
        scene_bounds : callable
            Function that returns World points (n, 3) around all visible contents.
        """
        super().__init__(parent)
        self.camera = camera
        self._pane, self._scene_bounds, self._picture = pane, scene_bounds, picture
        self._fitted_points: FloatArray | None = None

    def redraw(self) -> None:
        """Request a drawing in the next paint, and its refinement after a delay."""
        self._fitted_points = None
        self._picture.begin_motion()
        self.changed.emit()

    # -- target of the view

    def home(self) -> None:
        """Show all visible contents from the south, looking down at 35 degrees."""
        self.camera.look_along(0.0, 35.0)
        self._frame_all()

    def frame(self, points_world: FloatArray) -> None:
        """Show all points (n, 3) of the World frame, keeping the view direction.

        They are kept in view if the widget is resized before the camera is moved.
        """
        points = np.asarray(points_world, float)
        self.fit(points)
        self._fitted_points = points

    def fit(self, points_world: FloatArray) -> None:
        """Show all these World points (n, 3), keeping the view direction."""
        self.camera.fit(points_world, self._pane.extent())
        self.redraw()

    def handle_resize(self) -> None:
        """Frame the same points again unless the camera has been moved since."""
        if self._fitted_points is not None:
            self.frame(self._fitted_points)

    def keep_camera(self) -> None:
        """Keep the camera when the widget is resized."""
        self._fitted_points = None

    def set_pivot(self, point_world: FloatArray) -> None:
        """Set the pivot of rotations, a point in the World frame; the view does not change."""
        self.camera.set_pivot(np.asarray(point_world, float))
        self._picture.redraw_once()

    def set_standard_view(self, name: str) -> None:
        """Look in a named direction, and frame everything visible.

        Names refer to the view direction ("north" is the view from the south): north, northeast,
        east, southeast, south, southwest, west, northwest, down, up. "top" is the same as
        "down", and "bottom" the same as "up".
        """
        trend, plunge = STANDARD_VIEWS[VIEW_ALIASES.get(name, name)]
        self.camera.look_along(trend, plunge)
        self._frame_all()

    def look_along(self, trend_deg: float, plunge_deg: float) -> None:
        """Look along a direction without moving the pivot in the image.

        Up, or North if the view is within 1 degree of vertical, points upwards in the image.
        """
        self.camera.look_along(trend_deg, plunge_deg)
        self.redraw()

    def set_orthographic(self, is_orthographic: bool) -> None:
        """Switch the projection, keeping the scale at the distance of the pivot."""
        if is_orthographic != self.camera.orthographic:
            self.camera.orthographic = is_orthographic
            self.redraw()

    def _frame_all(self) -> None:
        self.frame(self._scene_bounds())

    # -- properties of the view

    @property
    def orthographic(self) -> bool:
        return self.camera.orthographic

    def view_direction(self) -> tuple[float, float]:
        """Return the trend and plunge (positive downwards) of the view direction, degrees."""
        return self.camera.trend_plunge()

    def metres_per_pixel(self) -> float:
        """Return the scale at the distance of the pivot, in metres per logical pixel."""
        return self.camera.metres_per_pixel(self._pane.extent()[1])

    def view_extent(self) -> tuple[FloatArray, float, float]:
        """Return the centre (3,) of the view in the World frame, and the size of the view.

        The centre and the size (width and height, m) are at the distance of the pivot.
        """
        camera, scale = self.camera, self.metres_per_pixel()
        centre = camera.position + camera.distance * camera.direction
        width, height = self._pane.extent()
        return centre, scale * width, scale * height

    # -- stored view state

    def camera_state(self) -> dict[str, Any]:
        """Return the state of the camera as plain values for `set_camera_state`."""
        return self.camera.to_dict()

    def set_camera_state(self, state: dict[str, Any]) -> None:
        """Restore a camera state. If it is not valid, raise ValueError and change nothing."""
        self.camera.restore(state)
        self.restored.emit()
        self.redraw()
