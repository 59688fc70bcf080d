"""Grids of what was looked at as a layer: where their cells lie, and what was found in them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.products.ortho.interpretation import items_from_records
from vomstudio.project import edits, grid_edits
from vomstudio.project.exports.export import export_records
from vomstudio.project.grid_edits import MARKS
from vomstudio.project.kinds.station import Station
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import FaceGrid, Model
from vomstudio.project.tables.grid_layer import LAYER, world_cells

MODEL = Model("m", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("crs", "EPSG:32633"))
SEEN = Station("s", "St 1", "m", "0" * 64, ((1.0, 2.0, 3.0),))


def grid(**more) -> FaceGrid:
    fields = {
        "id": "g",
        "name": "Grid 1",
        "model_id": "m",
        "model_hash": "0" * 64,
        "origin": (1.0, 2.0, 3.0),
        "right": (0.6, 0.8, 0.0),
        "up": (0.0, 0.0, 1.0),
        "cell": 0.5,
        "columns": 3,
        "rows": 2,
        "marks": "d-euud",
    }
    return FaceGrid(**{**fields, **more})


def test_cells_move_with_the_placed_model() -> None:
    """Turned by 30 degrees, doubled and shifted with it."""
    turn = Rotation.from_euler("z", -30, degrees=True).as_matrix()
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = 2.0 * turn, (500_000.0, 4_000_000.0, 100.0)
    by = Registration(
        "r", "control", "control", Frame("crs", "EPSG:32633"), tuple(map(tuple, matrix.tolist()))
    )
    placed = Model("m", "cliff", "cliff.obj", "mesh", "0" * 64, by)
    for model, to_world in ((MODEL, np.eye(4)), (placed, matrix)):
        numbers, corners = world_cells(grid(), {"m": model, "r": by, "g": grid()})
        assert list(numbers) == list(range(6))
        # Cell 4 is the second one of the upper row: around from its lower left corner.
        right, up = np.array([0.6, 0.8, 0.0]), np.array([0.0, 0.0, 1.0])
        steps = [(0.5, 0.5), (1.0, 0.5), (1.0, 1.0), (0.5, 1.0)]
        file = [np.array([1.0, 2.0, 3.0]) + a * right + b * up for a, b in steps]
        wanted = np.array(file) @ to_world[:3, :3].T + to_world[:3, 3]
        assert corners[4] == pytest.approx(wanted, abs=1e-8)
    numbers, _ = world_cells(grid(), {"m": MODEL}, "de")
    assert list(numbers) == [0, 2, 5]


@pytest.mark.filterwarnings("ignore:'crs' was not provided:UserWarning")
def test_exports_have_a_ring_for_every_cell(tmp_path: Path) -> None:
    import pyogrio

    records: dict = {}
    for edit in (
        lambda: edits.add_model(records, MODEL),
        lambda: edits.add_features(records, [SEEN]),
        lambda: grid_edits.add_grid(records, grid()),
    ):
        records.update(edit().after)
    # A mark that is none, as of a later program, was not looked at.
    records["h"] = grid(id="h", name="=Grid", marks="d?", columns=2, rows=1)
    made = export_records(records, "gpkg", tmp_path / "a.gpkg", writes_map=True)
    assert made.features == 1
    assert made.layers[LAYER] == 8
    assert "looked_at" in (tmp_path / "a.qgs").read_text("utf-8")
    meta, _, shapes, columns = pyogrio.raw.read(tmp_path / "a.gpkg", layer=LAYER)
    rows = {name: list(c) for name, c in zip(meta["fields"], columns, strict=True)}
    assert meta["crs"] == "EPSG:32633"
    assert rows["found"] == [MARKS[mark] for mark in "d-euudd-"]
    assert rows["cell"][:4] == ["1, 1", "2, 1", "3, 1", "1, 2"]
    assert rows["model"] == ["cliff"] * 8
    assert set(rows["id"]) == {"g", "h"}
    rings = shapely.from_wkb(shapes)
    heights = shapely.get_coordinates(rings[3], include_z=True)[:, 2]
    assert (heights.min(), heights.max()) == pytest.approx((3.5, 4.0))
    export_records(records, "geojson", tmp_path / "a.geojson")
    said = json.loads((tmp_path / "a_looked_at.geojson").read_text("utf-8"))
    assert [f["properties"]["found"] for f in said["features"]] == rows["found"]
    for format_ in ("shp", "dxf", "kml"):
        export_records(records, format_, tmp_path / f"a.{format_}")
    # A project without grids has no such layer, and a picture draws no cells.
    assert {item.layer for item in items_from_records(records, Measurements())} == {"stations"}
    del records["g"], records["h"]
    assert LAYER not in export_records(records, "gpkg", tmp_path / "b.gpkg").layers
