"""Contours on the net: their levels, places, colours, bar, and what is said of them."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.density import DENSITY_METHODS, DENSITY_UNITS, density
from vomstudio.geology.stereonet import longitude_latitude_to_vectors
from vomstudio.products.net.contents import Contouring, NetContents, make_sets
from vomstudio.products.net.contours import (
    DENSITY_NAMES,
    ContourPlan,
    check_contour_sizes,
    describe_density,
)
from vomstudio.products.net.figure import NetArtists, draw_stereonet
from vomstudio.products.net.figure_options import StereonetOptions
from vomstudio.products.net.set_statistics import add_statistics, find_maxima
from vomstudio.products.net.style import NetStyle


def cluster(azimuth: float, dip: float, n: int, seed: int) -> tuple[str, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return ("plane", (azimuth + rng.normal(0, 8, n)) % 360.0, dip + rng.normal(0, 5, n))


SETS = make_sets({"Beds": cluster(120, 35, 60, 1), "Joints": cluster(250, 60, 40, 2)})
NET = NetContents(SETS, contour="exponential_kamb")


def draw(net: NetContents, style: NetStyle | None = None, wide: bool = True) -> NetArtists:
    figure = Figure(figsize=(7.0, 4.5) if wide else (3.0, 6.0), dpi=100)
    FigureCanvasAgg(figure)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return draw_stereonet(figure, net, style or NetStyle())


def contours(artists: NetArtists, filled: bool) -> list[ContourSet]:
    result = [c for c in artists.axes.collections if isinstance(c, ContourSet)]
    return [c for c in result if c.filled == filled]


def words(artists: NetArtists) -> list[str]:
    return [t.get_text() for t in artists.axes.texts]


@pytest.mark.parametrize("projection", ["area", "angle"])
@pytest.mark.parametrize("each", [False, True])
def test_density_along_a_contour_equals_its_level(projection: str, each: bool) -> None:
    """Counted anew at the places of the drawn line, without the grid."""
    look = Contouring((3.0, 9.0), False, each)
    artists = draw(replace(NET, projection=projection, contouring=look))
    drawn = contours(artists, False)
    data = [s.vectors() for s in SETS] if each else [np.vstack([s.vectors() for s in SETS])]
    assert len(drawn) == len(data)
    for lines, vectors in zip(drawn, data, strict=True):
        for level, path in zip((3.0, 9.0), lines.get_paths(), strict=True):
            result = density(vectors, longitude_latitude_to_vectors(path.vertices))
            # Straight pieces between the places of a grid, on a flank of 20 within its step.
            assert np.abs(result - level).max() < 0.12 * level + 0.1


def test_requested_levels_are_drawn_and_shown_in_the_bar() -> None:
    artists = draw(replace(NET, contouring=Contouring((1.5, 7.0, 1000.0))))
    (lines,) = contours(artists, False)
    assert list(lines.levels) == [1.5, 7.0]  # nothing is as dense as 1000
    assert {"1.5", "7", "standard deviations"} <= set(words(artists))
    assert len([p for p in artists.axes.patches if isinstance(p, Rectangle)]) == 2
    draw(replace(NET, contouring=Contouring((5.0,))))


@pytest.mark.parametrize("filled", first_in_default_tier([None, True, False], 2))
@pytest.mark.parametrize("each", first_in_default_tier([False, True], 2))
@pytest.mark.parametrize("dark", first_in_default_tier([False, True], 2))
@pytest.mark.parametrize("wide", first_in_default_tier([False, True], 2))
def test_contours_are_lines_or_filled_for_all_sets_or_each_in_its_colour(
    filled: bool | None, each: bool, dark: bool, wide: bool
) -> None:
    from matplotlib.colors import to_hex

    style = NetStyle.dark() if dark else NetStyle()
    artists = draw(replace(NET, contouring=Contouring((), filled, each)), style, wide)
    full = not each if filled is None else filled
    parts = len(SETS) if each else 1
    assert len(contours(artists, True)) == (parts if full else 0)
    lines = contours(artists, False)
    assert len(lines) == parts
    if each:
        for s, drawn in zip(SETS, lines, strict=True):
            top = to_hex(np.asarray(drawn.get_edgecolor())[-1])
            assert top.casefold() == style.outline(style.color(s.color)).casefold()
    cells = [p for p in artists.axes.patches if isinstance(p, Rectangle)]
    assert len(cells) == (parts * len(lines[0].levels) if full else 0)
    # Whatever the bar's place, its figures stand in the figure and beside no other words.
    width, height = artists.axes.figure.bbox.size
    boxes = artists.text_boxes
    assert all(a >= 0 and b >= 0 and c <= width and d <= height + 1 for a, b, c, d in boxes)
    text = " ".join(words(artists))
    assert "exponential kernel, 3 σ" in text
    assert ("standard deviations" if wide else "σ") in words(artists)


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("compact", [False, True])
def test_legend_states_which_sets_are_counted_together(wide: bool, compact: bool) -> None:
    def subject(**more: Any) -> list[str]:
        net = replace(NET, compact=compact, contouring=Contouring(**more))
        text = " ".join(words(draw(net, wide=wide)))
        stated = ("of all sets together, n = 100", "of Joints, n = 40")
        return [each for each in stated if each in text]

    assert subject() == ["of all sets together, n = 100"]
    assert subject(set_name="Joints") == ["of Joints, n = 40"]
    assert subject(each_set=True) == []
    alone = replace(NET, sets=SETS[:1])
    assert "together" not in " ".join(words(draw(alone, wide=wide)))


def test_only_the_selected_group_of_sets_is_counted() -> None:
    """Two sets of joints and the beds: what is far from all joints has no density."""
    far = make_sets({"J2": cluster(20, 80, 30, 5)})[0]
    sets = (SETS[0], replace(SETS[1], group="Joint"), replace(far, group="Joint"))
    net = NetContents(sets, contour="schmidt", contouring=Contouring(set_name="Joint"))
    result = describe_density(net)
    assert result is not None
    (part,) = result["parts"]
    assert (part["set"], part["n"]) == ("Joint", 70)
    (filled,) = contours(draw(net), True)
    at = np.vstack([path.vertices for path in filled.get_paths()])
    from_beds = longitude_latitude_to_vectors(at) @ SETS[0].vectors().mean(axis=0)
    assert from_beds.max() < 0.9
    assert describe_density(replace(net, contouring=Contouring(set_name="Fault"))) is None


@pytest.mark.parametrize("filled", [False, True])
@pytest.mark.parametrize("dark", [False, True])
def test_contours_are_drawn_below_the_poles_and_transparent(filled: bool, dark: bool) -> None:
    look = Contouring(filled=filled)
    style = NetStyle.dark() if dark else NetStyle()
    artists = draw(replace(NET, contouring=look), style)
    for drawn in (*contours(artists, True), *contours(artists, False)):
        assert drawn.get_zorder() < min(line.get_zorder() for line in artists.poles)
    for drawn in contours(artists, True):
        assert np.asarray(drawn.get_facecolor())[:, 3].max() < 0.8


def test_sets_of_one_type_and_colour_are_distinguished_by_their_dashes() -> None:
    pair = (SETS[0], replace(SETS[1], color=SETS[0].color, variant=1))
    artists = draw(NetContents(pair, contour="linear_kamb", contouring=Contouring(each_set=True)))
    one, other = (tuple(c.get_linestyle()[0]) for c in contours(artists, False))
    assert one != other


def test_requested_sigma_is_used_and_named() -> None:
    nets = [replace(NET, contouring=Contouring(sigma=s)) for s in (2.0, 4.5)]
    drawn = [draw(net) for net in nets]
    assert DENSITY_NAMES["exponential_kamb"].format(sigma="4.5") in words(drawn[1])
    tops = []
    for net, sigma in zip(nets, (2.0, 4.5), strict=True):
        result = describe_density(net)
        assert result is not None
        vectors = np.vstack([s.vectors() for s in SETS])
        part = result["parts"][0]
        place = np.radians([part["trend_deg"], part["plunge_deg"]])
        line = [
            np.sin(place[0]) * np.cos(place[1]),
            np.cos(place[0]) * np.cos(place[1]),
            -np.sin(place[1]),
        ]
        assert density(vectors, line, sigma=sigma)[0] == pytest.approx(part["maximum"])
        tops.append(part["maximum"])
    assert tops[0] != pytest.approx(tops[1])


def test_too_sparse_orientations_give_a_note_instead_of_a_bar() -> None:
    even = make_sets({"a": ("line", np.arange(0.0, 360.0, 30.0), np.full(12, 30.0))})
    net = NetContents(even, contour="schmidt", contouring=Contouring((50.0,)))
    artists = draw(net)
    assert Finding("net.nowhere-dense").message in words(artists)
    assert not contours(artists, False)
    assert DENSITY_UNITS["schmidt"] not in words(artists)
    result = describe_density(net)
    assert result is not None
    assert result["levels"] == []
    assert describe_density(replace(net, sets=())) is None


def test_too_few_orientations_are_reported() -> None:
    """Kamb's circle of 3 takes 9/12 of the hemisphere, of 9 exactly a half; Schmidt's never."""
    three = make_sets({"a": ("plane", [10, 20, 30], [40, 50, 60]), "b": cluster(9, 40, 9, 3)})
    each = NetContents(three, contour="kamb", contouring=Contouring(each_set=True))
    (few,) = check_contour_sizes(each)
    assert few == Finding("net.few-for-contours", set="a", count=3, share_percent=75.0)
    assert check_contour_sizes(replace(each, contouring=Contouring())) == []
    assert check_contour_sizes(replace(each, contour="schmidt")) == []
    assert check_contour_sizes(replace(each, contour=None)) == []


@pytest.mark.parametrize(
    ("code", "field", "options"),
    [
        ("option.requires", "--levels", {"levels": "2"}),
        ("net.not-levels", "--levels", {"contour": "kamb", "levels": "0,2"}),
        ("net.not-levels", "--levels", {"contour": "kamb", "levels": "nan"}),
        ("net.not-levels", "--levels", {"contour": "kamb", "levels": "inf"}),
        ("net.not-levels", "--levels", {"contour": "kamb", "levels": "2;4"}),
        (
            "net.too-many-levels",
            "--levels",
            {"contour": "kamb", "levels": ",".join(str(i + 1) for i in range(21))},
        ),
        ("option.out-of-range", "--kamb-sigma", {"contour": "kamb", "kamb_sigma": 0.0}),
        ("option.out-of-range", "--kamb-sigma", {"contour": "kamb", "kamb_sigma": float("nan")}),
    ],
)
def test_invalid_levels_and_sigmas_are_rejected(
    code: str, field: str, options: dict[str, Any]
) -> None:
    with refused(code, UsageError, field=field):
        StereonetOptions(**options)


@pytest.mark.full
@pytest.mark.parametrize("method", DENSITY_METHODS)
@pytest.mark.parametrize("n", [1, 2, 5])
def test_few_orientations_can_be_contoured(method: str, n: int) -> None:
    few = make_sets({"a": ("line", np.arange(n) * 20.0, np.full(n, 30.0))})
    for each in (False, True):
        draw(NetContents(few, contour=method, contouring=Contouring(each_set=each)))


def test_copies_with_the_same_contours_share_their_density() -> None:
    plan = ContourPlan.of(NET)
    assert ContourPlan.of(add_statistics(replace(NET, title="Joints"), {"maxima"})) is plan
    assert ContourPlan.of(replace(NET, contouring=Contouring(sigma=4.0))) is not plan
    assert ContourPlan.of(replace(NET, contour="kamb")) is not plan


@pytest.mark.parametrize("each", [False, True])
def test_the_marked_maximum_is_the_reported_one(each: bool) -> None:
    net = replace(NET, contouring=Contouring(each_set=each))
    density = describe_density(net)
    assert density is not None
    marked = [(mark.line.trend_deg, mark.line.plunge_deg) for mark in find_maxima(net)]
    assert marked == [(part["trend_deg"], part["plunge_deg"]) for part in density["parts"]]
