"""From a folder of photos to a textured model: the stages, in their order, each one resumable."""

from __future__ import annotations

import contextlib
import hashlib
import json
import shutil
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio import __version__
from vomstudio.errors import GeometryError, InputError, TargetError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.photogrammetry.checkpoints import Checkpoints, Stage, file_name, key_of, write_whole
from vomstudio.photogrammetry.diary import Diary
from vomstudio.photogrammetry.scene import SparseScene
from vomstudio.photogrammetry.settings import Settings
from vomstudio.progress import Executor, Progress

if TYPE_CHECKING:
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.photos import Photo, PhotoFolder
    from vomstudio.photogrammetry.alignment import Alignment
    from vomstudio.photogrammetry.undistortion import Undistorted

RESULT = "reconstruction.json"
WORK = "work"

# A registration by camera GPS is told to be weak beyond this tilt.
_WEAK_DEG = 2.0


@dataclass(frozen=True)
class Outputs:
    """The files of a reconstruction below `folder`."""

    folder: Path

    @property
    def result(self) -> Path:
        return self.folder / RESULT

    @property
    def log(self) -> Path:
        return self.folder / "log.txt"

    @property
    def cameras(self) -> Path:
        return self.folder / "cameras.csv"

    @property
    def poses(self) -> Path:
        return self.folder / "cameras.json"

    @property
    def sparse(self) -> Path:
        return self.folder / "sparse.ply"

    @property
    def dense(self) -> Path:
        return self.folder / "dense.laz"

    @property
    def mesh(self) -> Path:
        return self.folder / "model.obj"

    @property
    def others(self) -> tuple[Path, ...]:
        return (self.folder / "model.glb", self.folder / "model.ply")

    @property
    def report(self) -> Path:
        return self.folder / "report.html"


