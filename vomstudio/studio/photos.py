"""Photos of the open models, and their folders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.signals import Signal
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.project.edit import Edit
from vomstudio.project.records import Model
from vomstudio.studio.background import Background
from vomstudio.studio.models import Models
from vomstudio.studio.notices import Notices
from vomstudio.studio.projects import Projects

if TYPE_CHECKING:
    from vomstudio.geometry.rays.raytree import RayTree
    from vomstudio.photogrammetry.inspect.photo_views import PhotoViews

VIEW_KEY = "cameras"
# Maximum distance of a line of sight from the points of a cloud that it meets, in point
# spacings.
_MAX_RAY_DISTANCE_SPACINGS = 1.0


@dataclass(frozen=True, eq=False)
class ModelPhotos:
    """Photos of a model.

    Attributes
    ----------
    files : mapping of str to Path
        Files of the photos that were found, by name of the view.
    warnings : tuple of Finding
        Findings about the camera file.
    """

    model_id: str
    name: str
    views: PhotoViews
    files: Mapping[str, Path]
    warnings: tuple[Finding, ...] = ()

    def path(self, view: int) -> Path | None:
        """Return the file of a view's photo, or None if it was not found."""
        return self.files.get(self.views.views[view].name)


class PhotoLinks:
    """Photos of the open models.

    No photos are read before `request_photos` is called, because preparing a model with millions of
    faces takes seconds.

    Attributes
    ----------
    changed : Signal
        Emitted when the photos of a model have been found, lost or moved.
    """

    def __init__(
        self, projects: Projects, models: Models, notices: Notices, background: Background
    ) -> None:
        self.changed: Signal[str] = Signal()
        self._projects, self._models = projects, models
        self._notices, self._background = notices, background
        self._ready: dict[str, ModelPhotos] = {}
        self._trees: dict[str, tuple[object, RayTree]] = {}
        self._problems: dict[str, Finding] = {}
        self._is_enabled = False

    # --- queries ------------------------------------------------------------------------------
    def of(self, model_id: str) -> ModelPhotos | None:
        """Return the photos of a model, or None if it has no photos or they are not read yet."""
        return self._ready.get(model_id)

    def models(self) -> list[str]:
        """Return the ids of the models that have photos, in project order."""
        return [m.id for m in self._projects.of(Model) if m.id in self._ready]

    def busy(self) -> bool:
        """Return whether photos of a model are being read."""
        return self._background.is_busy

    def problem(self, model_id: str) -> Finding | None:
        """Return why the photos of a model with cameras cannot be used, or None."""
        return self._problems.get(model_id)

    def request_photos(self) -> None:
        """Start to search for photos, now and whenever models change."""
        if not self._is_enabled:
            self._is_enabled = True
            for model_id in self._models.open_models:
                self.look(model_id)

    # --- choices of the user ------------------------------------------------------------------
    def open_cameras(self, model_id: str, path: Path) -> None:
        """Use a camera file for a model, and save the choice in the project."""
        self._remember(model_id, cameras=self._projects.project.model_path(path))
        self._is_enabled = True
        self.look(model_id)

    def find_photos(self, model_id: str, folder: Path) -> None:
        """Use the photos in a folder for a model, and save the choice in the project."""
        self._remember(model_id, photos=self._projects.project.model_path(folder))
        self.look(model_id)

    def forget_choices(self, model_id: str) -> None:
        """Discard the user's choices, and use the cameras and photos beside the model."""
        choices = self._projects.view(VIEW_KEY, {})
        self._projects.store_view(
            VIEW_KEY, {id_: choices[id_] for id_ in choices if id_ != model_id}
        )

    def _remember(self, model_id: str, **values: str) -> None:
        choices = self._projects.view(VIEW_KEY, {})
        choice = choices.get(model_id)
        new_choices = {
            **choices,
            model_id: {**(choice if isinstance(choice, dict) else {}), **values},
        }
        self._projects.store_view(VIEW_KEY, new_choices)

    # --- reading -----------------------------------------------------------------------------
    def cameras_path(self, model_id: str) -> Path | None:
        """Return the camera file selected for a model, or the one beside its file, or None."""
        record = self._projects.records.get(model_id)
        if not isinstance(record, Model):
            return None
        if (selected_path := self._selected_path(model_id, "cameras")) is not None:
            return selected_path
        from vomstudio.io.photos.own_cameras.reading import find_camera_file

        file = self._projects.project.find_model(record)
        return None if file is None else find_camera_file(file)

    def _selected_path(self, model_id: str, subject: str) -> Path | None:
        """Return the selected path of a model's cameras or photos, or None.

        Paths in the project are stored relative to it because the project can be moved.
        """
        choices = self._projects.view(VIEW_KEY, {}).get(model_id)
        choice = choices.get(subject) if isinstance(choices, dict) else None
        if not isinstance(choice, str) or not choice or "\0" in choice:
            return None
        return self._projects.project.folder / choice

    def look(self, model_id: str) -> None:
        """Read the photos of a model that was opened or whose file or cameras have changed."""
        open_model, path = self._models.open_models.get(model_id), self.cameras_path(model_id)
        record = self._projects.records.get(model_id)
        if (
            not self._is_enabled
            or open_model is None
            or path is None
            or not isinstance(record, Model)
        ):
            return
        if isinstance(open_model.data, StreamedCloud):
            self._problems[model_id] = Finding("model.cloud-too-large", model=record.name)
            return
        self._problems.pop(model_id, None)
        cached_tree = self._trees.get(model_id)
        tree = (
            cached_tree[1]
            if cached_tree is not None and cached_tree[0] is open_model.data
            else None
        )
        selected_path = self._selected_path(model_id, "photos")
        # The project was moved together with its photos.
        folder = self._projects.project.folder.parent
        data, resolution = open_model.data, open_model.resolution or 0.0

        def refuse(error: VomError) -> None:
            self._ready.pop(model_id, None)
            self._problems[model_id] = to_finding(error)
            self.changed.emit(model_id)

        self._background.run(
            lambda: _read_photos(record, path, selected_path, folder, data, resolution, tree),
            partial(self._store, data),
            refuse,
            key=model_id,
        )
        self.changed.emit(model_id)

    def _store(self, data: object, photos: ModelPhotos) -> None:
        known_photos = self._ready.get(photos.model_id)
        for finding in photos.warnings:
            if known_photos is None or finding not in known_photos.warnings:
                self._notices.warn(finding, finding.severity)
        self._ready[photos.model_id] = photos
        self._trees[photos.model_id] = (data, photos.views.tree)
        self.changed.emit(photos.model_id)

    def follow_edit(self, edit: Edit) -> None:
        """Discard the photos of removed models, and reread the photos of moved models."""
        for id_, record in edit.after.items():
            old_record = edit.before[id_]
            if isinstance(old_record, Model) and record is None:
                self._background.cancel(id_)
                self._ready.pop(id_, None)
                self._trees.pop(id_, None)
                self.changed.emit(id_)
            elif (
                isinstance(old_record, Model)
                and isinstance(record, Model)
                and (old_record.to_world != record.to_world or old_record.path != record.path)
            ):
                self.look(id_)

    def forget_all(self) -> None:
        """Discard all photos because another project is opened."""
        self._background.cancel_all()
        self._ready.clear()
        self._trees.clear()
        self._problems.clear()


