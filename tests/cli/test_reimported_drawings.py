"""A drawing of the traces of a project is imported again: unchanged, edited or copied."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyogrio
import pytest
import shapely

import vomstudio as vs

SPECIMEN = Path(__file__).resolve().parents[1] / "specimens" / "schema1.vom"
pytestmark = [
    pytest.mark.filterwarnings("ignore:'crs' was not provided"),
    pytest.mark.filterwarnings("ignore::vomstudio.errors.VomWarning"),
]
Rows = list[tuple[dict[str, str], shapely.LineString]]


@dataclass
class Drawing:
    """An orthophoto of the specimen with its interpretation. files : by format"""

    run: Any
    folder: Path
    project: Path
    sidecar: str
    files: dict[str, str]

    def reimport(self, drawing: str | Path, *options: object) -> Any:
        """Import a drawing into the project and return the JSON."""
        model = self.project / "models" / "face" / "face.obj"
        ran = self.run(
            "trace", model, "--sidecar", self.sidecar, "--from-ortho", drawing, "--into",
            self.project, "--on", "face", "-o", self.folder / "t.csv", "--force", "--json",
            *options,
        )  # fmt: skip
        assert ran.code == 0, ran.err
        return ran.json

    def rows(self) -> Rows:
        """Return the traces of the GeoPackage with their attributes."""
        meta, _, shapes, columns = pyogrio.raw.read(self.files["gpkg"], layer="traces")
        names = list(meta["fields"])
        return [
            ({name: str(column[i] or "") for name, column in zip(names, columns, strict=True)},
             shape)
            for i, shape in enumerate(shapely.from_wkb(shapes))
        ]  # fmt: skip

    def write(self, rows: Rows, name: str = "edited.gpkg") -> Path:
        """Write traces as a program that keeps id, name, kind and set does."""
        path = self.folder / name
        path.unlink(missing_ok=True)
        names = ["id", "name", "kind", "set"]
        values = [np.array([row.get(n, "") for row, _ in rows], object) for n in names]
        crs = pyogrio.read_info(self.files["gpkg"], layer="traces")["crs"]
        pyogrio.raw.write(path, shapely.to_wkb(np.array([s for _, s in rows], object)), values,
                          names, geometry_type="LineString", crs=crs, layer="traces")  # fmt: skip
        return path

    def traces(self) -> dict[str, np.ndarray]:
        """Return the World vertices (n, 3) of the project's traces, by id."""
        with vs.Project.open(self.project) as opened:
            lines = opened.traces().set_index("id")["geometry"]
        return {i: shapely.get_coordinates(line, include_z=True) for i, line in lines.items()}


@pytest.fixture
def drawing(run, tmp_path: Path) -> Drawing:
    project = tmp_path / "p.vom"
    shutil.copytree(SPECIMEN, project)
    model = project / "models" / "face" / "face.obj"
    made = run("ortho", model, "--trend", 31, "--plunge", 11, "--gsd", 0.05, "-o",
               tmp_path / "o.tif", "--draw", project, "--json").json  # fmt: skip
    return Drawing(run, tmp_path, project, made["sidecar"], made["drawing"])


def codes(answer: Any) -> list[str]:
    return [each["code"] for each in answer["warnings"]]


def ids(rows: list[dict[str, str]]) -> set[str]:
    return {row["id"] for row in rows}


@pytest.mark.parametrize("format_", ["gpkg", "svg", "dxf"])
def test_unmodified_traces_are_not_added_again(drawing: Drawing, format_: str) -> None:
    before = drawing.traces()
    answer = drawing.reimport(drawing.files[format_], "--type", "bedding")
    drawn = {row["id"] for row, _ in drawing.rows()}
    assert len(ids(answer["unchanged"])) == len(drawn)
    # A drawing for CAD has no ids, and two traces lie at one place.
    assert format_ == "dxf" or ids(answer["unchanged"]) == drawn
    assert "drawing.traces-unchanged" in codes(answer)
    assert answer["updated"] == []
    after = drawing.traces()
    assert len(after) == len(before) + len(answer["added"])
    assert all(np.array_equal(after[id_], line) for id_, line in before.items())


def test_edited_traces_change_only_if_requested(drawing: Drawing) -> None:
    rows = drawing.rows()
    edited = rows[0][0]["id"]
    rows[0] = (rows[0][0], shapely.affinity.translate(rows[0][1], 0.4, 0.1))
    file = drawing.write(rows)
    before = drawing.traces()
    answer = drawing.reimport(file)
    assert (answer["added"], answer["updated"]) == ([], [])
    assert len(answer["unchanged"]) == len(rows) - 1
    assert "drawing.traces-edited" in codes(answer)
    assert all(np.array_equal(drawing.traces()[id_], line) for id_, line in before.items())
    answer = drawing.reimport(file, "--update")
    assert ids(answer["updated"]) == {edited}
    after = drawing.traces()
    assert set(after) == set(before)
    assert np.linalg.norm(after[edited].mean(axis=0) - before[edited].mean(axis=0)) > 0.2
    # Now it is as the drawing has it.
    assert ids(drawing.reimport(file)["unchanged"]) == {row["id"] for row, _ in rows}
    drawing.run("project", drawing.project, "undo")
    assert all(np.array_equal(drawing.traces()[id_], line) for id_, line in before.items())


def test_a_copy_with_the_same_id_is_a_new_trace_of_its_kind_and_set(drawing: Drawing) -> None:
    rows = drawing.rows()
    words, shape = rows[0]
    copy = (dict(words, kind="Joint", set="J7"), shapely.affinity.translate(shape, 0.4, 0.1))
    answer = drawing.reimport(drawing.write([copy, *rows]))
    assert len(answer["added"]) == 1
    assert len(answer["unchanged"]) == len(rows)
    with vs.Project.open(drawing.project) as opened:
        row = opened.traces().set_index("id").loc[answer["added"][0]["id"]]
    assert (row["kind"].casefold(), row["set"]) == ("joint", "J7")
