"""Files for other programs: read back by those programs' rules, and by libraries."""

from __future__ import annotations

import csv
import json
import re
import shutil
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from tests.messages import by_code, refused
from tests.samples import ZIGZAG, bed
from vomstudio.core.errors import InputError
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.frames import Frame
from vomstudio.io.exchange.fault_slips import faultkin_sense
from vomstudio.io.gate.drawn_layers import read_raw_lines
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.project import edits
from vomstudio.project.exports.export import export_project
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.records import Model

SPECIMEN = Path(__file__).parents[2] / "specimens" / "schema1.vom"


@pytest.fixture(scope="module")
def specimen(tmp_path_factory) -> Path:
    """Planes, traces and lineations with every sense of slip."""
    folder = tmp_path_factory.mktemp("specimen") / "a.vom"
    shutil.copytree(SPECIMEN, folder)
    return folder


@pytest.fixture
def mapped(tmp_path) -> Path:
    """Two beds on a model with a CRS."""
    project = ProjectFolder.create(tmp_path / "map.vom")
    session = project.session
    frame = Frame("crs", "EPSG:32633")
    session.apply(edits.add_model(session.records, Model("m1", "c", "c.obj", "mesh", "0", frame)))
    for number, shift in enumerate((0.0, 2.5)):
        vertices = tuple((x + 576_665.725, y + 5_188_117.06, z + shift) for x, y, z in ZIGZAG)
        session.apply(edits.add_trace(session.records, bed(f"t{number}", vertices=vertices)))
    session.apply(
        edits.set_attributes(
            session.records, ["t1"], notes='"wet",\tdark', set_name="Ä", overturned=True
        )
    )
    session.save()
    project.close()
    return tmp_path / "map.vom"


def rows_of(path: Path, delimiter: str) -> list[dict[str, str]]:
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter=delimiter))


def movement(row: dict[str, str]) -> np.ndarray:
    """Of the hanging wall, by the two letters alone: T moves it up along the striae, N down; seen
    across the fault, R moves the far side to the right, L to the left."""
    plane = Plane(float(row["strike"]) + 90.0, float(row["dip"]))
    line = Line(float(row["trend"]), float(row["plunge"])).vector()
    first, second = row["sense"]
    if row["dip"] != "90" and float(row["plunge"]) > 1e-6:
        return -line if first == "T" else line
    # From the footwall, the hanging wall lies ahead, along the dip direction; its right is the
    # far end of the strike.
    right = (
        -plane.strike_vector()
        if row["dip"] != "90"
        else -Plane(float(row["strike"]) + 90.0, 89.999).strike_vector()
    )
    wanted = 1.0 if second == "R" else -1.0
    return line if np.sign(line @ right) == wanted else -line


def test_faultkin_export_has_correct_slip_sense(specimen, tmp_path) -> None:
    from vomstudio.geology.orientation import slip_from_rake

    made = export_project(specimen, "faultkin", tmp_path / "f.txt")
    written = rows_of(tmp_path / "f.txt", "\t")
    assert len(written) == len(made.rows) > 20
    for row, ours in zip(written, made.rows, strict=True):
        plane = Plane(ours["on_plane_dip_direction_deg"], ours["on_plane_dip_deg"])
        expected = slip_from_rake(plane, ours["slip_rake_deg"]).vector()
        assert movement(row) == pytest.approx(expected, abs=1e-5), row["label"]
    assert {row["sense"] for row in written} == {"TR", "TL", "NR", "NL"}
    assert {r["slip_sense"] for r in made.rows} == {"normal", "reverse", "sinistral", "dextral"}


def test_faultkin_sense_letters_follow_the_rake() -> None:
    rakes = {30: "TL", 150: "TR", -30: "NL", -150: "NR", 0: "NL", 180: "NR", 90: "TL", -90: "NL"}
    assert {rake: faultkin_sense(rake) for rake in rakes} == rakes


