"""Grids of cells and repeats of features as records: edits, journal, what counts as a structure."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import pytest

from tests.messages import refused
from vomstudio.core.errors import DocumentError
from vomstudio.geology.coverage.face_coverage import MARK_TITLES
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits, grid_edits, repeated_features
from vomstudio.project.codec import decode, encode
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import DEFAULT_TYPES, FaceGrid, Model

MODEL = Model("m", "face", "face.obj", "mesh", "0" * 64, Frame("local"))
GRID = FaceGrid(
    "g", "", "m", "0" * 64, (0.0, 0.0, 5.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5, 3, 2
)
POINTS = ((0.0, 0.0, 0.0), (1.0, 0.2, 0.5), (2.0, -0.3, 0.1), (3.0, 0.4, 0.9))


def records(*more) -> dict:
    return {r.id: r for r in (*DEFAULT_TYPES, MODEL, *more)}


def trace(id_: str, **values) -> Trace:
    return Trace(id_, id_.upper(), "bedding", "m", "0" * 64, POINTS, **values)


def test_every_mark_has_a_title_in_the_window() -> None:
    assert set(grid_edits.MARKS) == set(MARK_TITLES)


def test_grid_is_added_marked_and_removed() -> None:
    now = records()
    for edit in (
        lambda: grid_edits.add_grid(now, GRID),
        lambda: grid_edits.mark_cells(now, "g", [0, 5], "d"),
        lambda: grid_edits.mark_cells(now, "g", [5], "u"),
    ):
        edit().swap(now)
    grid = now["g"]
    assert grid.marks == "d----u"
    assert decode(encode(grid)) == grid
    last = grid_edits.mark_cells(now, "g", [1], "e")
    last.swap(now)
    last.inverse().swap(now)
    assert now["g"] == grid
    with refused("model.in-use", DocumentError, count=1):
        edits.remove_model(now, "m")
    grid_edits.remove_grid(now, "g").swap(now)
    edits.remove_model(now, "m").swap(now)
    assert "g" not in now


@pytest.mark.parametrize(
    ("cells", "mark"), [([6], "d"), ([-1], "d"), ([], "d"), ([0], "?"), ([0], "-")]
)
def test_unknown_cells_and_marks_are_rejected(cells, mark) -> None:
    with pytest.raises(DocumentError):
        grid_edits.mark_cells(records(replace(GRID, name="G")), "g", cells, mark)


def test_marks_of_a_damaged_grid_are_completed_for_every_cell() -> None:
    assert grid_edits.grid_marks(replace(GRID, marks="dX")) == "d-----"
    assert grid_edits.grid_marks(replace(GRID, marks="d" * 99)) == "dddddd"


@pytest.mark.parametrize(
    "grid", [replace(GRID, model_id="?"), replace(GRID, cell=0.0), replace(GRID, columns=0)]
)
def test_grid_without_a_model_or_cells_is_rejected(grid) -> None:
    with pytest.raises(DocumentError):
        grid_edits.add_grid(records(), grid)


def test_grids_are_numbered_consecutively() -> None:
    now = records()
    for id_ in ("a", "b"):
        grid_edits.add_grid(now, replace(GRID, id=id_)).swap(now)
    assert [now[i].name for i in ("a", "b")] == ["Grid 1", "Grid 2"]


def test_grids_and_repeats_are_stored_in_the_project(tmp_path) -> None:
    with closing(ProjectFolder.create(tmp_path / "a.vom")) as project:
        session = project.session
        session.apply(edits.add_model(session.records, MODEL))
        session.apply(grid_edits.add_grid(session.records, GRID))
        session.apply(grid_edits.mark_cells(session.records, "g", [2], "e"))
        for one in (trace("b1"), trace("b2")):
            session.apply(edits.add_trace(session.records, one))
        session.apply(repeated_features.link_repeat(session.records, "b2", "b1", "AB"))
        session.save()
        kept = dict(session.records)
    with closing(ProjectFolder.open(tmp_path / "a.vom")) as project:
        assert dict(project.session.records) == kept
        assert project.session.records["b2"].repeat_of == "b1"


def test_repeat_takes_type_and_set_of_the_original_and_is_not_counted() -> None:
    now = records(trace("b1", set_name="A"), trace("j1"), trace("b2"))
    repeated_features.link_repeat(now, "b2", "b1", "AB").swap(now)
    again = now["b2"]
    assert (again.name, again.set_name, again.interpreter) == ("B1 again", "A", "AB")
    features = [r for r in now.values() if isinstance(r, Trace)]
    assert [f.id for f in repeated_features.first_picks(features, now)] == ["b1", "j1"]
    assert [f.id for f in repeated_features.repeatable_features(now)] == ["j1"]
    assert repeated_features.repeat_columns(again, now) == {"repeat_of": "b1", "interpreter": "AB"}
    # Where the first was deleted the second stands for the structure.
    edits.delete(now, ["b1"]).swap(now)
    assert not repeated_features.is_repeat(now["b2"], now)
    assert repeated_features.repeat_columns(now["b2"], now) == {"interpreter": "AB"}


def test_invalid_repeat_is_rejected() -> None:
    line = Lineation("l", "L", "lineation", "m", "0" * 64, POINTS[:2])
    now = records(trace("b1"), trace("b2", repeat_of="b1"), trace("b3"), line)
    for again, first in (("b3", "b2"), ("b1", "b1"), ("l", "b1"), ("b3", "?"), ("?", "b1")):
        with pytest.raises(DocumentError):
            repeated_features.link_repeat(now, again, first)
    with pytest.raises(DocumentError):
        repeated_features.set_interpreter(now, [], "AB")
