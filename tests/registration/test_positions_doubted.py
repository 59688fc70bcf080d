"""What positions of cameras are mistaken for is named, and no photo is blamed for it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from pyproj import Transformer

from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.registration.camera_positions import select_consistent_cameras
from vomstudio.registration.checks.heights import constant_height_findings
from vomstudio.registration.checks.point_order import find_row_order

Array = npt.NDArray[np.float64]
ORIGIN = np.array([398_000.0, 4_980_000.0, 320.0])
PHOTOS = [f"IMG_{i:02d}.jpg" for i in range(12)]


def cameras(seed: int, noise: float = 0.5) -> tuple[Array, Array]:
    """An arc of twelve cameras about an outcrop, and where a receiver puts them."""
    chance = np.random.default_rng(seed)
    turn = np.linspace(0.0, 2.4, 12)
    model = np.column_stack([35 * np.cos(turn), 35 * np.sin(turn), 5 + 3 * turn])
    model += chance.normal(size=model.shape) * 2.5
    return model, ORIGIN + model + chance.normal(size=model.shape) * noise


def told(model: Array, world: Array) -> tuple[list[Finding], list[Finding]]:
    nothing = np.full(world.shape, np.nan)
    _, wrong, gone = select_consistent_cameras(
        PHOTOS[: len(model)], model, world, nothing, is_alone=True
    )
    return wrong, gone


@pytest.mark.full
def test_correct_camera_positions_give_no_finding() -> None:
    alarms = 0
    for seed in range(24):
        model, world = cameras(seed, noise=float(1 + seed % 5))
        if seed % 3 == 0:  # from above, at one height by the barometer
            model[:, 2] = 40.0 + np.random.default_rng(seed).normal(size=12) * 0.3
            world[:, 2] = 360.0
        alarms += bool(told(model, world)[0])
    assert alarms == 0


@pytest.mark.parametrize("height", [0.0, 330.0])
def test_constant_camera_heights_are_reported(height: float) -> None:
    for seed in range(5):
        model, world = cameras(seed)
        world[:, 2] = height
        (finding,), gone = told(model, world)
        assert finding.code == "control.constant-heights"
        assert finding.values["height"] == height
        assert gone == []


def test_three_points_of_constant_height_are_reported_unless_model_is_flat() -> None:
    model = np.array([[0.0, 0.0, 0.0], [30.0, 0.0, 18.0], [10.0, 25.0, 4.0]])
    assert constant_height_findings(model, model * [1.0, 1.0, 0.0])
    flat = model * [1.0, 1.0, 0.0]
    assert constant_height_findings(flat, flat + ORIGIN) == []


def test_photos_in_another_order_are_reported() -> None:
    for seed in range(5):
        model, world = cameras(seed)
        for order in (world[::-1], np.roll(world, 1, axis=0)):
            (finding,), gone = told(model, order)
            assert (finding.code, finding.values["photos"]) == ("control.other-order", True)
            assert gone == []
        # The first photo has no position, and the last position no photo.
        found = find_row_order(model[1:], world[:-1])
        assert found is not None
        assert (found.rows + 1 == found.coordinate_rows).all()


def test_swapped_x_and_y_columns_exclude_no_photo() -> None:
    model, world = cameras(0)
    _, gone = told(model, world[:, [1, 0, 2]])
    assert gone == []


@pytest.mark.parametrize("latitude_first", [False, True])
def test_positions_in_degrees_are_not_reported_as_identical(latitude_first: bool) -> None:
    model, world = cameras(1)
    back = Transformer.from_crs("EPSG:32633", "EPSG:4326", always_xy=True)
    longitude, latitude = back.transform(world[:, 0], world[:, 1])
    columns = [latitude, longitude] if latitude_first else [longitude, latitude]
    for heights in (world[:, 2], np.full(12, 320.0)):
        with refused("frame.maybe-degrees", GeometryError):
            told(model, np.column_stack([*columns, heights]))
    with refused("gps-equal", GeometryError):
        told(model, np.tile(ORIGIN, (12, 1)))
