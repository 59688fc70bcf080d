"""A net is the same picture at every scale: all its sizes follow those of the style."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import Collection, LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.text import Text

from tests.products.net_places import places
from vomstudio.geology.folds import fold_axis
from vomstudio.geology.orientation import Plane, normals_to_planes
from vomstudio.geology.stereonet import project
from vomstudio.products.net.contents import (
    NetContents,
    NetEllipse,
    NetSet,
    compute_means,
    make_sets,
)
from vomstudio.products.net.contours import OPACITY
from vomstudio.products.net.figure import NetArtists, draw_stereonet
from vomstudio.products.net.legend import text_width
from vomstudio.products.net.page import NetPage
from vomstudio.products.net.style import SYMBOL_SIZES, NetStyle, symbol_scale

ONE = NetStyle(font_pt=8.0, marker_pt=4.0, line_pt=0.7)
"""No size of it is 1, so that a product and a quotient differ."""


def times(style: NetStyle, factor: float) -> NetStyle:
    return replace(
        style,
        font_pt=factor * style.font_pt,
        marker_pt=factor * style.marker_pt,
        line_pt=factor * style.line_pt,
    )


def draw(net: NetContents, style: NetStyle, width: float, height: float) -> NetArtists:
    """width, height : in points."""
    figure = Figure(figsize=(width / 72, height / 72), dpi=72)
    FigureCanvasAgg(figure)
    return draw_stereonet(figure, net, style)


def sizes(artist: Any) -> list[float]:
    """All that is measured in points."""
    if isinstance(artist, Line2D):
        marked = artist.get_marker() != "None"
        own = [artist.get_markersize(), artist.get_markeredgewidth()] if marked else []
        return [*own, artist.get_linewidth() if artist.get_linestyle() != "None" else 0.0]
    if isinstance(artist, Collection):
        return [float(v) for v in np.atleast_1d(artist.get_linewidths())]
    if isinstance(artist, Text):
        return [artist.get_fontsize()]
    if isinstance(artist, Patch):
        return [artist.get_linewidth() if artist.get_edgecolor()[3] else 0.0]
    return []


def cluster(n: int, seed: int) -> tuple[str, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    normals = Plane(132, 41).normal() + 0.3 * rng.normal(size=(n, 3))
    return ("plane", *normals_to_planes(normals)[:2])


@cache
def full(contour: str | None) -> NetContents:
    groups = {f"Set {k}": cluster(5 + k, k) for k in range(4)}
    groups["Striae"] = ("line", np.array([310.0, 50, 90]), np.array([55.0, -20, -60]))
    names = {k: [f"{k}.{i}" for i in range(len(v[1]))] for k, v in groups.items()}
    sets = tuple(replace(s, variant=k) for k, s in enumerate(make_sets(groups, names)))
    return NetContents(
        sets,
        means=compute_means(sets),
        fold=fold_axis(sets[0].azimuth_deg, sets[0].angle_deg),
        selected=frozenset({"Set 0.1", "Set 1.2", "Striae.1"}),
        ellipses=(NetEllipse(Plane(132, 41), 6, 2, 70),),
        contour=contour,
        title="Limb of the Big Elk",
        notes=("north known",),
    )


def drawn(artists: NetArtists) -> list[Any]:
    """All that is on a net but the lines to labels, which stand where their letters find room;
    contours that are filled have no lines."""
    axes = artists.axes
    every = [*axes.lines, *axes.collections, *axes.patches, *axes.texts]
    kept = [artist for artist in every if artist.get_gid() != "to label"]
    return [artist for artist in kept if not getattr(artist, "filled", False)]


@pytest.mark.full
@pytest.mark.parametrize(
    ("contour", "width", "height"), [(None, 480, 326), ("kamb", 480, 326), ("kamb", 260, 520)]
)
def test_doubling_sheet_and_style_gives_the_same_picture(
    contour: str | None, width: float, height: float
) -> None:
    net, factor = full(contour), 2.0
    small = draw(net, ONE, width, height)
    large = draw(net, times(ONE, factor), factor * width, factor * height)
    assert large.radius_px == pytest.approx(factor * small.radius_px, rel=0.01)
    assert large.centre_px == pytest.approx(factor * np.array(small.centre_px), rel=0.01)
    measured = 0
    for a, b in zip(drawn(small), drawn(large), strict=True):
        assert type(a) is type(b)
        assert np.array(sizes(b)) == pytest.approx(factor * np.array(sizes(a)))
        measured += len(sizes(a))
        if not isinstance(a, Text):
            assert places(b) == pytest.approx(places(a), abs=0.02)
    assert measured > 40
    near = {t.get_text(): places(t)[0] for t in large.axes.texts}
    outside = [t for t in small.axes.texts if np.hypot(*places(t)[0]) > 1.0]
    assert len(outside) >= 8
    for text in outside:
        assert near[text.get_text()] == pytest.approx(places(text)[0], abs=0.03)
    boxes = zip(small.text_boxes, large.text_boxes, strict=True)
    heights = [((a[3] - a[1]), (b[3] - b[1])) for a, b in boxes]
    assert [b for _, b in heights] == pytest.approx([factor * a for a, _ in heights])
    for text, box in zip(small.axes.texts, small.text_boxes, strict=True):
        assert box[3] - box[1] == pytest.approx(text.get_fontsize())


def page(net: NetContents, width: float, height: float) -> NetPage:
    return NetPage(Figure(figsize=(width / 72, height / 72), dpi=72), net, ONE)


@pytest.mark.full
@pytest.mark.parametrize("title", ["", "Limb"])
@pytest.mark.parametrize("contour", [None, "kamb"])
@pytest.mark.parametrize(("width", "height"), [(480, 326), (260, 520), (900, 300), (300, 300)])
def test_the_net_is_as_large_as_its_surroundings_allow(
    title: str, contour: str | None, width: float, height: float
) -> None:
    """Of the sheet's width and height what is left by margins, N, the ticks and the words."""
    net = NetContents(
        make_sets({"Beds": cluster(9, 1), "Joints": cluster(5, 2)}), contour=contour, title=title
    )
    result = page(net, width, height)
    font = 8.0
    pad, row, tick = 0.8 * font, 1.45 * font, 0.9 * font
    head = row + 0.6 * font
    assert (result.width, result.height) == pytest.approx((width, height))
    top = result.cy + result.radius
    if result.is_legend_beside:
        gap = tick + 1.5 * font
        assert result.cx - result.radius == pytest.approx(pad + tick)
        assert height - top == pytest.approx(head + 0.5 * pad)
        assert result.legend_x == pytest.approx(result.cx + result.radius + gap)
        assert result.legend_x + result.legend_width == pytest.approx(width - pad)
        # Either the height is used up, or the width.
        spare = height - head - tick - pad - 2 * result.radius
        column = result._column_width(result.words)
        assert min(spare, result.legend_width - column) == pytest.approx(0.0, abs=1e-6)
    else:
        bar = 0.0 if contour is None else 4.5 * font
        assert result.cx == pytest.approx((width - bar) / 2)
        assert height - top == pytest.approx(head + (1.9 * row if title else 0.0))
        assert (result.legend_x, result.legend_width) == pytest.approx((pad, width - 2 * pad))
        low = pad + (len(result.rows) + len(result.caption_lines)) * row
        spare = result.cy - result.radius - tick - low
        side = width - 2 * (pad + tick) - bar - 2 * result.radius
        assert min(spare, side) == pytest.approx(0.0, abs=1e-6)
        assert max(spare, side) > -1e-6
    box = result.axes.get_window_extent()
    assert (box.x0 + box.x1) / 2 == pytest.approx(result.cx)
    assert (box.y0 + box.y1) / 2 == pytest.approx(result.cy)
    assert (box.width, box.height) == pytest.approx((2 * result.radius, 2 * result.radius))


