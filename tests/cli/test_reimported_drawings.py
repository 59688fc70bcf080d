"""A drawing of the traces of a project is imported again: unchanged, edited or copied."""

from __future__ import annotations

import shutil
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyogrio
import pytest
import shapely

import vomstudio as vs
from tests.tiers import first_in_default_tier
from vomstudio.project.journal.database import read_replay

SPECIMEN = Path(__file__).resolve().parents[1] / "specimens" / "schema1.vom"
pytestmark = [
    pytest.mark.filterwarnings("ignore:'crs' was not provided"),
    pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning"),
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
            "trace",
            model,
            "--sidecar",
            self.sidecar,
            "--from-ortho",
            drawing,
            "--into",
            self.project,
            "--on",
            "face",
            "-o",
            self.folder / "t.csv",
            "--force",
            "--json",
            *options,
        )
        assert ran.code == 0, ran.err
        return ran.json

    def rows(self) -> Rows:
        """Return the traces of the GeoPackage with their attributes."""
        meta, _, shapes, columns = pyogrio.raw.read(self.files["gpkg"], layer="traces")
        names = list(meta["fields"])
        return [
            (
                {name: str(column[i] or "") for name, column in zip(names, columns, strict=True)},
                shape,
            )
            for i, shape in enumerate(shapely.from_wkb(shapes))
        ]

    def write(self, rows: Rows, name: str = "edited.gpkg") -> Path:
        """Write traces as a program that keeps id, name, kind and set does."""
        path = self.folder / name
        path.unlink(missing_ok=True)
        names = ["id", "name", "kind", "set"]
        values = [np.array([row.get(n, "") for row, _ in rows], object) for n in names]
        crs = pyogrio.read_info(self.files["gpkg"], layer="traces")["crs"]
        pyogrio.raw.write(
            path,
            shapely.to_wkb(np.array([s for _, s in rows], object)),
            values,
            names,
            geometry_type="LineString",
            crs=crs,
            layer="traces",
        )
        return path

    def shown_lines(self) -> Counter[str]:
        """Return how many lines and outlines of each feature the GeoPackage has, by id."""
        shown: Counter[str] = Counter()
        for layer, kind in pyogrio.list_layers(self.files["gpkg"]):
            if kind == "Point":
                continue
            meta, _, shapes, columns = pyogrio.raw.read(self.files["gpkg"], layer=layer)
            ids = columns[list(meta["fields"]).index("id")]
            for id_, shape in zip(ids, shapely.from_wkb(shapes), strict=True):
                rings = len(shape.interiors) + 1 if shape.geom_type == "Polygon" else 1
                shown[str(id_)] += rings
        return shown

    def features(self) -> dict[str, Any]:
        """Return all records of the project."""
        return read_replay(self.project).records

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
    made = run(
        "ortho",
        model,
        "--trend",
        31,
        "--plunge",
        11,
        "--gsd",
        0.05,
        "-o",
        tmp_path / "o.tif",
        "--draw",
        project,
        "--json",
    ).json
    return Drawing(run, tmp_path, project, made["sidecar"], made["drawing"])


def codes(answer: Any) -> list[str]:
    return [each["code"] for each in answer["warnings"]]


def ids(rows: list[dict[str, str]]) -> set[str]:
    return {row["id"] for row in rows}


@pytest.mark.parametrize("format_", first_in_default_tier(["gpkg", "svg", "dxf"]))
def test_an_unmodified_drawing_adds_and_changes_nothing(drawing: Drawing, format_: str) -> None:
    """Its traces, lineations, outlines of patches and dimensions are in the project already."""
    before = drawing.features()
    answer = drawing.reimport(drawing.files[format_])
    assert answer["added"] == answer["updated"] == []
    shown = drawing.shown_lines()
    # A drawing for CAD has no ids, and two features may lie at one place.
    assert len(answer["unchanged"]) == shown.total()
    assert format_ == "dxf" or {row["id"] for row in answer["unchanged"]} == set(shown)
    assert "drawing.unchanged" in codes(answer)
    assert drawing.features() == before


@pytest.mark.full
def test_edited_traces_change_only_if_requested(drawing: Drawing) -> None:
    rows = drawing.rows()
    edited = rows[0][0]["id"]
    corners = shapely.get_coordinates(rows[0][1])
    corners[1] += [0.4, 0.1]
    rows[0] = (rows[0][0], shapely.LineString(corners))
    file = drawing.write(rows)
    before = drawing.traces()
    answer = drawing.reimport(file)
    assert (answer["added"], answer["updated"]) == ([], [])
    assert len(answer["unchanged"]) == len(rows) - 1
    assert "drawing.edited" in codes(answer)
    assert all(np.array_equal(drawing.traces()[id_], line) for id_, line in before.items())
    answer = drawing.reimport(file, "--update")
    assert ids(answer["updated"]) == {edited}
    assert "drawing.edited" not in codes(answer)
    after = drawing.traces()
    assert set(after) == set(before)
    moved = np.linalg.norm(after[edited] - before[edited], axis=1)
    assert moved[1] > 0.2
    # Vertices that were not moved stay where they were picked, to the last digit.
    assert np.delete(moved, 1).max() == 0.0
    assert ids(drawing.reimport(file)["unchanged"]) == {row["id"] for row, _ in rows}


def test_new_and_edited_lines_are_one_undo_step(drawing: Drawing) -> None:
    rows = drawing.rows()
    before = drawing.features()
    rows[0] = (rows[0][0], shapely.affinity.translate(rows[0][1], 0.4, 0.1))
    new = ({"name": "mine", "kind": "Joint"}, shapely.affinity.translate(rows[1][1], 0.3, 0.2))
    answer = drawing.reimport(drawing.write([*rows, new]), "--update")
    assert [row["name"] for row in answer["added"]] == ["mine"]
    assert len(answer["updated"]) == 1
    assert drawing.run("project", drawing.project, "undo").code == 0
    assert drawing.features() == before


@pytest.mark.full
def test_copied_line_with_same_id_becomes_new_trace(drawing: Drawing) -> None:
    rows = drawing.rows()
    words, shape = rows[0]
    copy = (dict(words, kind="Joint", set="J7"), shapely.affinity.translate(shape, 0.4, 0.1))
    answer = drawing.reimport(drawing.write([copy, *rows]))
    assert len(answer["added"]) == 1
    assert len(answer["unchanged"]) == len(rows)
    with vs.Project.open(drawing.project) as opened:
        row = opened.traces().set_index("id").loc[answer["added"][0]["id"]]
    assert (row["kind"].casefold(), row["set"]) == ("joint", "J7")


@pytest.mark.full
def test_an_edited_outline_of_a_patch_is_left_out(drawing: Drawing) -> None:
    meta, _, shapes, columns = pyogrio.raw.read(drawing.files["gpkg"], layer="patches")
    id_ = str(columns[list(meta["fields"]).index("id")][0])
    outline = shapely.get_coordinates(shapely.from_wkb(shapes)[0])
    moved = shapely.affinity.translate(shapely.LineString(outline), 0.3, 0.1)
    before = drawing.features()
    rows = [*drawing.rows(), ({"id": id_, "name": "edited", "kind": "Bedding"}, moved)]
    answer = drawing.reimport(drawing.write(rows), "--update")
    assert answer["added"] == answer["updated"] == []
    assert drawing.features() == before
