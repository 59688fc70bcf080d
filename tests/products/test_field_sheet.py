"""The field sheet says and draws the plan's own numbers."""

from __future__ import annotations

import re
import zlib
from dataclasses import replace
from html import escape
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.quiver import Quiver
from matplotlib.transforms import Bbox

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.photogrammetry.survey.plan_camera import PlanCamera
from vomstudio.photogrammetry.survey.planning import Manner, SurveyPlan, plan_survey
from vomstudio.photogrammetry.survey.survey_options import PlanOptions
from vomstudio.products.report.field_sheet import (
    CONTROL_COLOR,
    OBLIQUE_COLOR,
    PERPENDICULAR_COLOR,
    TITLE,
    draw_field_sheet,
    figures,
    write_field_sheet,
)

APSC = PlanCamera("test <one>", 24.0, 16.0, 24.0, 6000, 4000)


@pytest.fixture(scope="module")
def plan() -> SurveyPlan:
    return plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0))


def test_figures_have_units(plan: SurveyPlan) -> None:
    """24 mm on 24 mm of 6000 pixels see as much across as they are away: 3.33 mm a pixel."""
    messages = dict(figures(plan))
    assert messages["Camera"] == "test <one>, 6000 x 4000"
    assert messages["Lens"].startswith("24 mm")
    assert messages["Outcrop"] == "30 x 10 m"
    assert messages["Distance"] == "20 m"
    assert messages["Pixel size (GSD)"] == "3.33 mm"
    # A tenth of the textbook's limit: half a resolution of 33 mm over 0.866 times that.
    assert messages["Plane size, error"] == "33 cm ± 3.3°, 3.3 m (1000 px) ± 0.3°"
    assert messages["Footprint"] == "20 x 13.3 m"
    assert messages["Spacing"] == "6 m along, 4 m up"
    assert messages["Overlap"] == "70 %"
    straight, oblique = len(plan.select_kind("perpendicular")), len(plan.select_kind("oblique"))
    assert messages["Photos"] == (
        f"{straight + oblique}: {straight} perpendicular, {oblique} oblique"
    )
    assert messages["Photos per point"].startswith(f"{plan.views_least} or more, ")
    near, far = plan.depth_of_field_m
    assert messages["Sharp at f/8"] == f"{near:.3g} m to " + (
        "infinity" if far is None else f"{far:.3g} m"
    )


def cells(html: str, heading: str) -> list[list[str]]:
    table = html.split(f"<h2>{heading}</h2>")[1].split("</table>")[0]
    rows = re.findall(r"<tr>(.*?)</tr>", table)
    return [re.findall(r"<t[hd]>(.*?)</t[hd]>", row) for row in rows]


def test_the_page_lists_every_position_and_point(plan: SurveyPlan, tmp_path: Path) -> None:
    write_field_sheet(tmp_path / "a.html", plan)
    html = (tmp_path / "a.html").read_text("utf-8")
    head, *rows = cells(html, "Positions")
    assert head == ["photo", "kind", "along, m", "up, m", "away, m", "turn, °", "tilt, °"]
    assert len(rows) == len(plan.positions)
    for row, s in zip(rows, plan.positions, strict=True):
        places = [f"{v:.2f}" for v in (s.along_m, s.up_m, s.away_m)]
        assert row == [str(s.number), s.kind, *places, f"{s.turn_deg:+.0f}", f"{s.tilt_deg:+.0f}"]
    head, *rows = cells(html, "Control points")
    assert rows == [
        [p.label, p.use, f"{p.along_m:.2f}", f"{p.up_m:.2f}"] for p in plan.control_points
    ]
    assert escape("test <one>") in html
    assert f" {100 * plan.target_size_m:.2g} cm " in html
    assert "<li>Date ____" in html


