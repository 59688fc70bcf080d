"""A page with a net: its frame, what a fold adds to it, and room for everything."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from tests.products.net_places import parts, places
from tests.tiers import first_in_default_tier
from vomstudio.geology.density import choose_round_levels
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.orientation import Line, Plane, normals_to_planes
from vomstudio.geology.stereonet import confidence_ellipse, great_circles, line_at, project
from vomstudio.products.net.contents import (
    MAX_AUTOMATIC_CIRCLES,
    NetContents,
    NetEllipse,
    compute_means,
    make_sets,
)
from vomstudio.products.net.figure import NetArtists, draw_stereonet
from vomstudio.products.net.labels import find_label_position
from vomstudio.products.net.legend import text_width
from vomstudio.products.net.style import NetStyle

STYLE = NetStyle.dock()
SIZES = [(360, 360), (300, 420), (520, 360), (1000, 700), (420, 300), (260, 700)]


def planes(n: int, seed: int = 0) -> tuple[str, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    normals = Plane(132, 41).normal() + 0.15 * rng.normal(size=(n, 3))
    return ("plane", *normals_to_planes(normals)[:2])


def folded() -> FoldAxis:
    turns = np.radians([-60.0, -35, -20, 5, 15, 30, 50, 70])
    axis = Line(125, 26).vector()
    u = np.cross(axis, [0, 0, 1.0])
    u /= np.linalg.norm(u)
    poles = np.cos(turns)[:, None] * np.cross(u, axis) + np.sin(turns)[:, None] * u
    poles += 0.03 * np.random.default_rng(1).normal(size=poles.shape)
    return fold_axis(*normals_to_planes(poles)[:2])


def draw(net: NetContents, width: int = 360, height: int = 360) -> NetArtists:
    figure = Figure(figsize=(width / 100, height / 100), dpi=100)
    FigureCanvasAgg(figure)
    return draw_stereonet(figure, net, STYLE)


def test_rim_has_ticks_every_ten_degrees_and_long_ones_at_cardinal_directions() -> None:
    (ticks,) = [c for c in draw(NetContents()).axes.collections if isinstance(c, LineCollection)]
    lines = parts(ticks)
    rim, cross = lines[:36], lines[36:]
    azimuth = [math.degrees(math.atan2(*line[0])) % 360 for line in rim]
    assert azimuth == pytest.approx(np.arange(0, 360, 10), abs=1e-6)
    assert [np.linalg.norm(line[0]) for line in rim] == pytest.approx(np.ones(36))
    for line in rim:
        assert np.cross([*line[0], 0], [*line[1], 0]) == pytest.approx(np.zeros(3), abs=1e-12)
    length = np.array([np.linalg.norm(line[1]) for line in rim]) - 1.0
    assert length[::9] == pytest.approx(np.full(4, 2.0 * length[1]))
    assert np.delete(length, [0, 9, 18, 27]) == pytest.approx(np.full(32, length[1]))
    assert length[1] > 0
    # A cross in the middle, upright and level.
    for line, axis in zip(cross, (0, 1), strict=True):
        assert line[:, 1 - axis] == pytest.approx(np.zeros(2))
        assert line[0, axis] == pytest.approx(-line[1, axis])
        assert line[0, axis] != 0


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_north_label_is_above_its_tick(width: int, height: int) -> None:
    artists = draw(NetContents(), width, height)
    artists.axes.figure.draw_without_rendering()
    (north,) = [text for text in artists.axes.texts if text.get_text() == "N"]
    (ticks,) = [c for c in artists.axes.collections if isinstance(c, LineCollection)]
    tick = np.linalg.norm(parts(ticks)[0][1]) * artists.radius_px
    box = north.get_window_extent()
    assert 0.5 * (box.x0 + box.x1) == pytest.approx(artists.centre_px[0], abs=1.0)
    assert artists.centre_px[1] + tick <= box.y0 + 1.0
    assert box.y0 <= artists.centre_px[1] + tick + box.height


@pytest.mark.parametrize("projection", ["area", "angle"])
def test_a_fold_is_drawn_with_its_axis_its_region_and_its_great_circle(projection: str) -> None:
    fold = folded()
    artists = draw(NetContents(fold=fold, projection=projection))
    lines = [places(line) for line in artists.axes.lines]
    (star,) = [
        line
        for line in artists.axes.lines
        if line.get_marker() == "*" and np.hypot(*places(line)[0]) < 1.0
    ]
    beta = fold.beta.vector()
    assert places(star)[0] == pytest.approx(project(beta, projection)[0])

    def drawn(curve: np.ndarray) -> bool:
        return any(line.shape == curve.shape and np.allclose(line, curve) for line in lines)

    assert fold.confidence_axis is not None
    assert fold.max_confidence95_deg is not None
    assert fold.min_confidence95_deg is not None
    curves = confidence_ellipse(
        beta,
        fold.confidence_axis.vector(),
        fold.max_confidence95_deg,
        fold.min_confidence95_deg,
    )
    assert all(drawn(project(curve, projection, flip=False)) for curve in curves)
    (circle,) = [
        line
        for line in lines
        if len(line) > 50
        and all(
            abs(v.vector() @ beta) < 1e-6
            for x, y in line[1:-1:10]
            if (v := line_at(float(x), float(y), projection))
        )
    ]
    assert len(circle) == 91
    two = draw(NetContents(fold=fold_axis([100, 220], [30, 55]), projection=projection))
    long = [line for line in two.axes.lines if len(places(line)) > 50]
    assert len(long) == 1  # no region of two planes


def test_means_are_open_symbols_at_their_directions() -> None:
    sets = make_sets({"a": planes(9), "b": planes(5, 2), "c": planes(2)})
    net = NetContents(sets, means=compute_means(sets), circles=False)
    artists = draw(net)
    size = 2.0 * STYLE.marker_pt
    big = [line for line in artists.axes.lines if line.get_markersize() == pytest.approx(size)]
    assert len(big) == len(net.means) == 2
    for line, mean in zip(big, net.means, strict=True):
        at = project(mean.line.vector(), "area")[0]
        assert places(line)[0] == pytest.approx(at)
        assert line.get_markerfacecolor() == STYLE.net
        assert line.get_markeredgecolor() == STYLE.outline(STYLE.color(mean.color))


@pytest.mark.full
def test_great_circles_match_the_planes_and_many_are_pale() -> None:
    for n, steps in ((5, 61), (100, 61), (101, 31)):
        sets = make_sets({"a": planes(n)})
        artists = draw(NetContents(sets, circles=True))
        vectors = great_circles(sets[0].azimuth_deg, sets[0].angle_deg, steps)
        expected = project(vectors, "area", flip=False)
        assert artists.arcs[0] == pytest.approx(expected)
        (lines,) = [
            c
            for c in artists.axes.collections
            if isinstance(c, LineCollection) and len(c.get_segments()) == n
        ]
        for drawn, arc in zip(parts(lines), expected, strict=True):
            assert drawn == pytest.approx(arc, abs=1e-9)
        assert artists.arc_rows[0].tolist() == list(range(n))
    alphas = []
    for n in (1, 16, 100, 1000, 10_000):
        artists = draw(NetContents(make_sets({"a": planes(n)}), circles=True))
        (lines,) = [
            c
            for c in artists.axes.collections
            if isinstance(c, LineCollection) and len(c.get_segments()) == n
        ]
        alphas.append(lines.get_alpha())
    assert alphas == pytest.approx([1.0, 1.0, 0.4, 0.15, 0.15])


def test_caption_states_how_many_great_circles_are_left_out() -> None:
    def words(n: int, **more: object) -> list[str]:
        net = NetContents(make_sets({"a": planes(n)}), **more)  # type: ignore[arg-type]
        return [t.get_text() for t in draw(net, 600, 400).axes.texts]

    left_out = f"Great circles of {MAX_AUTOMATIC_CIRCLES + 1:,} planes are not drawn"
    assert left_out in words(MAX_AUTOMATIC_CIRCLES + 1)
    assert not any("left out" in text for text in words(MAX_AUTOMATIC_CIRCLES))
    assert not any("left out" in text for text in words(MAX_AUTOMATIC_CIRCLES + 1, circles=False))


def symbols(artists: NetArtists, marker: str) -> list[Line2D]:
    return [line for line in artists.axes.lines if line.get_marker() == marker]


def test_upward_lines_are_hollow_symbols_at_their_lower_end() -> None:
    sets = make_sets({"a": ("line", [10.0, 50, 90], [30.0, -20, -60])})
    artists = draw(NetContents(sets))
    marker = sets[0].marker
    full, hollow = [
        line for line in symbols(artists, marker) if np.hypot(*places(line).T).max() < 1.0
    ]
    assert places(full) == pytest.approx(project(Line(10, 30).vector()))
    low = [Line(230, 20).vector(), Line(270, 60).vector()]
    assert places(hollow) == pytest.approx(project(np.array(low)))
    assert full.get_markerfacecolor() == sets[0].color
    assert hollow.get_markerfacecolor() == STYLE.net


def test_legend_uses_the_drawn_colour_of_the_great_circles() -> None:
    """A yellow line is darkened on white, in the net and in the legend."""
    net = NetContents(tuple(replace(s, color="#f0e442") for s in make_sets({"a": planes(5)})))
    artists = draw(net)
    (arcs,) = [
        c
        for c in artists.axes.collections
        if isinstance(c, LineCollection) and len(c.get_segments()) == 5
    ]
    lines = artists.axes.get_figure().findobj(Line2D)
    legend = {to_hex(line.get_color()) for line in lines if len(line.get_xdata()) == 2}
    assert to_hex(arcs.get_color()[0]) in legend
    assert "#f0e442" not in legend


def away(box: tuple[float, float, float, float], centre: tuple[float, float]) -> float:
    """Distance of a box from a point."""
    dx = max(box[0] - centre[0], 0.0, centre[0] - box[2])
    dy = max(box[1] - centre[1], 0.0, centre[1] - box[3])
    return math.hypot(dx, dy)


@pytest.mark.parametrize(("width", "height"), first_in_default_tier(SIZES))
@pytest.mark.parametrize("sets", first_in_default_tier([3, 12, 40]))
@pytest.mark.parametrize("contour", first_in_default_tier([None, "kamb"]))
def test_legend_and_caption_do_not_overlap_the_net_which_keeps_its_share(
    width: int, height: int, sets: int, contour: str | None
) -> None:
    """However many sets there are: those without room are counted in the last row."""
    some = make_sets({f"Joint set {i}": planes(3, i) for i in range(sets)})
    net = NetContents(some, contour=contour, title="Limb" if sets == 3 else "", circles=False)
    artists = draw(net, width, height)
    assert 2 * artists.radius_px >= 0.4 * min(width, height)
    for box in artists.text_boxes:
        assert away(box, artists.centre_px) >= artists.radius_px - 0.5
        # The box of a word is a hair higher than its letters.
        assert box[0] >= 0
        assert box[1] >= 0
        assert box[2] <= width
        assert box[3] <= height + 0.5
    cx, cy = artists.centre_px
    r = artists.radius_px
    assert r <= min(cx, width - cx, cy, height - cy)
    words = [t.get_text() for t in artists.axes.texts]
    named = sum(text.startswith("Joint set") for text in words)
    more = [text for text in words if text.startswith("and ")]
    if more:
        assert more == [f"and {sets - named} more"]
    else:
        assert named == sets


class Sheet:
    """A figure of 300 x 200 points with a net of 80 in its middle."""

    width, height, cx, cy, radius, font = 300.0, 200.0, 150.0, 100.0, 80.0, 10.0

    def __init__(self) -> None:
        self.text_boxes: list[tuple[float, float, float, float]] = []


def box_of(place: tuple[float, float], text: str) -> tuple[float, float, float, float]:
    return (place[0], place[1] - 6.2, place[0] + text_width(text, 10.0), place[1] + 6.2)


def test_label_is_placed_beside_its_mark_without_overlaps() -> None:
    rng = np.random.default_rng(2)
    placed = 0
    for _ in range(60):
        sheet = Sheet()
        marks = [rng.uniform([20, 20], [280, 180]) for _ in range(3)]
        text = "mean 132/41"
        for mark in marks:
            place = find_label_position(sheet, mark, text, np.zeros((0, 2)), marks)
            if place is None:
                continue
            placed += 1
            box = box_of(place, text)
            assert box[0] >= 2
            assert box[2] <= 298
            assert box[1] >= 2
            assert box[3] <= 198
            near = [away(box, tuple(m)) for m in marks]
            # It would be read as that of the nearest one; boxes are two points wider than words.
            assert away(box, tuple(mark)) <= min(near) + 2.1
            for other in sheet.text_boxes:
                apart = box[0] >= other[2] or other[0] >= box[2]
                assert apart or box[1] >= other[3] or other[1] >= box[3]
            sheet.text_boxes.append(box)
    assert placed > 150


def test_unobstructed_label_is_near_its_mark_without_covering_it() -> None:
    """The mark of a mean is as wide as a letter is high."""
    for x, y in ((150.0, 100.0), (120.0, 130.0), (170.0, 60.0)):
        mark = np.array([x, y])
        place = find_label_position(Sheet(), mark, "beta", np.zeros((0, 2)), [mark])
        assert place is not None
        assert 6.0 <= away(box_of(place, "beta"), (x, y)) <= 12.0


def test_label_avoids_poles_and_the_rim_if_possible() -> None:
    sheet = Sheet()
    mark = np.array([150.0, 100.0])
    alone = find_label_position(sheet, mark, "beta", np.zeros((0, 2)), [mark])
    assert alone is not None
    # Poles where it would have stood drive it elsewhere, all around out to where it is free.
    box = box_of(alone, "beta")
    crowd = np.array([[x, y] for x in np.linspace(box[0], box[2], 5) for y in (box[1] + 1, box[3])])
    other = find_label_position(sheet, mark, "beta", crowd, [mark])
    assert other is not None
    moved = box_of(other, "beta")
    inside = (crowd > [moved[0], moved[1]]) & (crowd < [moved[2], moved[3]])
    assert not inside.all(axis=1).any()
    near_rim = np.array([150.0 + 62.0, 100.0])
    place = find_label_position(sheet, near_rim, "beta", np.zeros((0, 2)), [near_rim])
    assert place is not None
    corners = [(x, y) for x in box_of(place, "beta")[::2] for y in box_of(place, "beta")[1::2]]
    assert max(math.hypot(x - 150, y - 100) for x, y in corners) <= 80.0


def test_label_is_omitted_if_it_does_not_fit() -> None:
    sheet = Sheet()
    mark = np.array([150.0, 100.0])
    sheet.text_boxes = [(0.0, 0.0, 300.0, 200.0)]
    assert find_label_position(sheet, mark, "beta", np.zeros((0, 2)), [mark]) is None


@pytest.mark.parametrize("method", ["kamb", "schmidt"])
def test_levels_of_contours_are_even_round_and_at_most_eight(method: str) -> None:
    """Their step is the finest round one that leaves eight or fewer; of standard deviations two
    or more."""
    rng = np.random.default_rng(3)
    powers, steps = {
        "kamb": (3.6, [2, 4, 5, 10, 20, 50, 100, 200, 500]),
        "schmidt": (2.6, [1, 2, 5, 10, 20, 50]),
    }[method]
    tops = [*(10.0 ** rng.uniform(-1, powers, 400)), 2.0, 4.0, 16.0, 16.1, 8.0, 1.0]
    for top in [*tops, *(8.0 * step for step in steps)]:
        levels = choose_round_levels(float(top), method)
        assert len(levels) <= 8
        assert all(0.0 < level < top for level in levels)
        if not levels:
            assert top <= min(steps)
            continue
        assert levels == pytest.approx(levels[0] * np.arange(1, len(levels) + 1))
        assert levels[0] == min(step for step in steps if top / step <= 8)
        # As many as there is room for: the next level is the top or beyond it.
        assert levels[-1] + levels[0] >= top
    assert choose_round_levels(1e5, method) == [steps[-1]]
    assert choose_round_levels(7.0, "kamb") == [2.0, 4.0, 6.0]
    assert choose_round_levels(7.0, "schmidt") == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert choose_round_levels(30.0, "kamb") == [4.0, 8.0, 12.0, 16.0, 20.0, 24.0, 28.0]


def test_selection_does_not_change_the_net_contents() -> None:
    sets = make_sets({"a": planes(9)}, {"a": [str(i) for i in range(9)]})
    artists = draw(NetContents(sets))
    artists.select({"3", "4"})
    assert artists.contents.selected == {"3", "4"}
    assert artists.contents.sets is sets
    again = draw(artists.contents)
    assert len(again.emphasis) == len(artists.emphasis)


@pytest.mark.parametrize("turn", range(0, 360, 30))
@pytest.mark.parametrize("share", [0.6, 0.78])
def test_label_near_the_rim_stays_inside_on_every_side(turn: int, share: float) -> None:
    sheet = Sheet()
    way = np.array([math.cos(math.radians(turn)), math.sin(math.radians(turn))])
    mark = np.array([150.0, 100.0]) + share * 80.0 * way
    place = find_label_position(sheet, mark, "beta", np.zeros((0, 2)), [mark])
    assert place is not None
    box = box_of(place, "beta")
    corners = [(x, y) for x in box[::2] for y in box[1::2]]
    assert max(math.hypot(x - 150, y - 100) for x, y in corners) <= 80.0
    # And it is the nearest such place: its own mark is within two letters of it.
    assert away(box, (float(mark[0]), float(mark[1]))) <= 2.6 * 1.1 * 10.0


def test_label_is_placed_where_it_hides_the_fewest_poles() -> None:
    """Poles all about but to the left."""
    rng = np.random.default_rng(4)
    for gap in (90.0, 180.0, 270.0, 0.0):
        sheet = Sheet()
        mark = np.array([150.0, 100.0])
        around = rng.uniform(-50.0, 50.0, (4000, 2))
        angle = np.degrees(np.arctan2(around[:, 1], around[:, 0]))
        off = np.abs((angle - gap + 180.0) % 360.0 - 180.0)
        crowd = mark + around[(off > 55.0) & (np.hypot(*around.T) > 3.0)]
        place = find_label_position(sheet, mark, "pi", crowd, [mark])
        assert place is not None
        box = box_of(place, "pi")
        middle = np.array([box[0] + box[2], box[1] + box[3]]) / 2 - mark
        result = math.degrees(math.atan2(middle[1], middle[0]))
        assert abs((result - gap + 180.0) % 360.0 - 180.0) <= 31.0


@pytest.mark.parametrize("projection", ["area", "angle"])
def test_poles_and_downward_lines_are_filled_and_each_is_drawn_once(
    projection: str,
) -> None:
    """Overturned and level ones too; only lines can point up."""
    groups = {
        "beds": ("plane", [10.0, 130, 250], [0.0, 45, 90]),
        "lines": ("line", [10.0, 50, 90], [0.0, 20, 90]),
        "both": ("line", [10.0, 50], [-10.0, 20]),
    }
    sets = make_sets(groups)
    artists = draw(NetContents(sets, projection=projection))
    drawn = [places(line) for line in artists.poles]
    for s, at, line, points in zip(sets, artists.positions, artists.poles, drawn, strict=True):
        up = s.angle_deg < 0 if s.kind == "line" else np.zeros(len(s), dtype=bool)
        assert points == pytest.approx(at[~up])
        assert at == pytest.approx(project(s.vectors(), projection))
        assert line.get_markerfacecolor() == s.color
        assert line.get_marker() == s.marker
        # In the legend there is one more, outside the net.
        others = [
            other
            for other in symbols(artists, s.marker)
            if other is not line and np.hypot(*places(other)[0]) <= 1.0
        ]
        assert sum(len(other.get_xdata()) for other in others) == up.sum()
    bare = draw(NetContents(sets, poles=False, projection=projection))
    assert [len(line.get_xdata()) for line in bare.poles] == [0, 0, 0]


def test_highlighted_items_are_drawn_above_the_rest() -> None:
    """Density and its contours under great circles, these under poles; a fold and means over them,
    a selection over all features, and words over everything."""
    sets = make_sets({"a": planes(9)}, {"a": [str(i) for i in range(9)]})
    fold = folded()
    net = NetContents(
        sets,
        fold=fold,
        means=compute_means(sets),
        contour="kamb",
        circles=True,
        selected=frozenset({"3"}),
        ellipses=(NetEllipse(Plane(132, 41), 6, 2, 70),),
    )
    artists = draw(net, 700, 450)
    axes = artists.axes
    rim = axes.spines["geo"]
    filled, contours = (
        next(c for c in axes.collections if isinstance(c, ContourSet) and c.filled == full)
        for full in (True, False)
    )
    (circles,) = [
        c for c in axes.collections if isinstance(c, LineCollection) and len(c.get_segments()) == 9
    ]
    casing, chosen_circle = (a for a in artists.emphasis if isinstance(a, LineCollection))
    ring, ellipse = (
        next(
            a for a in artists.emphasis if isinstance(a, Line2D) and (a.get_marker() != "None") == m
        )
        for m in (True, False)
    )
    on_net = [x for x in axes.lines if np.hypot(*places(x)[0]) <= 1.0 + 1e-9]
    (star,) = [x for x in on_net if x.get_marker() == "*"]
    (mean,) = [x for x in on_net if x.get_markersize() == pytest.approx(2.0 * STYLE.marker_pt)]
    beta = [x for x in on_net if len(x.get_xdata()) > 20 and x not in artists.emphasis]
    order = [
        [filled],
        [contours],
        [circles],
        artists.poles,
        beta,
        [rim],
        [casing],
        [chosen_circle],
        [star, mean],
        [ellipse],
        [ring],
        list(axes.texts),
    ]
    assert all(order)
    for under, over in pairwise(order):
        assert max(a.get_zorder() for a in under) < min(a.get_zorder() for a in over)
    beside = [x for x in axes.lines if places(x)[0, 0] > 1.0]
    assert len(beside) >= 4
    for sign in beside:
        assert ring.get_zorder() < sign.get_zorder() < axes.texts[0].get_zorder()


def test_most_important_lines_are_the_widest_and_contours_the_finest() -> None:
    """In widths of the style's line: contours and the frames of their bar about a half, the rim,
    its ticks and a fold about one, and the open symbols of means about two."""
    sets = make_sets({"a": planes(9), "l": ("line", [10.0, 50, 90], [30.0, -20, -60])})
    net = NetContents(sets, fold=folded(), means=compute_means(sets), contour="kamb", circles=True)
    axes = draw(net, 700, 450).axes
    unit = STYLE.line_pt
    rim = axes.spines["geo"]
    bar = [p for p in axes.patches if isinstance(p, Rectangle)]
    (contours,) = [c for c in axes.collections if isinstance(c, ContourSet) and not c.filled]
    lines = [c for c in axes.collections if isinstance(c, LineCollection)]
    on_net = [x for x in axes.lines if np.hypot(*places(x)[0]) <= 1.0 + 1e-9]
    curves = [x for x in on_net if x.get_marker() == "None"]
    (star,) = [x for x in on_net if x.get_marker() == "*"]
    means = [x for x in on_net if x.get_markersize() == pytest.approx(2.0 * STYLE.marker_pt)]
    hollow = [
        x
        for x in on_net
        if x.get_markerfacecolor() == STYLE.net and x not in means and x.get_marker() != "None"
    ]
    assert bar
    assert len(curves) >= 2
    assert len(lines) == 2
    assert means
    assert len(hollow) == 1
    fine = [*(p.get_linewidth() for p in bar), *np.atleast_1d(contours.get_linewidths())]
    (sign,) = [x for x in axes.lines if x.get_marker() == "*" and x is not star]
    fine.append(sign.get_markeredgewidth())
    middle = [rim.get_linewidth(), *(x.get_linewidth() for x in curves)]
    middle += [float(v) for c in lines for v in c.get_linewidths()]
    middle += [star.get_markeredgewidth(), *(x.get_markeredgewidth() for x in hollow)]
    for widths, low, high in (
        (fine, 0.4, 0.7),
        (middle, 0.9, 1.5),
        ([x.get_markeredgewidth() for x in means], 1.8, 3.0),
    ):
        for width in widths:
            assert low * unit < width < high * unit
    assert 2.0 < star.get_markersize() / STYLE.marker_pt < 3.0


@pytest.mark.parametrize("side", [200, 280, 340])
@pytest.mark.parametrize("count", [1, 8])
def test_compact_net_fills_its_square_and_leaves_a_row_below(side: int, count: int) -> None:
    sets = make_sets({f"Joints J{k}": planes(8, k) for k in range(count)})
    net = NetContents(sets, fold=folded(), averages=("some", "words"), compact=True)
    full, brief = draw(net, side, side), draw(replace(net, brief=True), side, side)
    assert brief.radius_px > 1.1 * full.radius_px
    assert 2 * brief.radius_px > (0.6 if count == 1 else 0.7) * side
    row = 1.45 * STYLE.font_pt * 100 / 72
    assert min(box[1] for box in brief.text_boxes) >= row
    drawn = [text.get_window_extent() for text in brief.axes.texts]
    assert max(box.x1 for box in drawn) <= side
    words = [text.get_text() for text in brief.axes.texts]
    # Its sets are named all or not at all.
    named = [word for word in words if word.startswith("Joints")]
    assert len(named) == (1 if count == 1 else 0)
    assert any(word.startswith("β") for word in words)


def test_no_label_covers_the_selection_name_on_the_screen() -> None:
    """In the top left corner of a net with a legend."""
    for azimuth in range(90, 180, 10):
        sets = make_sets({"a": ("plane", [azimuth - 1.0, azimuth, azimuth + 1.0], [80.0] * 3)})
        net = NetContents(sets, means=compute_means(sets), compact=True)
        for width, height in ((300, 420), (360, 360)):
            corner = (0.0, height - 2 * 1.45 * STYLE.font_pt * 100 / 72, 0.4 * width, height)
            for x0, _, _, y1 in draw(net, width, height).text_boxes:
                assert x0 >= corner[2] or y1 <= corner[1]
