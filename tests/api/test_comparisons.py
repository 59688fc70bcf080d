"""`vs.compare`: models, files and arrays in, the command's names out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vomstudio as vs

FLAT = np.column_stack([*(a.ravel() for a in np.mgrid[0:3:0.1, 0:3:0.1]), np.zeros(900)])


def test_result_has_same_field_names_as_command(tmp_path: Path) -> None:
    stages: list[str] = []
    found = vs.compare(
        FLAT + [0, 0, 0.1],
        FLAT,
        m3c2_m=0.3,
        registration_error_m=0.01,
        progress=lambda stage, done, total: stages.append(stage),
    )
    told = json.loads(json.dumps(found.to_dict()))
    assert {"n", "mean_m", "median_m", "std_m", "mad_m", "rms_m", "lod95_m"} <= set(told)
    assert found.mean_m == pytest.approx(0.1)
    assert found.lod95_m == pytest.approx(0.0196, rel=1e-6)
    assert found.distances.shape == (900,)
    assert "accuracy" not in repr(found)
    assert "mean_m" in repr(found)
    assert len(set(stages)) > 3


def test_files_models_and_tables_are_accepted() -> None:
    import pandas as pd

    cliff = vs.read(vs.sample("sample.obj"))
    found = vs.compare(pd.DataFrame(cliff.points, columns=["x", "y", "z"]), cliff)
    assert found.rms_m == pytest.approx(0.0, abs=1e-9)
    assert vs.compare(vs.sample("sample.obj"), cliff).n == len(cliff.points)


@pytest.mark.parametrize(
    "options", [{"m3c2_m": "wide"}, {"m3c2_m": [1.0, 2.0]}, {"m3c2_m": -1.0}, {"cancel": 3}]
)
def test_invalid_lengths_are_refused(options: dict[str, Any]) -> None:
    with pytest.raises((vs.errors.InputError, vs.errors.UsageError)):
        vs.compare(FLAT, FLAT, **options)


def test_comparison_can_be_cancelled() -> None:
    token = vs.CancelToken()
    token.cancel()
    with pytest.raises(vs.errors.Cancelled):
        vs.compare(FLAT, FLAT, cancel=token)


def test_registration_error_of_project_is_used(tmp_path: Path) -> None:
    from vomstudio.geometry.frames import Frame
    from vomstudio.geometry.registrations import Registration

    variances = np.diag([0.0, 0.0, 0.01**2, 0.0, 0.02**2, 0.02**2, 0.02**2])
    record = Registration(
        "r",
        "",
        "points",
        Frame("local"),
        covariance=tuple(map(tuple, variances.tolist())),
        centre=(0.0, 0.0, 0.0),
    )
    # Corners 5 m from the vertical axis through the centre, which turn by 0.01 about it.
    box = np.array([[-3.0, -4.0, 0.0], [3.0, 4.0, 2.0]])
    stated = np.sqrt((3 * 0.02**2 + (5 * 0.01) ** 2) / 3)
    assert record.placing_error_m(box) == pytest.approx(stated)
    points = Registration("r", "", "points", rms_check_m=0.03, rms_control_m=0.01)
    assert points.placing_error_m(box) == pytest.approx(0.03 / np.sqrt(3))
    assert Registration("r", "", "local").placing_error_m(box) is None
    path = tmp_path / "flat.xyz"
    np.savetxt(path, FLAT)
    with pytest.warns(vs.errors.VomWarning, match="registration"):
        assert (
            vs.compare(vs.read(path, unit="m", up="z"), FLAT, m3c2_m=0.3).registration_error_m
            == 0.0
        )
