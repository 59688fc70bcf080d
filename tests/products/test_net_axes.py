"""Nets are drawn on the axes of mplstereonet, where closed forms and the library have things."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from tests.products.net_places import parts, places
from vomstudio.geology.density import DENSITY_METHODS, choose_round_levels, density_grid, grid_size
from vomstudio.geology.folds import fold_axis
from vomstudio.geology.orientation import Line, lines_to_vectors
from vomstudio.geology.stereonet import vectors_to_longitude_latitude
from vomstudio.products.net.contents import (
    MAX_AUTOMATIC_CIRCLES,
    NetCircle,
    NetContents,
    NetMark,
    compute_means,
    make_sets,
)
from vomstudio.products.net.figure import draw_stereonet
from vomstudio.products.net.figure_style import FigureStyle
from vomstudio.products.net.net_axes import add_net, import_mplstereonet, is_stereonet_axes
from vomstudio.products.net.script_net import create_axes, draw_net
from vomstudio.products.net.style import NetStyle

rng = np.random.default_rng(11)
BEDS = (60 + 5 * rng.normal(size=30)) % 360, 40 + 5 * rng.normal(size=30)
LINES = np.array([200.0, 210.0, 205.0]), np.array([10.0, 12.0, 20.0])
PROJECTIONS = ["area", "angle"]


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    with mpl.rc_context({"backend": "agg"}):
        yield
        plt.close("all")


def contents(**more: Any) -> NetContents:
    sets = make_sets({"Bedding": ("plane", *BEDS), "Striae": ("line", *LINES)})
    return NetContents(sets, means=compute_means(sets), **more)


def page(net: NetContents) -> Any:
    figure = Figure(figsize=(6, 4), dpi=100)
    FigureCanvasAgg(figure)
    return draw_stereonet(figure, net, NetStyle()).axes


def script(net: NetContents) -> Any:
    ax = create_axes(net, FigureStyle())
    draw_net(ax, net)
    return ax


def marks(ax: Any, symbol: str) -> list[Any]:
    """Symbols on the net; those of the legend are elsewhere."""
    lines = [line for line in ax.lines if line.get_marker() == symbol]
    return [line for line in lines if np.hypot(*places(line).T).max() <= 1.0 + 1e-9]


@pytest.mark.parametrize("door", [page, script])
@pytest.mark.parametrize("projection", PROJECTIONS)
def test_every_entry_point_draws_on_mplstereonet_axes(door: Any, projection: str) -> None:
    ax = door(contents(projection=projection))
    assert ax.name == f"equal_{projection}_stereonet"
    assert is_stereonet_axes(ax)
    assert not is_stereonet_axes(plt.figure().add_subplot())
    box = ax.get_window_extent()
    assert box.width == pytest.approx(box.height)


@pytest.mark.parametrize("door", [page, script])
@pytest.mark.parametrize("projection", PROJECTIONS)
def test_poles_are_at_the_radius_of_the_projection(door: Any, projection: str) -> None:
    """sqrt(2) sin(dip / 2) for equal areas, tan(dip / 2) for equal angles, against the dip."""
    azimuth = np.array([0.0, 37, 90, 180, 211, 270, 359])
    dip = np.array([0.0, 12, 45, 60, 89, 90, 90])
    net = NetContents(make_sets({"a": ("plane", azimuth, dip)}), projection=projection)
    (poles,) = marks(door(net), "o")
    half = np.radians(dip / 2)
    radius = math.sqrt(2.0) * np.sin(half) if projection == "area" else np.tan(half)
    up = np.radians(azimuth + 180.0)
    expected = np.stack([radius * np.sin(up), radius * np.cos(up)], axis=1)
    assert places(poles) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("door", [page, script])
@pytest.mark.parametrize("projection", PROJECTIONS)
def test_mplstereonet_artists_coincide_with_ours(door: Any, projection: str) -> None:
    """Poles, lines, great circles and cones, which the library adds to the same axes."""
    cone = NetCircle(Line(210.0, 50.0), 20.0, "Cone")
    mark = NetMark(Line(33.0, 21.0), "mark")
    ax = door(contents(projection=projection, user_circles=(cone,), marks=(mark,)))
    beds, striae = contents().sets
    (poles,) = (line for line in marks(ax, beds.marker) if len(places(line)) == 30)
    (lines,) = (line for line in marks(ax, striae.marker) if len(places(line)) == 3)
    (circles,) = [
        c
        for c in ax.collections
        if isinstance(c, LineCollection) and len(c.get_segments()) == len(beds)
    ]
    (small,) = [line for line in ax.lines if line.get_linestyle() == ":" and len(places(line)) > 9]
    (cross, *_) = marks(ax, "x")
    strike = BEDS[0] - 90.0
    (theirs,) = ax.pole(strike, BEDS[1].copy())
    assert places(poles) == pytest.approx(places(theirs), abs=1e-9)
    (theirs,) = ax.plot(*import_mplstereonet().line(LINES[1].copy(), LINES[0].copy()))
    assert places(lines) == pytest.approx(places(theirs), abs=1e-9)
    (theirs,) = ax.line(21.0, 33.0)
    assert places(cross) == pytest.approx(places(theirs), abs=1e-9)
    for ours, theirs in zip(parts(circles), ax.plane(strike, BEDS[1].copy()), strict=True):
        away = np.linalg.norm(ours[:, None] - places(theirs)[None], axis=2)
        assert away.min(axis=1).max() < 0.02  # half of a step of theirs
    curve = parts(ax.cone(50.0, 210.0, 20.0, segments=1441, bidirectional=False))[0]
    away = np.linalg.norm(places(small)[:, None] - curve[None], axis=2)
    assert away.min(axis=1).max() < 2e-3


@pytest.mark.parametrize("door", [page, script])
def test_fold_axis_has_the_same_position_from_every_entry_point(door: Any) -> None:
    fold = fold_axis([100, 220, 160, 130], [30, 55, 42, 30])
    ax = door(NetContents(fold=fold))
    (star,) = marks(ax, "*")
    (theirs,) = ax.line(fold.beta.plunge_deg, fold.beta.trend_deg)
    assert places(star) == pytest.approx(places(theirs), abs=1e-9)


def test_great_circles_of_many_planes_are_left_out() -> None:
    many = MAX_AUTOMATIC_CIRCLES + 1
    sets = make_sets({"Joints": ("plane", np.linspace(0, 300, many), np.full(many, 50.0))})
    ax = script(NetContents(sets))
    assert all(line.get_linestyle() == "None" for line in ax.lines)
    assert not any(len(c.get_paths()) == many for c in ax.collections)


def test_script_legend_counts_each_set_and_describes_each_mean() -> None:
    texts = [text.get_text() for text in script(contents()).get_legend().get_texts()]
    assert texts[:2] == ["Bedding, poles (n = 30)", "Striae, lines (n = 3)"]
    assert [text.split()[0] for text in texts[2:]] == ["Mean", "Mean"]


@pytest.mark.parametrize("contour", [None, "kamb"])
def test_script_legend_is_placed_beside_the_net(contour: str | None) -> None:
    ax = script(contents(contour=contour))
    ax.figure.canvas.draw()
    legend, net = ax.get_legend().get_window_extent(), ax.get_window_extent()
    assert net.x1 <= legend.x0
    assert legend.x0 - net.x1 < 0.12 * net.width
    assert legend.x1 <= ax.figure.bbox.x1
    assert 0 <= legend.y0 < legend.y1 <= ax.figure.bbox.y1


def test_a_script_can_show_a_grid_and_azimuths() -> None:
    ax = script(contents())
    ax.grid(True)
    ax.set_azimuth_ticks(range(0, 360, 90))
    ax.figure.canvas.draw()
    assert len(ax.get_azimuth_ticklabels()) == 4
    assert any(line.get_visible() for line in ax.get_xgridlines())


@pytest.mark.parametrize("method", DENSITY_METHODS)
def test_contours_match_mplstereonet(method: str) -> None:
    """Joe Kington's mplstereonet counts by itself, over a grid of the same places."""
    sets = make_sets({"Bedding": ("plane", *BEDS)})
    ax = page(NetContents(sets, contour=method))
    (ours,) = [c for c in ax.collections if getattr(c, "filled", False)]
    *_, counted = import_mplstereonet().density_grid(
        BEDS[0] - 90,
        BEDS[1].copy(),
        measurement="poles",
        method=method,
        gridsize=grid_size(len(BEDS[0]), method),
    )
    # Its places leap to the other side at the rim; these are the same ones without the leap.
    other = page(NetContents())
    steps, values = density_grid(sets[0].vectors(), method)
    away = np.abs(values - counted.T)
    # A pole at the very edge of a counting circle may count for one and not for the other.
    assert np.mean(away > 1e-6) < (0.01 if method in ("kamb", "schmidt") else 1e-12)
    theirs = other.contourf(steps, steps, counted.T, levels=ours.levels)
    assert list(ours.levels[:-1]) == choose_round_levels(float(counted.max()), method)
    assert ours.levels[-1] > counted.max()
    for mine, expected in zip(ours.get_paths(), theirs.get_paths(), strict=True):
        assert len(mine.vertices) == pytest.approx(len(expected.vertices), abs=8)
        if len(mine.vertices):
            away = np.linalg.norm(mine.vertices[:, None] - expected.vertices, axis=2)
            near = 0.06 if method in ("kamb", "schmidt") else 1e-6
            assert away.min(axis=0).max() < near
            assert away.min(axis=1).max() < near