def test_features_without_slip_are_skipped_and_listed(specimen, tmp_path) -> None:
    made = export_project(specimen, "faultkin", tmp_path / "f.txt")
    assert "B01" in {item["name"] for item in made.skipped}


def test_project_without_slips_is_rejected(mapped, tmp_path) -> None:
    with pytest.raises(InputError, match="faultkin"):
        export_project(mapped, "faultkin", tmp_path / "f.txt")
    assert not (tmp_path / "f.txt").exists()


def test_wintensor_export_includes_unknown_senses(specimen, tmp_path) -> None:
    export_project(specimen, "wintensor", tmp_path / "w.txt")
    rows = rows_of(tmp_path / "w.txt", "\t")
    assert {row["Sense"] for row in rows} == set("NISDX")
    assert {row["Format"] for row in rows} == {"11"}
    assert all(row["Confidence"] == "X" for row in rows if row["Sense"] == "X")
    assert {row["Confidence"] for row in rows} == {"P", "X"}


def test_stereonet_has_a_file_of_planes_and_one_of_lines(specimen, tmp_path) -> None:
    made = export_project(specimen, "stereonet", tmp_path / "s.txt")
    assert [path.name for path in made.files] == ["s.txt", "s_lines.txt"]
    planes = rows_of(tmp_path / "s.txt", "\t")
    kept = [row for row in made.rows if row["element"] == "plane"]
    assert [float(row["strike"]) for row in planes] == pytest.approx(
        [row["strike_rhr_deg"] for row in kept], abs=1e-6
    )
    lines = rows_of(tmp_path / "s_lines.txt", "\t")
    assert len(lines) + len(planes) == len(made.rows)


def test_orient_export_has_planes_and_lines_under_orient_column_names(specimen, tmp_path) -> None:
    made = export_project(specimen, "orient", tmp_path / "o.tsv")
    rows = rows_of(tmp_path / "o.tsv", "\t")
    assert len(rows) == len(made.rows)
    assert list(rows[0])[:6] == ["Station", "X", "Y", "Z", "Dip Direction", "Dip"]
    assert all(bool(row["Dip"]) or bool(row["Plunge"]) for row in rows)


def test_gempy_gets_gradients_toward_the_younger_side(specimen, tmp_path) -> None:
    """As `gempy.API.io_API` of GemPy 2026 makes them of azimuth, dip and polarity."""
    made = export_project(specimen, "gempy", tmp_path / "g.csv")
    rows = rows_of(tmp_path / "g.csv", ",")
    azimuth, dip, polarity = (
        np.array([float(row[name]) for row in rows]) for name in ("azimuth", "dip", "polarity")
    )
    azimuth_rad, dip_rad = np.radians(azimuth), np.radians(dip)
    gradient = polarity[:, None] * np.stack(
        [
            np.sin(dip_rad) * np.sin(azimuth_rad),
            np.sin(dip_rad) * np.cos(azimuth_rad),
            np.cos(dip_rad),
        ],
        axis=1,
    )
    normals = np.array([[row[f"normal_{axis}"] for axis in "xyz"] for row in made.rows])
    sign = np.array([-1.0 if row["overturned"] else 1.0 for row in made.rows])
    assert gradient == pytest.approx(sign[:, None] * normals, abs=1e-6)
    assert -1.0 in polarity
    errors = [row["total95_deg"] for row in made.rows]
    known = [i for i, error in enumerate(errors) if error is not None]
    # Of 95 % of two directions are within sqrt(-2 ln 0.05) standard deviations.
    spread = np.sqrt([float(rows[i]["nugget"]) for i in known]) * np.sqrt(-2 * np.log(0.05))
    assert np.degrees(spread) == pytest.approx([errors[i] for i in known], rel=1e-9)
    points = rows_of(tmp_path / "g_surface_points.csv", ",")
    assert list(points[0]) == ["X", "Y", "Z", "formation"]


