"""The drawn net: what it says, where things are, that nothing overlaps or is cut off."""

from __future__ import annotations

import time
import warnings
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tests.tiers import first_in_default_tier
from vomstudio.core.errors import UsageError
from vomstudio.geology.density import DENSITY_METHODS, DENSITY_UNITS
from vomstudio.geology.folds import fold_axis
from vomstudio.geology.orientation import Line, Plane, angle_between_lines, normals_to_planes
from vomstudio.geology.stereonet import vectors_to_longitude_latitude
from vomstudio.products.net.contents import NetContents, NetEllipse, compute_means, make_sets
from vomstudio.products.net.figure import NetArtists, draw_stereonet, write_stereonet
from vomstudio.products.net.figure_options import SIZE_MM
from vomstudio.products.net.legend import SYMBOLS
from vomstudio.products.net.page import PROJECTION_NAMES
from vomstudio.products.net.style import PRINT, NetStyle


def cluster(dip_direction: float, dip: float, n: int, spread: float) -> tuple:
    rng = np.random.default_rng(n)
    normals = Plane(dip_direction, dip).normal() + np.radians(spread) * rng.normal(size=(n, 3))
    return "plane", *normals_to_planes(normals)[:2]


GROUPS = {
    "Bedding": cluster(132, 41, 12, 4),
    "Fault": cluster(300, 75, 2, 3),
    "Joints": cluster(40, 82, 20, 6),
    "Striae": ("line", np.array([310.0, 315, 305, 300]), np.array([55.0, 60, 58, 61])),
}
SETS = make_sets(GROUPS, {k: [f"{k}{i}" for i in range(len(v[1]))] for k, v in GROUPS.items()})
FULL = NetContents(
    SETS,
    means=compute_means(SETS),
    fold=fold_axis(SETS[0].azimuth_deg, SETS[0].angle_deg),
    selected=frozenset({"Bedding3"}),
    ellipses=(NetEllipse(Plane(132, 41), 6, 2, 70),),
)
EMPTY = NetContents()
MANY = make_sets(
    {f"Joint set {i} of the upper unit": cluster(30 * i, 60 + i, 9, 5) for i in range(12)}
)
CROWDED = NetContents(MANY, means=compute_means(MANY))


def draw(
    net: NetContents, width: int = 360, height: int = 360, style: NetStyle | None = None
) -> tuple[Figure, NetArtists]:
    figure = Figure(figsize=(width / 100, height / 100), dpi=100)
    FigureCanvasAgg(figure)
    return figure, draw_stereonet(figure, net, style or NetStyle.dock())


def texts(artists: NetArtists) -> list[str]:
    return [t.get_text() for t in artists.axes.texts]


def pixel(artists: NetArtists, line: Line) -> tuple[float, float]:
    x, y = artists.axes.transData.transform(vectors_to_longitude_latitude(line.vector()))
    return float(x), float(y)


def test_net_states_its_projection_and_contents() -> None:
    _, artists = draw(FULL, 600, 400)
    words = texts(artists)
    assert "N" in words
    assert PROJECTION_NAMES["area"] in words
    for s in SETS:
        assert any(w.startswith(f"{s.name}, ") and f"(n = {len(s)})" in w for w in words)
    assert any(w.startswith("β ") for w in words)
    assert any("joint 95 %" in w for w in words)
    _, artists = draw(replace(FULL, projection="angle"))
    assert PROJECTION_NAMES["angle"] in texts(artists)


@pytest.mark.parametrize(
    ("width", "height"),
    first_in_default_tier([(360, 360), (300, 420), (520, 360), (1000, 700), (420, 300)], 6),
)
@pytest.mark.parametrize(
    "net",
    first_in_default_tier(
        [FULL, replace(FULL, contour="schmidt"), CROWDED, replace(CROWDED, contour="kamb"), EMPTY],
        6,
    ),
    ids=["full", "contoured", "crowded", "crowded and contoured", "empty"],
)
def test_texts_neither_overlap_nor_are_cut_off(net: NetContents, width: int, height: int) -> None:
    figure, artists = draw(net, width, height)
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    boxes = {t.get_text(): t.get_window_extent(renderer) for t in artists.axes.texts}
    for text, box in boxes.items():
        assert box.x0 >= 0, text
        assert box.y0 >= 0, text
        assert box.x1 <= width, text
        assert box.y1 <= height, text
    for (a, one), (b, other) in combinations(boxes.items(), 2):
        apart = (
            one.x1 <= other.x0 + 1
            or other.x1 <= one.x0 + 1
            or one.y1 <= other.y0 + 1
            or other.y1 <= one.y0 + 1
        )
        assert apart, (a, b)


