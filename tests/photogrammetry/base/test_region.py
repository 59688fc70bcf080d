"""The box of which alone a model is made."""

from __future__ import annotations

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.base.region import Region
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.base.settings import PipelineSettings
from vomstudio.photogrammetry.dense.pairs import select_pairs

ORIGIN = np.array([400_000, 5_000_000, 0])


def scene() -> SparseScene:
    """Six photos in a row before a wall of 50 m; neighbours see the same 10 m of it."""
    rng = np.random.default_rng(1)
    points = np.stack([rng.uniform(0, 50, 600), np.full(600, 20.0), rng.uniform(0, 8, 600)], axis=1)
    lens = Intrinsics("PINHOLE", 1600, 1200, (1200.0, 1200.0, 800.0, 600.0))
    # Looking north: right is east, down is down.
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    centres = np.array([[4.0 + 8.0 * i, 0.0, 4.0] for i in range(6)])
    views = tuple(View(f"{i}.jpg", lens, turn, -turn @ c) for i, c in enumerate(centres))
    seen = np.array([np.abs(points[:, 0] - c[0]) < 12.0 for c in centres])
    keep = seen.sum(axis=0) >= 2
    points, seen = points[keep], seen[:, keep]
    track_views = np.concatenate([np.flatnonzero(column) for column in seen.T]).astype(np.int32)
    of = np.repeat(np.arange(len(points)), seen.sum(axis=0))
    pixels = np.array(
        [views[v].project(points[p])[0] for v, p in zip(track_views, of, strict=True)], np.float32
    )
    return SparseScene(
        views,
        points,
        np.zeros((len(points), 3), np.uint8),
        np.full(len(points), 0.3, np.float32),
        np.concatenate([[0], np.cumsum(seen.sum(axis=0))]),
        track_views,
        pixels.reshape(-1, 2),
        origin=(400_000, 5_000_000, 0),
        crs="EPSG:32615",
        scaled=True,
    )


def box(low: float, high: float) -> Region:
    found = Region.of([400_000 + low, 5_000_000, -1, 400_000 + high, 5_000_030, 20])
    assert found is not None
    return found


def test_only_photos_that_see_the_region_get_depth_maps() -> None:
    wall = scene()
    part = select_pairs(wall).select_views(box(0, 6).select_region_views(wall))
    assert {plan.view for plan in part.plans} == {0, 1}
    assert len(select_pairs(wall).select_views(box(0, 50).select_region_views(wall)).plans) == 6


def test_points_are_chosen_in_the_frame_of_the_model() -> None:
    points = np.array([[1.0, 20.0, 3.0], [10.0, 20.0, 3.0], [1.0, 20.0, 30.0]])
    assert box(0, 6).contains(points, ORIGIN).tolist() == [True, False, False]


def test_region_beside_the_rock_is_rejected() -> None:
    with refused("region.few-points", GeometryError):
        box(500, 600).select_region_views(scene())
    wall = scene()
    with refused("region.no-depths", GeometryError):
        select_pairs(wall).select_views([])


@pytest.mark.parametrize(
    "numbers", [(0, 0, 0, 1, 1), (0, 0, 0, 1, 1, 0), (0, 0, 0, 1, 1, float("nan")), (1,) * 6]
)
def test_invalid_region_is_rejected(numbers: tuple[float, ...]) -> None:
    with pytest.raises(UsageError, match="region"):
        PipelineSettings(region=numbers)


def test_settings_without_a_region_have_none() -> None:
    assert Region.of(PipelineSettings().region) is None
