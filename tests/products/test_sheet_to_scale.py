"""The sheet: to scale on paper and in pixels; in a PDF text is text and lines are lines."""

from __future__ import annotations

import itertools
import re
import zlib
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.messages import refused, shown_codes
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.products.ortho.legend_entries import create_entries
from vomstudio.products.ortho.sheet import format_from_path, write_sheet
from vomstudio.products.ortho.vector_drawing import Drawing, DrawingShape, paper_scale, place_labels
from vomstudio.products.ortho.view_description import unknown_direction_text
from vomstudio.products.ortho.view_directions import view_along_line

MM = 72.0 / 25.4


def page_of(path: Path) -> tuple[list[float], str]:
    """Its size in points, and the program that draws it, without the codes of other objects."""
    data = path.read_bytes()
    (box,) = re.findall(rb"/MediaBox \[\s*([^]]*)\]", data)
    for result in re.finditer(rb"stream\r?\n(.*?)\r?\nendstream", data, re.S):
        try:
            # Whose last byte may be taken for a part of the line's end.
            text = zlib.decompressobj().decompress(result.group(1))
        except zlib.error:
            continue
        if b"BT" in text:
            return [float(v) for v in box.split()], text.decode("latin-1")
    raise AssertionError("no page")


def get_texts(page: str) -> str:
    """Words that are written, without kerning; letters may be codes of two bytes."""
    messages = []
    for block in re.findall(r"\bBT\b(.*?)\bET\b", page, re.S):
        strings = re.findall(r"\(((?:\\.|[^()\\])*)\)", block, re.S)
        words = re.sub(r"\\(.)", r"\1", "".join(strings), flags=re.S)
        messages.append(words.replace("\x00", ""))
    return "\n".join(messages)


def lines_of(page: str) -> list[np.ndarray]:
    """Each stroked path (n, 2), points of the page."""
    result = []
    for path in re.findall(r"((?:[-\d.]+ [-\d.]+ [ml]\n)+)\s*S", page):
        result.append(np.array([[float(v) for v in row.split()[:2]] for row in path.splitlines()]))
    return result


def drawing(width: float = 20.0, height: float = 8.0) -> Drawing:
    trace = DrawingShape(
        "traces", np.array([[-7.0, -2.0], [0.0, 1.0], [6.0, 2.5]]), "#0072b2", label="B01 21°"
    )
    joint = DrawingShape("joints", np.array([[3.0, 0.0]]), "#009e73", label="J1 60°", dip_deg=60.0)
    bounds = np.array([[-width / 2, -height / 2], [width / 2, height / 2]])
    picture = np.full((40, 100, 4), (120, 110, 90, 255), np.uint8)
    return Drawing(
        (trace, joint), bounds, ("NW (315)", "SE (135)"), ("right (m)", "up (m)"), picture=picture
    )


def test_sheet_contains_text_as_text_and_lines_to_scale(tmp_path: Path) -> None:
    view = replace(
        view_along_line(45, 0),
        reason=Finding("view.chosen", description="along the axis of the fold"),
    )
    output = drawing()
    write_sheet(tmp_path / "s.pdf", output, view, "pdf")
    box, page = page_of(tmp_path / "s.pdf")
    words = get_texts(page)
    for messages in (
        "NW (315)",
        "SE (135)",
        "B01 21",
        "J1 60",
        "right (m)",
        "up (m)",
        "1 : 100",
        "along the axis of the fold",
        "045.0/0.0",
    ):
        assert messages in words, words
    scale = paper_scale(output.bounds)
    assert scale == 100
    # The trace, in millimetres of paper between its points, by the scale that the sheet states.
    expected = np.diff(output.shapes[0].points, axis=0) * 1000.0 / scale * MM
    assert any(
        len(line) == 3 and np.allclose(np.diff(line, axis=0), expected, atol=0.02)
        for line in lines_of(page)
    )
    # Twenty metres at 1 : 100 are twenty centimetres of paper and the margins.
    assert box[2] / MM == pytest.approx(236.0, abs=0.1)


def test_sheet_gives_no_reason_for_a_direction_that_was_given(tmp_path: Path) -> None:
    given = replace(view_along_line(45, 0), reason=Finding("view.as-given"))
    write_sheet(tmp_path / "s.pdf", drawing(), given, "pdf")
    words = get_texts(page_of(tmp_path / "s.pdf")[1])
    assert "045.0/0.0" in words
    assert given.reason.message not in words
    assert "view.as-given" not in shown_codes(words)


