"""Cameras of a reconstructed model's photos, drawn at their poses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Signal

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.geometry import transform
from vomstudio.geometry.frusta import Frustum, frusta
from vomstudio.project.records import Model
from vomstudio.rendering.qt.photo_cameras import PhotoCameras
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.studio.photos import PhotoLinks
from vomstudio.studio.tools.interaction_types import Button, Pointer, PointerEvent
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio

MatrixRows = tuple[tuple[float, ...], ...]
"""Rows of a 4 x 4 matrix."""


class CameraView(QObject):
    """Drawing of the cameras of the visible models.

    Attributes
    ----------
    camera_selected : Signal
        Emitted with the name of the photo whose camera was clicked.
    cameras_loaded : Signal
        Emitted when the cameras of a model have been read.
    """

    camera_selected = Signal(str)
    cameras_loaded = Signal()

    def __init__(self, studio: Studio, links: PhotoLinks) -> None:
        super().__init__()
        self._studio, self._links = studio, links
        self._cameras: PhotoCameras | None = None
        self._background = QtBackground(self)
        # File of each model, and frusta of each file in the frame of the model.
        self._files: dict[str, Path] = {}
        self._frusta: dict[Path, tuple[list[Frustum], tuple[int, int, int]]] = {}
        self._drawn_files: list[tuple[Path, MatrixRows]] = []
        studio.project_opened.connect(self._clear)
        studio.model_loaded.connect(self._load_cameras)
        links.changed.connect(self._reload_cameras)
        studio.edited.connect(lambda _: self.refresh())
        studio.visibility_changed.connect(lambda _: self.refresh())
        studio.display.changed.connect(
            lambda setting: self.refresh() if setting == "cameras" else None
        )

    def watch(self, viewport: Viewport) -> None:
        """Draw the cameras in a viewport."""
        self._cameras = viewport.photos
        viewport.pointer.connect(self._handle_pointer)
        for model_id in self._studio.models:
            self._load_cameras(model_id)

    def disabled_reason(self) -> Finding | None:
        """Return why no cameras can be shown, or None if cameras can be shown."""
        if not self._studio.models:
            return Finding("action.no-model")
        if not any(self._files.get(i) in self._frusta for i in self._studio.models):
            return Finding("cameras.none-beside-models")
        return None

    def folder(self) -> Path | None:
        """Return the folder of an open model's camera file, or None if no such file is loaded."""
        for model_id in self._studio.models:
            path = self._files.get(model_id)
            if path in self._frusta:
                return path.parent
        return None

    def _clear(self) -> None:
        self._files.clear()
        self._frusta.clear()
        self.refresh()

    def _load_cameras(self, model_id: str) -> None:
        record, open_model = self._studio.records.get(model_id), self._studio.models.get(model_id)
        if not isinstance(record, Model) or open_model is None:
            return
        path = self._links.cameras_path(model_id)
        if path is None:
            return
        self._files[model_id] = path
        bounds = open_model.data.bounds

        def store(cameras: tuple[list[Frustum], tuple[int, int, int]]) -> None:
            self._frusta[path] = cameras
            # The file may have changed.
            self._drawn_files = []
            self.refresh()
            self.cameras_loaded.emit()

        def warn(error: VomError) -> None:
            finding = Finding(
                "cameras.not-shown", model=record.name, reason=error, reason_code=error.code
            )
            self._studio.warn(finding)

        self._background.run(lambda: _read_frusta(path, bounds), store, warn)

    def _visible_files(self) -> list[tuple[Path, MatrixRows]]:
        """Return the camera files of the visible models, with the matrices to World.

        Models that share the same photos are listed once.
        """
        studio = self._studio
        if not studio.display.cameras or not studio.visible("models"):
            return []
        files: list[tuple[Path, MatrixRows]] = []
        for model_id, path in self._files.items():
            record = studio.records.get(model_id)
            if path not in self._frusta or not isinstance(record, Model):
                continue
            if model_id in studio.models and studio.visible(model_id):
                files.append((path, record.to_world))
        return list(dict.fromkeys(files))

    def _reload_cameras(self, model_id: str) -> None:
        """Load the cameras of a model again if another camera file has been selected."""
        if self._links.cameras_path(model_id) != self._files.get(model_id):
            self._load_cameras(model_id)

    def visible_frusta(self) -> list[Frustum]:
        """Return the frusta of the visible cameras in the World frame."""
        result = []
        for path, to_world in self._visible_files():
            local_frusta, origin = self._frusta[path]
            matrix = transform.matrix(to_world)
            result += [item.transform(matrix, origin) for item in local_frusta]
        return result

    def refresh(self) -> None:
        """Draw the visible cameras if they have changed."""
        files = self._visible_files()
        # Avoids needless updates: this runs at every edit, and new cameras redraw the whole
        # outcrop.
        if self._cameras is not None and files != self._drawn_files:
            self._drawn_files = files
            self._cameras.show(self.visible_frusta())

    def highlight_cameras(self, names: set[str]) -> None:
        """Highlight the cameras of the photos with the given names."""
        if self._cameras is not None:
            self._cameras.select(names)

    def frusta_points(self) -> FloatArray:
        """Return (n, 3) World points of the visible frusta."""
        points = [np.vstack([item.tip, item.corners]) for item in self.visible_frusta()]
        return np.concatenate([np.zeros((0, 3)), *points])

    def _handle_pointer(self, event: PointerEvent) -> None:
        is_clicked = event.kind is Pointer.CLICK and event.button is Button.LEFT
        if not is_clicked or self._studio.tool_name != "navigate" or self._cameras is None:
            return
        name = self._cameras.at(event.x, event.y)
        if name is not None:
            self.highlight_cameras({name})
            self._studio.info(Finding("camera.clicked", photo=name))
            self.camera_selected.emit(name)


def _read_frusta(path: Path, bounds: FloatArray) -> tuple[list[Frustum], tuple[int, int, int]]:
    from vomstudio.io.photos.own_cameras.reading import read_camera_file
    from vomstudio.io.photos.own_cameras.result import local_cameras

    cameras = local_cameras(read_camera_file(path, bounds))
    pyramids = frusta(cameras.views, bounds.mean(axis=0) - cameras.origin)
    weak_names = cameras.weak_names
    return [replace(item, is_weak=item.name in weak_names) for item in pyramids], cameras.origin
