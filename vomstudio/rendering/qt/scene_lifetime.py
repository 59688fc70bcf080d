"""The scene, from when VTK has been imported until the view is closed.

The import takes most of a second, so it is done in a thread once the window is on the screen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.rendering.qt.thread_calls import poster
from vomstudio.rendering.view.camera import Camera
from vomstudio.studio.background import Background

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene


_IMPORT_S = 60.0


class SceneLife(QObject):
    """scene : None before it has started and after it has been closed; closed : it never will be
    there again"""

    started = Signal()

    def __init__(self, camera: Camera, furnish: Callable[[Scene], None], parent: QObject) -> None:
        """furnish : starts a scene and gives it what is to be seen from the first picture on."""
        super().__init__(parent)
        self.scene: Scene | None = None
        self.closed = False
        self._camera, self._furnish = camera, furnish
        self._waiting: list[Callable[[], None]] = []
        self._begun = False
        self._background = Background(poster(self), "vtk import", threads=1)

    def begin(self) -> None:
        """The window is on the screen: import what draws; calling it again does nothing."""
        if not self._begun and not self.closed:
            self._begun = True
            QTimer.singleShot(0, self._import)

    def _import(self) -> None:
        self._background.run(_import_scene, self._start)
        self._background.run(_import_readers, lambda _: None)

    def _start(self, _: object) -> None:
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
        self._background.stop(wait_s=_IMPORT_S)
        self._waiting.clear()

    def close(self) -> None:
        """Release VTK."""
        if self.scene is not None:
            self.scene.close()
            self.scene = None


def _import_scene() -> None:
    import vomstudio.rendering.prepare.preparation
    import vomstudio.rendering.scene.scene  # noqa: F401


def _import_readers() -> None:
    # Needed as soon as a model is opened.
    import PIL.JpegImagePlugin  # noqa: F401
    import vtkmodules.vtkFiltersCore  # noqa: F401
