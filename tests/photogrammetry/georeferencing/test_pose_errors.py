"""The errors of poses, by photos whose poses are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.photogrammetry.made_photos import around, face
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import bundle_adjust
from vomstudio.photogrammetry.georeferencing.pose_errors import PoseErrors, pose_errors
from vomstudio.registration.similarity import fit_similarity

NOISE_PX = 0.5


def scene_of(count: int = 8, points: int = 250, few: int | None = None) -> SparseScene:
    """An exact scene. few : tie points of the last photo"""
    views, positions = around(count), face(points)
    seen = np.array([view.contains(view.project(positions)) for view in views])
    if few is not None:
        seen[-1, np.flatnonzero(seen[-1])[few:]] = False
    positions, seen = positions[seen.sum(axis=0) >= 2], seen[:, seen.sum(axis=0) >= 2]
    rows, columns = np.nonzero(seen.T)
    pixels = np.stack(
        [views[v].project(positions[p])[0] for p, v in zip(rows, columns, strict=True)]
    )
    return SparseScene(
        tuple(views),
        positions,
        np.zeros((len(positions), 3), np.uint8),
        np.full(len(positions), 0.3, np.float32),
        np.concatenate([[0], np.cumsum(seen.sum(axis=0))]),
        columns.astype(np.int32),
        pixels.astype(np.float32),
    )


def noisy(scene: SparseScene, seed: int) -> SparseScene:
    rng = np.random.default_rng(seed)
    pixels = scene.track_pixels + rng.normal(0, NOISE_PX, scene.track_pixels.shape)
    return replace(scene, track_pixels=pixels.astype(np.float32))


def errors_of(scene: SparseScene) -> PoseErrors:
    errors = pose_errors(scene, NOISE_PX)
    assert errors is not None
    return errors


def test_errors_of_adjusted_photos_are_within_the_stated_errors() -> None:
    truth = scene_of()
    stated = errors_of(truth)
    off = []
    for seed in range(12):
        made = bundle_adjust(noisy(truth, seed), ())
        fit = fit_similarity(made.centres, truth.centres)
        off.append(np.linalg.norm(fit(made.centres) - truth.centres, axis=1))
    ratio = np.array(off) / stated.position95
    # Of a normal ellipsoid nearly all are within, and the RMS is near a half of the longest axis.
    assert np.mean(ratio < 1) > 0.9
    assert 0.25 < np.sqrt(np.mean(ratio**2)) < 0.75
    assert not stated.is_weak.any()


def test_only_the_photo_with_few_tie_points_is_weak() -> None:
    whole, weak = errors_of(scene_of()), errors_of(scene_of(few=6))
    assert weak.is_weak.tolist() == [False] * 7 + [True]
    assert weak.position95[-1] > 5 * whole.position95[-1]
    assert weak.position95[:-1] == pytest.approx(whole.position95[:-1], rel=0.5)
    scene = scene_of(few=6)
    (finding,) = weak.findings(scene)
    assert finding.code == "weak-poses"
    assert finding.values["photos"] == (scene.views[-1].name,)


def test_a_photo_without_tie_points_is_weak() -> None:
    assert errors_of(scene_of(few=0)).is_weak.tolist() == [False] * 7 + [True]


def test_errors_follow_the_noise_and_the_scale() -> None:
    scene = scene_of()
    one, double = pose_errors(scene, 0.5), pose_errors(scene, 1.0)
    assert one is not None
    assert double is not None
    np.testing.assert_allclose(double.position95, 2 * one.position95, rtol=1e-3)
    views = tuple(view.moved(10.0, np.eye(3), np.zeros(3)) for view in scene.views)
    large = errors_of(replace(scene, views=views, points=10 * scene.points))
    np.testing.assert_allclose(large.position95, 10 * one.position95, rtol=1e-3)
    np.testing.assert_allclose(large.rotation95_deg, one.rotation95_deg, rtol=1e-3)
