"""What leaves a project is what was measured, in the frame it was declared in."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.messages import refused
from tests.samples import ZIGZAG, bed
from vomstudio.core.errors import TargetError, UsageError
from vomstudio.geometry.frames import Frame
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.project import edits
from vomstudio.project.exports.export import export_project
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Model
from vomstudio.project.tables.project_table import UNKNOWN_NORTH_TEXT

UTM = Frame("crs", "EPSG:32633")


@pytest.fixture
def project(tmp_path):
    project = ProjectFolder.create(tmp_path / "a.vom")
    session = project.session
    session.apply(
        edits.add_model(
            session.records,
            Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, UTM),
        )
    )
    for number, shift in enumerate((0.0, 2.5)):
        vertices = tuple((x + 576_665.725, y + 5_188_117.06, z + shift) for x, y, z in ZIGZAG)
        session.apply(edits.add_trace(session.records, bed(f"t{number}", vertices=vertices)))
    session.apply(
        edits.set_attributes(session.records, ["t1"], notes='5" bed, "wet"', set_name="Ä")
    )
    yield project
    project.close()


def test_table_contains_the_values_of_the_window(project, tmp_path):
    export_project(project.folder, "csv", tmp_path / "o.csv")
    table = read_orientations(tmp_path / "o.csv")
    measured = Measurements().of(project.session.records, ["t0", "t1"])
    np.testing.assert_allclose(
        table.dip_deg, [m.fit.dip_deg for m in measured.values()], rtol=1e-10
    )
    np.testing.assert_allclose(
        table.dip_direction_deg, [m.fit.dip_direction_deg for m in measured.values()], rtol=1e-10
    )
    text = (tmp_path / "o.csv").read_text(encoding="utf-8")
    assert "# CRS: EPSG:32633" in text
    assert '"5"" bed, ""wet"""' in text
    assert "Ä" in text


def test_gdal_reads_the_layers_with_coordinates_and_crs(project, tmp_path):
    import shapely
    from pyogrio.raw import read

    export_project(project.folder, "gpkg", tmp_path / "o.gpkg")
    meta, _, geometry, columns = read(tmp_path / "o.gpkg", layer="traces")
    assert meta["crs"] == "EPSG:32633"
    lines = shapely.from_wkb(geometry)
    for line, id_ in zip(lines, ("t0", "t1"), strict=True):
        kept = np.array(project.session.records[id_].vertices)
        np.testing.assert_array_equal(shapely.get_coordinates(line, include_z=True), kept)
    fields = dict(zip(meta["fields"], columns, strict=True))
    assert list(fields["set"]) == ["", "Ä"]
    meta, _, geometry, columns = read(tmp_path / "o.gpkg", layer="planes")
    fields = dict(zip(meta["fields"], columns, strict=True))
    centres = shapely.get_coordinates(shapely.from_wkb(geometry), include_z=True)
    for centre, id_, dip in zip(centres, ("t0", "t1"), fields["dip_deg"], strict=True):
        np.testing.assert_allclose(
            centre, np.mean(project.session.records[id_].vertices, axis=0), rtol=1e-15
        )
        assert dip == pytest.approx(
            Measurements().of(project.session.records, [id_])[id_].fit.dip_deg
        )


def test_local_model_has_no_crs_and_undeclared_model_states_it(project, tmp_path):
    session = project.session
    session.apply(edits.declare_frame(session.records, "m1", Frame("local")))
    export_project(project.folder, "csv", tmp_path / "local.csv")
    assert "none declared" in (tmp_path / "local.csv").read_text()
    session.apply(edits.declare_frame(session.records, "m1", Frame()))
    export_project(project.folder, "csv", tmp_path / "undeclared.csv")
    text = (tmp_path / "undeclared.csv").read_text()
    assert UNKNOWN_NORTH_TEXT in text
    assert Frame().name() in text


def test_output_is_replaced_only_with_force_and_leaves_no_partial_files(project, tmp_path):
    out = tmp_path / "o.gpkg"
    out.write_text("precious")
    with refused("output.exists", TargetError, file=out):
        export_project(project.folder, "gpkg", out)
    assert out.read_text() == "precious"
    export_project(project.folder, "gpkg", out, force=True)
    assert out.read_bytes()[:6] == b"SQLite"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.vom", "o.gpkg", "o.qgs"]


def test_unknown_format_is_rejected(project, tmp_path):
    with refused("option.not-a-choice", UsageError, value="docx"):
        export_project(project.folder, "docx", tmp_path / "o.docx")


def test_an_empty_project_has_nothing_to_export(tmp_path):
    ProjectFolder.create(tmp_path / "b.vom").close()
    with refused("export.no-features"):
        export_project(tmp_path / "b.vom", "csv", tmp_path / "o.csv")
    assert not (tmp_path / "o.csv").exists()


def test_the_command_line_writes_the_same_table(project, tmp_path, capfd):
    from vomstudio.cli import main

    export_project(project.folder, "csv", tmp_path / "a.csv")
    words = ["export", str(project.folder), "--to", "csv", "-o", str(tmp_path / "b.csv"), "--json"]
    assert main(words) == 0
    said = json.loads(capfd.readouterr().out)
    assert said["files"] == [str(tmp_path / "b.csv")]
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    assert main(words) == 2
    assert len(project.session.of(Trace)) == 2


def test_verdicts_use_the_thresholds_of_the_user(tmp_path):
    strict = {"thresholds": {"good_confidence95_deg": 1e-6, "poor_confidence95_deg": 1e-5}}
    for name, settings in (("plain", {}), ("strict", strict)):
        project = ProjectFolder.create(tmp_path / f"{name}.vom", settings=lambda s=settings: s)
        session = project.session
        model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, UTM)
        session.apply(edits.add_model(session.records, model))
        session.apply(edits.add_trace(session.records, bed("t1")))
        table = export_project(project.folder, "csv", tmp_path / f"{name}.csv")
        project.close()
        qualities = [row["quality"] for row in table.rows]
        assert qualities == ["poor"] if name == "strict" else qualities != ["poor"]
