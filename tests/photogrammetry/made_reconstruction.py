"""The folder of a small reconstruction whose every number is known, made without reconstructing."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models.writing import write_model
from vomstudio.io.photos.cameras_file import Cameras, write_cameras
from vomstudio.io.photos.reading import read_photos
from vomstudio.photogrammetry.align import mapping, match_database
from vomstudio.photogrammetry.align.alignment import Alignment
from vomstudio.photogrammetry.align.features import Features
from vomstudio.photogrammetry.align.priors import Calibration
from vomstudio.photogrammetry.base.checkpoints import file_name
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.dense.depthmaps import DepthMap
from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto
from vomstudio.photogrammetry.pipeline.photo_results import save_undistorted
from vomstudio.photogrammetry.pipeline.report_data import tie_points

WIDE, HIGH = 320, 240
NAMES = ("a.jpg", "b.jpg", "c.jpg")
ORIGIN = (1000, 2000, 300)
MISS = np.array([0.3, -0.4])
"""By which every observation of the second photo is off, pixels."""
DISTANCE = 10.0
WEAK = "c.jpg"
"""Photo that is said to be weakly connected."""


@dataclass(frozen=True)
class Made:
    """rows : matches of a and b that agree; refused : one that does not"""

    out: Path
    photos: Path
    scene: SparseScene
    rows: np.ndarray
    refused: np.ndarray


def make(folder: Path) -> Made:
    """Three photos 2 m apart, which look north at a wall of speckles 10 m away."""
    import pycolmap

    rng = np.random.default_rng(4)
    photos, out = folder / "photos", folder / "reconstruction"
    photos.mkdir(parents=True)
    lens = Intrinsics("SIMPLE_RADIAL", WIDE, HIGH, (300.0, WIDE / 2, HIGH / 2, -0.02))
    look_north = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    views = []
    for k, name in enumerate(NAMES):
        pixels = rng.integers(60, 200, (HIGH // 8, WIDE // 8, 3), np.uint8)
        picture = Image.fromarray(pixels).resize((WIDE, HIGH), Image.Resampling.BILINEAR)
        exif = Image.Exif()
        # The last one was held upright.
        exif[0x0112] = 6 if k == 2 else 1
        picture.save(photos / name, exif=exif)
        centre = np.array([2.0 * k, 0.0, 0.0])
        views.append(View(name, lens, look_north, -look_north @ centre))

    count = 150
    points = np.column_stack(
        [rng.uniform(0, 4, count), np.full(count, DISTANCE), rng.uniform(-3, 3, count)]
    )
    seen = np.array([view.project(points) for view in views])
    seen[1] += MISS
    offsets = np.arange(0, 3 * count + 1, 3)
    scene = SparseScene(
        tuple(views),
        points,
        rng.integers(0, 255, (count, 3), np.uint8),
        np.zeros(count, np.float32),
        offsets.astype(np.int64),
        np.tile(np.arange(3, dtype=np.int32), count),
        seen.transpose(1, 0, 2).reshape(-1, 2).astype(np.float32),
        ORIGIN,
        "EPSG:32633",
        True,
    )
    scene = SparseScene(**{**scene.__dict__, "errors_px": mapping.point_errors(scene)})

    aligned = out / "work" / "alignment-0123456789abcdef"
    aligned.mkdir(parents=True)
    listed = read_photos(photos).photos
    features = []
    for k in range(3):
        keypoints = np.zeros((count + 20, 6), np.float32)
        keypoints[:count, :2] = seen[k]
        keypoints[count:, :2] = rng.uniform(0, [WIDE, HIGH], (20, 2))
        keypoints[:, [2, 5]] = 3.0
        descriptors = rng.integers(0, 255, (count + 20, 128), np.uint8)
        colors = np.zeros((count + 20, 3), np.uint8)
        features.append(Features(keypoints, descriptors, colors, WIDE, HIGH))
    match_database.open_database(aligned / "database.db", listed, features, ["k"] * 3)
    database = pycolmap.Database.open(aligned / "database.db")
    rows = np.column_stack([np.arange(100), np.arange(100)]).astype(np.uint32)
    refused = np.array([[120, 7]], np.uint32)
    for first, second, kept in ((1, 2, rows), (2, 3, rows[:12]), (1, 3, rows[:0])):
        tried = np.vstack([kept, refused])
        database.write_matches(first, second, tried)
        geometry = pycolmap.TwoViewGeometry()
        geometry.inlier_matches = kept
        geometry.config = 3 if len(kept) else 0
        database.write_two_view_geometry(first, second, geometry)
    database.close()

    calibration = Calibration(
        "SIMPLE_RADIAL",
        ("f", "cx", "cy", "k1"),
        lens.params,
        (1.5, 0.0, 0.0, 0.004),
        (
            (1.0, *[float("nan")] * 2, -0.95),
            *[(float("nan"),) * 4] * 2,
            (-0.95, *[float("nan")] * 2, 1.0),
        ),
        NAMES,
        "freed",
        (Finding("lens.focal-estimated", spread_deg=12.0),),
        297.0,
        12.0,
    )
    (aligned / "part0").mkdir()
    Alignment((scene,), (), 0.17, (calibration,), count, ()).save(aligned)

    framed = out / "work" / "frame-0123456789abcdef"
    framed.mkdir()
    scene.save(framed)
    residuals = [{"name": name, "error_m": 0.5 + k} for k, name in enumerate(NAMES[:2])]
    registration = {"method": "camera positions (GPS)", "rms_m": 1.1, "residuals": residuals}
    (framed / "stage.json").write_text(json.dumps({"registration": registration}))

    # A wall at right angles to the view: one depth, in the left half of the photo.
    ideal = View(NAMES[0], Intrinsics.pinhole(160, 120, 150.0, 80.0, 60.0), look_north, np.zeros(3))
    depth = np.zeros((120, 160), np.float32)
    depth[:, :80] = DISTANCE + np.linspace(-1, 1, 80, dtype=np.float32)
    normals = np.zeros((120, 160, 3), np.float32)
    normals[:, :80] = (0.0, 0.0, -1.0)
    confidence = np.where(depth > 0, 191, 0).astype(np.uint8)
    for stage in ("depths", "straight"):
        (out / "work" / f"{stage}-0123456789abcdef").mkdir()
    path = Path(f"{file_name(NAMES[0])}.npz")
    made = DepthMap(NAMES[0], ideal, depth, normals, confidence)
    made.save(out / "work" / "depths-0123456789abcdef" / path)
    with Image.open(photos / NAMES[0]) as image:
        image.resize((160, 120)).save(folder / "small.png")
    straight = UndistortedPhoto((folder / "small.png").read_bytes(), None, ideal)
    save_undistorted(out / "work" / "straight-0123456789abcdef" / path, straight)

    weak_names = frozenset({WEAK})
    cameras = Cameras(scene.views, photos, ORIGIN, scene.crs, weak_names=weak_names)
    write_cameras(out / "cameras.json", cameras)
    write_model(tie_points(scene), scene.crs, out / "sparse.ply")
    wall = rng.uniform([-2, DISTANCE, -3], [6, DISTANCE + 0.05, 3], (4000, 3))
    grey = rng.integers(90, 160, (4000, 1), np.uint8).repeat(3, axis=1)
    write_model(PointCloud(wall + ORIGIN, grey), scene.crs, out / "dense.ply")
    (out / "request.json").write_text(json.dumps({"photos": str(photos), "quality": "preview"}))
    return Made(out, photos, scene, rows.astype(np.int64), refused.astype(np.int64))
