"""Import of the libraries that an open model needs, in a thread."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QWidget

from vomstudio.ui.base.qt_background import QtBackground


class NetPlaceholder(QWidget):
    """Page of the net until its libraries have been imported."""

    appeared = Signal()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        self.appeared.emit()


class BackgroundImports(QObject):
    """Import of slow libraries in a thread.

    `begun` is emitted when the thread starts, `stereonet_imported` when the stereonet can be
    created, and `all_imported` when all libraries have been imported.
    """

    begun = Signal()
    stereonet_imported = Signal()
    all_imported = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._background = QtBackground(self, "net import", threads=1)
        self._has_begun = False
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self.begin)

    def begin(self) -> None:
        """Start the thread; further calls have no effect."""
        if not self._has_begun:
            self._has_begun = True
            self._background.run(_import_stereonet, lambda _: self.stereonet_imported.emit())
            self._background.run(_import_neighbours, lambda _: self.all_imported.emit())
            self.begun.emit()

    def start_deadline(self, deadline_ms: int) -> None:
        """Start the thread after a delay, unless it is started earlier."""
        self._timer.start(deadline_ms)

    def stop(self) -> None:
        """Prevent the start of the thread, or end it after the current import."""
        self._timer.stop()
        self._background.stop()


def _import_stereonet() -> None:
    import vomstudio.ui.panels.net.stereonet_panel  # noqa: F401


def _import_neighbours() -> None:
    # Needed as soon as a model is open, which is also when its picture must be drawn.
    import scipy.sparse.csgraph
    import scipy.spatial  # noqa: F401