@pytest.mark.parametrize("manner", ["handheld", "terrain"])
def test_drawings_show_positions_at_their_coordinates(manner: Manner) -> None:
    plan = plan_survey(
        APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0, manner=manner)
    )
    front, above = draw_field_sheet(plan, has_only_drawings=True).axes
    for axes, height in ((front, "up_m"), (above, "away_m")):
        lines = {str(line.get_label()): line for line in axes.lines}
        arrows = [c for c in axes.collections if isinstance(c, Quiver)]
        for kind, arrow in zip(("perpendicular", "oblique"), arrows, strict=True):
            some = plan.select_kind(kind)  # type: ignore[arg-type]
            line = lines[f"{kind}: {len(some)}"]
            assert np.array_equal(line.get_xdata(), [s.along_m for s in some])
            assert np.array_equal(line.get_ydata(), [getattr(s, height) for s in some])
            # Arrows point to what is aimed at.
            across = np.array([s.target_along_m - s.along_m for s in some])
            toward = [s.target_up_m - s.up_m if height == "up_m" else -s.away_m for s in some]
            assert (arrow.angles, arrow.scale_units) == ("xy", "xy")
            assert np.asarray(arrow.U) / arrow.scale == pytest.approx(0.12 * across)
            assert np.asarray(arrow.V) / arrow.scale == pytest.approx(0.12 * np.array(toward))
    boxes = [p for p in front.patches if isinstance(p, Rectangle)]
    assert (boxes[0].get_xy(), boxes[0].get_width(), boxes[0].get_height()) == ((0, 0), 30, 10)
    first, (w, h) = plan.select_kind("perpendicular")[0], plan.footprint_m
    assert boxes[1].get_width() == w
    assert boxes[1].get_height() == h
    assert boxes[1].get_center() == pytest.approx((first.along_m, first.up_m))
    assert not boxes[1].get_fill(), "it would hide the outcrop"
    marked = {
        (line.get_xdata()[0], line.get_ydata()[0]): line.get_fillstyle()
        for line in front.lines
        if len(line.get_xdata()) == 1 and line.get_marker() == "s"
    }
    for point in plan.control_points:
        filled = "full" if point.use == "control" else "none"
        assert marked[point.along_m, point.up_m] == filled
    assert [t.get_text() for t in front.texts] == [p.label for p in plan.control_points]
    (ground,) = above.patches
    assert ground.get_height() == pytest.approx(0.4)
    assert ground.get_y() == pytest.approx(-0.4)
    flat = manner == "terrain"
    assert front.get_ylabel() == ("across, m\n(from above)" if flat else "up, m\n(from the front)")
    assert above.get_ylabel() == (
        "above the ground, m\n(from the side)" if flat else "away from the rock, m\n(from above)"
    )


@pytest.mark.parametrize("ending", first_in_default_tier(["pdf", "svg", "html"]))
def test_sheet_has_no_creation_date_and_is_overwritten_only_with_force(
    plan: SurveyPlan, tmp_path: Path, ending: str
) -> None:
    from vomstudio.core.errors import TargetError

    path = tmp_path / f"sheet.{ending}"
    write_field_sheet(path, plan)
    with pytest.raises(TargetError):
        write_field_sheet(path, plan)
    write_field_sheet(path, plan, force=True)
    assert b"CreationDate" not in path.read_bytes()
    assert b"<dc:date>" not in path.read_bytes()


def test_texts_of_a_sheet_are_aligned_in_columns(plan: SurveyPlan) -> None:
    figure = draw_field_sheet(plan)
    figure.draw_without_rendering()
    boxes = {t.get_text(): t.get_window_extent() for t in figure.texts}
    for name, value in figures(plan):
        assert boxes[name].x1 < boxes[value].x0
        assert boxes[name].y1 == pytest.approx(boxes[value].y1, abs=2.0)
    order = list(boxes.values())
    for i, one in enumerate(order):
        for other in order[i + 1 :]:
            assert not one.overlaps(other)
    front, above = (axes.get_position() for axes in figure.axes)
    assert above.y1 < front.y0
    assert boxes[TITLE].y0 > front.y1 * figure.bbox.height


PAPER = [(30.0, 10.0), (8.0, 25.0), (200.0, 12.0)]


def in_mm(figure: Figure, box: Bbox) -> np.ndarray:
    """Left, lower, right and upper edge from the lower left corner of the paper."""
    return 25.4 / figure.dpi * box.extents


def around(axes: Axes) -> Bbox:
    """With its numbers, its words and its legend."""
    box = axes.get_tightbbox()
    assert box is not None
    return Bbox.union([box])


