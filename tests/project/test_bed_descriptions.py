"""What is said of beds along a line: kept with it, told apart, and moved with its points."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from tests.messages import refused
from tests.project.test_edits import MODEL, TRACE
from vomstudio.core.errors import DocumentError
from vomstudio.project import edits
from vomstudio.project.bed_descriptions import bed_lines, describe_bed
from vomstudio.project.codec import decode_edit, encode_edit
from vomstudio.project.edit import Edit
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.dimension import Dimension

POINTS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.5), (2.0, 0.0, 1.5), (3.0, 0.5, 2.0))
LINE = Dimension("line", "section A", "polyline", MODEL.id, MODEL.content_hash, POINTS)
CONTACT = Contact("c1", "C1", TRACE.type_id, MODEL.id, MODEL.content_hash, POINTS)
RECORDS = {MODEL.id: MODEL, "line": LINE, TRACE.id: TRACE}


def after(records: dict, edit: Edit) -> dict:
    return {**records, **{k: v for k, v in edit.after.items() if v is not None}}


def described() -> dict:
    records = after(RECORDS, describe_bed(RECORDS, "line", "#2", "limestone", ""))
    records = after(records, describe_bed(records, "line", TRACE.id, "", "cross-bedded"))
    return after(records, describe_bed(records, "line", "#0", "sandstone", "red"))


def test_bed_has_one_description_and_none_after_it_is_emptied() -> None:
    records = described()
    assert set(records["line"].beds) == {
        ("#0", "sandstone", "red"),
        ("#2", "limestone", ""),
        (TRACE.id, "", "cross-bedded"),
    }
    records = after(records, describe_bed(records, "line", "#0", "chert", ""))
    assert [bed for bed in records["line"].beds if bed[0] == "#0"] == [("#0", "chert", "")]
    with refused("edit.no-change", DocumentError):
        describe_bed(records, "line", "#0", "chert", "")
    for key in ("#0", "#2", TRACE.id):
        records = after(records, describe_bed(records, "line", key, "", ""))
    assert records["line"] == LINE
    for id_ in ("gone", MODEL.id):
        with refused("bed.no-line", DocumentError):
            describe_bed(records, id_, "#0", "chert", "")


@pytest.mark.parametrize("line", [LINE, TRACE, CONTACT], ids=lambda r: r.name)
def test_journal_keeps_the_description_of_every_bed_of_a_log(line, tmp_path) -> None:
    folder = tmp_path / "p.vom"
    project = ProjectFolder.create(folder)
    session = project.session
    kept = replace(line, id="line")
    session.apply(edits.add_model(session.records, MODEL))
    session.apply(edits.add_features(session.records, [kept]))
    session.apply(describe_bed(session.records, "line", "#1", "=sand", "“wavy”\nand red"))
    session.save()
    project.close()
    project = ProjectFolder.open(folder)
    try:
        assert not project.session.problems
        assert project.session.records["line"].beds == (("#1", "=sand", "“wavy”\nand red"),)
        project.session.undo()
        assert project.session.records["line"].beds == ()
    finally:
        project.close()


@pytest.mark.parametrize(
    "beds", [[["#1", "a"]], [["#1", "a", 3]], "x", [["#1", "a", None]], None, [{"a": "b"}]]
)
def test_invalid_descriptions_are_reported_when_read(beds) -> None:
    edit = describe_bed(RECORDS, "line", "#1", "chert", "")
    before, plain = (json.loads(json.dumps(each)) for each in encode_edit(edit))
    plain["line"]["beds"] = beds
    with pytest.raises(DocumentError) as caught:
        decode_edit(edit.label, before, plain, RECORDS)
    assert caught.value.field == "beds"


def test_descriptions_stay_with_their_points() -> None:
    records = described()

    def moved(vertices) -> set:
        edit = edits.set_line(records, "line", vertices)
        return set(edit.after["line"].beds)

    same = {("#0", "sandstone", "red"), ("#2", "limestone", ""), (TRACE.id, "", "cross-bedded")}
    # A point that is moved is the same boundary.
    assert moved((*POINTS[:2], (2.0, 1.0, 1.0), POINTS[3])) == same
    assert moved((*POINTS, (4.0, 0.0, 3.0))) == same
    assert moved(((-1.0, 0.0, 0.0), *POINTS)) == {
        ("#1", "sandstone", "red"),
        ("#3", "limestone", ""),
        (TRACE.id, "", "cross-bedded"),
    }
    assert moved(POINTS[1:]) == {("#1", "limestone", ""), (TRACE.id, "", "cross-bedded")}


def test_trace_keeps_its_description_while_it_is_extended() -> None:
    records = after(RECORDS, describe_bed(RECORDS, TRACE.id, "#1", "chert", ""))
    edit = edits.set_vertices(
        records,
        TRACE.id,
        (TRACE.vertices[1], *TRACE.vertices[1:]),
        resolution=None,
        outcrop_normal=None,
    )
    assert edit.after[TRACE.id].beds == (("#1", "chert", ""),)


def test_exports_state_the_boundary_of_each_description() -> None:
    records = described()
    line = records["line"]
    beds = {what: place for place, what in (s.split(": ") for s in bed_lines(line, records))}
    assert beds["sandstone, red"].endswith(" 1")
    assert beds["cross-bedded"].endswith(f" {TRACE.name}")
    # A trace that was deleted bounds nothing; what was said comes back with it.
    del records[TRACE.id]
    assert len(bed_lines(line, records)) == 2
    assert bed_lines(MODEL, records) == []
