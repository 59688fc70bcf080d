"""Which way an orthophoto looks, in words."""

from __future__ import annotations

from dataclasses import replace

import pytest

from vomstudio.products.ortho.view_description import direction_text, end_labels
from vomstudio.products.ortho.view_directions import view_along_line


@pytest.mark.parametrize("trend", range(0, 360, 15))
def test_the_ends_of_a_picture_are_a_quarter_turn_from_the_view(trend: int) -> None:
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


def test_up_is_north_on_a_map_and_y_where_north_is_not_known() -> None:
    for plunge, words in ((90, "N"), (89.9, "N"), (-90, "N"), (89.8, "up"), (0, "up")):
        view = view_along_line(0, plunge)
        assert end_labels(view)[2] == words
        known = end_labels(replace(view, is_north_known=False))[2]
        assert known == ("y" if words == "N" else "up")


def test_the_view_in_words() -> None:
    assert direction_text(view_along_line(7.26, 12.34)).startswith("View toward 007.3/12.3 ")
