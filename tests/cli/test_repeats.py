"""`vomstudio repeats` and `vs.repeats`, and that repeats are no further structures."""

from __future__ import annotations

import json
from contextlib import closing
from xml.etree import ElementTree

import numpy as np
import pandas
import pytest

import vomstudio as vs
from tests.messages import codes, shown_codes, shown_values, warned
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits, repeated_features
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model

HEAD = "id,dip_direction_deg,dip_deg,max_confidence95_deg,repeat_of,interpreter\n"
TABLE = (
    HEAD
    + "a,90,40,3,,AB\nb,100,50,3,,AB\nc,120,60,2,,AB\n"
    + "d,90,43,3,a,AB\ne,100,52,3,b,CD\nf,99,53,3,zz,CD\ng,90,44,3,d,CD\n"
)


def test_angles_of_pairs_and_missing_first_picks_are_reported(run, write) -> None:
    found = run("repeats", write(TABLE), "--json").json
    assert (found["n"], found["structures"], found["repeats"]) == (3, 2, 3)
    angles = {(p["first"], p["repeat"]): p["angle_deg"] for p in found["pairs"]}
    # Of planes with one dip direction the difference of the dips; a repeat of a repeat is one more.
    assert angles == pytest.approx({("a", "d"): 3.0, ("a", "g"): 4.0, ("b", "e"): 2.0})
    assert [p["by"] for p in found["pairs"]] == [["AB", "AB"], ["AB", "CD"], ["AB", "CD"]]
    assert found["pairs"][0]["stated95_deg"] == pytest.approx(18**0.5)
    assert found["stated95_deg"] == pytest.approx(3.0)
    assert [one["id"] for one in found["left_out"]] == ["f"]
    assert [(own["name"], own["spread"]["n"]) for own in found["interpreters"]] == [("AB", 1)]
    assert found["test"]["n"] == 3
    assert found["stated_errors_hold"] == "undetermined"
    words = run("repeats", write(TABLE))
    assert shown_values(words.out, "repeats.too-few")["count"] == "3"
    assert shown_values(words.out, "feature.left-out")["feature"].split()[-1] == "f"


def test_registration_errors_are_excluded_from_repeat_errors(run, write) -> None:
    errors = "max_confidence95_deg,registration_error_deg,total95_deg"
    head = f"id,dip_direction,dip,{errors},repeat_of\n"
    rows = "a,90,40,3,4,5,\nb,90,41,3,4,5,a\n"
    assert run("repeats", write(head + rows), "--json").json["stated95_deg"] == pytest.approx(3.0)


def test_structures_can_be_identified_by_column(run, write) -> None:
    path = write("trend,plunge,station,who\n10,20,A,x\n10,24,A,y\n50,60,B,x\n70,10,,x\n80,10,,x\n")
    found = run("repeats", path, "--by", "station", "--interpreter", "who", "--json").json
    assert (found["n"], found["repeats"]) == (4, 1)
    assert found["spread"]["sigma_deg"] == pytest.approx(2.0)
    assert found["test"] is None
    assert found["stated95_deg"] is None
    frame = pandas.read_csv(path)
    assert vs.repeats(frame, by="station", interpreter="who").to_dict()["pairs"] == [
        {
            "first": "1",
            "repeat": "2",
            "by": ["x", "y"],
            "angle_deg": pytest.approx(4.0),
            "stated95_deg": None,
            "within95": None,
        },
    ]


def test_table_without_repeats_is_reported(run, write) -> None:
    found = run("repeats", write(HEAD + "a,90,40,3,,AB\n"), "--json").json
    assert (found["spread"], found["pairs"]) == (None, [])
    assert [each["code"] for each in found["reasons"]] == ["repeats.none"]
    ran = run("repeats", write("dip_direction,dip\n90,40\n"), "--json")
    assert (ran.code, ran.json["error"]["field"]) == (2, "--by")
    ran = run("repeats", write("dip_direction,dip\n90,40\n"), "--by", "bed", "--json")
    assert (ran.code, ran.json["error"]["field"]) == (2, "bed")


