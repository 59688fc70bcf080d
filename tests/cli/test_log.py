"""`vomstudio log` and `vomstudio threepoint`, and the same in Python."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs
from tests.messages import codes, error_of, messages, refused

LOG = (
    "name,x,y,z,lithology,notes\na,0,0,0,sandstone,=1+1\nb,10,0,0,limestone,\nc,20,0,0,,\nd,,,,,\n"
)
BENNISON = "393 2374 550\n1891 2738 650\n2191 1037 450\n"
"""Bennison (1990), coal seam in three boreholes: strike 106.45, dip 7.37, as Cardozo solves it in
Computational structural geology, notebook 4."""


def test_log_is_reported_and_written(run, write, tmp_path: Path) -> None:
    target = tmp_path / "log.csv"
    words = ["--bed", "90/30", "--bed-error", "2", "--sigma", "0.01", "-o", target]
    ran = run("log", write(LOG), *words, "--json")
    assert ran.code == 0
    assert ran.json["n"] == 3
    assert ran.json["dropped_lines"] == [5]
    first, second = ran.json["intervals"]
    assert first["thickness_m"]["value"] == pytest.approx(5.0)
    assert first["strabospot"]["siliciclastic_type"] == "sandstone"
    assert second["strabospot"]["primary_lithology"] == "limestone"
    assert ran.json["total_m"]["value"] == pytest.approx(10.0)
    rows = [r for r in csv.reader(target.read_text("utf-8").splitlines()) if r[0][0] != "#"]
    assert rows[0][:6] == ["number", "base", "top", "base_m", "top_m", "thickness_m"]
    assert rows[1][:6] == ["1", "a", "b", "0.0000", "5.0000", "5.0000"]
    assert rows[1][-1] == "'=1+1"
    text = run("log", write(LOG), *words, "--force")
    assert "sandstone" in text.out
    assert run("log", write(LOG), *words).code == 2
    for wrong in (["--bed", "90"], ["--bed", "90/95"], ["--bed", "9/9", "--sigma", "-1"]):
        assert run("log", write(LOG), *wrong).code == 2
    assert run("log", write("1 2 3\n"), "--bed", "9/9").code == 2


def test_bennison_three_point_problem_has_published_attitude(run, write) -> None:
    ran = run("threepoint", write(BENNISON), "--sigma", "5", "--json")
    assert ran.code == 0
    assert ran.json["strike_rhr_deg"] == pytest.approx(106.45, abs=0.005)
    assert ran.json["dip_deg"] == pytest.approx(7.37, abs=0.005)
    assert 0 < ran.json["dip_error_deg"] < 1
    assert ran.json["max_confidence95_deg"] > ran.json["dip_error_deg"]
    assert "196.4/07.4 ± " in run("threepoint", write(BENNISON), "--sigma", "5").out
    exact = run("threepoint", write(BENNISON), "--json").json
    assert (exact["dip_error_deg"], exact["max_confidence95_deg"]) == (None, None)
    said = run("threepoint", write(BENNISON)).out
    assert "196/07" in said
    assert "±" not in said
    for wrong in ("0 0 0\n1 1 1\n2 2 2\n", "0 0 0\n1 1 1\n", "0 0 0\n1 1 1\n2 2 2\n3 3 3\n"):
        assert run("threepoint", write(wrong)).code == 2
    assert run("threepoint", write(BENNISON), "--sigma", "-1").code == 2


def test_more_than_three_points_give_error_estimate(run, write) -> None:
    """A fourth borehole two metres above the seam of the others."""
    fourth = "1000 1500 %s\n"
    exact = run("threepoint", write(BENNISON), "--json").json
    assert (exact["n"], exact["rms_m"], exact["max_confidence95_deg"]) == (3, None, None)
    found = run("threepoint", write(BENNISON + fourth % 480.0), "--json").json
    assert found["n"] == 4
    assert found["rms_m"] > 0
    assert found["sigma_m"] == pytest.approx(2.0 * found["rms_m"])
    stated = run("threepoint", write(BENNISON + fourth % 480.0), "--sigma", "5", "--json").json
    assert stated["sigma_m"] == 5.0
    assert stated["dip_deg"] == found["dip_deg"]


@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_python_functions_match_command_output(write) -> None:
    points = np.array([[float(w) for w in line.split()] for line in BENNISON.splitlines()])
    seam = vs.threepoint(points, sigma_m=5.0)
    assert seam.dip_deg == pytest.approx(7.37, abs=0.005)
    of_file = vs.threepoint(write(BENNISON), sigma_m=5.0).to_dict()
    assert codes({"warnings": of_file.pop("warnings")}) == ["frame.assumed"]
    assert {name: value for name, value in seam.to_dict().items() if name != "warnings"} == of_file
    assert "dip_direction_deg" in repr(seam)
    found = vs.log(write(LOG), bed=(90, 30))
    assert [i.lithology for i in found.intervals] == ["sandstone", "limestone"]
    moved = vs.displacement([[5.0, 0.0, -8.660254, 0.0, 0.0, 0.0]], fault=(90, 60), sigma_m=0.1)
    assert moved.what == "net slip"
    assert moved.mean_throw_m == pytest.approx(8.66, abs=0.01)
    cut = vs.displacement(
        [[5.0, 0.0, -8.660254, 0.0, 0.0, 0.0]], fault=(90, 60), bed=(0, 0), slip=(90, 60)
    )
    assert cut.mean_net_m == pytest.approx(10.0, abs=0.01)
    with pytest.raises(vs.errors.UsageError):
        vs.displacement([[0] * 6], fault=(90, 60), bed=(0, 0), rake_deg=90, slip=(90, 60))
    with refused("array.shape", shape=(3, 2), expected="(n, 3)"):
        vs.threepoint([[0, 0], [1, 1], [2, 2]])


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Traces of four beds, dipping 30 to the East, on a stair, and a line up the stair on which
    two beds are described; beside them a line of one point and a namesake."""
    from vomstudio.geometry.frames import Frame
    from vomstudio.project import edits
    from vomstudio.project.bed_descriptions import describe_bed
    from vomstudio.project.folder import ProjectFolder
    from vomstudio.project.kinds.dimension import Dimension
    from vomstudio.project.kinds.trace import Trace
    from vomstudio.project.records import Model

    made = ProjectFolder.create(tmp_path / "p.vom")
    session = made.session
    model = Model("m", "stair", "stair.obj", "mesh", "0" * 64, Frame("local"))
    session.apply(edits.add_model(session.records, model))
    along = np.array([0.0, 1.0, 0.0])
    down = np.array([np.cos(np.radians(30)), 0.0, -np.sin(np.radians(30))])
    normal = np.array([np.sin(np.radians(30)), 0.0, np.cos(np.radians(30))])
    features, places = [], []
    for k, height in enumerate((0.0, 1.0, 3.0, 3.5)):
        places.append(tuple(map(float, height * normal)))
        corners = [a * along + b * down for a, b in ((-2, -0.5), (-1, 0.4), (0, 0), (1, -0.4))]
        points = [tuple(map(float, height * normal + c)) for c in (*corners, 2 * along)]
        features.append(Trace(f"t{k}", f"B{k}", "bedding", "m", "0" * 64, tuple(points)))
    section = Dimension("s", "section A", "polyline", "m", "0" * 64, tuple(places))
    twins = [replace(section, id=f"twin{k}", name="twin") for k in (1, 2)]
    session.apply(edits.add_features(session.records, [*features, section, *twins]))
    session.apply(describe_bed(session.records, "s", "t1", "sandstone", "red"))
    session.apply(describe_bed(session.records, "s", "#0", "chert", ""))
    session.save()
    made.close()
    return tmp_path / "p.vom"


