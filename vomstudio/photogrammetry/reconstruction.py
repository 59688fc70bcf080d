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
