"""Values as colours, against matplotlib's own."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import Normalize

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.view import scalars
from vomstudio.rendering.view.scalars import ELEVATION, MISSING_COLOR, FieldStyle, make_scale

LEVEL = np.eye(4)


def cloud(**fields: np.ndarray) -> PointCloud:
    count = len(next(iter(fields.values())))
    points = np.random.default_rng(0).normal(0, 10, (count, 3))
    return PointCloud(points, fields=fields)


def scale(name: str, values: np.ndarray, **style: object) -> scalars.Scale:
    return make_scale(cloud(**{name: values}), FieldStyle(name, **style), LEVEL)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["viridis", "cividis"])
def test_colours_match_matplotlib(name: str) -> None:
    values = np.linspace(-3.0, 40.0, 1001)
    made = make_scale(
        cloud(depth=np.abs(values)), FieldStyle("depth", 0.0, 30.0, palette=name), LEVEL
    )
    expected = colormaps[name](Normalize(0.0, 30.0)(values), bytes=True)[:, :3]
    assert np.array_equal(made.colors(values), expected)


def test_default_range_is_the_2nd_to_98th_percentile() -> None:
    values = np.random.default_rng(1).gamma(2.0, 100.0, 50_001)
    made = scale("intensity", values)
    assert [made.low, made.high] == pytest.approx(np.percentile(values, [2, 98]))
    assert made.has_lower_values
    assert made.has_higher_values
    whole = scale("intensity", values, percentiles=(0.0, 100.0))
    assert [whole.low, whole.high] == pytest.approx([values.min(), values.max()])
    assert not whole.has_lower_values
    assert not whole.has_higher_values


def test_signed_field_uses_a_diverging_map_centred_on_zero() -> None:
    made = scale("C2C signed distances", np.array([-1.0, 0.5, 3.0, 0.0] * 20))
    assert made.kind == "diverging"
    assert made.low == -made.high
    middle = made.colors(np.array([0.0]))[0].astype(int)
    assert np.ptp(middle) <= 6
    red, _, blue = made.colors(np.array([made.high]))[0].astype(int)
    assert red > blue


def test_azimuths_use_a_cyclic_map() -> None:
    made = scale("dip direction [deg]", np.array([3.0, 90.0, 359.0]))
    assert (made.kind, made.low, made.high) == ("cyclic", 0.0, 360.0)
    near, far = made.colors(np.array([0.5, 359.5])).astype(int)
    assert np.abs(near - far).max() <= 6
    assert np.array_equal(made.colors(np.array([-10.0])), made.colors(np.array([350.0])))


def test_missing_values_are_grey() -> None:
    made = scale("roughness", np.array([0.1, np.nan, 0.3, np.inf]))
    assert made.missing
    assert [tuple(c) for c in made.colors(np.array([np.nan, np.inf]))] == [
        MISSING_COLOR,
        MISSING_COLOR,
    ]
    assert np.isfinite([made.low, made.high]).all()
    nothing = scale("roughness", np.array([np.nan, np.nan]))
    assert tuple(nothing.colors(np.array([np.nan]))[0]) == MISSING_COLOR


def test_las_classes_have_their_names_and_colours_of_their_own() -> None:
    codes = np.array([2] * 500_000 + [5] * 10 + [6, 64], np.uint8)
    made = scale("classification", codes)
    assert [c.name for c in made.categories] == [
        "2  ground",
        "5  high vegetation",
        "6  building",
        "64  user-defined",
    ]
    colors = made.colors(np.array([2, 5, 6, 64, 7]))
    assert len(np.unique(colors, axis=0)) == 5
    assert tuple(colors[4]) == MISSING_COLOR
    every = {color for _, color in scalars.LAS_CLASSES.values()}
    assert len(every) == len(scalars.LAS_CLASSES)


def test_elevation_is_the_height_in_world() -> None:
    """A model whose second axis points up."""
    turned = np.array([[1, 0, 0, 10], [0, 0, -1, 20], [0, 1, 0, 30], [0, 0, 0, 1]], float)
    vertices = np.random.default_rng(2).normal(0, 5, (100, 3))
    mesh = Mesh(vertices, np.zeros((0, 3), np.int32))
    assert ELEVATION in scalars.field_names(mesh)
    _, read = scalars.reader(mesh, ELEVATION, turned)
    assert read(slice(None)) == pytest.approx(vertices[:, 1] + 30.0)
    made = make_scale(mesh, FieldStyle(ELEVATION), turned)
    assert (made.kind, made.unit) == ("sequential", "m")


def test_constant_field_has_a_nonzero_range() -> None:
    made = scale("intensity", np.full(10, 7, np.uint16))
    assert made.low < 7.0 < made.high
    assert made.colors(np.array([7.0])).shape == (1, 3)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (18.383, 20.159), (-3e5, 7e5), (1e-6, 3e-6)])
def test_ticks_are_round_and_within_the_range(low: float, high: float) -> None:
    made = scale("depth", np.array([low, high]), low=low, high=high)
    ticks = made.ticks()
    assert 2 <= len(ticks) <= 8
    for value, text in ticks:
        assert low <= value <= high
        assert float(text.replace("−", "-")) == pytest.approx(value)


def test_names_and_units_are_read_from_the_field() -> None:
    assert scalars.field_title("scalar_C2C_absolute_distances") == "C2C absolute distances"
    assert (scalars.field_title("gain [dB]"), scalars.field_unit("gain [dB]")) == ("gain", "dB")
    assert scalars.field_unit("intensity") == ""
    assert scalars.field_unit("dip_direction") == "°"
    assert scalars.field_unit("C2C absolute distances") == ""
    assert scalars.field_unit(ELEVATION) == "m"


def test_only_numeric_fields_of_the_right_length_are_offered() -> None:
    points = PointCloud(
        np.zeros((3, 3)),
        fields={
            "good": np.arange(3),
            "short": np.arange(2),
            "words": np.array(["a", "b", "c"]),
            "vectors": np.zeros((3, 3)),
        },
    )
    assert scalars.field_names(points) == (ELEVATION, "good")
