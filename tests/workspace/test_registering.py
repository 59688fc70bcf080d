"""How far what was measured on a model turns with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vomstudio.document.kinds.control_point import ControlPoint
from vomstudio.document.kinds.trace import Trace
from vomstudio.document.measurement_cache import measure_all
from vomstudio.document.records import DEFAULT_TYPES, Frame, Model, Registration
from vomstudio.geometry import transform
from vomstudio.workspace.registering import (
    expected,
    set_words,
    sets_turned_deg,
    turned_deg,
)

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))
FLAT = np.array([[0, 0], [4, 1], [5, 5], [1, 4], [-2, 2], [2, 7]], float)


def plane(number: int, dip_deg: float, set_name: str = "") -> Trace:
    """A trace on a plane that dips to the east."""
    z = -np.tan(np.radians(dip_deg)) * FLAT[:, 0]
    points = np.column_stack([FLAT, z])
    return Trace(
        f"t{number}", f"T{number}", "bedding", "m1", MODEL.content_hash,
        tuple(map(tuple, points.tolist())), set_name=set_name,
    )  # fmt: skip


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
    found = sets_turned_deg(records, MODEL, after, measured)
    d, t = np.radians(dip), np.radians(angle)
    arc = np.degrees(np.arccos(min(1.0, abs(np.cos(d) ** 2 + np.sin(d) ** 2 * np.cos(t)))))
    assert found == pytest.approx({"Bedding: J1": arc}, abs=1e-5)
    assert turned_deg(MODEL, after) == pytest.approx(angle)


def test_sets_are_told_the_farthest_first_and_few_of_them() -> None:
    assert set_words({}) == ""
    said = set_words({"Bedding": 0.4, "Joint: J1": 12.0})
    assert said == "Mean planes turned: Joint: J1 by 12.0°; Bedding by 0.4°."
    assert set_words({str(i): float(i) for i in range(9)}).endswith("4 by 4.0°; others by less.")


def test_two_points_of_an_upright_model_foretell_the_others() -> None:
    """The truth is a turn about the vertical, a scale and a shift; nothing is foretold where the
    vertical is not known, or where the two stand one above the other."""
    truth = turned(35.0, (0.0, 0.0, 1.0)).to_world
    spots = np.array([[0, 0, 0], [9, 1, 2], [3, 7, 4], [0.2, 0.1, 8]], float)
    world = transform.apply(truth, spots) + [398_000.0, 4_980_000.0, 320.0]

    def points(*found: int) -> list[ControlPoint]:
        return [
            ControlPoint(
                f"c{i}", f"P{i}", "m1", MODEL.content_hash,
                (tuple(spots[i].tolist()),) if i in found else (), tuple(world[i].tolist()),
            )
            for i in range(4)
        ]  # fmt: skip

    known = expected(points(0, 1), None, MODEL)
    assert known.keys() == {"c2", "c3"}
    assert known["c2"] == pytest.approx(spots[2], abs=1e-6)
    assert known["c3"] == pytest.approx(spots[3], abs=1e-6)
    assert expected(points(0, 3), None, MODEL) == {}
    assert expected(points(0), None, MODEL) == {}
    assert expected(points(0, 1), None, replace(MODEL, placement=Frame("undeclared"))) == {}
