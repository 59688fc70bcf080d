"""Planes of the Python interface against the command, numpy's SVD, and the symmetries of space."""

from __future__ import annotations

import inspect
from dataclasses import FrozenInstanceError, fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
from hypothesis import given
from hypothesis import strategies as st

import vomstudio as vs
from tests.messages import refused, warned
from vomstudio.project.tables.orientation_table import COLUMNS

SAMPLE = vs.sample("picks.csv")


def points_on(dip_direction: float, dip: float, n: int = 40, seed: int = 1) -> np.ndarray:
    """(n, 3) on a plane by its definition: down the dip direction the height falls by tan(dip)."""
    chance = np.random.default_rng(seed)
    along, across = chance.uniform(-5, 5, (2, n))
    a, d = np.radians(dip_direction), np.radians(dip)
    down = np.array([np.sin(a) * np.cos(d), np.cos(a) * np.cos(d), -np.sin(d)])
    strike = np.array([-np.cos(a), np.sin(a), 0.0])
    return np.outer(along, strike) + np.outer(across, down)


def angle_between(a: float, b: float) -> float:
    return abs((a - b + 180.0) % 360.0 - 180.0)


@given(st.floats(0, 359.99), st.floats(0.5, 89.5))
def test_known_plane_is_recovered(dip_direction: float, dip: float) -> None:
    fit = vs.fit_plane(points_on(dip_direction, dip) + [364_520.0, 4_721_864.0, 850.0])
    assert angle_between(fit.dip_direction_deg, dip_direction) < 1e-3
    assert fit.dip_deg == pytest.approx(dip, abs=1e-4)
    assert angle_between(fit.strike_rhr_deg, dip_direction - 90.0) < 1e-3


