"""`vomstudio export`."""

from __future__ import annotations

from pathlib import Path

import pytest

import vomstudio as vs
from tests.messages import shown_codes
from vomstudio.geometry.frames import Frame
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model

# Vertices on a plane that dips 45 degrees to the east, and on its mirror image to the west.
EAST = ((0.0, 0.0, 0.0), (0.0, 9.0, 0.0), (4.0, 5.0, -4.0), (8.0, 1.0, -8.0), (3.0, 2.0, -3.0))
WEST = tuple((-x, y, z) for x, y, z in EAST)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "Kliff é.vom"
    opened = ProjectFolder.create(folder)
    session = opened.session
    frame = Frame(kind="crs", crs="EPSG:32615")
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, frame)
    session.apply(edits.add_model(session.records, model))
    for id_, name, points in (("t1", "Bed 1", EAST), ("t2", "Bed 2", WEST)):
        trace = Trace(id_, name, "bedding", "m1", "0" * 64, points, resolution=0.05)
        session.apply(edits.add_trace(session.records, trace))
    session.save()
    opened.close()
    return folder


def test_exported_table_contains_planes_and_frame(run, project: Path, tmp_path: Path) -> None:
    target = tmp_path / "planes.csv"
    ran = run("export", project, "--to", "csv", "-o", target, "--json")
    assert ran.code == 0
    assert ran.json["files"] == [str(target)]
    text = target.read_text(encoding="utf-8")
    assert "# CRS: EPSG:32615" in text
    found = read_orientations(target)
    assert found.column("name") == ["Bed 1", "Bed 2"]
    assert found.kinds == ("bedding", "bedding")
    assert found.dip_direction_deg == pytest.approx([90.0, 270.0])
    assert found.dip_deg == pytest.approx([45.0, 45.0])
    beta = run("fold", target, "--json").json["beta"]
    assert (beta["trend_deg"] % 180, beta["plunge_deg"]) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_layers_are_exported_as_geopackage(run, project: Path, tmp_path: Path) -> None:
    import pyogrio

    target = tmp_path / "layers.gpkg"
    ran = run("export", project, "--to", "gpkg", "-o", target, "--json")
    assert ran.code == 0
    layers = {name for name, _ in pyogrio.list_layers(target)}
    assert {"planes", "traces"} <= layers
    assert pyogrio.read_info(target, layer="planes")["crs"] == "EPSG:32615"
    assert sorted(p.name for p in tmp_path.iterdir()) == [project.name, "layers.gpkg", "layers.qgs"]


def test_geojson_is_projected_only_on_request(run, project: Path, tmp_path: Path) -> None:
    import pyogrio

    for words, crs in (((), "EPSG:4979"), (("--projected",), "EPSG:32615")):
        target = tmp_path / f"{crs[5:]}.geojson"
        assert run("export", project, "--to", "geojson", "-o", target, *words).code == 0
        assert pyogrio.read_info(target)["crs"] == crs
    with vs.Project.open(project) as opened:
        opened.export("geojson", tmp_path / "api.geojson", projected=True)
    assert (tmp_path / "api.geojson").read_text() == target.read_text()


def test_an_existing_export_is_replaced_only_by_force(run, project: Path, tmp_path: Path) -> None:
    target = tmp_path / "planes.csv"
    target.write_text("mine")
    assert "--force" in run("export", project, "--to", "csv", "-o", target).said
    assert target.read_text() == "mine"
    assert run("export", project, "--to", "csv", "-o", target, "--force").code == 0


def test_export_over_project_journal_is_refused(run, project: Path) -> None:
    journal = project / "journal.sqlite"
    before = journal.read_bytes()
    ran = run("export", project, "--to", "csv", "-o", journal, "--force")
    assert "output.is-input" in shown_codes(ran.said)
    assert journal.read_bytes() == before


@pytest.mark.parametrize("content", [None, b"", b"SQLite format 3\x00 but no more", b"words"])
def test_invalid_project_folder_is_refused(run, tmp_path: Path, content: bytes | None) -> None:
    folder = tmp_path / "bad.vom"
    folder.mkdir()
    if content is not None:
        (folder / "journal.sqlite").write_bytes(content)
    ran = run("export", folder, "--to", "csv", "-o", tmp_path / "out.csv", "--json")
    assert ran.code == 2
    assert ran.json["error"]["message"]
    assert not (tmp_path / "out.csv").exists()
    if content is not None:
        assert (folder / "journal.sqlite").read_bytes() == content


# GDAL says so of every 3DFACE.
@pytest.mark.filterwarnings("ignore:Non closed ring:RuntimeWarning")
def test_exported_drawings_and_shapefiles_are_listed(run, project: Path, tmp_path: Path) -> None:
    import pyogrio

    target = tmp_path / "o.shp"
    ran = run("export", project, "--to", "shp", "-o", target, "--json")
    assert ran.code == 0
    assert ran.json["files"] == [str(target), str(tmp_path / "o_traces.shp")]
    for path in ran.json["files"]:
        info = pyogrio.read_info(path)
        assert (info["features"], info["crs"]) == (2, "EPSG:32615")
    ran = run("export", project, "--to", "dxf", "-o", tmp_path / "d.dxf", "--json")
    assert ran.json["files"] == [str(tmp_path / "d.dxf")]
    drawn = pyogrio.read_info(tmp_path / "d.dxf", force_feature_count=True)["features"]
    assert drawn > 4
    assert ".shp" in run("export", project, "--to", "shp", "-o", tmp_path / "o").said
    assert "obj" in run("export", project, "--to", "obj", "-o", tmp_path / "o.obj").said


@pytest.mark.parametrize("word", ["CSV", "Gpkg", "GeoJSON", "LoopStructural"])
def test_export_format_is_case_insensitive(run, project: Path, tmp_path: Path, word: str) -> None:
    end = {"Gpkg": "gpkg", "GeoJSON": "geojson"}.get(word, "csv")
    small = run("export", project, "--to", word.lower(), "-o", tmp_path / f"a.{end}", "--json").json
    large = run("export", project, "--to", word, "-o", tmp_path / f"b.{end}", "--json").json
    assert large["n"] == small["n"] == 2
    assert [Path(f).name for f in large["files"]] == [
        Path(f).name.replace("a", "b", 1) for f in small["files"]
    ]
    with vs.Project.open(project) as opened:
        assert opened.export(word, tmp_path / f"c.{end}")
