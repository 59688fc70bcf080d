"""Orientations in the columns, layers and workbooks of others, and in what this program exports."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyogrio
import pytest

from tests.messages import by_code, refused
from vomstudio.core.errors import UsageError
from vomstudio.io.gate.orientation_files import read_orientations, read_slips
from vomstudio.io.text.column_mapping import parse_columns
from vomstudio.project.exports.export import export_project

SPECIMEN = Path(__file__).parents[2] / "specimens" / "schema1.vom"
Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write_file(content: str, name: str = "table.csv") -> Path:
        path = tmp_path / name
        path.write_text(content, encoding="utf-8")
        return path

    return write_file


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("azi,inc\n120,30\n", {"azimuth": "dipdir"}),
        ("azi,inc\n30,30\n", {"azimuth": "strike"}),
        ("azi,inc\n120,30\n", {"columns": {"azi": "dip_direction", "inc": "dip"}}),
        ("fazi,finc\n120,30\n", {"azimuth": "dipdir"}),
        ("120 30\n", {"azimuth": "dipdir"}),
        ("7 120 30\n", {"columns": {"2": "dip_direction", "3": "dip"}}),
        ("nx,ny,nz\n0.866025404,-0.5,1.732050808\n", {}),
        ("normal_x,normal_y,normal_z\n-0.433012702,0.25,-0.866025404\n", {}),
        ("OrientX;OrientY;OrientZ\n0.866025404;-0.5;1.732050808\n", {}),
        ("# from a field book\n#Strike\tDip\tRake\n30\t30SE\t80E\n", {}),
        ("bedding\n120/30\n", {}),
        ("id,measured\na,N30E/30SE\n", {}),
        ("120/30\n", {}),
        ("strike/dip\n30/30\n", {}),
        ("attitude\n30/30\n", {"azimuth": "strike"}),
        ("X,Y,Z,azimuth,dip,polarity,formation\n0,0,0,120,30,1,a\n", {}),
    ],
)
def test_planes_are_read_from_columns_of_other_programs(
    write: Write, text: str, options: dict
) -> None:
    found = read_orientations(write(text), **options)
    assert found.is_plane.tolist() == [True]
    assert found.dip_direction_deg == pytest.approx([120.0], abs=1e-6)
    assert found.dip_deg == pytest.approx([30.0], abs=1e-6)
    assert found.warnings == ()


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("dec,inc\n120,30\n", {}),
        ("Declination;Inclination\n120;30\n", {}),
        ("bearing,plunge\n120,30\n", {}),
        ("lazi,linc\n120,30\n", {}),
        ("K1dec,K1inc\n120,30\n", {}),
        ("trend/plunge\n120/30\n", {}),
        ("azi,inc\n120,30\n", {"columns": {"azi": "trend"}}),
        ("120 30\n", {"columns": {"1": "trend", "2": "plunge"}}),
    ],
)
def test_lines_are_read_from_columns_of_other_programs(
    write: Write, text: str, options: dict
) -> None:
    found = read_orientations(write(text), **options)
    assert found.is_plane.tolist() == [False]
    assert (found.trend_deg[0], found.plunge_deg[0]) == pytest.approx((120.0, 30.0))


@pytest.mark.parametrize(
    "text", ["azi,inc\n113,47\n", "113 47\n", "fazi,finc,lazi,linc\n90,60,90,60\n"]
)
def test_ambiguous_azimuth_is_rejected_with_a_working_option(write: Write, text: str) -> None:
    with refused("orientation.ambiguous-azimuth", UsageError) as error:
        read_orientations(write(text))
    example = error.value.to_dict()["example"]
    assert len(read_orientations(write(text), columns=parse_columns(example))) == 1


def test_two_conventions_in_one_column_are_reported(write: Write) -> None:
    found = read_orientations(write("bedding\nN30E/45SE\n120/30\n125/31\n"))
    finding = by_code(found.warnings)["orientation.two-conventions"]
    assert (finding["count"], finding["other_count"]) == (2, 1)
    assert found.dip_direction_deg.tolist() == [120.0, 120.0, 125.0]


def test_further_axes_of_a_magnetic_fabric_are_reported(write: Write) -> None:
    found = read_orientations(write("K1dec,K1inc,K3dec,K3inc\n10,20,200,69\n"))
    assert found.trend_deg.tolist() == [10.0]
    assert by_code(found.warnings)["orientation.other-axes"]["axes"] == ("K3",)


def test_zero_normals_are_dropped_and_loopstructural_normals_point_younging(
    write: Write,
) -> None:
    head = "feature_name,nx,ny,nz,interface\n"
    rows = "a,0.5,0,0.866,\na,-0.5,0,-0.866,\na,0,0,0,\na,,,,1\n"
    found = read_orientations(write(head + rows))
    assert found.overturned == (False, True)
    assert found.dropped == (4, 5)
    assert read_orientations(write("nx,ny,nz\n0,0,-1\n")).overturned is None


@pytest.mark.parametrize("text", ["azi", "azi=", "=dip", "azi=dip,inc"])
def test_malformed_column_mapping_is_rejected(text: str) -> None:
    with refused("columns.invalid", UsageError, field="--columns"):
        parse_columns(text)


def test_unknown_meanings_and_columns_are_rejected(write: Write) -> None:
    with refused("columns.unknown-meaning", UsageError):
        parse_columns("azi=colour")
    assert parse_columns("azi=dipdir") == {"azi": "dip_direction"}
    with refused("table.unknown-column", UsageError):
        read_orientations(write("azi,inc\n1,2\n"), columns={"az": "strike"})


def test_azimuths_alone_are_accepted_if_requested(write: Write) -> None:
    found = read_orientations(write("strike\n30\n40\n"), azimuth_only=True)
    assert found.dip_direction_deg.tolist() == [120.0, 130.0]
    assert np.isnan(found.dip_deg).all()
    with refused("orientation.ambiguous-azimuth", UsageError):
        read_orientations(write("azimuth\n30\n"), azimuth_only=True)
    with refused("table.missing-column"):
        read_orientations(write("strike\n30\n"))


# ------------------------------------------------------------------------- layers and workbooks

FIELDS = ["strike", "dip", "type"]
VALUES = [np.array([350.0, 10.0]), np.array([30, 60]), np.array(["bedding", "joint"], object)]


def write_layer(path: Path, crs: str | None, points: np.ndarray, **options: str) -> Path:
    import shapely

    pyogrio.raw.write(
        path,
        geometry=shapely.to_wkb(shapely.points(points)),
        field_data=VALUES,
        fields=FIELDS,
        geometry_type="Point Z",
        crs=crs,
        **options,
    )
    return path


METRES = np.array([[500000.0, 5000000.0, 100.0], [500010.0, 5000003.0, 101.0]])


@pytest.mark.parametrize("name", ["a.gpkg", "a.shp", "a.geojson"])
def test_point_layer_attributes_are_read_as_a_table(tmp_path: Path, name: str) -> None:
    found = read_orientations(write_layer(tmp_path / name, "EPSG:32633", METRES))
    assert found.dip_direction_deg.tolist() == [80.0, 100.0]
    assert found.kinds == ("bedding", "joint")
    columns = [found.table.find(axis) for axis in "xyz"]
    assert found.table.numbers(columns) == pytest.approx(METRES, abs=1e-3)
    assert found.table.comments == ("CRS: EPSG:32633",)


def test_degrees_of_points_become_metres_and_this_is_reported(tmp_path: Path) -> None:
    degrees = np.array([[15.0, 45.15, 100.0], [15.0001, 45.15, 101.0]])
    found = read_orientations(write_layer(tmp_path / "a.geojson", "EPSG:4326", degrees))
    x = found.table.numbers([found.table.find("x")])[:, 0]
    assert np.diff(x) == pytest.approx(7.86, abs=0.01)
    assert "frame.reprojected" in by_code(found.warnings)


def write_sheet(path: Path, layer: str, *, append: bool = False) -> None:
    pyogrio.raw.write(
        path,
        geometry=None,
        field_data=VALUES,
        fields=FIELDS,
        layer=layer,
        driver=path.suffix[1:].upper(),
        geometry_type=None,
        append=append,
    )


@pytest.mark.parametrize("name", ["a.xlsx", "a.ods"])
def test_the_sheet_of_a_workbook_is_a_table(tmp_path: Path, name: str) -> None:
    write_sheet(tmp_path / name, "readings")
    found = read_orientations(tmp_path / name)
    assert found.dip_direction_deg.tolist() == [80.0, 100.0]
    assert found.line_numbers.tolist() == [2, 3]
    with refused("drawing.unknown-layer", UsageError):
        read_orientations(tmp_path / name, layer="notes")


def test_one_of_several_sheets_is_chosen_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "a.ods"
    write_sheet(path, "readings")
    write_sheet(path, "copy", append=True)
    with refused("drawing.several-layers", UsageError, layers=["readings", "copy"]):
        read_orientations(path)
    assert len(read_orientations(path, layer="copy")) == 2


def test_a_text_table_has_no_layers(write: Write) -> None:
    with refused("table.no-layers", UsageError, field="--layer"):
        read_orientations(write("strike,dip\n1,2\n"), layer="a")


# ---------------------------------------------------------------------------- exports read back


@pytest.fixture(scope="module")
def specimen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("exports") / "a.vom"
    shutil.copytree(SPECIMEN, folder)
    return folder


@pytest.mark.parametrize(
    ("format_", "suffix"),
    [
        ("csv", "csv"),
        ("gpkg", "gpkg"),
        ("shp", "shp"),
        ("geojson", "geojson"),
        ("stereonet", "txt"),
        ("orient", "txt"),
        ("gempy", "csv"),
        ("loopstructural", "csv"),
        ("gems", "csv"),
    ],
)
def test_exported_planes_and_lines_round_trip(
    specimen: Path, tmp_path: Path, format_: str, suffix: str
) -> None:
    target = tmp_path / f"x.{suffix}"
    exported = export_project(specimen, format_, target)
    is_on_map = format_ in ("gpkg", "shp", "geojson")
    rows = [r for r in exported.rows if not (is_on_map and r["x"] is None)]
    lines_file = target.with_name(f"x_lines.{suffix}")
    files = [target] + [lines_file] * lines_file.exists()
    found = [read_orientations(file) for file in files]
    planes = np.concatenate([t.vectors()[t.is_plane] for t in found])
    lines = np.concatenate([t.vectors()[~t.is_plane] for t in found])
    for vectors, names, element in (
        (planes, ("pole_trend_deg", "pole_plunge_deg"), "plane"),
        (lines, ("trend_deg", "plunge_deg"), "line"),
    ):
        expected = np.radians(
            [[r[name] for name in names] for r in rows if r["element"] == element]
        ).reshape(-1, 2)
        unique = np.unique(np.round(vectors, 5) + 0.0, axis=0)
        azimuth, plunge = expected.T
        made = np.column_stack(
            [np.sin(azimuth) * np.cos(plunge), np.cos(azimuth) * np.cos(plunge), -np.sin(plunge)]
        )
        assert len(vectors) >= len(np.unique(np.round(made, 5), axis=0)) or not len(made)
        for vector in made:
            assert np.abs(unique - vector).max(axis=1).min() < 1e-4


@pytest.mark.parametrize("format_", ["faultkin", "wintensor"])
def test_exported_faults_are_read_back_as_planes(
    specimen: Path, tmp_path: Path, format_: str
) -> None:
    exported = export_project(specimen, format_, tmp_path / "x.txt")
    found = read_orientations(tmp_path / "x.txt")
    expected = [row["on_plane_dip_deg"] for row in exported.rows]
    assert found.dip_deg == pytest.approx(expected, abs=1e-5)


# -------------------------------------------------------------------------------------- faults


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("90\t60\t90\t60\t2\n", {"azimuth": "dipdir"}),
        ("0 60 90 60 N\n", {"azimuth": "strike"}),
        ("90,60,90,2\n", {"azimuth": "dipdir"}),
        ("fazi,finc,lazi,linc,sense\n90,60,90,60,N\n", {"azimuth": "dipdir"}),
        ("fazi,finc,lazi,linc,sense\n90,60,90,60,1\n", {"azimuth": "dipdir"}),
        ("90 60 90 60 2\n", {"columns": parse_columns("1=dipdir,2=dip,3=trend,4=plunge,5=sense")}),
    ],
)
def test_fault_without_usual_header_is_read(write: Write, text: str, options: dict) -> None:
    found = read_slips(write(text), **options)
    assert (found.dip_direction_deg[0], found.dip_deg[0]) == (90.0, 60.0)
    assert found.slip_rake_deg.tolist() == [-90.0]


def test_signed_slip_senses_refer_to_the_hanging_wall(write: Write) -> None:
    found = read_slips(write("strike,dip,rake,sense\n0,60,90,1\n0,60,90,-1\n"))
    assert found.slip_rake_deg.tolist() == [-90.0, 90.0]
    assert "slip.signed-senses" in by_code(found.warnings)
    # A 1 alone is reverse in T-TECTO.
    found = read_slips(write("strike,dip,rake,sense\n0,60,90,1\n"))
    assert "slip.numbered-senses" in by_code(found.warnings)


def test_the_polarity_of_gempy_and_map2loop_marks_overturned_beds(write: Write) -> None:
    found = read_orientations(write("DipDirection,dip,DipPolarity\n10,20,1\n10,20,-1\n10,20,0\n"))
    assert found.overturned == (False, True, None)


@pytest.mark.parametrize("text", ["90 60 90 60 2\n", "fazi,finc,rake,sense\n90,60,90,N\n"])
def test_ambiguous_fault_azimuth_is_rejected(write: Write, text: str) -> None:
    with refused("orientation.ambiguous-azimuth", UsageError):
        read_slips(write(text))
