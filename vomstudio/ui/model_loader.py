"""Models on their way from a file to the window: read in a worker process, mapped in a thread."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from PySide6.QtCore import QObject, Qt, Signal

from vomstudio.errors import VomError
from vomstudio.geometry.brush import CloudSurface, MeshSurface, surface_of
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io import model_cache
from vomstudio.jobs.events import Failed
from vomstudio.ui.job_bridge import Job, JobBridge


@dataclass(eq=False)
class OpenModel:
    """The data of a model that has been read. crs and content_hash are the file's."""

    data: Mesh | PointCloud
    surface: MeshSurface | CloudSurface
    warnings: tuple[str, ...]
    resolution: float | None
    crs: str | None
    content_hash: str

    @property
    def kind(self) -> Literal["mesh", "cloud"]:
        return "mesh" if isinstance(self.data, Mesh) else "cloud"


Then = Callable[[OpenModel], None]


class ModelLoader(QObject):
    """`problem` says in a sentence what could not be opened."""

    problem = Signal(str)
    _mapped = Signal(str, object, object)

    def __init__(self, jobs: JobBridge) -> None:
        super().__init__()
        self._jobs = jobs
        self._running: dict[str, Job | None] = {}
        self._mapped.connect(self._hand_over, Qt.ConnectionType.QueuedConnection)

    def load(self, key: str, path: Path, cache: Path, then: Then) -> None:
        """Read `path` and call `then` in the GUI's thread. A key that is being loaded is not loaded
        twice."""
        if key in self._running:
            return

        def failed(event: Failed) -> None:
            self._running.pop(key, None)
            if not event.cancelled:
                self.problem.emit(event.message)

        self._running[key] = self._jobs.submit(
            "models",
            "load_model",
            {"path": str(path), "cache": str(cache)},
            title=f"Opening {path.name}",
            on_done=lambda result: self._map(key, path, result, then),
            on_failed=failed,
        )

    def forget_all(self) -> None:
        """Nothing that is on its way arrives any more."""
        for job in self._running.values():
            if job is not None:
                self._jobs.cancel(job)
        self._running.clear()

    def _map(self, key: str, path: Path, result: dict[str, Any], then: Then) -> None:
        if key not in self._running:
            return
        # Checking a large cache touches every page of it: not in the GUI's thread.
        self._running[key] = None
        threading.Thread(target=self._map_in_thread, args=(key, path, result, then)).start()

    def _map_in_thread(self, key: str, path: Path, result: dict[str, Any], then: Then) -> None:
        try:
            loaded = model_cache.open_cached(Path(result["folder"]))
        except VomError as error:
            self._mapped.emit(key, f"{path.name} cannot be kept at hand: {error}", then)
            return
        data = loaded.data
        surface = surface_of(data)
        opened = OpenModel(
            data,
            surface,
            tuple(result["warnings"]),
            result["resolution"],
            result["crs"],
            result["content_hash"],
        )
        self._mapped.emit(key, opened, then)
        surface.build()

    def _hand_over(self, key: str, outcome: OpenModel | str, then: Then) -> None:
        if key not in self._running:
            return
        del self._running[key]
        if isinstance(outcome, str):
            self.problem.emit(outcome)
        else:
            then(outcome)
