"""The life of a project in a script: made, measured on, undone, saved, left, opened again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import geopandas
import numpy as np
import pandas
import pytest
import shapely

import vomstudio as vs
from tests.messages import refused, warned
from vomstudio.project.tables.orientation_table import COLUMNS

MODEL = vs.sample("sample.obj")
SPECIMEN = Path(__file__).resolve().parents[1] / "specimens" / "schema1.vom"


@pytest.fixture
def folder(tmp_path: Path, own_folders: Path) -> Path:
    return tmp_path / "cliff.vom"


@pytest.fixture
def bed(picks: Any) -> Any:
    return picks[picks["pick"] == "B01"][["x", "y", "z"]].to_numpy()


def test_project_is_created_measured_on_and_reopened(
    folder: Path, bed: Any, picks: Any, tmp_path: Path
) -> None:
    with vs.Project.create(folder) as project:
        model = project.add_model(MODEL)
        trace = project.add_trace(bed, model=model, type="BEDDING", name="first", set="west")
        fault = project.add_trace(
            picks[picks["kind"] == "fault"][["x", "y", "z"]], model="Sample", type="fault"
        )
        # The figures are those of the same points in a script, the verdict that of a model.
        fit, bare = project.fit(trace), vs.fit_plane(bed)
        assert isinstance(fit, vs.PlaneFit)
        assert (fit.dip_direction_deg, fit.dip_deg) == pytest.approx(
            (bare.dip_direction_deg, bare.dip_deg), abs=1e-6
        )
        assert fit.resolution_m is not None
        assert (fit.name, fit.kind, fit.set) == ("first", "bedding", "west")
        assert project.fit("first") == fit

        planes = project.planes()
        assert list(planes["id"]) == [trace, fault]
        assert list(planes.columns) == [*COLUMNS, "geometry"]
        assert planes["geometry"][0].equals(shapely.Point(fit.x, fit.y, fit.z))
        assert isinstance(planes, geopandas.GeoDataFrame)
        traces = project.traces()
        assert planes.crs == traces.crs == project.patches().crs == "EPSG:32633"
        line = traces.geometry[0]
        assert np.array(line.coords) == pytest.approx(bed, abs=1e-6)
        assert len(project.lines()) == len(project.patches()) == 0
        # Tables go on into the statistics; shapes do no harm there.
        assert vs.stats(planes, by="kind").sets["bedding"].n == 1

        assert project.unsaved
        assert "Add" in project.undo()
        assert list(project.planes()["id"]) == [trace]
        project.redo()
        assert len(project.planes()) == 2
        project.save()
        assert not project.unsaved

        (table,) = project.export("csv", tmp_path / "out.csv")
        read = vs.read_orientations(table)
        assert read["dip_deg"].tolist() == pytest.approx(planes["dip_deg"].tolist())
        found = project.verify()
        assert found.sound
        assert (found.models, found.features) == (1, 2)
    with vs.Project.open(folder) as again:
        assert [m.name for m in again.models] == ["sample"]
        assert again.models[0].features == 2
        pandas.testing.assert_frame_equal(again.planes(), planes)
        assert isinstance(again.models[0].read(), vs.Mesh)
    assert (folder / "project.gpkg").is_file()


def test_layers_without_common_crs_have_no_crs(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "triangle.obj"
    path.write_text("v 1 2 3\nv 4 2 3\nv 1 6 5\nf 1 2 3\n")
    with vs.Project.create(folder) as project:
        with warned("frame.assumed"):
            model = project.add_model(path)
        assert project.traces().crs is None
        project.add_trace([[1, 2, 3], [4, 2, 3], [1, 6, 5]], model=model, type="fault")
        assert project.traces().crs is project.planes().crs is None
        assert project.traces().geometry[0].geom_type == "LineString"
        assert project.traces().geometry.has_z.all()


def test_leaving_without_saving_discards_changes_and_can_be_undone(folder: Path, bed: Any) -> None:
    with vs.Project.create(folder) as project:
        model = project.add_model(MODEL)
        project.save()
        project.add_trace(bed, model=model, type="bedding")
    with vs.Project.open(folder) as project:
        assert len(project.planes()) == 0
        assert "Discard" in project.undo()
        assert len(project.planes()) == 1
        project.save()
    with vs.Project.open(folder) as project:
        assert len(project.planes()) == 1


def test_exception_in_with_block_discards_changes(folder: Path, bed: Any) -> None:
    def fails() -> None:
        with vs.Project.create(folder) as project:
            model = project.add_model(MODEL)
            project.add_trace(bed, model=model, type="bedding")
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        fails()
    with vs.Project.open(folder) as project:
        assert project.models == ()


def test_unsaved_changes_after_crash_survive_opening(folder: Path, bed: Any) -> None:
    project = vs.Project.create(folder)
    project.add_model(MODEL)
    # As a kernel that is killed leaves it.
    desk = project._open_project()
    desk.project.close()
    for _ in range(2):
        with (
            warned("project.recovered"),
            vs.Project.open(folder) as again,
        ):
            assert len(again.models) == 1


def test_project_cannot_be_opened_twice(folder: Path) -> None:
    with vs.Project.create(folder):
        with refused("project.locked"):
            vs.Project.open(folder)
        with refused("project.exists", vs.errors.TargetError):
            vs.Project.create(folder)
    vs.Project.open(folder).close()


def test_closed_project_reports_that_it_is_closed(folder: Path) -> None:
    project = vs.Project.create(folder)
    project.close()
    project.close()
    assert "closed" in repr(project)
    with refused("project.closed", vs.errors.DocumentError, file=folder):
        project.planes()


def test_old_project_gives_same_results_as_commands(
    command: Any, tmp_path: Path, own_folders: Path
) -> None:
    import shutil

    folder = tmp_path / "old.vom"
    shutil.copytree(SPECIMEN, folder)
    told = command("project", folder, "fit")
    # It was left unsaved when it was made.
    with warned("project.recovered"):
        opened = vs.Project.open(folder)
    with opened as project:
        for frame, rows in ((project.planes(), told["planes"]), (project.lines(), told["lines"])):
            assert list(frame["id"]) == [row["id"] for row in rows]
            for name in ("dip_direction_deg", "dip_deg", "trend_deg", "plunge_deg", "x", "rms_m"):
                values = [None if v != v else pytest.approx(v) for v in frame[name]]
                assert values == [row[name] for row in rows]
        line = project.fit(told["lines"][0]["id"])
        assert isinstance(line, vs.LineFit)
        assert line.trend_deg == pytest.approx(told["lines"][0]["trend_deg"])
        assert all(shape.geom_type == "Polygon" for shape in project.patches()["geometry"])
        assert all(shape.has_z for shape in project.patches()["geometry"])
        listed = command("project", folder, "list")
        assert [m.id for m in project.models] == [m["id"] for m in listed["models"]]
        # One of the patches repeats another and is not a structure of its own.
        assert len(project.patches()) == listed["kinds"]["patch"] - 1


@pytest.mark.parametrize(
    ("call", "kind", "code", "values"),
    [
        (
            lambda p, b: p.add_trace(b[:2], model="sample", type="bedding"),
            "GeometryError",
            "picks.no-plane",
            {"count": 1},
        ),
        (
            lambda p, b: p.add_trace(b.T, model="sample", type="bedding"),
            "InputError",
            "array.not-points",
            {"field": "points"},
        ),
        (
            lambda p, b: p.add_trace(b, model="sample", type="dyke"),
            "UsageError",
            "option.not-a-choice",
            {"value": "dyke"},
        ),
        (
            lambda p, b: p.add_trace(b, model="other", type="fault"),
            "UsageError",
            "option.not-a-choice",
            {"value": "other"},
        ),
        (
            lambda p, b: p.add_model("gone.obj"),
            "InputError",
            "file.missing",
            {"file": Path("gone.obj").absolute()},
        ),
        (
            lambda p, b: p.add_model(MODEL, up="x"),
            "InputError",
            "option.not-a-choice",
            {"value": "x", "choices": ("y", "z")},
        ),
        (
            lambda p, b: p.fit("B99"),
            "InputError",
            "record.missing",
            {"kind": "feature", "id": "B99"},
        ),
        (lambda p, b: p.redo(), "DocumentError", "edit.nothing-to-redo", {}),
        (lambda p, b: p.export("docx", "out.docx"), "InputError", "export.no-features", {}),
    ],
)
def test_actions_that_are_not_possible_are_refused(
    folder: Path, bed: Any, call: Any, kind: str, code: str, values: dict[str, Any]
) -> None:
    with vs.Project.create(folder) as project:
        project.add_model(MODEL)
        with refused(code, getattr(vs.errors, kind), **values):
            call(project, bed)


def test_export_over_project_files_is_refused(folder: Path, bed: Any) -> None:
    with vs.Project.create(folder) as project:
        project.add_trace(bed, model=project.add_model(MODEL), type="bedding")
        with pytest.raises(vs.errors.TargetError):
            project.export("csv", folder / "journal.sqlite", force=True)
        with refused("option.not-a-choice", vs.errors.UsageError):
            project.export("docx", folder.parent / "out.docx")


def test_a_model_without_a_frame_comes_with_a_warning(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "triangle.obj"
    path.write_text("v 1 2 3\nv 4 2 3\nv 1 6 5\nf 1 2 3\n")
    with vs.Project.create(folder) as project:
        with pytest.warns(vs.errors.VomWarning) as record:
            first = project.add_model(path)
        assert [each.message.code for each in record] == ["frame.assumed"]
        with warned("model.already-added"):
            assert project.add_model(path) == first
        assert project.models[0].read().points.tolist() == [[1, 2, 3], [4, 2, 3], [1, 6, 5]]
        path.write_text("v 1 2 3\nv 4 2 3\nv 1 6 6\nf 1 2 3\n")
        with refused("model.changed"):
            project.models[0].read()
        path.unlink()
        with refused("model.file-missing"):
            project.models[0].read()


@pytest.mark.parametrize("name", ["none.vom", "words.txt"])
def test_invalid_project_path_is_refused(tmp_path: Path, own_folders: Path, name: str) -> None:
    (tmp_path / "words.txt").write_text("no project")
    with pytest.raises(vs.errors.InputError):
        vs.Project.open(tmp_path / name)


def test_project_has_repr(folder: Path) -> None:
    with vs.Project.create(folder) as project:
        project.add_model(MODEL)
        assert "sample" in repr(project)
        assert "unsaved changes" in project._repr_html_()


def test_project_with_deleted_folder_refuses_edits_until_saved_elsewhere(tmp_path):
    import shutil

    import vomstudio as vs

    with vs.Project.create(tmp_path / "a.vom") as project:
        project.add_model(vs.sample("sample.obj"))
        shutil.rmtree(tmp_path / "a.vom")
        with refused("journal.folder-gone", vs.errors.DocumentError):
            project.judge_by("textbook")
        project.save_as(tmp_path / "b.vom")
        project.judge_by("textbook")
        assert [model.name for model in project.models] == ["sample"]
        project.save()
    with vs.Project.open(tmp_path / "b.vom") as project:
        assert project.verify().sound
    assert not (tmp_path / "a.vom").exists()
