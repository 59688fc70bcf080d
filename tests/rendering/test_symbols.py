"""Strike and dip symbols: where their strokes lie on the screen."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.symbols import (
    HALF_STRIKE_LENGTH,
    MIN_TICK_SHARE,
    TICK_LENGTH,
    SymbolSet,
    line_symbol,
    plane_symbol,
)

SIZE = (800.0, 600.0)


def looking(trend: float, plunge: float, *, orthographic: bool = True) -> Camera:
    camera = Camera()
    camera.orthographic = orthographic
    camera.look_along(trend, plunge)
    camera.position = -10.0 * camera.direction
    camera.distance = 10.0
    return camera


def seen(symbol, camera):
    """Strokes (s, 2, 2) about the symbol's place, y upwards."""
    signs = SymbolSet([symbol]).signs(camera, SIZE)
    strokes, owners = signs.strokes([0])
    assert (owners == 0).all()
    return (strokes - signs.pixels[0]) * [1.0, -1.0]


def long_axis(stroke: np.ndarray) -> np.ndarray:
    step = stroke[1] - stroke[0]
    return step / np.hypot(*step)


def test_symbol_seen_from_above_equals_the_map_symbol() -> None:
    strike, tick = seen(plane_symbol(132.0, 41.0, np.zeros(3), 1.0), looking(0.0, 90.0))
    toward = np.radians(132.0)
    assert long_axis(tick) == pytest.approx([np.sin(toward), np.cos(toward)], abs=1e-9)
    # Right-hand rule: from the end to the start or back, the strike is 042.
    assert abs(long_axis(strike) @ long_axis(tick)) < 1e-9
    assert np.hypot(*(strike[1] - strike[0])) == pytest.approx(2 * HALF_STRIKE_LENGTH)
    assert np.hypot(*tick[1]) == pytest.approx(TICK_LENGTH * np.cos(np.radians(41.0)))


def test_symbol_seen_along_strike_shows_the_dip() -> None:
    # Dipping 30 to the East, seen from the South: the tick falls to the right by 30 degrees.
    _, tick = seen(plane_symbol(90.0, 30.0, np.zeros(3), 1.0), looking(0.0, 0.0))
    assert long_axis(tick) == pytest.approx([np.cos(np.pi / 6), -0.5], abs=1e-9)
    assert np.hypot(*tick[1]) == pytest.approx(TICK_LENGTH)


@given(
    st.floats(0.0, 359.9),
    st.floats(1.0, 89.0),
    st.floats(0.0, 359.9),
    st.floats(-90.0, 90.0),
    st.booleans(),
)
def test_symbol_size_is_limited_in_every_view(azimuth, dip, trend, plunge, ortho):
    camera = looking(trend, plunge, orthographic=ortho)
    strike, tick = seen(plane_symbol(azimuth, dip, np.zeros(3), 1.0), camera)
    assert np.hypot(*(strike[1] - strike[0])) <= 2 * HALF_STRIKE_LENGTH + 1e-6
    assert 0.99 * MIN_TICK_SHARE * TICK_LENGTH <= np.hypot(*tick[1]) <= TICK_LENGTH + 1e-6


@given(st.floats(1.0, 500.0), st.booleans())
def test_symbol_size_does_not_depend_on_zoom(distance, ortho):
    symbol = plane_symbol(40.0, 50.0, np.zeros(3), 1.0)
    near, far = looking(20.0, 30.0, orthographic=ortho), looking(20.0, 30.0, orthographic=ortho)
    far.position, far.distance = -distance * far.direction, distance
    assert seen(symbol, near) == pytest.approx(seen(symbol, far), abs=1e-6)


def test_off_axis_strike_line_has_the_perspective_of_the_plane() -> None:
    """Perspective turns lines at the edge of the view: the symbol turns with them."""
    camera = looking(10.0, 20.0, orthographic=False)
    place = camera.point_at_depth(730.0, 90.0, SIZE, 10.0)
    symbol = plane_symbol(60.0, 55.0, place, 1.0)
    signs = SymbolSet([symbol]).signs(camera, SIZE)
    for direction, shown in (
        (symbol.long_axis, signs.long_axis[0]),
        (symbol.cross_axis, signs.cross_axis[0]),
    ):
        pixels, _ = camera.project(np.array([place, place + 1e-5 * direction]), SIZE)
        step = pixels[1] - pixels[0]
        assert shown / np.hypot(*shown) == pytest.approx(step / np.hypot(*step), abs=1e-4)


@pytest.mark.parametrize(
    ("dip", "overturned", "kind", "text"),
    [
        (0.2, False, "horizontal", ""),
        (41.3, False, "plane", "41"),
        (89.7, False, "vertical", ""),
        (41.3, True, "overturned", "41"),
        (89.7, True, "overturned", "90"),
    ],
)
def test_horizontal_vertical_and_overturned_planes_have_symbols_of_their_own(
    dip, overturned, kind, text
) -> None:
    symbol = plane_symbol(10.0, dip, np.zeros(3), 1.0, is_overturned=overturned)
    assert (symbol.kind, symbol.text) == (kind, text)


def test_vertical_plane_has_ticks_on_both_sides_and_overturned_plane_a_hook() -> None:
    camera = looking(0.0, 90.0)
    _, tick = seen(plane_symbol(10.0, 90.0, np.zeros(3), 1.0), camera)
    assert tick[0] == pytest.approx(-tick[1])
    plain = seen(plane_symbol(10.0, 60.0, np.zeros(3), 1.0), camera)
    hooked = seen(plane_symbol(10.0, 60.0, np.zeros(3), 1.0, is_overturned=True), camera)
    assert hooked[:2] == pytest.approx(plain)
    tick = long_axis(plain[1])
    # The hook lies on the side away from the dip.
    assert (hooked[2:] @ tick <= 1e-9).all()


def test_the_arrow_of_a_line_points_down_its_plunge() -> None:
    shaft, *barbs = seen(line_symbol(90.0, 30.0, np.zeros(3), 1.0), looking(0.0, 0.0))
    assert long_axis(shaft) == pytest.approx([np.cos(np.pi / 6), -0.5], abs=1e-9)
    for barb in barbs:
        assert barb[0] == pytest.approx(shaft[1])


def test_dip_number_is_placed_beyond_the_tick() -> None:
    camera = looking(0.0, 90.0)
    signs = SymbolSet(
        [
            plane_symbol(180.0, 30.0, np.zeros(3), 1.0),
            plane_symbol(180.0, 0.0, np.zeros(3), 1.0),
        ]
    ).signs(camera, SIZE)
    numbers = signs.numbers()
    # Image y runs downwards, and South is down in a view from above.
    assert numbers[0, 1] - signs.pixels[0, 1] > TICK_LENGTH * np.cos(np.pi / 6)
    assert numbers[0, 0] == pytest.approx(signs.pixels[0, 0])
    assert np.isnan(numbers[1]).all()
