"""What is added to a net on request: girdles, densest places, errors, averages, slip lines."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from tests.geology.samples import fisher_sample
from tests.messages import figures, refused
from tests.products.net_places import places
from vomstudio.core.errors import UsageError
from vomstudio.geology.notation import format_line
from vomstudio.geology.orientation import (
    Line,
    Plane,
    angle_between_lines,
    normals_to_planes,
    planes_to_poles,
)
from vomstudio.geology.stereonet import project
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.products.net.contents import (
    MARKERS,
    Contouring,
    NetContents,
    NetEllipse,
    compute_means,
    make_sets,
)
from vomstudio.products.net.figure import NetArtists, draw_stereonet
from vomstudio.products.net.figure_options import StereonetFigure
from vomstudio.products.net.figure_style import FigureStyle
from vomstudio.products.net.legend import legend_entries
from vomstudio.products.net.net_options import NetRotation, parse_cone, parse_slip, rotate_net
from vomstudio.products.net.preparation import NetAdditions
from vomstudio.products.net.set_statistics import (
    add_statistics,
    describe_sets,
    find_maxima,
    fit_girdles,
)
from vomstudio.products.net.style import NetStyle
from vomstudio.products.net.table_net import error_ellipses

ROWS: Any = None
"""Of a table, for what needs its errors only."""


def fold(axis: Line, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Dip directions and dips of beds about an axis, all the way round."""
    along = axis.vector()
    first = np.cross(along, [0.0, 0.0, 1.0])
    first /= np.linalg.norm(first)
    second = np.cross(along, first)
    turn = np.radians(np.arange(n) * 180.0 / n)[:, None]
    return normals_to_planes(np.cos(turn) * first + np.sin(turn) * second)[:2]