@pytest.mark.parametrize("manner", first_in_default_tier(["handheld", "terrain"], 2))
@pytest.mark.parametrize(("width", "height"), first_in_default_tier(PAPER, 2))
def test_sheet_fits_the_paper_and_the_drawings_fill_their_space(
    manner: str, width: float, height: float
) -> None:
    """Printers leave some 5 mm of an A4 page white. Words, drawings and reminders follow each other
    with white of one or two lines between them."""
    plan = plan_survey(
        APSC, PlanOptions(width_m=width, height_m=height, distance_m=20.0, manner=manner)
    )
    figure = draw_field_sheet(plan)
    figure.draw_without_rendering()
    assert (figure.get_size_inches() * 25.4).tolist() == pytest.approx([210, 297], abs=1)
    words = {t.get_text(): in_mm(figure, t.get_window_extent()) for t in figure.texts}
    drawings = [in_mm(figure, around(axes)) for axes in figure.axes]
    for box in [*words.values(), *drawings]:
        assert box.min() > 5.0
        assert box[2] < 205.0
        assert box[3] < 292.0
    starts = [
        box[0] for text, box in words.items() if text.startswith(("-", "!", "Date", "Photo "))
    ]
    starts += [words[name][0] for name, _ in figures(plan)[::2]]
    assert np.ptp(starts) < 1.0
    for box in drawings:
        assert box[0] < 12.0
        assert box[2] > 198.0
    above = np.array([box for box in words.values() if box[1] > 200.0])
    below = np.array([box for box in words.values() if box[3] < 100.0])
    assert len(above) + len(below) == len(words)
    edges = [above[:, 1].min(), *(v for b in drawings for v in (b[3], b[1])), below[:, 3].max()]
    white = np.array(edges[::2]) - edges[1::2]
    assert white.min() > 3.9
    assert white.max() < 9.0
    title = words["Photo survey: field sheet"]
    assert 297.0 - title[3] < 15.0
    rest = above[above[:, 3] < title[1]]
    assert len(rest) == len(above) - 1
    assert title[1] - rest[:, 3].max() < 9.0
    for axes in figure.axes:
        # Of the tighter direction 4 % stay free at either end, and a metre is a metre both ways.
        data = axes.dataLim
        low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
        used = (data.max - data.min) / (high - low)
        assert used.max() == pytest.approx(1.0 / 1.08, rel=2e-3)
        pixels = axes.transData.transform([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
        assert pixels[1, 0] - pixels[0, 0] == pytest.approx(pixels[2, 1] - pixels[0, 1])
    front, overhead = (in_mm(figure, axes.get_window_extent()) for axes in figure.axes)
    assert front[::2] == pytest.approx(overhead[::2])
    assert front[3] - front[1] == pytest.approx(overhead[3] - overhead[1])


@pytest.mark.parametrize(("width", "height"), first_in_default_tier(PAPER))
@pytest.mark.parametrize("pictures_only", first_in_default_tier([False, True]))
def test_texts_are_readable_and_symbols_distinguishable(
    width: float, height: float, pictures_only: bool
) -> None:
    """Words of a drawing are no larger than those of the sheet; signs are one to two millimetres
    wide, lines finer than they, and the point's name stands beside its sign."""
    plan = plan_survey(APSC, PlanOptions(width_m=width, height_m=height, distance_m=20.0))
    figure = draw_field_sheet(plan, has_only_drawings=pictures_only)
    figure.draw_without_rendering()
    largest = 9.0
    if not pictures_only:
        sizes = {t.get_text(): float(t.get_fontsize()) for t in figure.texts}
        for name, value in figures(plan):
            assert sizes[name] == sizes[value]
        title = sizes.pop("Photo survey: field sheet")
        assert min(sizes.values()) >= 8.0, "it is read in the field"
        largest = max(sizes.values())
        assert largest <= 12.0 < title <= 20.0
    front, above = figure.axes
    legend = front.get_legend()
    assert legend is not None
    for axes in (front, above):
        own = [axes.xaxis.label, axes.yaxis.label, *axes.texts]
        own += [*axes.get_xticklabels(), *axes.get_yticklabels(), *legend.get_texts()]
        assert all(7.0 <= t.get_fontsize() <= largest for t in own if t.get_text())
        for line in axes.lines:
            assert 1.0 < line.get_markersize() * 25.4 / 72.0 < 2.0
        for patch in axes.patches:
            assert 0.6 < patch.get_linewidth() < 1.5
        for arrow in axes.collections:
            assert isinstance(arrow, Quiver)
            shaft = float(arrow.width) * axes.get_window_extent().width * 25.4 / figure.dpi
            assert 0.2 < shaft < 0.5
    assert not legend.get_frame_on()
    box, room = legend.get_window_extent(), front.get_window_extent()
    assert (box.x0 + box.x1) / 2 == pytest.approx((room.x0 + room.x1) / 2, abs=1.0)
    assert 0.0 < box.y0 - room.y1 < box.height < 6.0 * figure.dpi / 25.4
    points = {p.label: p for p in plan.control_points}
    letter = 7.0 / 72.0 * figure.dpi
    for text in front.texts:
        p = points[text.get_text()]
        at = front.transData.transform((p.along_m, p.up_m))
        own = text.get_window_extent()
        away = np.array([own.x0, own.y0]) - at - 2.5 / 72.0 * figure.dpi
        assert away[0] > 0.0
        assert -0.2 * letter < away[1]
        assert away.max() < 0.5 * letter


def test_sheet_has_space_for_all_warnings_of_a_plan(plan: SurveyPlan) -> None:
    """Four warnings at once, each of two lines."""
    long = (
        "put some before or beside it, and take photos of those too, as far as there is room; " * 2
    )
    figure = draw_field_sheet(replace(plan, warnings=(long[:170],) * 4))
    figure.draw_without_rendering()
    boxes = [in_mm(figure, text.get_window_extent()) for text in figure.texts]
    assert sum(box[3] < 100.0 for box in boxes) >= 15
    assert min(box[1] for box in boxes) > 5.0
    for i, one in enumerate(figure.texts):
        for other in figure.texts[i + 1 :]:
            assert not one.get_window_extent().overlaps(other.get_window_extent())


def test_figure_of_an_html_sheet_contains_only_the_drawings(plan: SurveyPlan) -> None:
    figure = draw_field_sheet(plan, has_only_drawings=True)
    figure.draw_without_rendering()
    assert not figure.texts
    assert figure.get_size_inches().tolist() == [8.27, 6.0]
    front, above = (in_mm(figure, around(axes)) for axes in figure.axes)
    high = 6.0 * 25.4
    for white in (high - front[3], front[1] - above[3], above[1]):
        assert 1.0 < white < 9.0
    for box in (front, above):
        assert 0.0 < box[0] < 12.0
        assert 0.0 < 210.0 - box[2] < 12.0


@pytest.mark.parametrize("ending", ["pdf", "svg", "html"])
def test_sheet_of_each_format_opens_and_contains_its_drawings(
    plan: SurveyPlan, tmp_path: Path, ending: str
) -> None:
    path = tmp_path / f"sheet.{ending.upper()}"
    write_field_sheet(path, plan)
    data = path.read_bytes()
    if ending == "pdf":
        assert data.startswith(b"%PDF-")
        assert data.rstrip().endswith(b"%%EOF")
        (box,) = re.findall(rb"/MediaBox \[ ([^]]*) \]", data)
        assert [float(v) for v in box.split()] == pytest.approx([0, 0, 595, 842], abs=1.0)
        parts = re.findall(rb"/FlateDecode.*?stream\r?\n(.*?)\r?\nendstream", data, re.DOTALL)
        drawn = b"".join(zlib.decompressobj().decompress(part) for part in parts)
        # Operators of the page: words, and lines that are stroked.
        assert drawn.count(b" Tf") > 30
        assert drawn.count(b"\nS\n") + drawn.count(b"\nB\n") > 30
        return
    text = data.decode("utf-8")
    if ending == "html":
        assert text.rstrip().endswith("</html>")
        (text,) = re.findall(r"<svg.*</svg>", text, re.DOTALL)
    root = ElementTree.fromstring(text)
    high = 842.0 if ending == "svg" else 432.0
    size = [float(str(root.get(name)).removesuffix("pt")) for name in ("width", "height")]
    assert size == pytest.approx([595.0, high], abs=1.0)
    name = "{http://www.w3.org/2000/svg}g"
    groups = {str(g.get("id")) for g in root.iter(name)}
    assert {"axes_1", "axes_2", "legend_1", "Quiver_1"} <= groups


@pytest.mark.parametrize("n", [1, 399, 400, 401])
def test_view_directions_are_drawn_for_up_to_400_photos(plan: SurveyPlan, n: int) -> None:
    """And a kind of photo that is not taken is not in the legend."""
    first = plan.select_kind("perpendicular")[0]
    front, above = draw_field_sheet(
        replace(plan, positions=(first,) * n), has_only_drawings=True
    ).axes
    for axes in (front, above):
        assert sum(isinstance(c, Quiver) for c in axes.collections) == (n <= 400)
    legend = front.get_legend()
    assert legend is not None
    messages = [text.get_text() for text in legend.get_texts()]
    assert messages == [f"perpendicular: {n}", "control point", "check point"]


@pytest.mark.parametrize(("length", "lines"), [(107, 1), (108, 2)])
def test_lines_of_a_sheet_have_at_most_112_characters(
    plan: SurveyPlan, length: int, lines: int
) -> None:
    warning = "a" * length + " b."
    figure = draw_field_sheet(replace(plan, warnings=(warning,)))
    (at,) = [i for i, text in enumerate(figure.texts) if text.get_text().startswith("! ")]
    messages = [figure.texts[at + k].get_text() for k in range(lines)]
    assert " ".join(messages) == f"! {warning}"
    assert figure.texts[at + lines].get_text().startswith("- ")


@pytest.mark.parametrize("name", ["a.txt", "a", "a.png"])
def test_unsupported_sheet_suffix_is_rejected(plan: SurveyPlan, tmp_path: Path, name: str) -> None:
    from vomstudio.core.errors import UsageError

    with refused(
        "output.unknown-format",
        UsageError,
        field="--output",
        suffix=Path(name).suffix,
        formats=(".pdf", ".svg", ".html"),
    ):
        write_field_sheet(tmp_path / name, plan)
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize("manner", ["handheld", "terrain"])
def test_legend_explains_every_symbol_of_the_drawing(manner: Manner) -> None:
    plan = plan_survey(
        APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0, manner=manner)
    )
    front, above = draw_field_sheet(plan).axes
    legend = front.get_legend()
    assert legend is not None
    assert above.get_legend() is None
    straight, oblique = (len(plan.select_kind(kind)) for kind in ("perpendicular", "oblique"))  # type: ignore[arg-type]
    messages = {
        text.get_text(): handle
        for text, handle in zip(legend.get_texts(), legend.legend_handles, strict=True)
    }
    signs = {
        f"perpendicular: {straight}": ("o", PERPENDICULAR_COLOR, "full"),
        f"oblique: {oblique}": ("^", OBLIQUE_COLOR, "full"),
        "control point": ("s", CONTROL_COLOR, "full"),
        "check point": ("s", CONTROL_COLOR, "none"),
    }
    assert list(messages) == list(signs)
    for name, sign in signs.items():
        handle = messages[name]
        assert isinstance(handle, Line2D)
        assert (handle.get_marker(), handle.get_color(), handle.get_fillstyle()) == sign
    assert above.get_xlabel().endswith(", m")
    assert front.get_xlabel() == ""


def test_view_directions_of_very_many_photos_are_omitted() -> None:
    many = plan_survey(APSC, PlanOptions(width_m=400.0, height_m=40.0, distance_m=12.0))
    few = plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0))
    for plan in (many, few):
        expected = sum(
            0 < len(plan.select_kind(kind)) <= 400
            for kind in ("perpendicular", "oblique")  # type: ignore[arg-type]
        )
        for axes in draw_field_sheet(plan, has_only_drawings=True).axes:
            assert sum(isinstance(c, Quiver) for c in axes.collections) == expected
    assert len(many.select_kind("perpendicular")) > 400


@pytest.mark.parametrize("ending", first_in_default_tier(["pdf", "svg", "html"]))
def test_the_same_plan_gives_the_same_file(plan: SurveyPlan, tmp_path: Path, ending: str) -> None:
    one, other = tmp_path / f"one.{ending}", tmp_path / f"other.{ending}"
    write_field_sheet(one, plan)
    write_field_sheet(other, plan)
    assert one.read_bytes() == other.read_bytes()


def test_continuation_lines_of_reminders_are_indented(plan: SurveyPlan) -> None:
    figure = draw_field_sheet(plan)
    lines = [t for t in figure.texts if t.get_position()[1] < 0.3]
    heights = [t.get_position()[1] for t in lines]
    assert heights == sorted(heights, reverse=True)
    for before, text in zip([None, *lines[:-1]], lines, strict=True):
        x, y = text.get_position()
        begins = text.get_text().startswith(("- ", "! ", "Date "))
        assert x == (0.07 if begins else 0.09)
        if before is not None:
            step = 0.0138 + (0.003 if begins else 0.0)
            assert before.get_position()[1] - y == pytest.approx(step)
        assert len(text.get_text()) <= 112
    assert sum(x.get_position()[0] == 0.09 for x in lines) > 0
