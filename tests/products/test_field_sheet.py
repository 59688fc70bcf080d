"""The field sheet says and draws the plan's own numbers."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.quiver import Quiver

from vomstudio.products.report.field_sheet import (
    CONTROL,
    OBLIQUE,
    PERPENDICULAR,
    draw_field_sheet,
    figures,
    write_field_sheet,
)
from vomstudio.survey.plan_camera import PlanCamera
from vomstudio.survey.planning import SurveyPlan, plan_survey

APSC = PlanCamera("test <one>", 24.0, 16.0, 24.0, 6000, 4000)


@pytest.fixture(scope="module")
def plan() -> SurveyPlan:
    return plan_survey(APSC, 30.0, 10.0, distance_m=20.0)


def test_figures_stand_with_their_units(plan: SurveyPlan) -> None:
    """24 mm on 24 mm of 6000 pixels see as much across as they are away: 3.33 mm a pixel."""
    said = dict(figures(plan))
    assert said["Camera"] == "test <one>, 6000 x 4000"
    assert said["Lens"].startswith("24 mm")
    assert said["Outcrop"] == "30 x 10 m"
    assert said["Distance"] == "20 m"
    assert said["Pixel on the rock"] == "3.33 mm"
    assert said["Smallest plane"] == "3.3 m across"
    assert said["Footprint"] == "20 x 13.3 m"
    assert said["Spacing"] == "6 m along, 4 m up"
    assert said["Overlap"] == "70%"
    straight, oblique = len(plan.of_kind("perpendicular")), len(plan.of_kind("oblique"))
    assert said["Photos"] == (f"{straight + oblique}: {straight} perpendicular, {oblique} oblique")
    assert said["Photos per place"].startswith(f"{plan.views_least} or more, ")
    near, far = plan.depth_of_field_m
    assert said["Sharp at f/8"] == f"{near:.3g} m to " + (
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
    assert head == ["photo", "kind", "along m", "up m", "away m", "turn deg", "tilt deg"]
    assert len(rows) == len(plan.stations)
    for row, s in zip(rows, plan.stations, strict=True):
        places = [f"{v:.2f}" for v in (s.along_m, s.up_m, s.away_m)]
        assert row == [str(s.number), s.kind, *places, f"{s.turn_deg:+.0f}", f"{s.tilt_deg:+.0f}"]
    head, *rows = cells(html, "Control points")
    assert rows == [
        [p.label, p.use, f"{p.along_m:.2f}", f"{p.up_m:.2f}"] for p in plan.control_points
    ]
    assert "test &lt;one&gt;" in html
    assert f"targets of {100 * plan.target_size_m:.2g} cm or more" in html
    assert "<li>Date ____" in html


@pytest.mark.parametrize("manner", ["handheld", "terrain"])
def test_the_drawings_show_positions_where_they_are(manner: str) -> None:
    plan = plan_survey(APSC, 30.0, 10.0, distance_m=20.0, manner=manner)  # type: ignore[arg-type]
    front, above = draw_field_sheet(plan, pictures_only=True).axes
    for axes, height in ((front, "up_m"), (above, "away_m")):
        lines = {str(line.get_label()): line for line in axes.lines}
        arrows = [c for c in axes.collections if isinstance(c, Quiver)]
        for kind, arrow in zip(("perpendicular", "oblique"), arrows, strict=True):
            some = plan.of_kind(kind)  # type: ignore[arg-type]
            line = lines[f"{kind}: {len(some)}"]
            assert np.array_equal(line.get_xdata(), [s.along_m for s in some])
            assert np.array_equal(line.get_ydata(), [getattr(s, height) for s in some])
            # Arrows point to what is aimed at.
            across = np.array([s.target_along_m - s.along_m for s in some])
            toward = [s.target_up_m - s.up_m if height == "up_m" else -s.away_m for s in some]
            assert np.asarray(arrow.U) == pytest.approx(0.12 * across)
            assert np.asarray(arrow.V) == pytest.approx(0.12 * np.array(toward))
    boxes = [p for p in front.patches if isinstance(p, Rectangle)]
    assert (boxes[0].get_xy(), boxes[0].get_width(), boxes[0].get_height()) == ((0, 0), 30, 10)
    first, (w, h) = plan.of_kind("perpendicular")[0], plan.footprint_m
    assert boxes[1].get_width() == w
    assert boxes[1].get_height() == h
    assert boxes[1].get_center() == pytest.approx((first.along_m, first.up_m))
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
    assert front.get_ylabel() == ("across, m\n(from above)" if flat else "up, m\n(as you face it)")
    assert above.get_ylabel() == (
        "above the ground, m\n(from the side)" if flat else "away from the rock, m\n(from above)"
    )


@pytest.mark.parametrize("ending", ["pdf", "svg", "html"])
def test_a_sheet_is_written_without_its_date_and_only_over_what_may_go(
    plan: SurveyPlan, tmp_path: Path, ending: str
) -> None:
    from vomstudio.errors import TargetError

    path = tmp_path / f"sheet.{ending}"
    write_field_sheet(path, plan)
    with pytest.raises(TargetError):
        write_field_sheet(path, plan)
    write_field_sheet(path, plan, force=True)
    assert b"CreationDate" not in path.read_bytes()
    assert b"<dc:date>" not in path.read_bytes()


def test_the_words_of_a_sheet_stand_in_their_columns(plan: SurveyPlan) -> None:
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
    assert boxes["Photo survey: field sheet"].y0 > front.y1 * figure.bbox.height


@pytest.mark.parametrize("manner", ["handheld", "terrain"])
@pytest.mark.parametrize(("width", "height"), [(30.0, 10.0), (8.0, 25.0), (200.0, 12.0)])
def test_everything_on_a_sheet_is_on_the_paper_and_the_drawings_fill_their_room(
    manner: str, width: float, height: float
) -> None:
    plan = plan_survey(APSC, width, height, distance_m=20.0, manner=manner)  # type: ignore[arg-type]
    figure = draw_field_sheet(plan)
    figure.draw_without_rendering()
    paper = figure.bbox
    assert (figure.get_size_inches() * 25.4).tolist() == pytest.approx([210, 297], abs=1)
    for text in figure.texts:
        assert text.get_fontsize() >= 8.0, "it is read in the field"
        box = text.get_window_extent()
        assert paper.x0 + 20 < box.x0
        assert box.x1 < paper.x1 - 5
        assert paper.y0 < box.y0
        assert box.y1 < paper.y1
    for axes in figure.axes:
        box = axes.get_tightbbox()
        assert box is not None
        assert box.x0 > paper.x0
        assert box.x1 < paper.x1
        # Of the tighter direction 4 % stay free at either end.
        data = axes.dataLim
        low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
        used = (data.max - data.min) / (high - low)
        assert used.max() == pytest.approx(1.0 / 1.08, rel=2e-3)


def test_a_sheet_in_html_has_the_drawings_alone(plan: SurveyPlan) -> None:
    figure = draw_field_sheet(plan, pictures_only=True)
    assert not figure.texts
    assert figure.get_size_inches().tolist() == [8.27, 6.0]
    for axes in figure.axes:
        box = axes.get_position()
        assert 0.0 < box.y0 < box.y1 < 1.0


@pytest.mark.parametrize("name", ["a.txt", "a", "a.png"])
def test_a_sheet_is_refused_by_its_ending(plan: SurveyPlan, tmp_path: Path, name: str) -> None:
    from vomstudio.errors import UsageError

    with pytest.raises(UsageError, match=r"\.pdf, \.svg or \.html") as caught:
        write_field_sheet(tmp_path / name, plan)
    assert caught.value.field == "--output"
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize("manner", ["handheld", "terrain"])
def test_the_legend_explains_every_sign_of_the_drawing(manner: str) -> None:
    plan = plan_survey(APSC, 30.0, 10.0, distance_m=20.0, manner=manner)  # type: ignore[arg-type]
    front, above = draw_field_sheet(plan).axes
    legend = front.get_legend()
    assert legend is not None
    assert above.get_legend() is None
    straight, oblique = (len(plan.of_kind(kind)) for kind in ("perpendicular", "oblique"))  # type: ignore[arg-type]
    said = {
        text.get_text(): handle
        for text, handle in zip(legend.get_texts(), legend.legend_handles, strict=True)
    }
    signs = {
        f"perpendicular: {straight}": ("o", PERPENDICULAR, "full"),
        f"oblique: {oblique}": ("^", OBLIQUE, "full"),
        "control point": ("s", CONTROL, "full"),
        "check point": ("s", CONTROL, "none"),
    }
    assert list(said) == list(signs)
    for name, sign in signs.items():
        handle = said[name]
        assert isinstance(handle, Line2D)
        assert (handle.get_marker(), handle.get_color(), handle.get_fillstyle()) == sign
    assert above.get_xlabel() == "along the outcrop from its left end, m"
    assert front.get_xlabel() == ""


def test_of_very_many_photos_the_ways_they_look_are_left_out() -> None:
    many = plan_survey(APSC, 400.0, 40.0, distance_m=12.0)
    few = plan_survey(APSC, 30.0, 10.0, distance_m=20.0)
    for plan in (many, few):
        wanted = sum(
            0 < len(plan.of_kind(kind)) <= 400
            for kind in ("perpendicular", "oblique")  # type: ignore[arg-type]
        )
        for axes in draw_field_sheet(plan, pictures_only=True).axes:
            assert sum(isinstance(c, Quiver) for c in axes.collections) == wanted
    assert len(many.of_kind("perpendicular")) > 400


@pytest.mark.parametrize("ending", ["pdf", "svg", "html"])
def test_the_same_plan_gives_the_same_file(plan: SurveyPlan, tmp_path: Path, ending: str) -> None:
    one, other = tmp_path / f"one.{ending}", tmp_path / f"other.{ending}"
    write_field_sheet(one, plan)
    write_field_sheet(other, plan)
    assert one.read_bytes() == other.read_bytes()


def test_long_reminders_go_on_a_little_further_in(plan: SurveyPlan) -> None:
    figure = draw_field_sheet(plan)
    lines = [t for t in figure.texts if t.get_position()[1] < 0.26]
    heights = [t.get_position()[1] for t in lines]
    assert heights == sorted(heights, reverse=True)
    assert heights[0] == pytest.approx(0.255)
    for before, text in zip([None, *lines[:-1]], lines, strict=True):
        x, y = text.get_position()
        begins = text.get_text().startswith(("- ", "! ", "Date "))
        assert x == (0.07 if begins else 0.09)
        if before is not None:
            step = 0.0145 + (0.003 if begins else 0.0)
            assert before.get_position()[1] - y == pytest.approx(step)
        assert len(text.get_text()) <= 112
    assert sum(x.get_position()[0] == 0.09 for x in lines) > 0
