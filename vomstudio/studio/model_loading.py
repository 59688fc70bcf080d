"""Loading of models: a worker process reads the file, and a thread reads its cache."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

from vomstudio.core.errors import VomError
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal
from vomstudio.core.threads import lower_priority, start_thread
from vomstudio.core.words import tr
from vomstudio.geometry.brush import CloudSurface, MeshSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import POINT_BUDGET
from vomstudio.geometry.streaming.surfaces import create_surface
from vomstudio.io.models import copc, model_cache
from vomstudio.io.models.opening import file_hash
from vomstudio.studio.background import Background, Request
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.model_tasks import (
    LOAD_MODEL,
    PREVIEW_MODEL,
    CachedModel,
    ModelFile,
    PreviewPoints,
    PreviewRequest,
)
from vomstudio.studio.owner_thread import FIRST_PICTURE_DELAY_S, TimerFactory
from vomstudio.studio.running_jobs import Jobs, RunningJob


@dataclass(eq=False)
class OpenModel:
    """Data of a loaded model, with the CRS and hash of its file."""

    data: Mesh | PointCloud
    surface: MeshSurface | CloudSurface
    warnings: tuple[Finding, ...]
    resolution: float | None
    crs: str | None
    content_hash: str

    @property
    def kind(self) -> Literal["mesh", "cloud"]:
        """Kind of the model."""
        return "mesh" if isinstance(self.data, Mesh) else "cloud"

    def add_fields(self, fields: Mapping[str, np.ndarray]) -> bool:
        """Add computed fields with values (n,) for all points to those of the file.

        Views show them too, because they share the data. Returns False if the number of points
        differs, as it does for a streamed cloud.
        """
        data = self.data
        count = len(data.vertices) if isinstance(data, Mesh) else len(data.points)
        model_fields = data.fields
        if not isinstance(model_fields, dict) or any(
            len(values) != count for values in fields.values()
        ):
            return False
        model_fields.update(fields)
        return True

    def remove_fields(self, names: Iterable[str]) -> None:
        """Remove fields that were added by `add_fields`."""
        model_fields = self.data.fields
        if isinstance(model_fields, dict):
            for name in names:
                model_fields.pop(name, None)


LoadCallback = Callable[[OpenModel], None]


PREVIEW_SUFFIXES = (".las", ".laz")
PREVIEW_BYTES = 8_000_000
"""Smaller files are read faster than a preview can be computed."""


class ModelLoader:
    """Loader of models.

    Attributes
    ----------
    problem : Signal
        Emits the reason why a model could not be opened.
    conversion_available : Signal
        Emits the file of a model that is not metric, a suitable CRS, and the error.
    previewed : Signal
        Emits the key of a large cloud that is being read, and a sample of its points.
    ended : Signal
        Emits the key of a preview that is no longer needed.
    """

    def __init__(
        self,
        jobs: Jobs,
        background: Background,
        stream_background: Background,
        later: TimerFactory,
        budget: Callable[[], int] = lambda: POINT_BUDGET,
    ) -> None:
        """Create a loader.

        Parameters
        ----------
        jobs : Jobs
        background : Background
            Reads the caches of models; the process waits for it.
        stream_background : Background
            Starts the streaming of clouds. The threads that unpack points later have the same
            priority.
        later : TimerFactory
        budget : callable
            Returns the maximum number of points of a cloud in memory; a larger COPC file is
            streamed.
        """
        self.problem: Signal[Finding | VomError] = Signal()
        self.conversion_available: Signal[Path, str, VomError] = Signal()
        self.previewed: Signal[str, PointCloud] = Signal()
        self.ended: Signal[str] = Signal()
        self._jobs, self._background, self._streams = jobs, background, stream_background
        self._budget = budget
        self._running_jobs: dict[str, RunningJob | None] = {}
        self._unbuilt_surfaces: list[MeshSurface | CloudSurface] = []
        self._build_timer = later(FIRST_PICTURE_DELAY_S, self._build_surfaces)

    @property
    def busy(self) -> bool:
        """Whether a model is being loaded."""
        return bool(self._running_jobs)

    def load(self, key: str, path: Path, cache: Path, finished_callback: LoadCallback) -> None:
        """Read a file unless it is being read; call `finished_callback` in the owner's thread."""
        if key in self._running_jobs:
            return

        if copc.point_count(path) > self._budget():
            self._stream(key, path, finished_callback)
            return

        def handle_failure(event: Failed) -> None:
            self._running_jobs.pop(key, None)
            self.ended.emit(key)
            if event.cancelled:
                return
            if crs := event.error.get("suggested_crs"):
                self.conversion_available.emit(path, str(crs), event.to_error())
            else:
                self.problem.emit(event.to_error())

        self._start_preview(key, path, cache)
        self._running_jobs[key] = self._jobs.submit(
            LOAD_MODEL,
            ModelFile(path, cache),
            title=tr("Opening {file}", file=path.name),
            on_done=lambda result: self._fetch(key, path, result, finished_callback),
            on_failed=handle_failure,
        )

    def _stream(self, key: str, path: Path, callback: LoadCallback) -> None:
        """Open a cloud as a stream: further levels are read when the camera needs them."""
        self._running_jobs[key] = None

        def read(request: Request[OpenModel]) -> OpenModel:
            cloud = copc.stream(path, self._budget())
            request.deliver(partial(self.previewed.emit, key, cloud.overview()))
            # The hash that identifies the file is computed while the first levels are shown.
            content_hash = file_hash(path, lambda: not request.is_stale)
            crs, warnings = copc.read_crs(path)
            request.check()
            surface = create_surface(cloud)
            surface.build()
            spacing = cloud.store.median_spacing
            return OpenModel(cloud, surface, warnings, spacing, crs, content_hash)

        self._streams.run_request(
            read,
            partial(self._hand_over, key, callback),
            lambda error: self._report_failure(key, error),
        )

    def _start_preview(self, key: str, path: Path, cache: Path) -> None:
        """Request a sample of a large cloud, to be shown before all points are read."""
        if (
            path.suffix.lower() not in PREVIEW_SUFFIXES
            or model_cache.cache_folder(path, cache).exists()
        ):
            return
        try:
            if path.stat().st_size < PREVIEW_BYTES:
                return
            descriptor, name = tempfile.mkstemp(".npz", "vomstudio-")
        except OSError:
            # The error is reported when the file itself is read.
            return
        os.close(descriptor)
        out = Path(name)

        def show_preview(preview: PreviewPoints) -> None:
            if not preview.points or key not in self._running_jobs:
                out.unlink(missing_ok=True)
                return
            self._background.run(
                partial(_read_preview, out),
                lambda cloud: self._show_preview(key, cloud),
                lambda _: None,
                expected=(OSError, ValueError, KeyError),
            )

        self._jobs.submit(
            PREVIEW_MODEL,
            PreviewRequest(path, out),
            title=tr("Previewing {file}", file=path.name),
            on_done=show_preview,
            on_failed=lambda _: out.unlink(missing_ok=True),
            is_quiet=True,
        )

    def _show_preview(self, key: str, cloud: PointCloud) -> None:
        if key in self._running_jobs:
            self.previewed.emit(key, cloud)

    def forget_all(self) -> None:
        """Cancel the loading of all models."""
        for key in self._running_jobs:
            self.ended.emit(key)
        self._background.cancel_all()
        self._streams.cancel_all()
        self._build_timer.stop()
        self._unbuilt_surfaces.clear()
        for job in self._running_jobs.values():
            if job is not None:
                self._jobs.cancel(job)
        self._running_jobs.clear()

    def _fetch(
        self, key: str, path: Path, cached_model: CachedModel, callback: LoadCallback
    ) -> None:
        if key not in self._running_jobs:
            return
        # Runs in a thread, because reading a large cache takes long.
        self._running_jobs[key] = None

        def read() -> OpenModel:
            data = model_cache.read_transfer_folder(cached_model.folder).data
            # Computed here because the owner's thread needs the bounds often, and they take 0.1
            # s for ten million points.
            _ = data.bounds
            return OpenModel(
                data,
                create_surface(data),
                cached_model.warnings,
                cached_model.resolution,
                cached_model.crs,
                cached_model.content_hash,
            )

        def refuse(error: VomError) -> None:
            finding = Finding(
                "model.not-cached", file=path.name, reason=error, reason_code=error.code
            )
            self._report_failure(key, finding)

        self._background.run(read, partial(self._hand_over, key, callback), refuse)

    def _hand_over(self, key: str, callback: LoadCallback, opened_model: OpenModel) -> None:
        del self._running_jobs[key]
        callback(opened_model)
        self._unbuilt_surfaces.append(opened_model.surface)
        self._build_timer.start()
        self.ended.emit(key)

    def _report_failure(self, key: str, reason: Finding | VomError) -> None:
        del self._running_jobs[key]
        self.problem.emit(reason)
        self.ended.emit(key)

    def _build_surfaces(self) -> None:
        surfaces, self._unbuilt_surfaces = self._unbuilt_surfaces, []
        start_thread(_build_all, surfaces, name="surfaces", daemon=False)


def _read_preview(path: Path) -> PointCloud:
    try:
        with open_arrays(path) as arrays:
            colors = arrays.get("colors")
            fields = {"intensity": arrays["intensity"]} if "intensity" in arrays else {}
            return PointCloud(arrays["points"], colors, fields=fields)
    finally:
        path.unlink(missing_ok=True)


def _build_all(surfaces: list[MeshSurface | CloudSurface]) -> None:
    lower_priority(19)
    for surface in surfaces:
        surface.build()
