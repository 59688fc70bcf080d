"""Solids and surfaces in a drawing are left out and counted; its lines are read."""

from __future__ import annotations

from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely
from ezdxf.acis import api as acis
from ezdxf.layouts import Modelspace
from ezdxf.render.forms import cube

from tests.drawings import read_lines
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.gis.line_reading import read_gis_lines
from vomstudio.io.gis.wkb_shapes import shapes_from_wkb


def add_solid(space: Modelspace) -> None:
    acis.export_dxf(space.add_3dsolid(), [acis.body_from_mesh(cube())])


def add_body(space: Modelspace) -> None:
    acis.export_dxf(space.add_body(), [acis.body_from_mesh(cube())])


def add_region(space: Modelspace) -> None:
    acis.export_dxf(space.add_region(), [acis.body_from_mesh(cube())])


def add_surface(space: Modelspace) -> None:
    acis.export_dxf(space.add_surface(), [acis.body_from_mesh(cube())])


def add_polyface(space: Modelspace) -> None:
    space.add_polyface().append_faces([[(0, 0, 0), (1, 0, 0), (0, 1, 1)]])


def add_polymesh(space: Modelspace) -> None:
    mesh = space.add_polymesh((2, 2))
    for i in range(2):
        for j in range(2):
            mesh.set_mesh_vertex((i, j), (i, j, i * j))


def add_mesh(space: Modelspace) -> None:
    with space.add_mesh().edit_data() as data:
        data.vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 1)]
        data.faces = [[0, 1, 2]]


def add_block(space: Modelspace) -> None:
    """A polyface mesh and a text in a block, which GDAL reads as one collection."""
    assert space.doc is not None
    block = space.doc.blocks.new("THING")
    block.add_polyface().append_faces([[(0, 0, 0), (1, 0, 0), (0, 1, 1)]])
    block.add_point((0, 0, 0))
    space.add_blockref("THING", (5, 5, 0))


BODIES = [
    add_solid,
    add_body,
    add_region,
    add_surface,
    add_polyface,
    add_polymesh,
    add_mesh,
    add_block,
]


@pytest.mark.parametrize("add", BODIES)
def test_bodies_in_a_drawing_are_skipped_and_counted(tmp_path: Path, add) -> None:  # type: ignore[no-untyped-def]
    doc = ezdxf.new("R2010", units=6)
    space = doc.modelspace()
    for k in range(3):
        space.add_polyline3d([(0, k, 0), (5, k, 1), (9, k, 2)])
    add(space)
    add(space) if add is not add_block else None
    doc.saveas(tmp_path / "d.dxf")
    count = 1 if add is add_block else 2
    lines = read_gis_lines(tmp_path / "d.dxf")
    assert len(lines.lines) == 3
    drawn = read_lines(tmp_path / "d.dxf")
    assert len(drawn.shapes) == 3
    for warnings in (lines.warnings, drawn.warnings):
        found = [w for w in warnings if isinstance(w, Finding) and w.code == "drawing.no-lines"]
        assert [w.values["count"] for w in found] == [count]


def test_drawing_with_only_bodies_is_rejected_with_their_count(tmp_path: Path) -> None:
    doc = ezdxf.new("R2010")
    add_solid(doc.modelspace())
    add_polyface(doc.modelspace())
    doc.saveas(tmp_path / "d.dxf")
    with pytest.raises(InputError) as caught:
        read_lines(tmp_path / "d.dxf")
    assert caught.value.code == "drawing.only-bodies"
    assert caught.value.values["count"] == 2


def wkb(kind: int, *members: bytes, order: str = "<") -> bytes:
    head = bytes([order == "<"]) + kind.to_bytes(4, "little" if order == "<" else "big")
    count = len(members).to_bytes(4, "little" if order == "<" else "big")
    return head + count + b"".join(members)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("has_z", [False, True])
def test_surfaces_are_removed_from_collections(order: str, has_z: bool) -> None:
    place = (1.0, 2.0, 3.0)[: 3 if has_z else 2]
    line = shapely.LineString([place, np.add(place, 1.0)])
    triangle = shapely.Polygon(
        [place, np.add(place, 1.0), np.add(place, [2.0, 0.0, 0.0][: len(place)])]
    )
    one = {"<": 1, ">": 0}[order]
    member = shapely.to_wkb(line, byte_order=one, output_dimension=len(place), flavor="iso")
    face = shapely.to_wkb(triangle, byte_order=one, output_dimension=len(place), flavor="iso")
    plus = 1000 if has_z else 0
    surface = wkb(15 + plus, face, face, order=order)
    nested = wkb(7 + plus, wkb(16 + plus, order=order), member, order=order)
    rows = np.array(
        [surface, wkb(7 + plus, member, surface, nested, order=order), member, None, b"\1\2"],
        object,
    )
    shapes, surfaces = shapes_from_wkb(rows)
    assert surfaces.tolist() == [1, 2, 0, 0, 0]
    assert shapes[0] is None
    assert [part.wkt for part in shapely.get_parts(shapes[1].geoms[0])] == [line.wkt]
    assert shapes[1].geoms[1].geoms[0].wkt == line.wkt
    assert shapes[2].wkt == line.wkt
    assert shapes[3] is None
    assert shapes[4] is None


def test_corrupt_surfaces_do_not_hang_the_parser() -> None:
    rng = np.random.default_rng(4)
    face = shapely.to_wkb(shapely.Polygon([(0, 0), (1, 0), (0, 1)]))
    whole = wkb(7, wkb(15, face, face), wkb(7, wkb(15, face)))
    rows = []
    for _ in range(2000):
        data = bytearray(whole[: int(rng.integers(1, len(whole) + 1))])
        data[int(rng.integers(len(data)))] = int(rng.integers(256))
        rows.append(bytes(data))
    shapes, _ = shapes_from_wkb(np.array(rows, object))
    assert len(shapes) == len(rows)