@pytest.mark.parametrize("title", ["", "Limb", "Limb of the Big Elk on a day of rain, twice"])
@pytest.mark.parametrize("contour", [None, "schmidt"])
@pytest.mark.parametrize("name", ["A", "Joints of the upper unit"])
def test_legend_beside_the_net_is_as_wide_as_its_texts(
    title: str, contour: str | None, name: str
) -> None:
    """With their symbols, its title to 40 letters, the caption and the name of the bar."""
    net = NetContents(make_sets({name: cluster(9, 1)}), contour=contour, title=title)
    result = page(net, 480, 326)
    widths = [2.2 * 8.0 + text_width(f"{name}, poles (n = 9)", 8.0)]
    widths.append(text_width("Equal area, lower hemisphere", 8.0))
    widths.append(text_width(title[:40], 1.15 * 8.0, "bold"))
    if contour is not None:
        widths.append(text_width("% of data per 1 % area", 8.0))
    assert result._column_width(result.words) == pytest.approx(1.05 * max(widths))
    assert text_width("Limb", 8.0, "bold") > text_width("Limb", 8.0)


def test_long_legend_beside_the_net_ends_above_the_caption() -> None:
    """As many rows as there is height for, and no more."""
    counts = []
    for contour in (None, "kamb"):
        for title in ("", "Limb"):
            sets = make_sets({f"Joint set {k}": cluster(3, k) for k in range(30)})
            result = page(NetContents(sets, contour=contour, title=title), 900.0, 226.0)
            assert result.is_legend_beside
            row, pad, font = 1.45 * 8.0, 0.8 * 8.0, 8.0
            room = 226.0 - 2 * pad - (len(result.caption_lines) + 1) * row
            if result.bar is not None:
                bar = min(1.5 * font * len(result.bar.levels), 0.4 * 226.0)
                room -= bar + (len(result.bar_lines) + 1) * row
            room -= 1.9 * row if title else 0.0
            n = len(result.rows)
            assert n * 1.15 * row <= room < (n + 1) * 1.15 * row
            counts.append(n)
    assert counts == sorted(counts, reverse=True)
    assert len(set(counts)) == 4