def test_rotating_points_rotates_dip_direction() -> None:
    rough = points_on(70, 35) + np.random.default_rng(3).normal(0, 0.05, (40, 3))
    turn = np.radians(30.0)
    # Clockwise seen from above, as azimuths count.
    matrix = [[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    here, there = vs.fit_plane(rough), vs.fit_plane(rough @ np.array(matrix).T)
    assert angle_between(there.dip_direction_deg, here.dip_direction_deg + 30.0) < 1e-9
    assert there.dip_deg == pytest.approx(here.dip_deg)
    assert there.max_confidence95_deg == pytest.approx(here.max_confidence95_deg)


def test_normal_matches_numpy_svd() -> None:
    rough = points_on(200, 60) + np.random.default_rng(5).normal(0, 0.1, (40, 3))
    normal = np.linalg.svd(rough - rough.mean(axis=0))[2][2]
    fit = vs.fit_plane(rough)
    assert abs(fit.normal @ normal) == pytest.approx(1.0, abs=1e-12)
    assert np.linalg.norm(fit.normal) == pytest.approx(1.0)
    assert fit.centroid == pytest.approx(rough.mean(axis=0))
    assert fit.rms_m == pytest.approx(np.sqrt(np.mean(((rough - fit.centroid) @ normal) ** 2)))


def test_published_planes_are_reproduced(data_dir: Path) -> None:
    points = np.loadtxt(data_dir / "planes" / "well_defined.txt")
    fit = vs.fit_plane(points)
    assert (fit.strike_rhr_deg, fit.dip_deg) == pytest.approx((11.266, 3.492), abs=1e-3)
    assert fit.max_angular_error_deg == pytest.approx(0.475, abs=1e-3)
    assert fit.min_angular_error_deg == pytest.approx(0.147, abs=1e-3)


# --- the same as the command ----------------------------------------------------------------------
def rows_of(frame: Any) -> list[dict[str, Any]]:
    """As JSON has them."""
    return [
        {k: None if v is None or v != v else v for k, v in row.items()}
        for row in frame.to_dict("records")
    ]


def test_planes_match_command_output(command: Any, picks: Any) -> None:
    told = command("fit", SAMPLE, "--by", "pick")["planes"]
    made = rows_of(vs.fit_planes(picks, by="pick"))
    assert [row.keys() for row in made] == [row.keys() for row in told]
    for row, other in zip(made, told, strict=True):
        assert row == {k: pytest.approx(v) if isinstance(v, float) else v for k, v in other.items()}
    by_name = {name: group[["x", "y", "z"]] for name, group in picks.groupby("pick", sort=False)}
    bare = [{**row, "kind": None, "set": None} for row in made]
    assert rows_of(vs.fit_planes(by_name)) == bare


def test_fit_plane_matches_row_of_fit_planes(picks: Any) -> None:
    bed = picks[picks["pick"] == "B03"]
    (row,) = rows_of(vs.fit_planes({"B03": bed}))
    fit = vs.fit_plane(bed)
    assert {k: v for k, v in fit.to_dict().items() if k != "id"} == {
        k: row[k] for k in fit.to_dict() if k != "id"
    }


def test_attributes_match_table_columns() -> None:
    for kind in (vs.PlaneFit, vs.LineFit):
        assert tuple(field.name for field in fields(kind)) == (*COLUMNS, "warnings")


def test_horizontal_plane_has_no_azimuth_but_is_still_a_plane() -> None:
    level = [[0, 0, 1], [4, 0, 1], [0, 4, 1], [3, 3, 1]]
    flat = vs.fit_plane(level)
    assert (flat.element, flat.undefined, flat.dip_deg, flat.pole_plunge_deg) == (
        "plane",
        True,
        0.0,
        90.0,
    )
    assert [flat.dip_direction_deg, flat.strike_rhr_deg, flat.pole_trend_deg] == [None] * 3
    assert repr(flat).startswith("PlaneFit(000")
    assert "None" not in flat._repr_html_()
    # A table has the azimuth of a horizontal plane by convention, and says so.
    (row,) = rows_of(vs.fit_planes({"a": level}))
    assert (row["dip_direction_deg"], row["undefined"]) == (0.0, True)
    cliff = vs.read(SAMPLE.with_name("sample.obj"))
    by_fit = vs.section(cliff, plane=flat, through=cliff.bounds.mean(axis=0))
    assert by_fit.length_m == vs.section(cliff, plane="0/0", through=cliff.bounds.mean(0)).length_m


def test_reasons_and_notes_of_the_verdict_are_warnings_with_values() -> None:
    straight = vs.fit_plane([[k, 0.01 * (k % 2), 0.01 * (k % 3)] for k in range(5)])
    by_code = {each.code: each for each in straight.warnings}
    assert straight.reason_codes == "plane.too-straight"
    assert by_code["plane.too-straight"].values["error_deg"] > 80
    assert " ".join(each.message for each in straight.warnings) == (
        f"{straight.quality_reason} {straight.quality_notes}"
    )
    assert "warnings" not in straight.to_dict()
    with pytest.raises(FrozenInstanceError):
        straight.warnings = ()  # type: ignore[misc]


def test_line_attributes_of_plane_are_none() -> None:
    fit = vs.fit_plane(points_on(7, 35))
    of_lines = [name for name in COLUMNS if "slip" in name or name.startswith(("trend", "plunge"))]
    assert len(of_lines) == 5
    assert all(getattr(fit, name) is None for name in [*of_lines, "rake_deg", "on_plane"])


def test_fit_is_immutable_and_has_repr() -> None:
    fit = vs.fit_plane(points_on(7, 35))
    with pytest.raises(FrozenInstanceError):
        fit.dip_deg = 3.0  # type: ignore[misc]
    assert repr(fit).startswith("PlaneFit(007")
    assert "dip_direction_deg" in fit._repr_html_()


# --- options --------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("dip_direction", "dip", "axis"), [(90, 85, "x"), (0, 85, "y"), (90, 5, "z")]
)
def test_a_regression_takes_the_axis_nearest_the_normal(
    dip_direction: float, dip: float, axis: Any
) -> None:
    rough = points_on(dip_direction, dip) + np.random.default_rng(2).normal(0, 0.2, (40, 3))
    own = vs.fit_plane(rough, method="regression")
    assert own == vs.fit_plane(rough, method="regression", axis=axis)
    column = "xyz".index(axis)
    others = [i for i in range(3) if i != column]
    design = np.column_stack([rough[:, others], np.ones(len(rough))])
    slopes = np.linalg.lstsq(design, rough[:, column], rcond=None)[0]
    normal = np.zeros(3)
    normal[others], normal[column] = -slopes[:2], 1.0
    assert abs(own.normal @ normal / np.linalg.norm(normal)) == pytest.approx(1.0, abs=1e-9)


def test_the_resolution_enters_the_verdict() -> None:
    points = points_on(50, 40, n=12)
    fine, coarse = (vs.fit_plane(points, resolution_m=m) for m in (0.001, 2.0))
    assert fine.extent_over_resolution == pytest.approx(2000 * coarse.extent_over_resolution)
    assert fine.quality == "good"
    assert coarse.quality != "good"
    assert set(coarse.reason_codes.split()) & {"plane.resolution", "plane.too-small"}


# --- what cannot be -------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("given", "code", "values"),
    [
        ([], "argument.empty", {}),
        (None, "array.not-points", {"shape": ()}),
        ([["1", "2", "3"]] * 4, "array.not-numbers", {"type": "list"}),
        ([[1, 2, 3], [4, 5]], "array.not-numbers", {"type": "list"}),
        ([[1, 2, 3j]] * 4, "array.not-numbers", {"type": "list"}),
        ([1.0, 2.0, 3.0], "array.not-points", {"shape": (3,)}),
        (np.zeros((3, 9)), "array.not-points", {"shape": (3, 9)}),
        (np.zeros((9, 2)), "array.not-points", {"shape": (9, 2)}),
        (np.zeros((2, 2, 3)), "array.not-points", {"shape": (2, 2, 3)}),
        (
            [[0, 0, 0], [1, 0, 0], [0, np.nan, 0], [np.inf, 0, 0]],
            "array.not-finite",
            {"first_row": 2, "count": 2},
        ),
        (
            [[0, 0, 0], [1, 0, 0], [0, 1, 1e300]],
            "array.not-finite",
            {"first_row": 2, "count": 1},
        ),
        (np.ma.masked_less(np.ones((4, 3)), 2), "array.masked", {}),
        (
            pandas.DataFrame({"a": [1], "b": [2], "c": [3]}),
            "table.missing-column",
            {"column": "x", "columns": ("a", "b", "c")},
        ),
        (
            pandas.DataFrame({"x": [1], "X": [2], "y": [3], "z": [1]}),
            "table.repeated-column",
            {"column": "x", "columns": ("x", "X")},
        ),
    ],
)
def test_invalid_point_arrays_are_refused(given: Any, code: str, values: Any) -> None:
    with refused(code, field="points", **values):
        vs.fit_plane(given)