def test_density_includes_every_set_of_the_net() -> None:
    """Of lines alone it is highest at the lines, whatever planes are far away."""
    sets = make_sets({"Joint": ("plane", [0.0], [90.0]), "Striae": ("line", *LINES)})
    ax = script(NetContents(sets, contour="schmidt"))
    (contours,) = [c for c in ax.collections if getattr(c, "filled", False)]
    innermost = [path for path in contours.get_paths() if len(path.vertices)][-1]
    expected = np.transpose(
        import_mplstereonet().line(*(part.copy() for part in LINES[::-1]))
    ).mean(axis=0)
    assert np.degrees(np.abs(innermost.vertices.mean(axis=0) - expected)).max() < 6


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_rim_is_a_circle_in_the_given_area(projection: str) -> None:
    figure = Figure(figsize=(6, 4), dpi=100)
    FigureCanvasAgg(figure)
    ax = add_net(
        figure,
        (0.5, 0.1, 0.5, 0.8),
        NetStyle(),
        projection,
        x_radii=(-1.5, 1.5),
        y_radii=(-1.2, 1.8),
    )
    figure.draw_without_rendering()
    box = ax.get_window_extent()
    # The area is 300 by 320 pixels; three radii fit in the narrower side.
    assert (box.width, box.height) == pytest.approx((200.0, 200.0))
    assert (box.x0 + box.x1) / 2 == pytest.approx(450.0)
    assert (box.y0 + box.y1) / 2 == pytest.approx(40.0 + 160.0 - 0.3 * 100.0)
    ends = lines_to_vectors([0.0, 90, 180, 270], [0.0] * 4)
    at = ax.transData.transform(vectors_to_longitude_latitude(ends))
    assert np.hypot(*(at - [450.0, 170.0]).T) == pytest.approx(np.full(4, 100.0))


def test_mplstereonet_is_imported_only_when_a_net_is_drawn() -> None:
    code = (
        "import sys, vomstudio.products.net.figure, vomstudio.products.net.net_axes, "
        "vomstudio.products.net.slope_figure, vomstudio.api.nets; "
        "sys.exit(any(name in sys.modules for name in ('matplotlib', 'mplstereonet')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