def test_text_is_large_enough_to_read() -> None:
    _, dock = draw(FULL)
    assert min(t.get_fontsize() for t in dock.axes.texts) * 100 / 72 >= 9
    figure = Figure(figsize=tuple(v / 25.4 for v in SIZE_MM), dpi=100)
    FigureCanvasAgg(figure)
    printed = draw_stereonet(figure, FULL, PRINT)
    assert min(t.get_fontsize() for t in printed.axes.texts) >= 7


def test_the_net_is_round_and_inside_the_figure() -> None:
    for size in ((360, 360), (300, 500), (700, 360)):
        _, artists = draw(FULL, *size)
        east, north = pixel(artists, Line(90, 0)), pixel(artists, Line(0, 0))
        centre = pixel(artists, Line(0, 90))
        assert centre == pytest.approx(artists.centre_px)
        assert east[0] - centre[0] == pytest.approx(artists.radius_px)
        assert north[1] - centre[1] == pytest.approx(artists.radius_px)
        assert artists.radius_px > 0.25 * min(size)


def test_a_click_finds_the_nearest_feature_and_the_line_under_it() -> None:
    _, artists = draw(replace(FULL, circles=False))
    for s, name in ((SETS[1], "Fault1"), (SETS[3], "Striae2")):
        row = s.ids.index(name)
        line = Line.from_vector(s.vectors()[row])
        x, y = pixel(artists, line)
        assert artists.feature_at(x + 1, y - 1) == name
        result = artists.line_at(x, y)
        assert result is not None
        assert angle_between_lines(result, line) < 1e-6
    assert artists.feature_at(*artists.centre_px) is None
    assert artists.line_at(1, 1) is None


def test_a_click_on_a_great_circle_finds_its_plane() -> None:
    _, artists = draw(NetContents(SETS[1:2]))
    plane = Plane(float(SETS[1].azimuth_deg[0]), float(SETS[1].angle_deg[0]))
    x, y = pixel(artists, Line(plane.dip_direction_deg, plane.dip_deg))
    assert artists.feature_at(x, y) == "Fault0"
    _, bare = draw(NetContents(SETS[1:2], circles=False))
    assert bare.feature_at(x, y) is None


def test_lasso_selects_the_features_inside_it() -> None:
    _, artists = draw(FULL)
    w, h = 2 * artists.centre_px[0], 360.0
    assert len(artists.features_in_polygon([(0, 0), (w, 0), (w, h), (0, h)])) == 38
    x, y = pixel(artists, Line.from_vector(SETS[1].vectors()[0]))
    square = [(x - 2, y - 2), (x + 2, y - 2), (x + 2, y + 2), (x - 2, y + 2)]
    assert "Fault0" in artists.features_in_polygon(square)


def test_selection_is_highlighted_in_the_set_colour_and_can_be_cleared() -> None:
    _, artists = draw(replace(FULL, selected=frozenset(), ellipses=()))
    count = len(artists.axes.get_children())
    artists.select({"Joints4"})
    symbols = [line for line in artists.emphasis if isinstance(line, Line2D)]
    fills = {line.get_markerfacecolor() for line in symbols if line.get_marker() == "^"}
    assert fills == {SETS[2].color}
    assert len(artists.axes.get_children()) > count
    artists.select(())
    assert len(artists.axes.get_children()) == count


