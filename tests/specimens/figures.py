"""Everything that a project says of its features, asked for in ways that stay: the command line's
`export`, and an open project's session.

`python -m tests.specimens.figures NAME...` writes what the present program says of specimens to the
files of `RECORDED`. That was done once, with the program that made them; what a later program says
is held against it.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.files.spreadsheet_cells import unguarded

HERE = Path(__file__).resolve().parent
SPECIMENS = (
    "schema1",
    "schema1_draft",
    "schema2",
    "schema3",
    "schema4",
    "schema5",
    "schema6",
    "schema7",
    "schema8",
)
RECORDED = {
    HERE / "schema1_figures.json": ("schema1", "schema1_draft"),
    HERE / "schema2_figures.json": ("schema2",),
    HERE / "schema3_figures.json": ("schema3",),
    HERE / "schema4_figures.json": ("schema4",),
    HERE / "schema5_figures.json": ("schema5",),
    HERE / "schema6_figures.json": ("schema6",),
    HERE / "schema7_figures.json": ("schema7",),
    HERE / "schema8_figures.json": ("schema8",),
}


def copy_of(name: str, folder: Path) -> Path:
    """A specimen's project with everything that lies beside it, to be worked on."""
    for each in ("photos", "boulder.ply", f"{name}.vom"):
        source = HERE / each
        if source.is_dir():
            shutil.copytree(source, folder / each)
        else:
            shutil.copy(source, folder / each)
    return folder / f"{name}.vom"


@contextlib.contextmanager
def made_from(before: str, name: str, schema: int) -> Iterator[Any]:
    """The open project of an earlier specimen, brought to this schema: its journal is kept as the
    specimen `name`. Only a program of that schema can make it."""
    from vomstudio.io.project.journal_migration import SCHEMA_VERSION

    if schema != SCHEMA_VERSION:
        raise SystemExit(f"Only a program of schema {schema} can make this specimen.")
    with tempfile.TemporaryDirectory() as place:
        folder = copy_of(before, Path(place))
        opened = open_project(folder)
        yield opened
        opened.close()
        kept = HERE / f"{name}.vom"
        shutil.rmtree(kept, ignore_errors=True)
        kept.mkdir()
        shutil.copy(folder / "journal.sqlite", kept)


def open_project(folder: Path) -> Any:
    """The project, which must be closed again."""
    from vomstudio.io.project.folder import Project

    return Project.open(folder)


def command(*words: object) -> tuple[int, dict[str, Any]]:
    """Exit code and JSON object of a command."""
    from vomstudio.cli import main

    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(io.StringIO()):
        code = main([*map(str, words), "--json"])
    return code, json.loads(said.getvalue())


def figures_of(project: Path, *, history: bool = True) -> dict[str, Any]:
    """The orientation table as text, the layers with every float64 of them, the history."""
    with tempfile.TemporaryDirectory() as place:
        table, layers = Path(place) / "table.csv", Path(place) / "layers.gpkg"
        code, said = command("export", project, "--to", "csv", "-o", table)
        assert code == 0, said
        said.pop("files")
        code, again = command("export", project, "--to", "gpkg", "-o", layers)
        assert code == 0, again
        found = {"said": said, "table": read_table(table), "layers": read_layers(layers)}
    if history:
        found["history"] = history_of(project)
    return found


def read_table(path: Path) -> dict[str, Any]:
    """Comments but for the version, and rows by the feature's id."""
    lines = path.read_text(encoding="utf-8").splitlines()
    comments = [line for line in lines if line.startswith("#")][1:]
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    plain = [{name: unguarded(cell) for name, cell in row.items()} for row in rows]
    return {"comments": comments, "rows": {row["id"]: row for row in plain}}


def read_layers(path: Path) -> dict[str, Any]:
    """For every layer its rows by the feature's id, each with its vertices in World."""
    import pyogrio
    import shapely

    found: dict[str, Any] = {}
    for name, kind in pyogrio.list_layers(path):
        if kind is None:  # the table of styles
            continue
        meta, _, shapes, columns = pyogrio.raw.read(path, layer=name)
        rows = {}
        for number, shape in enumerate(shapely.from_wkb(shapes)):
            row = {
                str(field): plain(column[number])
                for field, column in zip(meta["fields"], columns, strict=True)
            }
            row["vertices"] = shapely.get_coordinates(shape, include_z=True).tolist()
            rows[row["id"]] = row
        found[str(name)] = {"kind": str(kind), "crs": meta["crs"], "rows": rows}
    return found


def history_of(project: Path) -> dict[str, Any]:
    """Labels of all that can be undone, the newest first, and of all that can be redone, with the
    number of features after each step. The project is as before afterwards, and its journal longer.
    """
    opened = open_project(project)
    try:
        session = opened.session
        here = state_of(session)
        draft = None if session.draft is None else dict(session.draft.state)
        redo = walk(session, "redo")
        for _ in redo:
            session.undo()
        undo = walk(session, "undo")
        for _ in undo:
            session.redo()
        assert state_of(session) == here
        return {
            **here,
            "draft": draft,
            "problems": list(session.problems),
            "undo": undo,
            "redo": redo,
        }
    finally:
        opened.close()


def state_of(session: Any) -> dict[str, Any]:
    """What the window shows of a session. The features are in the order of their ids: their own
    order depends on the way through the history, since what an undo brings back comes last."""
    return {
        "undo_label": session.undo_label,
        "redo_label": session.redo_label,
        "dirty": session.dirty,
        "records": len(session.records),
        "features": sorted([feature.id, feature.name] for feature in session.features()),
    }


def walk(session: Any, which: str) -> list[list[Any]]:
    """Undo or redo as far as it goes: label of each step, features and records after it."""
    steps = []
    while (label := getattr(session, f"{which}_label")) is not None:
        getattr(session, which)()
        steps.append([label, len(session.features()), len(session.records)])
    return steps


def plain(value: Any) -> Any:
    """A cell as JSON knows it; nothing in place of what is not a number."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def record(names: list[str]) -> None:
    """Write down what the present program says."""
    for path, kept in RECORDED.items():
        if not set(kept) & set(names):
            continue
        found = {}
        for name in kept:
            with tempfile.TemporaryDirectory() as place:
                found[name] = figures_of(copy_of(name, Path(place)))
        text = json.dumps(found, indent=0, ensure_ascii=False)
        path.write_text(text + "\n", encoding="utf-8")
        print(f"{path}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    record(sys.argv[1:])
