"""Symbols of a map: along the strike, down the dip."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geology.map_symbols import strike_and_dip_symbol, symbol_size, trend_arrow
from vomstudio.geology.orientation import Line, Plane

AT = np.array([500_000.0, 5_000_000.0, 120.0])


@pytest.mark.parametrize("azimuth", [0.0, 37.0, 180.0, 290.0])
def test_the_bar_runs_along_the_strike_and_the_tick_down_the_dip(azimuth: float) -> None:
    bar, tick = strike_and_dip_symbol(AT, azimuth, 40.0, 2.0)
    along = bar[1] - bar[0]
    assert np.linalg.norm(along) == pytest.approx(2.0)
    assert abs(along @ Plane(azimuth, 40.0).strike_vector()) == pytest.approx(2.0)
    down = tick[1] - tick[0]
    assert tick[0] == pytest.approx(AT)
    assert down / np.linalg.norm(down) == pytest.approx(Line(azimuth, 0.0).vector(), abs=1e-9)


def test_a_vertical_plane_has_ticks_on_both_sides_and_a_horizontal_one_a_cross() -> None:
    _, tick = strike_and_dip_symbol(AT, 90.0, 90.0, 2.0)
    assert tick.mean(axis=0) == pytest.approx(AT)
    one, other = strike_and_dip_symbol(AT, 0.0, 0.0, 2.0)
    assert np.linalg.norm(one[1] - one[0]) == np.linalg.norm(other[1] - other[0])


def test_overturned_bed_has_hook_pointing_up_dip() -> None:
    for dip in (0.0, 35.0, 90.0):
        plain = strike_and_dip_symbol(AT, 110.0, dip, 2.0)
        *same, hook = strike_and_dip_symbol(AT, 110.0, dip, 2.0, True)
        assert all((a == b).all() for a, b in zip(plain, same, strict=True))
        bar, down = plain[0], Line(110.0, 0.0).vector()
        along = (bar[1] - bar[0]) / 2.0
        steps = hook - AT
        assert np.linalg.norm(steps, axis=1) == pytest.approx(0.2)
        assert steps[[0, -1]] @ down == pytest.approx(0.0, abs=1e-9)
        assert steps[0] @ along == pytest.approx(-steps[-1] @ along)
        assert (steps[1:-1] @ down < 0).all()


def test_line_arrow_follows_trend_and_has_two_heads_if_horizontal() -> None:
    shaft, head = trend_arrow(AT, 120.0, 30.0, 2.0)
    assert shaft[1] - shaft[0] == pytest.approx(2.0 * Line(120.0, 0.0).vector())
    assert head[1] == pytest.approx(shaft[1])
    assert len(trend_arrow(AT, 120.0, 0.0, 2.0)) == 3


def test_symbol_size_is_positive_for_one_place_or_none() -> None:
    assert symbol_size([AT]) > 0
    assert symbol_size(np.zeros((0, 3))) > 0