def test_project_log_contains_typed_descriptions(run, project: Path, tmp_path: Path) -> None:
    """Thicknesses are those that the beds were made with."""
    target = tmp_path / "l.csv"
    ran = run(
        "log", project, "--line", "section A", "-o", target, "--plot", tmp_path / "l.pdf", "--json"
    )
    assert ran.code == 0, ran.err
    found = ran.json
    assert [i["thickness_m"]["value"] for i in found["intervals"]] == pytest.approx([1, 2, 0.5])
    assert [i["lithology"] for i in found["intervals"]] == ["", "sandstone", ""]
    assert found["intervals"][1]["notes"] == "red"
    assert (found["bed"]["dip_direction_deg"], found["bed"]["dip_deg"]) == pytest.approx((90, 30))
    assert "sandstone" in target.read_text("utf-8")
    # Its own points are other boundaries, with words of their own.
    found = run("log", project, "--line", "s", "--of", "points", "--json").json
    assert [i["base"] for i in found["intervals"]] == ["1", "2", "3"]
    assert [i["lithology"] for i in found["intervals"]] == ["chert", "", ""]
    found = run("log", project, "--line", "s", "--bed", "90/30", "--bed-error", 3, "--json").json
    assert found["bed"]["error95_deg"] == 3
    for words, code, field, values in (
        ((), "log.line-not-given", "--line", {}),
        (
            ("--line", "section B"),
            "log.no-line",
            "--line",
            {"name": "section B", "names": ["section A"]},
        ),
        (("--line", "twin"), "log.ambiguous-line", "--line", {"name": "twin"}),
        (("--line", "s", "--type", "vein7"), "log.no-type", "--type", {"name": "vein7"}),
        (("--line", "s", "--reach", "-1"), "option.out-of-range", "--reach", {"value": -1}),
        (("--line", "s", "--bed-error", "2"), "option.requires", "--bed-error", {"other": "--bed"}),
        (("--line", "s", "--type", "fault"), "log.too-few-boundaries", None, {}),
    ):
        ran = run("log", project, *words, "--json")
        assert ran.code == 2
        error_of(ran.json, code, field=field, **values)
    table = tmp_path / "t.csv"
    table.write_text(LOG)
    ran = run("log", table, "--bed", "9/9", "--reach", "1", "--json")
    error_of(ran.json, "option.requires", option="--reach", other="--line")
    for words, field in (((), "--bed"), (("--bed", "9/9", "--line", "s"), "--line")):
        ran = run("log", table, *words, "--json")
        assert (ran.code, ran.json["error"]["field"]) == (2, field)


