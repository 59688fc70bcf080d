"""A reconstruction writes the registration of `reconstruction.json` beside mesh and cloud."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vomstudio.geometry.registration_frames import is_same_registration
from vomstudio.io.models.reconstruction_file import read_result_registration
from vomstudio.io.models.registration_file import find_registration
from vomstudio.photogrammetry.pipeline.outputs import Outputs
from vomstudio.photogrammetry.pipeline.written_models import write_json, write_registrations


@pytest.fixture
def outputs(tmp_path: Path) -> Outputs:
    made = Outputs(tmp_path / "cliff")
    made.folder.mkdir()
    for path in (made.mesh, *made.other_models, made.dense):
        path.write_bytes(path.name.encode())
    return made


def result(**registration: Any) -> dict[str, Any]:
    own = {
        "method": "ground control points",
        "rotation_error_deg": {"about_up": 0.1, "about_east": 0.2, "about_north": np.float64(0.3)},
        "scale_error": 1e-3,
        "covariance": np.diag([1e-6] * 4 + [1e-4] * 3).tolist(),
        "centre": (4e5, 5e6, 300.0),
        "points": [
            {
                "label": "A",
                "role": "control",
                "residual_m": (0.01, 0.0, -0.02),
                "surveyed": np.array([4e5, 5e6, 310.0]),
            },
        ],
        "shape": {"reach_m": 12.5, "normal": [0.0, -1.0, 0.0]},
    }
    return {"frame": "EPSG:32633", "scaled": True, "registration": own | registration}


def test_each_model_has_the_registration_of_the_result(outputs: Outputs) -> None:
    told = result()
    write_json(outputs.result, told)
    write_registrations(outputs, told)
    expected = read_result_registration(outputs.mesh)
    assert [point.label for point in expected.control] == ["A"]
    for path in (outputs.mesh, *outputs.other_models, outputs.dense):
        found = find_registration(path, hashlib.sha256(path.read_bytes()).hexdigest())
        assert found.findings == ()
        assert found.registration is not None
        assert is_same_registration(found.registration, expected)
    names = sorted(path.name for path in outputs.folder.glob("*.registration.json"))
    assert names == ["dense.registration.json", "model.registration.json"]
    listed = json.loads((outputs.folder / names[1]).read_text("utf-8"))["files"]
    assert sorted(listed) == ["model.glb", "model.obj", "model.ply"]


def test_unregistered_model_removes_registrations_of_an_earlier_run(outputs: Outputs) -> None:
    write_registrations(outputs, result())
    unplaced = result() | {"registration": {}, "frame": "local", "scaled": False}
    write_registrations(outputs, unplaced)
    assert list(outputs.folder.glob("*.registration.json")) == []
