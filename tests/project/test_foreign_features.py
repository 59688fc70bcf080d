"""Traces and planes of other programs as features of a project."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.messages import refused
from tests.samples import ZIGZAG, bed
from tests.specimens.figures import command
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.exports.export import export_project
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.imports.feature_lists import ImportedFeatures, read_listed_features
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import measure_feature
from vomstudio.project.records import DEFAULT_TYPES, SURROUNDINGS_RULE, Model

pytestmark = pytest.mark.filterwarnings("ignore:Measured:UserWarning")

HASH = "0" * 64
CRS = "EPSG:32633"
ORIGIN = np.array([372411.0, 4709820.0, 613.0])
MODEL = Model("m1", "cliff", "cliff.obj", "mesh", HASH, Frame("crs", CRS))
RECORDS: dict[str, Any] = {"m1": MODEL, **{kind.id: kind for kind in DEFAULT_TYPES}}
POINTS = ORIGIN + np.array(ZIGZAG)


def read(path: Path, model: Model = MODEL, **options: Any) -> ImportedFeatures:
    crs = model.frame.crs
    return read_listed_features(path, model, {**RECORDS, "m1": model}, crs, **options)


def geojson(path: Path, *lines: tuple[dict[str, Any], Any], crs: str | None = CRS) -> Path:
    """Write lines by RFC 7946, with the older member `crs` that GDAL and QGIS write."""
    features = [
        {
            "type": "Feature",
            "properties": properties,
            "geometry": {"type": "LineString", "coordinates": np.asarray(points).tolist()},
        }
        for properties, points in lines
    ]
    content: dict[str, Any] = {"type": "FeatureCollection", "features": features}
    if crs is not None:
        name = f"urn:ogc:def:crs:EPSG::{crs.removeprefix('EPSG:')}"
        content["crs"] = {"type": "name", "properties": {"name": name}}
    path.write_text(json.dumps(content))
    return path


# --- doors ------------------------------------------------------------------------------------
def test_command_and_python_import_the_same_traces_in_one_step(tmp_path: Path) -> None:
    import vomstudio as vs

    corners = [[-1, -1, -1], [5, -1, -1], [5, 3, 3], [-1, 3, 3]]
    face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
    path = geojson(tmp_path / "a.geojson", ({"kind": "joint"}, ZIGZAG), crs=None)
    content = json.loads(path.read_text())
    # A member `crs` that is null stands for local coordinates, as in this program's exports.
    path.write_text(json.dumps({"crs": None, **content}))
    with vs.Project.create(tmp_path / "face.vom") as project:
        project.add_model(face, name="face")
        (by_python,) = project.import_file(path)
        project.save()
    code, result = command("project", tmp_path / "face.vom", "import", path)
    assert code == 0, result
    (by_command,) = [row["id"] for row in result["added"]]
    opened = ProjectFolder.open(tmp_path / "face.vom")
    first, second = (opened.session.records[id_] for id_ in (by_python, by_command))
    opened.close()
    assert isinstance(first, Trace)
    assert isinstance(second, Trace)
    assert replace(first, id="", name="") == replace(second, id="", name="")
    assert first.type_id == "joint"
    assert first.resolution is not None, "measured on the surface"
    assert first.rule == SURROUNDINGS_RULE
    code, result = command("project", tmp_path / "face.vom", "undo")
    assert result["features"] == 1


# --- lines of layers --------------------------------------------------------------------------
def test_lines_of_a_layer_become_traces_with_name_type_set_and_notes(tmp_path: Path) -> None:
    words = {"name": "F7", "type": "JOINT", "set": "J1", "notes": "wet"}
    found = read(geojson(tmp_path / "drawn.geojson", (words, POINTS), ({"name": "F8"}, POINTS)))
    first, second = found.features
    assert isinstance(first, Trace)
    assert np.array(first.vertices) == pytest.approx(POINTS)
    assert (first.name, first.type_id, first.set_name, first.notes) == ("F7", "joint", "J1", "wet")
    assert (second.name, second.type_id) == ("F8", "contact")
    assert (found.skipped, found.warnings) == ((), ())


def test_a_line_of_a_line_type_becomes_a_lineation(tmp_path: Path) -> None:
    found = read(geojson(tmp_path / "a.geojson", ({"kind": "fold axis"}, POINTS[:2])))
    (hinge,) = found.features
    assert isinstance(hinge, Lineation)
    assert hinge.type_id == "fold_axis"


def test_an_unknown_type_is_reported(tmp_path: Path) -> None:
    found = read(geojson(tmp_path / "a.geojson", ({"kind": "Dyke"}, POINTS)))
    assert [(w.code, w.values) for w in found.warnings] == [
        ("import.type-replaced", {"type": "dyke", "used": "Contact"})
    ]


def test_lines_that_define_no_plane_are_left_out_with_the_reason(tmp_path: Path) -> None:
    straight = ORIGIN + np.outer(range(4), [1.0, 2.0, 3.0])
    found = read(
        geojson(
            tmp_path / "a.geojson",
            ({"name": "good"}, POINTS),
            ({"name": "flat"}, POINTS[:, :2]),
            ({"name": "short"}, POINTS[:2]),
            ({"name": "straight"}, straight),
        )
    )
    assert [feature.name for feature in found.features] == ["good"]
    reasons = {name: reason.code for name, reason in found.skipped}
    assert reasons["flat"] == "import.no-heights"
    assert reasons["short"] == "import.too-few-points"
    assert set(reasons) == {"flat", "short", "straight"}
    with refused("import.nothing-usable"):
        read(geojson(tmp_path / "b.geojson", ({}, POINTS[:, :2])))


def test_lines_in_another_crs_are_converted(tmp_path: Path) -> None:
    from pyproj import Transformer

    to_degrees = Transformer.from_crs(CRS, "EPSG:4326", always_xy=True)
    degrees = np.column_stack([*to_degrees.transform(*POINTS[:, :2].T), POINTS[:, 2]])
    found = read(geojson(tmp_path / "a.geojson", ({}, degrees), crs=None))
    assert [finding.code for finding in found.warnings] == ["frame.reprojected"]
    assert np.array(found.features[0].vertices) == pytest.approx(POINTS, abs=1e-4)
    swapped = degrees[:, [1, 0, 2]]
    with refused("frame.swapped-axes"):
        read(geojson(tmp_path / "b.geojson", ({}, swapped), crs=None))


def test_orientations_of_the_file_are_compared_with_the_points(tmp_path: Path) -> None:
    plane = measure_feature(
        read(geojson(tmp_path / "a.geojson", ({}, POINTS))).features[0], MODEL
    ).plane
    assert plane is not None
    stated = {"dip_dir": plane.dip_direction_deg, "dip": plane.dip_deg}
    wrong = {"name": "w", "dip_dir": plane.dip_direction_deg + 180.0, "dip": plane.dip_deg}
    found = read(geojson(tmp_path / "b.geojson", (stated, POINTS), (wrong, POINTS)))
    (finding,) = found.warnings
    assert finding.code == "import.orientations-differ"
    assert finding.values["count"] == 1
    assert finding.values["total"] == 2
    assert finding.values["name"] == "w"
    assert float(finding.values["angle"]) == pytest.approx(2 * plane.dip_deg, abs=0.06)


def test_geopackage_shapefile_and_dxf_have_the_same_lines(tmp_path: Path) -> None:
    """Written by other libraries: geopandas and ezdxf."""
    import ezdxf
    import geopandas
    import shapely

    frame = geopandas.GeoDataFrame(
        {"name": ["F1", "F2"], "kind": ["fault", "Bedding"]},
        geometry=[shapely.LineString(POINTS), shapely.LineString(POINTS + 1.0)],
        crs=CRS,
    )
    frame.to_file(tmp_path / "a.gpkg", layer="mapped")
    frame.to_file(tmp_path / "a.shp")
    drawing = ezdxf.new()
    drawing.units = ezdxf.units.M
    for row in frame.itertuples():
        points = shapely.get_coordinates(row.geometry, include_z=True)
        drawing.modelspace().add_polyline3d(points, dxfattribs={"layer": row.kind})
    drawing.saveas(tmp_path / "a.dxf")
    for ending in ("gpkg", "shp", "dxf"):
        found = read(tmp_path / f"a.{ending}")
        assert [feature.type_id for feature in found.features] == ["fault", "bedding"]
        for feature, shift in zip(found.features, (0.0, 1.0), strict=True):
            assert np.array(feature.vertices) == pytest.approx(POINTS + shift, abs=1e-6)


def test_a_drawing_in_millimetres_is_converted(tmp_path: Path) -> None:
    import ezdxf

    drawing = ezdxf.new()
    drawing.units = ezdxf.units.MM
    drawing.modelspace().add_polyline3d(np.array(ZIGZAG) * 1000.0)
    drawing.saveas(tmp_path / "a.dxf")
    found = read(tmp_path / "a.dxf", replace(MODEL, placement=Frame("local")))
    assert np.array(found.features[0].vertices) == pytest.approx(np.array(ZIGZAG))
    assert "frame.unit-converted" in [finding.code for finding in found.warnings]


# --- round trip -------------------------------------------------------------------------------
@pytest.mark.parametrize("ending", ["gpkg", "shp", "geojson", "kml", "dxf"])
def test_exported_traces_are_imported_with_points_types_and_texts(
    tmp_path: Path, ending: str
) -> None:
    traces = [
        replace(bed("t1"), name="B1", set_name="S0", notes="wet", vertices=to_tuples(POINTS)),
        replace(bed("t2"), name="J1", type_id="joint", vertices=to_tuples(POINTS + 3.0)),
    ]
    hinge = Lineation("l1", "L1", "fold_axis", "m1", HASH, to_tuples(POINTS[:3]))
    opened = ProjectFolder.create(tmp_path / "face.vom")
    opened.session.apply(edits.add_model(opened.session.records, MODEL))
    opened.session.apply(edits.add_features(opened.session.records, [*traces, hinge]))
    records = dict(opened.session.records)
    opened.session.save()
    opened.close()
    export_project(tmp_path / "face.vom", ending, tmp_path / f"o.{ending}")
    parts = ["o"] if ending in ("gpkg", "kml", "dxf") else ["o_traces", "o_lineations"]
    features: list[Any] = []
    for part in parts:
        found = read_listed_features(tmp_path / f"{part}.{ending}", MODEL, records, CRS)
        assert found.skipped == ()
        expected = ["frame.reprojected"] if ending in ("kml", "geojson") else []
        assert [finding.code for finding in found.warnings] == expected
        features += found.features
    assert len(features) == 3
    back = {feature.type_id: feature for feature in features}
    for feature in (*traces, hinge):
        again = back[feature.type_id]
        assert type(again) is type(feature)
        assert np.array(again.vertices) == pytest.approx(np.array(feature.vertices), abs=1e-3)
        if ending != "dxf":
            # GDAL does not read the extended data of a DXF.
            assert (again.name, again.set_name) == (feature.name, feature.set_name)
            assert again.notes == feature.notes


def to_tuples(points: np.ndarray) -> tuple[Any, ...]:
    return tuple(tuple(point) for point in points.tolist())
