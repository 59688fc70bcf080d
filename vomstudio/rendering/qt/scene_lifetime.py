"""The scene, from when VTK has been imported until the view is closed.

The import takes most of a second, so it is done in a thread once the window is on the screen.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from vomstudio.rendering.view.camera import Camera

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene


class SceneLife(QObject):
    """scene : None before it has started and after it has been closed; closed : it never will be
    there again"""

    started = Signal()
    _imported = Signal()

    def __init__(self, camera: Camera, furnish: Callable[[Scene], None], parent: QObject) -> None:
        """furnish : starts a scene and gives it what is to be seen from the first picture on."""
        super().__init__(parent)
        self.scene: Scene | None = None
        self.closed = False
        self._camera, self._furnish = camera, furnish
        self._waiting: list[Callable[[], None]] = []
        self._importer: threading.Thread | None = None
        self._imported.connect(self._start, Qt.ConnectionType.QueuedConnection)

    def begin(self) -> None:
        """The window is on the screen: import what draws; calling it again does nothing."""
        if self._importer is None and self.scene is None and not self.closed:
            self._importer = threading.Thread(target=self._import, name="vtk import", daemon=True)
            QTimer.singleShot(0, self._importer.start)

    def _import(self) -> None:
        import vomstudio.rendering.prepare.preparation
        import vomstudio.rendering.scene.scene  # noqa: F401 - so that the window's thread finds it ready

        if not self.closed:
            self._imported.emit()
        # Wanted as soon as a model is opened.
        import PIL.JpegImagePlugin  # noqa: F401
        import vtkmodules.vtkFiltersCore  # noqa: F401

    def _start(self) -> None:
        if self.scene is not None or self.closed:
            return
        from vomstudio.rendering.scene.scene import Scene

        scene = Scene(self._camera)
        self._furnish(scene)
        self.scene = scene
        waiting, self._waiting = self._waiting, []
        for job in waiting:
            job()
        self.started.emit()

    def when_started(self, job: Callable[[], None]) -> None:
        """Do this now or, where there is no scene yet, as soon as there is one."""
        if self.scene is not None:
            job()
        else:
            self._waiting.append(job)

    def stop(self) -> None:
        """Nothing starts any more."""
        self.closed = True
        if self._importer is not None and self._importer.is_alive():
            self._importer.join()
        self._waiting.clear()

    def close(self) -> None:
        """Release VTK."""
        if self.scene is not None:
            self.scene.close()
            self.scene = None
