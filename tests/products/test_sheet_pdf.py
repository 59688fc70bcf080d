"""The sheet as PDF: text that is text, lines that are lines, all of it true to scale on paper."""

from __future__ import annotations

import re
import zlib
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from vomstudio.products.ortho.sheet_pdf import write_sheet_pdf
from vomstudio.products.ortho.vector_drawing import Drawing, Shape, paper_scale, placed_labels
from vomstudio.products.ortho.view_directions import view_along_line

MM = 72.0 / 25.4


def page_of(path: Path) -> tuple[list[float], str]:
    """Its size in points, and the program that draws it, without the codes of other objects."""
    data = path.read_bytes()
    (box,) = re.findall(rb"/MediaBox \[\s*([^]]*)\]", data)
    for found in re.finditer(rb"stream\r?\n(.*?)\r?\nendstream", data, re.S):
        try:
            text = zlib.decompress(found.group(1))
        except zlib.error:
            continue
        if b"BT" in text:
            return [float(v) for v in box.split()], text.decode("latin-1")
    raise AssertionError("no page")


def texts_of(page: str) -> str:
    """Words that are written, without kerning; letters may be codes of two bytes."""
    said = []
    for block in re.findall(r"\bBT\b(.*?)\bET\b", page, re.S):
        strings = re.findall(r"\(((?:\\.|[^()\\])*)\)", block, re.S)
        words = re.sub(r"\\(.)", r"\1", "".join(strings), flags=re.S)
        said.append(words.replace("\x00", ""))
    return "\n".join(said)


def lines_of(page: str) -> list[np.ndarray]:
    """Each stroked path (n, 2), points of the page."""
    found = []
    for path in re.findall(r"((?:[-\d.]+ [-\d.]+ [ml]\n)+)\s*S", page):
        found.append(np.array([[float(v) for v in row.split()[:2]] for row in path.splitlines()]))
    return found


def drawing(width: float = 20.0, height: float = 8.0) -> Drawing:
    trace = Shape(
        "traces", np.array([[-7.0, -2.0], [0.0, 1.0], [6.0, 2.5]]), "#0072b2", label="B01 21°"
    )
    joint = Shape("joints", np.array([[3.0, 0.0]]), "#009e73", label="J1 60°", dip_deg=60.0)
    bounds = np.array([[-width / 2, -height / 2], [width / 2, height / 2]])
    picture = np.full((40, 100, 4), (120, 110, 90, 255), np.uint8)
    return Drawing((trace, joint), bounds, ("NW (315)", "SE (135)"), ("right (m)", "up (m)"),
                   picture=picture)  # fmt: skip


def test_words_are_text_and_lines_are_where_they_are_to_scale(tmp_path: Path) -> None:
    view = replace(view_along_line(45, 0), reason="along the axis of the fold")
    made = drawing()
    write_sheet_pdf(tmp_path / "s.pdf", made, view)
    box, page = page_of(tmp_path / "s.pdf")
    words = texts_of(page)
    for said in ("NW (315)", "SE (135)", "B01 21", "J1 60", "right (m)", "up (m)", "1 : 100",
                 "along the axis of the fold", "045.0/0.0"):  # fmt: skip
        assert said in words, words
    scale = paper_scale(made.bounds)
    assert scale == 100
    # The trace, in millimetres of paper between its points, by the scale that the sheet states.
    wanted = np.diff(made.shapes[0].points, axis=0) * 1000.0 / scale * MM
    assert any(
        len(line) == 3 and np.allclose(np.diff(line, axis=0), wanted, atol=0.02)
        for line in lines_of(page)
    )
    # Twenty metres at 1 : 100 are twenty centimetres of paper and the margins.
    assert box[2] / MM == pytest.approx(236.0, abs=0.1)


def test_the_bar_is_as_long_as_it_says(tmp_path: Path) -> None:
    write_sheet_pdf(tmp_path / "s.pdf", drawing(), view_along_line(45, 0))
    _, page = page_of(tmp_path / "s.pdf")
    assert "5 m, 1 : 100" in texts_of(page)
    rows = re.findall(r"([-\d.]+) ([-\d.]+) m\n([-\d.]+) \2 l\n\3 ", page)
    widths = {round((float(b) - float(a)) / MM, 2) for a, _, b in rows}
    assert 25.0 in widths


def test_a_narrow_picture_and_unknown_scale_are_said_whole(tmp_path: Path) -> None:
    view = replace(view_along_line(45, 0), north_known=False, metric=False, reason="x " * 300)
    narrow = replace(drawing(0.5, 8.0), shapes=(), metric=False)
    write_sheet_pdf(tmp_path / "s.pdf", narrow, view)
    box, page = page_of(tmp_path / "s.pdf")
    words = texts_of(page)
    assert "Not registered: north and scale unknown" in words
    assert "1 :" not in words
    assert box[2] / MM == pytest.approx(166.0, abs=0.1)


def test_no_label_covers_another_and_those_apart_are_led_to() -> None:
    """Twelve planes at one place: some find room beside it, some at the end of a line, the others
    have no label."""
    at = np.array([[0.0, 0.0]])
    many = tuple(Shape("j", at + 0.01 * i, label=f"J{i:02d} 30°", dip_deg=30.0) for i in range(40))
    made = replace(drawing(), shapes=many)
    placed = placed_labels(made, 100.0, 2.6)
    assert 4 <= len(placed) < 40
    wide, tall = 0.001 * 100.0 * 2.6 * 0.5 * 7, 0.001 * 100.0 * 2.6
    boxes = [(p.x - wide if p.right else p.x, p.y - tall / 2) for p in placed]
    for (x, y), (u, v) in combinations(boxes, 2):
        assert abs(x - u) >= wide or abs(y - v) >= tall - 1e-9
    for p in placed:
        near = abs(p.y - p.named[1]) < 0.001 * 100.0 * 5.0
        assert p.apart != near
