"""The texts of a figure as they are drawn, and what is wrong with their places."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import combinations
from xml.etree import ElementTree

import pytest
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.text import Text
from matplotlib.textpath import text_to_path
from matplotlib.transforms import Affine2D, Bbox

MIN_FONT_PT = 5.5
_SLACK_PT = 0.5
_DESCENT = 0.15
"""Share of a box above and below that letters rarely use."""
_INTERNAL = re.compile(r"\b(None|null|nan|NaN|inf|True|False)\b|[{}]")
Words = tuple[str, Bbox, float]


class Page:
    """A figure that was drawn: its texts with boxes in points and font sizes."""

    def __init__(self, width_pt: float, height_pt: float) -> None:
        self.paper = Bbox.from_extents(0.0, 0.0, width_pt, height_pt)
        self.texts: list[Words] = []

    def faults(self) -> list[str]:
        """Texts that overlap, leave the page, are too small or show internal words."""
        found = [
            f"{a!r} overlaps {b!r}"
            for (a, one, _), (b, other, _) in combinations(self.texts, 2)
            if _core(one).overlaps(_core(other))
        ]
        for text, box, size in self.texts:
            left, bottom, right, top = box.extents
            if (
                min(left, bottom) < -_SLACK_PT
                or right > self.paper.x1 + _SLACK_PT
                or top > self.paper.y1 + _SLACK_PT
            ):
                found.append(f"{text!r} leaves the page")
            if size < MIN_FONT_PT:
                found.append(f"{text!r} has {size:.1f} pt")
            if _INTERNAL.search(re.sub(r"\$.*?\$", "", text)):
                found.append(f"{text!r} is internal")
        return found


def _core(box: Bbox) -> Bbox:
    """The part of a box that letters fill; the longer side is along the text."""
    wide, tall = box.width, box.height
    x, y = (_SLACK_PT, _DESCENT * tall) if wide >= tall else (_DESCENT * wide, _SLACK_PT)
    return Bbox.from_extents(box.x0 + x, box.y0 + y, box.x1 - x, box.y1 - y)


@contextmanager
def recorded() -> Iterator[list[Page]]:
    """The figures of matplotlib that are drawn inside, each as it was drawn last."""
    pages: dict[Figure, Page] = {}
    draw_text, draw_figure = Text.draw, Figure.draw

    def record_text(self: Text, renderer: RendererBase) -> None:
        figure = self.get_figure(root=True)
        if figure in pages and self.get_visible() and self.get_text().strip():
            box = self.get_window_extent(renderer)
            points = 72.0 / figure.dpi
            scaled = box.transformed(Affine2D().scale(points))
            pages[figure].texts.append((self.get_text(), scaled, float(self.get_fontsize())))
        draw_text(self, renderer)

    def record_figure(self: Figure, renderer: RendererBase) -> None:
        wide, tall = self.get_size_inches()
        pages[self] = Page(72.0 * wide, 72.0 * tall)
        draw_figure(self, renderer)

    record_text._supports_rasterization = True  # type: ignore[attr-defined]
    record_figure._supports_rasterization = True  # type: ignore[attr-defined]
    listed: list[Page] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Text, "draw", record_text)
        patch.setattr(Figure, "draw", record_figure)
        yield listed
    listed += pages.values()


def page_of_svg(svg: str) -> Page:
    """The page of a drawing in millimetres, with the widths of DejaVu Sans, a wide font."""
    root = ElementTree.fromstring(svg)
    width, height = (float(v) for v in root.get("viewBox", "").split()[2:])
    points = 72.0 / 25.4
    page = Page(points * width, points * height)
    size = float(root.get("font-size", "0"))
    for element in root.iter():
        if not element.tag.endswith("}text") or element.get("stroke", "none") != "none":
            continue
        text, own = element.text or "", points * float(element.get("font-size", size))
        x, y = (points * float(element.get(axis, "0")) for axis in "xy")
        font = FontProperties(size=own, weight=element.get("font-weight", "normal"))
        wide, _, _ = text_to_path.get_text_width_height_descent(text, font, ismath=False)
        shift = {"middle": 0.5, "end": 1.0}.get(element.get("text-anchor", "start"), 0.0) * wide
        if "rotate(-90" in element.get("transform", ""):
            box = Bbox.from_extents(x - 0.8 * own, y - wide + shift, x + 0.2 * own, y + shift)
        else:
            box = Bbox.from_extents(x - shift, y - 0.8 * own, x - shift + wide, y + 0.2 * own)
        page.texts.append((text, box, own))
    return page
