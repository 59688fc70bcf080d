"""Depth maps of earlier runs are reused only if their cameras have hardly moved."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.dense.depthmaps import DepthMap
from vomstudio.photogrammetry.pipeline.reused_depths import DepthInputs, EarlierDepthMaps

RULES = "rules"
LENS = Intrinsics("SIMPLE_RADIAL", 1200, 900, (1000.0, 600.0, 450.0, -0.05))
MAP_LENS = Intrinsics.pinhole(120, 90, 100.0, 60.0, 45.0)
DEPTH_M = 10.0


def camera(name: str, x: float, lens: Intrinsics = LENS) -> View:
    """Camera at (x, 0, 0) that looks along z."""
    return View(name, lens, np.eye(3), np.array([-x, 0.0, 0.0]))


REFERENCE, LEFT, RIGHT = camera("a", 0.0), camera("b", -1.0), camera("c", 1.5)


@pytest.fixture
def earlier(tmp_path: Path) -> EarlierDepthMaps:
    """One map of a wall at a distance of 10, with two sources."""
    pinhole = replace(REFERENCE, intrinsics=MAP_LENS)
    depth = np.full((90, 120), DEPTH_M, np.float32)
    depth[:10] = 0
    normals = np.zeros((90, 120, 3), np.float32)
    normals[..., 2] = -1
    DepthMap("a", pinhole, depth, normals, np.full((90, 120), 200, np.uint8)).save(
        tmp_path / "a.npz"
    )
    sources = (("hash b", LEFT), ("hash c", RIGHT))
    DepthInputs("hash a", REFERENCE, pinhole, sources).save(tmp_path / "a.json", RULES)
    return EarlierDepthMaps([tmp_path], RULES)


def find(
    earlier: EarlierDepthMaps,
    reference: View = REFERENCE,
    left: View = LEFT,
    right: View | None = RIGHT,
    map_lens: Intrinsics = MAP_LENS,
) -> DepthMap | None:
    views = {"hash a": reference, "hash b": left, "hash new": camera("new", 3.0)}
    if right is not None:
        views["hash c"] = right
    match = earlier.find("hash a", replace(reference, intrinsics=map_lens), views)
    return None if match is None else match[0]


def moved_px(pixels: float) -> float:
    """Distance of a camera by which a wall at `DEPTH_M` moves so many pixels of the map."""
    return pixels * DEPTH_M / MAP_LENS.focal[0]


def test_map_is_reused_unchanged_if_nothing_moved(earlier: EarlierDepthMaps) -> None:
    reused = find(earlier)
    assert reused is not None
    assert np.unique(reused.depth).tolist() == [0.0, DEPTH_M]
    assert (reused.confidence == 200).all()


def test_depths_follow_the_scale_of_a_moved_scene(earlier: EarlierDepthMaps) -> None:
    angle = np.radians(30)
    rotation = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]]
    )
    views = [
        view.moved(2.5, rotation, np.array([7.0, -3.0, 1.0])) for view in (REFERENCE, LEFT, RIGHT)
    ]
    reused = find(earlier, *views)
    assert reused is not None
    assert reused.depth[50, 60] == pytest.approx(2.5 * DEPTH_M, rel=1e-6)
    assert np.allclose(reused.view.centre, views[0].centre)


@pytest.mark.parametrize(("pixels", "is_reused"), [(0.1, True), (0.3, False)])
def test_map_is_reused_if_a_source_moved_by_less_than_a_fifth_of_a_pixel(
    earlier: EarlierDepthMaps, pixels: float, is_reused: bool
) -> None:
    shifted = replace(LEFT, translation=LEFT.translation + [0.0, moved_px(pixels), 0.0])
    assert (find(earlier, left=shifted) is not None) == is_reused


@pytest.mark.parametrize(("focal", "is_reused"), [(1000.5, True), (1010.0, False)])
def test_map_is_not_reused_if_the_lens_changed(
    earlier: EarlierDepthMaps, focal: float, is_reused: bool
) -> None:
    lens = replace(LENS, params=(focal, *LENS.params[1:]))
    views = [replace(view, intrinsics=lens) for view in (REFERENCE, LEFT, RIGHT)]
    assert (find(earlier, *views) is not None) == is_reused


def test_map_is_not_reused_without_one_of_its_sources(earlier: EarlierDepthMaps) -> None:
    assert find(earlier, right=None) is None


def test_map_of_another_size_or_method_is_not_reused(
    earlier: EarlierDepthMaps, tmp_path: Path
) -> None:
    assert find(earlier, map_lens=MAP_LENS.scaled(60, 45)) is None
    assert find(EarlierDepthMaps([tmp_path], "other rules")) is None


def test_damaged_files_are_ignored(tmp_path: Path, earlier: EarlierDepthMaps) -> None:
    (tmp_path / "a.npz").write_bytes(b"damaged")
    assert find(earlier) is None
    for content in ("", "[]", '{"rules": "rules"}', '{"rules": "rules", "photo": 1, "view": 2}'):
        (tmp_path / "a.json").write_text(content)
        assert find(EarlierDepthMaps([tmp_path], RULES)) is None


def test_drift_is_measured_from_the_computation_not_from_the_last_reuse(
    earlier: EarlierDepthMaps, tmp_path: Path
) -> None:
    scene = [view.moved(2.0, np.eye(3), np.zeros(3)) for view in (REFERENCE, LEFT, RIGHT)]
    views = dict(zip(("hash a", "hash b", "hash c"), scene, strict=True))
    match = earlier.find("hash a", replace(scene[0], intrinsics=MAP_LENS), views)
    assert match is not None
    depth_map, inputs = match
    later = tmp_path / "later"
    later.mkdir()
    depth_map.save(later / "a.npz")
    inputs.save(later / "a.json", RULES)
    again = EarlierDepthMaps([later], RULES)
    # 0.15 pixels against the first scene is allowed, and 0.15 more is not.
    for pixels, is_reused in ((0.15, True), (0.3, False)):
        shifted = replace(LEFT, translation=LEFT.translation + [0.0, moved_px(pixels), 0.0])
        reused = find(again, left=shifted)
        assert (reused is not None) == is_reused
        if reused is not None:
            assert reused.depth[50, 60] == pytest.approx(DEPTH_M, rel=1e-3)