@pytest.mark.parametrize("compact", [False, True])
@pytest.mark.parametrize(("width", "height"), [(400, 300), (260, 520), (200, 430), (206, 430)])
def test_long_names_are_wrapped_in_print_and_shortened_on_the_screen(
    width: float, height: float, compact: bool
) -> None:
    long = "Joints of the upper and of the lower unit"
    names = [long, ", ".join(3 * [long]), "J", "K"]
    net = NetContents(
        make_sets({name: cluster(4, k) for k, name in enumerate(names)}), compact=compact
    )
    figure = Figure(figsize=(width / 72, height / 72), dpi=72)
    canvas = FigureCanvasAgg(figure)
    artists = draw_stereonet(figure, net, ONE)
    for text in artists.axes.texts:
        box = text.get_window_extent(canvas.get_renderer())
        assert box.x0 >= 0
        assert box.x1 <= width
    # As they were measured they end at the margin.
    assert max(box[2] for box in artists.text_boxes) <= width - 0.8 * ONE.font_pt + 1e-6
    words = [text.get_text() for text in artists.axes.texts]
    if compact:
        assert any(word.endswith("…") for word in words)
        return
    assert not any(word.endswith("…") for word in words)
    whole = " ".join(" ".join(words).split())
    assert all(f"{name}, poles (n = 4)" in whole for name in names), words


def test_long_title_is_shortened_and_not_clipped() -> None:
    net = NetContents(title="Limb of the Big Elk, measured twice " * 4)
    artists = draw(net, ONE, 260, 300)
    assert any(text.get_text().endswith("…") for text in artists.axes.texts)
    assert max(box[2] for box in artists.text_boxes) <= 260 - 0.8 * ONE.font_pt + 1e-6


