"""What is read back of a reconstruction is what went in."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.messages import refused
from tests.photogrammetry import made_reconstruction
from tests.photogrammetry.made_reconstruction import DISTANCE, MISS, NAMES
from vomstudio.photogrammetry.base.stage_folders import is_aligned, stage_folder
from vomstudio.photogrammetry.inspect import inspection


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> made_reconstruction.Made:
    return made_reconstruction.make(tmp_path_factory.mktemp("made"))


def test_stored_matches_are_read_unchanged(made) -> None:
    found = inspection.pair(made.out, "a.jpg", "b.jpg")
    assert np.array_equal(found.matches, made.rows)
    assert np.array_equal(found.refused, made.refused)
    # Each match is one point of the wall, seen by both.
    scene = made.scene
    for side, view, off in ((found.left, 0, 0.0), (found.right, 1, MISS)):
        places = side[found.matches[:, view]]
        expected = scene.views[view].project(scene.points[:100]) + off
        assert np.allclose(places, expected, atol=1e-3)


def test_reversed_pair_has_the_same_matches(made) -> None:
    there = inspection.pair(made.out, "a.jpg", "b.jpg")
    back = inspection.pair(made.out, "b.jpg", "a.jpg")
    assert np.array_equal(back.matches, there.matches[:, ::-1])
    assert np.array_equal(back.refused, there.refused[:, ::-1])
    assert np.array_equal(back.left, there.right)


def test_overview_reports_match_counts_and_residuals(made) -> None:
    facts = inspection.overview(made.out)
    assert json.loads(json.dumps(facts)) == facts
    assert facts["pairs"] == [[0, 1, 101, 100], [0, 2, 1, 0], [1, 2, 13, 12]]
    rows = {photo["name"]: photo for photo in facts["photos"]}
    assert [rows[name]["features"] for name in NAMES] == [170, 170, 170]
    assert rows["a.jpg"]["error_px"] == pytest.approx(0.0, abs=1e-4)
    assert rows["b.jpg"]["error_px"] == pytest.approx(0.5, abs=1e-3)
    assert [rows[name]["gps_m"] for name in NAMES] == [0.5, 1.5, None]
    assert [rows[name]["has_depths"] for name in NAMES] == [True, False, False]
    (camera,) = facts["cameras"]
    assert camera["correlation"][0] == [1.0, None, None, -0.95]
    assert facts["scaled"]


def test_residual_vectors_are_observed_minus_projected(made) -> None:
    pixels, vectors = inspection.residual_vectors(made.out, "b.jpg")
    assert np.allclose(vectors, MISS, atol=1e-3)
    truth = made.scene.views[1].project(made.scene.points)
    assert np.allclose(pixels - vectors, truth, atol=1e-3)
    assert len(inspection.residual_vectors(made.out, "nowhere.jpg")[0]) == 0


def test_depth_map_is_coloured_only_where_it_has_depths(made) -> None:
    found = inspection.depth_pictures(made.out, "a.jpg")
    assert found.coverage == inspection.coverage(made.out, "a.jpg") == pytest.approx(0.5)
    assert inspection.coverage(made.out, "b.jpg") is None
    assert DISTANCE - 1 <= found.low < found.high <= DISTANCE + 1
    assert (found.colors[:, 80:] == inspection.NO_DEPTH_COLOR).all()
    # viridis grows brighter with every step.
    bright = found.colors[60, :80].astype(int) @ [299, 587, 114]
    assert (np.diff(bright) >= 0).all()
    assert found.photo.std() > 5
    with refused("dense.no-neighbour"):
        inspection.depth_pictures(made.out, "b.jpg")


def test_normal_of_a_wall_seen_from_the_south_is_coloured_as_south(made) -> None:
    found = inspection.depth_pictures(made.out, "a.jpg")
    # South is opposite to the red of the north.
    assert found.normals[60, 20].tolist() == [0, 255, 255]


def test_hue_follows_the_azimuth_of_the_normal() -> None:
    north, east, flat = (0, 1, 0), (1, 0, 0), (0, 0, 1)
    colors = inspection.normal_colors(np.array([north, east, flat, (0, 0, -1)], float))
    assert colors[0].tolist() == [255, 0, 0]
    assert colors[1].tolist() == [128, 255, 0]
    assert colors[2].tolist() == [255, 255, 255]
    assert colors[3].max() < 128


def test_missing_reconstruction_is_reported(tmp_path) -> None:
    (tmp_path / "work" / "alignment-0123.part").mkdir(parents=True)
    assert stage_folder(tmp_path, "alignment") is None
    assert not is_aligned(tmp_path)
    assert not is_aligned(tmp_path / "nowhere")
    with refused("reconstruct.not-yet"):
        inspection.overview(tmp_path)
    with refused("reconstruct.not-yet"):
        inspection.pair(tmp_path, "a", "b")


def test_damaged_database_is_reported(tmp_path) -> None:
    made = made_reconstruction.make(tmp_path)
    database = next(made.out.glob("work/alignment-*/database.db"))
    for path in database.parent.glob("database.db*"):
        path.unlink()
    database.write_bytes(b"nothing of the kind" * 100)
    with refused("alignment.matches-unreadable"):
        inspection.overview(made.out)
