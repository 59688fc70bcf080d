"""`vomstudio project`: what the window can do to a project, without a window."""

from __future__ import annotations

import html
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.conftest import Run
from tests.messages import by_code, codes, shown_codes
from tests.specimens import figures
from vomstudio.core.paths import resource
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, TEXTBOOK_THRESHOLDS
from vomstudio.geometry import transform
from vomstudio.geometry.brush import MeshSurface
from vomstudio.geometry.frames import Frame
from vomstudio.io.models.opening import read_model
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import read_replay
from vomstudio.project.journal.migration import SCHEMA_VERSION
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Feature, Model
from vomstudio.project.sample import read_truth, sample_model
from vomstudio.studio.tools.local_surface import measure_surroundings

pytestmark = pytest.mark.usefixtures("own_folders")

# On a plane that dips 45 degrees to the east.
EAST = ((0.0, 0.0, 0.0), (0.0, 9.0, 0.0), (4.0, 5.0, -4.0), (8.0, 1.0, -8.0), (3.0, 2.0, -3.0))
PICKS = resource("sample", "picks.csv")
# A triangle as large as EAST, in feet and with Y up.
OBJ = "v 0 0 0\nv 40 0 0\nv 0 -40 -40\nf 1 2 3\n"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """With a model whose file is gone, and one trace on it."""
    folder = tmp_path / "Kliff é.vom"
    opened = ProjectFolder.create(folder)
    session = opened.session
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("crs", "EPSG:32615"))
    session.apply(edits.add_model(session.records, model))
    trace = Trace("t1", "", "bedding", "m1", "0" * 64, EAST, set_name="west", resolution=0.05)
    session.apply(edits.add_trace(session.records, trace))
    session.save()
    opened.close()
    return folder


@pytest.fixture
def empty(tmp_path: Path) -> Path:
    folder = tmp_path / "empty.vom"
    ProjectFolder.create(folder).close()
    return folder


def traces(folder: Path) -> list[Trace]:
    return [r for r in read_replay(folder).records.values() if isinstance(r, Trace)]


def labels(folder: Path) -> list[str]:
    return [edit.label for _, edit in read_replay(folder).done]


def rows_of(folder: Path) -> list[tuple[object, ...]]:
    with sqlite3.connect(folder / "journal.sqlite") as db:
        found = db.execute("SELECT * FROM journal").fetchall()
    db.close()
    return found


def change_rows(folder: Path, statement: str) -> None:
    with sqlite3.connect(folder / "journal.sqlite") as db:
        db.execute(statement)
    db.close()


# --- looking -------------------------------------------------------------------------------------
def test_list_works_while_project_is_open_in_window(run, project: Path) -> None:
    window = ProjectFolder.open(project)
    found = run("project", project, "list", "--json").json
    window.close()
    (model,) = found["models"]
    assert (model["id"], model["name"], model["crs"]) == ("m1", "cliff", "EPSG:32615")
    assert model["features"] == found["features"] == 1
    assert (found["kinds"], found["types"], found["sets"]) == (
        {"trace": 1},
        {"Bedding": 1},
        {"west": 1},
    )
    assert found["schema"] == SCHEMA_VERSION
    assert found["sound"]
    assert not found["unsaved"]
    assert found["history"]["undo"] == 2
    assert found["history"]["undo_label"] == labels(project)[-1]


def test_fit_matches_row_of_exported_table(run, project: Path, tmp_path: Path) -> None:
    (row,) = run("project", project, "fit", "--json").json["planes"]
    assert (row["id"], row["name"], row["kind"]) == ("t1", "B01", "bedding")
    assert (row["dip_direction_deg"], row["dip_deg"]) == pytest.approx((90.0, 45.0))
    assert run("project", project, "fit", "t1", "--json").json["planes"] == [row]
    assert run("project", project, "fit", "B01", "--json").json["planes"] == [row]
    by_error = run("project", project, "fit")
    assert by_error.out.splitlines()[-1] == DEFAULT_THRESHOLDS.description
    assert run("project", project, "profile", "textbook").code == 0
    assert run("project", project, "fit").out.splitlines()[-1] == TEXTBOOK_THRESHOLDS.description
    refused = run("project", project, "fit", "B02", "--json")
    assert refused.code == 2
    assert refused.json["error"]["code"] == "record.missing"
    assert refused.json["error"]["id"] == "B02"


