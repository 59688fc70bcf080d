"""Readings by compass of which the azimuth means something else."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from vomstudio.registration.compass_checks import azimuth_findings

Array = npt.NDArray[np.float64]
LABELS = [f"B{i}" for i in range(10)]
TURN = Rotation.from_euler("zyx", [40, 6, -9], degrees=True).as_matrix()


def readings(seed: int) -> tuple[Array, Array, Array]:
    """Dip directions, dips (degrees) with 2 degrees of error, and normals in the model."""
    chance = np.random.default_rng(seed)
    azimuth, dip = chance.uniform(0, 360, 10), chance.uniform(30, 80, 10)
    model = normals(azimuth, dip) @ TURN
    return azimuth + chance.normal(size=10) * 2, dip + chance.normal(size=10) * 2, model


def normals(azimuth: Array, dip: Array) -> Array:
    """Upward: of a plane that dips to the east by 30 degrees (0.5, 0, 0.87)."""
    a, d = np.radians(azimuth), np.radians(dip)
    return np.column_stack([np.sin(d) * np.sin(a), np.sin(d) * np.cos(a), np.cos(d)])


def test_correct_readings_give_no_finding() -> None:
    for seed in range(15):
        azimuth, dip, model = readings(seed)
        assert azimuth_findings(LABELS, model, normals(azimuth, dip)) == []


@pytest.mark.parametrize("given", [-90.0, 90.0, 180.0])
def test_two_wrong_azimuths_are_reported_with_their_correction(given: float) -> None:
    for seed in range(8):
        azimuth, dip, model = readings(seed)
        azimuth[[3, 6]] += given
        (found,) = azimuth_findings(LABELS, model, normals(azimuth, dip))
        assert (found.code, found.values["labels"]) == ("compass.other-azimuth", ("B3", "B6"))
        assert abs(found.values["turn_deg"] + given) % 360.0 == 0.0