def test_circular_and_mixed_type_repeats_are_left_out(run, write) -> None:
    ring = write(HEAD + "a,90,40,3,b,\nb,90,40,3,a,\nc,10,10,3,,\n")
    found = run("repeats", ring, "--json").json
    assert [one["id"] for one in found["left_out"]] == ["a", "b"]
    mixed = "id,dip_direction,dip,trend,plunge,repeat_of\np,90,40,,,\nl,,,90,40,p\n"
    found = run("repeats", write(mixed), "--json").json
    assert (found["repeats"], found["left_out"][0]["id"]) == (0, "l")


@pytest.mark.parametrize(
    "words",
    [
        "stats {table}",
        "fold {table}",
        "rose {table} -o {folder}/rose.svg --force",
        "stereonet {table} -o {folder}/net.svg --force",
        "slope {table} --face 100/70 --friction 30",
        "sets {table} -o {folder}/sets.csv --force",
    ],
)
def test_repeats_are_excluded_from_other_commands(run, write, tmp_path, words: str) -> None:
    """The answer is that of the table without them, and it is said that they were left out."""
    firsts = "".join(line for line in TABLE.splitlines(True) if line[0] not in "defg")
    firsts = HEAD + firsts.split("\n", 1)[1]
    said = words.format(table="{table}", folder=tmp_path)
    answers = []
    for text in (TABLE, firsts):
        ran = run(*said.format(table=write(text)).split(), "--json")
        assert ran.code == 0, ran.err
        answers.append((ran.json, ran.err))
    (found, err), (wanted, _) = answers
    left_out = [w for w in found["warnings"] if w["code"] == "table.repeats-left-out"]
    found.pop("warnings")
    assert len(left_out) == 1
    assert "vomstudio repeats" in err
    wanted.pop("warnings")
    assert found == wanted


def test_slip_and_data_frames_exclude_repeats(run, write) -> None:
    head = "strike,dip,trend,plunge,sense,repeat_of,id\n"
    path = write(head + "0,45,90,45,N,,p\n180,45,270,45,N,,q\n180,46,270,46,N,q,r\n")
    assert run("slip", path, "--json").json["n"] == 2
    frame = vs.read_orientations(write(TABLE))
    assert len(frame) == 7
    with warned("table.repeats-left-out", count=4):
        assert vs.stats(frame).n == 3


def test_table_with_only_repeats_is_refused(run, write) -> None:
    ran = run("stats", write(HEAD + "d,90,43,3,a,AB\n"), "--json")
    assert (ran.code, ran.json["error"]["field"]) == (2, "repeat_of")


def test_repeated_trace_is_excluded_from_fractures(run, write) -> None:
    def layer(*repeat_of: str | None) -> str:
        features = [
            {
                "type": "Feature",
                "properties": {"name": f"t{i}", "repeat_of": of},
                "geometry": {"type": "LineString", "coordinates": [[0, i], [4, i]]},
            }
            for i, of in enumerate(repeat_of)
        ]
        crs = {"type": "name", "properties": {"name": "EPSG:32633"}}
        return json.dumps({"type": "FeatureCollection", "crs": crs, "features": features})

    area = write(
        json.dumps(
            {
                "type": "FeatureCollection",
                "crs": {"type": "name", "properties": {"name": "EPSG:32633"}},
                "features": [
                    {
                        "type": "Feature",
                        "properties": {},
                        "geometry": {
                            "type": "Polygon",
                            "coordinates": [[[0, -1], [4, -1], [4, 4], [0, 4], [0, -1]]],
                        },
                    }
                ],
            }
        ),
        "area.geojson",
    )
    traces = write(layer(None, "", "t0"), "traces.geojson")
    found = run("fractures", traces, "--area", area, "--json").json
    assert (found["traces"], found["P21_1_per_m"]) == (2, pytest.approx(8 / 20))
    assert "table.repeats-left-out" in codes(found)
    ran = run("fractures", write(layer("a", "b"), "again.geojson"), "--json")
    assert (ran.code, ran.json["error"]["field"]) == (2, "repeat_of")