# --- undo and redo -------------------------------------------------------------------------------
def test_undo_and_redo_work_as_in_window(run, project: Path) -> None:
    done = labels(project)
    undone = run("project", project, "undo", "--json").json
    label = undone["undone"]
    assert label == done[-1]
    assert label.endswith(" B01")
    assert undone["features"] == 0
    assert undone["history"] == {
        "undo": 1,
        "redo": 1,
        "undo_label": done[-2],
        "redo_label": label,
    }
    assert not undone["unsaved"]
    redone = run("project", project, "redo", "--json").json
    assert redone["redone"] == label
    assert [trace.vertices for trace in traces(project)] == [EAST]
    assert (project / "project.gpkg").is_file()
    nothing = run("project", project, "redo", "--json")
    assert nothing.json["error"]["code"] == "edit.nothing-to-redo"
    assert run("project", project, "undo").code == 0
    assert not (project / "project.gpkg").exists(), "layers of nothing"
    assert run("project", project, "undo").code == 0
    nothing = run("project", project, "undo", "--json")
    assert nothing.code == 2
    assert nothing.json["error"]["code"] == "edit.nothing-to-undo"


def test_a_project_that_is_open_in_a_window_is_not_changed(run, project: Path) -> None:
    window = ProjectFolder.open(project)
    before = (project / "journal.sqlite").read_bytes()
    for words in (["undo"], ["add-model", sample_model()], ["compact"]):
        ran = run("project", project, *words, "--json")
        assert (ran.code, ran.json["error"]["code"]) == (2, "project.locked")
    assert (project / "journal.sqlite").read_bytes() == before
    window.close()


# --- models --------------------------------------------------------------------------------------
def test_a_model_comes_with_the_frame_of_its_file(run, empty: Path) -> None:
    added = run("project", empty, "add-model", sample_model(), "--json").json
    (model,) = added["models"]
    assert added["model"] == model["id"]
    assert added["added"]
    assert (model["name"], model["kind"], model["crs"]) == ("sample", "mesh", "EPSG:32633")
    assert not added["unsaved"]
    again = run("project", empty, "add-model", sample_model(), "--json")
    assert again.json["model"] == model["id"]
    assert not again.json["added"]
    assert "already" in again.err
    assert len(again.json["models"]) == 1
    assert again.json["history"]["undo"] == 1


def test_model_without_frame_is_local_with_warning(run, empty: Path, write) -> None:
    ran = run("project", empty, "add-model", write(OBJ, "face.obj"), "--json")
    assert ran.json["models"][0]["frame"] == Frame("local").name()
    assert codes(ran.json) == ["frame.assumed"]


@pytest.mark.parametrize(
    ("words", "frame", "expected"),
    [
        (
            ["--crs", "32633", "--up", "y"],
            Frame("crs", "EPSG:32633", 1.0, "y"),
            ["frame.outside-area"],
        ),
        (["--up", "y", "--unit", "ft"], Frame("local", None, 0.3048, "y"), []),
        (["--unit", "cm"], Frame("local", None, 0.01, "z"), ["frame.assumed"]),
    ],
)
def test_frame_is_declared_by_options(
    run, empty: Path, write, words: list[str], frame: Frame, expected: list[str]
) -> None:
    ran = run("project", empty, "add-model", write(OBJ, "face.obj"), *words, "--json")
    assert codes(ran.json) == expected
    (model,) = [r for r in read_replay(empty).records.values() if isinstance(r, Model)]
    assert model.frame == frame