def test_scale_bar_has_its_stated_length(tmp_path: Path) -> None:
    write_sheet(tmp_path / "s.pdf", drawing(), view_along_line(45, 0), "pdf")
    _, page = page_of(tmp_path / "s.pdf")
    assert "5 m, 1 : 100" in get_texts(page)
    rows = re.findall(r"([-\d.]+) ([-\d.]+) m\n([-\d.]+) \2 l\n\3 ", page)
    widths = {round((float(b) - float(a)) / MM, 2) for a, _, b in rows}
    assert 25.0 in widths


def test_narrow_picture_and_unknown_scale_are_described_in_full(tmp_path: Path) -> None:
    view = replace(
        view_along_line(45, 0),
        is_north_known=False,
        is_metric=False,
        reason=Finding("view.chosen", description="x " * 300),
    )
    narrow = replace(drawing(0.5, 8.0), shapes=(), is_metric=False)
    write_sheet(tmp_path / "s.pdf", narrow, view, "pdf")
    box, page = page_of(tmp_path / "s.pdf")
    words = get_texts(page)
    assert unknown_direction_text(view) in words
    assert "1 :" not in words
    assert box[2] / MM == pytest.approx(166.0, abs=0.1)


def test_labels_do_not_overlap_and_distant_ones_have_leader_lines() -> None:
    """Twelve planes at one place: some find room beside it, some at the end of a line, the others
    have no label."""
    at = np.array([[0.0, 0.0]])
    many = tuple(
        DrawingShape("j", at + 0.01 * i, label=f"J{i:02d} 30°", dip_deg=30.0) for i in range(40)
    )
    output = replace(drawing(), shapes=many)
    placed = place_labels(output, 100.0, 2.6)
    assert 4 <= len(placed) < 40
    wide, tall = 0.001 * 100.0 * 2.6 * 0.5 * 7, 0.001 * 100.0 * 2.6
    boxes = [(p.x - wide if p.is_on_right else p.x, p.y - tall / 2) for p in placed]
    for (x, y), (u, v) in combinations(boxes, 2):
        assert abs(x - u) >= wide or abs(y - v) >= tall - 1e-9
    for p in placed:
        near = abs(p.y - p.anchor[1]) < 0.001 * 100.0 * 5.0
        assert p.is_separate != near


def middles(dark: np.ndarray) -> np.ndarray:
    """(k,) of the runs of dark pixels in a row or column (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], dark.astype(int), [0]])))
    return edges.reshape(-1, 2).mean(axis=1)


def longest_run(dark: np.ndarray) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], dark.astype(int), [0]])))
    return int(np.diff(edges)[::2].max(initial=0))


def frame_of(dark: np.ndarray) -> tuple[float, float, float, float]:
    """Left, top, right and bottom of the page's largest rectangle, pixels."""
    rows = np.array([longest_run(row) for row in dark])
    columns = np.array([longest_run(column) for column in dark.T])
    y, x = (middles(runs > 0.95 * runs.max()) for runs in (rows, columns))
    return x[0], y[0], x[-1], y[-1]


@pytest.mark.parametrize(
    ("ending", "width", "height"),
    first_in_default_tier(
        [
            ("png", 20.0, 8.0),
            ("jpg", 20.0, 8.0),
            ("jpeg", 3.0, 1.9),
            ("png", 8.0, 31.0),
            ("png", 2600.0, 900.0),
        ],
        2,
    ),
)
def test_picture_ticks_match_the_stated_scale(
    tmp_path: Path, ending: str, width: float, height: float
) -> None:
    """By the resolution that the file tells a printer."""
    bounds = np.array([[0.0, 0.0], [width, height]])
    output = replace(drawing(), shapes=(), picture=None, bounds=bounds)
    path = tmp_path / f"s.{ending}"
    write_sheet(path, output, view_along_line(45, 0), format_from_path(path))
    with Image.open(path) as page:
        assert page.format == {"png": "PNG"}.get(ending, "JPEG")
        dpi = page.info["dpi"]
        dark = np.asarray(page.convert("L")) < 128
    assert dpi == pytest.approx((300.0, 300.0), abs=0.01)
    scale = paper_scale(bounds)
    metre = 1000.0 / scale / 25.4 * 300.0
    left, top, right, bottom = frame_of(dark)
    assert (right - left, bottom - top) == pytest.approx((width * metre, height * metre), abs=1.5)
    x, y = round(left) - 3, round(bottom) + 3
    across = middles(dark[y + 5, x : round(right) + 3]) + x - left
    above = round(top) - 3
    up = bottom - above - middles(dark[above:y, x - 5])[::-1]
    for ticks, start, end in ((across, 0.0, width), (up, 0.0, height)):
        metres = ticks / metre
        step = np.diff(metres).mean()
        round_ = float(f"{step:.0e}")
        assert len(ticks) >= 3
        assert f"{round_:e}"[0] in "1245"
        expected = np.arange(start, end * (1 + 1e-9), round_)
        assert ticks == pytest.approx(expected * metre, abs=1.5)