@pytest.fixture
def project(tmp_path):
    """A bed picked by AB and again by CD, and one picked once."""
    folder = tmp_path / "beds.vom"
    model = Model("m", "face", "face.obj", "mesh", "0" * 64, Frame("local"))
    points = np.array([[0, 0, 0], [1, 0.9, 0.1], [2, -0.4, 0.6], [3, 0.7, 0.9], [4, -0.2, 1.5]])
    with closing(ProjectFolder.create(folder)) as made:
        session = made.session
        session.apply(edits.add_model(session.records, model))
        for i, id_ in enumerate(("b1", "b2", "b3")):
            own = points + [0, 0, 0.02 * i] * np.arange(5)[:, None]
            vertices = tuple(map(tuple, own.tolist()))
            one = Trace(id_, id_.upper(), "bedding", "m", "0" * 64, vertices, interpreter="AB")
            session.apply(edits.add_trace(session.records, one))
        session.apply(repeated_features.link_repeat(session.records, "b3", "b1", "CD"))
        session.save()
    return folder


def test_project_and_its_table_give_equal_repeats(run, project, tmp_path) -> None:
    found = run("repeats", project, "--json").json
    assert (found["n"], found["structures"]) == (2, 1)
    assert (found["pairs"][0]["first"], found["pairs"][0]["by"]) == ("b1", ["AB", "CD"])
    table = tmp_path / "t.csv"
    assert run("export", project, "--to", "csv", "-o", table).code == 0
    from_table = run("repeats", table, "--json").json
    (one,), (other,) = from_table["pairs"], found["pairs"]
    assert one["angle_deg"] == pytest.approx(other["angle_deg"], rel=1e-9)
    assert one["stated95_deg"] == pytest.approx(other["stated95_deg"], rel=1e-9)
    assert {**one, **other} == other
    assert vs.repeats(project).to_dict()["pairs"][0]["angle_deg"] == pytest.approx(
        found["pairs"][0]["angle_deg"]
    )
    assert run("stats", table, "--json").json["n"] == 2
    with vs.Project.open(project) as opened:
        planes = opened.planes()
    assert planes["repeat_of"].tolist() == [None, None, "b1"]
    with warned("table.repeats-left-out", count=1):
        assert vs.stats(planes).n == 2


@pytest.mark.parametrize("format_", ["geojson", "stereonet", "orient", "gempy", "dxf"])
def test_exports_for_other_programs_exclude_repeats(run, project, tmp_path, format_: str) -> None:
    out = tmp_path / f"out.{format_}"
    ran = run("export", project, "--to", format_, "-o", out, "--json")
    assert ran.code == 0, ran.err
    texts = "".join(p.read_text("utf-8", "replace") for p in tmp_path.glob("out*") if p.is_file())
    assert format_ == "gempy" or "B1" in texts
    assert "again" not in texts
    (left_out,) = [each["reason"] for each in ran.json["skipped"]]
    assert Finding.from_dict(left_out) == Finding("repeats.not-exported", first="B1")


@pytest.mark.full
def test_figures_state_number_of_excluded_repeats(run, write, tmp_path) -> None:
    table = write(TABLE)
    (tmp_path / "one.csv").write_text(HEAD + "a,90,40,3,,AB\nd,90,43,3,a,AB\n")
    (tmp_path / "none.csv").write_text(HEAD + "a,90,40,3,,AB\nb,90,43,3,,AB\n")
    for words in (("stereonet",), ("rose", "--of", "strike")):
        for source, count in ((table, 4), (tmp_path / "one.csv", 1), (tmp_path / "none.csv", 0)):
            figure = tmp_path / "figure.svg"
            assert run(words[0], source, *words[1:], "-o", figure, "--force").code == 0
            texts = ElementTree.fromstring(figure.read_text("utf-8")).itertext()
            drawn = " ".join(" ".join(texts).split()) + " "
            assert ("table.repeats-left-out" in shown_codes(drawn)) == bool(count)
            if count:
                left_out = shown_values(drawn, "table.repeats-left-out")
                assert left_out["count"].split()[-1] == str(count)
