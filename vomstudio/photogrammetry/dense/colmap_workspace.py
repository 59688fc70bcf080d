"""COLMAP dense workspace, for COLMAP's PatchMatch on CUDA.

The workspace follows COLMAP's documentation of its output format. No other module of this package
depends on COLMAP.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.photogrammetry.base.colmap import colmap, run_cancellable
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.dense.depthmaps import DepthMap
from vomstudio.photogrammetry.dense.pairs import DepthMapPlans
from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto


def has_cuda() -> bool:
    """Return whether the installed COLMAP supports a GPU."""
    return bool(colmap().has_cuda)


def compute_cuda_depth_maps(
    scene: SparseScene,
    pairs: DepthMapPlans,
    photos: Sequence[UndistortedPhoto],
    folder: Path,
    progress: Progress,
) -> list[DepthMap]:
    """Compute the depth maps of all plans with COLMAP's PatchMatch.

    Parameters
    ----------
    scene : SparseScene
    pairs : DepthMapPlans
    photos : sequence of UndistortedPhoto
        One photo for each view of the scene.
    folder : Path
        Empty folder for the workspace.
    progress : Progress

    Raises
    ------
    Cancelled
    GeometryError
        If a depth map differs in size from its photo.
    RuntimeError, ValueError
        As raised by COLMAP, if no GPU can be used or the computation fails.
    """
    pycolmap = colmap()
    # COLMAP uses the same pixel coordinates, so no shift is needed.
    files = write_workspace(folder, scene, photos, shift=0.0)
    lines = []
    for plan in pairs.plans:
        lines.append(files[plan.view])
        lines.append(", ".join(files[source.view] for source in plan.sources))
    (folder / "stereo" / "patch-match.cfg").write_text("\n".join(lines) + "\n", encoding="utf-8")
    options = pycolmap.PatchMatchOptions()
    options.depth_min = min(plan.near for plan in pairs.plans)
    options.depth_max = max(plan.far for plan in pairs.plans)
    options.geom_consistency = True
    depth_folder = folder / "stereo" / "depth_maps"
    run_cancellable(
        lambda token: pycolmap.patch_match_stereo(
            folder, options=options, cancellation_token=token
        ),
        progress,
        lambda: len(list(depth_folder.glob("*.geometric.bin"))),
    )
    maps = []
    for plan in pairs.plans:
        name = f"{files[plan.view]}.geometric.bin"
        depth = pycolmap.DepthMap()
        depth.read(folder / "stereo" / "depth_maps" / name)
        normal = pycolmap.NormalMap()
        normal.read(folder / "stereo" / "normal_maps" / name)
        maps.append(
            _convert_depth_map(photos[plan.view], depth.to_array(), normal.to_array(), plan)
        )
    return maps


def write_workspace(
    folder: Path, scene: SparseScene, photos: Sequence[UndistortedPhoto], *, shift: float
) -> list[str]:
    """Write images, pinhole cameras and tie points; COLMAP derives the overlap from these.

    Parameters
    ----------
    folder : Path
    scene : SparseScene
    photos : sequence of UndistortedPhoto
        One photo for each view of the scene.
    shift : float
        Offset that is added to the principal points.

    Returns
    -------
    list of str
        Names of the image files, in order.
    """
    import cv2

    pycolmap = colmap()
    for subfolder in ("images", "sparse", "stereo/depth_maps", "stereo/normal_maps"):
        (folder / subfolder).mkdir(parents=True)
    model = pycolmap.Reconstruction()
    feature_rows = np.zeros(len(scene.track_views), np.int64)
    files = [f"{number:06d}.png" for number in range(len(photos))]
    for number, (photo, file) in enumerate(zip(photos, files, strict=True), 1):
        lens = photo.view.intrinsics
        picture = photo.pixels()
        picture[~photo.valid_mask] = 0
        bgr = np.ascontiguousarray(picture[..., ::-1])
        (folder / "images" / file).write_bytes(cv2.imencode(".png", bgr)[1].tobytes())
        camera = pycolmap.Camera(
            model="PINHOLE",
            width=lens.width,
            height=lens.height,
            params=[*lens.focal, *(c + shift for c in lens.centre)],
            camera_id=number,
        )
        model.add_camera_with_trivial_rig(camera)
        image = pycolmap.Image()
        image.name, image.camera_id, image.image_id = file, number, number
        is_in_photo = scene.track_views == number - 1
        point_rows = scene.track_points[is_in_photo]
        feature_rows[is_in_photo] = np.arange(len(point_rows))
        pixels = photo.view.project(scene.points[point_rows])
        image.points2D = pycolmap.Point2DList([pycolmap.Point2D(xy) for xy in pixels])
        pose = pycolmap.Rigid3d(
            pycolmap.Rotation3d(np.asarray(photo.view.rotation, np.float64)),
            np.asarray(photo.view.translation, np.float64),
        )
        model.add_image_with_trivial_frame(image, pose)
    for point, xyz in enumerate(scene.points):
        track = pycolmap.Track()
        for row in range(scene.track_offsets[point], scene.track_offsets[point + 1]):
            track.add_element(int(scene.track_views[row]) + 1, int(feature_rows[row]))
        model.add_point3D(xyz, track, np.asarray(scene.colors[point], np.uint8))
    model.write(folder / "sparse")
    (folder / "stereo" / "fusion.cfg").write_text("\n".join(files) + "\n", encoding="utf-8")
    return files


def _convert_depth_map(photo: UndistortedPhoto, depth: Any, normal: Any, plan: Any) -> DepthMap:
    lens = photo.view.intrinsics
    depth, normal = np.array(depth, np.float32), np.array(normal, np.float32)
    if depth.shape != (lens.height, lens.width):
        raise GeometryError(
            Finding("dense.map-size", width=depth.shape[1], height=depth.shape[0]),
            file=photo.view.name,
        )
    is_valid = (depth > plan.near) & (depth < plan.far) & photo.valid_mask & normal.any(axis=2)
    depth[~is_valid] = 0.0
    normal[~is_valid] = 0.0
    # These depths are consistent with at least two other photos, or COLMAP would have dropped them.
    confidence = np.where(is_valid, 191, 0).astype(np.uint8)
    return DepthMap(photo.view.name, photo.view, depth, normal, confidence)
