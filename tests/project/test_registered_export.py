"""The table of a registered project states its registration, and is read back with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs
from tests.project.test_registered_figures import SHAPE, model, on_plane, registration
from vomstudio.geology.common_rotation_errors import region
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.rotation_errors import direction_covariance
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.project.exports.export import export_records
from vomstudio.project.records import Model, Record


def records(*placed: Model) -> dict[str, Record]:
    attitudes = [Plane(90.0 + 4 * (i % 3), 30.0 + 5 * (i % 4)) for i in range(8)]
    beds = [
        on_plane(f"t{i}", plane, placed[i % len(placed)].id, i) for i, plane in enumerate(attitudes)
    ]
    return {each.id: each for each in (*placed, *beds)}


def test_mean_of_exported_table_includes_the_registration_error(tmp_path: Path) -> None:
    path = tmp_path / "beds.csv"
    export_records(records(model("m1", registration())), "csv", path)
    found = vs.stats(path).sets["all"].fisher
    assert found is not None
    mean = Line(found.trend_deg, found.plunge_deg).vector()
    expected = region(mean, direction_covariance(SHAPE[:3, :3], mean)[0]).largest_deg
    assert found.registration_error_deg == pytest.approx(expected, rel=1e-6)


def test_each_registration_has_its_own_rotation_error_and_declared_models_none(
    tmp_path: Path,
) -> None:
    path = tmp_path / "beds.csv"
    placed = (
        model("m1", registration("r1")),
        model("m2", registration("r2", 2.0 * SHAPE)),
        model("m3", Frame("local")),
    )
    export_records(records(*placed), "csv", path)
    rotation_errors = read_orientations(path).rotation_errors
    assert rotation_errors is not None
    assert rotation_errors.group.tolist() == [0, 1, -1, 0, 1, -1, 0, 1]
    assert rotation_errors.rotations[1] == pytest.approx(2.0 * rotation_errors.rotations[0])
    assert rotation_errors.rotations[0] == pytest.approx(SHAPE[:3, :3])


def test_export_without_registration_error_omits_it(tmp_path: Path) -> None:
    path = tmp_path / "beds.csv"
    export_records(records(model("m1", Frame("local"))), "csv", path)
    assert "registration:" not in path.read_text("utf-8")
    assert read_orientations(path).rotation_errors is None
    assert np.isfinite(vs.stats(path).sets["all"].fisher.total95_deg)  # type: ignore[union-attr]
