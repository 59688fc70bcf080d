"""The moves of the view's camera, but for those of the mouse."""

from __future__ import annotations

from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Signal

from vomstudio.core.arrays import FloatArray
from vomstudio.rendering.qt.scene_lifetime import SceneLife
from vomstudio.rendering.qt.scene_picture import ScenePicture
from vomstudio.rendering.qt.viewport_protocol import Pane
from vomstudio.rendering.view.camera import STANDARD_VIEWS, VIEW_ALIASES, Camera


class CameraMoves(QObject):
    """Who moves the camera itself, as the mouse does, says so by `moved`."""

    changed = Signal()
    restored = Signal()
    """A view that was kept is taken up again."""

    def __init__(
        self, camera: Camera, pane: Pane, life: SceneLife, picture: ScenePicture, parent: QObject
    ) -> None:
        super().__init__(parent)
        self.camera = camera
        self._pane, self._life, self._picture = pane, life, picture
        self._fitted: FloatArray | None = None

    def moved(self) -> None:
        """The camera has changed: draw once in the next paint, rest a little later."""
        self._fitted = None
        self._picture.stir()
        self.changed.emit()

    # -- what is looked at

    def home(self) -> None:
        """See all visible models from the south and a little above, as on first sight."""
        self.camera.look_along(0.0, 35.0)
        self._frame_all()

    def frame(self, points_world: FloatArray) -> None:
        """Show all these World points (n, 3), keeping the direction of view, and keep them in view
        where the widget is resized before anybody moves."""
        points = np.asarray(points_world, float)
        self.fit(points)
        self._fitted = points

    def fit(self, points_world: FloatArray) -> None:
        """Show all these World points (n, 3), keeping the direction of view."""
        self.camera.fit(points_world, self._pane.extent())
        self.moved()

    def resized(self) -> None:
        """Nobody has moved since everything was brought into view: keep it in view."""
        if self._fitted is not None:
            self.frame(self._fitted)

    def stay(self) -> None:
        """From now on the camera keeps its place when the widget is resized."""
        self._fitted = None

    def set_pivot(self, point_world: FloatArray) -> None:
        """Orbit about this World point from now on; the view stays as it is."""
        self.camera.set_pivot(np.asarray(point_world, float))
        self._picture.redraw_once()

    def standard_view(self, name: str) -> None:
        """Look in a direction named by where the viewer looks ("north" stands in the south):
        north, northeast, east, southeast, south, southwest, west, northwest, down, up; "top" is
        "down" and "bottom" is "up". Everything visible is framed."""
        trend, plunge = STANDARD_VIEWS[VIEW_ALIASES.get(name, name)]
        self.camera.look_along(trend, plunge)
        self._frame_all()

    def look_along(self, trend_deg: float, plunge_deg: float) -> None:
        """Look along a direction; the pivot keeps its place. Image up is Up projected, North
        where the view is within 1 degree of vertical."""
        self.camera.look_along(trend_deg, plunge_deg)
        self.moved()

    def set_orthographic(self, orthographic: bool) -> None:
        """Switch the projection; what lies at the pivot's distance keeps its size."""
        if orthographic != self.camera.orthographic:
            self.camera.orthographic = orthographic
            self.moved()

    def _frame_all(self) -> None:
        scene = self._life.scene
        self.frame(np.zeros((0, 3)) if scene is None else scene.everything())

    # -- what is seen

    @property
    def orthographic(self) -> bool:
        return self.camera.orthographic

    def view_direction(self) -> tuple[float, float]:
        """Trend and plunge (degrees, plunge positive downwards) of where the viewer looks."""
        return self.camera.trend_plunge()

    def metres_per_pixel(self) -> float:
        """Metres across one logical pixel at the pivot's distance (anywhere if orthographic)."""
        return self.camera.metres_per_pixel(self._pane.extent()[1])

    def seen(self) -> tuple[FloatArray, float, float]:
        """The middle of the view at the pivot's distance (3,), World, and the width and height in
        metres that are seen there."""
        camera, scale = self.camera, self.metres_per_pixel()
        centre = camera.position + camera.distance * camera.direction
        width, height = self._pane.extent()
        return centre, scale * width, scale * height

    # -- kept with the project

    def camera_state(self) -> dict[str, Any]:
        """The view as JSON-able values, for `set_camera_state`."""
        return self.camera.to_dict()

    def set_camera_state(self, state: dict[str, Any]) -> None:
        """Take back a view; raises ValueError where it is none, and changes nothing then."""
        self.camera.restore(state)
        self.restored.emit()
        self.moved()
