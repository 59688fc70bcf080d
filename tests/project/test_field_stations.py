"""Stations of the field: several readings, photos and lines of notes belong to one of them."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import pyogrio.raw
import pytest

from tests.samples import HASH
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.codec import decode, encode
from vomstudio.project.exports.export import export_project
from vomstudio.project.figures import Subject
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.imports.feature_lists import read_listed_features
from vomstudio.project.imports.field_columns import geometry_of_type, guess
from vomstudio.project.imports.field_table import read_field_table
from vomstudio.project.imports.readings import make_readings, read_readings
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.station import KIND, Station, get_readings, station_photos
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import DEFAULT_TYPES, Model
from vomstudio.project.tables.project_table import project_table

BOOK = """station,type,dip direction,dip,notes
KB-17,bedding,132,41,"base of the bed,
below the scree"
KB-17,bedding,134,43,
KB-17,joint,220,80,
KB-18,bedding,140,40,
"""
MODEL = Model("m1", "cliff", "cliff.obj", "mesh", HASH, Frame("crs", "EPSG:32633"))
TYPES = {kind.id: kind for kind in DEFAULT_TYPES}


def read_book(tmp_path: Path, text: str = BOOK, line_types: tuple[str, ...] = ()) -> list[Reading]:
    path = tmp_path / "book.csv"
    path.write_text(text)
    table = read_field_table(path)
    found = guess(table)
    read = read_readings(table, found.columns, "dipdir/dip", line_types=line_types)
    assert not read.bad_rows
    return make_readings(read.rows, type_ids={k: k for k in TYPES}, type_id="bedding")


def with_readings(readings: list[Reading]) -> dict:
    return edits.add_readings(TYPES, readings).after


def test_readings_of_one_station_have_separate_names(tmp_path: Path) -> None:
    readings = [r for r in with_readings(read_book(tmp_path)).values() if isinstance(r, Reading)]
    assert [r.station for r in readings] == ["KB-17", "KB-17", "KB-17", "KB-18"]
    assert [r.name for r in readings] == ["B01", "B02", "J01", "B03"]
    assert readings[0].notes == "base of the bed,\nbelow the scree"


@pytest.mark.parametrize("title", ["station", "Station ID", "locality", "Site", "stop"])
def test_station_column_is_not_used_as_names(tmp_path: Path, title: str) -> None:
    readings = read_book(tmp_path, f"{title};name;dip direction;dip\nA1;F7;132;41\nA1;F8;12;4\n")
    assert [(r.station, r.name) for r in readings] == [("A1", "F7"), ("A1", "F8")]


def test_open_quote_affects_only_its_line(tmp_path: Path) -> None:
    text = 'station,dip direction,dip,notes\n1,132,41,5" wide\n2,12,4,\n'
    assert [r.station for r in read_book(tmp_path, text)] == ["1", "2"]


def test_station_shows_the_readings_with_its_number(tmp_path: Path) -> None:
    station = Station("s1", "S01", "m1", HASH, ((0.0, 0.0, 0.0),), number="kb-17")
    records = {**TYPES, **with_readings(read_book(tmp_path)), "m1": MODEL, "s1": station}
    assert [r.name for r in get_readings(station, records)] == ["B01", "B02", "J01"]
    (measured,) = measure_all(records, [station])
    assert "B01, B02, J01" in KIND.about(Subject(station, measured, records))[0]
    unused = replace(station, number="", name="X9")
    assert KIND.about(Subject(unused, measured, records)) == []


def test_reading_without_a_station_field_opens_unchanged() -> None:
    old = encode(Reading("r1", "R01", "bedding", "plane", 100.0, 30.0))
    del old["station"]
    reading = decode(old)
    assert reading == Reading("r1", "R01", "bedding", "plane", 100.0, 30.0)
    assert "station" not in project_table({**TYPES, "r1": reading}).extra_columns


@pytest.mark.filterwarnings("ignore:Measured:UserWarning")
def test_station_is_exported_and_imported_again(tmp_path: Path) -> None:
    readings = [replace(r, position=(372411.0, 4709820.0, 613.0)) for r in read_book(tmp_path)]
    opened = ProjectFolder.create(tmp_path / "face.vom")
    session = opened.session
    session.apply(edits.add_model(session.records, MODEL))
    session.apply(edits.add_readings(session.records, readings))
    session.save()
    opened.close()
    for form in ("csv", "gpkg", "orient"):
        export_project(tmp_path / "face.vom", form, tmp_path / f"out.{form}")
    text = (tmp_path / "out.csv").read_text()
    rows = list(csv.DictReader(line for line in text.splitlines(True) if line[0] != "#"))
    assert [row["station"] for row in rows] == ["KB-17", "KB-17", "KB-17", "KB-18"]
    meta, _, _, columns = pyogrio.raw.read(tmp_path / "out.gpkg", layer="planes")
    stations = dict(zip(meta["fields"], columns, strict=True))["station"]
    assert list(stations) == ["KB-17", "KB-17", "KB-17", "KB-18"]
    again = read_field_table(tmp_path / "out.csv")
    found = guess(again)
    back = read_readings(again, found.columns, found.notation or "").rows
    assert [(r.station, r.name) for r in back] == [
        ("KB-17", "B01"),
        ("KB-17", "B02"),
        ("KB-17", "J01"),
        ("KB-18", "B03"),
    ]
    assert back[0].notes == "base of the bed,\nbelow the scree"


def test_rows_of_one_station_become_one_station_with_all_photos(tmp_path: Path) -> None:
    path = tmp_path / "stations.csv"
    path.write_text(
        "station,x,y,z,photo,notes\nKB-17,1,2,3,a.jpg,base\nKB-17,1,2,3,b.jpg,top\n"
        "KB-17,900,2,3,c.jpg,far\nKB-18,4,5,6,,\n"
    )
    found = read_listed_features(path, MODEL, {**TYPES, "m1": MODEL}, "EPSG:32633")
    first, far, other = found.features
    assert isinstance(first, Station)
    assert station_photos(first) == ["a.jpg", "b.jpg"]
    assert first.notes == "base\ntop"
    assert [f.number for f in (first, far, other)] == ["KB-17", "KB-17", "KB-18"]


# --- lines by their type ----------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "meaning"),
    [
        ("Bedding", "plane"),
        ("slickenline", "line"),
        ("Striae", "line"),
        ("Mineral lineation", "line"),
        ("Slickenside", None),
        ("lineament", "plane"),
    ],
)
def test_type_name_determines_plane_or_line(name: str, meaning: str | None) -> None:
    assert geometry_of_type(name) == meaning


def test_rows_of_a_line_type_are_lines_in_a_table_of_planes(tmp_path: Path) -> None:
    text = "type,dip direction,dip\nFault,132,41\nLineation,140,40\n"
    fault, line = read_book(tmp_path, text, ("lineation",))
    assert (fault.geometry, line.geometry) == ("plane", "line")
    assert (line.azimuth_deg, line.inclination_deg) == (140.0, 40.0)
    assert line.type_id == "lineation"


def test_element_column_distinguishes_lines_and_planes(tmp_path: Path) -> None:
    text = "element,dip direction,dip\nplane,132,41\nline,140,40\n"
    assert [r.geometry for r in read_book(tmp_path, text)] == ["plane", "line"]
