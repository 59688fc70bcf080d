"""Values by which nothing can be placed are refused with a sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs
from tests.messages import refused
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.geometry.coordinate_limits import check_error
from vomstudio.io.control.observation_tables import read_pairs, read_positions
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.studio.placing.register_order import register_model

MODEL = np.random.default_rng(2).uniform(-20.0, 20.0, (5, 3))


@pytest.mark.parametrize("n", [3, 5])
def test_coincident_points_are_rejected(n: int) -> None:
    with refused("control.one-place", GeometryError):
        vs.register(MODEL[:n], np.full((n, 3), 100.0))
    with refused("control.one-place", GeometryError):
        vs.register(np.zeros((n, 3)), MODEL[:n])


@pytest.mark.parametrize("sigma", [1e-300, 1e-160, 1e-100, 1e-9, 1e200])
def test_invalid_accuracies_are_rejected(tmp_path: Path, sigma: float) -> None:
    with refused("accuracy.out-of-range", field="sigma_m"):
        vs.register(MODEL, MODEL, sigma_m=np.full((5, 3), sigma))
    table = tmp_path / "p.csv"
    table.write_text(
        f"label,model_x,model_y,model_z,x,y,z,sigma\nA,1,2,3,4,5,6,0.02\nB,1,2,3,4,5,6,{sigma}\n"
    )
    with refused("accuracy.out-of-range", line=3, field="sigma", value=sigma):
        read_pairs(table)
    for option, text in (("level", "0,0,0,1,0,0"), ("scale", "0,0,0,1,0,0,1")):
        with pytest.raises(UsageError) as error:
            register_model("-", RegisterOptions(**{option: (f"{text},{sigma}",)}), lambda *_: None)
        assert error.value.field == f"--{option}"


def test_valid_or_missing_accuracies_are_accepted() -> None:
    for value in (1e-6, 0.02, 30.0, float("nan")):
        assert check_error(value) is None


def test_commas_in_geo_txt_are_reported(tmp_path: Path) -> None:
    path = tmp_path / "geo.txt"
    path.write_text("EPSG:32633\na.jpg,398000,4980000,320\nb.jpg,398010,4980000,321\n")
    with refused("table.other-delimiter", delimiter=","):
        read_positions(path)
