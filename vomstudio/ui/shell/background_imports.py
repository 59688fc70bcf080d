"""Libraries that take long to import: a thread imports them once the window is on the screen."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.ui.base.qt_background import QtBackground


class BackgroundImports(QObject):
    """Imports slow libraries in a thread.

    stereonet_imported : the stereonet can be created; all_imported : everything has been imported.
    """

    stereonet_imported = Signal()
    all_imported = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._background = QtBackground(self, "net import", threads=1)
        self._begun = False
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self.begin)

    def begin(self) -> None:
        """Start the thread; a second call changes nothing."""
        if not self._begun:
            self._begun = True
            self._background.run(_import_stereonet, lambda _: self.stereonet_imported.emit())
            self._background.run(_import_neighbours, lambda _: self.all_imported.emit())

    def begin_at_latest_in(self, milliseconds: int) -> None:
        """Start the thread then, if it has not been started before."""
        self._timer.start(milliseconds)

    def stop(self) -> None:
        """Do not start the thread, or end it after the library that it imports."""
        self._timer.stop()
        self._background.stop()


def _import_stereonet() -> None:
    import vomstudio.ui.panels.net.stereonet_panel  # noqa: F401


def _import_neighbours() -> None:
    # Needed as soon as a model is there, when its picture is needed as well.
    import scipy.sparse.csgraph
    import scipy.spatial  # noqa: F401
