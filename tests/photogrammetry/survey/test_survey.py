from __future__ import annotations

import pytest

from tests.messages import refused
from vomstudio.core.errors import UsageError
from vomstudio.photogrammetry.survey.survey_resolution import (
    ground_sampling_distance,
    gsd_for_plane,
)


def test_pixel_size_follows_the_pinhole_model():
    # 23.5 mm sensor, 6000 px: 3.9167 um pixels; 35 mm lens at 50 m: 50 / 0.035 * 3.9167 um.
    gsd = ground_sampling_distance(23.5, 35.0, 50.0, 6000)
    assert gsd == pytest.approx(50.0 / 0.035 * 23.5e-3 / 6000, rel=1e-12)
    assert gsd_for_plane(1000 * gsd) == pytest.approx(gsd)


def test_pixel_size_doubles_with_distance_and_halves_with_focal_length():
    base = ground_sampling_distance(13.2, 8.8, 30.0, 5472)
    assert ground_sampling_distance(13.2, 8.8, 60.0, 5472) == pytest.approx(2 * base)
    assert ground_sampling_distance(13.2, 17.6, 30.0, 5472) == pytest.approx(base / 2)


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan")])
def test_nonpositive_values_are_rejected(bad):
    with refused("number.not-positive", UsageError):
        ground_sampling_distance(13.2, bad, 30.0, 5472)
