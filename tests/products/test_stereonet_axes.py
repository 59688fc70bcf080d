"""The net on axes of mplstereonet, against what the library draws itself."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

from vomstudio.geology.density import DENSITY_METHODS, choose_round_levels
from vomstudio.products.net.contents import AUTO_CIRCLES, NetContents, compute_means, make_sets
from vomstudio.products.net.stereonet_axes import draw_net, is_stereonet_axes, new_axes

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import mplstereonet

rng = np.random.default_rng(11)
BEDS = (60 + 5 * rng.normal(size=30)) % 360, 40 + 5 * rng.normal(size=30)
LINES = np.array([200.0, 210.0, 205.0]), np.array([10.0, 12.0, 20.0])


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    with mpl.rc_context({"backend": "agg"}):
        yield
        plt.close("all")


def drawn(**more: Any) -> Any:
    sets = make_sets({"Bedding": ("plane", *BEDS), "Striae": ("line", *LINES)})
    ax = new_axes(more.pop("projection", "area"))
    draw_net(ax, NetContents(sets, means=compute_means(sets), **more))
    return ax


def marks(ax: Any, symbol: str) -> list[Any]:
    return [line for line in ax.lines if line.get_marker() == symbol]


@pytest.mark.parametrize(
    ("projection", "name"), [("area", "equal_area_stereonet"), ("angle", "equal_angle_stereonet")]
)
def test_axes_are_those_of_the_projection(projection: str, name: str) -> None:
    ax = new_axes(projection)
    assert ax.name == name
    assert is_stereonet_axes(ax)
    assert not is_stereonet_axes(plt.figure().add_subplot())
    box = ax.get_position()
    # The legend stands beside the net, in the third that is left free.
    assert box.x1 <= 0.66 + 1e-9


def test_poles_lines_and_means_are_where_the_library_has_them() -> None:
    ax = drawn(circles=False)
    beds, striae = NetContents(make_sets({"B": ("plane", *BEDS), "S": ("line", *LINES)})).sets
    (poles,), (lines,) = marks(ax, beds.marker), marks(ax, striae.marker)
    expected = np.transpose(mplstereonet.pole(BEDS[0] - 90, BEDS[1].copy()))
    np.testing.assert_allclose(poles.get_xydata(), expected, atol=1e-12)
    expected = np.transpose(mplstereonet.line(LINES[1].copy(), LINES[0].copy()))
    np.testing.assert_allclose(lines.get_xydata(), expected, atol=1e-12)
    stars = marks(ax, "*")
    assert len(stars) == 2
    for star, measured in zip(stars, (poles, lines), strict=True):
        middle = measured.get_xydata().mean(axis=0)
        assert np.degrees(np.abs(star.get_xydata()[0] - middle)).max() < 1


def test_great_circles_are_those_of_the_planes_while_there_are_few() -> None:
    ax = drawn(circles=True)
    circles = [
        line for line in ax.lines if line.get_linestyle() == "-" and len(line.get_xdata()) > 9
    ]
    assert len(circles) == 30
    for line, strike, dip in zip(circles, BEDS[0] - 90, BEDS[1], strict=True):
        expected = np.transpose(mplstereonet.plane(strike, dip)).reshape(-1, 2)
        away = np.linalg.norm(line.get_xydata()[:, None] - expected, axis=2).min(axis=1)
        assert away.max() < 1e-6
    many = AUTO_CIRCLES + 1
    sets = make_sets({"Joints": ("plane", np.linspace(0, 300, many), np.full(many, 50.0))})
    ax = new_axes("area")
    draw_net(ax, NetContents(sets))
    assert all(line.get_linestyle() == "None" for line in ax.lines)


def test_the_legend_counts_each_set_and_words_each_mean() -> None:
    texts = [text.get_text() for text in drawn().get_legend().get_texts()]
    assert texts[:2] == ["Bedding, poles (n = 30)", "Striae, lines (n = 3)"]
    assert [text.split()[0] for text in texts[2:]] == ["Mean", "Mean"]


def test_the_legend_stands_in_the_room_beside_the_net() -> None:
    ax = drawn()
    ax.figure.canvas.draw()
    legend, net = ax.get_legend().get_window_extent(), ax.get_window_extent()
    assert net.x1 <= legend.x0
    assert legend.x0 - net.x1 < 0.12 * net.width
    assert legend.x1 <= ax.figure.bbox.x1
    assert 0 <= legend.y0 < legend.y1 <= ax.figure.bbox.y1


@pytest.mark.parametrize("method", DENSITY_METHODS)
def test_contours_are_those_of_the_library(method: str) -> None:
    """Joe Kington's mplstereonet counts by itself, over a grid of the same places."""
    sets = make_sets({"Bedding": ("plane", *BEDS)})
    ax, other = new_axes("area"), new_axes("area")
    draw_net(ax, NetContents(sets, contour=method))
    (ours,) = [c for c in ax.collections if type(c).__name__.endswith("ContourSet")]
    *_, counted = mplstereonet.density_grid(
        BEDS[0] - 90, BEDS[1].copy(), measurement="poles", method=method, gridsize=101
    )
    # Its places leap to the other side at the rim; these are the same ones without the leap.
    across = np.linspace(-np.pi / 2, np.pi / 2, 101)
    theirs = other.contourf(across, across, counted.T, levels=ours.levels)
    assert list(ours.levels[:-1]) == choose_round_levels(float(counted.max()), method)
    assert ours.levels[-1] > counted.max()
    for mine, expected in zip(ours.get_paths(), theirs.get_paths(), strict=True):
        assert len(mine.vertices) == pytest.approx(len(expected.vertices), abs=4)
        if len(mine.vertices):
            # A pole at the very edge of a counting circle may count for one and not for the other.
            away = np.linalg.norm(mine.vertices[:, None] - expected.vertices, axis=2)
            assert away.min(axis=0).max() < (0.05 if method == "schmidt" else 1e-6)
            assert away.min(axis=1).max() < (0.05 if method == "schmidt" else 1e-6)


def test_the_density_counts_every_set_of_the_net() -> None:
    """Of lines alone it is highest at the lines, whatever planes are far away."""
    sets = make_sets({"Joint": ("plane", [0.0], [90.0]), "Striae": ("line", *LINES)})
    ax = new_axes("area")
    draw_net(ax, NetContents(sets, contour="schmidt"))
    (contours,) = [c for c in ax.collections if type(c).__name__.endswith("ContourSet")]
    innermost = [path for path in contours.get_paths() if len(path.vertices)][-1]
    expected = np.transpose(mplstereonet.line(*(part.copy() for part in LINES[::-1]))).mean(axis=0)
    assert np.degrees(np.abs(innermost.vertices.mean(axis=0) - expected)).max() < 6