def test_loopstructural_gets_normals_and_surfaces(specimen, tmp_path) -> None:
    import pandas

    export_project(specimen, "loopstructural", tmp_path / "l.csv")
    data = pandas.read_csv(tmp_path / "l.csv")
    assert list(data) == ["X", "Y", "Z", "feature_name", "nx", "ny", "nz", "interface"]
    planes = data[data["nx"].notna()]
    assert np.linalg.norm(planes[["nx", "ny", "nz"]], axis=1) == pytest.approx(1.0)
    assert planes["interface"].isna().all()
    points = data[data["nx"].isna()]
    assert points.groupby("feature_name")["interface"].min().eq(0).all()


def test_gems_has_the_fields_of_the_standard(specimen, tmp_path) -> None:
    made = export_project(specimen, "gems", tmp_path / "g.csv")
    rows = rows_of(tmp_path / "g.csv", ",")
    assert list(rows[0])[:3] == ["Type", "Azimuth", "Inclination"]
    assert len({row["OrientationPoints_ID"] for row in rows}) == len(rows)
    for row, ours in zip(rows, made.rows, strict=True):
        assert all(row[name] for name in ("Type", "IdentityConfidence", "MapUnit"))
        if ours["element"] == "plane" and not ours["undefined"]:
            assert float(row["Azimuth"]) == pytest.approx(ours["strike_rhr_deg"], abs=1e-6)
    overturned = [r for r, o in zip(rows, made.rows, strict=True) if o["overturned"]]
    assert {row["Symbol"] for row in overturned if row["Type"] == "bedding"} == {"06.04"}


def test_overturned_beds_have_a_hook_in_drawings_and_kml(specimen, mapped, tmp_path) -> None:
    import ezdxf

    made = export_project(specimen, "dxf", tmp_path / "d.dxf")
    planes = [r for r in made.rows if r["element"] == "plane" and r["x"] is not None]
    hooked = [row for row in planes if row["overturned"]]
    assert hooked
    lines = ezdxf.readfile(tmp_path / "d.dxf").modelspace().query("LINE")
    for row in planes:
        place = np.array([row[axis] for axis in "xyz"])
        ends = np.array([[line.dxf.start.xyz, line.dxf.end.xyz] for line in lines]) - place
        away = np.linalg.norm(ends, axis=2)
        # The pieces of a half circle begin and end equally far from its middle, as the bar does.
        near = (np.abs(away[:, 0] - away[:, 1]) < 1e-6) & (
            np.linalg.norm(ends.sum(1), axis=1) > 1e-6
        )
        assert (near.sum() >= 8) == bool(row["overturned"])
    export_project(mapped, "kml", tmp_path / "k.kml")
    marks = (tmp_path / "k.kml").read_text("utf-8").split("<Placemark>")[1:]
    symbols = [mark for mark in marks if "<Point>" in mark and 'name="dip_deg"' in mark]

    def turned(mark: str) -> bool:
        return (
            re.search(r'name="overturned">\s*<displayName>[^<]*</displayName>\s*<value>True<', mark)
            is not None
        )

    for mark in symbols:
        assert mark.count("<LineString>") == (3 if turned(mark) else 2)
    assert any(map(turned, symbols))


def test_geojson_export_is_in_degrees_and_round_trips(mapped, tmp_path) -> None:
    """RFC 7946: longitude and latitude in WGS 84, and no member `crs`."""
    made = export_project(mapped, "geojson", tmp_path / "g.geojson")
    held = json.loads((tmp_path / "g.geojson").read_text("utf-8"))
    longitude, latitude, height = held["features"][0]["geometry"]["coordinates"]
    assert "crs" not in held
    assert (longitude, latitude) == pytest.approx((16.0, 46.84), abs=0.02)
    assert height == pytest.approx(made.rows[0]["z"], abs=1e-4)
    back = read_orientations(tmp_path / "g.geojson")
    places = back.table.numbers([back.table.find(axis) for axis in "xyz"])
    assert places == pytest.approx(
        np.array([[r[axis] for axis in "xyz"] for r in made.rows]), abs=2e-4
    )
    assert "frame.reprojected" in by_code(back.warnings)
    lines = read_raw_lines(tmp_path / "g_traces.geojson")
    assert (lines.crs, [w.code for w in lines.warnings]) == ("EPSG:32633", ["frame.reprojected"])


