"""Widget of PyVista in which only paint events draw.

The stock widget draws twice per step of a drag, draws an idle window five times per second, and
smooths edges while the camera moves. Here `render` only requests a paint, a paint draws only
changed parts, and the timer and the smoothing are off. Importing this module takes seconds.
"""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent
from PySide6.QtGui import (
    QDragEnterEvent,
    QDropEvent,
    QEnterEvent,
    QKeyEvent,
    QMouseEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QWidget
from pyvistaqt import QtInteractor
from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

from vomstudio.rendering.qt.gestures import Gestures
from vomstudio.rendering.scene.canvas import Canvas


class _Interactor(vtkGenericRenderWindowInteractor):
    """Interactor that calls `draw` instead of drawing the whole window in every paint."""

    draw: Callable[[], None] | None = None

    def Render(self) -> None:  # noqa: N802 - VTK's name
        if self.draw is not None:
            self.draw()


class PlotterView(QtInteractor):
    """Plotter whose pictures are drawn by `draw`, and whose mouse events go to `gestures`."""

    def __init__(self, parent: QWidget, draw: Callable[[], None], gestures: Gestures) -> None:
        interactor = _Interactor()
        super().__init__(parent, auto_update=False, multi_samples=0, iren=interactor)
        self._gestures = gestures
        interactor.draw = draw
        # A picture that is drawn in several steps is shown after the last one; see `present`.
        window = self.ren_win
        assert window is not None, "the widget has just made it"
        self._window = window
        window.SwapBuffersOff()

    def canvas(self) -> Canvas:
        """Return a canvas that draws in this widget."""
        return Canvas(self._window, self.renderer)

    def present(self) -> None:
        """Pass the drawn picture to the widget."""
        self._window.SwapBuffersOn()
        self._window.Frame()
        self._window.SwapBuffersOff()

    def render(self) -> None:  # type: ignore[override]
        self.update()

    # -- mouse and keys, which belong to the view and not to an interactor style of VTK

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        self._gestures.press(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        self._gestures.move(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        self._gestures.release(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        self._gestures.double_click(event)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        self._gestures.wheel(event)

    def enterEvent(self, event: QEnterEvent) -> None:  # noqa: N802 - Qt's name
        QWidget.enterEvent(self, event)

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802 - Qt's name
        self._gestures.leave()
        QWidget.leaveEvent(self, event)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802 - Qt's name
        event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:  # noqa: N802 - Qt's name
        event.ignore()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802 - Qt's name
        event.ignore()

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802 - Qt's name
        event.ignore()
