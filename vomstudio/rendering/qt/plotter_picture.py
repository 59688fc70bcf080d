"""Scheduling of the second view's picture, which is drawn only inside paint events."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.rendering.qt.scene_picture import REFRESH_DELAY_MS, REST_MS

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene


class PlotterPicture(QObject):
    """Schedule of a picture: once per step of a move, in small steps at rest, never when idle.

    Attributes
    ----------
    is_moving : bool
        Whether the camera is moving or has just stopped.
    """

    picture_completed = Signal()
    """Emitted when the picture that is shown has changed."""

    def __init__(self, request_paint: Callable[[], None], parent: QObject) -> None:
        super().__init__(parent)
        self.is_moving = False
        self._scene: Scene | None = None
        self._present: Callable[[], None] = lambda: None
        self._request_paint = request_paint
        self._is_dirty, self._are_features_dirty, self._is_rest_pending = True, False, False
        self._rest_timer = QTimer(self, singleShot=True)
        self._rest_timer.timeout.connect(self._come_to_rest)

    def begin(self, scene: Scene, present_callback: Callable[[], None]) -> None:
        """Draw a scene from now on; `present_callback` passes a finished picture to the screen."""
        self._scene, self._present = scene, present_callback
        self.redraw()

    def stop(self) -> None:
        """Draw nothing until `begin` is called again."""
        self._scene, self._present = None, lambda: None
        self._rest_timer.stop()

    @property
    def is_still(self) -> bool:
        """Whether the picture is complete and nothing will be drawn until something changes."""
        scene = self._scene
        return (
            scene is not None
            and scene.picture.is_complete
            and not (self.is_moving or self._is_dirty or self._are_features_dirty)
            and not self._rest_timer.isActive()
        )

    # -- requests

    def begin_motion(self) -> None:
        """Draw once in the next paint because the camera has moved, and refine after a delay."""
        self.is_moving, self._is_dirty = True, True
        if self._scene is not None:
            self._scene.picture.abandon()
        self._rest_timer.start(REST_MS)
        self._request_paint()

    def redraw(self) -> None:
        """Draw again because the models have changed."""
        self._is_dirty = True
        self._schedule_rest()
        self._request_paint()

    def redraw_once(self) -> None:
        """Draw the models once, while refinement at rest continues."""
        self._is_dirty = True
        self._request_paint()

    def redraw_features(self) -> None:
        """Draw the features again."""
        self._are_features_dirty = True
        self._request_paint()

    def _schedule_rest(self) -> None:
        if not self._rest_timer.isActive():
            self._rest_timer.start(REFRESH_DELAY_MS)

    def _come_to_rest(self) -> None:
        self.is_moving = False
        scene = self._scene
        if scene is None:
            return
        if scene.picture.is_complete and not self._is_dirty:
            # Labels that did not fit during the movement may fit now.
            self.picture_completed.emit()
        elif any(m.visible and m.proxies and not m.has_all_chunks for m in scene.models.values()):
            # Drawn again when the next part of the model has arrived.
            self._request_paint()
        else:
            self._is_rest_pending = True
            self._request_paint()

    # -- inside a paint

    def draw(self) -> None:
        """Draw what has changed since the last paint, or the next step of a picture at rest."""
        scene = self._scene
        if scene is None:
            return
        picture = scene.picture
        if self._is_rest_pending and not self.is_moving and not picture.refining:
            picture.begin_rest()
        self._is_rest_pending = False
        if picture.refining:
            if picture.refine():
                self._is_dirty = self._are_features_dirty = False
                self._finish(scene)
            else:
                self._request_paint()
        elif self._is_dirty:
            self._is_dirty = self._are_features_dirty = False
            picture.draw(is_moving=self.is_moving)
            if picture.is_layering:
                self._request_paint()
                return
            self._finish(scene)
            if picture.has_more_nodes:
                self.redraw_once()
        elif picture.is_layering:
            if picture.draw_band():
                self._finish(scene)
            else:
                self._request_paint()
        elif self._are_features_dirty:
            self._are_features_dirty = False
            picture.draw_features()
            if picture.is_layering:
                self._request_paint()
            else:
                self._finish(scene)

    def _finish(self, scene: Scene) -> None:
        # Labels are hidden behind the models; the depth is read while its context is current.
        scene.canvas.depth()
        self._present()
        self.picture_completed.emit()
        if not scene.picture.is_complete:
            self._schedule_rest()
