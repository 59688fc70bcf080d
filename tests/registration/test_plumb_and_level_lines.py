"""Plumb lines, nearly parallel level lines, and the photos' upright as a prior of the vertical."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from vomstudio.core.findings import Finding
from vomstudio.registration.evidence import Evidence, register
from vomstudio.registration.level_evidence import UPRIGHT_SIGMA_DEG, KnownDirection
from vomstudio.registration.results import ModelPlacement

Array = npt.NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
TURN = Rotation.from_euler("zyx", [35.0, 9.0, -6.0], degrees=True).as_matrix()
"""From the model to World."""


def codes(placed: ModelPlacement) -> set[str]:
    return {each.code for each in placed.warnings if isinstance(each, Finding)}


def up_on_model(placed: ModelPlacement) -> Array:
    """What the placement makes of the true vertical of the model."""
    return placed.matrix[:3, :3] / placed.scale @ TURN.T @ UP


def tip_deg(placed: ModelPlacement) -> float:
    return float(np.degrees(np.arccos(np.clip(up_on_model(placed) @ UP, -1.0, 1.0))))


def line(direction: Array, sigma_deg: float | None = None, turn: Array = TURN) -> KnownDirection:
    """A line of 4 m on the model, of a direction in World."""
    start = np.array([1.0, 2.0, 0.5])
    end = start + 4.0 * np.asarray(direction, float) @ turn
    return KnownDirection(tuple(start.tolist()), tuple(end.tolist()), sigma_deg)


def level(azimuth_deg: float, plunge_deg: float = 0.0, **more) -> KnownDirection:
    a, p = np.radians([azimuth_deg, plunge_deg])
    return line(np.array([np.sin(a) * np.cos(p), np.cos(a) * np.cos(p), -np.sin(p)]), **more)


@pytest.mark.parametrize("end", [1.0, -1.0])
def test_exact_plumb_line_determines_the_vertical(end: float) -> None:
    """Whichever end is given first."""
    placed = register(Evidence(plumb_lines=[line(end * UP)]))
    assert up_on_model(placed) == pytest.approx(UP, abs=1e-9)
    assert (placed.known.vertical, placed.known.north) == (True, False)
    error = placed.rotation_error_deg
    assert error.about_up is None
    # 0.5 degrees about each horizontal axis, and of n lines by their root.
    assert (error.about_east, error.about_north) == pytest.approx((0.5, 0.5), rel=1e-3)
    four = register(Evidence(plumb_lines=[line(end * UP, 0.8)] * 4)).rotation_error_deg
    assert (four.about_east, four.about_north) == pytest.approx((0.4, 0.4), rel=1e-3)


def test_plumb_line_is_equivalent_to_two_perpendicular_level_lines() -> None:
    plumb = register(Evidence(plumb_lines=[line(UP)]))
    levels = register(Evidence(level_lines=[level(20.0), level(110.0)]))
    assert plumb.matrix == pytest.approx(levels.matrix, abs=1e-9)
    assert np.array(plumb.covariance)[:2, :2] == pytest.approx(
        np.array(levels.covariance)[:2, :2], rel=1e-6, abs=1e-12
    )


@pytest.mark.parametrize("azimuth_deg", [40.0, 170.0])
def test_tilt_does_not_depend_on_model_azimuth(azimuth_deg: float) -> None:
    """Turning the frame of the model about its own z axis turns the result, and nothing else."""
    turn = Rotation.from_euler("z", azimuth_deg, degrees=True).as_matrix()
    tilted = Rotation.from_euler("x", 1.0, degrees=True).as_matrix() @ UP
    first = register(Evidence(plumb_lines=[line(tilted), line(UP)], level_lines=[level(50.0)]))
    given = [line(tilted, turn=TURN @ turn), line(UP, turn=TURN @ turn)]
    levels = [
        line(np.array([np.sin(np.radians(50.0)), np.cos(np.radians(50.0)), 0.0]), turn=TURN @ turn)
    ]
    other = register(Evidence(plumb_lines=given, level_lines=levels))
    vertical = [placed.matrix[2, :3] / placed.scale for placed in (first, other)]
    assert vertical[1] == pytest.approx(vertical[0] @ turn, abs=1e-9)


def test_plumb_line_far_from_model_vertical_leaves_up_ambiguous() -> None:
    assert "registration.which-end-up" not in codes(register(Evidence(plumb_lines=[line(UP)])))
    lying = line(UP, turn=Rotation.from_euler("x", 80.0, degrees=True).as_matrix())
    assert "registration.which-end-up" in codes(register(Evidence(plumb_lines=[lying])))


def test_plumb_line_with_coincident_ends_is_rejected() -> None:
    from vomstudio.core.errors import UsageError

    place = (1.0, 2.0, 3.0)
    with pytest.raises(UsageError) as refused:
        register(Evidence(plumb_lines=[KnownDirection(place, place)]))
    assert refused.value.field == "--plumb"


# --- nearly parallel level lines ------------------------------------------------------------------
@pytest.mark.full
@pytest.mark.parametrize("apart_deg", [0.0, 2.0, 14.0])
@pytest.mark.parametrize("dip_deg", [-1.0, 1.0])
@pytest.mark.parametrize("has_photos", [True, False])
def test_nearly_parallel_level_lines_count_as_one(
    apart_deg: float, dip_deg: float, has_photos: bool
) -> None:
    """Two lines 2 degrees apart, one of which dips by 1 degree, would tip the model by 27."""
    lines = [level(10.0), level(10.0 + apart_deg, dip_deg)]
    evidence = Evidence(level_lines=lines, photo_up=UP if has_photos else None)
    placed = register(evidence)
    # The model stood at 11 degrees; it is not tipped about the lines, and level along their mean.
    along = np.array([level_line.second for level_line in lines]) - [1.0, 2.0, 0.5]
    mean = placed.matrix[:3, :3] @ along.mean(axis=0)
    assert np.degrees(np.arcsin(mean[2] / np.linalg.norm(mean))) == pytest.approx(0.0, abs=0.02)
    assert np.arccos(placed.matrix[2, 2] / placed.scale) < np.radians(11.0)
    assert not placed.known.vertical
    findings = {each.code: each for each in placed.warnings if isinstance(each, Finding)}
    finding = findings["registration.parallel-level-lines"]
    expected = np.degrees(
        np.arccos(
            np.clip(
                along[0] @ along[1] / np.linalg.norm(along[0]) / np.linalg.norm(along[1]), -1, 1
            )
        )
    )
    assert finding.values["apart_deg"] == pytest.approx(expected, abs=1e-6)
    assert ("registration.photo-upright" in findings) == has_photos
    assert ("registration.poor" in findings) == has_photos
    tilt = np.array(placed.covariance)[:2, :2]
    widest = np.degrees(np.sqrt(np.linalg.eigvalsh(tilt)[-1]))
    assert widest == pytest.approx(UPRIGHT_SIGMA_DEG if has_photos else 0.5 / np.sqrt(2), rel=0.01)


def test_level_lines_far_enough_apart_count_separately() -> None:
    placed = register(Evidence(level_lines=[level(10.0), level(26.0)]))
    assert placed.known.vertical
    assert "registration.parallel-level-lines" not in codes(placed)
    # The tilt about the lines by half a degree of each: 0.5 / sqrt(2) / sin(8 degrees).
    tilt = np.array(placed.covariance)[:2, :2]
    widest = np.degrees(np.sqrt(np.linalg.eigvalsh(tilt)[-1]))
    assert widest == pytest.approx(0.5 / np.sqrt(2.0) / np.sin(np.radians(8.0)), rel=0.02)
    # One line across makes the nearly parallel ones count each, too.
    crossed = register(Evidence(level_lines=[level(10.0), level(12.0), level(100.0)]))
    assert crossed.known.vertical
    assert "registration.parallel-level-lines" not in codes(crossed)


def test_photo_upright_prior_is_weighted_by_its_error() -> None:
    """Against the mean of two normal distributions in the plane across a level line."""
    for sigma_deg in (0.5, 10.0):
        lines = [level(0.0, sigma_deg=sigma_deg), level(90.0, sigma_deg=sigma_deg)]
        true_up = TURN.T @ UP
        placed = register(Evidence(level_lines=lines, photo_up=UP))
        share = sigma_deg**2 / (sigma_deg**2 + UPRIGHT_SIGMA_DEG**2)
        from_true = np.arccos(true_up @ UP)
        assert np.radians(tip_deg(placed)) == pytest.approx(share * from_true, rel=0.02, abs=1e-6)


def test_photo_upright_prior_can_be_excluded() -> None:
    lines = [level(10.0), level(12.0, 1.0)]
    groups = register(Evidence(level_lines=lines, photo_up=UP)).observations
    (label,) = next(group.labels for group in groups if group.kind == "photo_upright")
    placed = register(Evidence(level_lines=lines, photo_up=UP, without=[label]))
    assert "photo_upright" not in {group.kind for group in placed.observations}
    assert "registration.photo-upright" not in codes(placed)
