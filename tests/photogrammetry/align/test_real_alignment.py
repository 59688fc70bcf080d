"""Alignments of photo sets that somebody surveyed by other means."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from vomstudio.core.progress import SilentProgress
from vomstudio.io.control.control_files import read_control, read_marks
from vomstudio.io.photos.photo import Photo
from vomstudio.io.photos.reading import read_photos
from vomstudio.photogrammetry.align.alignment import Alignment, AlignmentOptions, align
from vomstudio.photogrammetry.georeferencing.control import place_by_control
from vomstudio.photogrammetry.georeferencing.georeference import place_by_gps
from vomstudio.studio.jobs.executors import Threads

pytestmark = pytest.mark.slow
OPTIONS = AlignmentOptions(max_size=1600, threads=2)


def placed(folder: Path, work: Path, count: int) -> tuple[Sequence[Photo], Alignment]:
    """All `count` photos of a folder, aligned."""
    photos = read_photos(folder).photos
    aligned = align(photos, work / "work", OPTIONS, Threads(2), SilentProgress())
    assert aligned.registered_photo_count == len(photos) == count
    return photos, aligned


def test_a_lake_shore_placed_by_gps_agrees_with_an_independent_cloud(
    data_dir: Path, tmp_path: Path
) -> None:
    import laspy
    from scipy.spatial import cKDTree

    folder = data_dir / "brighton_beach"
    photos, aligned = placed(folder, tmp_path, 18)
    # Debian's COLMAP 3.8 on the same photos at the same size: 7515 points at 0.814 px.
    assert aligned.tie_point_count >= 7515
    scene, report = place_by_gps(aligned.parts[0], photos)
    assert not report.adjusted
    cloud = laspy.read(folder / "model.laz")
    known = np.column_stack([cloud.x, cloud.y, cloud.z])
    found = scene.points + scene.origin
    distance, row = cKDTree(known[:, :2]).query(found[:, :2], distance_upper_bound=0.5)
    near = np.isfinite(distance)
    assert near.sum() > 5000
    higher = found[near, 2] - known[row[near], 2]
    # What GPS of a drone leaves in height; the shape is far better.
    assert abs(np.median(higher)) < 1.0
    assert np.median(np.abs(higher - np.median(higher))) < 0.12


def test_cameras_of_a_wall_placed_by_marks_are_at_their_true_positions(
    data_dir: Path, tmp_path: Path
) -> None:
    folder = data_dir / "saint_martin"
    _photos, aligned = placed(folder, tmp_path, 4)
    # Debian's COLMAP 3.8 on the same photos at the same size: 4996 points at 0.247 px.
    assert aligned.tie_point_count >= 5020
    assert aligned.reprojection_error_px < 0.247
    control = read_control(folder / "Ground-Pts3D.xml")
    marks = read_marks(folder / "GroundMeasure.xml")
    scene, report = place_by_control(aligned.parts[0], control, marks, threads=2)
    assert report.control_rms_m is not None
    assert report.control_rms_m < 0.05
    # Six points on a wall do not tell a focal length that is 4.5 % short: that is said, and the
    # cameras, 4.8 m away, are too near by as much.
    assert report.decisions[0].code == "lens.ground-held"
    assert report.decisions[0].values["focal_px"] == pytest.approx(2016, abs=0.5)
    for view in scene.views:
        name = f"Orientation-{view.name.rsplit('/', 1)[-1]}.xml"
        stated = ElementTree.parse(folder / "orientation" / name).find(".//Externe/Centre")
        assert stated is not None
        truth = _three(stated.text or "")
        assert np.linalg.norm(view.centre + scene.origin - truth) < 0.25


def _three(text: str) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in text.split())
    return x, y, z