def test_every_legend_symbol_precedes_its_text() -> None:
    net = replace(full(None), selected=frozenset(), title="")
    for width, height in ((480, 326), (260, 520)):
        artists = draw(net, ONE, width, height)
        words = [t for t in artists.axes.texts if "(n = " in t.get_text()]
        assert len(words) == 5
        r = artists.radius_px
        for s, text in zip(net.sets, words, strict=True):
            x, y = places(text)[0]
            ((mark, size),) = [
                (places(line)[0], line.get_markersize())
                for line in artists.axes.lines
                if line.get_marker() == s.marker
                and len(line.get_xdata()) == 1
                and abs(places(line)[0, 1] - y) < 1e-9
                and 0 < (x - places(line)[0, 0]) * r < 3 * ONE.font_pt
            ]
            assert (x - mark[0]) * r == pytest.approx((2.2 - 0.8) * ONE.font_pt)
            assert size == pytest.approx(1.1 * SYMBOL_SIZES.get(s.marker, 1.0) * ONE.marker_pt)


def symbol_width(s: NetSet, variant: int) -> float:
    return ONE.symbol(replace(s, variant=variant))[2] / ONE.line_pt


def test_symbol_edges_have_the_width_of_their_variant() -> None:
    (s,) = make_sets({"a": cluster(4, 0)})
    assert [symbol_width(s, k) for k in range(5)] == pytest.approx([0.5, 1.5, 1.2, 0.5, 0.5])
    # A light colour is rimmed with a deeper one, a little wider; arms of a cross are not.
    light = replace(s, color="#F0E442")
    assert symbol_width(light, 0) == pytest.approx(1.0)
    assert ONE.symbol(replace(s, marker="X"))[2] == pytest.approx(0.5 * ONE.line_pt)


@pytest.mark.parametrize("n", [1, 9, 40, 200, 1200])
@pytest.mark.parametrize("background", [0, 3000])
def test_rings_grow_thinner_and_smaller_with_their_number(n: int, background: int) -> None:
    """Up to 30 a symbol is 1.7 times as large as the others and 1.5 times as those of a small net;
    from a thousand on 1.2 and 0.7 times. Between them it goes with the logarithm."""
    groups = {"a": cluster(n, 0)} | ({"b": cluster(background, 1)} if background else {})
    names = {"a": [str(i) for i in range(n)]}
    net = NetContents(make_sets(groups, names), circles=False, selected=frozenset(names["a"]))
    artists = draw(net, ONE, 300, 300)
    (ring,) = [
        a for a in artists.emphasis if isinstance(a, Line2D) and a.get_marker() not in ("None", "")
    ]
    share = min(max((np.log10(1 + n) - 1.5) / 1.5, 0.0), 1.0)
    plain = ONE.marker_pt * symbol_scale(n + background)
    expected = max(plain * (1.7 - 0.5 * share), ONE.marker_pt * (1.5 - 0.8 * share))
    assert ring.get_markersize() == pytest.approx(expected)
    assert ring.get_markeredgewidth() == pytest.approx((1.6 - 1.2 * share) * ONE.line_pt)


def test_selection_lines_have_the_expected_widths() -> None:
    net = replace(full(None), contour=None)
    artists = draw(replace(net, sets=net.sets[:1], selected=frozenset({"Set 0.1"})), ONE, 480, 326)
    bands = [a for a in artists.emphasis if isinstance(a, LineCollection)]
    ellipse = [a for a in artists.emphasis if isinstance(a, Line2D) and a.get_marker() == "None"]
    widths = [float(c.get_linewidths()[0]) for c in bands] + [e.get_linewidth() for e in ellipse]
    assert widths == pytest.approx([3.4 * 0.7, 2.0 * 0.7, 1.2 * 0.7])


