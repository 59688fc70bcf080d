"""Stations, contact lines and rock areas: in the journal, moved by the registration, in files that
OGR and ezdxf read, and back from them."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pyogrio
import pytest
import shapely

from tests.messages import refused
from tests.samples import bed
from tests.specimens.figures import command
from vomstudio.core.errors import DocumentError, InputError
from vomstudio.geology.beds.lithologies import LITHOLOGIES, lithology_color, strabospot_fields
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.project import edits
from vomstudio.project.exports.export import export_project
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.imports.feature_lists import read_listed_features
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.lithology import Lithology
from vomstudio.project.kinds.station import Station
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import Model

pytestmark = [
    pytest.mark.filterwarnings("ignore:Measured:UserWarning"),
    pytest.mark.filterwarnings("ignore:'crs' was not provided:UserWarning"),
]

HASH = "0" * 64
CRS = "EPSG:32633"
ORIGIN = np.array([372411.0, 4709820.0, 613.0])
LINE = tuple(tuple((ORIGIN + step).tolist()) for step in ([0, 0, 0], [3, 0, 4], [3, 0, 16]))
RING = tuple(
    tuple((ORIGIN + step).tolist()) for step in ([0, 0, 0], [2, 0, 0], [2, 0, 3], [0, 0, 3])
)
MODEL = Model("m1", "cliff", "cliff.obj", "mesh", HASH, Frame("crs", CRS))
STATION = Station("s1", "S01", "m1", HASH, LINE[:1], "sample", "=KB-17", "DSC 12.jpg", "wet, red")
CONTACT = Contact("k1", "F01", "fault", "m1", HASH, LINE, "main", "sharp")
ROCK = Lithology("a1", "L01", "m1", HASH, RING, "sandstone", 6.5, "coarse")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "face.vom"
    opened = ProjectFolder.create(folder)
    session = opened.session
    session.apply(edits.add_model(session.records, MODEL))
    session.apply(edits.add_features(session.records, [STATION, CONTACT, ROCK]))
    session.save()
    opened.close()
    return folder


# --- the document ---------------------------------------------------------------------------
def figures(model: Model = MODEL) -> dict[str, Any]:
    features = [STATION, CONTACT, ROCK]
    measured = measure_all({"m1": model, **{f.id: f for f in features}}, features)
    return {f.id: m for f, m in zip(features, measured, strict=True)}


def test_stations_contacts_and_rock_areas_have_dimensions_but_no_orientation():
    found = figures()
    assert found["s1"].points == pytest.approx(np.array(LINE[:1]))
    assert found["k1"].dimension == {"length_m": pytest.approx(17.0)}
    rock = found["a1"].dimension
    assert rock["area_m2"] == pytest.approx(6.5)
    assert rock["outline_m2"] == pytest.approx(6.0)
    assert rock["perimeter_m"] == pytest.approx(10.0)
    for each in found.values():
        assert each.plane is each.line is each.fit is each.verdict is each.problem is None


def test_registration_moves_features_and_scales_their_dimensions():
    """A turn by 30 degrees about up and twice the size: places turn, lengths double, areas are four
    times as large."""
    turn = np.radians(30.0)
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
    matrix[:3, :3] *= 2.0
    matrix[:3, 3] = [10.0, 20.0, 30.0]
    rows = tuple(map(tuple, matrix.tolist()))
    placed = replace(MODEL, placement=Registration("r", "points", "points", matrix=rows))
    before, after = figures(), figures(placed)
    for id_, was in before.items():
        wanted = was.points @ matrix[:3, :3].T + matrix[:3, 3]
        assert after[id_].points == pytest.approx(wanted)
    assert after["k1"].dimension["length_m"] == pytest.approx(34.0)
    assert after["a1"].dimension["area_m2"] == pytest.approx(26.0)
    assert after["a1"].dimension["outline_m2"] == pytest.approx(24.0)


def test_features_can_be_undone_and_are_stored_in_the_project(project: Path):
    opened = ProjectFolder.open(project)
    session = opened.session
    assert [session.records[i] for i in ("s1", "k1", "a1")] == [STATION, CONTACT, ROCK]
    session.apply(edits.set_attributes(session.records, ["a1"], lithology="shale"))
    session.apply(edits.set_attributes(session.records, ["s1"], what="station", number="KB-18"))
    session.apply(
        edits.change_feature(session.records, replace(CONTACT, repeat_of="t1", interpreter="AN"))
    )
    opened.close()
    opened = ProjectFolder.open(project)
    session = opened.session
    contact, station, rock = (session.records[i] for i in ("k1", "s1", "a1"))
    assert (contact.repeat_of, contact.interpreter) == ("t1", "AN")
    assert (station.what, station.number, rock.lithology) == ("station", "KB-18", "shale")
    for _ in range(4):
        session.undo()
    assert session.features() == []
    opened.close()


def test_invalid_choice_is_rejected_and_never_stored_in_the_journal(project: Path):
    opened = ProjectFolder.open(project)
    with refused("option.not-a-choice", DocumentError, value="fossil"):
        edits.set_attributes(opened.session.records, ["s1"], what="fossil")
    opened.close()


def test_every_lithology_is_in_strabospot_and_all_but_covered_have_a_colour():
    assert len(set(LITHOLOGIES)) == len(LITHOLOGIES)
    assert all(strabospot_fields(word) is not None for word in LITHOLOGIES)
    assert [word for word in LITHOLOGIES if not lithology_color(word)] == ["covered"]
    # As on the state geologic maps of the USGS: red, green, blue.
    published = {
        "sandstone": (205, 255, 217),
        "shale": (172, 228, 200),
        "limestone": (67, 175, 249),
        "siltstone": (214, 254, 154),
        "conglomerate": (183, 217, 204),
    }
    for word, rgb in published.items():
        assert lithology_color(word) == "#{:02x}{:02x}{:02x}".format(*rgb)
    assert lithology_color("granite") == lithology_color("") == ""
    assert lithology_color("packstone") == lithology_color("limestone")


# --- files ----------------------------------------------------------------------------------
def shapes(path: Path, layer: str | None = None) -> tuple[dict[str, Any], list[Any]]:
    about, _, raw, columns = pyogrio.raw.read(path, layer=layer)
    named = {str(f): c[0] for f, c in zip(about["fields"], columns, strict=True)}
    return {**named, "crs": about["crs"]}, list(shapely.from_wkb(raw))


def coordinates(shape: Any) -> np.ndarray:
    return shapely.get_coordinates(shape, include_z=True)


@pytest.mark.parametrize("ending", ["gpkg", "shp"])
def test_ogr_reads_points_lines_and_polygons_in_three_dimensions(
    project: Path, tmp_path: Path, ending: str
):
    out = tmp_path / f"o.{ending}"
    table = export_project(project, ending, out)
    assert (table.rows, table.features) == ([], 3)
    assert table.layers["stations"] == table.layers["contacts"] == table.layers["lithologies"] == 1
    for name, form, wanted in (
        ("stations", "Point", LINE[:1]),
        ("contacts", "LineString", LINE),
        ("lithologies", "Polygon", (*RING, RING[0])),
    ):
        path = out if ending == "gpkg" else tmp_path / f"o_{name}.{ending}"
        told, (shape,) = shapes(path, name if ending == "gpkg" else None)
        assert shape.geom_type == form
        points = coordinates(shape)
        if ending == "shp" and form == "Polygon":
            # A shapefile's rings go round clockwise, from any point.
            assert set(map(tuple, points.round(6))) == set(wanted)
        else:
            assert points == pytest.approx(np.array(wanted), abs=1e-6)
        assert "32633" in told["crs"] or "33N" in told["crs"]
    told, _ = shapes(
        out if ending == "gpkg" else tmp_path / f"o_stations.{ending}",
        "stations" if ending == "gpkg" else None,
    )
    assert (told["number"], told["photo"], told["kind"]) == ("=KB-17", "DSC 12.jpg", "sample")
    told, _ = shapes(
        out if ending == "gpkg" else tmp_path / f"o_lithologies.{ending}",
        "lithologies" if ending == "gpkg" else None,
    )
    assert (told["lithology"], told["area_m2"]) == ("sandstone", pytest.approx(6.5))


def test_geopackage_has_a_style_for_each_layer_and_rock_colours(project: Path, tmp_path: Path):
    import sqlite3
    from contextlib import closing

    export_project(project, "gpkg", tmp_path / "o.gpkg")
    with closing(sqlite3.connect(tmp_path / "o.gpkg")) as file:
        styles = dict(file.execute("SELECT f_table_name, styleQML FROM layer_styles").fetchall())
    assert {"stations", "contacts", "lithologies"} <= set(styles)
    assert 'attr="lithology"' in styles["lithologies"]
    assert "205,255,217" in styles["lithologies"]
    assert 'attr="kind"' in styles["contacts"]


def test_kml_has_degrees_heights_and_a_real_polygon(project: Path, tmp_path: Path):
    from pyproj import Transformer

    export_project(project, "kml", tmp_path / "o.kml")
    _, (shape,) = shapes(tmp_path / "o.kml", "lithologies")
    (part,) = shape.geoms
    assert part.geom_type == "Polygon"
    there = Transformer.from_crs(CRS, "EPSG:4326", always_xy=True)
    wanted = np.column_stack([*there.transform(*np.array(RING)[:, :2].T), np.array(RING)[:, 2]])
    assert coordinates(part)[:-1] == pytest.approx(wanted, abs=1e-8)


def test_dxf_has_separate_layers(project: Path, tmp_path: Path):
    export_project(project, "dxf", tmp_path / "o.dxf")
    drawing = ezdxf.readfile(tmp_path / "o.dxf")
    entities = {e.dxf.layer: e for e in drawing.modelspace()}
    point = entities["sample_stations"]
    assert point.dxf.location.xyz == pytest.approx(LINE[0])
    line = entities["fault_contacts"]
    assert [v.dxf.location.xyz for v in line.vertices] == [pytest.approx(p) for p in LINE]
    ring = entities["sandstone_lithologies"]
    assert ring.is_closed
    assert [v.dxf.location.xyz for v in ring.vertices] == [pytest.approx(p) for p in RING]


def test_csv_keeps_the_orientation_table_and_adds_separate_tables(project: Path, tmp_path: Path):
    table = export_project(project, "csv", tmp_path / "o.csv")
    assert [path.name for path in table.files] == [
        "o.csv",
        "o_contacts.csv",
        "o_lithologies.csv",
        "o_stations.csv",
    ]
    rows = [line for line in (tmp_path / "o.csv").read_text().splitlines() if line[0] != "#"]
    assert len(rows) == 1, "no plane is invented"
    lines = (tmp_path / "o_stations.csv").read_text().splitlines()
    (row,) = csv.DictReader(line for line in lines if not line.startswith("#"))
    assert row["number"] == "'=KB-17", "no formula for a spreadsheet"
    assert float(row["z"]) == pytest.approx(613.0)


@pytest.mark.parametrize("ending", ["gpkg", "shp", "geojson", "kml", "csv"])
def test_exported_features_are_imported_unchanged(project: Path, tmp_path: Path, ending: str):
    export_project(project, ending, tmp_path / f"o.{ending}")
    opened = ProjectFolder.open(project)
    records = opened.session.records
    one = ending in ("gpkg", "kml")
    names = ["o"] if one else ["o_stations", "o_contacts", "o_lithologies"]
    found = []
    for name in names:
        read = read_listed_features(tmp_path / f"{name}.{ending}", MODEL, records, CRS)
        assert read.skipped == ()
        # KML and GeoJSON are in degrees by their standards.
        expected = ["frame.reprojected"] if ending in ("kml", "geojson") else []
        assert [finding.code for finding in read.warnings] == expected
        found += read.features
    by_kind = {type(f): f for f in found}
    assert len(found) == len(by_kind) == 3
    for was in (STATION, CONTACT, ROCK):
        now = by_kind[type(was)]
        assert now.id != was.id
        points = sorted(now.vertices) if ending == "shp" else now.vertices
        wanted = sorted(was.vertices) if ending == "shp" else was.vertices
        # KML has degrees with nine decimals.
        assert np.array(points) == pytest.approx(np.array(wanted), abs=1e-3)
        kept = {"id": was.id, "vertices": was.vertices}
        if was is ROCK:
            assert now.area == pytest.approx(6.5, rel=1e-3)
            kept["area"] = was.area
        assert replace(now, **kept) == was
    opened.close()


def test_area_is_measured_again_if_the_surface_is_available(project: Path, tmp_path: Path):
    export_project(project, "geojson", tmp_path / "o.geojson")
    opened = ProjectFolder.open(project)
    path = tmp_path / "o_lithologies.geojson"
    read = read_listed_features(
        path, MODEL, opened.session.records, CRS, lambda ring: 0.0 + len(ring)
    )
    assert read.features[0].area == 4.0
    opened.close()


def test_bad_files_are_reported_with_the_remedy(project: Path, tmp_path: Path):
    opened = ProjectFolder.open(project)
    records = opened.session.records

    def error(path: Path) -> InputError:
        with pytest.raises(InputError) as caught:
            read_listed_features(path, MODEL, records, CRS)
        return caught.value

    assert error(tmp_path / "gone.gpkg").code == "file.missing"
    (tmp_path / "text.gpkg").write_text("notes")
    assert error(tmp_path / "text.gpkg").code == "import.not-vectors"
    flat = tmp_path / "flat_contacts.geojson"
    flat.write_text(
        '{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"name": '
        '"F9"}, "geometry": {"type": "LineString", "coordinates": [[15, 42], [15.1, 42]]}}]}'
    )
    assert "no heights" in error(flat).message
    other = tmp_path / "roads.geojson"
    other.write_text(flat.read_text())
    assert error(other).code == "import.nothing-usable"
    assert "no heights" in error(other).values["reason"]
    points = tmp_path / "wells.geojson"
    points.write_text(
        '{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, '
        '"geometry": {"type": "Point", "coordinates": [15, 42, 3]}}]}'
    )
    assert error(points).code == "import.no-layers"
    assert {"stations", "traces"} <= set(error(points).values["layers"])
    (tmp_path / "stations.csv").write_text("name,x,y,z\nA,1,2,3\nB,1,no,3\n")
    found = read_listed_features(tmp_path / "stations.csv", MODEL, records, CRS)
    assert [f.name for f in found.features] == ["A"]
    assert [name for name, _ in found.skipped] == ["B"]
    opened.close()


# --- the command line -------------------------------------------------------------------------
def test_commands_that_need_planes_report_that_none_exist(project: Path, tmp_path: Path):
    for form in ("stereonet", "orient", "faultkin", "wintensor", "gempy", "loopstructural", "gems"):
        code, said = command("export", project, "--to", form, "-o", tmp_path / f"{form}.txt")
        assert code == 2, form
        assert said["error"]["message"]
    code, said = command("project", project, "verify")
    assert code == 0
    code, said = command("project", project, "list")
    assert said["kinds"] == {"station": 1, "contact": 1, "lithology": 1}
    code, said = command("project", project, "fit")
    assert (code, said["planes"], said["lines"], said["skipped"]) == (0, [], [], [])


def test_features_without_orientation_never_count_as_planes(project: Path, tmp_path: Path):
    opened = ProjectFolder.open(project)
    session = opened.session
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.save()
    opened.close()
    code, said = command("project", project, "fit")
    assert [row["id"] for row in said["planes"]] == ["t1"]
    code, said = command("export", project, "--to", "csv", "-o", tmp_path / "t.csv")
    assert (code, said["n"]) == (0, 1)


def test_command_line_imports_a_file_as_one_step(project: Path, tmp_path: Path):
    command("export", project, "--to", "gpkg", "-o", tmp_path / "o.gpkg")
    code, said = command("project", project, "import", tmp_path / "o.gpkg")
    assert code == 0, said
    assert len(said["added"]) == 3
    assert said["features"] == 6
    code, said = command("project", project, "undo")
    assert said["features"] == 3


def test_python_returns_the_features_as_tables(project: Path):
    import vomstudio as vs

    with vs.Project.open(project) as opened:
        stations, contacts, rocks = opened.stations(), opened.contacts(), opened.lithologies()
        assert list(stations["number"]) == ["=KB-17"]
        assert stations["geometry"][0].z == pytest.approx(613.0)
        assert list(contacts["length_m"]) == [pytest.approx(17.0)]
        assert contacts["geometry"][0].has_z
        assert list(rocks["lithology"]) == ["sandstone"]
        assert list(rocks["area_m2"]) == [pytest.approx(6.5)]
        assert len(opened.planes()) == len(opened.lines()) == len(opened.traces()) == 0
