"""The daylight envelope is a smooth curve of poles whose planes dip along the face."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geology import stereonet as nets
from vomstudio.products.net.slope_figure import _daylight_envelope


@pytest.mark.parametrize("dip", [20.0, 60.0, 84.0, 89.0, 89.99, 90.0])
def test_dip_line_of_each_envelope_pole_is_in_the_slope_face(dip: float) -> None:
    poles = _daylight_envelope(dip)
    assert np.linalg.norm(poles, axis=1) == pytest.approx(1.0)
    assert (poles[:, 2] <= 1e-9).all()
    face = np.array([np.sin(np.radians(dip)), 0.0, np.cos(np.radians(dip))])
    flat = np.hypot(poles[:, 0], poles[:, 1])
    x, y = np.divide(poles[:, :2].T, flat, out=np.zeros((2, len(poles))), where=flat > 0)
    lines = np.stack([poles[:, 2] * x, poles[:, 2] * y, -flat], axis=1)
    assert lines[flat > 1e-6] @ face == pytest.approx(0.0, abs=1e-8)
    # From the centre around to it again, without corners that a pen would not draw.
    places = nets.project(poles)
    assert places[[0, -1]] == pytest.approx(0.0, abs=1e-6)
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 0.05
    deepest = np.degrees(np.arccos(-poles[:, 2])).max()
    assert deepest == pytest.approx(dip, abs=1e-6)


def test_envelope_of_a_vertical_face_covers_half_the_net() -> None:
    places = nets.project(_daylight_envelope(90.0))
    x, y = np.append(places, places[:1], axis=0).T
    area = 0.5 * abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    assert area == pytest.approx(np.pi / 2, rel=1e-3)
