"""Which way an orthophoto looks, in words."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from vomstudio.products.ortho.view_description import axis_labels, direction_text, end_labels
from vomstudio.products.ortho.view_directions import view_along_line


@pytest.mark.parametrize("trend", range(0, 360, 15))
def test_side_labels_of_a_picture_are_perpendicular_to_the_view(trend: int) -> None:
    winds = (
        "N",
        "NNE",
        "NE",
        "ENE",
        "E",
        "ESE",
        "SE",
        "SSE",
        "S",
        "SSW",
        "SW",
        "WSW",
        "W",
        "WNW",
        "NW",
        "NNW",
    )
    view = view_along_line(trend, 10)
    for label, azimuth in zip(end_labels(view)[:2], (trend - 90, trend + 90), strict=True):
        wind, number = label.split()
        assert int(number.strip("()")) == azimuth % 360
        off = (winds.index(wind) * 22.5 - azimuth + 180) % 360 - 180
        assert abs(off) <= 11.25
    local = end_labels(replace(view, is_north_known=False))
    assert local == (f"{(trend - 90) % 360:03d}, local", f"{(trend + 90) % 360:03d}, local", "up")


def test_horizontal_axis_of_a_picture_is_named_by_its_direction() -> None:
    view = view_along_line(31, 11)
    horizontal_label = axis_labels(view, "m")[0]
    assert "ESE" in horizontal_label
    assert horizontal_label.endswith("(m)")
    local_label = axis_labels(replace(view, is_north_known=False), "m")[0]
    assert not re.search("[NESW]", local_label)
    assert local_label.endswith("(m)")


@pytest.mark.parametrize(
    ("plunge", "label", "local_label"),
    [
        (90, "N", "y"),
        (89.9, "N", "y"),
        (-90, "N", "y"),
        (45, "up", "up"),
        (0, "up", "up"),
        (-45, "up", "up"),
    ],
)
def test_vertical_label_of_a_picture_is_north_on_a_map_and_up_on_a_wall(
    plunge: float, label: str, local_label: str
) -> None:
    view = view_along_line(0, plunge)
    assert end_labels(view)[2] == label
    assert end_labels(replace(view, is_north_known=False))[2] == local_label


@pytest.mark.parametrize("trend", range(0, 360, 45))
@pytest.mark.parametrize("plunge", [46, 70, 89.8, -46, -89.8])
def test_vertical_label_of_a_steep_view_is_its_azimuth(trend: int, plunge: float) -> None:
    # Seen from above, the top of the picture is farther along the trend; from below, nearer.
    azimuth = trend if plunge > 0 else (trend + 180) % 360
    view = view_along_line(trend, plunge)
    *_, label = end_labels(view)
    wind, number = label.split()
    assert int(number.strip("()")) == azimuth
    assert axis_labels(view, "m")[1] == f"distance toward {wind} (m)"
    assert end_labels(replace(view, is_north_known=False))[2] == f"{azimuth:03d}, local"


def test_view_text_states_trend_and_plunge() -> None:
    assert direction_text(view_along_line(7.26, 12.34)).startswith("View toward 007.3/12.3 ")
