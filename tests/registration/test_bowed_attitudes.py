"""A model bent by a wrong lens, told by points, by positions or by the gimbals of its photos."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import with_code
from tests.tiers import first_in_default_tier
from vomstudio.geology.orientation import Line
from vomstudio.geology.view_attitudes import camera_rotations
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.control.attitude_tables import attitude_table
from vomstudio.io.control.observation_tables import Pairs, Positions
from vomstudio.registration.evidence import Evidence, register

LENS = Intrinsics("PINHOLE", 4000, 3000, (3000.0, 3000.0, 2000.0, 1500.0))


def over_ground() -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-50, 50, 6), np.linspace(-50, 50, 6))
    return np.stack([x.ravel(), y.ravel(), np.full(36, 40.0)], axis=1)


def bent(curvature: float, seed: int = 3) -> Evidence:
    """36 photos over flat ground; in the model both their places and how they look are bent by
    z = c r^2. Their positions are those of a cheap receiver, which shows nothing of that."""
    rng = np.random.default_rng(seed)
    world = over_ground()
    angles = np.stack(
        [rng.uniform(0, 360, 36), rng.normal(-90, 3, 36), rng.normal(0, 3, 36)], axis=1
    )
    angles[:, 1] = np.minimum(angles[:, 1], -84.0 - rng.uniform(0, 4, 36))
    cameras = camera_rotations(angles)
    slope = 2.0 * curvature * world[:, :2]
    turn = Rotation.from_rotvec(np.stack([slope[:, 1], -slope[:, 0], np.zeros(36)], axis=1))
    coordinates = world + [0.0, 0.0, 1.0] * (curvature * (world[:, :2] ** 2).sum(axis=1))[:, None]
    names = [f"{i}.jpg" for i in range(36)]
    views = {}
    for name, place, camera in zip(names, coordinates, turn.as_matrix() @ cameras, strict=True):
        views[name] = View(name, LENS, camera.T, -camera.T @ place)
    told = angles + rng.normal(0, 0.1, (36, 3))
    return Evidence(
        views=views,
        centres={name: view.centre for name, view in views.items()},
        positions=Positions(
            tuple(names), world + rng.normal(0, 3.0, (36, 3)), False, np.full((36, 3), np.nan)
        ),
        attitudes=attitude_table(tuple(names), told, None, ("true",) * 36, is_doubted=True),
    )


@pytest.mark.full
@pytest.mark.parametrize("curvature", first_in_default_tier([0.0004, -0.0004]))
def test_gimbal_angles_reveal_a_bowed_model(curvature: float) -> None:
    """2 c r at 71 m, the corner, is 3.2 degrees."""
    bowed = with_code(register(bent(curvature)).warnings, "registration.bowed")
    (finding,) = [each for each in bowed if each.values["source"] == "verticals"]
    assert finding.values["n"] == 36
    side = finding.values["side_deg"]
    assert side == pytest.approx(np.degrees(2 * 0.0004 * np.hypot(50, 50)), abs=0.25)


def bent_points(curvature: float, n: int, turned: np.ndarray) -> Evidence:
    """By ten control points and the rest as check, on ground that is bent by w = c r^2 in the model
    and stands as it is turned."""
    rng = np.random.default_rng(n)
    flat = np.column_stack([rng.uniform(-50, 50, (n, 2)), np.zeros(n)])
    model = flat.copy()
    model[:, 2] = curvature * (flat[:, :2] ** 2).sum(axis=1)
    labels = tuple(f"P{i}" for i in range(n))
    world = flat @ turned.T + rng.normal(0, 0.02, (n, 3)) + [5000.0, 7000.0, 100.0]
    pairs = Pairs(labels, model, world, np.full((n, 3), np.nan), np.arange(n) >= 10)
    return Evidence(pairs=pairs)


@pytest.mark.parametrize("source", first_in_default_tier(["control", "positions", "verticals"], 2))
@pytest.mark.parametrize(
    ("curvature", "word"), first_in_default_tier([(0.0004, "dish"), (-0.0004, "dome")], 2)
)
def test_dome_and_dish_are_distinguished(source: str, curvature: float, word: str) -> None:
    """z = c r^2: the edges of a dome are below its middle."""
    if source == "control":
        evidence = bent_points(curvature, 16, np.eye(3))
    else:
        evidence = bent(curvature)
        if source == "positions":
            assert evidence.positions is not None
            rng = np.random.default_rng(8)
            good = over_ground() + rng.normal(0, 0.05, (36, 3))
            positions = replace(evidence.positions, coordinates=good)
            evidence = replace(evidence, attitudes=None, positions=positions)
    finding, *_ = with_code(register(evidence).warnings, "registration.bowed")
    assert finding.values["source"] == ("verticals" if source == "verticals" else "residuals")
    assert f"(a {word})" in finding.values["where"]
    assert ("below it" in finding.values["where"]) == (word == "dome")


@pytest.mark.parametrize(("curvature", "azimuth"), [(0.0004, 217), (-0.0004, 37)])
def test_bowed_wall_reports_the_azimuth_of_bending(curvature: float, azimuth: int) -> None:
    """Its normal w, by which c counts, looks to 217 degrees and up by 5."""
    w = Line(217.0, -5.0).vector()
    along = np.cross([0.0, 0.0, 1.0], w)
    along /= np.linalg.norm(along)
    turned = np.column_stack([along, np.cross(w, along), w])
    placed = register(bent_points(curvature, 16, turned))
    (finding,) = with_code(placed.warnings, "registration.bowed")
    assert finding.values["where"].endswith(f"{azimuth:03d}")


def test_straight_model_is_not_reported_as_bowed() -> None:
    assert not with_code(register(bent(0.0)).warnings, "registration.bowed")
