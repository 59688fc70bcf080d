"""Scheduling of scene drawing, and the resulting picture.

While the camera moves, the scene is drawn only inside a paint event (once per step, coalesced by
`update()`). At rest it is drawn incrementally by a timer with zero delay. An idle view draws
nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtGui import QImage, QOpenGLContext
from PySide6.QtWidgets import QWidget

from vomstudio.core.arrays import ByteArray
from vomstudio.rendering.qt.scene_lifetime import SceneLifetime

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene

REST_MS = 250
"""Time without moves after which the camera is at rest."""
REFRESH_DELAY_MS = 30
"""Delay of drawing after a change, so that several changes are drawn together."""


class ScenePicture(QObject):
    """Picture of the scene, and its schedule.

    Attributes
    ----------
    image : QImage or None
        Last picture, or None before the first one.
    is_moving : bool
        Whether the camera is moving or has just stopped.
    """

    first_frame = Signal()
    drawn = Signal()
    """Emitted when the models have been drawn."""
    content_changed = Signal()
    """Emitted when the contents, and not only the camera, require a new picture."""
    outdated = Signal()
    """Emitted when the overlays must be laid out again."""

    def __init__(self, view: QWidget, lifetime: SceneLifetime) -> None:
        super().__init__(view)
        self.image: QImage | None = None
        self.is_moving = False
        self._view, self._lifetime = view, lifetime
        self._pixels: ByteArray | None = None
        self._is_dirty = True
        self._are_features_dirty = False
        self._is_first_done = False
        self._warm_up_steps: Iterator[None] = iter(())
        self._rest_timer = QTimer(self, singleShot=True, interval=REST_MS)
        self._rest_timer.timeout.connect(self._come_to_rest)
        self._refine_timer = QTimer(self, singleShot=True, interval=0)
        self._refine_timer.timeout.connect(self._refine_step)
        lifetime.started.connect(self.redraw_once)

    @property
    def is_still(self) -> bool:
        """Whether the picture is complete and nothing will be drawn until something changes."""
        scene = self._lifetime.scene
        return (
            scene is not None
            and scene.picture.is_complete
            and not self.is_moving
            and not self._rest_timer.isActive()
        )

    # -- requests

    def begin_motion(self) -> None:
        """Draw once in the next paint because the camera has moved, and refine after a delay."""
        self.is_moving = True
        self._is_dirty = True
        if self._lifetime.scene is not None:
            self._lifetime.scene.picture.abandon()
        self._refine_timer.stop()
        self._rest_timer.start(REST_MS)
        self._view.update()

    def redraw(self) -> None:
        """Draw again because the models have changed."""
        self.content_changed.emit()
        self._is_dirty = True
        self._refine_timer.stop()
        self._schedule_rest()
        self._view.update()

    def redraw_once(self) -> None:
        """Draw the models once, while refinement at rest continues."""
        self.content_changed.emit()
        self._is_dirty = True
        self._view.update()

    def redraw_features(self) -> None:
        """Draw the features again."""
        self.content_changed.emit()
        self._are_features_dirty = True
        self._view.update()

    def replace_canvas(self) -> None:
        """Draw the complete picture again because the appearance of the models has changed.

        The previous picture remains until then, unless proxies can be drawn immediately.
        """
        self.content_changed.emit()
        scene = self._lifetime.scene
        if scene is None:
            return
        if any(m.visible and m.proxies for m in scene.models.values()):
            self.redraw()
            return
        scene.picture.abandon()
        self._refine_timer.stop()
        if not self._is_dirty:
            self._rest_timer.start(1)

    def schedule_redraw(self, *, is_first: bool) -> None:
        """Draw new content after a short delay, or immediately if `is_first`."""
        self.content_changed.emit()
        if is_first:
            self.redraw_once()
        self._schedule_rest()

    def schedule_rest(self) -> None:
        """Schedule the refinement because the camera has stopped."""
        self._rest_timer.start(REFRESH_DELAY_MS)

    def rescale(self) -> None:
        """Adapt to a new size of the widget or to another screen."""
        self.outdated.emit()
        scene = self._lifetime.scene
        if scene is None:
            return
        scene.set_scale(self._view.devicePixelRatioF())
        scene.resize(*self.device_size())
        self.is_moving = True
        self._is_dirty = True
        self._refine_timer.stop()
        self._rest_timer.start(REST_MS)
        self._view.update()

    def device_size(self) -> tuple[int, int]:
        """Return the size of the widget in device pixels."""
        ratio = self._view.devicePixelRatioF()
        width, height = self._view.width() * ratio, self._view.height() * ratio
        return max(1, round(width)), max(1, round(height))

    def pause(self) -> None:
        """Stop drawing while the view is hidden."""
        self._refine_timer.stop()

    def stop(self) -> None:
        self._rest_timer.stop()
        self._refine_timer.stop()
        # Break the reference to the scene.
        self._warm_up_steps = iter(())

    def _schedule_rest(self) -> None:
        if not self._rest_timer.isActive():
            self._rest_timer.start(REFRESH_DELAY_MS)

    # -- inside a paint

    def draw_changes(self) -> None:
        """Draw what has changed since the last paint."""
        scene = self._lifetime.scene
        if scene is None:
            return
        _leave_qt_context()
        picture = scene.picture
        if self._is_dirty and not picture.refining:
            self._is_dirty = self._are_features_dirty = False
            picture.draw(is_moving=self.is_moving)
            if picture.is_layering:
                self._refine_timer.start()
                if self.image is not None:
                    return
            self._copy_pixels(scene)
            self.drawn.emit()
            if picture.has_more_nodes:
                self._is_dirty = True
                QTimer.singleShot(0, self._view.update)
            if not picture.is_complete and not picture.is_layering:
                self._schedule_rest()
        elif self._are_features_dirty:
            self._are_features_dirty = False
            picture.draw_features()
            if picture.is_layering:
                self._refine_timer.start()
                if not picture.shows_simple_emphasis:
                    return
            self._copy_pixels(scene)
            if not picture.is_complete and not picture.refining and not picture.is_layering:
                self._schedule_rest()
        elif picture.is_layering and not self._refine_timer.isActive():
            # The view has been hidden in the meantime.
            self._refine_timer.start()

    def finish_paint(self) -> None:
        """Finish a paint, and warm up the driver after the first paint with a scene."""
        scene = self._lifetime.scene
        if scene is not None and not self._is_first_done:
            self._is_first_done = True
            self.first_frame.emit()
            self._warm_up_steps = scene.warm_up()
            QTimer.singleShot(0, self._warm_up_step)

    def _warm_up_step(self) -> None:
        scene = self._lifetime.scene
        if scene is not None and not scene.models:
            for _ in self._warm_up_steps:
                self._is_dirty = True
                QTimer.singleShot(0, self._warm_up_step)
                return
            self._view.update()

    # -- refinement at rest

    def _come_to_rest(self) -> None:
        scene = self._lifetime.scene
        self.is_moving = False
        if scene is None or not self._view.isVisible():
            return
        if scene.picture.is_layering and not scene.picture.refining and not self._is_dirty:
            # The last band schedules the refinement again if anything is left to draw.
            return
        if not self._is_dirty:
            scene.nodes.update_nodes()
        if scene.picture.is_complete and not self._is_dirty:
            # The picture is complete; labels that did not fit during the movement may fit now.
            self.outdated.emit()
            self._view.update()
            self.drawn.emit()
            return
        is_unfinished = any(
            m.visible and m.proxies and not m.has_all_chunks for m in scene.models.values()
        )
        if is_unfinished:
            if self._is_dirty:
                self._view.update()
            return
        if scene.nodes.is_waiting:
            self._rest_timer.start(50)
            return
        scene.picture.begin_rest()
        self._refine_timer.start()

    def _refine_step(self) -> None:
        scene = self._lifetime.scene
        if scene is None:
            return
        _leave_qt_context()
        picture = scene.picture
        if picture.refining:
            is_finished = picture.refine()
            if is_finished:
                self._is_dirty = False
                self._are_features_dirty = False
        elif picture.is_layering and not self._is_dirty and not self._are_features_dirty:
            is_finished = picture.draw_band()
        else:
            # The next paint starts the drawing again.
            return
        if not is_finished:
            self._refine_timer.start()
            return
        self._copy_pixels(scene)
        self.drawn.emit()
        self._view.update()
        if not scene.picture.is_complete:
            # Additional content arrived while this frame was being drawn.
            self._rest_timer.start(REFRESH_DELAY_MS)

    def _copy_pixels(self, scene: Scene) -> None:
        # The image shares the memory of the array, which must be kept alive.
        self._pixels = np.ascontiguousarray(scene.canvas.pixels()[::-1])
        height, width = self._pixels.shape[:2]
        self.image = QImage(
            self._pixels.data, width, height, 4 * width, QImage.Format.Format_RGBX8888
        )
        self.image.setDevicePixelRatio(self._view.devicePixelRatioF())
        self.outdated.emit()


def _leave_qt_context() -> None:
    """Leave Qt's graphics context before VTK activates its own context.

    Qt would otherwise continue to draw in the context of VTK, because VTK does not inform Qt.
    """
    context = QOpenGLContext.currentContext()
    if context is not None:
        context.doneCurrent()
