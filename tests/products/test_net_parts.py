"""What is on a net before it is drawn: sets, means, legend, colours; and what a selection draws."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tests.products.net_places import parts, places
from vomstudio.geology.folds import fold_axis
from vomstudio.geology.notation import format_error_deg
from vomstudio.geology.orientation import (
    Line,
    Plane,
    angle_between_lines,
    normals_to_planes,
)
from vomstudio.geology.stereonet import project
from vomstudio.products.net.contents import (
    MARKERS,
    MAX_AUTOMATIC_CIRCLES,
    OKABE_ITO,
    NetContents,
    NetEllipse,
    NetLineEllipse,
    compute_means,
    describe_means,
    make_sets,
    shows_all_circles,
)
from vomstudio.products.net.figure import NetArtists, draw_stereonet
from vomstudio.products.net.legend import SYMBOLS, legend_entries, shorten_text, text_width
from vomstudio.products.net.style import NetStyle, symbol_scale

BEDS = ("plane", [130.0, 134, 132], [40.0, 42, 41])
STRIAE = ("line", [310.0, 312], [55.0, 57])


def some(n: int, seed: int = 0) -> tuple[str, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    normals = Plane(132, 41).normal() + 0.2 * rng.normal(size=(n, 3))
    return ("plane", *normals_to_planes(normals)[:2])


def draw(net: NetContents, style: NetStyle | None = None) -> NetArtists:
    figure = Figure(figsize=(4, 4), dpi=100)
    FigureCanvasAgg(figure)
    return draw_stereonet(figure, net, style or NetStyle.dock())


def test_sets_take_colours_and_symbols_in_order_without_early_repeats() -> None:
    sets = make_sets({f"s{i}": BEDS for i in range(20)})
    assert [s.color for s in sets[:8]] == list(OKABE_ITO)
    assert [s.marker for s in sets[:8]] == list(MARKERS)
    assert len({(s.color, s.marker) for s in sets}) == 20
    assert sets[8].color == sets[0].color
    with pytest.raises(ValueError, match="curve"):
        make_sets({"a": ("curve", [1], [1])})


def test_planes_are_shown_as_poles_and_lines_as_directions() -> None:
    beds, striae = make_sets({"b": BEDS, "s": STRIAE})
    assert beds.vectors()[1] == pytest.approx(Plane(134, 42).pole().vector())
    assert striae.vectors()[1] == pytest.approx(Line(312, 57).vector())
    assert (len(beds), len(striae)) == (3, 2)


def test_sets_of_three_or_more_have_a_labelled_mean() -> None:
    sets = make_sets({"b": BEDS, "s": STRIAE, "l": ("line", [10.0, 12, 11], [5.0, 5, 5])})
    beds, lines = compute_means(sets, "strike/dip", 1)
    assert beds.label == "042.0/41.0 RHR"
    assert angle_between_lines(beds.line, Plane(132, 41).pole()) < 0.05
    assert (beds.color, beds.marker) == (sets[0].color, sets[0].marker)
    assert lines.label == "011.0/05.0"
    (alone,) = compute_means(sets[:1])
    assert alone.label == "Mean 132/41"
    even = make_sets({"e": ("line", [0.0, 60, 120], [0.0, 0, 0])})
    assert compute_means(even) == ()


def test_few_great_circles_are_shown_unless_requested_otherwise() -> None:
    few = NetContents(make_sets({"a": some(MAX_AUTOMATIC_CIRCLES)}))
    many = NetContents(make_sets({"a": some(MAX_AUTOMATIC_CIRCLES), "b": some(1)}))
    lines = NetContents(
        make_sets({"a": some(MAX_AUTOMATIC_CIRCLES), "l": ("line", [1.0] * 99, [2.0] * 99)})
    )
    assert [shows_all_circles(net) for net in (few, many, lines)] == [True, False, True]
    assert shows_all_circles(replace(many, circles=True))
    assert not shows_all_circles(replace(few, circles=False))


def test_legend_describes_each_symbol() -> None:
    fold = fold_axis(*some(30, 3)[1:])
    sets = make_sets({"Beds": BEDS, "Striae": STRIAE})
    style = NetStyle()
    full = NetContents(
        sets,
        fold=fold,
        means=compute_means(sets),
        decimals=1,
        ellipses=(NetEllipse(Plane(130, 40), 6, 2, 70),),
    )
    beds, striae, beta, pi, mean, ellipse = legend_entries(full, style)
    assert (beds.text, beds.marker, beds.line) == ("Beds, poles (n = 3)", sets[0].marker, "-")
    assert (striae.text, striae.line) == ("Striae, lines (n = 2)", None)
    assert (beds.symbol_set, beds.color) == (sets[0], sets[0].color)
    major, minor = fold.max_confidence95_deg, fold.min_confidence95_deg
    errors = f"±{format_error_deg(major)} / ±{format_error_deg(minor)}"
    assert beta.text == f"β, joint 95 %: {errors}, n = {fold.n}"
    plane = fold.pi_plane
    assert pi.text == f"π-plane {plane.dip_direction_deg:05.1f}/{plane.dip_deg:04.1f}"
    assert (mean.text, mean.is_outlined, mean.color) == (
        describe_means(full.means),
        True,
        style.net,
    )
    assert ellipse.text == SYMBOLS["pole-ellipse"]
    line = NetLineEllipse(Line(10, 20), 4, 2, Line(100, 0).vector())
    assert legend_entries(replace(full, ellipses=(line,)), style)[-1].text.endswith("line")
    terse = legend_entries(replace(full, compact=True, means=()), style)
    assert [e.text.split(" ")[0] for e in terse] == ["Beds", "Striae", "β", "π"]
    assert terse[0].text == "Beds (3)"
    assert terse[2].text == f"β {errors}, n = {fold.n}"
    poor = legend_entries(replace(full, fold_not_good_count=2), style)
    assert "2 not rated good" in poor[2].text
    bare = legend_entries(NetContents(sets, poles=False, circles=False), style)
    assert (bare[0].text, bare[0].marker, bare[0].line) == ("Beds, planes (n = 3)", None, None)
    both = make_sets({"Fault": BEDS})
    twice = (*both, replace(make_sets({"Fault": STRIAE})[0]))
    texts = [e.text for e in legend_entries(NetContents(twice, compact=True), style)]
    assert texts == ["Fault (3)", "Fault, lines (2)"]
    two = fold_axis([100, 220], [30, 55])
    assert legend_entries(NetContents(fold=two), style)[0].text == "β, n = 2"


def test_text_is_shortened_to_the_available_width() -> None:
    words = "Joint set of the upper unit"
    width = text_width(words, 8.0)
    assert shorten_text(words, 8.0, width) == words
    short = shorten_text(words, 8.0, 0.6 * width)
    assert short.endswith("…")
    assert text_width(short, 8.0) <= 0.6 * width
    longer = words[: len(short)] + "…"
    assert text_width(longer, 8.0) > 0.6 * width - text_width("m", 8.0)
    assert shorten_text(words, 8.0, 1.0) == "J…"
    assert text_width("MM", 16.0) == pytest.approx(2.0 * text_width("MM", 8.0), rel=0.02)
    assert text_width("  ", 10.0) == pytest.approx(6.0)
    assert text_width("$x^{$", 8.0) > text_width("x", 8.0)


def luminance(color: str) -> float:
    """Of WCAG 2."""
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in to_rgb(color)]
    return float(np.dot([0.2126, 0.7152, 0.0722], linear))


def contrast(a: str, b: str) -> float:
    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


DEEP = ["#000000", "#0072b2", "#0072B2", "#101060", "#301010", "#204020", "#404040", "#663300"]


@pytest.mark.parametrize("color", DEEP)
def test_dark_colours_are_lightened_on_a_dark_net_and_kept_on_a_light_one(color: str) -> None:
    dark = NetStyle.dark()
    assert contrast(dark.color(color), dark.net) >= 3.0
    assert NetStyle().color(color) == color


@pytest.mark.parametrize("color", ["#ffffff", "#e69f00", "#56b4e9"])
def test_colours_visible_on_a_dark_net_are_kept(color: str) -> None:
    assert NetStyle.dark().color(color) == color


def test_replaced_colours_are_matched_in_any_case() -> None:
    assert NetStyle.dark().color("#0072b2") == NetStyle.dark().color("#0072B2") == "#3d9be0"


@pytest.mark.parametrize("color", ["#f0e442", "#ffffe0", "#ffffff", "#000000", "#d55e00"])
def test_thin_lines_keep_contrast_to_their_background(color: str) -> None:
    style = NetStyle()
    drawn = style.outline(color)
    assert contrast(drawn, style.net) >= 1.8
    assert (drawn == color) == (contrast(color, style.net) >= 1.8)


def test_variants_of_a_set_cycle_through_full_open_pale_and_deep() -> None:
    style = NetStyle()
    (s,) = make_sets({"a": BEDS})
    faces = [style.symbol(replace(s, variant=k))[0] for k in range(5)]
    assert faces[0] == faces[4] == s.color
    assert faces[1] == style.net
    assert luminance(faces[3]) < luminance(faces[0]) < luminance(faces[2]) < luminance(faces[1])
    edges = [style.symbol(replace(s, variant=k))[1] for k in range(4)]
    assert edges == [style.net, s.color, s.color, style.net]
    cross = replace(s, marker="P")
    assert style.symbol(cross)[:2] == (s.color, s.color)


def test_symbols_shrink_with_their_number() -> None:
    sizes = [symbol_scale(n) for n in (0, 1, 100, 300, 1000, 10_000, 10**6)]
    assert sizes[:3] == [1.0, 1.0, 1.0]
    assert sizes[4:] == [0.7, 0.4, 0.4]
    assert 0.7 < sizes[3] < 1.0


def test_dock_sizes_are_in_screen_pixels() -> None:
    coarse, fine = NetStyle.dock(dpi=72.0, font_px=12.0), NetStyle.dock(dpi=144.0, font_px=12.0)
    assert coarse.font_pt == pytest.approx(12.0)
    for name in ("font_pt", "marker_pt", "line_pt"):
        assert getattr(fine, name) == pytest.approx(getattr(coarse, name) / 2.0)
    assert NetStyle.dock(dark=True).paper == NetStyle.dark().paper


# Selected features


def ids(net: NetContents) -> NetContents:
    named = tuple(replace(s, ids=tuple(f"{s.name}{i}" for i in range(len(s)))) for s in net.sets)
    return replace(net, sets=named)


def rings(artists: NetArtists) -> list[Line2D]:
    return [a for a in artists.emphasis if isinstance(a, Line2D) and a.get_marker() != "None"]


def test_selected_features_get_rings_and_great_circles() -> None:
    net = ids(NetContents(make_sets({"b": BEDS, "s": STRIAE}), circles=False))
    artists = draw(replace(net, selected=frozenset({"b0", "b2", "s1", "nothing"})))
    beds, striae = rings(artists)
    for ring, s, rows in ((beds, net.sets[0], [0, 2]), (striae, net.sets[1], [1])):
        assert places(ring) == pytest.approx(project(s.vectors()[rows], "area"))
        assert ring.get_marker() == s.marker
    plain = artists.poles[0].get_markersize()
    assert beds.get_markersize() > 1.15 * plain
    circles = [a for a in artists.emphasis if isinstance(a, LineCollection)]
    assert [len(c.get_segments()) for c in circles] == [2, 2]
    under, over = circles
    assert under.get_linewidths()[0] > over.get_linewidths()[0]
    assert under.get_zorder() < over.get_zorder() < beds.get_zorder()
    pole = Plane(130, 40).pole().vector()
    from vomstudio.geology.stereonet import line_at

    for x, y in parts(over)[0][10:-10:20]:
        line = line_at(float(x), float(y), "area")
        assert line is not None
        assert line.vector() @ pole == pytest.approx(0.0, abs=1e-6)
    assert draw(net).emphasis == []


def test_circles_of_a_large_selection_are_omitted_if_poles_are_shown() -> None:
    net = ids(NetContents(make_sets({"b": some(60)}), circles=False))
    everything = frozenset(net.sets[0].ids)
    few = frozenset(list(net.sets[0].ids)[:MAX_AUTOMATIC_CIRCLES])

    def circles(shown: NetContents) -> int:
        return sum(isinstance(a, LineCollection) for a in draw(shown).emphasis)

    assert circles(replace(net, selected=few)) == 2
    assert circles(replace(net, selected=everything)) == 0
    assert circles(replace(net, selected=everything, poles=False)) == 2


def test_rings_of_thousands_are_thin_and_small() -> None:
    one = ids(NetContents(make_sets({"b": some(10)}), circles=False))
    many = ids(NetContents(make_sets({"b": some(3000)}), circles=False))
    (single,) = rings(draw(replace(one, selected=frozenset({"b1"}))))
    (crowd,) = rings(draw(replace(many, selected=frozenset(many.sets[0].ids))))
    assert crowd.get_markeredgewidth() < 0.5 * single.get_markeredgewidth()
    assert crowd.get_markersize() < single.get_markersize()


@pytest.mark.parametrize("projection", ["area", "angle"])
def test_ellipse_of_the_selected_feature_is_drawn(projection: str) -> None:
    ellipse = NetEllipse(Plane(130, 40), 6, 2, 70)
    net = NetContents(make_sets({"b": BEDS}), projection=projection, ellipses=(ellipse,))
    (drawn,) = [a for a in draw(net).emphasis if isinstance(a, Line2D)]
    (outline,) = ellipse.outline()
    assert places(drawn) == pytest.approx(project(outline, projection), abs=1e-9)


def test_pointer_finds_a_pole_within_its_radius_and_the_last_of_equals() -> None:
    net = ids(NetContents(make_sets({"a": BEDS, "b": BEDS}), circles=True))
    artists = draw(net)
    x, y = project(net.sets[0].vectors()[1], "area")[0] * artists.radius_px + artists.centre_px
    assert artists.feature_at(x, y) == "b1"
    far = project(Plane(134, 42).normal()[None] * -1, "area")
    assert far.shape == (1, 2)
    alone = ids(NetContents(make_sets({"a": ("plane", [134.0], [42.0])}), circles=False))
    artists = draw(alone)
    x, y = project(alone.sets[0].vectors()[0], "area")[0] * artists.radius_px + artists.centre_px
    assert artists.feature_at(x + 5.9, y) == "a0"
    assert artists.feature_at(x + 6.1, y) is None
    assert artists.feature_at(x, y + 11.0, max_distance_px=12.0) == "a0"
    circle = draw(replace(alone, circles=True, poles=False))
    on = project(Line(134, 42).vector(), "area")[0] * circle.radius_px + circle.centre_px
    toward = (np.array(circle.centre_px) - on) / np.linalg.norm(np.array(circle.centre_px) - on)
    assert circle.feature_at(*(on + 2.8 * toward)) == "a0"
    assert circle.feature_at(*(on + 3.3 * toward)) is None
    assert circle.feature_at(*(on + 3.3 * toward), max_distance_px=8.0) == "a0"
    assert circle.to_net(*circle.centre_px) == pytest.approx((0.0, 0.0))


def test_an_ellipse_is_enlarged_to_the_total_error() -> None:
    """What is added is the same in both directions; a free turn about a line adds nothing."""
    plane = Plane(120.0, 40.0)
    same = NetEllipse.enlarge_to_total(plane, 3.0, 1.0, 20.0, 3.0)
    assert (same.max_angle_deg, same.min_angle_deg) == pytest.approx((3.0, 1.0))
    expand = NetEllipse.enlarge_to_total(plane, 3.0, 1.0, 20.0, 5.0)
    assert (expand.max_angle_deg, expand.min_angle_deg) == pytest.approx((5.0, math.sqrt(17.0)))
    free = NetEllipse.enlarge_to_total(plane, 3.0, 1.0, 20.0, 90.0)
    assert (free.max_angle_deg, free.min_angle_deg) == pytest.approx((90.0, 1.0))
