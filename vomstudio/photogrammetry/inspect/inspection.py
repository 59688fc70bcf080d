"""Data of a finished reconstruction: pairs, cameras, residuals and depth maps.

Functions with the parameter `out` read the folder of a reconstruction without changing it. Except
for `coverage`, they raise InputError if a stage is unfinished or damaged. Pixels are those of the
photos as stored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import ByteArray, Float32Array, FloatingArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.files.disk_errors import damage_reason
from vomstudio.core.files.regular import read_json
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.photogrammetry.align import mapping, match_database
from vomstudio.photogrammetry.align.alignment import Alignment
from vomstudio.photogrammetry.base.checkpoints import file_name
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.base.stage_folders import stage_folder

MIN_STRONG_MATCHES = 50
"""Pairs with fewer verified matches are weak."""

_ALIGNMENT = to_translate("aligned photos")
_POSES = to_translate("poses")
_DEPTHS = to_translate("depth maps")
NO_DEPTH_COLOR = (58, 60, 64)
"""Colour of pixels without a depth."""


def _stage(out: Path, name: str, results: str) -> Path:
    """Return the folder of a finished stage; `results` names its content in the message."""
    folder = stage_folder(out, name)
    if folder is None:
        raise InputError(Finding("reconstruct.not-yet", results=tr(results)), file=out)
    return folder


def _aligned_photos(folder: Path) -> list[tuple[str, int, int]]:
    """Return name, width and height of the photos in the order of the alignment."""
    try:
        rows = read_json(folder / "database.json")["photos"]
        return [(str(row[0]), int(row[1]), int(row[2])) for row in rows]
    except (OSError, ValueError, TypeError, KeyError, IndexError) as error:
        raise InputError(
            Finding("alignment.damaged", reason=damage_reason(error)),
            file=folder,
        ) from error


def overview(out: Path) -> dict[str, Any]:
    """Return the overview of an alignment as JSON values.

    It contains the `photos` in the order of the alignment, the `pairs` of their rows with the
    numbers of matches and of verified matches, the `cameras`, and the registration.
    """
    folder = _stage(out, "alignment", _ALIGNMENT)
    alignment = Alignment.load(folder)
    frame_folder = _stage(out, "frame", _POSES)
    scene = SparseScene.load(frame_folder)
    scene_facts = _read_facts(frame_folder)
    database = folder / "database.db"
    names = _aligned_photos(folder)
    counts = match_database.match_counts(database)
    features = match_database.feature_counts(database)
    registration = scene_facts.get("registration", {})
    gps = {row["name"]: row["error_m"] for row in registration.get("residuals", [])}
    depths = stage_folder(out, "depths")
    reasons = {name: reason.message for name, reason in alignment.unregistered_photos}
    views = {view.name: row for row, view in enumerate(scene.views)}
    parts = {view.name: k for k, part in enumerate(alignment.parts) for view in part.views}
    lengths = np.linalg.norm(mapping.residuals(scene), axis=1)
    photos = []
    for row, (name, width, height) in enumerate(names):
        view_errors = lengths[scene.track_views == views[name]] if name in views else np.zeros(0)
        view_errors = view_errors[np.isfinite(view_errors)]
        photos.append(
            {
                "name": name,
                "width": width,
                "height": height,
                "features": features.get(row, 0),
                "part": parts.get(name),
                "reason": reasons.get(name),
                "tie_points": len(view_errors),
                "error_px": float(np.median(view_errors)) if len(view_errors) else None,
                "largest_px": float(view_errors.max()) if len(view_errors) else None,
                "gps_m": gps.get(name),
                "has_depths": depths is not None and _depth_path(depths, name).exists(),
            }
        )
    return {
        "folder": _photo_folder(out),
        "photos": photos,
        "pairs": [[i, j, *counts[i, j]] for i, j in sorted(counts)],
        "weak_below": MIN_STRONG_MATCHES,
        "cameras": [_camera(camera) for camera in alignment.cameras],
        "reprojection_error_px": _finite_or_none(alignment.reprojection_error_px),
        "tie_points": len(scene.points),
        "scaled": scene.scaled,
        "crs": scene.crs,
        "registration": {k: v for k, v in registration.items() if k not in ("residuals", "points")},
    }


def _read_facts(folder: Path) -> dict[str, Any]:
    try:
        content = read_json(folder / "stage.json")
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def _photo_folder(out: Path) -> str | None:
    try:
        request = read_json(out / "request.json")
        return str(request["photos"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _finite_or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _camera(camera: Any) -> dict[str, Any]:
    return {
        "model": camera.model,
        "names": list(camera.names),
        "values": list(camera.values),
        "sigma": [_finite_or_none(value) for value in camera.sigma],
        "correlation": [[_finite_or_none(value) for value in row] for row in camera.correlation],
        "photos": list(camera.photos),
        "focal": camera.focal,
        "reason": " ".join(reason.message for reason in camera.reasons),
        "exif_px": camera.exif_px,
        "convergence_deg": camera.convergence_deg,
        "strongest": None
        if camera.strongest_correlation is None
        else list(camera.strongest_correlation),
    }


# ------------------------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class PhotoPair:
    """Features and matches of two photos.

    Attributes
    ----------
    left, right : (n, 2) ndarray
        Positions of all features of each photo, in pixels.
    matches : (m, 2) ndarray
        Verified matches, as rows of `left` and `right`.
    refused : (k, 2) ndarray
        Rejected matches, as rows of `left` and `right`.
    """

    left: Float32Array
    right: Float32Array
    matches: IntArray
    refused: IntArray


def pair(out: Path, a: str, b: str) -> PhotoPair:
    """Return the features and matches of two photos."""
    folder = _stage(out, "alignment", _ALIGNMENT)
    names = [name for name, _, _ in _aligned_photos(folder)]
    for name in (a, b):
        if name not in names:
            raise InputError(Finding("reconstruct.photo-not-aligned", photo=name), file=out)
    left, right, all_rows, verified_rows = match_database.read_pair_matches(
        folder / "database.db", names.index(a), names.index(b)
    )
    verified_pairs = {(int(i), int(j)) for i, j in verified_rows}
    rejected_matches = np.array(
        [row for row in all_rows.tolist() if tuple(row) not in verified_pairs], np.int64
    )
    return PhotoPair(left, right, verified_rows, rejected_matches.reshape(-1, 2))


def residual_vectors(out: Path, name: str) -> tuple[Float32Array, Float32Array]:
    """Return pixels (n, 2) of tie points in a photo, and their residuals (n, 2) in pixels.

    Residuals are observed minus projected positions. Both arrays are empty if the photo has no
    pose.
    """
    scene = SparseScene.load(_stage(out, "frame", _POSES))
    row = next((k for k, view in enumerate(scene.views) if view.name == name), None)
    if row is None:
        return np.zeros((0, 2), np.float32), np.zeros((0, 2), np.float32)
    is_in_view = scene.track_views == row
    pixels = scene.track_pixels[is_in_view]
    misclosures = pixels - scene.views[row].project(scene.points[scene.track_points[is_in_view]])
    is_finite = np.isfinite(misclosures).all(axis=1)
    return pixels[is_finite].astype(np.float32), misclosures[is_finite].astype(np.float32)


# ------------------------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class DepthPictures:
    """Depth map of a photo as pictures, all of the same size (h, w).

    Attributes
    ----------
    photo : (h, w, 3) array
        Undistorted photo; black if it is no longer stored.
    depth : (h, w) float32 array
        Depths; 0 if unknown.
    low, high : float
        Depths of the first and last colour.
    colors, confidence, normals : (h, w, 3) uint8 array
        Colours of the depths, of the confidence, and of the normals in the model's frame (see
        `normal_colors`).
    coverage : float
        Share of the photo's usable pixels that have a depth.
    """

    photo: ByteArray
    depth: Float32Array
    low: float
    high: float
    colors: ByteArray
    confidence: ByteArray
    normals: ByteArray
    coverage: float


def _depth_path(folder: Path, name: str) -> Path:
    return folder / f"{file_name(name)}.npz"


def depth_pictures(out: Path, name: str) -> DepthPictures:
    """Return the depth map of a photo as pictures."""
    from vomstudio.photogrammetry.dense.depthmaps import DepthMap
    from vomstudio.photogrammetry.pipeline.photo_results import load_undistorted

    path = _depth_path(_stage(out, "depths", _DEPTHS), name)
    if not path.exists():
        raise InputError(Finding("dense.no-neighbour", photo=name))
    depth_map = DepthMap.load(path)
    photo = np.zeros((*depth_map.depth.shape, 3), np.uint8)
    is_usable = np.ones(depth_map.depth.shape, bool)
    undistorted_folder = stage_folder(out, "straight")
    if undistorted_folder is not None and _depth_path(undistorted_folder, name).exists():
        undistorted = load_undistorted(_depth_path(undistorted_folder, name))
        if undistorted.pixels().shape == photo.shape:
            photo, is_usable = undistorted.pixels(), undistorted.valid_mask
    has_depth = depth_map.depth > 0
    low, high = depth_range(depth_map.depth)
    table = color_table()
    normals = normal_colors(depth_map.normals @ depth_map.view.rotation)
    confidence = table[depth_map.confidence]
    for picture in (normals, confidence):
        picture[~has_depth] = NO_DEPTH_COLOR
    return DepthPictures(
        photo,
        depth_map.depth,
        low,
        high,
        depth_colors(depth_map.depth, low, high, table),
        confidence,
        normals,
        float((has_depth & is_usable).sum() / max(1, is_usable.sum())),
    )


def coverage(out: Path, name: str) -> float | None:
    """Return the share of usable pixels with a depth, or None without a readable depth map."""
    from vomstudio.photogrammetry.pipeline.photo_results import load_undistorted

    folder = stage_folder(out, "depths")
    if folder is None or not _depth_path(folder, name).exists():
        return None
    try:
        with open_arrays(_depth_path(folder, name)) as arrays:
            has_depth = arrays["depth"] > 0
        undistorted_folder = stage_folder(out, "straight")
        if undistorted_folder is not None:
            usable_pixels = load_undistorted(_depth_path(undistorted_folder, name)).valid_mask
            if usable_pixels.shape == has_depth.shape:
                return float((has_depth & usable_pixels).sum() / max(1, usable_pixels.sum()))
    except (OSError, ValueError, KeyError, EOFError):
        return None
    return float(has_depth.mean())


def depth_range(depth: Float32Array) -> tuple[float, float]:
    """Return the 1 % and 99 % quantiles of the depths; (0, 1) if there are no depths."""
    known_depth = depth[depth > 0]
    if not len(known_depth):
        return 0.0, 1.0
    low, high = (float(value) for value in np.percentile(known_depth, (1, 99)))
    return (low, high) if high > low else (low * 0.999, low * 1.001)


def color_table() -> ByteArray:
    """Return the viridis table (256, 3)."""
    from matplotlib import colormaps

    table = colormaps["viridis"].resampled(256)(np.arange(256), bytes=True)
    return np.ascontiguousarray(table[:, :3])


def depth_colors(depth: Float32Array, low: float, high: float, table: ByteArray) -> ByteArray:
    """Return colours (h, w, 3) of depths; pixels without a depth are NO_DEPTH_COLOR."""
    color_rows = np.clip((depth - low) / (high - low) * len(table), 0, len(table) - 1).astype(
        np.intp
    )
    picture = np.asarray(table[color_rows])
    picture[depth <= 0] = NO_DEPTH_COLOR
    return picture


def normal_colors(normals: FloatingArray) -> ByteArray:
    """Return colours (..., 3) of unit normals (..., 3) in the model's frame.

    The hue is the dip direction (0 for north, clockwise). Colours are paler for gentle dips and
    darker for overhangs.
    """
    x, y, z = np.moveaxis(np.asarray(normals, np.float32), -1, 0)
    hue = (np.degrees(np.arctan2(x, y)) % 360.0) / 60.0
    saturation = np.clip(np.hypot(x, y), 0, 1)
    value = np.where(z < 0, 1.0 + 0.55 * np.clip(z, -1, 0), 1.0)
    # Convert hue, saturation and value to RGB (Smith 1978).
    parts = [
        value * (1 - saturation * np.clip(np.minimum(k, 4 - k), 0, 1))
        for k in ((5 + hue) % 6, (3 + hue) % 6, (1 + hue) % 6)
    ]
    return np.asarray(np.round(255 * np.stack(parts, axis=-1)), np.uint8)
