"""Lifetime of the scene, from the import of VTK until the view is closed.

The import takes nearly a second, and runs in a thread once the window is visible.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.core.arrays import FloatArray
from vomstudio.rendering.qt.thread_calls import poster
from vomstudio.rendering.view.camera import Camera
from vomstudio.studio.background import Background

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene


_MAX_IMPORT_S = 60.0


class SceneLifetime(QObject):
    """Creation and release of the scene.

    Attributes
    ----------
    scene : Scene or None
        Scene, or None before its creation and after its release.
    is_closed : bool
        Whether the scene has been released.
    """

    started = Signal()

    def __init__(
        self, camera: Camera, fill_scene: Callable[[Scene], None], parent: QObject
    ) -> None:
        """Store `fill_scene`, which starts a new scene and passes it its first contents."""
        super().__init__(parent)
        self.scene: Scene | None = None
        self.is_closed = False
        self._camera, self._fill_scene = camera, fill_scene
        self._pending_jobs: list[Callable[[], None]] = []
        self._has_begun = False
        self._background = Background(poster(self), "vtk import", threads=1)

    def begin(self) -> None:
        """Start the import once the window is visible; further calls have no effect."""
        if not self._has_begun and not self.is_closed:
            self._has_begun = True
            QTimer.singleShot(0, self._import)

    def _import(self) -> None:
        self._background.run(_import_scene, self._start)
        self._background.run(_import_readers, lambda _: None)

    def _start(self, _: object) -> None:
        from vomstudio.rendering.scene.scene import Scene

        scene = Scene(self._camera)
        self._fill_scene(scene)
        self.scene = scene
        pending_jobs, self._pending_jobs = self._pending_jobs, []
        for job in pending_jobs:
            job()
        self.started.emit()

    def all_corners(self) -> FloatArray:
        """Return the World box corners (n, 3) of the visible contents; see `Scene.all_corners`."""
        return np.zeros((0, 3)) if self.scene is None else self.scene.all_corners()

    def call_when_started(self, job: Callable[[], None]) -> None:
        """Run a job now if the scene exists, or else when it has been created."""
        if self.scene is not None:
            job()
        else:
            self._pending_jobs.append(job)

    def stop(self) -> None:
        """Prevent the creation of the scene."""
        self.is_closed = True
        self._background.stop(wait_s=_MAX_IMPORT_S)
        self._pending_jobs.clear()

    def close(self) -> None:
        """Release VTK."""
        if self.scene is not None:
            self.scene.close()
            self.scene = None


def _import_scene() -> None:
    import vomstudio.rendering.prepare.preparation
    import vomstudio.rendering.scene.scene  # noqa: F401


def _import_readers() -> None:
    # Imported here because it is needed as soon as a model is opened.
    import PIL.JpegImagePlugin  # noqa: F401
    import vtkmodules.vtkFiltersCore  # noqa: F401
