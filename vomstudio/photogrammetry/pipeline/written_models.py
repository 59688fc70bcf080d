"""Files of a reconstruction for other programs: cameras, tie points, cloud and model."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.files.atomic import atomic_write
from vomstudio.core.files.containment import make_folder, require_inside
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.photogrammetry.base.background import RockExtent
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.pose_errors import PoseErrors
from vomstudio.photogrammetry.pipeline.outputs import Outputs
from vomstudio.photogrammetry.pipeline.report_data import tie_points

if TYPE_CHECKING:
    from vomstudio.photogrammetry.align.alignment import Alignment


def write_camera_files(
    outputs: Outputs,
    photos: Path,
    alignment: Alignment,
    scene: SparseScene,
    rock: RockExtent | None = None,
    pose_errors: PoseErrors | None = None,
) -> None:
    """Write cameras and tie points of all parts before the depth maps are computed.

    Files of an earlier run are replaced.
    """
    from vomstudio.io.models.writing import write_model
    from vomstudio.io.photos.cameras_file import Cameras, write_cameras, write_cameras_csv

    errors = {} if pose_errors is None else pose_errors.errors_by_name(scene)
    weak_names = frozenset() if pose_errors is None else pose_errors.weak_names(scene)
    cameras = Cameras(scene.views, photos, scene.origin, scene.crs, scene.scaled, weak_names)
    write_cameras_csv(outputs.cameras, cameras, errors, force=True)
    write_cameras(outputs.poses, cameras, force=True)
    write_model(
        tie_points(scene, rock), scene.crs, outputs.sparse_cloud, force=True, axes=scene.axes
    )
    # Remove the parts of an earlier run, which markers may have joined since.
    for folder in outputs.folder.glob("part[0-9]*"):
        require_inside(folder, outputs.folder)
        for name in (outputs.poses.name, outputs.sparse_cloud.name):
            (folder / name).unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            folder.rmdir()
    for number, part in enumerate(alignment.parts[1:], start=2):
        folder = outputs.folder / f"part{number}"
        make_folder(folder, outputs.folder)
        cameras = Cameras(part.views, photos)
        write_cameras(folder / outputs.poses.name, cameras, force=True)
        write_model(
            tie_points(part), None, folder / outputs.sparse_cloud.name, force=True, axes=part.axes
        )


def write_models(
    outputs: Outputs, scene: SparseScene, cloud: PointCloud, textured_mesh: Mesh, progress: Progress
) -> None:
    """Write the cloud and the textured mesh in the World frame."""
    from vomstudio.io.models.writing import write_model

    progress.stage(tr("Writing the model"), 2 + len(outputs.other_models))
    world = replace(cloud, points=cloud.points + scene.origin)
    write_model(world, scene.crs, outputs.dense, force=True, axes=scene.axes)
    mesh = replace(textured_mesh, vertices=textured_mesh.vertices + scene.origin)
    for written_count, path in enumerate((outputs.mesh, *outputs.other_models), start=1):
        progress.step(written_count)
        write_model(mesh, scene.crs, path, force=True, axes=scene.axes)
    if scene.crs is not None:
        from pyproj import CRS

        with atomic_write(outputs.mesh.with_suffix(".prj"), True) as path:
            path.write_text(CRS.from_user_input(scene.crs).to_wkt(), encoding="utf-8")


def write_registrations(outputs: Outputs, result: Mapping[str, Any]) -> None:
    """Write the registration of `reconstruction.json` beside mesh and cloud.

    Models without external observations have no registration; files of an earlier run are removed.
    """
    from vomstudio.io.models.reconstruction_file import result_registration
    from vomstudio.io.models.registration_file import registration_path, write_registration

    # Convert as readers of the file do.
    names = ("registration", "frame", "scaled")
    text = json.dumps({name: result[name] for name in names}, default=_to_plain_value)
    registration = result_registration(json.loads(text), outputs.folder.name)
    is_known = registration.rotation_covariance() is not None
    for models in ((outputs.mesh, *outputs.other_models), (outputs.dense,)):
        if is_known:
            write_registration(registration, models, force=True)
        else:
            registration_path(models[0]).unlink(missing_ok=True)


def write_json(path: Path, value: dict[str, Any]) -> None:
    """Write a result as JSON, with arrays as lists and findings as objects."""
    path.write_text(json.dumps(value, indent=1, default=_to_plain_value), encoding="utf-8")


def _to_plain_value(value: Any) -> Any:
    if isinstance(value, Finding):
        return value.to_dict()
    return value.tolist() if hasattr(value, "tolist") else str(value)
