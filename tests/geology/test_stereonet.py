"""Net geometry against closed forms, mplstereonet, and what the projections are named for."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vomstudio.core.errors import GeometryError
from vomstudio.geology import stereonet as nets
from vomstudio.geology.orientation import (
    Line,
    Plane,
    angle_between_lines,
    line_from_rake,
    lines_to_vectors,
)
from vomstudio.geometry.planes import fit_plane

azimuths = st.floats(0, 360)
steeps = st.floats(0, 90)
projections = st.sampled_from(nets.PROJECTIONS)


@pytest.mark.parametrize("projection", nets.PROJECTIONS)
def test_north_plots_at_top_and_vertical_line_at_center(projection: str) -> None:
    vectors = lines_to_vectors([0, 90, 180, 270, 0], [0, 0, 0, 0, 90])
    np.testing.assert_allclose(
        nets.project(vectors, projection), [[0, 1], [1, 0], [0, -1], [-1, 0], [0, 0]], atol=1e-15
    )


def test_radii_match_both_projections() -> None:
    half = math.radians((90 - 30) / 2)
    assert nets.project(Line(90, 30).vector(), "area")[0, 0] == pytest.approx(
        math.sqrt(2) * math.sin(half)
    )
    assert nets.project(Line(90, 30).vector(), "angle")[0, 0] == pytest.approx(math.tan(half))


def test_equal_area_keeps_areas() -> None:
    # A hemisphere's even scatter stays even: each ring of equal area of the net has its share.
    rng = np.random.default_rng(0)
    z = -rng.random(200_000)
    t = rng.uniform(0, 2 * math.pi, z.size)
    h = np.sqrt(1 - z**2)
    r = np.hypot(*nets.project(np.stack([h * np.cos(t), h * np.sin(t), z], 1), "area").T)
    counts, _ = np.histogram(r**2, bins=20, range=(0, 1))
    assert np.abs(counts / z.size - 0.05).max() < 5 * math.sqrt(0.05 / z.size)


def cone(axis: Line, angle: float) -> list[np.ndarray]:
    """An ellipse of confidence that is as wide as long."""
    across = np.cross(axis.vector(), np.roll(axis.vector(), 1) + [0.0, 0.1, 0.3])
    return nets.confidence_ellipse(axis.vector(), across, angle, angle)


def test_equal_angle_turns_every_cone_into_a_circle() -> None:
    (part,) = cone(Line(200, 50), 20)
    x, y = nets.project(part, "angle").T
    # Fit x^2 + y^2 = a x + b y + c exactly.
    solution, *_ = np.linalg.lstsq(np.stack([x, y, np.ones_like(x)], 1), x**2 + y**2, rcond=None)
    np.testing.assert_allclose(np.stack([x, y, np.ones_like(x)], 1) @ solution, x**2 + y**2)


def test_upward_vectors_plot_at_lower_end_and_input_is_unchanged() -> None:
    v = np.array([[0.3, 0.4, 0.5]])
    before = v.copy()
    np.testing.assert_allclose(nets.project(v), nets.project(-v))
    np.testing.assert_array_equal(v, before)


@pytest.mark.parametrize("projection", nets.PROJECTIONS)
def test_projection_agrees_with_mplstereonet(mplstereonet: Any, projection: str) -> None:
    """By its transform, whose net has the radius of the root of 2, or 2."""
    rng = np.random.default_rng(1)
    trend, plunge = rng.uniform(0, 360, 100), rng.uniform(0, 90, 100)
    positions = np.transpose(mplstereonet.line(plunge.copy(), trend.copy()))
    vectors = lines_to_vectors(trend, plunge)
    np.testing.assert_allclose(nets.vectors_to_longitude_latitude(vectors), positions, atol=1e-12)
    transforms = mplstereonet.stereonet_transforms
    kind, radius = {
        "area": (transforms.LambertTransform, math.sqrt(2.0)),
        "angle": (transforms.StereographicTransform, 2.0),
    }[projection]
    theirs = kind(0.0, 0.0, 1).transform(positions) / radius
    np.testing.assert_allclose(nets.project(vectors, projection), theirs, atol=1e-12)


@given(azimuths, steeps)
def test_longitude_and_latitude_round_trip_to_line(trend: float, plunge: float) -> None:
    vector = Line(trend, plunge).vector()
    before = vector.copy()
    for sign in (1.0, -1.0):
        back = nets.longitude_latitude_to_vectors(nets.vectors_to_longitude_latitude(sign * vector))
        assert back[2] <= 1e-15
        assert np.abs(np.cross(back, vector)).max() < 1e-12
    assert (vector == before).all()


def test_a_grid_covers_the_lower_hemisphere_to_its_rim() -> None:
    steps, places = nets.hemisphere_grid(19)
    assert np.degrees(steps) == pytest.approx(np.arange(-90, 91, 10))
    assert np.linalg.norm(places, axis=-1) == pytest.approx(np.ones((19, 19)))
    assert (places[..., 2] <= 1e-15).all()
    assert places[9, 9] == pytest.approx([0.0, 0.0, -1.0])
    edge = np.concatenate([places[0], places[-1], places[:, 0], places[:, -1]])
    assert edge[:, 2] == pytest.approx(np.zeros(76), abs=1e-15)
    # The rows run to the North, the columns to the East.
    assert places[13, 9] == pytest.approx(Line(0, 50).vector())
    assert places[9, 13] == pytest.approx(Line(90, 50).vector())


@given(azimuths, steeps, projections)
def test_clicked_position_round_trips_to_line(trend: float, plunge: float, projection: str) -> None:
    line = Line(trend, plunge)
    x, y = nets.project(line.vector(), projection)[0]
    back = nets.line_at(float(x), float(y), projection)
    assert back is not None
    assert angle_between_lines(line, back) < 1e-5


def test_click_outside_net_gives_no_line() -> None:
    assert nets.line_at(0.8, 0.8) is None
    assert np.isnan(nets.project([[0, 0, 0.0]])).all()


@given(azimuths, st.floats(0.01, 90))
def test_great_circle_contains_lines_of_its_plane_from_rim_to_rim(
    dip_direction: float, dip: float
) -> None:
    plane = Plane(dip_direction, dip)
    arc = nets.great_circle(plane)
    assert np.linalg.norm(arc, axis=1) == pytest.approx(np.ones(91))
    assert arc[[0, -1], 2] == pytest.approx([0.0, 0.0], abs=1e-15)
    assert arc[:, 2].max() < 1e-15
    np.testing.assert_allclose(arc @ plane.normal(), 0, atol=1e-12)


def test_the_great_circle_of_a_horizontal_plane_is_the_rim() -> None:
    arc = nets.great_circle(Plane(0, 0))
    np.testing.assert_allclose(np.hypot(*arc.T[:2]), 1)
    np.testing.assert_allclose(arc[:, 2], 0)
    np.testing.assert_allclose(arc[0], arc[-1], atol=1e-15)


@given(azimuths, steeps, st.floats(0.5, 89))
def test_a_cone_keeps_its_angle_and_is_split_on_the_rim(
    trend: float, plunge: float, angle: float
) -> None:
    axis = Line(trend, plunge)
    parts = cone(axis, angle)
    for part in parts:
        assert part[:, 2].max() < 1e-11
        away = np.degrees(np.arccos(np.clip(np.abs(part @ axis.vector()), 0, 1)))
        # Crossing points are interpolated between neighbours 2 degrees apart on the cone.
        np.testing.assert_allclose(away, angle, atol=0.05)
    if len(parts) > 1:
        for part in parts:
            for end in (part[0], part[-1]):
                assert end[2] == pytest.approx(0, abs=1e-9)
    if plunge > angle + 0.01:
        assert len(parts) == 1
    elif plunge < angle - 0.01 and plunge + angle < 90:
        assert len(parts) == 2


def test_the_ellipse_of_a_pole_reaches_its_semi_axes() -> None:
    plane = Plane(132, 41)
    (lines,) = nets.pole_ellipse(plane, 6.0, 2.0, 30.0)
    pole = plane.pole().vector()
    away = np.degrees(np.arccos(lines @ pole))
    assert away.max() == pytest.approx(6, abs=1e-6)
    assert away.min() == pytest.approx(2, abs=1e-6)
    far = lines[np.argmax(away)] - pole * (lines[np.argmax(away)] @ pole)
    toward = math.cos(math.radians(30)) * plane.strike_vector() + 0.5 * plane.dip_vector()
    assert abs(far @ toward) / np.linalg.norm(far) == pytest.approx(1)


@pytest.mark.parametrize("rake_deg", [0.0, 30.0, 90.0, 140.0])
def test_pole_ellipse_of_straight_trace_is_elongated_across_the_trace(rake_deg: float) -> None:
    """The plane turns about the trace, so that its normal stays perpendicular to it."""
    plane = Plane(130, 40)
    trace = line_from_rake(plane, rake_deg).vector()
    across = np.cross(plane.normal(), trace)
    rng = np.random.default_rng(round(rake_deg))
    along, beside = rng.uniform([-5, -0.3], [5, 0.3], (60, 2)).T
    points = np.outer(along, trace) + np.outer(beside, across)
    points += np.outer(rng.normal(0, 0.01, 60), plane.normal())
    fit = fit_plane(points)
    assert (fit.error_rake_deg - rake_deg) % 180 == pytest.approx(90, abs=2)
    fitted = Plane(fit.dip_direction_deg, fit.dip_deg)
    (lines,) = nets.pole_ellipse(
        fitted, fit.max_confidence95_deg, fit.min_confidence95_deg, fit.error_rake_deg
    )
    farthest = lines[np.argmin(np.abs(lines @ fitted.pole().vector()))]
    off_trace = np.degrees(np.arcsin(np.abs(farthest @ trace)))
    assert off_trace < 1.5 * fit.min_confidence95_deg < 0.3 * fit.max_confidence95_deg


def test_the_ellipse_of_a_steep_plane_is_split_at_the_rim() -> None:
    parts = nets.pole_ellipse(Plane(132, 88), 6.0, 3.0, 90.0)
    assert len(parts) == 2
    assert [p[i, 2] for p in parts for i in (0, -1)] == pytest.approx([0.0] * 4, abs=1e-9)


def test_ellipse_with_parallel_axes_is_rejected() -> None:
    with pytest.raises(GeometryError):
        nets.confidence_ellipse([0, 0, -1], [0, 0, 1], 5, 2)
