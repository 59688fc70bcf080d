"""Libraries that take long to import, brought in by a thread once the window is on the screen."""

from __future__ import annotations

import threading

from PySide6.QtCore import QObject, Signal


class LateImport(QObject):
    """net_imported : what draws the net is there; all_imported : and all the rest. Both are sent by
    the thread."""

    net_imported = Signal()
    all_imported = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._thread: threading.Thread | None = None

    def begin(self) -> None:
        """Asked for again, it goes on as it is."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="net import", daemon=True)
            self._thread.start()

    def _work(self) -> None:
        import vomstudio.ui.analyse.stereonet_panel  # noqa: F401

        self.net_imported.emit()
        # Wanted as soon as a model is there, when its picture is wanted as well.
        import scipy.sparse.csgraph
        import scipy.spatial  # noqa: F401

        self.all_imported.emit()
