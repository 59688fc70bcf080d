"""How planes lie on pictures: strike and dip on a map, apparent dips on others; and their way into
drawings and back."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from PIL import Image

from tests.drawings import read_lines
from vomstudio.geology.orientation import planes_to_normals
from vomstudio.io.gis.line_reading import read_gis_lines
from vomstudio.io.gis.svg_lines import read_svg
from vomstudio.products.ortho.interpretation import Item, ProjectedItem, project_item
from vomstudio.products.ortho.legend_entries import create_entries
from vomstudio.products.ortho.sheet import write_sheet
from vomstudio.products.ortho.vector_drawing import (
    Drawing,
    DrawingShape,
    create_shape,
    svg_text,
    write_dxf,
    write_gpkg,
)
from vomstudio.products.ortho.view_directions import view_along_line

PLANES = [(0, 30), (45, 60), (90, 45), (120, 20), (225, 85), (315, 50), (10, 90), (200, 0)]


def item(dd: float, dip: float, at: tuple[float, float, float] = (0, 0, 0), **more: bool) -> Item:
    return Item(
        "planes",
        "point",
        np.array([at], float),
        f"p{dd:g}",
        "",
        "bedding",
        "",
        "#0072b2",
        planes_to_normals(dd, dip),
        dd,
        dip,
        **more,
    )


def seen(what: Item, trend: float, plunge: float) -> ProjectedItem:
    frame = view_along_line(trend, plunge).frame
    flat = project_item(what, np.zeros(3), frame.right, -frame.down)
    assert flat is not None
    return flat


@pytest.mark.parametrize(("dd", "dip"), PLANES)
def test_a_map_shows_strike_and_true_dip(dd: float, dip: float) -> None:
    flat = seen(item(dd, dip), 0, 90)
    assert flat.apparent_dip_deg is None
    shape = create_shape(flat)
    assert shape.label == f"{dip}°"
    assert shape.dip_deg is None
    assert shape.values["apparent_dip_deg"] is None
    bar, tick = shape.marks(1.0)
    strike = math.radians(dd - 90)
    way = np.array([math.sin(strike), math.cos(strike)])
    assert np.abs((bar[1] - bar[0]) @ way) == pytest.approx(2.0)
    down = np.array([math.sin(math.radians(dd)), math.cos(math.radians(dd))])
    reach = {0: (-1.0, 1.0), 90: (-0.4, 0.4)}.get(dip, (0.0, 0.4))
    assert tick @ down == pytest.approx(reach)


@pytest.mark.parametrize("turn", [37.0, 180.0, 251.0])
def test_rotating_the_world_about_up_rotates_symbols_but_not_labels(turn: float) -> None:
    a = math.radians(turn)
    spin = np.array([[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]])
    for dd, dip in PLANES:
        before = create_shape(seen(item(dd, dip, overturned=True), 0, 90))
        after = create_shape(seen(item((dd + turn) % 360, dip, overturned=True), 0, 90))
        assert before.label == after.label
        # Azimuths are clockwise.
        for one, other in zip(before.symbol, after.symbol, strict=True):
            assert other == pytest.approx(one @ spin, abs=1e-12)


def test_near_vertical_views_are_maps_and_others_show_apparent_dips() -> None:
    for plunge in (81.0, 90.0, -85.0):
        assert seen(item(120, 20), 40, plunge).symbol
    for plunge in (79.0, 45.0, 0.0, -60.0):
        flat = seen(item(120, 20), 40, plunge)
        assert not flat.symbol
        assert flat.apparent_dip_deg is not None
    # tan a = tan d sin b on a vertical picture.
    flat = seen(item(120, 20), 40, 0)
    expected = math.atan(math.tan(math.radians(20)) * math.sin(math.radians(130 - 210)))
    assert abs(flat.apparent_dip_deg or 0) == pytest.approx(abs(math.degrees(expected)))
    # A plane that the viewer looks straight at has no trace, its own error apart.
    assert seen(item(220, 89.5), 40, 0).apparent_dip_deg is None
    assert seen(item(220, 88.0), 40, 0).apparent_dip_deg is not None


def map_drawing() -> Drawing:
    rows = [
        item(dd, dip, (10.0 * k, 7.0 * k, 0), overturned=k == 1)
        for k, (dd, dip) in enumerate(PLANES)
    ]
    trace = DrawingShape("traces", np.array([[0.0, 0.0], [5.0, 9.0]]), "#0072b2")
    shapes = tuple(
        replace(create_shape(seen(row, 0, 90)), label=f"bed {k}") for k, row in enumerate(rows)
    )
    bounds = np.array([[-10.0, -10.0], [90.0, 60.0]])
    return Drawing((*shapes, trace), bounds, ("W", "E"), ("x", "y"))


def section_drawing() -> Drawing:
    shape = create_shape(seen(item(120, 20), 40, 0))
    trace = DrawingShape("traces", np.array([[0.0, 0.0], [5.0, 9.0]]), "#0072b2")
    return Drawing((shape, trace), np.array([[-10.0, -10.0], [10.0, 10.0]]), ("W", "E"), ("x", "y"))


@pytest.mark.parametrize("make", [map_drawing, section_drawing])
def test_dxf_contains_symbol_lines_and_texts_that_are_not_read_as_traces(
    make, tmp_path: Path
) -> None:  # type: ignore[no-untyped-def]
    drawing, path = make(), tmp_path / "d.dxf"
    write_dxf(path, drawing)
    space = ezdxf.readfile(path).modelspace()
    planes = [s for s in drawing.shapes if s.layer == "planes"]
    texts = space.query("TEXT")
    assert sorted(t.dxf.text for t in texts) == sorted(
        s.label.replace("°", "\\U+00B0") if "°" not in texts[0].dxf.text else s.label
        for s in planes
    )
    lines = list(space.query("LINE"))
    assert {e.dxf.layer for e in [*texts, *lines]} == {"planes_symbols"}
    assert len(lines) == sum(len(line) - 1 for s in planes for line in s.marks(1.0))
    # What is drawn lies about its place as the shape says.
    bar = planes[0].marks(1.0)[0]
    way = np.array(
        [lines[0].dxf.end.x - lines[0].dxf.start.x, lines[0].dxf.end.y - lines[0].dxf.start.y]
    )
    assert way / np.linalg.norm(way) == pytest.approx((bar[1] - bar[0]) / 2.0)
    assert len(space.query("POINT")) == len(planes)
    assert [line.layer for line in read_gis_lines(path).lines] == ["traces"]
    assert len(read_lines(path).shapes) == 1


@pytest.mark.full
def test_other_formats_are_also_read_without_their_symbols(tmp_path: Path) -> None:
    drawing = map_drawing()
    write_gpkg(tmp_path / "d.gpkg", drawing, None, "VOM Studio")
    assert [line.layer for line in read_gis_lines(tmp_path / "d.gpkg").lines] == ["traces"]
    assert len(read_lines(tmp_path / "d.gpkg").shapes) == 1
    (tmp_path / "d.svg").write_text(svg_text(drawing), "utf-8")
    assert len(read_svg(tmp_path / "d.svg").lines) == 1


def test_user_layer_with_symbols_in_its_name_is_read(tmp_path: Path) -> None:
    trace = DrawingShape("my_symbols", np.array([[0.0, 0.0], [5.0, 9.0]]), "#0072b2")
    other = DrawingShape("lines", np.array([[0.0, 1.0], [5.0, 9.0]]), "#0072b2")
    bounds = np.array([[0.0, 0.0], [9.0, 9.0]])
    write_dxf(tmp_path / "d.dxf", Drawing((trace, other), bounds, ("W", "E"), ("x", "y")))
    assert len(read_gis_lines(tmp_path / "d.dxf").lines) == 2


def test_legend_shows_which_symbol_is_drawn() -> None:
    (entry,) = (e for e in create_entries(map_drawing().shapes) if e.place)
    assert entry.has_map_symbol
    assert entry.overturned
    (entry,) = (e for e in create_entries(section_drawing().shapes) if e.place)
    assert entry.dips
    assert not entry.has_map_symbol


def test_long_northings_leave_space_for_the_axis_name(tmp_path: Path) -> None:
    drawing = map_drawing()
    shift = np.array([500_000.0, 4_500_000.0])
    far = replace(
        drawing,
        bounds=drawing.bounds + shift,
        shapes=tuple(replace(s, points=s.points + shift) for s in drawing.shapes),
    )
    write_sheet(tmp_path / "s.png", far, view_along_line(0, 90), "png")
    ink = np.asarray(Image.open(tmp_path / "s.png").convert("L")) < 200
    # A name that is cut off reaches the edge of the page.
    assert not ink[:, :12].any()
    text = svg_text(far)
    assert "4500020" in text
    assert "e+06" not in text
