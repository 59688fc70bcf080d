"""Figures of a specimen project, read in ways that stay: the command `export` and a session.

The figures of each specimen are recorded beside it, in NAME_figures.json.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.files.spreadsheet_cells import unescape_formula

HERE = Path(__file__).resolve().parent
SPECIMENS = ("schema1",)
RELATIVE = 1e-12
"""Tolerance of a number: other processors and libraries sum in another order."""
ZERO = 1e-12
"""Below this a number is rounding, such as the roughness of a line through two points."""
# Verdicts are not compared: they are what the rules of the present version state.
JUDGED = {
    "quality",
    "quality_reason",
    "reason",
    "reason_codes",
    "codes",
    "quality_notes",
    "q_notes",
    "total95_deg",
    "total95",
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


def open_project(folder: Path) -> Any:
    """The project, which must be closed again."""
    from vomstudio.project.folder import ProjectFolder

    return ProjectFolder.open(folder)


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
    plain = [{name: unescape_formula(cell) for name, cell in row.items()} for row in rows]
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


def recorded(name: str) -> dict[str, Any]:
    """The figures recorded beside a specimen."""
    found: dict[str, Any] = json.loads(_file_of(name).read_text(encoding="utf-8"))
    return found


def record(name: str, found: dict[str, Any]) -> None:
    """Write the figures of a specimen beside it."""
    text = json.dumps(found, indent=0, ensure_ascii=False)
    _file_of(name).write_text(text + "\n", encoding="utf-8")


def _file_of(name: str) -> Path:
    return HERE / f"{name}_figures.json"


def differences(was: Any, now: Any, where: str = "", ignored: Sequence[str] = ()) -> Iterator[str]:
    """Yield the places where recorded figures differ from present ones. Additions are allowed.

    ignored : keys of the outermost map that are not compared
    """
    if isinstance(was, dict):
        for key in was:
            if key in ignored:
                continue
            if key not in now:
                yield f"{where}/{key} is gone"
            elif key not in JUDGED:
                yield from differences(was[key], now[key], f"{where}/{key}")
            elif key == "quality" and bool(was[key]) != bool(now[key]):
                yield f"{where}/{key}: {was[key]!r} is {now[key]!r} now"
    elif isinstance(was, list):
        if len(was) != len(now):
            yield f"{where}: {len(was)} entries were {len(now)} now"
        for number, (one, other) in enumerate(zip(was, now, strict=False)):
            yield from differences(one, other, f"{where}[{number}]")
    elif isinstance(was, float) and isinstance(now, float | int):
        if not math.isclose(now, was, rel_tol=RELATIVE, abs_tol=ZERO):
            yield f"{where}: {was!r} is {now!r} now"
    elif was != now and not _are_equal_numbers(was, now):
        yield f"{where}: {was!r} is {now!r} now"


def _are_equal_numbers(was: Any, now: Any) -> bool:
    """Whether two cells of a table are numbers that agree to their twelve digits."""
    try:
        return math.isclose(float(now), float(was), rel_tol=1e-11, abs_tol=ZERO)
    except (TypeError, ValueError):
        return False
