"""What contradicts points that fit well by themselves does not overrule them, and is named."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import with_code
from tests.registrations import TURN
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import planes_to_normals
from vomstudio.registration.observations import (
    COMPASS,
    YAW,
    Attitudes,
    Azimuths,
    Directions,
    FixedScale,
    LevelLines,
    ObservationKind,
    Points,
)
from vomstudio.registration.placing import ModelPlacement, place

Array = npt.NDArray[np.float64]
ORIGIN = np.array([576_700.0, 5_188_160.0, 160.0])
TURNS = ("registration.north-turned", "registration.north-quarter-turn")


def north_turns(placed: ModelPlacement) -> list[Finding]:
    return [each for code in TURNS for each in with_code(placed.warnings, code)]


def points(rng: np.random.Generator, n: int, stated: bool = False) -> Points:
    """Of a site of 60 x 40 x 25 m, known to 2 cm."""
    model = rng.uniform(-0.5, 0.5, (n, 3)) * [60.0, 40.0, 25.0]
    world = ORIGIN + model @ TURN.T + rng.normal(size=(n, 3)) * 0.02
    sigma = np.full((n, 3), 0.02 if stated else np.nan)
    return Points([f"P{i}" for i in range(n)], model, world, sigma)


def levels(rng: np.random.Generator, off_deg: float) -> LevelLines:
    """Two horizontal lines at right angles that both rise by this; good to half a degree."""
    rise = np.radians(off_deg + rng.normal(size=2) * 0.5)
    flat = np.array([[1.0, 0.0], [0.0, 1.0]]) * np.cos(rise)[:, None]
    world = np.column_stack([flat, np.sin(rise)])
    return LevelLines(["a", "b"], world @ TURN, np.full(2, np.radians(0.5)))


def yaws(rng: np.random.Generator, off_deg: float, n: int = 12) -> Attitudes:
    """Of cameras that look about northwards; good to 2 degrees, all turned alike."""
    true = Rotation.from_euler(
        "zx", np.column_stack([rng.uniform(-30, 30, n), rng.uniform(80, 100, n)]), degrees=True
    )
    noise = Rotation.from_rotvec(np.radians(rng.normal(size=(n, 3)) * [0.5, 0.5, 2.0]))
    off = Rotation.from_rotvec([0.0, 0.0, -np.radians(off_deg)])
    sigma = np.tile(np.radians([2.0, 0.5, 0.5]), (n, 1))
    axes = np.tile(np.eye(3)[:, [2, 1, 0]], (n, 1, 1))
    seen = (off * noise * true).as_matrix()
    return Attitudes([f"i{k}" for k in range(n)], TURN.T @ true.as_matrix(), seen, axes, sigma)


def planes(rng: np.random.Generator, off_deg: float, stated: bool) -> Directions:
    """Six by compass, good to 2 degrees, whose dip directions are all too large by this."""
    azimuth, dip = rng.uniform(0, 360, 6), rng.uniform(30, 80, 6)
    true = planes_to_normals(azimuth, dip).reshape(-1, 3)
    noise = rng.normal(size=(2, 6)) * 2.0
    world = planes_to_normals(azimuth + off_deg + noise[0], dip + noise[1]).reshape(-1, 3)
    sigma = np.full((6, 2), np.radians(2.0) if stated else np.nan)
    return Directions([f"b{k}" for k in range(6)], true @ TURN, world, sigma)


def azimuth(rng: np.random.Generator, off_deg: float) -> Azimuths:
    """Of one line, good to 3 degrees."""
    line = np.array([[0.6, 0.8, 0.1]])
    read = np.arctan2(line[:, 0], line[:, 1]) + np.radians(off_deg + rng.normal(size=1) * 3.0)
    return Azimuths(["line"], line @ TURN, read, np.radians([3.0]))


def off_deg(placed: ModelPlacement) -> Array:
    """(3,) by how much a placement is turned, about east, north and up."""
    rotation = np.array(placed.matrix)[:3, :3] / placed.scale
    return np.degrees(Rotation.from_matrix(rotation @ TURN.T).as_rotvec())


def held(placed: ModelPlacement) -> bool:
    stated = placed.rotation_error_95_deg
    assert stated is not None
    limits = np.array([stated.about_east, stated.about_north, stated.about_up], np.float64)
    # Twice the 95 % of each axis: three of them, in some forty placements.
    return bool((np.abs(off_deg(placed)) < 2.0 * limits).all())


@pytest.mark.parametrize("n", [4, 6, 10])
@pytest.mark.parametrize("wrong", [10.0, 45.0])
def test_wrong_level_lines_do_not_tilt_good_points(n: int, wrong: float) -> None:
    rng = np.random.default_rng(n)
    placed = place([points(rng, n), levels(rng, wrong)])
    assert held(placed)
    assert np.linalg.norm(off_deg(placed)) < 1.0
    assert abs(placed.scale - 1.0) < 0.01
    assert any("a" in b.label or "b" in b.label for b in placed.blunders)


@pytest.mark.parametrize("n", [4, 6, 10])
@pytest.mark.parametrize(("wrong", "correction"), [(30.0, None), (90.0, -90.0), (180.0, -180.0)])
def test_wrong_azimuth_is_reported_and_does_not_rotate_good_points(
    n: int, wrong: float, correction: float | None
) -> None:
    rng = np.random.default_rng(n)
    placed = place([points(rng, n), azimuth(rng, wrong)])
    assert held(placed)
    assert abs(placed.scale - 1.0) < 0.01
    (finding,) = north_turns(placed)
    assert finding.values["kind"] == COMPASS
    assert (finding.code == TURNS[1]) == (correction is not None)
    if correction is not None:
        assert (finding.values["correction_deg"] - correction) % 360.0 == 0.0


@pytest.mark.parametrize("stated", [False, True])
@pytest.mark.parametrize("n", [4, 6])
def test_strikes_read_as_dip_directions_are_reported(n: int, stated: bool) -> None:
    rng = np.random.default_rng(n)
    placed = place([points(rng, n), planes(rng, 90.0, stated)])
    assert held(placed)
    (finding,) = north_turns(placed)
    assert (finding.code, finding.values["kind"]) == (TURNS[1], COMPASS)


@pytest.mark.parametrize("wrong", [5.0, 15.0, 175.0])
def test_common_yaw_offset_is_reported_and_points_are_kept(wrong: float) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        placed = place([points(rng, 6), yaws(rng, wrong)])
        assert held(placed)
        (finding,) = north_turns(placed)
        assert finding.values["kind"] == YAW
        assert (finding.code == TURNS[1]) == (wrong > 90.0)


@pytest.mark.full
def test_consistent_observations_are_rarely_reported() -> None:
    """Each of three tests is wrong in one of a thousand sound models."""
    said = 0
    for seed in range(25):
        rng = np.random.default_rng(seed)
        every: list[list[ObservationKind]] = [
            [points(rng, 4), levels(rng, 0.0)],
            [points(rng, 5), yaws(rng, 0.0)],
            [points(rng, 6), planes(rng, 0.0, stated=bool(seed % 2))],
            [points(rng, 5), azimuth(rng, 0.0)],
        ]
        for kinds in every:
            placed = place(kinds)
            assert held(placed)
            named = north_turns(placed)
            named += with_code(placed.warnings, "registration.residuals-large")
            said += bool(named)
    assert said <= 3


def test_known_scale_is_kept_and_contradicting_points_are_reported() -> None:
    rng = np.random.default_rng(3)
    own = points(rng, 6)
    twice = Points(own.labels, own.model, ORIGIN + 2.0 * (own.world - ORIGIN), own.sigma)
    ends = np.array([[-30.0, 0.0, 0.0]]), np.array([[30.0, 0.0, 0.0]])
    kept = FixedScale(["scale"], *ends, np.array([60.0]), np.array([0.006]))
    for others in ([], [levels(rng, 0.0)]):
        placed = place([twice, kept, *others])
        assert placed.scale == pytest.approx(1.0, abs=0.01)
        assert with_code(placed.warnings, "registration.scale-contradicted")