@pytest.mark.full
@pytest.mark.parametrize("compact", [False, True])
def test_selection_redraws_the_net_only_if_the_legend_changes(compact: bool) -> None:
    net = replace(full(None), selected=frozenset(), ellipses=(), compact=compact)
    artists = draw(net, ONE, 480, 326)
    ellipse = NetEllipse(Plane(132, 41), 6, 2, 70)
    first = artists.axes
    artists.select({"Set 0.1"})
    assert artists.axes is first
    artists.select({"Set 0.1"}, (ellipse,))
    assert (artists.axes is first) == compact
    second = artists.axes
    artists.select({"Set 0.2"}, (replace(ellipse, plane=Plane(130, 40)),))
    assert artists.axes is second
    artists.select(())
    assert (artists.axes is second) == compact
    figure = artists.axes.get_figure()
    assert figure is not None
    assert [ax for ax in figure.axes if ax.has_data()] == [artists.axes]


def test_figure_is_cleared_before_redrawing() -> None:
    figure = Figure(figsize=(5, 4))
    FigureCanvasAgg(figure)
    draw_stereonet(figure, full(None), ONE)
    again = draw_stereonet(figure, full("kamb"), ONE)
    assert [ax for ax in figure.axes if ax.has_data()] == [again.axes]


@pytest.mark.parametrize(("width", "height"), [(480, 326), (260, 520)])
def test_pixels_and_net_positions_map_both_ways(width: float, height: float) -> None:
    artists = draw(full(None), ONE, width, height)
    (cx, cy), r = artists.centre_px, artists.radius_px
    for x, y in np.random.default_rng(0).uniform(-1.5, 1.5, (20, 2)):
        assert artists.to_net(cx + r * x, cy + r * y) == pytest.approx((x, y))
    s = artists.contents.sets[0]
    at = np.array([cx, cy]) + r * project(s.vectors(), "area")
    for (x, y), name in zip(at, s.ids, strict=True):
        assert artists.feature_at(x, y) == name


@pytest.mark.parametrize("n", [500, 501, 2000, 2001])
@pytest.mark.parametrize("contour", [None, "kamb"])
def test_poles_over_contours_are_dots_and_many_lose_their_edges(
    n: int, contour: str | None
) -> None:
    net = NetContents(make_sets({"a": cluster(n, 0)}), contour=contour)
    (poles,) = draw(net, ONE, 300, 300).poles
    dots = contour is not None and n > 500
    assert poles.get_alpha() == (0.4 if dots else 1.0)
    size = ONE.marker_pt * symbol_scale(n) * (0.5 if dots else 1.0)
    assert poles.get_markersize() == pytest.approx(size)
    rim = 0.0 if dots or n > 2000 else 0.5 * ONE.line_pt
    assert poles.get_markeredgewidth() == pytest.approx(rim)


@pytest.mark.parametrize("dark", [False, True])
def test_contours_are_shaded_evenly_in_the_colours_of_their_bar(dark: bool) -> None:
    style = replace(NetStyle.dark() if dark else ONE, font_pt=8.0, line_pt=0.7)
    artists = draw(NetContents(make_sets({"a": cluster(40, 1)}), contour="kamb"), style, 480, 326)
    bar = [p for p in artists.axes.patches if isinstance(p, Rectangle)]
    first, last, name = (0.1, 0.9, "cividis") if dark else (0.2, 0.9, "Greys")
    shades = [colormaps[name](float(s))[:3] for s in np.linspace(first, last, len(bar))]
    # As translucent colours look on the net.
    net = np.array(to_rgb(style.net))
    expected = [OPACITY * np.array(shade) + (1.0 - OPACITY) * net for shade in shades]
    for box, color in zip(bar, expected, strict=True):
        assert box.get_facecolor()[:3] == pytest.approx(color, abs=0.01)
    (filled,) = [c for c in artists.axes.collections if getattr(c, "filled", False)]
    # What lies over the last level has its colour too.
    shown = np.asarray(filled.get_facecolor())
    assert shown[: len(bar), :3] == pytest.approx(np.array(shades), abs=0.01)
    assert shown[:, 3] == pytest.approx(np.full(len(shown), OPACITY))
    for box, level in zip(bar, filled.levels, strict=False):
        (label,) = [
            t
            for t in artists.axes.texts
            if t.get_text() == f"{level:g}" and abs(t.get_position()[1] - box.get_y()) < 1e-9
        ]
        right = box.get_x() + box.get_width()
        assert label.get_position()[0] - right == pytest.approx(0.4 * 8.0)
        assert box.get_width() == pytest.approx(8.0)


