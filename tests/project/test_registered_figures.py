"""What a registration does to lines where planes meet, to lengths and to thicknesses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from tests.messages import by_code
from vomstudio.geology.intersections import NORMAL_QUANTILE95
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.rotation_errors import direction_covariance, errors_95_deg
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement import Measurement
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import Feature, Group, Model

FACTOR = float(np.sqrt(chi2.ppf(0.95, 2)))
SHAPE = np.diag([*(np.radians([1.0, 2.0, 3.0]) ** 2), 0.01**2])
SHAPE[0, 2] = SHAPE[2, 0] = np.radians(1.0) ** 2
SHAPE[1, 3] = SHAPE[3, 1] = np.radians(0.5) * 0.01


def registration(id_: str = "r1", shape: np.ndarray = SHAPE) -> Registration:
    whole = np.zeros((7, 7))
    whole[:4, :4] = shape
    rows = tuple(map(tuple, whole.tolist()))
    return Registration(id_, id_, "points", Frame("local"), covariance=rows)


def model(id_: str, placed: Registration | Frame) -> Model:
    return Model(id_, id_, f"{id_}.ply", "mesh", "hash", placed)


def on_plane(id_: str, plane: Plane, model_id: str, seed: int = 1) -> Trace:
    rng = np.random.default_rng(seed)
    along, down = plane.strike_vector(), plane.dip_vector()
    t = np.linspace(-5.0, 5.0, 40)
    points = t[:, None] * along + (3.0 * np.sin(t))[:, None] * down
    points = points + rng.normal(0.0, 0.002, (40, 3))
    return Trace(id_, id_, "bedding", model_id, "hash", tuple(map(tuple, points.tolist())))


def measured(feature: Feature, *others: Model | Feature) -> Measurement:
    records = {each.id: each for each in (*others, feature)}
    return measure_all(records, [feature])[0]


def meeting(first: Group, second: Group) -> Intersection:
    return Intersection("i1", "i", "lineation", first, second)


A, B = Plane(90.0, 40.0), Plane(200.0, 70.0)
PLANES = Group(feature_id="a"), Group(feature_id="b")


# --- lines ----------------------------------------------------------------------------------------
def test_intersection_of_planes_on_one_model_has_its_rotation_error() -> None:
    placed = model("m1", registration())
    found = measured(meeting(*PLANES), placed, on_plane("a", A, "m1"), on_plane("b", B, "m1", 2))
    assert found.line is not None
    expected = errors_95_deg(SHAPE[:3, :3], found.line.vector()[None])[0]
    assert found.registration_error_deg == pytest.approx(expected, rel=1e-6)
    assert found.total is not None
    assert found.max_confidence95_deg is not None
    assert found.total.largest_deg == pytest.approx(
        np.hypot(expected, found.max_confidence95_deg), rel=0.02
    )


def test_planes_on_two_models_have_independent_rotation_errors() -> None:
    """Against 4,000 pairs of turns drawn."""
    both = [model("m1", registration("r1")), model("m2", registration("r2"))]
    found = measured(meeting(*PLANES), *both, on_plane("a", A, "m1"), on_plane("b", B, "m2", 2))
    rng = np.random.default_rng(3)
    root = np.linalg.cholesky(SHAPE[:3, :3])
    first, second = (Rotation.from_rotvec(rng.normal(size=(4000, 3)) @ root.T) for _ in "ab")
    lines = np.cross(first.apply(A.normal()), second.apply(B.normal()))
    lines /= np.linalg.norm(lines, axis=1)[:, None]
    assert found.line is not None
    off = lines * np.sign(lines @ found.line.vector())[:, None] - found.line.vector()
    worst = np.degrees(np.sqrt(np.linalg.eigvalsh(off.T @ off / 4000)[-1]))
    assert found.registration_error_deg == pytest.approx(FACTOR * worst, rel=0.06)


def test_models_with_one_registration_share_its_rotation_error() -> None:
    both = [model("m1", registration()), model("m2", registration())]
    one = measured(meeting(*PLANES), *both, on_plane("a", A, "m1"), on_plane("b", B, "m1", 2))
    two = measured(meeting(*PLANES), *both, on_plane("a", A, "m1"), on_plane("b", B, "m2", 2))
    assert two.registration_error_deg == pytest.approx(one.registration_error_deg)


def test_registration_error_of_a_set_does_not_depend_on_its_size() -> None:
    placed = model("m1", registration())
    told = []
    for n in (2, 12):
        beds = [on_plane(f"t{i}", A, "m1", i) for i in range(n)]
        joints = replace(on_plane("b", B, "m1", 99), type_id="joint")
        group = meeting(Group(type_id="bedding"), Group(feature_id="b"))
        told.append(measured(group, placed, *beds, joints).registration_error_deg)
    assert told[1] == pytest.approx(told[0], rel=0.01)


def test_compass_readings_and_declared_models_have_no_registration_error() -> None:
    level = Reading("b", "b", "joint", "plane", 200.0, 70.0)
    found = measured(meeting(*PLANES), model("m1", Frame("local")), on_plane("a", A, "m1"), level)
    assert found.registration_error_deg is None
    assert found.verdict is not None
    assert "line.registration" not in by_code(found.verdict.reasons)


def test_line_verdict_reports_large_registration_error() -> None:
    wild = registration(shape=9.0 * SHAPE)
    found = measured(
        meeting(*PLANES), model("m1", wild), on_plane("a", A, "m1"), on_plane("b", B, "m1", 2)
    )
    assert found.verdict is not None
    assert found.verdict.quality == "poor"
    assert by_code(found.verdict.reasons)["line.registration"]["limit_deg"] == 15.0


def lineation(plane_id: str, model_id: str = "m1") -> Lineation:
    line = Line(120.0, 20.0)
    wanted = A.normal() * float(line.vector() @ A.normal())
    direction = line.vector() - wanted
    points = np.linspace(0.0, 2.0, 12)[:, None] * direction
    points = points + np.random.default_rng(4).normal(0.0, 0.001, (12, 3))
    vertices = tuple(map(tuple, points.tolist()))
    return Lineation("l1", "l", "lineation", model_id, "hash", vertices, plane_id=plane_id)


def test_line_projected_on_a_plane_of_its_model_has_the_full_rotation_error() -> None:
    placed = model("m1", registration())
    alone = measured(lineation(""), placed)
    laid = measured(lineation("a"), placed, on_plane("a", A, "m1"))
    assert laid.registration_error_deg == pytest.approx(alone.registration_error_deg, rel=1e-3)
    assert laid.total is not None
    assert laid.max_confidence95_deg is not None
    assert laid.total.largest_deg > laid.max_confidence95_deg


def test_line_projected_on_a_reading_errs_only_within_that_plane() -> None:
    bed = Reading("a", "a", "bedding", "plane", A.dip_direction_deg, A.dip_deg)
    found = measured(lineation("a"), model("m1", registration()), bed)
    # About the plane's normal.
    sigma = np.degrees(np.sqrt(A.normal() @ SHAPE[:3, :3] @ A.normal()))
    assert found.registration_error_deg == pytest.approx(FACTOR * sigma, rel=1e-3)


# --- lengths --------------------------------------------------------------------------------------
def dimension(kind: str, points: Sequence[Sequence[float]], **more: str) -> Dimension:
    vertices = tuple(map(tuple, np.asarray(points, float).tolist()))
    return Dimension("d1", "d", kind, "m1", "hash", vertices, **more)  # type: ignore[arg-type]


STEP = np.array([3.0, -4.0, 12.0])


def drawn_steps(size: int = 40_000) -> np.ndarray:
    """STEP after draws of turn and scale, to first order, as the covariance itself is."""
    root = np.linalg.cholesky(SHAPE + 1e-18 * np.eye(4))
    draws = np.random.default_rng(5).normal(size=(size, 4)) @ root.T
    return np.asarray(STEP + np.cross(draws[:, :3], STEP) + draws[:, 3:] * STEP)


def test_distance_error_comes_from_the_scale_error_only() -> None:
    found = measured(dimension("distance", [[0, 0, 0], STEP]), model("m1", registration()))
    assert found.dimension is not None
    assert found.dimension["distance_registration95_m"] == pytest.approx(
        NORMAL_QUANTILE95 * 0.01 * 13.0
    )


def test_vertical_and_horizontal_distances_include_the_rotation_error() -> None:
    found = measured(dimension("distance", [[0, 0, 0], STEP]), model("m1", registration()))
    assert found.dimension is not None
    moved = drawn_steps()
    assert found.dimension["vertical_registration95_m"] == pytest.approx(
        NORMAL_QUANTILE95 * moved[:, 2].std(), rel=0.02
    )
    # Along the horizontal direction that it has: to first order.
    along = moved[:, :2] @ STEP[:2] / 5.0
    assert found.dimension["horizontal_registration95_m"] == pytest.approx(
        NORMAL_QUANTILE95 * along.std(), rel=0.02
    )


def test_vertical_distance_has_a_horizontal_error_from_tilt() -> None:
    shape = np.diag([np.radians(1.0) ** 2, np.radians(2.0) ** 2, 0.0, 0.0])
    placed = model("m1", registration(shape=shape))
    found = measured(dimension("distance", [[0, 0, 0], [0, 0, 10.0]]), placed)
    assert found.dimension is not None
    # About north by 2 degrees it leans east.
    expected = NORMAL_QUANTILE95 * 10.0 * np.radians(2.0)
    assert found.dimension["horizontal_registration95_m"] == pytest.approx(expected, rel=1e-3)
    assert found.dimension["vertical_registration95_m"] == pytest.approx(0.0, abs=1e-12)


def test_relative_area_error_is_twice_the_scale_error() -> None:
    square = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]
    found = measured(dimension("area", square), model("m1", registration()))
    assert found.dimension is not None
    assert found.dimension["area_registration95_m2"] == pytest.approx(
        2 * NORMAL_QUANTILE95 * 0.01 * 4.0
    )
    assert found.dimension["perimeter_registration95_m"] == pytest.approx(
        NORMAL_QUANTILE95 * 0.01 * 8.0
    )


def thickness(of_plane: Feature, *models: Model) -> dict[str, float]:
    found = measured(dimension("thickness", [[0, 0, 0], STEP], plane_id="a"), *models, of_plane)
    assert found.dimension is not None
    return dict(found.dimension)


def test_thickness_error_on_one_model_comes_from_the_scale_error_only() -> None:
    found = thickness(on_plane("a", A, "m1"), model("m1", registration()))
    expected = NORMAL_QUANTILE95 * 0.01 * found["thickness_m"]
    assert found["thickness_registration95_m"] == pytest.approx(expected)
    assert found["thickness_total95_m"] == pytest.approx(
        np.hypot(found["thickness_error95_m"], expected)
    )


def test_thickness_across_a_compass_reading_includes_the_rotation_error() -> None:
    bed = Reading("a", "a", "bedding", "plane", A.dip_direction_deg, A.dip_deg)
    found = thickness(bed, model("m1", registration()))
    spread = (drawn_steps() @ A.normal()).std()
    assert found["thickness_registration95_m"] == pytest.approx(
        NORMAL_QUANTILE95 * spread, rel=0.02
    )
    # The error of the plane itself is not known, nor is then that of all together.
    assert "thickness_total95_m" not in found


def test_thickness_across_a_bed_of_another_model_combines_both_errors() -> None:
    both = model("m1", registration()), model("m2", registration("r2", 2.0 * SHAPE))
    found = thickness(on_plane("a", A, "m2"), *both)
    turned = direction_covariance(2.0 * SHAPE[:3, :3], A.normal())[0]
    spread = np.hypot((drawn_steps() @ A.normal()).std(), np.sqrt(STEP @ turned @ STEP))
    assert found["thickness_registration95_m"] == pytest.approx(
        NORMAL_QUANTILE95 * spread, rel=0.02
    )


def test_axis_errors_are_used_without_a_covariance() -> None:
    plain = Registration(
        "r1", "r", "gps", Frame("local"), rotation_error_deg=(0.0, 0.0, 1.0), scale_error=0.02
    )
    found = measured(dimension("distance", [[0, 0, 0], [10.0, 0, 0]]), model("m1", plain))
    assert found.dimension is not None
    assert found.dimension["distance_registration95_m"] == pytest.approx(NORMAL_QUANTILE95 * 0.2)
    # About north: what lies east goes up or down.
    expected = NORMAL_QUANTILE95 * 10.0 * np.radians(1.0)
    assert found.dimension["vertical_registration95_m"] == pytest.approx(expected)


def test_dimensions_without_registration_error_omit_its_figures() -> None:
    for placed in (Frame("local"), Registration("r1", "r", "gps", Frame("local"))):
        found = measured(dimension("distance", [[0, 0, 0], STEP]), model("m1", placed))
        assert found.dimension is not None
        assert not [name for name in found.dimension if "registration" in name]