@pytest.mark.parametrize("ending", first_in_default_tier(["png", "jpg"]))
def test_interpretation_in_a_picture_matches_the_ticks(tmp_path: Path, ending: str) -> None:
    output = drawing()
    path = tmp_path / f"s.{ending}"
    write_sheet(path, output, view_along_line(45, 0), format_from_path(path))
    with Image.open(path) as page:
        seen = np.asarray(page.convert("RGB")).astype(int)
    left, _, _, bottom = frame_of(seen.sum(axis=2) < 200)
    metre = 1000.0 / paper_scale(output.bounds) / 25.4 * 300.0
    low = output.bounds[0]

    def off(point: np.ndarray, color: tuple[int, int, int]) -> int:
        """Of the pixel there, or of a neighbour: the frame is found to the nearest pixel only."""
        x, y = (point - low) * metre
        row, column = round(bottom - y), round(left + x)
        around = seen[row - 1 : row + 2, column - 1 : column + 2]
        return int(np.abs(around - color).max(axis=2).min())

    trace = output.shapes[0].points
    for share in (0.02, 0.3, 0.8):
        for a, b in itertools.pairwise(trace):
            assert off(a + share * (b - a), (0x00, 0x72, 0xB2)) < 40
    # The picture fills the frame, in its own colour.
    for corner in ((-9.8, -3.8), (9.8, 3.8), (-9.8, 3.8), (9.8, -3.8)):
        assert off(np.array(corner), (120, 110, 90)) < 6


@pytest.mark.full
def test_pixel_page_is_no_larger_than_paper_for_any_picture_size(
    tmp_path: Path,
) -> None:
    """A quarter of a metre and its margins."""
    for size in (1e-3, 1.0, 1e5):
        bounds = np.array([[0.0, 0.0], [size, size]])
        output = replace(drawing(), shapes=(), bounds=bounds)
        write_sheet(tmp_path / "s.png", output, view_along_line(45, 0), "png")
        with Image.open(tmp_path / "s.png") as page:
            assert max(page.size) < (250.0 + 75.0) / 25.4 * 300.0


def test_tick_labels_of_a_narrow_picture_do_not_overlap(tmp_path: Path) -> None:
    narrow = replace(drawing(0.5, 8.0), shapes=())
    write_sheet(tmp_path / "s.png", narrow, view_along_line(45, 0), "png")
    with Image.open(tmp_path / "s.png") as page:
        dark = np.asarray(page.convert("L")) < 128
    left, _, right, bottom = frame_of(dark)
    ticks = middles(dark[round(bottom) + 8, round(left) - 3 : round(right) + 3])
    assert (np.diff(ticks) > 3.0 / 25.4 * 300.0).all()


def test_suffix_determines_the_format() -> None:
    for name, format_ in (
        ("a.PNG", "png"),
        ("a.jpg", "jpeg"),
        ("a.jpeg", "jpeg"),
        ("a.pdf", "pdf"),
    ):
        assert format_from_path(name) == format_
    with refused("output.unknown-format", UsageError, field="--sheet", suffix=".gif"):
        format_from_path("a.gif")