@pytest.mark.parametrize(("width", "height"), [(480, 326), (260, 520)])
def test_contour_bar_is_beside_the_net_below_its_name(width: float, height: float) -> None:
    artists = draw(full("kamb"), ONE, width, height)
    cy, r, font = artists.centre_px[1], artists.radius_px, ONE.font_pt
    bar = [p for p in artists.axes.patches if isinstance(p, Rectangle)]
    low, high = bar[0].get_y(), bar[-1].get_y() + bar[-1].get_height()
    n = len(bar)
    words = {t.get_text(): np.array(t.get_position()) for t in artists.axes.texts}
    if width > height:
        assert high - low == pytest.approx(min(1.5 * font * n, 0.4 * height))
        unit, name = words["standard deviations"], words["Density after Kamb, 3 σ"]
        subject = words["of all sets together, n = 29"]
        assert unit[1] - high == pytest.approx(0.8 * 1.45 * font)
        assert subject[1] - unit[1] == pytest.approx(1.45 * font)
        assert name[1] - subject[1] == pytest.approx(1.45 * font)
        notes = [at[1] for text, at in words.items() if text in ("north known",)]
        assert low > max(notes)
    else:
        assert high - low == pytest.approx(min(1.5 * font * n, 1.2 * r))
        assert (low + high) / 2 == pytest.approx(cy)
        assert words["σ"][1] - high == pytest.approx(0.8 * 1.45 * font)
        assert bar[0].get_x() == pytest.approx(width - 0.8 * font - 3.2 * font)


def test_legend_draws_lines_as_on_the_net() -> None:
    """A great circle whole, the circle of a fold in dashes, each as long as one and a half
    letters, before its words; a mean open and larger than a pole."""
    net = replace(full(None), selected=frozenset(), ellipses=(), circles=True)
    artists = draw(net, ONE, 480, 326)
    r, font = artists.radius_px, ONE.font_pt
    words = {t.get_text(): places(t)[0] for t in artists.axes.texts}
    lines = [
        (places(line), line)
        for line in artists.axes.lines
        if len(line.get_xdata()) == 2 and np.ptp(places(line)[:, 1]) == 0
    ]
    result = {}
    for ends, line in lines:
        (text,) = [
            text
            for text, (x, y) in words.items()
            if abs(y - ends[0, 1]) < 1e-9 and 0 < (x - ends[1, 0]) * r < 2 * font
        ]
        result[text] = line
        assert (ends[1, 0] - ends[0, 0]) * r == pytest.approx(1.6 * font)
        assert (words[text][0] - ends[0, 0]) * r == pytest.approx(2.2 * font)
        assert line.get_linewidth() == pytest.approx(1.3 * ONE.line_pt)
    (pi,) = [text for text in words if text.startswith("π-plane")]
    assert result[pi].get_linestyle() == "--"
    assert len(result) == 5
    assert sum(line.get_linestyle() == "-" for line in result.values()) == 4
    mean = words["Open symbol: Fisher mean"]
    (mark,) = [
        line
        for line in artists.axes.lines
        if len(line.get_xdata()) == 1
        and abs(places(line)[0, 1] - mean[1]) < 1e-9
        and 1.0 < places(line)[0, 0] < mean[0]
    ]
    assert mark.get_markersize() == pytest.approx(1.6 * ONE.marker_pt)
    assert mark.get_markerfacecolor() == ONE.net
    assert mark.get_markeredgecolor() == ONE.ink
    assert mark.get_markeredgewidth() == pytest.approx(1.4 * ONE.line_pt)
