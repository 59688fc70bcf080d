"""Cameras and tie points as files of COLMAP and nerfstudio.

COLMAP's `images.txt` has poses from the frame to the camera (x right, y down, z forward), and
`points3D.txt` the tie points with the photos that see them (COLMAP documentation, "Output Format").
A matrix of `transforms.json` is from the camera (x right, y up, z backward) to the frame
(nerfstudio documentation, "Data conventions").
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.files.atomic import atomic_group, atomic_write, check_target
from vomstudio.core.findings import Finding
from vomstudio.core.results import Result
from vomstudio.geometry.cameras import CAMERA_MODELS, Intrinsics, View
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.registration_file import read_registration
from vomstudio.io.models.writing import write_model
from vomstudio.io.photos.cameras_file import FILE_NAME, Cameras, read_cameras
from vomstudio.io.photos.own_cameras.photos import find_photos
from vomstudio.io.photos.own_cameras.reading import is_camera_file, read_camera_file
from vomstudio.io.photos.own_cameras.result import ModelCameras
from vomstudio.photogrammetry.base.colmap import colmap
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.base.stage_folders import stage_folder

_COLMAP_FILES = ("cameras.txt", "images.txt", "points3D.txt", "rigs.txt", "frames.txt")
_AXES = np.diag([1.0, -1.0, -1.0])
"""Transforms camera axes with y down and z forward to axes with y up and z backward."""
_TIE_POINTS = "sparse.ply"
_SUPPORTED_PARAMETERS = ("k1", "k2", "k3", "p1", "p2")
"""Distortion parameters that transforms.json can store for a lens other than a fisheye."""


@dataclass(frozen=True)
class CameraExport(Result):
    """Files with cameras for another program.

    Parameters
    ----------
    files : tuple of Path
    photos, points : int
        Number of photos with a pose, and of tie points.
    frame : str
        "world", or "local" for coordinates relative to ``origin``.
    crs : str or None
        CRS of the World frame.
    origin : tuple of int
        World coordinates of the origin of the local coordinates; 0 for "world".
    warnings : tuple of Finding
    """

    files: tuple[Path, ...]
    photos: int
    points: int
    frame: str
    crs: str | None
    origin: tuple[int, int, int]
    warnings: tuple[Finding, ...] = field(default=())


def export_cameras(
    source: str | Path, target: str | Path, *, world: bool = False, force: bool = False
) -> CameraExport:
    """Write the cameras and tie points of a reconstruction for another program.

    Parameters
    ----------
    source : str or Path
        Folder of a reconstruction by this program, or a camera file of any supported program.
    target : str or Path
        ``NAME.json`` for nerfstudio, otherwise a folder for COLMAP's text files.
    world : bool
        Whether to write World coordinates. They are computed from the origin of the cameras and the
        registration in the folder of `source`.
    force : bool
        Whether to replace existing files.

    Raises
    ------
    InputError
        If the cameras cannot be read.
    UsageError
        With the code ``cameras.no-world`` if `world` is set and the cameras are not registered.
    TargetError
        If a file cannot be written, or exists and `force` is not set.
    """
    source, target = Path(source), Path(target)
    cameras, warnings = _read_cameras(source)
    scene = _load_scene(source, cameras)
    if world:
        scene = _scene_in_world(scene, source)
    if target.suffix.lower() == ".json":
        names = [view.name for view in scene.views]
        path = source / FILE_NAME if source.is_dir() else source
        photos = find_photos(path, names, (path.parent / cameras.photos,))
        files, lens_warnings = _write_transforms(target, scene, photos, force=force)
        warnings += lens_warnings
    else:
        files = _write_colmap(target, scene, force=force)
    return CameraExport(
        files=files,
        photos=len(scene.views),
        points=len(scene.points),
        frame="world" if world else "local",
        crs=scene.crs,
        origin=scene.origin,
        warnings=warnings,
    )


# --- reading --------------------------------------------------------------------------------------
def _load_scene(source: Path, cameras: Cameras) -> SparseScene:
    """Return cameras and tie points, with tracks if the stage files still exist."""
    folder = source if source.is_dir() else source.parent
    stage = stage_folder(folder, "frame")
    if stage is not None:
        scene = SparseScene.load(stage)
        names = {view.name for view in scene.views}
        if scene.origin == cameras.origin and names == {view.name for view in cameras.views}:
            return scene
    points, colors = np.zeros((0, 3)), np.zeros((0, 3), np.uint8)
    path = folder / _TIE_POINTS
    if path.is_file():
        data = read_model(path).data
        tie_points = data.vertices if isinstance(data, Mesh) else data.points
        points = np.asarray(tie_points, np.float64) - cameras.origin
        if data.colors is not None:
            colors = np.asarray(data.colors, np.uint8)
        else:
            colors = np.full(points.shape, 128, np.uint8)
    return SparseScene(
        views=cameras.views,
        points=points,
        colors=colors,
        errors_px=np.zeros(len(points), np.float32),
        track_offsets=np.zeros(len(points) + 1, np.int64),
        track_views=np.zeros(0, np.int32),
        track_pixels=np.zeros((0, 2), np.float32),
        origin=cameras.origin,
        crs=cameras.crs,
        scaled=cameras.is_scaled,
    )


def _read_cameras(source: Path) -> tuple[Cameras, tuple[Finding, ...]]:
    path = source / FILE_NAME if (source / FILE_NAME).is_file() else source
    if path.name == FILE_NAME and is_camera_file(path):
        return read_cameras(path), ()
    foreign_cameras: ModelCameras = read_camera_file(source)
    if not foreign_cameras.views:
        raise InputError(Finding("cameras.no-poses"), file=foreign_cameras.path)
    return Cameras(
        tuple(foreign_cameras.views.values()), foreign_cameras.photos or Path(".")
    ), foreign_cameras.warnings


def _scene_in_world(scene: SparseScene, source: Path) -> SparseScene:
    """Return a scene in World coordinates. Raises UsageError if its position is unknown."""
    folder = source if source.is_dir() else source.parent
    origin = np.array(scene.origin, np.float64)
    scale, rotation, shift, crs = 1.0, np.eye(3), origin, scene.crs
    files = sorted(folder.glob("*.registration.json"))
    if files:
        registration = read_registration(files[0]).registration
        matrix = np.array(registration.matrix, np.float64)
        scale = float(np.cbrt(np.linalg.det(matrix[:3, :3])))
        rotation = matrix[:3, :3] / scale
        shift = matrix[:3, :3] @ origin + matrix[:3, 3]
        crs = registration.frame.crs
    elif not (scene.scaled or scene.crs is not None):
        raise UsageError(Finding("cameras.no-world"), file=source, field="--world")
    views = tuple(view.moved(scale, rotation, shift) for view in scene.views)
    points = scale * scene.points @ rotation.T + shift
    return replace(scene, views=views, points=points, origin=(0, 0, 0), crs=crs, scaled=True)


# --- writing --------------------------------------------------------------------------------------
def _write_colmap(folder: Path, scene: SparseScene, *, force: bool) -> tuple[Path, ...]:
    model = _colmap_model(scene)
    with tempfile.TemporaryDirectory(prefix="vomstudio-") as scratch_folder:
        model.write_text(scratch_folder)
        written_files = [name for name in _COLMAP_FILES if (Path(scratch_folder) / name).is_file()]
        folder.mkdir(parents=True, exist_ok=True)
        paths = tuple(folder / name for name in written_files)
        with atomic_group(paths, force) as temporaries:
            for name, temporary in zip(written_files, temporaries, strict=True):
                shutil.copyfile(Path(scratch_folder) / name, temporary)
    return paths


def _colmap_model(scene: SparseScene) -> Any:
    """Convert the scene to a COLMAP reconstruction."""
    pycolmap = colmap()
    model = pycolmap.Reconstruction()
    numbers: dict[Intrinsics, int] = {}
    for view in scene.views:
        lens = view.intrinsics
        if lens in numbers:
            continue
        numbers[lens] = len(numbers) + 1
        model.add_camera_with_trivial_rig(
            pycolmap.Camera(
                model=lens.model,
                width=lens.width,
                height=lens.height,
                params=list(lens.params),
                camera_id=numbers[lens],
            )
        )
    feature_rows = np.zeros(len(scene.track_views), np.int64)
    for number, view in enumerate(scene.views, 1):
        image = pycolmap.Image()
        image.name, image.image_id = view.name, number
        image.camera_id = numbers[view.intrinsics]
        is_in_view = scene.track_views == number - 1
        feature_rows[is_in_view] = np.arange(np.count_nonzero(is_in_view))
        pixels = np.asarray(scene.track_pixels[is_in_view], np.float64)
        image.points2D = pycolmap.Point2DList([pycolmap.Point2D(xy) for xy in pixels])
        pose = pycolmap.Rigid3d(
            pycolmap.Rotation3d(np.asarray(view.rotation, np.float64)),
            np.asarray(view.translation, np.float64),
        )
        model.add_image_with_trivial_frame(image, pose)
    for point, position in enumerate(scene.points):
        track = pycolmap.Track()
        for row in range(scene.track_offsets[point], scene.track_offsets[point + 1]):
            track.add_element(int(scene.track_views[row]) + 1, int(feature_rows[row]))
        number = model.add_point3D(position, track, np.asarray(scene.colors[point], np.uint8))
        model.point3D(number).error = float(scene.errors_px[point])
    return model


def _write_transforms(
    path: Path, scene: SparseScene, photos: Mapping[str, Path], *, force: bool
) -> tuple[tuple[Path, ...], tuple[Finding, ...]]:
    check_target(path, force=force)
    frames = [_frame_entry(view, photos.get(view.name), path.parent) for view in scene.views]
    content: dict[str, Any] = {"camera_model": "OPENCV", "frames": frames}
    files = [path]
    if len(scene.points):
        points = path.with_name(f"{path.stem}_points.ply")
        content["ply_file_path"] = points.name
        cloud = PointCloud(scene.points, colors=scene.colors)
        write_model(cloud, None, points, force=force, axes=scene.axes)
        files.append(points)
    with atomic_write(path, force) as temporary:
        temporary.write_text(json.dumps(content, indent=1, ensure_ascii=False), "utf-8")
    simplified_photos = sorted(
        {v.name for v in scene.views if not _is_supported_lens(v.intrinsics)}
    )
    warnings = (
        (Finding("cameras.lenses-simplified", photos=simplified_photos),)
        if simplified_photos
        else ()
    )
    return tuple(files), warnings


def _frame_entry(view: View, photo: Path | None, folder: Path) -> dict[str, Any]:
    """Return the frame of a photo, with the path of the photo relative to the file if known."""
    matrix = np.eye(4)
    matrix[:3, :3] = view.rotation.T @ _AXES
    matrix[:3, 3] = view.centre
    lens = view.intrinsics
    values = dict(zip(CAMERA_MODELS[lens.model], lens.params, strict=True))
    is_fisheye = lens.model == "OPENCV_FISHEYE"
    used_names = ("k1", "k2", "k3", "k4") if is_fisheye else _SUPPORTED_PARAMETERS
    name = view.name if photo is None else _relative_path(photo, folder)
    return {
        "file_path": name,
        "w": lens.width,
        "h": lens.height,
        "fl_x": float(lens.focal[0]),
        "fl_y": float(lens.focal[1]),
        "cx": float(lens.centre[0]),
        "cy": float(lens.centre[1]),
        **({"camera_model": "OPENCV_FISHEYE"} if is_fisheye else {}),
        **{key: float(values[key]) for key in used_names if key in values},
        "transform_matrix": matrix.tolist(),
    }


def _is_supported_lens(lens: Intrinsics) -> bool:
    values = dict(zip(CAMERA_MODELS[lens.model], lens.params, strict=True))
    is_full = lens.model == "FULL_OPENCV"
    return not (is_full and any(values[key] != 0.0 for key in ("k4", "k5", "k6")))


def _relative_path(photo: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(photo, folder)).as_posix()
    except ValueError:
        # The photos are on another drive.
        return photo.as_posix()
