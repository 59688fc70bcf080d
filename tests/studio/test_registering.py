"""How far what was measured on a model turns with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import figures
from vomstudio.core.findings import Finding
from vomstudio.geometry import transform
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import DEFAULT_TYPES, Model
from vomstudio.registration.rotation_uncertainty import worst_turn95_deg
from vomstudio.registration.similarity import jacobian
from vomstudio.studio.placing.registering import (
    add_reference_error,
    expected_positions,
    rotation_deg,
    set_rotation_finding,
    set_rotations_deg,
)

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))
FLAT = np.array([[0, 0], [4, 1], [5, 5], [1, 4], [-2, 2], [2, 7]], float)


def plane(number: int, dip_deg: float, set_name: str = "") -> Trace:
    """A trace on a plane that dips to the east."""
    z = -np.tan(np.radians(dip_deg)) * FLAT[:, 0]
    points = np.column_stack([FLAT, z])
    return Trace(
        f"t{number}",
        f"T{number}",
        "bedding",
        "m1",
        MODEL.content_hash,
        tuple(map(tuple, points.tolist())),
        set_name=set_name,
    )


def turned(degrees: float, axis: tuple[float, float, float]) -> Model:
    matrix = np.eye(4)
    matrix[:3, :3] = 2.0 * Rotation.from_rotvec(np.radians(degrees) * np.array(axis)).as_matrix()
    rows = tuple(tuple(row) for row in matrix.tolist())
    placed = Registration("r", "points", "points", Frame("local"), rows)
    return replace(MODEL, placement=placed)


@pytest.mark.parametrize("dip", [0.0, 20.0, 60.0])
@pytest.mark.parametrize("angle", [1.0, 30.0, 90.0])
def test_poles_turn_on_small_circles_about_the_axis(dip: float, angle: float) -> None:
    """A turn by t about the vertical moves the pole of a plane that dips by d through the arc c,
    where cos c = cos^2 d + sin^2 d cos t."""
    after = turned(angle, (0.0, 0.0, 1.0))
    traces = [plane(1, dip, "J1"), plane(2, dip, "J1")]
    records = {"m1": after, **{k.id: k for k in DEFAULT_TYPES}, **{t.id: t for t in traces}}
    measured = dict(zip(("t1", "t2"), measure_all(records, traces), strict=True))
    found = set_rotations_deg(records, MODEL, after, measured)
    d, t = np.radians(dip), np.radians(angle)
    arc = np.degrees(np.arccos(min(1.0, abs(np.cos(d) ** 2 + np.sin(d) ** 2 * np.cos(t)))))
    assert found == pytest.approx({"Bedding: J1": arc}, abs=1e-5)
    assert rotation_deg(MODEL, after) == pytest.approx(angle)


def test_set_rotations_are_listed_largest_first_and_truncated() -> None:
    assert set_rotation_finding({}) is None
    two = set_rotation_finding({"Bedding": 0.4, "Joint: J1": 12.0})
    assert two == Finding(
        "registration.sets-turned", sets=["Joint: J1 by 12.0°", "Bedding by 0.4°"]
    )
    nine = set_rotation_finding({str(i): float(i) for i in range(9)})
    assert nine is not None
    *_, last, others = nine.values["sets"]
    assert (last, figures(others)) == ("4 by 4.0°", [])


def test_two_points_of_an_upright_model_predict_the_others() -> None:
    """The truth is a turn about the vertical, a scale and a shift; nothing is foretold where the
    vertical is not known, or where the two stand one above the other."""
    truth = turned(35.0, (0.0, 0.0, 1.0)).to_world
    spots = np.array([[0, 0, 0], [9, 1, 2], [3, 7, 4], [0.2, 0.1, 8]], float)
    world = transform.apply(truth, spots) + [398_000.0, 4_980_000.0, 320.0]

    def points(*found: int) -> list[ControlPoint]:
        return [
            ControlPoint(
                f"c{i}",
                f"P{i}",
                "m1",
                MODEL.content_hash,
                (tuple(spots[i].tolist()),) if i in found else (),
                tuple(world[i].tolist()),
            )
            for i in range(4)
        ]

    known = expected_positions(points(0, 1), None, MODEL)
    assert known.keys() == {"c2", "c3"}
    assert known["c2"] == pytest.approx(spots[2], abs=1e-6)
    assert known["c3"] == pytest.approx(spots[3], abs=1e-6)
    assert expected_positions(points(0, 3), None, MODEL) == {}
    assert expected_positions(points(0), None, MODEL) == {}
    assert (
        expected_positions(points(0, 1), None, replace(MODEL, placement=Frame("undeclared"))) == {}
    )


def _moved(points: np.ndarray, numbers: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """By a turn (rad), a relative growth and a shift about a centre, exactly."""
    turn = Rotation.from_rotvec(numbers[:3]).as_matrix()
    return centre + (1.0 + numbers[3]) * (points - centre) @ turn.T + numbers[4:]


def test_error_of_a_fitted_model_combines_reference_and_fit_errors() -> None:
    """Where points of it come to lie in ten thousand draws of both errors."""
    rng = np.random.default_rng(4)
    sizes = (
        [1e-3, 2e-3, 3e-3, 1e-3, 0.02, 0.01, 0.03],
        [2e-3, 1e-3, 1e-3, 5e-4, 0.01, 0.01, 0.02],
    )
    scatter = [np.diag(size) @ rng.normal(0, 1, (7, 7)) for size in sizes]
    centres = np.array([[100.0, 50.0, 10.0], [400.0, -80.0, 30.0]])
    known = [
        Registration(
            name,
            name,
            "points",
            Frame("local"),
            covariance=tuple(map(tuple, (s @ s.T).tolist())),
            centre=tuple(c.tolist()),
        )
        for name, s, c in zip(("fit", "other"), scatter, centres, strict=True)
    ]
    both = add_reference_error(known[0], known[1], scale_fitted=True)
    points = np.array([[120.0, 40.0, 0.0], [60.0, 90.0, 25.0]])
    drawn = []
    for _ in range(10_000):
        there = _moved(points, scatter[0] @ rng.normal(0, 1, 7), centres[0])
        drawn.append(_moved(there, scatter[1] @ rng.normal(0, 1, 7), centres[1]))
    for number, point in enumerate(points):
        moves = jacobian(point - centres[0])
        expected_spread = moves @ np.array(both.covariance) @ moves.T
        spread = np.cov(np.array(drawn)[:, number].T)
        assert np.sqrt(np.diag(spread)) == pytest.approx(
            np.sqrt(np.diag(expected_spread)), rel=0.03
        )
    # About up, east, north, as the record has it.
    sums = np.sqrt(sum(np.diag(s @ s.T)[:3] for s in scatter))
    assert both.rotation_error_deg == pytest.approx(tuple(np.degrees(sums[[2, 0, 1]])))
    worst = [worst_turn95_deg(one.rotation_covariance()) for one in (both, *known)]
    assert worst[0] > max(worst[1:])
    # Nothing is made up where the error of the other one is not known.
    unknown = replace(known[1], covariance=None)
    assert add_reference_error(known[0], unknown, scale_fitted=True) == known[0]
    assert add_reference_error(known[0], None, scale_fitted=True) == known[0]
