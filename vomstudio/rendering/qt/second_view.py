"""Second 3-D view of the contents of the viewport, with a camera of its own.

PyVista's widget draws it; the imports take seconds, so this module does not import it. The
widget exists only while the view is visible: a Qt context does not survive the move to another
window, for example when a dock is floated, and a closed view uses no graphics memory.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QEvent, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QHideEvent, QPainter, QPaintEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QWidget

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.rendering.qt.camera_moves import CameraMoves
from vomstudio.rendering.qt.feature_picking import feature_at
from vomstudio.rendering.qt.gestures import Gestures
from vomstudio.rendering.qt.overlays import Overlays
from vomstudio.rendering.qt.plotter_picture import PlotterPicture
from vomstudio.rendering.qt.preview_painting import PreviewPainter
from vomstudio.rendering.qt.viewport import BACKGROUND, Viewport
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.rendering.view.readout_position import ReadingPosition
from vomstudio.studio.tools.interaction_types import Area, Hit, Preview

if TYPE_CHECKING:
    from vomstudio.rendering.qt.plotter_view import PlotterView
    from vomstudio.rendering.scene.shared_scene import SharedScene


def import_plotter() -> None:
    """Import the slow libraries of the view, so that it can be shown without a long delay.

    The function may run in any thread, and imports nothing that creates Qt classes: if another
    thread does this while the main thread uses Qt, the program crashes.
    """
    import pyvista.plotting  # noqa: F401


class SecondView(QWidget):
    """3-D view of the models and features of a viewport. Pixels are logical.

    Parameters
    ----------
    source : Viewport
        View whose contents, appearance and clipping box are shown.
    is_shown : callable
        Function that returns whether a model is shown, given its id.
    """

    pointer = Signal(object)
    """Emits the PointerEvents of the gestures."""
    camera_changed = Signal()

    def __init__(
        self, source: Viewport, is_shown: Callable[[str], bool], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self.setMinimumSize(160, 120)
        self.preview: Preview | None = None
        self._preview_areas: list[tuple[Area, tuple[float, float, float]]] = []
        self._reading_position = ReadingPosition()
        self._source, self._is_shown = source, is_shown
        self._plotter: PlotterView | None = None
        self._is_creating = False
        self._scene: SharedScene | None = None
        self.camera = Camera()
        self.camera.restore(source.camera.to_dict())
        self._picture = PlotterPicture(self._request_paint, self)
        self._picture.picture_completed.connect(self._refresh_labels)
        self.moves = CameraMoves(self.camera, self, self._scene_bounds, self._picture, self)
        self.moves.changed.connect(self.camera_changed)
        self.overlays = Overlays(self.camera, source.display.captions)
        self.gestures = Gestures(self, self.moves, _NoFaces(), self)
        self.gestures.pointer.connect(self.pointer)
        self._labels = _LabelOverlay(self)
        # Several changes are adopted together.
        self._follow_timer = QTimer(self, singleShot=True, interval=0)
        self._follow_timer.timeout.connect(self.follow)
        source.content_changed.connect(self.schedule_follow)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        return QSize(600, 600)

    def extent(self) -> tuple[float, float]:
        """Return the width and height in logical pixels, at least 1 each."""
        return float(max(self.width(), 1)), float(max(self.height(), 1))

    @property
    def scene(self) -> SharedScene | None:
        """VTK scene, or None while the view is hidden."""
        return self._scene

    @property
    def plotter(self) -> PlotterView | None:
        """PyVista's widget, or None while the view is hidden."""
        return self._plotter

    @property
    def is_still(self) -> bool:
        """Whether the picture is complete and nothing will be drawn until something changes."""
        return self._picture.is_still and not self._follow_timer.isActive()

    # -- start and end

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        QTimer.singleShot(0, self, self._create)

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802 - Qt's name
        if not event.spontaneous():
            self.release()
        super().hideEvent(event)

    def _create(self) -> None:
        # The first widget of this kind has Qt create its window again, which hides and shows it.
        if self._plotter is not None or self._is_creating or not self.isVisible():
            return
        from vomstudio.rendering.qt.plotter_view import PlotterView

        self._is_creating = True
        try:
            self._plotter = plotter = PlotterView(self, self._draw, self.gestures)
        finally:
            self._is_creating = False
        plotter.setGeometry(self.rect())
        # Keys act on the outcrop.
        plotter.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        plotter.setFocusProxy(self._source)
        plotter.show()
        self._labels.raise_()

    def release(self) -> None:
        """Release VTK and the graphics memory of the view until it is shown again."""
        self._follow_timer.stop()
        self._picture.stop()
        if self._scene is not None:
            self._scene.close()
            self._scene = None
        if self._plotter is not None:
            self._plotter.close()
            self._plotter.deleteLater()
            self._plotter = None

    def _draw(self) -> None:
        """Draw inside a paint of the plotter, whose graphics context is current."""
        source, plotter = self._source.scene, self._plotter
        if source is None or plotter is None:
            return
        if self._scene is None:
            from vomstudio.rendering.scene.shared_scene import SharedScene

            self._scene = SharedScene(source, self.camera, plotter.canvas())
            self._scene.set_scale(self.devicePixelRatioF())
            self._scene.start(*self._device_size())
            self._scene.resize(*self._device_size())
            self._adopt_changes()
            self._picture.begin(self._scene, plotter.present)
        self._picture.draw()

    def _request_paint(self) -> None:
        if self._plotter is not None:
            self._plotter.update()

    def _device_size(self) -> tuple[int, int]:
        ratio = self.devicePixelRatioF()
        return max(1, round(self.width() * ratio)), max(1, round(self.height() * ratio))

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        super().resizeEvent(event)
        self._fit_widgets()

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.DevicePixelRatioChange:
            self._fit_widgets()
        return super().event(event)

    def _fit_widgets(self) -> None:
        """Adapt to a new size or to another screen."""
        self._labels.setGeometry(self.rect())
        if self._plotter is not None:
            self._plotter.setGeometry(self.rect())
        if self._scene is not None:
            self._scene.set_scale(self.devicePixelRatioF())
            self._scene.resize(*self._device_size())
            self.moves.handle_resize()
            self._picture.begin_motion()

    # -- contents

    def schedule_follow(self) -> None:
        """Adopt the changes of the viewport after the present event."""
        self._follow_timer.start()

    def follow(self) -> None:
        """Adopt the changes of the viewport's contents, and draw them."""
        if self._scene is None or self._source.scene is None:
            # The first paint after the start of the viewport adopts all contents.
            self._request_paint()
            return
        models, features = self._adopt_changes()
        if models:
            self._picture.redraw()
        if features:
            self.overlays.annotations.clear_state()
            self._picture.redraw_features()
        self.gestures.adopt_settings(self._source.gestures)
        notes, source = self.overlays, self._source.overlays
        notes.is_north_known, notes.is_unit_known = source.is_north_known, source.is_unit_known
        notes.annotations.label_mode = source.annotations.label_mode
        self._refresh_labels()

    def _adopt_changes(self) -> tuple[bool, bool]:
        assert self._scene is not None
        return self._scene.follow(self._is_shown), self._scene.follow_features()

    def _scene_bounds(self) -> FloatArray:
        return np.zeros((0, 3)) if self._scene is None else self._scene.all_corners()

    def frame_all(self) -> None:
        """Show all contents, keeping the view direction."""
        self.moves.frame(self._scene_bounds())

    # -- picking and projecting

    def pick(self, x: float, y: float) -> Hit | None:
        """Return the front-most point of a shown model at a pixel, or None."""
        return None if self._scene is None else self._scene.pick(x, y, self.extent())

    def world_position(self, hit: Hit) -> FloatArray:
        """Return the position (3,) of a hit in the World frame."""
        return self._source.world_position(hit)

    def feature_at(self, x: float, y: float, *, include_discs: bool = True) -> str | None:
        """Return the id of the feature with a label, symbol, line or disc at a pixel, or None."""
        if (feature_id := self.overlays.annotations.at(x, y)) is not None:
            return feature_id
        candidates = [drawing for drawing in self._features().values() if drawing.visible]
        return feature_at(candidates, x, y, self.camera, self.extent(), include_discs=include_discs)

    def project(self, points: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Project points (n, 3) of the World frame to pixels (n, 2), and test their visibility."""
        pixels, _ = self.camera.project(points, self.extent())
        if self._scene is None:
            return pixels, np.zeros(len(pixels), np.bool_)
        return pixels, self._scene.visibility(points) & self._source.clip.contains(points)

    def hover(self, x: float, y: float, *, is_free: bool) -> None:
        """Ignore the cursor at a pixel, because this view has no highlights."""

    def set_preview(self, preview: Preview | None) -> None:
        """Show the preview of an unfinished feature, or None to remove it."""
        self.preview = preview
        areas = [] if preview is None else preview.areas()
        # The areas are compared by identity, because their arrays may be large.
        is_same = [(id(area), c) for area, c in areas] == [
            (id(area), c) for area, c in self._preview_areas
        ]
        if self._scene is not None and not is_same:
            self._preview_areas = areas
            self._scene.features.set_preview_areas(areas)
            self._picture.redraw_features()
        self._labels.update()

    def _features(self) -> Mapping[str, FeatureDrawing]:
        return self._source.features.unclipped_drawings()

    # -- labels

    def _refresh_labels(self) -> None:
        self._labels.update()

    def paint_labels(self, painter: QPainter) -> None:
        """Paint labels, compass and scale bar."""
        if self._scene is None:
            painter.fillRect(QRectF(self.rect()), BACKGROUND)
            return
        if not (self._scene.models or self._features()):
            return
        self.overlays.paint(
            painter,
            self.extent(),
            self._features(),
            self._source.features.selected,
            self._scene.scales(),
            self.project,
            is_moving=self._picture.is_moving,
        )
        if self.preview is not None:
            PreviewPainter(
                painter, self.camera, self.extent(), self.project, self._reading_position
            ).paint(self.preview, self.gestures.cursor, self.gestures.hovered_handle)


class _NoFaces:
    """Clipping box without handles; its faces can be moved only in the viewport."""

    def face_at(self, x: float, y: float) -> int | None:
        return None

    def drag_face(self, face: int, x: float, y: float) -> None: ...

    def release_face(self) -> None: ...


class _LabelOverlay(QWidget):
    """Transparent layer over the plotter, painted without its graphics context."""

    def __init__(self, view: SecondView) -> None:
        super().__init__(view)
        self._view = view
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_NoSystemBackground)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        painter = QPainter(self)
        self._view.paint_labels(painter)
        painter.end()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802 - Qt's name
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._view.overlays.annotations.forget_font()
            self.update()
