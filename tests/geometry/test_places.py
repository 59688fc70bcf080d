"""What is a coordinate, and what is too far from a model to be a place on it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vomstudio.geometry.coordinate_limits import (
    MAX_DISTANCE_DIAMETERS,
    check_coordinates,
    check_longitude_latitude,
    check_near_model,
    find_invalid_points,
)

CUBE = np.array([[576_700.0, 5_188_100.0, 180.0], [576_703.0, 5_188_104.0, 192.0]])
"""3 by 4 by 12 m: its diagonal is 13 m."""


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e30, -1e13, 1e300])
def test_invalid_coordinates_are_detected_in_single_points_and_arrays(value):
    assert check_coordinates([1.0, value, 2.0]) is not None
    assert check_near_model((576_701.0, value, 185.0), CUBE) is not None
    points = np.zeros((3, 3))
    points[1, 2] = value
    assert find_invalid_points(points).tolist() == [False, True, False]


@pytest.mark.parametrize("value", [0.0, -5_188_100.0, 6_378_137_000.0, 4e7])
def test_terrestrial_metres_and_millimetres_are_valid_coordinates(value):
    assert check_coordinates([value]) is None
    assert not find_invalid_points(np.full((1, 3), value)).any()


def test_point_is_near_model_up_to_maximum_number_of_diameters():
    x, y, z = CUBE[1]
    reach = 13.0 * MAX_DISTANCE_DIAMETERS
    assert check_near_model((x + 0.99 * reach, y, z), CUBE) is None
    assert check_near_model((x + 1.01 * reach, y, z), CUBE) is not None
    finding = check_near_model((x, y, z + 200 * 13.0), CUBE)
    assert finding.code == "coordinate.far-from-model"
    assert finding.values["times"] == pytest.approx(200.0)


def test_model_without_extent_rejects_only_invalid_coordinates():
    holed = np.full((2, 3), np.nan)
    assert check_near_model((1.0, 2.0, 3.0), holed) is None
    assert check_near_model((1.0, math.nan, 3.0), holed) is not None


@pytest.mark.parametrize(
    ("longitude", "latitude", "name"),
    [(12.0, 95.0, "latitude"), (12.0, math.nan, "latitude"), (1e30, 45.0, "longitude")],
)
def test_out_of_range_longitude_or_latitude_is_reported(longitude, latitude, name):
    assert check_longitude_latitude(longitude, latitude).code == f"coordinate.{name}"


def test_valid_longitude_and_latitude_are_accepted():
    assert check_longitude_latitude(-179.9, -90.0) is None
    assert check_longitude_latitude(359.0, 90.0) is None