def test_legend_names_the_ellipse_only_while_one_is_drawn() -> None:
    figure, artists = draw(replace(FULL, selected=frozenset(), ellipses=()))
    name = SYMBOLS["pole-ellipse"]
    assert name not in texts(artists)
    artists.select({"Bedding3"}, FULL.ellipses)
    assert name in texts(artists)
    assert artists.axes in figure.axes
    artists.select({"Bedding4"})
    assert name not in texts(artists)


def test_thousands_of_great_circles_are_one_collection() -> None:
    many = make_sets({"Facets": cluster(132, 41, 1000, 20)})
    _, artists = draw(NetContents(many, circles=True))
    circles = [
        c
        for c in artists.axes.collections
        if isinstance(c, LineCollection) and len(c.get_segments()) == 1000
    ]
    assert len(circles) == 1
    _, artists = draw(NetContents(many))
    assert not artists.arcs[0].size  # too many to see the poles: left out unless asked


def test_ten_thousand_poles_are_drawn_within_a_quarter_of_a_second() -> None:
    many = make_sets(
        {"Facets": cluster(132, 41, 10_000, 20)}, {"Facets": [str(i) for i in range(10_000)]}
    )
    draw(NetContents(many))
    best = np.inf
    for _ in range(3):
        start = time.process_time()
        figure, artists = draw(NetContents(many))
        figure.canvas.draw()
        best = min(best, time.process_time() - start)
    assert best < 0.25  # some 0.04 s where nothing else runs
    assert artists.feature_at(*pixel(artists, Line.from_vector(many[0].vectors()[7]))) == "7"


@pytest.mark.parametrize("method", DENSITY_METHODS)
def test_contours_have_levels_and_a_bar_with_units(method: str) -> None:
    _, artists = draw(replace(FULL, contour=method), 700, 450)
    words = texts(artists)
    assert DENSITY_UNITS[method] in words
    levels = sorted(float(w) for w in words if w.replace(".", "").isdigit())
    assert 1 <= len(levels) <= 8
    draw(replace(EMPTY, contour=method))


def test_an_unknown_contour_or_format_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="exponential_kamb"):
        draw(replace(FULL, contour="heat"))
    with pytest.raises(UsageError, match="svg"):
        write_stereonet(tmp_path / "net.bmp", FULL, format="bmp")


@pytest.mark.parametrize("format", first_in_default_tier(["svg", "pdf", "png"]))
def test_svg_figures_contain_text_as_text(tmp_path: Path, format: str) -> None:
    out = tmp_path / f"net.{format}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write_stereonet(out, FULL, format=format)
    data = out.read_bytes()
    if format == "svg":
        words = "".join(ElementTree.fromstring(data).itertext())
        assert PROJECTION_NAMES["area"] in words
        assert "Bedding, poles (n = 12)" in words
    else:
        assert data.startswith({"pdf": b"%PDF", "png": b"\x89PNG"}[format])


@pytest.mark.parametrize("size_mm", [SIZE_MM, (90.0, 140.0)])
def test_figure_has_the_requested_size(tmp_path: Path, size_mm: tuple[float, float]) -> None:
    from PIL import Image

    net = NetContents(SETS[1:2])
    write_stereonet(
        tmp_path / "net.png",
        net,
        format="png",
        width_mm=size_mm[0],
        height_mm=size_mm[1],
        dpi=100.0,
    )
    with Image.open(tmp_path / "net.png") as picture:
        assert picture.size == pytest.approx([100.0 * v / 25.4 for v in size_mm], abs=1.0)
        assert picture.info["dpi"] == pytest.approx((100.0, 100.0), abs=0.1)
    write_stereonet(
        tmp_path / "net.svg", net, format="svg", width_mm=size_mm[0], height_mm=size_mm[1]
    )
    top = ElementTree.parse(tmp_path / "net.svg").getroot()
    points = [float(str(top.get(name)).removesuffix("pt")) for name in ("width", "height")]
    assert points == pytest.approx([72.0 * v / 25.4 for v in size_mm])


