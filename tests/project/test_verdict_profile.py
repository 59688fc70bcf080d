"""A project's profile is one record: choosing it judges everything anew, in one undoable step."""

from __future__ import annotations

import csv
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import DocumentError
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, TEXTBOOK_THRESHOLDS, Thresholds
from vomstudio.project import edits
from vomstudio.project.codec import decode_edit, encode_edit
from vomstudio.project.exports.export import export_records
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements, depends_on
from vomstudio.project.records import DEFAULT_TYPES, PROFILE_ID, Model, Record

OWN = replace(TEXTBOOK_THRESHOLDS, profile="strict", least_coplanarity=1e6)


@pytest.fixture
def records() -> dict[str, Record]:
    random = np.random.default_rng(0)
    xyz = random.uniform(-2.0, 2.0, (40, 3)) * [1.0, 0.8, 0.0] + random.normal(0, 0.01, (40, 3))
    model = Model("m", "cliff", "cliff.obj", "0", "mesh")
    trace = Trace("t", "B01", "bedding", "m", "0", tuple(map(tuple, xyz.tolist())), 0.01)
    return {each.id: each for each in (*DEFAULT_TYPES, model, trace)}


def test_profile_changes_the_verdict_but_not_the_measurements(records: dict[str, Record]) -> None:
    measurements = Measurements()
    before = measurements.of(records, ["t"])["t"]
    judged = {**records, **edits.judge_by(records, OWN).after}
    after = measurements.of(judged, ["t"])["t"]
    assert before.verdict is not None
    assert after.verdict is not None
    assert (before.verdict.quality, before.verdict.profile) == ("good", "error")
    assert (after.verdict.quality, after.verdict.profile) == ("doubtful", "strict")
    assert before.fit is not None
    assert after.fit is not None
    assert np.array_equal(before.fit.normal, after.fit.normal)
    assert measurements.of(records, ["t"])["t"].verdict == before.verdict


def test_every_feature_depends_on_the_profile(records: dict[str, Record]) -> None:
    trace = records["t"]
    assert isinstance(trace, Trace)
    assert depends_on(records, trace, {PROFILE_ID})


@pytest.mark.parametrize(
    ("limits", "code", "field"),
    [
        (replace(DEFAULT_THRESHOLDS, good_M=5.0), "profile.fixed", "profile"),
        (replace(OWN, profile="  "), "name.empty", "profile"),
        (
            replace(OWN, least_coplanarity=0.0),
            "profile.limit-not-positive",
            "least_coplanarity",
        ),
        (
            replace(OWN, most_collinearity=float("nan")),
            "profile.limit-not-positive",
            "most_collinearity",
        ),
        (
            replace(OWN, good_confidence95_deg=20.0),
            "profile.limits-crossed",
            "good_confidence95_deg",
        ),
    ],
)
def test_invalid_limits_are_rejected(
    records: dict[str, Record], limits: object, code: str, field: str
) -> None:
    with refused(code, DocumentError, field=field):
        edits.judge_by(records, limits)  # type: ignore[arg-type]


def test_selecting_the_current_profile_is_rejected_as_no_change(records: dict[str, Record]) -> None:
    judged = {**records, **edits.judge_by(records, OWN).after}
    with refused("edit.no-change", DocumentError):
        edits.judge_by(judged, OWN)  # type: ignore[arg-type]


def test_profile_edit_survives_encoding(records: dict[str, Record]) -> None:
    first = edits.judge_by(records, OWN)
    again = decode_edit(first.label, *encode_edit(first), records)
    assert again.after == first.after
    judged = {**records, PROFILE_ID: first.after[PROFILE_ID]}
    second = edits.judge_by(judged, TEXTBOOK_THRESHOLDS)  # type: ignore[arg-type]
    assert decode_edit(second.label, *encode_edit(second), judged).after == second.after  # type: ignore[arg-type]


def test_damaged_profile_is_rejected(records: dict[str, Record]) -> None:
    edit = edits.judge_by(records, OWN)
    before, after = encode_edit(edit)
    after[PROFILE_ID]["limits"]["good_M"] = "four"
    with refused("record.wrong-value", DocumentError):
        decode_edit(edit.label, before, after, records)


def test_profile_is_saved_with_the_project_and_can_be_undone(tmp_path: Path) -> None:
    with closing(ProjectFolder.create(tmp_path / "cliff.vom")) as project:
        edit = edits.judge_by(project.session.records, OWN)
        project.session.apply(edit)
        project.session.save()
    with closing(ProjectFolder.open(tmp_path / "cliff.vom")) as project:
        assert project.session.records[PROFILE_ID].limits == OWN  # type: ignore[union-attr]
        assert project.session.undo_label == edit.label
        project.session.undo()
        assert PROFILE_ID not in project.session.records


@pytest.mark.parametrize(
    "profile", [DEFAULT_THRESHOLDS, TEXTBOOK_THRESHOLDS, OWN], ids=lambda each: each.profile
)
def test_exported_verdicts_state_the_profile_and_its_limits(
    records: dict[str, Record], tmp_path: Path, profile: Thresholds
) -> None:
    judged = records
    if profile is not DEFAULT_THRESHOLDS:
        judged = {**records, **edits.judge_by(records, profile).after}
    table, layers = tmp_path / "t.csv", tmp_path / "t.gpkg"
    export_records(judged, "csv", table)
    export_records(judged, "gpkg", layers)
    lines = table.read_text(encoding="utf-8").splitlines()
    assert f"# profile: {profile.description}" in lines
    (row,) = csv.DictReader(line for line in lines if not line.startswith("#"))
    assert row["profile"] == profile.profile
    with closing(sqlite3.connect(layers)) as file:
        described = file.execute("SELECT table_name, description FROM gpkg_contents").fetchall()
    said = {name: text for name, text in described if name != "layer_styles"}
    assert {"planes", "traces"} <= said.keys()
    assert set(said.values()) == {profile.description}
