"""The photos of the open models, and their folders."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.errors import VomError
from vomstudio.core.files.regular import is_regular
from vomstudio.core.findings import Finding, finding_of
from vomstudio.core.signals import Signal
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.io.photos.cameras_file import FILE_NAME, find_photos, read_cameras
from vomstudio.project.edit import Edit
from vomstudio.project.records import Model
from vomstudio.studio.background import Background
from vomstudio.studio.models import Models
from vomstudio.studio.projects import Projects

if TYPE_CHECKING:
    from vomstudio.geometry.rays.raytree import RayTree
    from vomstudio.photogrammetry.inspect.photo_views import PhotoViews

_KEPT = "cameras"
# Of a cloud a line of sight meets points within so many times their usual spacing.
_REACH_SPACINGS = 1.0


@dataclass(frozen=True, eq=False)
class ModelPhotos:
    """The photos of one model; folder: where they lie, None where they were not found."""

    model_id: str
    name: str
    views: PhotoViews
    folder: Path | None

    def path(self, view: int) -> Path | None:
        """File of a view's photo; None where the photos were not found."""
        return None if self.folder is None else self.folder / self.views.views[view].name


class PhotoLinks:
    """The photos of the open models. changed: photos of a model were found, lost or moved with it.

    Nothing is read before `want`: preparing a model of millions of faces takes seconds.
    """

    def __init__(self, projects: Projects, models: Models, background: Background) -> None:
        self.changed: Signal[str] = Signal()
        self._projects, self._models, self._background = projects, models, background
        self._ready: dict[str, ModelPhotos] = {}
        self._trees: dict[str, tuple[object, RayTree]] = {}
        self._problems: dict[str, Finding] = {}
        self._wanted = False

    # --- asked -------------------------------------------------------------------------------
    def of(self, model_id: str) -> ModelPhotos | None:
        """The photos of a model; None where it has none or they are not read yet."""
        return self._ready.get(model_id)

    def models(self) -> list[str]:
        """The models that have photos, in the order of the project."""
        return [m.id for m in self._projects.of(Model) if m.id in self._ready]

    def busy(self) -> bool:
        """Whether photos of a model are being read."""
        return self._background.is_busy

    def problem(self, model_id: str) -> Finding | None:
        """Return why a model has no photos though it has cameras."""
        return self._problems.get(model_id)

    def want(self) -> None:
        """Search for photos from now on."""
        if not self._wanted:
            self._wanted = True
            for model_id in self._models.open:
                self.look(model_id)

    # --- told --------------------------------------------------------------------------------
    def open_cameras(self, model_id: str, path: Path) -> None:
        """Use this file of cameras for a model, and keep the choice with the project."""
        self._remember(model_id, cameras=self._projects.project.model_path(path))
        self._wanted = True
        self.look(model_id)

    def find_photos(self, model_id: str, folder: Path) -> None:
        """Use the photos of this folder for a model, and keep the choice with the project."""
        self._remember(model_id, photos=self._projects.project.model_path(folder))
        self.look(model_id)

    def forget_choices(self, model_id: str) -> None:
        """Use the cameras and photos beside the model again."""
        kept = self._projects.view(_KEPT, {})
        self._projects.keep_view(_KEPT, {id_: kept[id_] for id_ in kept if id_ != model_id})

    def _remember(self, model_id: str, **values: str) -> None:
        kept = self._projects.view(_KEPT, {})
        before = kept.get(model_id)
        new = {**kept, model_id: {**(before if isinstance(before, dict) else {}), **values}}
        self._projects.keep_view(_KEPT, new)

    # --- reading -----------------------------------------------------------------------------
    def cameras_path(self, model_id: str) -> Path | None:
        """The cameras that were chosen, else those beside the model's file."""
        record = self._projects.records.get(model_id)
        if not isinstance(record, Model):
            return None
        if (chosen := self._chosen(model_id, "cameras")) is not None:
            return chosen
        file = self._projects.project.find_model(record)
        beside = None if file is None else file.with_name(FILE_NAME)
        return beside if beside is not None and is_regular(beside) else None

    def _chosen(self, model_id: str, what: str) -> Path | None:
        """Inside the project paths are relative to it: it can be moved."""
        choices = self._projects.view(_KEPT, {}).get(model_id)
        kept = choices.get(what) if isinstance(choices, dict) else None
        if not isinstance(kept, str) or not kept or "\0" in kept:
            return None
        return self._projects.project.folder / kept

    def look(self, model_id: str) -> None:
        """Read the photos of a model that was opened, or whose file or cameras have moved."""
        opened, path = self._models.open.get(model_id), self.cameras_path(model_id)
        record = self._projects.records.get(model_id)
        if not self._wanted or opened is None or path is None or not isinstance(record, Model):
            return
        if isinstance(opened.data, StreamedCloud):
            self._problems[model_id] = Finding("model.cloud-too-large", model=record.name)
            return
        self._problems.pop(model_id, None)
        kept = self._trees.get(model_id)
        tree = kept[1] if kept is not None and kept[0] is opened.data else None
        chosen = self._chosen(model_id, "photos")
        # A project that was moved together with its photos.
        around = self._projects.project.folder.parent
        data, resolution = opened.data, opened.resolution or 0.0

        def refuse(error: VomError) -> None:
            self._ready.pop(model_id, None)
            self._problems[model_id] = finding_of(error)
            self.changed.emit(model_id)

        self._background.run(
            lambda: _read_photos(record, path, chosen, around, data, resolution, tree),
            partial(self._store, data),
            refuse,
            key=model_id,
        )
        self.changed.emit(model_id)

    def _store(self, data: object, photos: ModelPhotos) -> None:
        self._ready[photos.model_id] = photos
        self._trees[photos.model_id] = (data, photos.views.tree)
        self.changed.emit(photos.model_id)

    def edited(self, edit: Edit) -> None:
        """Forget the photos of removed models, and read those of moved ones anew."""
        for id_, after in edit.after.items():
            before = edit.before[id_]
            if isinstance(before, Model) and after is None:
                self._background.cancel(id_)
                self._ready.pop(id_, None)
                self._trees.pop(id_, None)
                self.changed.emit(id_)
            elif (
                isinstance(before, Model)
                and isinstance(after, Model)
                and (before.to_world != after.to_world or before.path != after.path)
            ):
                self.look(id_)

    def forget_all(self) -> None:
        """Forget all photos: another project is opened."""
        self._background.cancel_all()
        self._ready.clear()
        self._trees.clear()
        self._problems.clear()


def _read_photos(
    record: Model,
    path: Path,
    chosen: Path | None,
    around: Path,
    data: Mesh | PointCloud,
    resolution: float,
    tree: RayTree | None,
) -> ModelPhotos:
    # Kernels take a third of a second to import: not while the window starts.
    from vomstudio.geometry.rays.raytree import RayTree
    from vomstudio.photogrammetry.inspect.photo_views import PhotoViews

    cameras = read_cameras(path)
    if tree is None:
        tree = RayTree(data, _REACH_SPACINGS * resolution)
    # The first ray loads the kernels: not in the owner's thread.
    tree.cast(np.zeros(3), np.ones((1, 3)))
    views = PhotoViews(cameras, tree, np.asarray(record.to_world), resolution)
    first = () if chosen is None else (chosen,)
    folder = find_photos(cameras, path, first)
    folder = folder or find_photos(cameras, around / FILE_NAME)
    return ModelPhotos(record.id, record.name, views, folder)