def test_unit_contradicting_crs_is_refused(run, empty: Path, write) -> None:
    words = ("--crs", "EPSG:32633", "--unit", "ft")
    ran = run("project", empty, "add-model", write(OBJ, "face.obj"), *words)
    assert ran.code == 2
    assert "--unit" in ran.said
    assert run("project", empty, "list", "--json").json["models"] == []


# --- picks ---------------------------------------------------------------------------------------
@pytest.mark.full
def test_sample_picks_reproduce_true_planes(run, empty: Path) -> None:
    run("project", empty, "add-model", sample_model())
    added = run(
        "project", empty, "add-picks", PICKS, "--type", "bedding", "--by", "pick", "--json"
    ).json
    assert len(added["added"]) == added["features"] == len(traces(empty))
    assert added["history"]["undo"] == 2, "one step back takes all of them away"
    rows = {row["name"]: row for row in run("project", empty, "fit", "--json").json["planes"]}
    truth = read_truth().planes
    assert set(truth) <= set(rows)
    for name, plane in truth.items():
        assert rows[name]["dip_deg"] == pytest.approx(plane.dip_deg, abs=4.0), name
        assert rows[name]["extent_over_resolution"] is not None
    run("project", empty, "undo")
    assert traces(empty) == []


@pytest.mark.full
def test_picks_measure_surroundings_like_window_tool(run, empty: Path, write) -> None:
    run("project", empty, "add-model", sample_model())
    run("project", empty, "add-picks", PICKS, "--type", "Fault", "--by", "pick")
    surface = MeshSurface(read_model(sample_model()).data)
    for trace in traces(empty)[:3]:
        assert trace.type_id == "fault"
        resolution, normal = measure_surroundings(surface, trace.vertices)
        assert trace.resolution == resolution
        assert trace.outcrop_normal == normal


def test_world_points_are_converted_to_model_frame(run, empty: Path, write) -> None:
    run("project", empty, "add-model", write(OBJ, "a.obj"), "--up", "y", "--unit", "ft")
    table = write("x,y,z\n" + "\n".join(f"{x},{y},{z}" for x, y, z in EAST) + "\n", "east.csv")
    run("project", empty, "add-picks", table, "--type", "joint", "--set", "J1")
    (trace,) = traces(empty)
    assert (trace.set_name, trace.name) == ("J1", "J01")
    to_world = Frame("local", None, 0.3048, "y").to_world()
    assert np.allclose(transform.apply(to_world, trace.vertices), EAST, atol=1e-12)
    (row,) = run("project", empty, "fit", "--json").json["planes"]
    assert (row["dip_direction_deg"], row["dip_deg"]) == pytest.approx((90.0, 45.0))


def test_picks_can_be_added_as_lines_and_patches(run, tmp_path: Path, write) -> None:
    folder = tmp_path / "walls.vom"
    model = write("v 0 0 0\nv 9 0 0\nv 9 0 9\nv 0 0 9\nf 1 2 3\nf 1 3 4\n", "wall.obj")
    assert run("project", folder, "create").code == 0
    assert run("project", folder, "add-model", model, "--up", "z", "--unit", "m").code == 0
    ring = "x,y,z,name\n" + "".join(f"{x},0,{z},R\n" for x, z in ((-1, -1), (9, -1), (9, 9)))
    words = ("project", folder, "add-picks", write(ring), "--by", "name", "--json")
    made = run(*words, "--type", "contact", "--shape", "line").json
    assert made["kinds"] == {"contact": 1}
    made = run(*words, "--type", "joint", "--shape", "patch").json
    assert made["kinds"] == {"contact": 1, "patch": 1}
    (row,) = run("project", folder, "fit", "--json").json["planes"]
    assert (row["name"], row["kind"], row["area_m2"]) == ("R", "joint", 40.5)
    refused = run(*words, "--type", "joint", "--shape", "circle").json["error"]
    assert refused["code"] == "option.not-a-choice"


