"""Points nearly on a line: how far the model may turn about it, beyond what is linear."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.control.observation_tables import Positions
from vomstudio.registration.adjustment import adjust
from vomstudio.registration.evidence import Evidence, register
from vomstudio.registration.likelihood import widen_by_likelihood
from vomstudio.registration.observations import Points

_Z95 = 1.959963984540054


def worst_deg(rotation: np.ndarray) -> float:
    return _Z95 * float(np.degrees(np.sqrt(np.linalg.eigvalsh(rotation)[-1])))


def points(world: np.ndarray, given: np.ndarray, sigma: np.ndarray | float) -> Points:
    """On a model that is turned and three times as small."""
    turn = Rotation.from_rotvec([0.4, -0.9, 1.2]).as_matrix()
    labels = [str(i) for i in range(len(world))]
    told = np.broadcast_to(sigma, world.shape)
    return Points(labels, world @ turn / 3.0, given, np.array(told), "cameras")


def judged(kind: Points) -> tuple[np.ndarray, np.ndarray]:
    """The linear covariance of the rotation and the wider one."""
    centre = kind.model.mean(axis=0, keepdims=True)
    size = float(np.sqrt(((kind.model - centre) ** 2).sum(axis=1).mean()))
    found = adjust([kind], centre, size)
    return found.rotation, widen_by_likelihood([kind], found, centre).rotation


@pytest.mark.parametrize("sigma", [0.5, 1.5, 2.5])
def test_rotation_limit_is_where_the_sum_of_squares_reaches_its_95_limit(sigma: float) -> None:
    """Points on rings around a line, at the distance r from it: turned by d about it each misses by
    2 r sin(d / 2), and the squares have grown by 1.96^2."""
    around = np.arange(16) * np.pi / 2.0
    rings = np.column_stack([np.repeat([-3e3, -1e3, 1e3, 3e3], 4), np.cos(around), np.sin(around)])
    linear, wide = judged(points(rings, rings, sigma))
    assert worst_deg(linear) == pytest.approx(np.degrees(_Z95 * sigma / 4.0), rel=1e-3)
    wanted = np.degrees(2.0 * np.arcsin(_Z95 * sigma / 8.0))
    assert worst_deg(wide) == pytest.approx(wanted, rel=0.01)


def test_well_distributed_points_keep_their_linear_errors() -> None:
    rng = np.random.default_rng(1)
    world = rng.uniform(-30, 30, (6, 3))
    linear, wide = judged(points(world, world + 0.02 * rng.normal(size=(6, 3)), 0.02))
    assert (wide == linear).all()


def evidence(off_m: float) -> Evidence:
    """Eight cameras along a line, off it by so much, by a receiver good to 1.5 m."""
    lens = Intrinsics.pinhole(4000, 3000, 3000.0, 2000.0, 1500.0)
    down = np.diag([1.0, -1.0, -1.0])
    around = np.arange(8) * np.pi / 2.0
    beside = off_m * np.column_stack([np.cos(around), np.sin(around)])
    world = np.column_stack([np.linspace(-70, 70, 8), beside])
    names = tuple(f"{i}.jpg" for i in range(8))
    views = {n: View(n, lens, down, -down @ c) for n, c in zip(names, world, strict=True)}
    given = Positions(names, world + [4e5, 5e6, 100.0], False, np.full((8, 3), 1.5))
    centres = {name: view.centre for name, view in views.items()}
    return Evidence(views=views, centres=centres, positions=given)


def test_cameras_that_leave_the_rotation_undetermined_are_rejected() -> None:
    """1.96 * 1.5 / (r sqrt 8) is 20 degrees for r of 3 m, 40 for 1.5, and 48 for 1.25."""
    placed = register(evidence(3.0))
    told = placed.rotation_error_95_deg.weakest.error_deg
    assert told == pytest.approx(20.0, abs=1.0)
    with refused("cameras.unsure", GeometryError):
        register(evidence(1.45))
