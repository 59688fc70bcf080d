"""A model is first looked at from its exposed side."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tiers import first_in_default_tier
from vomstudio.geology.orientation import Line
from vomstudio.geometry import transform
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.view.first_view import first_view

HERE = np.eye(4)


def sheet(across, up, *, rough=0.05) -> Mesh:
    """A rough sheet whose faces look along across x up."""
    rng = np.random.default_rng(1)
    a, b = np.meshgrid(np.arange(20.0), np.arange(20.0), indexing="ij")
    out = np.cross(across, up)
    points = a[..., None] * across + b[..., None] * up
    points = points + rng.normal(0.0, rough, a.shape)[..., None] * out
    n = np.arange(400).reshape(20, 20)
    p, q, r, s = n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]
    faces = np.stack([np.stack([p, q, r], -1), np.stack([p, r, s], -1)]).reshape(-1, 3)
    return Mesh(points.reshape(-1, 3), faces.astype(np.int32))


def looks(data, to_world=HERE) -> np.ndarray:
    return np.asarray(Line(*first_view(data, to_world)).vector())


@pytest.mark.parametrize("azimuth", first_in_default_tier([0.0, 75.0, 180.0, 310.0], 1))
def test_first_view_faces_a_cliff(azimuth):
    a = np.radians(azimuth)
    out = np.array([np.sin(a), np.cos(a), 0.0])
    cliff = sheet(np.cross([0.0, 0.0, 1.0], out), np.array([0.0, 0.0, 1.0]))
    assert looks(cliff) @ -out > 0.99


def test_first_view_of_a_pavement_is_from_above_with_north_up():
    ground = sheet(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    trend, plunge = first_view(ground, HERE)
    assert trend == 0.0
    assert plunge == pytest.approx(60.0)


def test_first_view_of_a_flat_cloud_is_from_above():
    ground = sheet(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    assert first_view(PointCloud(ground.vertices), HERE) == pytest.approx((0.0, 60.0))


def test_first_view_respects_the_up_axis():
    ground = sheet(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))
    y_up = transform.matrix(Frame("local", None, 0.001, "y").to_world())
    assert first_view(ground, y_up) == pytest.approx((0.0, 60.0))


def test_first_view_of_a_closed_body_is_the_default():
    one = sheet(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    both = Mesh(one.vertices, np.concatenate([one.faces, one.faces[:, ::-1]]))
    assert first_view(both, HERE) == (0.0, 35.0)
