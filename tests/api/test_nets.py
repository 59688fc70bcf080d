"""Nets on the axes of mplstereonet: poles, circles and densities where they belong."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

import vomstudio as vs
from tests.messages import refused

DIRECTION, DIP = np.array([120.0, 130.0, 125.0, 300.0]), np.array([30.0, 35.0, 25.0, 80.0])


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    plt.close("all")


@pytest.fixture
def library() -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import mplstereonet
    return mplstereonet


def pixels(curves: Any) -> list[Any]:
    """Display positions of each curve of a collection."""
    return [curves.get_transform().transform(part) for part in curves.get_segments()]


def contours_of(ax: Any, filled: bool) -> list[Any]:
    return [c for c in ax.collections if getattr(c, "filled", None) == filled]


@pytest.mark.parametrize("projection", ["area", "angle"])
def test_poles_and_great_circles_match_mplstereonet(library: Any, projection: Any) -> None:
    ax = vs.stereonet((DIRECTION, DIP), projection=projection)
    drawn = [np.sort(line.get_xydata(), axis=0) for line in ax.lines]
    wanted = np.sort(np.transpose(library.pole(DIRECTION - 90.0, DIP.copy())), axis=0)
    assert any(len(d) == 4 and np.allclose(d, wanted, atol=1e-9) for d in drawn)
    (circles,) = [c for c in ax.collections if len(c.get_paths()) == len(DIRECTION)]
    circle = ax.transData.transform(np.transpose(library.plane(30.0, 30.0)).reshape(-1, 2))
    assert any(np.abs(part[:, None] - circle).max(axis=2).min() < 1e-6 for part in pixels(circles))
    assert isinstance(ax, library.StereonetAxes)


def test_net_is_drawn_on_given_axes(library: Any) -> None:
    figure = plt.figure()
    ax = figure.add_subplot(projection="stereonet")
    assert vs.stereonet((DIRECTION, DIP), ax=ax) is ax
    assert ax.lines
    plain = figure.add_subplot()
    with refused("argument.wrong-type", expected="mplstereonet.StereonetAxes", field="ax"):
        vs.stereonet((DIRECTION, DIP), ax=plain)


@pytest.mark.parametrize("method", ["kamb", "exponential_kamb", "linear_kamb", "schmidt"])
def test_densities_are_highest_at_the_cluster(library: Any, method: str) -> None:
    chance = np.random.default_rng(3)
    direction, dip = 60 + 5 * chance.normal(size=50), 40 + 5 * chance.normal(size=50)
    ax = vs.stereonet((direction, dip), contour=method)
    (contours,) = contours_of(ax, True)
    innermost = [path for path in contours.get_paths() if len(path.vertices)][-1]
    middle = innermost.vertices.mean(axis=0)
    pole = np.array(library.pole(60.0 - 90.0, 40.0)).ravel()
    assert np.degrees(np.abs(middle - pole)).max() < 6


def test_contours_have_requested_levels_and_colour_bar_with_unit() -> None:
    chance = np.random.default_rng(3)
    direction, dip = 60 + 5 * chance.normal(size=50), 40 + 5 * chance.normal(size=50)
    ax = vs.stereonet((direction, dip), contour="kamb", levels=[8, 2, 4], filled=False)
    (contours,) = contours_of(ax, False)
    assert list(contours.levels) == [2.0, 4.0, 8.0]
    assert not contours_of(ax, True)
    (bar,) = ax.child_axes
    ax.figure.canvas.draw()
    assert [t.get_text() for t in bar.get_yticklabels()] == ["2", "4", "8"]
    assert bar.get_title(loc="left") == "standard deviations"
    smooth = vs.stereonet((direction, dip), contour="kamb", kamb_sigma=6.0)
    assert len(contours_of(smooth, True)) == 1


def test_each_set_is_contoured_in_its_colour(picks: Any) -> None:
    planes = vs.fit_planes(picks, by="pick")
    planes["kind"] = planes["id"].str[0].map({"B": "bedding", "F": "fault", "J": "joint"})
    ax = vs.stereonet(planes, by="kind", contour="schmidt", each_set=True)
    contours = contours_of(ax, False)
    assert len(contours) == planes["kind"].nunique()
    assert len({tuple(c.levels) for c in contours}) == 1


def test_sets_have_names_in_the_legend(picks: Any) -> None:
    planes = vs.fit_planes(picks, by="pick")
    planes["kind"] = planes["id"].str[0].map({"B": "bedding", "F": "fault", "J": "joint"})
    ax = vs.stereonet(planes, by="kind")
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    counts = planes["kind"].value_counts()
    for kind, n in counts.items():
        assert f"{kind}, poles (n = {n})" in texts


def test_many_planes_are_drawn_as_poles_only() -> None:
    chance = np.random.default_rng(5)
    ax = vs.stereonet((chance.uniform(0, 360, 60), chance.uniform(10, 80, 60)))
    assert all(line.get_linestyle() == "None" for line in ax.lines)


@pytest.mark.parametrize(
    ("more", "error"),
    [
        ({"contour": "rainbow"}, {"code": "option.not-a-choice", "field": "contour"}),
        ({"projection": "mercator"}, {"code": "option.not-a-choice", "field": "projection"}),
        (
            {"levels": [2]},
            {"code": "option.requires", "field": "levels", "option": "levels", "other": "contour"},
        ),
        (
            {"contour": "kamb", "levels": [-2]},
            {"code": "net.not-levels", "field": "levels", "text": "-2"},
        ),
        (
            {"contour": "kamb", "kamb_sigma": 99},
            {"code": "option.out-of-range", "field": "kamb_sigma", "maximum": 10.0},
        ),
        ({"by": "site"}, {"code": "table.unknown-column", "column": "site"}),
    ],
)
def test_invalid_net_options_are_refused(more: Any, error: dict[str, Any]) -> None:
    with pytest.raises(vs.errors.VomError) as raised:
        vs.stereonet((DIRECTION, DIP), **more)
    assert raised.value.to_dict().items() >= error.items()


def test_input_is_not_modified() -> None:
    direction, dip = DIRECTION.copy(), DIP.copy()
    vs.stereonet((direction, dip))
    assert (direction == DIRECTION).all()
    assert (dip == DIP).all()


def test_net_is_untilted_and_intersections_need_two_planes() -> None:
    ax = vs.stereonet(([90, 90], [50, 50]), untilt=(90, 20))
    plain = vs.stereonet(([90, 90], [30, 30]))
    at = [axes.lines[-1].get_xydata()[0] for axes in (ax, plain)]
    np.testing.assert_allclose(at[0], at[1], atol=1e-6)
    with refused("net.number-of-planes", vs.errors.UsageError, count=1):
        vs.stereonet(([90], [50]), intersections=True)


def test_roses_by_set_are_drawn_in_one_figure() -> None:
    import matplotlib.pyplot as plt
    import pandas

    table = pandas.DataFrame(
        {
            "dipdir": [90, 92, 180, 185, 182],
            "dip": [40] * 5,
            "set": ["A", "A", "B", "B", "B"],
            "length": [1.0, 3.0, 1.0, 1.0, 1.0],
        }
    )
    ax = vs.rose(table, by="set", weight="length", of="dip-direction")
    figure = ax.figure
    assert ax is figure.axes[0]
    assert len(figure.axes) == 2
    assert "A (n = 2)" in [text.get_text() for text in figure.texts]
    # The mean of 90 once and 92 three times.
    assert "mean 092, R̄ 1.00" in [text.get_text() for text in figure.texts]
    plt.close(figure)
    with refused(
        "rose.uneven-bins", vs.errors.UsageError, field="bin_deg", bin_deg=7.0, range_deg=180.0
    ):
        vs.rose(table, bin_deg=7)
    with refused("rose.no-lines", vs.errors.GeometryError):
        vs.rose(table, of="trend")


@pytest.mark.parametrize("of", ["strike", "dip"])
def test_a_rose_is_drawn_on_axes_of_another_figure(of: str) -> None:
    planes = ([90, 92, 180, 185, 182], [40, 41, 42, 50, 60])
    figure, (left, right) = plt.subplots(1, 2)
    before = right.get_position().bounds
    assert vs.rose(planes, ax=right, of=of) is right
    assert figure.axes == [left, right]
    assert not left.has_data()
    assert right.get_aspect() == 1.0
    figure.draw_without_rendering()
    assert right.get_position().width <= before[2] + 1e-9
    assert "n = 5" in right.get_title()
    alone = vs.rose(planes, of=of)
    assert len(right.patches) == len(alone.patches)
    plt.close("all")


def test_given_axes_accept_one_rose_and_must_be_rectangular() -> None:
    import pandas

    planes = pandas.DataFrame({"dipdir": [90, 180], "dip": [40, 50], "set": ["A", "B"]})
    ax = plt.figure().add_subplot()
    with refused("rose.several-sets", vs.errors.UsageError, field="ax", sets=("A", "B")):
        vs.rose(planes, ax=ax, by="set")
    assert not ax.has_data()
    for other in (plt.figure().add_subplot(projection="polar"), "axes"):
        with refused("argument.wrong-type", vs.errors.InputError, field="ax"):
            vs.rose(planes, ax=other)
    plt.close("all")


def test_set_and_weight_options_work_from_python() -> None:
    import pandas

    azimuth = [90, 91, 89, 92, 150, 151, 149, 152, 270, 271, 269, 272]
    dip = [30, 31, 29, 30, 50, 51, 49, 50, 60, 61, 59, 60]
    table = pandas.DataFrame({"dipdir": azimuth, "dip": dip, "set": list("aaaabbbbcccc")})
    found = vs.fold(table, by="set")
    assert found.one_axis is not None
    assert not found.one_axis.serves_all
    assert found.valid == "no"
    assert vs.fold(table, sets=["a", "b", "c"]).verdict == "two axes"
    with refused("table.no-errors", vs.errors.UsageError):
        vs.stats(table, weights="error")
    with pytest.raises(vs.errors.InputError, match="weights"):
        vs.stats(table, weights="length")  # type: ignore[arg-type]


def _on_the_net(line: Any, library: Any) -> np.ndarray[Any, Any]:
    """Unit vectors (n, 3), East, North, Up, of what is drawn."""
    return _vectors(line.get_xydata(), library)


def _vectors(places: Any, library: Any) -> np.ndarray[Any, Any]:
    plunge, bearing = library.geographic2plunge_bearing(*places.T)
    p, t = np.radians(plunge), np.radians(bearing)
    return np.column_stack([np.cos(p) * np.sin(t), np.cos(p) * np.cos(t), -np.sin(p)])


def _drawn(ax: Any, label: str) -> Any:
    (line,) = [line for line in ax.lines if line.get_label() == label]
    return line


@pytest.mark.parametrize("projection", ["area", "angle"])
def test_typed_planes_cones_and_slip_lines_are_drawn_at_their_attitudes(
    library: Any, projection: Any
) -> None:
    ax = vs.stereonet(
        (DIRECTION, DIP),
        projection=projection,
        planes=["120/30"],
        cones=[(30, 40, 20)],
        slip_lines=[(200, 60, 90)],
    )
    trend, plunge = np.radians([30, 40])
    axis = [np.cos(plunge) * np.sin(trend), np.cos(plunge) * np.cos(trend), -np.sin(plunge)]
    away = np.degrees(np.arccos(_on_the_net(_drawn(ax, "Cone 30/40/20"), library) @ axis))
    np.testing.assert_allclose(away, 20, atol=1e-4)
    circle = _drawn(ax, "Plane 120/30").get_xydata()
    wanted = _vectors(np.transpose(library.plane(30.0, 30.0)).reshape(-1, 2), library)
    away = np.linalg.norm(wanted[:, None] - _vectors(circle, library), axis=2)
    # Both are polylines; ours has a point every degree.
    assert away.min(axis=1).max() < np.radians(0.51)
    # It does not leap over the net where it meets the primitive circle.
    assert np.abs(np.diff(circle, axis=0)).max() < 0.1
    # A rake of 90 degrees is the line of dip.
    np.testing.assert_allclose(
        _drawn(ax, "rake 90: 200/60").get_xydata()[0], np.ravel(library.line(60, 200)), atol=1e-9
    )


def test_a_girdle_a_maximum_and_averages_are_drawn() -> None:
    # Poles on the great circle whose pole is the line 090/20: beds that hold it.
    beds = ([90, 30, 150, 10, 170], [20, 36.05, 36.05, 64.49, 64.49])
    ax = vs.stereonet(beds, girdles=True, maxima=True, averages=True)
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert any(text.startswith("planes, girdle 270/70 (K 0.") for text in texts)
    assert any(text.startswith("max ") for text in texts)
    assert any("about 090/20" in text.get_text() for text in ax.texts)


def test_error_ellipses_show_total_error_of_table(picks: Any, library: Any) -> None:
    bed = vs.fit_planes(picks[picks["pick"] == "B01"], by="pick")
    ax = vs.stereonet(bed, errors=True)
    plain = vs.stereonet(bed)
    assert len(ax.collections) == len(plain.collections) + 1
    (ellipse,) = pixels(ax.collections[-1])
    pole = bed[["normal_x", "normal_y", "normal_z"]].to_numpy()[0]
    away = np.degrees(
        np.arccos(np.abs(_vectors(ax.transData.inverted().transform(ellipse), library) @ pole))
    )
    total, largest, smallest = (
        bed[name][0] for name in ("total95_deg", "max_confidence95_deg", "min_confidence95_deg")
    )
    assert away.max() == pytest.approx(total, rel=1e-3)
    assert away.min() == pytest.approx(np.sqrt(smallest**2 + total**2 - largest**2), rel=1e-2)
    with refused("net.no-errors", vs.errors.UsageError):
        vs.stereonet((DIRECTION, DIP), errors=True)


def test_rotation_rotates_the_net() -> None:
    # About a line straight down the right-hand rule runs clockwise on the map.
    turned = vs.stereonet((DIRECTION, DIP), rotate=(0, 90, 30))
    other = vs.stereonet(((DIRECTION + 30) % 360, DIP))
    places = [
        np.vstack([line.get_xydata() for line in ax.lines if line.get_marker() == "o"])
        for ax in (turned, other)
    ]
    np.testing.assert_allclose(*places, atol=1e-9)
    assert any("Rotated by 30" in text.get_text() for text in turned.texts)


def test_style_options_apply_to_figure() -> None:
    ax = vs.stereonet(
        (DIRECTION, DIP),
        size_mm=(254, 127),
        symbol_size_pt=9,
        font_size_pt=6,
        grey=True,
        line_width_pt=2,
    )
    np.testing.assert_allclose(ax.figure.get_size_inches(), [10, 5])
    (poles,) = [line for line in ax.lines if len(line.get_xdata()) == len(DIRECTION)]
    assert poles.get_markersize() == 9
    color = poles.get_markerfacecolor()
    assert color[1:3] == color[3:5] == color[5:7]
    assert ax.get_legend().get_texts()[0].get_fontsize() == 6


@pytest.mark.parametrize(
    "more",
    [
        {"untilt": (90,)},
        {"untilt": "steep"},
        {"untilt": ("a", "b")},
        {"rotate": (1, 2)},
        {"contour": "kamb", "levels": 3},
        {"contour": "kamb", "levels": ["a"]},
        {"kamb_sigma": None},
        {"planes": (120, 30)},
        {"cones": [(30, 40, 0)]},
        {"cones": [(30, 40)]},
        {"slip_lines": 3},
        {"slip_lines": ["1/2"]},
        {"size_mm": 3},
        {"size_mm": (1, 1)},
        {"font": 3},
        {"font": "No Such Font"},
        {"symbol_size_pt": "big"},
        {"by": ["set"]},
    ],
)
def test_invalid_options_are_refused_with_sentence(more: Any) -> None:
    with pytest.raises(vs.errors.VomError) as found:
        vs.stereonet((DIRECTION, DIP), **more)
    assert str(found.value).endswith(".")


def test_size_is_refused_for_existing_axes() -> None:
    ax = vs.stereonet((DIRECTION, DIP))
    with refused("option.conflict", vs.errors.UsageError, option="size_mm", other="ax"):
        vs.stereonet((DIRECTION, DIP), ax=ax, size_mm=(100, 100))