def key_drawing() -> Drawing:
    """Two types, one of them as a line, an outline and a place; a rock; and what has no type."""
    ring = np.array([[-4.0, -3.0], [-2.0, -3.0], [-3.0, -1.0]])
    typed = {"values": {"kind": "bedding"}}
    joint = {"values": {"kind": "joint $J_1$"}}
    shapes = (
        DrawingShape("traces", np.array([[-7.0, -2.0], [6.0, 2.5]]), "#0072b2", **typed),
        DrawingShape("patches", ring, "#0072b2", is_closed=True, **typed),
        DrawingShape("planes", np.array([[1.0, 1.0]]), "#0072b2", dip_deg=20.0, **typed),
        DrawingShape("planes", np.array([[3.0, 0.0]]), "#009e73", dip_deg=60.0, **joint),
        DrawingShape(
            "lithologies",
            ring + 3,
            "#eec58b",
            is_closed=True,
            is_filled=True,
            values={"kind": "sandstone"},
        ),
        DrawingShape(
            "known_lines", np.array([[0.0, 0.0], [1.0, 0.0]]), "#cc79a7", values={"kind": ""}
        ),
    )
    return replace(drawing(), shapes=shapes)


def test_legend_lists_each_type_once_with_its_symbols(tmp_path: Path) -> None:
    result = {entry.name: entry for entry in create_entries(key_drawing().shapes)}
    assert list(result) == ["bedding", "joint $J_1$", "sandstone", "known lines"]
    bed, joint = result["bedding"], result["joint $J_1$"]
    assert (bed.line, bed.area, bed.place, bed.is_filled) == (True, True, True, False)
    assert (joint.line, joint.area, joint.place) == (False, False, True)
    assert result["sandstone"].is_filled
    write_sheet(tmp_path / "s.pdf", key_drawing(), view_along_line(45, 0), "pdf")
    box, page = page_of(tmp_path / "s.pdf")
    words = get_texts(page)
    for messages in (*result, "Ticks at points: planes with their apparent dips"):
        assert messages in words
    write_sheet(tmp_path / "n.pdf", key_drawing(), view_along_line(45, 0), "pdf", legend=False)
    without, page = page_of(tmp_path / "n.pdf")
    assert "sandstone" not in get_texts(page)
    # The page grows by the legend; nothing that is to scale moves.
    assert box[3] > without[3]
    assert box[2] == without[2]


def test_a_legend_of_many_long_names_stays_on_the_page(tmp_path: Path) -> None:
    many = tuple(
        DrawingShape(
            "traces",
            np.array([[0.0, 0.0], [1.0, k / 10]]),
            f"#0000{k:02x}",
            values={"kind": f"type {k} " + "with a long name " * (k % 5)},
        )
        for k in range(30)
    )
    output = replace(drawing(2.0, 8.0), shapes=many)
    write_sheet(tmp_path / "s.pdf", output, view_along_line(45, 0), "pdf")
    box, page = page_of(tmp_path / "s.pdf")
    words = get_texts(page)
    assert all(f"type {k} " in words for k in range(30))
    places = [(float(x), float(y)) for x, y in re.findall(r"1 0 0 1 ([-\d.]+) ([-\d.]+) Tm", page)]
    assert all(0 < x < box[2] for x, _ in places)
    assert all(0 < y < box[3] for _, y in places)


def test_label_avoids_covering_other_points_if_possible() -> None:
    """Beside a point to the right there is no other; else the label goes there, or further off."""
    first = np.array([[0.0, 0.0]])
    for beside in ([0.6, 0.2], [0.6, -0.2], [-0.6, 0.2]):
        other = DrawingShape("j", np.array([beside]))
        named = DrawingShape("j", first, label="J1 30°", dip_deg=30.0)
        (placed,) = place_labels(replace(drawing(), shapes=(named, other)), 100.0, 2.6)
        wide, tall = 0.001 * 100.0 * 2.6 * 0.58 * 7, 0.001 * 100.0 * 2.6 * 1.25
        left = placed.x - wide if placed.is_on_right else placed.x
        inside = left < beside[0] < left + wide and abs(placed.y - beside[1]) < tall / 2
        assert not inside
        assert not placed.is_separate
    # Where points are everywhere it is written all the same.
    g = np.linspace(-3.0, 3.0, 200)
    crowd = tuple(DrawingShape("j", np.array([[a, b]])) for a in g[::4] for b in g[::4])
    (placed,) = place_labels(replace(drawing(), shapes=(named, *crowd)), 100.0, 2.6)
    assert placed.shape is named
