"""Symbols and letters of a net can be read, and are told apart by nothing but what is meant."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.markers import MarkerStyle
from PIL import Image
from shapely.geometry import Polygon

from tests.products.test_net_parts import BEDS, DEEP, contrast
from vomstudio.products.net.contents import MARKERS, NetContents, make_sets
from vomstudio.products.net.figure import draw_stereonet, write_stereonet
from vomstudio.products.net.figure_options import SIZE_MM
from vomstudio.products.net.style import PRINT, SYMBOL_SIZES, NetStyle, _contrast


@pytest.mark.parametrize("marker", sorted({*MARKERS, *SYMBOL_SIZES}))
def test_symbols_of_one_size_cover_similar_areas(marker: str) -> None:
    """Within a factor of 1.5 of a circle's, by their outlines as matplotlib has them."""

    def area(name: str, size: float) -> float:
        style = MarkerStyle(name)
        outline = style.get_path().transformed(style.get_transform())
        polygons = [Polygon(part) for part in outline.to_polygons() if len(part) > 3]
        return float(sum(polygon.area for polygon in polygons)) * size**2

    circle = area("o", 1.0)
    assert circle == pytest.approx(np.pi / 4.0, rel=0.02)
    assert 1 / 1.5 < area(marker, SYMBOL_SIZES.get(marker, 1.0)) / circle < 1.5


def test_a_printed_net_has_the_sizes_of_a_figure_in_a_journal() -> None:
    """As wide as a page's text, letters of 6 to 10 points, lines of a quarter of a millimetre."""
    width, height = SIZE_MM
    assert 140.0 < width < 190.0
    assert 0.5 < height / width < 1.0
    assert 6.0 < PRINT.font_pt < 10.0
    assert 1.0 < PRINT.marker_pt * 25.4 / 72.0 < 2.5
    assert 0.18 < PRINT.line_pt * 25.4 / 72.0 < 0.5
    assert PRINT.contour_map == "light"


def test_screen_net_has_font_and_symbol_sizes_of_a_window() -> None:
    dock = NetStyle.dock()
    px = 100.0 / 72.0
    assert dock == NetStyle.dock(False, 100.0)
    assert 9.0 < dock.font_pt * px < 14.0
    assert 4.0 < dock.marker_pt * px < 9.0
    assert 0.9 < dock.line_pt * px < 1.8
    assert dock.paper == NetStyle().paper


@pytest.mark.parametrize("color", DEEP)
def test_dark_colour_is_lightened_only_as_far_as_needed(color: str) -> None:
    """So that it is still known for what it is: three to one is enough, a little more a step."""
    dark = NetStyle.dark()
    if color.casefold() in {name.casefold() for name in dark.color_replacements}:
        return
    lifted = dark.color(color)
    assert 3.0 <= contrast(lifted, dark.net) < 4.2
    # On the way to the ink, and nowhere else.
    share = (np.array(to_rgb(lifted)) - to_rgb(color)) / (
        np.array(to_rgb(dark.ink)) - to_rgb(color)
    )
    assert np.ptp(share) < 0.03


@pytest.mark.parametrize("net", ["#2a2b2e", "#606060", "#7f7f7f", "#b0b0b0", "#ffffff"])
def test_colours_are_lightened_only_on_dark_nets(net: str) -> None:
    """Darker than a fifth of white: there the ink is light."""
    style = replace(NetStyle(), net=net, ink="#e8e8e8")
    lifted = style.color("#203040") != "#203040"
    assert lifted == (net in ("#2a2b2e", "#606060"))


@pytest.mark.parametrize("color", ["#0072B2", "#D55E00", "#009E73", "#CC79A7"])
def test_pale_and_deep_symbols_are_halfway_to_background_and_ink(
    color: str,
) -> None:
    style = NetStyle()
    (s,) = make_sets({"a": BEDS})
    for variant, end in ((2, style.net), (3, style.ink)):
        face = style.symbol(replace(s, color=color, variant=variant))[0]
        middle = (np.array(to_rgb(color)) + to_rgb(end)) / 2
        assert np.abs(np.array(to_rgb(face)) - middle).max() < 1.0 / 255.0


def test_net_is_written_at_300_dpi_by_default(tmp_path: Path) -> None:
    """300, unless it is said otherwise."""
    write_stereonet(tmp_path / "net.png", NetContents(), format="png")
    with Image.open(tmp_path / "net.png") as picture:
        expected = np.array(SIZE_MM) / 25.4 * 300.0
        assert picture.size == pytest.approx(expected, abs=1.0)


@pytest.mark.parametrize(("reach", "within"), [(2.0, 2.0), (3.0, 2.0), (6.0, 3.0), (20.0, 10.0)])
def test_great_circle_has_half_the_pick_radius_of_a_pole_but_two_pixels_at_least(
    reach: float, within: float
) -> None:
    """A vertical plane: its great circle is a straight line across the net."""
    sets = make_sets({"a": ("plane", [90.0], [90.0])}, {"a": ["x"]})
    figure = Figure(figsize=(4, 4), dpi=100)
    FigureCanvasAgg(figure)
    artists = draw_stereonet(figure, NetContents(sets, poles=False), NetStyle.dock())
    x, y = artists.centre_px
    for away in (-within, within):
        for up in (0.0, 30.0, -0.9 * artists.radius_px):
            assert artists.feature_at(x + 0.98 * away, y + up, reach) == "x"
            assert artists.feature_at(x + 1.02 * away, y + up, reach) is None
    top = y + artists.radius_px
    assert artists.feature_at(x, top + 0.95 * within, reach) == "x"
    assert artists.feature_at(x, top + 1.05 * within, reach) is None


@pytest.mark.parametrize("projection", ["area", "angle"])
def test_contours_stay_inside_the_net(projection: str) -> None:
    """Steep planes of all directions: their poles are dense along the rim."""
    turn = np.arange(0.0, 360.0, 6.0)
    sets = make_sets({"a": ("plane", turn, np.full(60, 88.0))})
    figure = Figure(figsize=(6, 4), dpi=100)
    canvas = FigureCanvasAgg(figure)
    net = NetContents(sets, contour="kamb", projection=projection, poles=False)
    artists = draw_stereonet(figure, net, NetStyle.dock())
    canvas.draw()
    picture = np.asarray(canvas.buffer_rgba())[::-1]
    y, x = np.mgrid[: picture.shape[0], : picture.shape[1]] + 0.5
    cx, cy = artists.centre_px
    away = np.hypot(x - cx, y - cy) / artists.radius_px
    outside = (away > 1.1) & (np.abs(x - cx) < 1.02 * artists.radius_px)
    for x0, y0, x1, y1 in artists.text_boxes:
        outside &= (x < x0 - 3) | (x > x1 + 3) | (y < y0 - 3) | (y > y1 + 3)
    assert outside.sum() > 1000
    assert (picture[outside] == 255).all()
    near = (away > 0.9) & (away < 0.98)
    assert (picture[near][:, :3] < 250).any(axis=1).mean() > 0.8


def test_contrast_follows_the_web_content_guidelines() -> None:
    """Of any two colours, deep blue ones too."""
    rng = np.random.default_rng(0)
    for a, b in zip(rng.uniform(size=(60, 3)), rng.uniform(size=(60, 3)), strict=True):
        one, other = to_hex(a), to_hex(b * [0.02, 0.02, 1.0])
        assert _contrast(one, other) == pytest.approx(contrast(one, other))
    assert _contrast("#0000ff", "#ffffff") == pytest.approx(8.592, abs=1e-3)
    assert _contrast("#000000", "#ffffff") == pytest.approx(21.0)