def claim(out: Path) -> Outputs:
    """The folder `out` for a reconstruction: a new one, an empty one, or one that was begun before.

    Raises TargetError where something else is in it, or it cannot be made.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        strangers = [p for p in out.iterdir() if not p.name.startswith(".")]
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise TargetError(f"no folder can be made there ({reason})", file=out) from error
    if strangers and not (out / RESULT).exists() and not (out / WORK).is_dir():
        raise TargetError(
            "holds other files; name a new or empty folder, or one of an earlier reconstruction",
            file=out,
        )
    try:
        (out / WORK).mkdir(exist_ok=True)
    except OSError as error:
        raise TargetError(f"cannot be written ({error.strerror})", file=out) from error
    return Outputs(out)


def reconstruct(
    folder: Path, out: Path, settings: Settings, executor: Executor, progress: Progress
) -> dict[str, Any]:
    """Make a model of the photos in `folder`; what an earlier run finished is not done again.

    Returns the object that CLI.md promises for `reconstruct`, with more for the report; it is also
    written to `reconstruction.json`. Raises InputError for photos of which nothing can be made,
    TargetError for a disk that cannot hold it, and Cancelled.
    """
    outputs = claim(out)
    run = _Run(folder, outputs, settings, executor, Diary(outputs.log, progress))
    try:
        return run.all()
    finally:
        run.pause()


@dataclass(frozen=True)
class _Placed:
    scene: SparseScene
    registration: dict[str, Any]
    stage: Stage


class _Run:
    def __init__(
        self,
        folder: Path,
        outputs: Outputs,
        settings: Settings,
        executor: Executor,
        diary: Diary,
    ) -> None:
        self.folder, self.outputs = folder, outputs
        self.settings, self.executor, self.diary = settings, executor, diary
        self.checkpoints = Checkpoints(outputs.folder / WORK)
        self.facts: dict[str, Any] = {}

    def all(self) -> dict[str, Any]:
        self.diary.log(f"VOM Studio {__version__}, {self.settings.as_dict()}")
        photos = self._photos()
        alignment, aligned = self._align(photos)
        scene, placed = self._place(alignment, photos, aligned)
        undistorted, flat = self._undistort(scene, photos, placed)
        maps = self._depths(scene, undistorted, flat)
        cloud, fused = self._fuse(undistorted, maps)
        mesh, surfaced = self._surface(cloud, scene, fused)
        textured = self._texture(mesh, undistorted, surfaced)
        return self._write(photos, alignment, scene, cloud, textured)

    def pause(self) -> None:
        self.diary.end_stage()
        for stage in self.checkpoints.stages:
            with contextlib.suppress(TargetError):
                stage.pause()

    # ------------------------------------------------------------------------------------------
    def _photos(self) -> PhotoFolder:
        from vomstudio.io.photos import read_photos

        found = read_photos(self.folder, self.diary)
        for name, reason in found.skipped:
            self.diary.note(f"{name} was left out: {reason}")
        for warning in found.warnings:
            self.diary.note(warning)
        if len(found.photos) < 2:
            raise InputError(
                "holds one photo only; a model needs at least two that overlap, better ten",
                file=self.folder,
            )
        self.hashes = {}
        self.diary.stage("Checking photos", len(found.photos))
        for number, photo in enumerate(found.photos):
            self.diary.step(number)
            self.hashes[photo.name] = _hash(photo)
        return found

    def _align(self, photos: PhotoFolder) -> tuple[Alignment, Stage]:
        from vomstudio.photogrammetry.alignment import Alignment, Options, align

        size, seed = self.settings.steps.align_px, self.settings.seed
        stage = self.checkpoints.stage(
            "alignment", _versions("pycolmap"), size, seed, self.hashes, _cameras_said(photos)
        )
        if not stage.done:
            options = Options(max_size=size, seed=seed, threads=self.settings.threads)
            align(photos.photos, stage.folder, options, self.executor, self.diary)
            stage.finish()
        return Alignment.load(stage.folder), stage

    def _place(self, alignment: Alignment, photos: PhotoFolder, aligned: Stage) -> _Placed:
        """The largest part in World where control or GPS allow it, else upright and local."""
        from vomstudio.photogrammetry import georeference
        from vomstudio.photogrammetry.local_frame import upright

        if not alignment.parts:
            raise GeometryError(
                "none of the photos could be joined to another: neighbours must show the same "
                "rock from a step aside; vomstudio check says which of them do",
                file=self.folder,
            )
        settings = self.settings
        marks = (settings.control, settings.marks)
        stage = self.checkpoints.stage(
            "frame", aligned.key, settings.crs, *(p and _hash_file(p) for p in marks)
        )
        if not stage.done:
            self.diary.stage("Registering")
            part, facts = alignment.parts[0], {}
            try:
                if settings.control is not None:
                    scene, report = georeference.by_control(
                        part, settings.control, settings.marks, settings.crs
                    )
                else:
                    scene, report = georeference.by_gps(part, photos.photos, settings.crs)
                facts = report.as_dict()
            except GeometryError as error:
                if settings.control is not None or settings.crs is not None:
                    raise
                scene = upright(part, photos.photos)
                facts = {"refused": error.message}
            scene.save(stage.folder)
            stage.finish(registration=facts)
        for warning in stage.facts["registration"].get("warnings", []):
            self.diary.note(warning)
        if refused := stage.facts["registration"].get("refused"):
            self.diary.note(f"The model keeps a local frame without scale: {refused}")
        return _Placed(SparseScene.load(stage.folder), stage.facts["registration"], stage)

    def _undistort(
        self, scene: SparseScene, photos: PhotoFolder, placed: Stage
    ) -> tuple[Kept[Undistorted], Stage]:
        """Photos without distortion, of the size in which every pixel gets a depth."""
        from vomstudio.photogrammetry import undistortion

        size = self._dense_size()
        stage = self.checkpoints.stage("straight", placed.key, versions("cv2"), size)
        by_name = {photo.name: photo for photo in photos.photos}

        def task(number: int) -> undistortion.UndistortTask:
            view = scene.views[number]
            photo = by_name[view.name]
            mask = None if photo.mask is None else photo.mask.read_bytes()
            return undistortion.UndistortTask(photo.path.read_bytes(), mask, view, size)

        kept = Kept(stage.folder, [v.name for v in scene.views], save_straight, load_straight)
        self._each("Straightening photos", stage, kept, undistortion.undistort, task)
        return kept.at(stage.folder), stage

    def _depths(
        self, scene: SparseScene, straight: Kept[Undistorted], flat: Stage
    ) -> tuple[Kept[DepthMap], Stage]:
        from vomstudio.photogrammetry import depthmaps, pairs

        stage = self.checkpoints.stage("depths", flat.key, versions("cv2", "numba"))
        plans = {plan.name: plan for plan in pairs.plan(scene)}
        names = [view.name for view in scene.views if view.name in plans]
        numbers = {view.name: number for number, view in enumerate(scene.views)}

        def task(number: int) -> depthmaps.DepthTask:
            plan = plans[names[number]]
            sources = tuple(straight[numbers[name]] for name in plan.sources)
            return depthmaps.DepthTask(straight[numbers[plan.name]], sources, plan)

        kept = Kept(stage.folder, names, save_depths, load_depths)
        self._each("Finding depths", stage, kept, depthmaps.depth_map, task)
        return kept.at(stage.folder), stage

    def _each(
        self,
        title: str,
        stage: Stage,
        kept: Kept[Result],
        work: Callable[[Item], Result],
        task: Callable[[int], Item],
    ) -> None:
        """Do what is not done yet of a stage whose results are one for each photo."""
        if stage.done:
            return
        left = [number for number in range(len(kept)) if not kept.has(number)]
        self.diary.stage(title, len(kept))
        progress = Ahead(self.diary, len(kept) - len(left))
        for done, result in self.executor.map(work, map(task, left), progress):
            kept.put(left[done], result)
        stage.finish()

    def _fuse(
        self, straight: Kept[Undistorted], maps: Kept[DepthMap], depths: Stage
    ) -> tuple[PointCloud, Stage]:
        from vomstudio.photogrammetry import fusion

        stage = self.checkpoints.stage("cloud", depths.key)
        if not stage.done:
            cloud = fusion.fuse(straight, maps, fusion.Options(), self.diary)
            write_whole(stage.folder / "cloud.npz", lambda path: save_cloud(path, cloud))
            stage.finish(points=len(cloud.points))
        return load_cloud(stage.folder / "cloud.npz"), stage

    def _surface(self, cloud: PointCloud, fused: Stage) -> tuple[Mesh, Stage]:
        from vomstudio.photogrammetry import surface

        faces = self.settings.steps.faces
        stage = self.checkpoints.stage("surface", fused.key, versions("open3d"), faces)
        if not stage.done:
            options = surface.Options(faces=faces, threads=self.settings.threads)
            mesh = surface.make_surface(cloud, options, self.diary)
            write_whole(stage.folder / "mesh.npz", lambda path: save_mesh(path, mesh))
            stage.finish(faces=len(mesh.faces))
        return load_mesh(stage.folder / "mesh.npz"), stage

    def _write(self) -> None:
        pass