def test_bedding_comes_from_traces_near_the_line(run, project: Path) -> None:
    """The other limb, which dips to the West 50 m away, counts only if it is asked for."""
    from vomstudio.project import edits
    from vomstudio.project.folder import ProjectFolder
    from vomstudio.project.kinds.trace import Trace

    made = ProjectFolder.open(project)
    session = made.session
    other = []
    for k in range(4):
        first = next(t for t in session.of(Trace) if t.id == f"t{k}")
        turned = [(50.0 - z * 1.7, y, 2.0 * x) for x, y, z in first.vertices]
        other.append(replace(first, id=f"o{k}", name=f"O{k}", vertices=tuple(turned)))
    session.apply(edits.add_features(session.records, other))
    session.save()
    made.close()
    found = run("log", project, "--line", "s", "--of", "points", "--reach", "0.5", "--json").json
    assert found["bed"]["traces"] == ["B0", "B1", "B2", "B3"]
    assert found["bed"]["dip_deg"] == pytest.approx(30.0)
    assert "log.beds-not-parallel" not in codes(found)
    both = run("log", project, "--line", "s", "--of", "points", "--reach", "90", "--json").json
    assert len(both["bed"]["traces"]) == 8
    assert "log.beds-not-parallel" in codes(both)


def test_project_exports_contain_typed_notes(run, project: Path, tmp_path: Path) -> None:
    import pyogrio

    assert run("export", project, "--to", "gpkg", "-o", tmp_path / "l.gpkg").code == 0
    _, _, _, columns = pyogrio.raw.read(tmp_path / "l.gpkg", layer="dimensions")
    notes = [text for column in columns for text in column if isinstance(text, str)]
    assert any("B1: sandstone, red" in text for text in notes)


@pytest.mark.parametrize("empty", ["1,nan,1", "1,,1", "inf,2,2"])
def test_rows_without_coordinates_are_reported(run, write, empty: str) -> None:
    rows = ["x,y,z,name", "0,0,0,a", f"{empty},b", "3,4,5,c", "9,2,2,d"]
    for words in (("threepoint",), ("log", "--bed", "90/20")):
        table = write("\n".join(rows))
        ran = run(words[0], table, *words[1:], "--json")
        assert ran.json["dropped_lines"] == [3]
        assert any("line 3" in said for said in messages(ran.json))
        assert "line 3" in run(words[0], table, *words[1:]).err


def test_line_along_rough_face_does_not_increase_boundary_errors(run, tmp_path) -> None:  # type: ignore[no-untyped-def]
    """Beds whose traces stray by 1 cm, and a line that follows the steps of the face between them:
    the thickness is known by the traces. An overturned bed is told."""
    from vomstudio.geometry.frames import Frame
    from vomstudio.project import edits
    from vomstudio.project.folder import ProjectFolder
    from vomstudio.project.kinds.trace import Trace
    from vomstudio.project.records import Model

    generator = np.random.default_rng(5)
    made = ProjectFolder.create(tmp_path / "p.vom")
    session = made.session
    model = Model("m", "face", "face.obj", "mesh", "0" * 64, Frame("local"))
    session.apply(edits.add_model(session.records, model))
    features = []
    for k in range(3):
        east = np.linspace(-4, 4, 40)
        points = np.stack([east, 0.6 * np.sin(2 * east), np.full(40, 2.0 * k)], 1)
        points += generator.normal(0, 0.01, points.shape)
        rows = tuple(tuple(map(float, p)) for p in points)
        features.append(Trace(f"t{k}", f"B{k}", "bedding", "m", "0" * 64, rows, overturned=k > 0))
    path = ((0.0, 0.0, -0.5), (0.3, 0.5, 0.5), (-0.4, -0.6, 1.5), (0.2, 0.4, 2.5), (0.0, 0.0, 4.5))
    line = Trace("s", "log", "joint", "m", "0" * 64, path)
    session.apply(edits.add_features(session.records, [*features, line]))
    session.save()
    made.close()
    ran = run("log", tmp_path / "p.vom", "--line", "log", "--reach", 1, "--json")
    assert ran.code == 0, ran.err
    assert 0.008 < ran.json["sigma_m"] < 0.012
    for interval in ran.json["intervals"]:
        assert abs(interval["thickness_m"]["value"] - 2.0) < interval["thickness_m"]["error95"]
        assert interval["thickness_m"]["error95"] < 0.06
    assert ran.json["warnings"][0]["code"] == "log.overturned-beds"
    assert ran.json["warnings"][0]["count"] == 2
    turned = run("log", tmp_path / "p.vom", "--line", "log", "--reach", 1, "--overturned", "--json")
    assert not messages(turned.json)
