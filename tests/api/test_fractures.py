"""Fractures by the interface: as the command, and from coordinates."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely.geometry import mapping

import vomstudio as vs
from tests.messages import refused, warned

JOINTS = [[(0, y), (6, y)] for y in (1, 2, 3)] + [[(2, 1), (2, 3)]]
CORNERS = [(1, 0), (5, 0), (5, 4), (1, 4)]


def test_lines_areas_and_sets_accept_any_coordinates() -> None:
    shapes = shapely.linestrings(np.array(JOINTS, float))
    one = vs.fractures(JOINTS, area=CORNERS)
    two = vs.fractures(shapes, area=shapely.Polygon(CORNERS), by=["a", "a", "a", "b"])
    assert one.P21_1_per_m == two.P21_1_per_m == 14 / 16
    assert [(s.name, s.n) for s in two.sets] == [("a", 3), ("b", 1)]
    # A line of two corners along a joint set sees its spacing.
    across = vs.fractures(JOINTS, scanline=[(3, 0), (3, 4)])
    assert across.P10_1_per_m == pytest.approx(3 / 4)
    assert across.sets[0].spacing.mean_m == pytest.approx(1.0)
    assert "P21_1_per_m" in repr(one)


@pytest.mark.full
def test_result_matches_command_output(data_dir: Path, tmp_path: Path) -> None:
    folder = data_dir / "fracture_traces"
    found = vs.fractures(
        folder / "KB11_traces.geojson",
        area=folder / "KB11_area.geojson",
        snap_m=0.001,
        plot=tmp_path / "kb11.pdf",
    )
    assert (found.pieces, found.nodes.I, found.nodes.Y, found.nodes.X) == (709, 476, 826, 268)
    assert (tmp_path / "kb11.pdf").stat().st_size > 10_000


def test_invalid_map_arguments_are_refused() -> None:
    with refused("array.shape", shape=(2, 4), field="traces"):
        vs.fractures([[(0, 0, 0, 0), (1, 1, 1, 1)]])
    with refused("lines.no-plane", vs.errors.GeometryError):
        vs.fractures([[(0, 0, 0), (1, 1, 1)]])
    with pytest.raises(vs.errors.InputError, match="traces:"):
        vs.fractures([])
    for scanline in ([(3, 0), (3, 0)], [(3, 0, 0), (3, 0, 4)]):
        with refused("fractures.scanline-without-length", vs.errors.GeometryError):
            vs.fractures(JOINTS, scanline=scanline)
    for code, field, options in (
        ("option.conflict", "circle", {"area": CORNERS, "circle": (0, 0, 1)}),
        ("fractures.not-a-circle", "circle", {"circle": (0, 0)}),
        ("fractures.sets-not-of-traces", "by", {"by": ["a"]}),
        ("option.too-small", "snap_m", {"snap_m": -1}),
    ):
        with pytest.raises(vs.errors.UsageError) as wrong:
            vs.fractures(JOINTS, **options)
        assert (wrong.value.code, wrong.value.field) == (code, field)
    with refused("fractures.area-elsewhere", vs.errors.GeometryError):
        vs.fractures(JOINTS, circle=(100, 100, 1))


@pytest.mark.filterwarnings("ignore:The data lie outside:vomstudio.core.errors.VomWarning")
def test_self_crossing_area_is_reported_with_both_areas(tmp_path: Path) -> None:
    """A bow tie: two triangles of 25 square metres each, which cancel by the order of corners."""
    bow = shapely.Polygon([(0, 0), (10, 10), (10, 0), (0, 10)])
    lines = [np.array([(1.0, 5.0), (9.0, 5.0)])]
    with warned("area.self-crossing", area_m2=50.0, signed_area_m2=0.0):
        found = vs.fractures(lines, area=bow)
    assert found.area_m2 == pytest.approx(50.0)
    file = tmp_path / "bow.geojson"
    drawn = {
        "type": "FeatureCollection",
        "crs": {"type": "name", "properties": {"name": "EPSG:32633"}},
        "features": [{"type": "Feature", "properties": {}, "geometry": mapping(bow)}],
    }
    file.write_text(json.dumps(drawn))
    with warned("area.self-crossing"):
        vs.fractures(lines, area=file)
    sound = vs.fractures(lines, area=shapely.box(0, 0, 10, 10))
    assert not [said for said in sound.warnings if "crosses" in said]