@pytest.mark.parametrize(
    ("count", "width_mm"),
    first_in_default_tier(
        [(1, 85.0), (4, 85.0), (9, 85.0), (1, 170.0), (4, 170.0), (9, 170.0), (14, 170.0)], 2
    ),
)
def test_figure_height_fits_its_texts(tmp_path: Path, count: int, width_mm: float) -> None:
    """Nothing is left out, and the net does not shrink for it."""
    planes = ("plane", [10.0, 14.0, 12.0], [20.0, 21.0, 23.0])
    sets = make_sets({f"bedding of the limb {i}": planes for i in range(count)}, {})
    messages = tuple(f"{s.name}: n = 3, Fisher mean 012/21, kappa 1,200, alpha95 2.3" for s in sets)
    net = NetContents(sets, averages=messages, contour="schmidt")
    write_stereonet(tmp_path / "net.svg", net, format="svg", width_mm=width_mm)
    top = ElementTree.parse(tmp_path / "net.svg").getroot()
    height_mm = float(str(top.get("height")).removesuffix("pt")) / 72.0 * 25.4
    assert SIZE_MM[1] - 0.1 <= height_mm <= 240.1
    words = " ".join("".join(top.itertext()).split())
    assert "…" not in words
    assert words.count("Fisher mean") == count
    figure = Figure(figsize=(width_mm / 25.4, height_mm / 25.4), dpi=100)
    artists = draw_stereonet(figure, net)
    assert 2.0 * artists.radius_px / 100.0 * 25.4 >= min(0.7 * width_mm, 75.0) - 0.1


@pytest.mark.parametrize("name", ["$x^{$", "a$b$c", "$"])
def test_names_with_dollar_signs_are_drawn_literally(tmp_path: Path, name: str) -> None:
    sets = make_sets({name: ("plane", [10, 30], [20, 20]), "b": ("plane", [90], [40])}, {})
    out = tmp_path / "net.svg"
    write_stereonet(out, NetContents(sets=sets), format="svg")
    words = "".join(ElementTree.fromstring(out.read_bytes()).itertext())
    assert f"{name}, poles (n = 2)" in words


def test_non_numeric_rows_are_left_out_with_their_ids() -> None:
    (s,) = make_sets({"a": ("plane", [10, np.nan, 30], [20, 20, 20])}, {"a": ["x", "y", "z"]})
    assert s.ids == ("x", "z")
    assert len(s) == 2


def test_every_theme_separates_colours_from_the_background() -> None:
    for style in (NetStyle(), NetStyle.dark()):
        assert style.ink != style.net
        assert style.color("#000000") != style.net
    figure, _ = draw(FULL, style=NetStyle.dock(dark=True))
    assert figure.get_facecolor()[:3] < (0.3, 0.3, 0.3)


@pytest.mark.parametrize("width", [700, 380])
def test_contour_bar_has_even_steps_labelled_with_their_levels(width: int) -> None:
    from matplotlib.patches import Rectangle

    figure, artists = draw(replace(FULL, contour="kamb"), width, 450)
    bar = [p for p in artists.axes.patches if isinstance(p, Rectangle)]
    levels = [t for t in artists.axes.texts if t.get_text().replace(".", "").isdigit()]
    assert len(bar) == len(levels) > 1
    steps = [box.get_height() for box in bar]
    assert steps == pytest.approx([steps[0]] * len(bar))
    for below, above in pairwise(bar):
        assert above.get_y() == pytest.approx(below.get_y() + below.get_height())
        assert above.get_x() == below.get_x()
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    result = sorted((t.get_window_extent(renderer).y0, float(t.get_text())) for t in levels)
    assert [value for _, value in result] == sorted(value for _, value in result)


@pytest.mark.parametrize(("width", "height"), [(700, 450), (360, 420)])
def test_title_is_above_all_other_texts_of_its_column(width: int, height: int) -> None:
    net = replace(FULL, title="Limb of the Big Elk", notes=("north known",))
    figure, artists = draw(net, width, height)
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    boxes = {t.get_text(): t.get_window_extent(renderer) for t in artists.axes.texts}
    (title,) = [box for text, box in boxes.items() if text.startswith("Limb")]
    legend = [box for text, box in boxes.items() if text.startswith("Bedding")]
    assert legend
    assert title.y0 > max(box.y1 for box in legend)
    assert any("north known" in text for text in boxes)
