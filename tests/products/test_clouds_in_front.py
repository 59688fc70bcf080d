"""Clouds whose points leave gaps, with another surface behind."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vomstudio.geometry.cloud import PointCloud
from vomstudio.products.ortho.cloud_picture import CloudSource
from vomstudio.products.ortho.tiles import Grid

GSD = 0.02
SPACING = 0.01
"""Mean distance to the nearest of 2500 random points on a square metre."""


def strewn(n: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0, 3, (n, 2))


def depth_of(view: np.ndarray) -> np.ndarray:
    grid = Grid(0.0, 0.0, GSD, 150, 150)
    source = CloudSource(PointCloud(view), view, grid, SPACING)
    return np.asarray(source.draw(grid.tiles()[0]).depth)


@pytest.mark.parametrize("tilt_deg", [0, 45, 70])
def test_background_is_not_visible_through_gaps_of_a_surface(tilt_deg: float) -> None:
    slope = math.tan(math.radians(tilt_deg))
    front, back = strewn(22_500, 1), strewn(22_500, 2)
    view = np.concatenate(
        [
            np.column_stack([front, slope * front[:, 0]]),
            np.column_stack([back, slope * back[:, 0] + 2.0 + 3.0 * slope]),
        ]
    )
    depth = depth_of(view)
    x = (np.arange(150) + 0.5) * GSD
    off = np.abs(depth - slope * x)[5:-5, 5:-5]
    assert np.isfinite(off).all()
    assert off.max() < 0.06 * (1 + slope)


def test_background_is_visible_through_a_window() -> None:
    front, back = strewn(22_500, 1), strewn(22_500, 2)
    outside = np.linalg.norm(front - [1.5, 1.5], axis=1) > 0.2
    view = np.concatenate(
        [
            np.column_stack([front[outside], np.zeros(outside.sum())]),
            np.column_stack([back, np.full(len(back), 2.0)]),
        ]
    )
    depth = depth_of(view)
    behind = depth > 1.0
    # The points at its edge stand for a little of it.
    assert 0.18**2 * np.pi < behind.sum() * GSD**2 < 0.2**2 * np.pi
    assert behind[75, 75]


@pytest.mark.parametrize("angle_deg", [60, 80])
def test_surface_seen_at_a_small_angle_has_no_holes(angle_deg: float) -> None:
    points = strewn(22_500, 3)
    slope = math.tan(math.radians(angle_deg))
    grid = Grid(0.0, 0.0, GSD, 150, 150)
    view = np.column_stack([points, slope * points[:, 0]])
    picture = CloudSource(PointCloud(view), view, grid, SPACING).draw(grid.tiles()[0])
    x = (np.arange(150) + 0.5) * GSD
    off = (picture.depth - slope * x)[5:-5, 5:-5] / (slope * GSD)
    assert np.abs(off).max() < 4.0
    # Of points strewn at random a few in a hundred pixels have none within their reach.
    assert picture.filled / 150**2 < 0.05


@pytest.mark.parametrize("angle_deg", [70, 75, 80, 85])
@pytest.mark.parametrize("gsd", [0.02, 0.04])
def test_depth_of_a_steep_surface_is_unbiased(angle_deg: float, gsd: float) -> None:
    """Points strewn over the surface itself: of the depth that it changes by in a pixel, the
    median is off by an eighth at most (by up to nine tenths where only the nearest took part)."""
    turn = math.radians(angle_deg)
    long = min(3.0 / math.cos(turn), 12.0)
    along = np.random.default_rng(4).uniform(0, [long, 3], (int(7500 * long), 2))
    view = np.column_stack(
        [along[:, 0] * math.cos(turn), along[:, 1], along[:, 0] * math.sin(turn)]
    )
    grid = Grid(0.0, 0.0, gsd, int(long * math.cos(turn) / gsd), int(3 / gsd))
    depth = CloudSource(PointCloud(view), view, grid, SPACING).draw(grid.tiles()[0]).depth
    x = (np.arange(grid.width) + 0.5) * gsd
    off = (depth - math.tan(turn) * x)[5:-5, 5:-5] / (math.tan(turn) * gsd)
    assert np.isfinite(off).all()
    assert abs(float(np.median(off))) < 0.125
