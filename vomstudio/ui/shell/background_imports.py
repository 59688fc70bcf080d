"""Libraries that take long to import: a thread imports them once the window is on the screen."""

from __future__ import annotations

import threading
from contextlib import suppress

from PySide6.QtCore import QObject, QTimer, Signal


class BackgroundImports(QObject):
    """Imports slow libraries in a thread.

    stereonet_imported : the stereonet can be made; all_imported : everything has been imported.
    Both signals are sent by the thread.
    """

    stereonet_imported = Signal()
    all_imported = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._thread: threading.Thread | None = None
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self.begin)

    def begin(self) -> None:
        """Start the thread; a second call changes nothing."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="net import", daemon=True)
            self._thread.start()

    def begin_at_latest_in(self, milliseconds: int) -> None:
        """Start the thread then, if nobody has done so before."""
        self._timer.start(milliseconds)

    def do_not_begin(self) -> None:
        """Nobody wants it any more; what has begun goes on."""
        self._timer.stop()

    def _work(self) -> None:
        import vomstudio.ui.analyse.stereonet_panel  # noqa: F401

        # A window that was closed meanwhile has no signals any more.
        with suppress(RuntimeError):
            self.stereonet_imported.emit()
        # Wanted as soon as a model is there, when its picture is wanted as well.
        import scipy.sparse.csgraph
        import scipy.spatial  # noqa: F401

        with suppress(RuntimeError):
            self.all_imported.emit()
