"""The legend of vector drawings names each kind of feature in its colour."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest

from vomstudio.products.ortho.legend_entries import explain_symbols
from vomstudio.products.ortho.vector_drawing import Drawing, DrawingShape, svg_text

LINE = np.array([[0.0, 0.0], [4.0, 1.0]])
KINDS = {"bedding": "#0072b2", "fault": "#d55e00"}


def drawing(dip_deg: float | None) -> Drawing:
    """Return a drawing of two beds, a fault and the outline of a surface."""
    shapes = [
        DrawingShape(kind, LINE + number, color, values={"kind": kind})
        for number, (kind, color) in enumerate(KINDS.items())
        for _ in range(2)
    ]
    shapes += [
        DrawingShape("surface", LINE),
        DrawingShape(
            "bedding", LINE[:1], KINDS["bedding"], dip_deg=dip_deg, values={"kind": "bedding"}
        ),
    ]
    bounds = np.array([[-1.0, -1.0], [6.0, 3.0]])
    return Drawing(tuple(shapes), bounds, ("W", "E"), ("x (m)", "y (m)"), ("A title",))


@pytest.mark.parametrize("dip_deg", [None, 30.0])
def test_legend_shows_each_type_beside_a_glyph_of_its_colour(
    dip_deg: float | None,
) -> None:
    drawn = drawing(dip_deg)
    root = ElementTree.fromstring(svg_text(drawn))
    (frame,) = (group for group in root.iter() if group.get("id") == "frame")
    elements = list(frame)
    named = {}
    for glyph, text in pairwise(elements):
        if glyph.tag != text.tag and glyph.get("stroke") and text.tag.endswith("text"):
            named[text.text] = glyph.get("stroke")
    assert KINDS.items() <= named.items()
    remarks = explain_symbols(drawn.legend)
    assert bool(remarks) == (dip_deg is not None)
    assert sum(each.text == remarks for each in elements) == bool(remarks)
    page = float(root.get("height", "").removesuffix("mm"))
    texts = [each for each in elements if each.tag.endswith("text")]
    assert len({(each.get("x"), each.get("y")) for each in texts}) == len(texts)
    heights = [float(each.get("y", "0")) for each in texts]
    assert max(heights) < page - 3.0


def test_annotation_lines_are_not_in_the_legend() -> None:
    bend = DrawingShape("bends", LINE, "#888888", label="bend", is_annotation=True)
    drawn = drawing(None)
    assert replace(drawn, shapes=(*drawn.shapes, bend)).legend == drawn.legend