def _read_photos(
    record: Model,
    path: Path,
    selected_path: Path | None,
    project_folder: Path,
    data: Mesh | PointCloud,
    resolution: float,
    tree: RayTree | None,
) -> ModelPhotos:
    # Imported late, because importing the kernels takes 0.3 s and would delay the start.
    from vomstudio.geometry.rays.raytree import RayTree
    from vomstudio.io.photos.own_cameras.photos import find_photos
    from vomstudio.io.photos.own_cameras.reading import read_camera_file
    from vomstudio.io.photos.own_cameras.result import local_cameras
    from vomstudio.photogrammetry.inspect.photo_views import PhotoViews

    cameras_of_model = read_camera_file(path, data.bounds)
    cameras = local_cameras(cameras_of_model)
    if tree is None:
        tree = RayTree(data, _MAX_RAY_DISTANCE_SPACINGS * resolution)
    # Runs in a thread, because the first ray loads the kernels.
    tree.cast(np.zeros(3), np.ones((1, 3)))
    views = PhotoViews(cameras, tree, np.asarray(record.to_world), resolution)
    folders = [folder for folder in (selected_path, cameras_of_model.photos) if folder is not None]
    names = list(cameras_of_model.views)
    files = find_photos(path, names, folders) or find_photos(project_folder / path.name, names)
    return ModelPhotos(record.id, record.name, views, files, cameras_of_model.warnings)