def test_picks_without_plane_are_reported_and_others_added(run, project: Path, write) -> None:
    lines = ["x,y,z,bed", *(f"{x},{y},{z},good" for x, y, z in EAST)]
    lines += ["0,0,0,short", "1,1,1,short"]
    ran = run(
        "project",
        project,
        "add-picks",
        write("\n".join(lines)),
        "--type",
        "bedding",
        "--by",
        "bed",
        "--json",
    )
    assert [item["name"] for item in ran.json["added"]] == ["good"]
    assert [item["id"] for item in ran.json["skipped"]] == ["short"]
    assert by_code(ran.json["warnings"])["model.file-missing"]["model"] == "cliff"
    only = run("project", project, "add-picks", write("x,y,z\n0,0,0\n1,1,1\n"), "--type", "fault")
    assert only.code == 2
    assert "plane" in only.said
    assert len(traces(project)) == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--type", "bedrock"], ("--type", "bedrock", "Bedding, Fault")),
        (["--type", "fault", "--model", "face"], ("--model", "face", "cliff")),
        (["--type", "fault", "--by", "bed"], ("bed",)),
        ([], ("--type",)),
    ],
)
def test_unknown_names_are_reported_with_available_ones(run, project, write, words, said) -> None:
    table = write("x,y,z\n0,0,0\n0,9,0\n4,5,-4\n")
    ran = run("project", project, "add-picks", table, *words)
    assert ran.code == 2
    for word in said:
        assert word in ran.said
    assert len(traces(project)) == 1


# --- soundness -----------------------------------------------------------------------------------
def test_valid_project_is_verified_and_repair_is_refused(run, project: Path) -> None:
    found = run("project", project, "verify", "--json").json
    assert found["sound"]
    assert found["problems"] == []
    refused = run("project", project, "repair")
    assert refused.code == 2
    assert "journal.sound" in shown_codes(refused.said)


def test_damaged_row_is_reported_and_repair_keeps_the_rest(run, project: Path, write) -> None:
    lines = [
        "x,y,z,bed",
        *(f"{x},{y},{z + shift},{name}" for name, shift in (("a", 5.0),) for x, y, z in EAST),
    ]
    table = write("\n".join(lines))
    run("project", project, "add-picks", table, "--type", "fault", "--by", "bed")
    change_rows(project, "UPDATE journal SET label = 'x' WHERE label = 'Add bedding trace B01'")
    damaged = run("project", project, "verify", "--json")
    assert damaged.code == 2
    assert not damaged.json["sound"]
    assert len(damaged.json["problems"]) == 1
    assert "compaction.damaged" in shown_codes(run("project", project, "compact").said)
    before = (project / "journal.sqlite").read_bytes()
    repaired = run("project", project, "repair", "--json").json
    assert repaired["sound"]
    assert len(repaired["lost"]) == 1
    assert Path(repaired["kept"]).read_bytes()[:16] == before[:16]
    assert read_replay(Path(repaired["kept"])).problems != []
    assert run("project", project, "verify").code == 0
    assert [trace.name for trace in traces(project)] == ["a"]
    assert run("project", project, "undo", "--json").json["undone"] == "Add a"


def test_compact_removes_unreachable_rows_after_dry_run(run, project: Path, write) -> None:
    table = write("x,y,z\n" + "\n".join(f"{x},{y},{z}" for x, y, z in EAST))
    run("project", project, "undo")
    run("project", project, "add-picks", table, "--type", "fault")
    before = run("project", project, "list", "--json").json
    rows_before = rows_of(project)
    plan = run("project", project, "compact", "--dry-run", "--json").json
    assert not plan["compacted"]
    assert plan["rows"] > 0
    assert rows_of(project) == rows_before
    done = run("project", project, "compact", "--json").json
    assert done["compacted"]
    assert done["rows"] == plan["rows"]
    after = run("project", project, "list", "--json").json
    assert after == before
    assert not run("project", project, "compact", "--json").json["compacted"]


# --- words ---------------------------------------------------------------------------------------
def test_invalid_project_is_refused_in_one_sentence(run, tmp_path: Path) -> None:
    for action in ("list", "undo", "verify", "fit"):
        ran = run("project", tmp_path / "none.vom", action, "--json")
        assert ran.code == 2
        assert ran.json["error"]["file"]