def cluster(n: int = 40, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return normals_to_planes(fisher_sample(rng, n, 60.0, planes_to_poles(120, 50)))[:2]


def net(**more: object) -> NetContents:
    sets = make_sets({"folded": ("plane", *fold(Line(40, 20))), "joints": ("plane", *cluster())})
    return replace(NetContents(sets), **more)


def draw(contents: NetContents, style: FigureStyle | None = None) -> NetArtists:
    figure = Figure(figsize=(6.7, 4.5), dpi=100)
    return draw_stereonet(figure, contents, (style or FigureStyle()).net_style())


def test_girdle_is_drawn_across_the_fold_axis_and_not_for_a_cluster() -> None:
    result, others = fit_girdles(net().sets)
    assert others == ("joints",)
    (girdle,) = result
    assert girdle.half_angle_deg == 90.0
    assert angle_between_lines(girdle.axis, Line(40, 20)) < 1e-6
    assert girdle.color == net().sets[0].color
    messages = add_statistics(net(), {"girdles"})
    assert any("joints" in note for note in messages.notes)
    assert len(draw(messages).axes.lines) > len(draw(net()).axes.lines)


@pytest.mark.parametrize("each", [True, False])
def test_density_maximum_of_a_cluster_is_near_its_mean(each: bool) -> None:
    joints = replace(net(), sets=net().sets[1:], contouring=Contouring(each_set=each))
    for contents in (joints, replace(joints, contour="linear_kamb")):
        (mark,) = find_maxima(contents)
        assert angle_between_lines(mark.line, Plane(120, 50).pole()) < 4.0
        assert mark.label.startswith("max ")
    assert "% / 1 %" in find_maxima(replace(joints, contour="schmidt"))[0].label


def test_averages_state_number_method_and_values() -> None:
    folded, joints = describe_sets(net().sets)
    assert (folded[:7], joints[:7]) == ("folded:", "joints:")
    assert figures(folded) == [60.0, 1.0, 40.0, 20.0]
    assert "G 1.00" in folded
    count, mean, *_ = figures(joints)
    assert (count, mean) == (40.0, pytest.approx(120.0, abs=5.0))
    assert "κ" in joints
    assert "α95" in joints
    written = {t.get_text() for t in draw(add_statistics(net(), {"averages"})).axes.texts}
    assert any(text.startswith("joints: n = 40") for text in written)


def test_a_slip_line_lies_in_its_plane_at_its_rake() -> None:
    circle, mark = parse_slip("120/60/40")
    plane = Plane(120, 60)
    assert abs(plane.normal() @ mark.line.vector()) < 1e-9
    # 40 degrees from the strike that has the dip to its right.
    strike = Line(plane.strike_rhr_deg, 0.0)
    assert angle_between_lines(mark.line, strike) == pytest.approx(40.0)
    assert angle_between_lines(circle.axis, plane.pole()) < 1e-6
    for wrong in ("120/60", "120/95/10", "a/b/c"):
        with pytest.raises(UsageError):
            parse_slip(wrong)


TABLE = (
    "dip_direction_deg,dip_deg,max_confidence95_deg,min_confidence95_deg,error_rake_deg\n"
    "120,40,8,3,30\n200,70,5,2,100\n300,20,,,\n"
)


def read(folder: Path, text: str):
    path = folder / "planes.csv"
    path.write_text(text, encoding="utf-8")
    return read_orientations(path)


def test_errors_come_from_the_table_and_rotate_with_the_planes(tmp_path: Path) -> None:
    result = error_ellipses(read(tmp_path, TABLE))
    assert [e.max_angle_deg for e in result] == [8.0, 5.0]
    with pytest.raises(UsageError, match="max_confidence95_deg"):
        error_ellipses(read(tmp_path, "dip_direction,dip\n120,40\n"))
    contents = NetContents(make_sets({"a": ("plane", [120, 200], [40, 70])}), errors=result)
    lines = [c for c in draw(contents).axes.collections if isinstance(c, LineCollection)]
    assert len(lines) > len(
        [
            c
            for c in draw(replace(contents, errors=())).axes.collections
            if isinstance(c, LineCollection)
        ]
    )
    turned = rotate_net(contents, NetRotation(Plane(120, 40)))
    first = turned.errors[0]
    assert first.line.plunge_deg == pytest.approx(90.0)
    # Of the pole that is upright now, the larger axis still goes by the rake from the strike 030.
    toward = Line.from_vector(first.axis)
    assert toward.trend_deg % 180 == pytest.approx(60.0)
    assert "Untilted by 120/40" in turned.notes


def test_ellipse_of_a_pole_equals_that_of_its_plane() -> None:
    ellipse = NetEllipse(Plane(120, 40), 9.0, 4.0, 25.0)
    one, other = ellipse.outline(), ellipse.pole_ellipse().outline()
    assert len(one) == len(other)
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)


def test_rotation_keeps_angles_and_rotates_slip_arrows_with_their_striae() -> None:
    striae = replace(
        make_sets({"s": ("line", [40.0, 90.0], [10.0, 30.0])})[0],
        slips=np.array([Line(40, 10).vector(), [np.nan] * 3]),
    )
    rotation = NetRotation(Plane(200, 35), Line(70, 20), 50.0)
    after = rotation.rotate_set(striae)
    before = striae.vectors() @ striae.vectors().T
    np.testing.assert_allclose(np.abs(after.vectors() @ after.vectors().T), np.abs(before))
    assert after.slips is not None
    assert abs(after.slips[0] @ after.vectors()[0]) == pytest.approx(1.0)
    assert np.isnan(after.slips[1]).all()
    # About the vertical nothing happens to a net but that it turns.
    half = NetRotation(None, Line(0, 90), 30.0).rotate_set(striae)
    np.testing.assert_allclose(half.azimuth_deg, [70.0, 120.0])


def test_marks_are_drawn_with_labels_at_their_directions() -> None:
    _, mark = parse_slip("120/60/40")
    artists = draw(replace(net(), marks=(mark,)))
    assert mark.label in {t.get_text() for t in artists.axes.texts}
    at = project(mark.line.vector())[0]
    drawn = [line for line in artists.axes.lines if len(line.get_xdata()) == 1]
    assert any(np.allclose(places(line), at) for line in drawn)


