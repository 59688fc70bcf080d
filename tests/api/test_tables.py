"""Tables of orientations, whatever their convention, against the command and hand-made truth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest

import vomstudio as vs
from tests.messages import refused, warned
from vomstudio.project.tables.orientation_table import COLUMNS

Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def written(text: str) -> Path:
        path = tmp_path / "table.csv"
        path.write_text(text)
        return path

    return written


# One plane, dipping by 45 degrees to 120.
SAME_PLANE = {
    "dip direction": "dip direction,dip\n120,45\n",
    "strike": "strike,dip\n30,45\n",
    "quadrant": "strike,dip,quadrant\n210,45,SE\n",
    "in the cells": "strike,dip\nN30E,45SE\n",
    "pole": "pole trend;pole plunge\n300;45\n",
    "attitude": "attitude\n120/45\n",
    "ours": "id,dip_direction_deg,dip_deg,strike_rhr_deg\nB1,120,45,30\n",
}


@pytest.mark.parametrize("text", SAME_PLANE.values(), ids=SAME_PLANE)
def test_every_convention_gives_the_same_columns(write: Write, text: str) -> None:
    found = vs.read_orientations(write(text))
    assert list(found.columns)[: len(COLUMNS)] == list(COLUMNS)
    assert found.attrs["convention"].startswith("planes")
    row = found.iloc[0]
    figures = (row.dip_direction_deg, row.dip_deg, row.strike_rhr_deg)
    assert figures == pytest.approx((120.0, 45.0, 30.0))
    assert (row.pole_trend_deg, row.pole_plunge_deg) == pytest.approx((300.0, 45.0))
    assert row.element == "plane"
    assert np.isnan(row.trend_deg)


def test_lines_have_their_own_columns(write: Write) -> None:
    found = vs.read_orientations(write("name,trend,plunge\nL1,200,30\nL2,10,-5\n"))
    assert list(found["element"]) == ["line", "line"]
    assert found["trend_deg"].tolist() == [200.0, 10.0]
    assert found["dip_deg"].isna().all()
    assert list(found["name"]) == ["L1", "L2"]


def test_ambiguous_azimuth_must_be_declared(write: Write) -> None:
    path = write("azimuth,dip\n120,45\n")
    with refused("orientation.ambiguous-azimuth", vs.errors.UsageError):
        vs.read_orientations(path)
    assert vs.read_orientations(path, azimuth="strike")["dip_direction_deg"][0] == 210.0
    assert vs.read_orientations(path, azimuth="dipdir")["dip_direction_deg"][0] == 120.0


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("dip_direction,dip\n120,95\n", "orientation.overturned-dip", 2),
        ("dip_direction,dip\n120,up\n", "table.not-a-number", 2),
        ("colour,size\nred,3\n", "orientation.no-columns", 1),
        ("dip_direction,dip\n", "table.no-rows", 1),
    ],
)
def test_errors_name_file_line_and_column(write: Write, text: str, code: str, line: int) -> None:
    path = write(text)
    with refused(code, file=path, line=line, field=None if code == "table.no-rows" else "dip"):
        vs.read_orientations(path)


def test_missing_file_is_named() -> None:
    with refused("file.missing", file="nowhere.csv"):
        vs.read_orientations("nowhere.csv")


def test_fit_table_survives_round_trip(command: Any, tmp_path: Path, picks: Any) -> None:
    path = tmp_path / "planes.csv"
    command("fit", vs.sample("picks.csv"), "--by", "pick", "-o", path)
    read, made = vs.read_orientations(path), vs.fit_planes(picks, by="pick")
    for name in COLUMNS:
        if made[name].dtype == object or made[name].dtype == bool:
            # No text and an empty one are the same in a file.
            assert [v or None for v in read[name]] == [v or None for v in made[name]], name
        else:
            np.testing.assert_allclose(read[name], made[name], rtol=1e-9, err_msg=name)


def test_additional_columns_are_kept(write: Write) -> None:
    found = vs.read_orientations(write("dip_direction,dip,site,weight\n10,20,A,1.5\n30,40,B,2\n"))
    assert list(found["site"]) == ["A", "B"]
    assert found["weight"].tolist() == [1.5, 2.0]


def test_rows_without_angles_are_dropped_with_warning(write: Write) -> None:
    path = write("dip_direction,dip\n10,20\nnan,nan\n30,40\n")
    with pytest.warns(vs.errors.VomWarning) as caught:
        found = vs.read_orientations(path)
    (warning,) = [each.message for each in caught]
    assert isinstance(warning, vs.errors.VomWarning)
    assert (warning.code, warning.values["lines"]) == ("table.rows-left-out", (3,))
    assert found.attrs["dropped_lines"] == [3]
    assert len(found) == 2


# --- what is handed over in memory ----------------------------------------------------------------
@pytest.mark.parametrize(
    ("columns", "named"),
    [
        ({"dip_dir": [120], "dip": [45]}, "dip direction/dip"),
        ({"strike": [30], "dip": [45]}, "strike (right-hand rule)/dip"),
        ({"Strike": [210], "Dip": [45], "Quadrant": ["SE"]}, "quadrant"),
    ],
)
def test_data_frames_are_interpreted_like_files(columns: Any, named: str) -> None:
    found = vs.stats(pandas.DataFrame(columns))
    assert named in found.convention
    mean = found.sets["all"].tensor.axes[0]
    assert (mean.trend_deg, mean.plunge_deg) == pytest.approx((300.0, 45.0))


def test_file_table_and_arrays_give_equal_statistics(data_dir: Path) -> None:
    path = data_dir / "planes" / "big_elk_strike_dip.txt"
    table = vs.read_orientations(path)
    arrays = (table["dip_direction_deg"], table["dip_deg"])
    by_each = [vs.stats(each).sets["all"] for each in (path, table, arrays, np.array(arrays))]
    assert all(one == by_each[0] for one in by_each)


@pytest.mark.parametrize(
    ("given", "code", "values"),
    [
        (([10, 20], [95, 20]), "orientation.overturned-dip", {"value": 95}),
        (([10, 20], [-5, 20]), "angle.out-of-range", {"value": -5, "maximum": 90}),
        (([10, 900], [5, 20]), "angle.out-of-range", {"value": 900, "maximum": 720}),
        (([10, 20], [5]), "array.lengths-differ", {"count": 2, "other_count": 1}),
        (([10, np.nan], [5, 5]), "array.not-finite", {"first_row": 1}),
        ((["N", "S"], [5, 5]), "array.not-numbers", {"field": "dip_direction"}),
        (([[10], [20]], [5, 5]), "array.shape", {"shape": (2, 1)}),
        (([], []), "argument.empty", {}),
        ((1, 2, 3), "argument.wrong-type", {"type": "tuple"}),
        (np.zeros((5, 2)), "argument.wrong-type", {"type": "ndarray"}),
        (7, "argument.wrong-type", {"type": "int"}),
        (None, "argument.wrong-type", {"type": "NoneType"}),
        ({"dip": [3]}, "argument.wrong-type", {"type": "dict"}),
        (
            pandas.DataFrame({"colour": ["red"]}),
            "orientation.no-columns",
            {"columns": ("colour",)},
        ),
        (
            pandas.DataFrame({"dip_dir": [10], "dip": ["steep"]}),
            "table.not-a-number",
            {"cell": "steep"},
        ),
        (pandas.DataFrame({"dip_dir": [], "dip": []}), "argument.empty", {"field": "table"}),
    ],
)
def test_invalid_orientations_are_refused(given: Any, code: str, values: dict[str, Any]) -> None:
    with refused(code, **values):
        vs.stats(given)


def test_values_in_radians_give_warning() -> None:
    chance = np.random.default_rng(4)
    direction, dip = chance.uniform(0, 2 * np.pi, 30), chance.uniform(0.1, np.pi / 2, 30)
    with warned("compass.radians"):
        vs.stats((direction, dip))
    # The same in degrees, and beds that are nearly flat, are what they are.
    vs.stats((np.degrees(direction), np.degrees(dip)))
    vs.stats((chance.uniform(0, 360, 30), chance.uniform(0, 1.5, 30)))


@pytest.mark.parametrize("text", SAME_PLANE.values(), ids=SAME_PLANE)
def test_table_read_from_file_is_accepted_by_statistics(write: Write, text: str) -> None:
    """The file's own columns, which follow ours, do not claim the same angles once more."""
    path = write(text)
    read = vs.read_orientations(path)
    mean = vs.stats(read).sets["all"].tensor.axes[0]
    assert (mean.trend_deg, mean.plunge_deg) == pytest.approx((300.0, 45.0))
    again = vs.stats(str(path)).sets["all"].tensor.axes[0]
    assert mean.trend_deg == pytest.approx(again.trend_deg)


@pytest.mark.parametrize("word", ["1", "x", "Yes", "overturned", "ja", "T"])
def test_overturned_column_accepts_common_words(word: str, tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "beds.csv"
    path.write_text(f"dip direction,dip,Inverted\n90,45,{word}\n90,30,no\n90,20,\n")
    read = vs.read_orientations(path)
    assert read["overturned"].tolist() == [True, False, None]
