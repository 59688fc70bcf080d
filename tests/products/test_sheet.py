"""The sheet of an orthophoto: nothing covers anything else, and its bar is as long as it says."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw

from vomstudio.errors import UsageError
from vomstudio.products.ortho.sheet import (
    bar_length,
    direction_in_words,
    draw_sheet,
    end_labels,
    format_of,
)
from vomstudio.products.ortho.view_directions import view_along_line

Box = tuple[float, float, float, float]


@dataclass
class Drawn:
    """Boxes of what was drawn, in pixels: left, top, right, bottom."""

    texts: dict[str, Box] = field(default_factory=dict)
    rectangles: list[Box] = field(default_factory=list)
    arrow: list[tuple[float, float]] = field(default_factory=list)
    shaft: list[tuple[float, float]] = field(default_factory=list)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Drawn:
    found = Drawn()
    kind = ImageDraw.ImageDraw
    plain = {name: getattr(kind, name) for name in ("text", "rectangle", "polygon", "line")}

    def text(self: Any, xy: Any, words: str, fill: Any, font: Any, anchor: Any = None) -> None:
        found.texts[words] = self.textbbox(xy, words, font=font, anchor=anchor)
        plain["text"](self, xy, words, fill, font, anchor=anchor)

    def rectangle(self: Any, xy: Any, *rest: Any, **more: Any) -> None:
        found.rectangles.append(tuple(xy))
        plain["rectangle"](self, xy, *rest, **more)

    def polygon(self: Any, xy: Any, *rest: Any, **more: Any) -> None:
        found.arrow = list(xy)
        plain["polygon"](self, xy, *rest, **more)

    def line(self: Any, xy: Any, *rest: Any, **more: Any) -> None:
        found.shaft = [tuple(xy[:2]), tuple(xy[2:])]
        plain["line"](self, xy, *rest, **more)

    for name, other in (("text", text), ("rectangle", rectangle), ("polygon", polygon),
                        ("line", line)):  # fmt: skip
        monkeypatch.setattr(kind, name, other)
    return found


def meet(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


LONG = (
    "the view is along the axis of the fold, which was measured on sixty planes of both limbs, and "
    "looks down it, since most of what is hit faces the viewer; seen from behind it would be a "
    "mirror image of what stands before whoever comes to the outcrop from the road below"
)


@pytest.mark.parametrize(
    ("width", "height", "enlarged"),
    [
        (700, 300, 1),
        (300, 900, 1),
        (2400, 1500, 1),
        (80, 40, 8),
        (5, 2, 128),
        (100, 900, 1),
        (9, 700, 1),
        (639, 20, 2),
        (640, 20, 1),
        (641, 20, 1),
        (20, 640, 1),
        (20, 639, 2),
        (213, 10, 4),
        (214, 10, 3),
    ],
)
def test_nothing_on_a_sheet_covers_anything_else(
    tmp_path: Path, drawn: Drawn, width: int, height: int, enlarged: int
) -> None:
    """A small picture is enlarged until its longer side has 640 pixels; one that is narrow has
    its words beside it, whole."""
    rgba = np.full((height, width, 4), (10, 120, 200, 255), np.uint8)
    view = replace(view_along_line(40, 20), reason=LONG, north_known=False, metric=False)
    view = replace(view, sense="against the upward normal")
    draw_sheet(tmp_path / "s.png", rgba, 0.01, view)
    sheet = Image.open(tmp_path / "s.png")
    frame, bar, half = drawn.rectangles
    # The picture lies within its frame, whole and in its own colour.
    assert (frame[2] - frame[0] - 1, frame[3] - frame[1]) == (
        width * enlarged,
        height * enlarged + 1,
    )
    border = min(8, (width * enlarged) // 3)
    inside = np.asarray(sheet)[
        int(frame[1]) + border : int(frame[3]) - border,
        int(frame[0]) + border : int(frame[2]) - border,
    ]
    assert inside.size
    assert (inside == (10, 120, 200)).all()
    assert frame[0] + frame[2] == pytest.approx(sheet.width, abs=2)
    arrow = np.array([*drawn.arrow, *drawn.shaft])
    arrow_box = (*arrow.min(axis=0), *arrow.max(axis=0))
    things = {**drawn.texts, "frame": frame, "bar": bar, "arrow": arrow_box}
    assert "Not registered: north and scale unknown" in things
    for name, box in things.items():
        assert box[0] >= 0, name
        assert box[1] >= 0, name
        assert box[2] <= sheet.width, name
        assert box[3] <= sheet.height, name
    for (one, a), (other, b) in combinations(things.items(), 2):
        assert not meet(a, b), (one, other)
    # What it says of the bar and of the ends stands by them.
    assert drawn.texts["0"][0] == pytest.approx(bar[0], abs=3)
    (length,) = [t for t in drawn.texts if t.endswith(" units")]
    middle = (drawn.texts[length][0] + drawn.texts[length][2]) / 2
    size = max(14, round(max(width, height) * enlarged / 70))
    left, right, up = end_labels(view)
    if width * enlarged >= 300:
        assert middle == pytest.approx(bar[2], abs=2)
        assert drawn.texts[left][0] == pytest.approx(frame[0], abs=4)
        assert drawn.texts[right][2] == pytest.approx(frame[2], abs=4)
    else:
        assert 0 <= middle - bar[2] < 4 * size
        assert 2 * size < frame[0] - drawn.texts[left][0] + width * enlarged / 2 < 10 * size
    ends = [drawn.texts[word] for word in (left, right)]
    assert ends[0][0] + ends[1][2] == pytest.approx(frame[0] + frame[2], abs=4)
    for end in ends:
        assert frame[1] - end[3] == pytest.approx(end[1], abs=0.6 * size)
    assert 0.25 * size < drawn.texts[up][0] - arrow_box[2] < 0.5 * size
    # An arrow points up, from the middle of its shaft.
    tip, *base = drawn.arrow
    assert tip[1] < min(y for _, y in base)
    assert {x for x, _ in drawn.shaft} == {tip[0]}
    assert (base[0][0] + base[1][0]) / 2 == tip[0]
    assert half[2] - half[0] == pytest.approx((bar[2] - bar[0]) / 2)
    lines = [
        box
        for text, box in drawn.texts.items()
        if text.startswith("View") or (len(text) > 5 and text in LONG)
    ]
    assert len(lines) >= 3
    assert [box[1] for box in lines] == sorted(box[1] for box in lines)
    assert np.ptp([box[0] for box in lines]) <= 3
    widest = max(box[2] - box[0] for box in lines)
    if bar[0] + widest + 2 * size <= sheet.width:
        assert max(abs(box[0] - bar[0]) for box in lines) <= 3
    else:
        assert sheet.width - max(box[2] for box in lines) == pytest.approx(2 * size, abs=3)
    # Words fill the width of the picture, and are no wider; a narrow one's, that of a small sheet.
    fullest = max(box[2] - box[0] for text, box in drawn.texts.items() if text in LONG)
    room = max(width * enlarged, 640)
    assert fullest <= room
    if room < 0.5 * size * len(LONG):
        assert fullest > 0.7 * room


@pytest.mark.parametrize(("width", "height"), [(700, 300), (300, 900), (2400, 1500)])
def test_a_sheet_has_a_margin_of_two_letters_all_round(
    tmp_path: Path, drawn: Drawn, width: int, height: int
) -> None:
    """Letters are a seventieth of the longer side high, and never so small as not to be read."""
    size = max(14, round(max(width, height) / 70))
    view = replace(view_along_line(40, 20), reason=LONG)
    draw_sheet(tmp_path / "s.png", np.full((height, width, 4), 200, np.uint8), 0.01, view)
    with Image.open(tmp_path / "s.png") as sheet:
        wide, high = sheet.size
    frame, bar, half = drawn.rectangles
    assert frame[0] + 1 >= 2 * size
    assert wide - frame[2] >= 2 * size
    if width >= 640:
        assert (frame[0] + 1, wide - frame[2]) == (2 * size, 2 * size)
    else:
        assert wide == 640 + 4 * size
    boxes = list(drawn.texts.values())
    assert min(box[1] for box in boxes) >= size
    assert 2 * size <= high - max(box[3] for box in boxes) <= 4 * size
    assert wide - max(box[2] for box in boxes) >= size
    # The picture, the bar and the words under each other, with room between.
    ends = [box for text, box in drawn.texts.items() if text in end_labels(view)]
    assert frame[1] - max(box[3] for box in ends) >= 0.3 * size
    assert bar[1] - frame[3] == size
    assert bar[3] - bar[1] == half[3] - half[1] == size // 3
    lines = sorted(
        box[1]
        for text, box in drawn.texts.items()
        if text.startswith("View") or (len(text) > 5 and text in LONG)
    )
    values = [box for text, box in drawn.texts.items() if text[0].isdigit() and len(text) < 9]
    assert len(values) == 2
    for box in values:
        assert 0.1 * size < box[1] - bar[3] < 0.8 * size
        assert 1.2 * size < lines[0] - box[3] < 2.6 * size
    assert np.diff(lines) == pytest.approx(np.full(len(lines) - 1, 1.5 * size), abs=0.35 * size)
    tip, *base = drawn.arrow
    assert base[1][0] - base[0][0] == 2 * (size // 3)
    assert base[0][1] - tip[1] == size // 2
    assert [y for _, y in drawn.shaft] == [tip[1] + size // 2, tip[1] + size + size // 3]


@pytest.mark.parametrize(
    "width_m", [0.03, 0.04, 0.08, 0.7, 4.0, 8.0, 12.0, 999.0, 4000.0, 8000.0, 50_000.0]
)
def test_the_bar_is_as_long_as_it_says(tmp_path: Path, drawn: Drawn, width_m: float) -> None:
    metres = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3}
    for width in (320, 1000):
        drawn.rectangles.clear()
        drawn.texts.clear()
        rgba = np.zeros((200, width, 4), np.uint8)
        draw_sheet(tmp_path / "s.png", rgba, width_m / width, view_along_line(40, 20))
        frame, bar, _ = drawn.rectangles
        (words,) = [t for t in drawn.texts if t.split()[-1] in metres and len(t) < 9]
        number, unit = words.split()
        share = (bar[2] - bar[0]) / (frame[2] - frame[0] - 1)
        assert share * width_m == pytest.approx(float(number) * metres[unit], rel=1e-6)
        # The largest unit of which there is at least one.
        assert float(number) >= 1.0
        larger = {"mm": 10.0, "cm": 100.0, "m": 1000.0, "km": np.inf}
        assert float(number) < larger[unit]


@pytest.mark.parametrize("power", range(-6, 7))
def test_a_bar_is_one_two_or_five_and_a_tenth_to_a_quarter_of_the_width(power: int) -> None:
    for first in (1.0, 1.7, 3.99, 4.0, 4.01, 7.99, 8.0, 8.01):
        width = first * 10.0**power
        length = bar_length(width)
        assert 0.1 * width <= length <= 0.25 * width * (1 + 1e-12)
        assert f"{length:.6e}"[0] in "125"
        assert float(f"{length:.0e}") == pytest.approx(length)


@pytest.mark.parametrize("trend", range(0, 360, 15))
def test_the_ends_of_a_picture_are_a_quarter_turn_from_the_view(trend: int) -> None:
    winds = ("N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE",
             "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW")  # fmt: skip
    view = view_along_line(trend, 10)
    for label, azimuth in zip(end_labels(view)[:2], (trend - 90, trend + 90), strict=True):
        wind, number = label.split()
        assert int(number.strip("()")) == azimuth % 360
        off = (winds.index(wind) * 22.5 - azimuth + 180) % 360 - 180
        assert abs(off) <= 11.25
    local = end_labels(replace(view, north_known=False))
    assert local == (f"{(trend - 90) % 360:03d}, local", f"{(trend + 90) % 360:03d}, local", "up")


def test_up_is_north_on_a_map_and_y_where_north_is_not_known() -> None:
    for plunge, words in ((90, "N"), (89.9, "N"), (-90, "N"), (89.8, "up"), (0, "up")):
        view = view_along_line(0, plunge)
        assert end_labels(view)[2] == words
        known = end_labels(replace(view, north_known=False))[2]
        assert known == ("y" if words == "N" else "up")


def test_the_view_in_words() -> None:
    assert direction_in_words(view_along_line(7.26, 12.34)).startswith("View toward 007.3/12.3 ")


def test_the_ending_says_the_format() -> None:
    for name, format_ in (
        ("a.PNG", "PNG"),
        ("a.jpg", "JPEG"),
        ("a.jpeg", "JPEG"),
        ("a.pdf", "PDF"),
    ):
        assert format_of(name) == format_
    with pytest.raises(UsageError, match=r"\.png, \.jpg or \.pdf") as caught:
        format_of("a.gif")
    assert caught.value.field == "--sheet"