def test_unknown_action_lists_available_ones(run, project) -> None:
    ran = run("project", project, "frobnicate")
    assert ran.code == 2
    assert "add-picks" in ran.said


# --- verdicts and what they rest on ---------------------------------------------------------------
def test_misspelt_action_is_reported_before_its_options(run, project: Path) -> None:
    ran = run("project", project, "reprot", "-o", "report.html", "--json")
    assert ran.json["error"]["code"] == "command.misspelt"
    assert ran.json["error"]["nearest"] == "report"
    ran = run("project", project, "--modle", "cliff", "report", "-o", "report.html", "--json")
    assert (ran.json["error"]["code"], ran.json["error"]["value"]) == (
        "command.unknown-argument",
        "--modle",
    )


def test_quality_profile_can_be_changed_and_undone(run: Run, project: Path) -> None:
    assert fitted(run, project)["profile"] == "error"
    said = run("project", project, "profile", "textbook", "--json").json
    assert said["profile"] == "textbook"
    row = fitted(run, project)
    # Five points exactly in one plane, longer than a hundred resolutions, and hardly drawn out.
    assert (row["profile"], row["quality"]) == ("textbook", "good")
    again = run("project", project, "profile", "textbook", "--json")
    assert again.code == 2
    assert "already" in again.json["error"]["message"]
    assert run("project", project, "undo", "--json").json["undone"].endswith("textbook")
    assert fitted(run, project)["profile"] == "error"
    out = project.parent / "planes.csv"
    run("project", project, "redo")
    assert run("export", project, "--to", "csv", "-o", out).code == 0
    head, *rows = [ln for ln in out.read_text("utf-8").splitlines() if not ln.startswith("#")]
    assert dict(zip(head.split(","), rows[0].split(","), strict=False))["id"] == "t1"
    assert ",textbook," in rows[0]


def test_unknown_profile_is_refused(run: Run, project: Path) -> None:
    said = run("project", project, "profile", "mine", "--json")
    assert said.code == 2
    assert "textbook" in said.json["error"]["message"]


def fitted(run: Run, project: Path) -> dict[str, Any]:
    (row,) = run("project", project, "fit", "--json").json["planes"]
    assert isinstance(row, dict)
    return row


