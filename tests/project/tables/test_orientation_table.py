"""Orientation tables: the usual conventions are told apart, and our own comes back as written."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.messages import by_code
from vomstudio.core.errors import InputError, TargetError, UsageError
from vomstudio.geology.folds import fold_axis
from vomstudio.geology.orientation import Line, Plane, line_from_rake
from vomstudio.geology.quality import governing_confidence_deg, judge, resolution_tilt_deg
from vomstudio.geometry.planes import fit_plane
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.project.tables.orientation_table import (
    COLUMNS,
    Row,
    line_row,
    plane_row,
    plane_rows,
    write_orientation_csv,
)

Write = Callable[[str], Path]

# Strike 30 by the right-hand rule and dip 40 is a plane that dips toward 120.
DIP_DIRECTION, DIP = 120.0, 40.0


@pytest.fixture
def table(tmp_path: Path) -> Write:
    def write(content: str) -> Path:
        path = tmp_path / "table.csv"
        path.write_text(content, encoding="utf-8")
        return path

    return write


def only_plane(found: OrientationTable) -> tuple[float, float]:
    assert found.is_plane.tolist() == [True]
    return float(found.dip_direction_deg[0]), float(found.dip_deg[0])


def refused(path: Path, azimuth: str | None = None) -> InputError | UsageError:
    with pytest.raises((InputError, UsageError)) as caught:
        read_orientations(path, azimuth)  # type: ignore[arg-type]
    assert caught.value.file == str(path)
    return caught.value


# -------------------------------------------------------------------------------- conventions


@pytest.mark.parametrize(
    "text",
    [
        "dip_direction_deg,dip_deg\n120,40\n",
        "Dip Direction,Dip\n120,40\n",
        "dipdir;dip\n120;40\n",
        "DIP_DIR\tDIP\n120,0\t40,0\n",
        "dip direction dip\n120 40\n",
        "DipDir (°),Dip (°)\n120,40\n",
        "Dip,DipDirection\n40,120\n",
        "strike,dip\n30,40\n",
        "Strike (RHR),Dip\n30,40\n",
        "strike_lhr,dip\n210,40\n",
        "Strike (LHR) dip\n210 40\n",
        "strike,dip,dip quadrant\n30,40,SE\n",
        "strike,dip,quadrant\n210,40,SE\n",
        "strike,dip,direction\n210,40,SE\n",
        "strike,dip,dips to\n210,40,SE\n",
        "strike,dip,dip direction\n210,40,SE\n",
        "strike,dip\nN30E,40SE\n",
        "strike,dip\nS30W,40 SE\n",
        "id,attitude\na,N30E 40SE\n",
        "dip direction,dip\nS60E,40\n",
        "dip direction;dip\n120°;39°60'\n",
        "pole_trend,pole_plunge\n300,50\n",
        "id,strike,dip,dip_dir\na,30,40,120\n",
    ],
)
def test_one_plane_in_any_common_notation_is_the_same_plane(table: Write, text: str) -> None:
    found = read_orientations(table(text))
    assert only_plane(found) == pytest.approx((DIP_DIRECTION, DIP))
    assert found.convention.startswith("planes ")
    assert found.warnings == ()


@pytest.mark.parametrize(
    "text",
    [
        "trend,plunge\n300,50\n",
        "Plunge Trend\n50 300\n",
        "azimuth,plunge\n300,50\n",
        "trend,plunge\nN60W,50°\n",
    ],
)
def test_one_line_in_any_common_notation_is_the_same_line(table: Write, text: str) -> None:
    found = read_orientations(table(text))
    assert found.is_plane.tolist() == [False]
    assert (found.trend_deg[0], found.plunge_deg[0]) == (300.0, 50.0)
    assert "trend/plunge" in found.convention


@pytest.mark.parametrize(
    "text", ["azimuth,dip\n30,40\n", "AZ dip\n30 40\n", "30 40\n", "30,40,9\n"]
)
def test_azimuth_of_unknown_meaning_is_rejected_until_specified(table: Write, text: str) -> None:
    path = table(text)
    assert "--azimuth strike" in refused(path).message
    assert only_plane(read_orientations(path, "strike")) == pytest.approx((120.0, 40.0))
    assert only_plane(read_orientations(path, "dipdir")) == pytest.approx((30.0, 40.0))


def test_named_column_needs_no_azimuth_option_and_ignores_it(table: Write) -> None:
    path = table("strike,dip\n30,40\n")
    assert only_plane(read_orientations(path, "dipdir")) == pytest.approx((120.0, 40.0))


def test_right_hand_rule_is_used_if_a_quadrant_is_empty(table: Write) -> None:
    found = read_orientations(table("strike,dip,quadrant\n30,40,\n30,40,NW\n"))
    assert found.dip_direction_deg.tolist() == pytest.approx([120.0, 300.0])


def test_compass_points_of_unknown_meaning_are_ignored_and_reported(table: Write) -> None:
    found = read_orientations(table("strike,dip,limb\n30,40,NE\n"))
    assert found.dip_direction_deg[0] == pytest.approx(DIP_DIRECTION)
    assert by_code(found.warnings)["orientation.quadrants-unused"] == {"columns": "'limb'"}


def test_quadrant_along_the_strike_is_rejected_with_its_line(table: Write) -> None:
    error = refused(table("strike,dip,quadrant\n30,40,SE\n0,40,N\n"))
    assert error.line == 3


def test_strike_column_contradicting_the_dip_direction_is_reported(table: Write) -> None:
    found = read_orientations(table("strike,dip,dip_dir\n30,40,120\n210,40,120\n"))
    assert found.dip_direction_deg.tolist() == [120.0, 120.0]
    assert by_code(found.warnings)["orientation.strike-differs"]["lines"] == (3,)


def test_left_hand_strikes_beside_dip_directions_are_reported(table: Write) -> None:
    found = read_orientations(table("strike,dip,dip_dir\n210,40,120\n100,50,10\n0,0,0\n,20,30\n"))
    assert list(by_code(found.warnings)) == ["orientation.strike-left-hand"]
    assert found.dip_direction_deg.tolist() == [120.0, 10.0, 0.0, 30.0]


def test_azimuths_over_360_are_wrapped_and_reported(table: Write) -> None:
    found = read_orientations(table("strike,dip\n390,40\n-330,40\n360,10\n30,40\n"))
    assert found.dip_direction_deg.tolist() == pytest.approx([120.0, 120.0, 90.0, 120.0])
    assert by_code(found.warnings)["orientation.azimuths-wrapped"]["lines"] == (2, 3)


def test_strike_over_360_beside_a_quadrant_is_wrapped_and_reported(table: Write) -> None:
    found = read_orientations(table("strike,dip,quadrant\n390,40,SE\n30,40,SE\n"))
    assert found.dip_direction_deg.tolist() == pytest.approx([120.0, 120.0])
    assert by_code(found.warnings)["orientation.azimuths-wrapped"]["lines"] == (2,)


@pytest.mark.parametrize("dip", ["90.5", "-1", "inf", "120"])
def test_dip_outside_0_to_90_is_rejected_with_its_line(table: Write, dip: str) -> None:
    error = refused(table(f"strike,dip\n30,40\n30,{dip}\n"))
    assert (error.line, error.field) == (3, "dip")


@pytest.mark.parametrize("azimuth", ["721", "-400", "inf", "1e308"])
def test_impossible_azimuth_is_rejected_with_its_line(table: Write, azimuth: str) -> None:
    error = refused(table(f"dipdir,dip\n30,40\n{azimuth},40\n"))
    assert (error.line, error.field) == (3, "dipdir")


def test_rows_without_angles_are_dropped_and_reported_by_line(table: Write) -> None:
    found = read_orientations(table("id,strike,dip\na,30,40\nb,,40\nc,30,nan\nd,40,50\n"))
    assert found.ids == ("a", "d")
    assert found.dropped == (3, 4)
    assert by_code(found.warnings)["table.rows-left-out"]["lines"] == (3, 4)


def test_a_horizontal_plane_needs_no_direction(table: Write) -> None:
    found = read_orientations(table("strike,dip\n,0\n45,0\n"))
    assert found.dip_deg.tolist() == [0.0, 0.0]
    assert found.dip_direction_deg.tolist() == [0.0, 0.0]


def test_a_directed_line_may_point_up(table: Write) -> None:
    found = read_orientations(table("trend,plunge\n0,-30\n"))
    assert found.vectors()[0] == pytest.approx([0.0, math.sqrt(0.75), 0.5])


@pytest.mark.parametrize(
    ("text", "code", "value"),
    [
        ("strike\n30\n", "table.missing-column", "dip"),
        ("dip\n30\n", "table.missing-column", "dip direction"),
        ("trend\n30\n", "table.missing-column", "plunge"),
        ("plunge\n30\n", "table.missing-column", "trend"),
        ("a,b\n1,2\n", "orientation.no-columns", ("a", "b")),
        ("strike,strike,dip\n1,2,3\n", "table.repeated-column", "strike"),
        ("strike,dip\n", "table.no-rows", None),
        ("strike,dip\nnan,nan\n", "table.no-valid-rows", 1),
        ("strike,dip\nthirty,40\n", "table.not-a-number", "thirty"),
        ("strike,dip\n30,40\n30\n", "table.ragged-row", 1),
        ("element,strike,dip\nvolume,30,40\n", "table.unknown-word", "volume"),
        ("30\n40\n", "table.column-count", 1),
        ("trend,plunge\nN60W,50\nup,50\n", None, None),
        ("dip direction,dip\n120°,95°\n", "orientation.overturned-dip", 95.0),
        ("dip direction,dip\n-120°,40\n", None, None),
    ],
)
def test_invalid_orientation_table_is_rejected_with_the_reason(
    table: Write, text: str, code: str | None, value: object
) -> None:
    error = refused(table(text))
    assert code is None or error.code == code
    assert value is None or value in error.values.values()


def test_planes_and_lines_may_share_a_table(table: Write) -> None:
    text = "element,dip_dir,dip,trend,plunge\nplane,120,40,,\nline,,,300,50\n,120,40,,\n"
    found = read_orientations(table(text))
    assert found.is_plane.tolist() == [True, False, True]
    poles = found.vectors()
    assert poles[0] == pytest.approx(poles[1])


def test_strike_and_dip_file_gives_the_published_fold_axis(data_dir: Path) -> None:
    found = read_orientations(data_dir / "planes" / "big_elk_strike_dip.txt", "strike")
    assert len(found) == 61
    axis = fold_axis(found.dip_direction_deg, found.dip_deg)
    assert axis.beta.trend_deg == pytest.approx(125.3, abs=0.05)
    assert axis.beta.plunge_deg == pytest.approx(26.1, abs=0.05)


# ------------------------------------------------------------------------------------ our own


def a_plane(**metadata: object) -> Row:
    rng = np.random.default_rng(7)
    uv = rng.uniform(-5, 5, (40, 2))
    points = np.column_stack([uv, 0.3 * uv[:, 0] - 0.2 * uv[:, 1] + rng.normal(0, 0.01, 40)])
    fit = fit_plane(points + np.array([576_700.0, 5_188_100.0, 160.0]))
    verdict = judge(fit, resolution_m=0.05, outcrop_normal=None)
    return plane_row(fit, verdict, resolution_m=0.05, **metadata)


def test_row_has_exactly_the_documented_columns_in_order() -> None:
    # The contract of the command line: other programs count on names and order.
    assert COLUMNS == (
        "id",
        "name",
        "kind",
        "element",
        "set",
        "dip_direction_deg",
        "dip_deg",
        "strike_rhr_deg",
        "pole_trend_deg",
        "pole_plunge_deg",
        "trend_deg",
        "plunge_deg",
        "rake_deg",
        "slip_rake_deg",
        "slip_sense",
        "slip_confidence",
        "on_plane",
        "on_plane_dip_direction_deg",
        "on_plane_dip_deg",
        "overturned",
        "undefined",
        "x",
        "y",
        "z",
        "normal_x",
        "normal_y",
        "normal_z",
        "n_points",
        "extent_m",
        "area_m2",
        "rms_m",
        "lambda1",
        "lambda2",
        "lambda3",
        "coplanarity",
        "collinearity",
        "M",
        "K",
        "max_angular_error_deg",
        "min_angular_error_deg",
        "max_confidence95_deg",
        "min_confidence95_deg",
        "error_rake_deg",
        "dip_error_deg",
        "dip_direction_error_deg",
        "registration_error_deg",
        "total95_deg",
        "normal_cov_ee",
        "normal_cov_en",
        "normal_cov_eu",
        "normal_cov_nn",
        "normal_cov_nu",
        "normal_cov_uu",
        "resolution_m",
        "extent_over_resolution",
        "bend_deg",
        "attitude_scale",
        "quality",
        "quality_reason",
        "reason_codes",
        "quality_notes",
        "profile",
        "method",
        "model",
        "frame",
        "notes",
    )
    assert tuple(a_plane()) == COLUMNS
    assert tuple(line_row(Line(30.0, 20.0))) == COLUMNS
    with pytest.raises(TypeError, match="colour"):
        a_plane(colour="red")


def test_angles_of_a_row_describe_one_plane() -> None:
    row = a_plane()
    # z = 0.3 x - 0.2 y dips against its gradient, with the gradient's slope.
    assert row["dip_direction_deg"] == pytest.approx(
        math.degrees(math.atan2(-0.3, 0.2)) % 360, abs=0.2
    )
    assert row["dip_deg"] == pytest.approx(math.degrees(math.atan(math.hypot(0.3, 0.2))), abs=0.1)
    assert row["strike_rhr_deg"] == pytest.approx((row["dip_direction_deg"] - 90) % 360)
    assert row["pole_trend_deg"] == pytest.approx((row["dip_direction_deg"] + 180) % 360)
    assert row["pole_plunge_deg"] == pytest.approx(90 - row["dip_deg"])
    assert row["lambda1"] + row["lambda2"] + row["lambda3"] == pytest.approx(1.0)
    assert row["coplanarity"] == pytest.approx(1 / row["lambda3"])
    assert row["extent_over_resolution"] == pytest.approx(row["extent_m"] / 0.05)
    assert [row["x"], row["y"]] == pytest.approx([576_700.0, 5_188_100.0], abs=2.0)
    assert row["undefined"] is False
    assert row["trend_deg"] is None


def test_registration_error_widens_the_total_error() -> None:
    fit = fit_plane(np.array([[0, 0, 0], [9, 0, 0.1], [0, 9, 0], [9, 9, 0], [4, 5, 0.1]]))
    verdict = judge(fit, resolution_m=None, outcrop_normal=None)
    row = plane_row(fit, verdict, registration_error_deg=2.0)
    own = governing_confidence_deg(fit)
    assert own is not None
    assert row["total95_deg"] == pytest.approx(math.hypot(own, 2.0))
    assert plane_row(fit, verdict)["total95_deg"] == own
    coarse = plane_row(fit, verdict, resolution_m=4.0, registration_error_deg=2.0)
    tilt = resolution_tilt_deg(fit, 4.0)
    assert tilt is not None
    assert tilt > own
    assert coarse["total95_deg"] == pytest.approx(math.hypot(tilt, 2.0))


@pytest.mark.parametrize("registration_deg", [None, 2.0])
def test_covariance_of_the_normal_matches_the_total_error(registration_deg: float | None) -> None:
    """Its axes are the normal, the direction in which the plane tilts most, and that across it."""
    row = a_plane(registration_error_deg=registration_deg)
    covariance = covariance_of(row)
    squares, axes = np.linalg.eigh(covariance)
    chi2 = -2.0 * math.log(0.05)
    assert math.degrees(math.sqrt(chi2 * squares[2])) == pytest.approx(row["total95_deg"])
    smallest = math.hypot(row["min_confidence95_deg"], registration_deg or 0.0)
    assert math.degrees(math.sqrt(chi2 * squares[1])) == pytest.approx(smallest)
    normal = [row["normal_x"], row["normal_y"], row["normal_z"]]
    assert abs(axes[:, 0] @ normal) == pytest.approx(1.0)
    plane = Plane(row["dip_direction_deg"], row["dip_deg"])
    tilt = line_from_rake(plane, row["error_rake_deg"]).vector()
    assert abs(axes[:, 2] @ tilt) == pytest.approx(1.0)


def test_covariance_table_rotates_with_the_world() -> None:
    rng = np.random.default_rng(3)
    points = rng.normal(0, [4, 2, 0.02], (30, 3)) @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn = np.array(
        [[math.cos(0.5), math.sin(0.5), 0], [-math.sin(0.5), math.cos(0.5), 0], [0, 0, 1]]
    )
    first, turned = (
        covariance_of(plane_row(fit, judge(fit, resolution_m=None, outcrop_normal=None)))
        for fit in (fit_plane(points), fit_plane(points @ turn.T))
    )
    assert turned == pytest.approx(turn @ first @ turn.T, abs=1e-9)


def test_batch_rows_equal_the_rows_of_single_planes() -> None:
    rng = np.random.default_rng(5)
    fits = []
    for number in range(300):
        points = rng.normal(0, [4, 2, 0.02], (3 + number % 20, 3))
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0] if number % 3 else np.eye(3)[[2, 0, 1]]
        fits.append(fit_plane(points @ turn if number % 7 else points))
    verdicts = [judge(fit, resolution_m=0.5, outcrop_normal=None) for fit in fits]
    planes = Plane.from_normals([fit.normal for fit in fits])
    rows = plane_rows(fits, verdicts, planes, resolution_m=0.5)
    for fit, verdict, plane, row in zip(fits, verdicts, planes, rows, strict=True):
        single = plane_row(fit, verdict, resolution_m=0.5, plane=plane)
        assert row == {
            name: pytest.approx(value, rel=1e-9, abs=1e-15) if type(value) is float else value
            for name, value in single.items()
        }


def covariance_of(row: Row) -> np.ndarray:
    ee, en, eu, nn, nu, uu = (
        row[f"normal_cov_{name}"] for name in ("ee", "en", "eu", "nn", "nu", "uu")
    )
    return np.array([[ee, en, eu], [en, nn, nu], [eu, nu, uu]])


def test_three_points_have_no_errors_and_only_finite_values() -> None:
    fit = fit_plane(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 1]]))
    row = plane_row(fit, judge(fit, resolution_m=None, outcrop_normal=None))
    assert row["max_confidence95_deg"] is None
    assert row["quality"] in ("doubtful", "poor")
    assert not any(isinstance(v, float) and not math.isfinite(v) for v in row.values())


def test_written_table_is_read_unchanged(tmp_path: Path) -> None:
    rows = [
        a_plane(id="#1", name='a, "b"', kind="bedding", set="hanging wall", notes="two\nlines"),
        a_plane(id="2", name="Schüttung", kind="joint", overturned=True),
        line_row(Line(123.456789, 12.5), id="3", kind="lineation"),
    ]
    path = tmp_path / "out.csv"
    write_orientation_csv(path, rows, crs="EPSG:32615")
    found = read_orientations(path)
    assert found.ids == ("#1", "2", "3")
    assert found.kinds == ("bedding", "joint", "lineation")
    assert found.sets == ("hanging wall", "", "")
    assert found.is_plane.tolist() == [True, True, False]
    assert found.dip_direction_deg[:2] == pytest.approx(
        [row["dip_direction_deg"] for row in rows[:2]], rel=1e-11
    )
    assert found.dip_deg[0] == pytest.approx(rows[0]["dip_deg"], rel=1e-11)
    assert found.trend_deg[2] == pytest.approx(123.456789, rel=1e-11)
    assert found.column("name")[0] == 'a, "b"'
    assert found.column("notes")[0] == "two\nlines"
    assert found.warnings == ()


def test_written_table_states_its_frame_and_is_plain_csv(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    write_orientation_csv(path, [a_plane(id="1")], crs="EPSG:32615", notes=["project:\nMine"])
    lines = path.read_text(encoding="utf-8").splitlines()
    block = [line for line in lines if line.startswith("#")]
    for said in ("EPSG:32615", "grid north", "right-hand rule", "VOM Studio 0.", "project: Mine"):
        assert any(said in line for line in block), said
    reader = csv.DictReader(line for line in lines if not line.startswith("#"))
    assert tuple(reader.fieldnames or ()) == COLUMNS
    (row,) = reader
    assert row["undefined"] == "false"
    assert row["trend_deg"] == row["area_m2"] == ""


def test_pandas_reads_the_written_table(tmp_path: Path) -> None:
    import pandas

    path = tmp_path / "out.csv"
    rows = [a_plane(id="1", name="#1"), line_row(Line(10.0, 20.0), id="2")]
    write_orientation_csv(path, rows)
    skipped = sum(line.startswith("#") for line in path.read_text().splitlines())
    frame = pandas.read_csv(path, skiprows=skipped)
    assert frame["dip_deg"][0] == pytest.approx(rows[0]["dip_deg"], rel=1e-11)
    assert list(frame["element"]) == ["plane", "line"]


def test_an_existing_table_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text("mine")
    with pytest.raises(TargetError):
        write_orientation_csv(path, [])
    assert path.read_text() == "mine"


def test_table_written_in_many_chunks_contains_every_cell(tmp_path: Path) -> None:
    """Against the reader of the standard library; columns hold values of several classes."""
    rng = np.random.default_rng(2)
    words = ("", "plain", "a, b", 'said "so"', "# first", " spaced ", "two\nlines", None)
    numbers = (None, math.inf, math.nan, 1e-300, 123456.789, np.float64(0.1), -0.0, 7)
    rows: list[dict[str, object]] = [
        {
            "id": f"trace-{i}",
            "notes": words[rng.integers(len(words))],
            "rms_m": numbers[rng.integers(len(numbers))],
            "dip_deg": float(rng.uniform(0, 90)),
            "n_points": int(rng.integers(3, 99)),
            "undefined": bool(rng.integers(2)),
        }
        for i in range(10_000)
    ]
    path = tmp_path / "many.csv"
    write_orientation_csv(path, iter(rows))
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    first = next(i for i, line in enumerate(lines) if not line.startswith("# "))
    found = list(csv.DictReader(lines[first:]))
    assert len(found) == len(rows)
    for row, cells in zip(rows, found, strict=True):
        assert tuple(cells) == COLUMNS
        assert cells["id"] == row["id"]
        assert cells["notes"] == (row["notes"] or "")
        rms = row["rms_m"]
        if rms is None or not math.isfinite(rms):
            assert cells["rms_m"] == ""
        else:
            assert float(cells["rms_m"]) == pytest.approx(rms, rel=1e-11)
        assert float(cells["dip_deg"]) == pytest.approx(row["dip_deg"], rel=1e-11)
        assert int(cells["n_points"]) == row["n_points"]
        assert cells["undefined"] == ("true" if row["undefined"] else "false")
        assert not any(cells[name] for name in COLUMNS if name not in row)
