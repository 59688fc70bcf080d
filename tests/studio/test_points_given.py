"""What coordinates of points on a model of a project look like."""

from __future__ import annotations

import numpy as np
import pytest

from tests.messages import by_code, refused
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.geometry.frames import Frame
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.studio.models import new_model
from vomstudio.studio.placing.registering import place_by_points

CRS = "EPSG:32615"
MODEL = new_model("face", "face.ply", "mesh", "", Frame("crs", crs=CRS))
BOUNDS = np.array([[576_660.0, 5_188_110.0, 150.0], [576_760.0, 5_188_200.0, 162.0]])


def given() -> Pairs:
    chance = np.random.default_rng(0)
    model = chance.uniform(*BOUNDS, (6, 3))
    world = model + chance.normal(size=model.shape) * 0.02
    unstated = np.full(model.shape, np.nan)
    return Pairs(tuple("ABCDEF"), model, world, unstated, np.zeros(6, bool))


def test_correct_points_give_no_finding() -> None:
    codes = by_code(place_by_points(given(), BOUNDS, MODEL, CRS).warnings).keys()
    assert not codes & {"control.swapped-columns", "registration.moved"}


def test_swapped_columns_are_rejected() -> None:
    pairs = given()
    pairs.world[:] = pairs.world[:, [1, 0, 2]]
    with pytest.raises(InputError) as refused:
        place_by_points(pairs, BOUNDS, MODEL, CRS)
    assert refused.value.code == "frame.swapped-axes"


def test_points_in_another_frame_are_rejected() -> None:
    pairs = given()
    pairs.model[:] -= [576_000.0, 5_188_000.0, 0.0]
    with refused("registration.off-model", GeometryError):
        place_by_points(pairs, BOUNDS, MODEL, CRS)