def test_projected_geojson_is_read_by_gdal_in_the_crs_of_the_project(mapped, tmp_path) -> None:
    import pyogrio

    made = export_project(mapped, "geojson", tmp_path / "g.geojson", is_projected=True)
    assert [path.name for path in made.files] == ["g.geojson", "g_traces.geojson"]
    information = pyogrio.read_info(tmp_path / "g_traces.geojson")
    assert information["crs"] == "EPSG:32633"
    assert information["features"] == 2
    held = json.loads((tmp_path / "g.geojson").read_text("utf-8"))
    point = held["features"][0]["geometry"]["coordinates"]
    assert point == [made.rows[0][axis] for axis in "xyz"]
    assert held["features"][1]["properties"]["set"] == "Ä"


def test_geojson_in_local_frame_warns_about_missing_crs(specimen, tmp_path) -> None:
    made = export_project(specimen, "geojson", tmp_path / "g.geojson")
    held = json.loads((tmp_path / "g.geojson").read_text("utf-8"))
    assert "crs" in held
    assert held["crs"] is None
    assert [finding.code for finding in made.warnings] == ["geojson.no-crs"]
    lines = read_raw_lines(tmp_path / "g_traces.geojson")
    assert lines.crs is None
    assert "frame.assumed" in by_code(lines.warnings)


def test_balloons_of_kml_have_names_and_rounded_values(mapped, tmp_path) -> None:
    made = export_project(mapped, "kml", tmp_path / "k.kml")
    space = {"k": "http://www.opengis.net/kml/2.2"}
    root = ElementTree.parse(tmp_path / "k.kml").getroot()
    mark = root.find(".//k:Placemark", space)
    assert mark is not None
    held = {
        data.get("name"): (
            data.findtext("k:displayName", None, space),
            data.findtext("k:value", None, space),
        )
        for data in mark.findall(".//k:Data", space)
    }
    title, text = held["dip_deg"]
    assert title != "dip_deg"
    assert float(str(text).rstrip("°")) == pytest.approx(made.rows[0]["dip_deg"], abs=0.5)
    assert len(str(text)) < 7
    assert held["id"][1] == made.rows[0]["id"]
    assert float(str(held["x"][1])) == pytest.approx(made.rows[0]["x"], abs=1e-3)


def test_kml_positions_match_the_outcrop(mapped, tmp_path) -> None:
    from pyproj import Transformer

    made = export_project(mapped, "kml", tmp_path / "k.kml")
    space = {"k": "http://www.opengis.net/kml/2.2"}
    root = ElementTree.parse(tmp_path / "k.kml").getroot()
    point = root.find(".//k:Point/k:coordinates", space)
    assert point is not None
    assert point.text is not None
    longitude, latitude, height = map(float, point.text.split(","))
    back = Transformer.from_crs("EPSG:4326", "EPSG:32633", always_xy=True)
    assert back.transform(longitude, latitude) == pytest.approx(
        (made.rows[0]["x"], made.rows[0]["y"]), abs=1e-3
    )
    assert height == pytest.approx(made.rows[0]["z"], abs=1e-3)
    names = [e.text for e in root.findall(".//k:Folder/k:name", space)]
    assert names == ["planes", "traces"]


def test_kml_export_in_local_frame_is_rejected(specimen, tmp_path) -> None:
    with refused("kml.no-crs"):
        export_project(specimen, "kml", tmp_path / "k.kml")


@pytest.mark.parametrize("format_", ["orient", "gems", "gempy"])
def test_text_values_do_not_break_columns(mapped, tmp_path, format_) -> None:
    made = export_project(mapped, format_, tmp_path / "x.txt")
    delimiter = "\t" if format_ == "orient" else ","
    rows = rows_of(tmp_path / "x.txt", delimiter)
    assert len(rows) == len(made.rows)
    assert all(None not in row for row in rows)