def test_string_argument_is_a_file_name() -> None:
    with refused("file.missing", file="north"):
        vs.fit_plane("north")


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ([[0, 0, 0], [1, 0, 0]], "feature.too-few-points"),
        ([[1, 1, 1]] * 5, "points.coincident"),
        ([[i, 2 * i, 0] for i in range(6)], "points.collinear"),
    ],
)
def test_points_without_a_plane_are_refused_with_the_reason(given: Any, code: str) -> None:
    with refused(code, vs.errors.GeometryError):
        vs.fit_plane(given)


@pytest.mark.parametrize(
    "wrong",
    [
        {"method": "ransac"},
        {"axis": "w"},
        {"resolution_m": -1},
        {"resolution_m": "fine"},
        {"profile": "taste"},
    ],
)
def test_invalid_settings_are_refused(wrong: Any) -> None:
    with pytest.raises(vs.errors.VomError):
        vs.fit_plane(points_on(10, 20), **wrong)


def test_groups_without_a_plane_are_named(picks: Any) -> None:
    bed = picks[picks["pick"] == "B01"][["x", "y", "z"]].to_numpy()
    with warned("feature.left-out", feature="short"):
        made = vs.fit_planes({"bed": bed, "short": bed[:2]})
    assert list(made["id"]) == ["bed"]
    assert made.attrs["skipped"][0]["id"] == "short"
    with refused("plane.none-fitted", vs.errors.GeometryError, count=1, field="short"):
        vs.fit_planes({"short": bed[:2]})


def test_rows_without_coordinates_are_dropped_and_counted(picks: Any) -> None:
    holes = picks.copy()
    holes.loc[[3, 40], "x"] = np.nan
    with warned("array.rows-left-out", count=2):
        made = vs.fit_planes(holes, by="pick")
    assert made["n_points"].sum() == len(picks) - 2


@pytest.mark.parametrize(
    ("groups", "by", "kind"),
    [
        ({}, None, "InputError"),
        (5, None, "InputError"),
        ({"a": [[1, 2]]}, None, "InputError"),
        ({"a": [[1, 2, 3]] * 4}, "pick", "UsageError"),
        (pandas.DataFrame({"x": [1.0], "y": [1.0], "z": [1.0]}), None, "UsageError"),
        (pandas.DataFrame({"x": [1.0], "y": [1.0], "z": [1.0]}), "pick", "UsageError"),
        (
            pandas.DataFrame({"x": ["a"], "y": [1.0], "z": [1.0], "pick": ["a"]}),
            "pick",
            "InputError",
        ),
        (
            pandas.DataFrame({"x": [np.nan], "y": [1.0], "z": [1.0], "pick": ["a"]}),
            "pick",
            "InputError",
        ),
    ],
)
def test_invalid_groups_are_refused(groups: Any, by: Any, kind: str) -> None:
    with pytest.raises(getattr(vs.errors, kind)):
        vs.fit_planes(groups, by=by)


def test_group_ids_are_preserved() -> None:
    made = vs.fit_planes({7: points_on(10, 20), (1, 2): points_on(20, 30)})
    assert list(made["id"]) == [7, (1, 2)]


def test_input_is_not_modified() -> None:
    points = points_on(10, 20)
    before = points.copy()
    points.setflags(write=False)
    vs.fit_plane(points)
    assert (points == before).all()
    assert "points" in inspect.signature(vs.fit_plane).parameters