def test_features_of_old_rule_are_reported_and_updated(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "cliff.vom"
    opened = ProjectFolder.create(folder)
    opened.close()
    file = tmp_path / "wall.obj"
    # A wall that faces south, with a vertex every half metre.
    file.write_text(wall(0.5), encoding="utf-8")
    assert run("project", folder, "add-model", file, "--up", "z", "--unit", "m").code == 0
    opened = ProjectFolder.open(folder)
    session = opened.session
    (model,) = session.of(Model)
    # Dips 60 degrees to the south, with scatter along its normal.
    x = np.linspace(-3.0, 3.0, 9)
    down, off = 0.3 * x**2, 0.05 * (-1.0) ** np.arange(9)
    xyz = np.column_stack([x, -0.5 * down - 0.866 * off, 4.0 - 0.866 * down + 0.5 * off])
    points = tuple((a, b, c) for a, b, c in xyz.tolist())
    old = Trace(
        "old",
        "B01",
        "bedding",
        model.id,
        model.content_hash,
        points,
        resolution=3.0,
        outcrop_normal=(0.0, 0.0, 1.0),
        method="regression",
    )
    session.apply(edits.add_trace(session.records, old))
    session.save()
    opened.close()
    before = fitted(run, folder)
    assert "plane.earlier-rule" in shown_codes(before["quality_notes"])
    assert before["resolution_m"] == 3.0
    said = run("project", folder, "update", "--json").json
    assert said["updated"] == 1
    after = fitted(run, folder)
    assert "plane.earlier-rule" not in shown_codes(after["quality_notes"] or "")
    assert after["resolution_m"] == pytest.approx(0.5, rel=0.5)
    # y = a x + b z + c, since the normal lies nearest to y.
    (a, b, _), *_ = np.linalg.lstsq(np.column_stack([x, xyz[:, 2], np.ones(9)]), xyz[:, 1])
    assert after["dip_deg"] == pytest.approx(np.degrees(np.arctan2(np.hypot(a, 1.0), abs(b))))
    none = run("project", folder, "update", "--json")
    assert none.code == 2
    assert none.json["error"]["code"] == "surroundings.up-to-date"
    run("project", folder, "undo")
    assert fitted(run, folder)["resolution_m"] == 3.0


def wall(step: float) -> str:
    xs = np.arange(-4.0, 4.0 + step, step)
    zs = np.arange(0.0, 6.0 + step, step)
    lines = [f"v {x} 0 {z}" for z in zs for x in xs]
    n = len(xs)
    for j in range(len(zs) - 1):
        for i in range(n - 1):
            a = j * n + i + 1
            lines += [f"f {a} {a + 1} {a + n + 1}", f"f {a} {a + n + 1} {a + n}"]
    return "\n".join(lines) + "\n"


@pytest.mark.full
def test_registering_model_by_points_moves_its_measurements(run: Run, tmp_path: Path) -> None:
    """A quarter about the vertical turns every dip direction by 90 degrees; undoing it turns them
    back."""
    folder = figures.copy_of("schema1", tmp_path)
    before = {r["id"]: r for r in run("project", folder, "fit", "--json").json["planes"]}
    model = np.array([[0, 0, 0], [9, 0, 0], [0, 8, 1], [3, 2, 7], [5, 6, 0.5]], float)
    there = model[:, [1, 0, 2]] * [-1.0, 1.0, 1.0] + [700.0, 800.0, 90.0]
    model += [364534.0, 4721858.0, 852.0]
    rows = [
        ",".join(map(str, (f"P{i}", *a, *b)))
        for i, (a, b) in enumerate(zip(model, there, strict=True))
    ]
    table = tmp_path / "pairs.csv"
    table.write_text("\n".join(["label,model_x,model_y,model_z,x,y,z", *rows]))
    ran = run(
        "project",
        folder,
        "register",
        table,
        "--model",
        "face",
        "--crs",
        "EPSG:32633",
        "--click-sigma",
        "0",
        "--json",
    )
    assert ran.code == 0, ran.err
    assert ran.json["turned_deg"] == pytest.approx(90.0)
    # A pole of dip d turns on a small circle about the vertical: 2 asin(sin d sin 45).
    sets = ran.json["sets_turned_deg"]
    assert sets
    assert all(0.0 <= turn <= 90.0 + 1e-9 for turn in sets.values())
    after = {r["id"]: r for r in run("project", folder, "fit", "--json").json["planes"]}
    # A plane along an axis has no regression along that axis.
    assert before.keys() - after.keys() == {"trace-along-x"}
    turned = 0
    for id_, row in after.items():
        was = before[id_]
        if row["model"] != "face" or row["undefined"]:
            continue
        turned += 1
        change = (row["dip_direction_deg"] - was["dip_direction_deg"]) % 360.0
        assert change == pytest.approx(270.0, abs=1e-6)
        assert row["dip_deg"] == pytest.approx(was["dip_deg"], abs=1e-6)
        # The points fit exactly: what is left is the rounding of whole numbers on a small boulder.
        assert 0.0 < row["registration_error_deg"] < 3.0
    assert turned > 3
    run("project", folder, "undo")
    back = {r["id"]: r for r in run("project", folder, "fit", "--json").json["planes"]}
    assert back == before


def test_a_project_is_created_once(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "new.vom"
    made = run("project", folder, "create", "--json")
    assert (made.code, made.json["features"], made.json["sound"]) == (0, 0, True)
    again = run("project", folder, "create", "--json")
    assert (again.code, again.json["error"]["code"]) == (2, "project.exists")


def test_values_of_features_are_set_and_features_deleted(run: Run, project: Path) -> None:
    changed = run("project", project, "set", "t1", "--set", "east", "--name", "B01", "--json")
    assert changed.json["changed"] == [{"id": "t1", "name": "B01"}]
    (trace,) = traces(project)
    assert (trace.set_name, trace.name) == ("east", "B01")
    for words, code in (
        (("set", "t1"), "option.none-given"),
        (("set", "t1", "--type", "sand"), "option.not-a-choice"),
        (("set", "none", "--set", "east"), "record.missing"),
        (("delete", "none"), "record.missing"),
    ):
        ran = run("project", project, *words, "--json")
        assert (ran.code, ran.json["error"]["code"]) == (2, code)
    gone = run("project", project, "delete", "B01", "--json")
    assert gone.json["deleted"] == [{"id": "t1", "name": "B01"}]
    assert not traces(project)
    assert run("project", project, "undo").code == 0
    assert len(traces(project)) == 1


def test_a_report_is_written_while_a_window_has_the_project_open(
    run: Run, tmp_path: Path, project: Path
) -> None:
    out = tmp_path / "report.html"
    words = ("project", project, "report", "-o", out, "--json")
    opened = ProjectFolder.open(project)
    ran = run(*words)
    opened.close()
    assert ran.code == 0, ran.err
    found = {key: ran.json[key] for key in ("file", "planes", "lines", "skipped", "features")}
    assert found == {"file": str(out), "planes": 1, "lines": 0, "skipped": [], "features": 1}
    assert sum(ran.json["quality"].values()) == 1
    (row,) = run("project", project, "fit", "--json").json["planes"]
    assert f"<td>{row['name']}</td>" in out.read_text("utf-8")
    assert run(*words).json["error"]["code"] == "output.exists"
    assert run(*words, "--force").code == 0
    words = ("project", project, "report", "-o", project / "journal.sqlite", "--force", "--json")
    assert run(*words).code == 2
    assert run("project", project, "verify").code == 0


def test_report_lists_features_without_orientation_and_registrations(
    run: Run, tmp_path: Path
) -> None:
    folder, out = figures.copy_of("schema1", tmp_path), tmp_path / "report.html"
    ran = run("project", folder, "report", "-o", out, "--json")
    assert ran.code == 0, ran.err
    listed = run("project", folder, "fit", "--json").json
    assert (ran.json["planes"], ran.json["lines"]) == (len(listed["planes"]), len(listed["lines"]))
    assert ran.json["skipped"] == listed["skipped"]
    text = out.read_text("utf-8")
    records = read_replay(folder).records.values()
    assert all(html.escape(r.name) in text for r in records if isinstance(r, Feature))
    models = [r for r in records if isinstance(r, Model)]
    placed = [model.registration.name for model in models if model.registration is not None]
    assert placed
    assert all(html.escape(name) in text for name in (*placed, *(m.name for m in models)))


def test_project_register_matches_register_command(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "new.vom"
    model = tmp_path / "triangle.ply"
    points = [[0, 0, 0], [9, 0, 0], [0, 8, 1], [3, 2, 7]]
    rows = "\n".join(" ".join(map(str, row)) for row in points)
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n"
    model.write_text(head + f"property double z\nend_header\n{rows}\n")
    assert run("project", folder, "create").code == 0
    assert run("project", folder, "add-model", model, "--up", "z", "--unit", "m").code == 0
    lines = ("--bearing", "0,0,0,9,0,0,120,0.5", "--level", "0,0,0,9,0,0", "--plumb", "3,2,0,3,2,7")
    alone = run("register", model, *lines, "--keep-scale", "--json")
    ran = run("project", folder, "register", *lines, "--keep-scale", "--json")
    assert (alone.code, ran.code) == (0, 0), ran.err
    for key in ("matrix", "rotation_error_95_deg", "known"):
        assert ran.json[key] == alone.json[key]
    assert ran.json["turned_deg"] == pytest.approx(30.0)
    refused = run("project", folder, "register", "--json")
    assert (refused.code, refused.json["error"]["code"]) == (2, "registration.no-observations")
