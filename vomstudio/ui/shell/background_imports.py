"""Libraries that take long to import: a thread imports them once the window is on the screen."""

from __future__ import annotations

import threading

from PySide6.QtCore import QObject, Signal


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

    def begin(self) -> None:
        """Start the thread; a second call changes nothing."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="net import", daemon=True)
            self._thread.start()

    def _work(self) -> None:
        import vomstudio.ui.analyse.stereonet_panel  # noqa: F401

        self.stereonet_imported.emit()
        # Wanted as soon as a model is there, when its picture is wanted as well.
        import scipy.sparse.csgraph
        import scipy.spatial  # noqa: F401

        self.all_imported.emit()