def test_grey_style_has_no_colours_and_custom_sizes_are_applied() -> None:
    from matplotlib.colors import to_rgb

    artists = draw(net(contour="kamb"), FigureStyle(StereonetFigure(grey=True)))
    for line in artists.axes.lines:
        colors = [line.get_color()] if line.get_linestyle() != "None" else []
        if line.get_marker() != "None":
            colors += [line.get_markerfacecolor(), line.get_markeredgecolor()]
        for color in colors:
            assert max(to_rgb(color)) - min(to_rgb(color)) < 0.01
    large = draw(net(), FigureStyle(StereonetFigure(font_size_pt=12.0, symbol_size_pt=9.0)))
    small = draw(net())
    assert large.poles[0].get_markersize() == pytest.approx(2.0 * small.poles[0].get_markersize())
    assert max(t.get_fontsize() for t in large.axes.texts) == pytest.approx(1.15 * 12)
    swapped = draw(net(), FigureStyle(colors={net().sets[0].color: "#123456"}))
    assert swapped.poles[0].get_markerfacecolor() == "#123456"


def test_invalid_style_is_rejected_and_valid_styles_are_stored() -> None:
    with pytest.raises(UsageError):
        FigureStyle.from_options(StereonetFigure(font="No Such Font"))
    for wrong in (
        {"size_mm": "1"},
        {"font_size_pt": float("nan")},
        {"line_width_pt": 0.0},
        {"font": "No Such Font"},
        {"font_size_pt": "wide", "other": 3},
        {"colors": {"red": "blue", "green": 3}},
        {"colors": 7},
    ):
        assert FigureStyle.restore(wrong) == FigureStyle()
    figure = StereonetFigure(font="DejaVu Serif", grey=True, size_mm="90")
    style = FigureStyle(figure, {"#000000": "#ff0000"})
    assert style.size_mm == (90.0, 115.0)
    assert FigureStyle.from_options(figure) == replace(style, colors={})
    assert FigureStyle.from_options(style.rose_figure) == replace(style, colors={})
    assert FigureStyle.restore(style.to_settings()) == style
    assert StereonetFigure(size_mm="90 x 60").width_and_height == (90.0, 60.0)
    with refused("figure.not-a-size", UsageError, text="wide", field="--size"):
        StereonetFigure(size_mm="wide")


@pytest.mark.parametrize(
    "rotation",
    [
        NetRotation(Plane(100, 35)),
        NetRotation(None, Line(40, 30), 75.0),
        NetRotation(Plane(10, 90), Line(5, 0), 20.0),
    ],
)
def test_typed_features_rotate_with_measured_ones(rotation: NetRotation) -> None:
    """A plane, a cone about its pole and a line on it are the same things typed and measured."""
    plane = Plane(120, 60)
    planes = np.array([120.0, 125.0, 118.0]), np.array([60.0, 61.0, 58.0])
    measured_net = NetContents(make_sets({"beds": ("plane", *planes)}))
    circle, mark = parse_slip("120/60/40")
    cone = parse_cone(f"{plane.pole().trend_deg}/{plane.pole().plunge_deg}/20")
    wishes = NetAdditions(rotation, (circle, cone), (mark,))
    after = wishes.net(measured_net, ROWS)
    measured = Line.from_vector(after.sets[0].vectors()[0])
    for drawn in after.user_circles:
        assert angle_between_lines(drawn.axis, measured) < 1e-6
        assert "rotated to" in drawn.label
    (line,) = after.marks
    assert abs(line.line.vector() @ measured.vector()) < 1e-9
    assert line.label == f"rake 40: {format_line(line.line)}"
    before = NetAdditions(NetRotation(), (circle, cone), (mark,)).net(measured_net, ROWS)
    assert before.user_circles == (circle, cone)
    assert before.marks == (mark,)


def test_typed_line_has_its_own_symbol_in_the_legend() -> None:
    _, mark = parse_slip("120/60/40")
    shown = replace(net(), marks=(mark,), means=compute_means(net().sets))
    entries = legend_entries(shown, NetStyle())
    (own,) = (e for e in entries if "rake" in e.text)
    others = [e.marker for e in entries if e is not own]
    assert own.marker == mark.marker
    assert mark.marker not in others
    assert mark.marker not in MARKERS
    assert not any("rake" in e.text for e in legend_entries(net(), NetStyle()))
