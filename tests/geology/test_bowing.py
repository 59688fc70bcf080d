"""Bowed models: known curvature is found again, and flat ones are called bowed once in twenty."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.tiers import first_in_default_tier
from vomstudio.geology.bowing import fit_bowing, fit_bowing_to_rotations
from vomstudio.registration.placing import register_points

CLIFF = Rotation.from_euler("xz", [90.0, 35.0], degrees=True).as_matrix()


def face(n: int, seed: int) -> np.ndarray:
    """(n, 3) places on an upright face 60 m long and 30 m high, somewhere."""
    rng = np.random.default_rng(seed)
    flat = np.stack([rng.uniform(-30, 30, n), rng.uniform(-15, 15, n), 0.5 * rng.normal(size=n)])
    return np.asarray(flat.T @ CLIFF.T + [400.0, 900.0, 50.0])


def bowed(places: np.ndarray, curvature: float) -> np.ndarray:
    """The same on a model whose middle is pushed back along its normal, by c r^2 at the edges."""
    local = (places - places.mean(axis=0)) @ CLIFF
    local[:, 2] += curvature * (local[:, :2] ** 2).sum(axis=1)
    return np.asarray(local @ CLIFF.T + places.mean(axis=0))


@pytest.mark.full
@pytest.mark.parametrize("curvature", first_in_default_tier([0.001, -0.0005], 1))
def test_a_known_curvature_is_found_from_control_and_check_points(curvature: float) -> None:
    """A registration by ten of sixteen points takes shift, tilt and scale away, and the curvature
    is there all the same."""
    inside = 0
    for seed in range(60):
        world = face(16, seed)
        rng = np.random.default_rng(1000 + seed)
        model = bowed(world, curvature)
        noisy = world + 0.01 * rng.normal(size=world.shape)
        check = np.arange(16) >= 10
        fit = register_points(model, noisy, check=check)
        found = fit_bowing(noisy, fit(model) - noisy)
        assert found is not None
        assert found.significant
        inside += abs(abs(found.curvature_per_m) - abs(curvature)) <= found.error95_per_m
    assert inside >= 50


def test_change_of_dip_matches_bent_surface() -> None:
    """z = c r^2 slopes by 2 c r: 1 mm in 1 m squared at 30 m is 3.4 degrees on each side."""
    x, y = np.meshgrid(np.linspace(-30, 30, 7), np.linspace(-30, 30, 7))
    places = np.stack([x.ravel(), y.ravel(), np.zeros(49)], axis=1)
    places = places[np.hypot(places[:, 0], places[:, 1]) <= 30.0]
    residuals = np.zeros_like(places)
    residuals[:, 2] = 0.001 * (places[:, :2] ** 2).sum(axis=1)
    found = fit_bowing(places, residuals)
    assert found is not None
    assert found.curvature_per_m == pytest.approx(0.001)
    assert found.reach_m == pytest.approx(30.0)
    assert found.side_deg == pytest.approx(np.degrees(0.06))
    assert found.across_deg == pytest.approx(2.0 * np.degrees(0.06))
    assert found.rise_m == pytest.approx(0.9)


@pytest.mark.parametrize("n", first_in_default_tier([6, 9, 30], 1))
def test_flat_models_are_called_bowed_once_in_twenty(n: int) -> None:
    alarms, rounds = 0, 1500
    rng = np.random.default_rng(n)
    for seed in range(rounds):
        places = face(n, seed)
        # As a registration leaves them: noise with a shift and a tilt.
        turn = np.cross(0.01 * rng.normal(size=3), places - places.mean(axis=0))
        noise = rng.normal(size=places.shape) * [0.02, 0.02, 0.04]
        found = fit_bowing(places, noise + turn + rng.normal(size=3))
        # Six points may happen to lie all at one distance.
        assert found is not None or n == 6
        alarms += found is not None and found.significant
    assert 0.035 < alarms / rounds < 0.067


def test_points_are_weighted_by_stated_accuracy() -> None:
    """Twelve good points and twelve that are a hundred times worse: the good ones decide."""
    world = face(24, 5)
    rng = np.random.default_rng(6)
    sigma = np.where(np.arange(24)[:, None] < 12, 0.01, 1.0) * np.ones(3)
    residuals = bowed(world, 0.001) - world + sigma * rng.normal(size=world.shape)
    weighed, alike = fit_bowing(world, residuals, sigma), fit_bowing(world, residuals)
    assert weighed is not None
    assert alike is not None
    assert weighed.error95_per_m < 0.05 * alike.error95_per_m
    assert abs(weighed.curvature_per_m) == pytest.approx(0.001, rel=0.1)


def test_reach_is_taken_from_model_extent() -> None:
    world = face(10, 7)
    residuals = bowed(world, 0.001) - world
    wide = face(4000, 8)
    found = fit_bowing(world, residuals, extent=wide)
    assert found is not None
    assert found.reach_m == pytest.approx(np.hypot(30.0, 15.0), rel=0.03)


@pytest.mark.parametrize("case", ["few", "line", "ring", "spot"])
def test_insufficient_points_give_no_result(case: str) -> None:
    t = np.linspace(0.0, 2.0 * np.pi, 20, endpoint=False)
    places = {
        "few": face(5, 1),
        "line": np.outer(np.linspace(0, 50, 20), [1.0, 2.0, 0.1]),
        "ring": np.stack([10 * np.cos(t), 10 * np.sin(t), np.zeros(20)], axis=1),
        "spot": np.ones((9, 3)),
    }[case]
    assert fit_bowing(places, np.random.default_rng(2).normal(size=places.shape)) is None


# --- by the verticals of photos ------------------------------------------------------------------
def block(n: int, rng: np.random.Generator, *, wall: bool) -> tuple[np.ndarray, np.ndarray]:
    """Cameras (n, 3) before an upright face, or over ground, and their rotations to World, a little
    unlike each other."""
    flat = np.stack([rng.uniform(-30, 30, n), rng.uniform(-15, 15, n), np.full(n, 20.0)], axis=1)
    looking = Rotation.from_euler("x", 180.0, degrees=True)
    shaken = Rotation.from_rotvec(rng.normal(0, 0.1, (n, 3)))
    turned = Rotation.from_matrix(CLIFF) if wall else Rotation.identity()
    return turned.apply(flat), (turned * shaken * looking).as_matrix()


def turns_of_bend(places: np.ndarray, curvature: float, *, wall: bool) -> np.ndarray:
    """How the cameras turn with the surface w = c r^2, by the turn that takes its normal from that
    of the plane (numerically, from the surface itself)."""
    frame = CLIFF if wall else np.eye(3)
    local = (places - places.mean(axis=0)) @ frame
    step = 1e-4

    def height(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return curvature * (u**2 + v**2)

    u, v = local[:, 0], local[:, 1]
    slope_u = (height(u + step, v) - height(u - step, v)) / (2 * step)
    slope_v = (height(u, v + step) - height(u, v - step)) / (2 * step)
    normals = np.stack([-slope_u, -slope_v, np.ones(len(u))], axis=1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    turns = [Rotation.align_vectors([one], [[0.0, 0.0, 1.0]])[0].as_rotvec() for one in normals]
    return np.array(turns) @ frame.T


@pytest.mark.parametrize("wall", first_in_default_tier([False, True], 1))
@pytest.mark.parametrize("curvature", first_in_default_tier([0.0004, -0.0004], 1))
def test_a_known_curvature_is_found_from_verticals(wall: bool, curvature: float) -> None:
    inside, rounds = 0, 200
    for seed in range(rounds):
        rng = np.random.default_rng(seed)
        places, cameras = block(40, rng, wall=wall)
        mount = cameras @ np.radians([0.7, -0.4, 0.3])
        turns = turns_of_bend(places, curvature, wall=wall) + mount
        turns += np.radians(0.2) * rng.normal(size=turns.shape) + np.radians([1.0, -0.5, 20.0])
        found = fit_bowing_to_rotations(places, turns, cameras)
        assert found is not None
        up = 1.0 if not wall or CLIFF[2, 2] >= 0.0 else -1.0
        inside += abs(found.curvature_per_m - up * curvature) <= found.error95_per_m
    assert inside >= 0.91 * rounds


@pytest.mark.full
def test_verticals_of_a_flat_block_are_called_bowed_once_in_twenty() -> None:
    alarms, rounds = 0, 1500
    for seed in range(rounds):
        rng = np.random.default_rng(seed)
        places, cameras = block(12, rng, wall=bool(seed % 2))
        turns = np.radians(0.3) * rng.normal(size=(12, 3)) + rng.normal(size=3)
        found = fit_bowing_to_rotations(places, turns, cameras)
        assert found is not None
        alarms += found.significant
    assert 0.035 < alarms / rounds < 0.067


def test_misaligned_mount_around_a_rock_is_not_bowing() -> None:
    """All cameras look inwards and each is pitched by a degree: that looks like a dome to whoever
    does not know of mounts."""
    rng = np.random.default_rng(5)
    around = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    reach = rng.uniform(15.0, 30.0, 24)
    places = np.stack([reach * np.sin(around), reach * np.cos(around), np.zeros(24)], axis=1)
    ahead = -places / np.linalg.norm(places, axis=1)[:, None]
    down = np.tile([0.0, 0.0, -1.0], (24, 1))
    cameras = np.stack([np.cross(down, ahead), down, ahead], axis=2)
    turns = cameras @ np.radians([1.0, 0.0, 0.0]) + np.radians(0.05) * rng.normal(size=(24, 3))
    found = fit_bowing_to_rotations(places, turns, cameras)
    assert found is None or not found.significant


def test_few_or_coincident_photos_give_no_result() -> None:
    rng = np.random.default_rng(0)
    places, cameras = block(5, rng, wall=False)
    assert fit_bowing_to_rotations(places, np.zeros((5, 3)), cameras) is None
    places, cameras = block(9, rng, wall=False)
    assert fit_bowing_to_rotations(np.zeros((9, 3)), rng.normal(size=(9, 3)), cameras) is None
