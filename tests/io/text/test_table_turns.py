"""What tables say of registrations: in the lines of their head, or row by row."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

import vomstudio as vs
from tests.messages import by_code
from vomstudio.geology.common_rotation_errors import UNKNOWN_GROUP
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.project.tables.registration_comments import registration_lines

FACTOR = float(np.sqrt(chi2.ppf(0.95, 2)))
HEAD = "dip_direction_deg,dip_deg,model,registration_error_deg"
COVARIANCE = [[1.0, 0.2, 0.0], [0.2, 4.0, 0.0], [0.0, 0.0, 9.0]]


def table(folder: Path, *lines: str) -> OrientationTable:
    path = folder / "beds.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_orientations(path)


def line(*models: str, covariance: object = COVARIANCE) -> str:
    told = {"models": list(models), "rotation_covariance_deg2": covariance}
    return f"# {registration_lines([told])[0]}"


def test_table_without_registration_columns_has_no_rotation_errors(tmp_path: Path) -> None:
    found = table(tmp_path, "dip direction,dip", "90,30", "100,40")
    assert found.rotation_errors is None


def test_error_column_alone_is_isotropic(tmp_path: Path) -> None:
    found = table(
        tmp_path, HEAD, "90,30,a,2", "100,40,a,3", "110,40,b,1", "100,40,,"
    ).rotation_errors
    assert found is not None
    assert found.group.tolist() == [0, 0, 1, UNKNOWN_GROUP]
    sigma = np.degrees(np.sqrt(np.diagonal(found.rotations, axis1=1, axis2=2)))
    assert sigma * FACTOR == pytest.approx(np.array([[3.0] * 3, [1.0] * 3]))


def test_header_covariance_gives_rotation_axes(tmp_path: Path) -> None:
    found = table(
        tmp_path, line("a", "b"), HEAD, "90,30,a,2", "100,40,b,3", "90,30,,"
    ).rotation_errors
    assert found is not None
    # Both models were placed by one registration.
    assert found.group.tolist() == [0, 0, UNKNOWN_GROUP]
    assert found.rotations[0] == pytest.approx(np.array(COVARIANCE) * np.radians(1.0) ** 2)


@pytest.mark.parametrize(
    "bad",
    [
        "# registration: no JSON",
        line("a", covariance=[[1.0]]),
        line("a", covariance=[[1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0]]),
        line("a", covariance=[["x"] * 3] * 3),
        "# registration: [1, 2]",
    ],
)
def test_damaged_header_leaves_the_error_column(tmp_path: Path, bad: str) -> None:
    found = table(tmp_path, bad, HEAD, "90,30,a,2", "100,40,a,2").rotation_errors
    assert found is not None
    assert np.degrees(np.sqrt(found.rotations[0, 0, 0])) * FACTOR == pytest.approx(2.0)


def test_covariance_is_ignored_if_two_models_share_a_name(tmp_path: Path) -> None:
    lines = line("a"), line("a", covariance=np.eye(3).tolist())
    found = table(tmp_path, *lines, HEAD, "90,30,a,2", "100,40,a,2").rotation_errors
    assert found is not None
    assert np.degrees(np.sqrt(found.rotations[0, 0, 0])) * FACTOR == pytest.approx(2.0)


@pytest.mark.parametrize("cell", ["", "-1", "nan", "inf", "120", "word"])
def test_invalid_half_angle_gives_no_rotation_errors(tmp_path: Path, cell: str) -> None:
    assert table(tmp_path, HEAD, f"90,30,a,{cell}", f"100,40,a,{cell}").rotation_errors is None


def test_means_and_fold_axes_include_the_registration_error(tmp_path: Path) -> None:
    """Turned about up alone by 3 degrees (1 sigma): the mean pole of beds that dip 30 degrees moves
    by the sine of that."""
    path = tmp_path / "beds.csv"
    rows = [f"{90 + i % 3},{30 + i % 2},a,2" for i in range(12)]
    told = line("a", covariance=[[0, 0, 0], [0, 0, 0], [0, 0, 9.0]])
    path.write_text("\n".join([told, HEAD, *rows]), encoding="utf-8")
    found = vs.stats(path).sets["all"].fisher
    assert found is not None
    assert found.alpha95_deg is not None
    sine = np.cos(np.radians(found.plunge_deg))
    assert found.registration_error_deg == pytest.approx(3.0 * FACTOR * sine, rel=1e-6)
    assert found.total95_deg == pytest.approx(
        np.hypot(found.alpha95_deg, found.registration_error_deg)
    )
    beta = vs.fold(path).beta
    level = np.cos(np.radians(beta.plunge_deg))
    assert beta.registration_error_deg == pytest.approx(3.0 * FACTOR * level, rel=1e-6)
    assert beta.total95_deg is not None
    assert beta.total95_deg >= beta.max_confidence95_deg
    assert json.dumps(vs.fold(path).to_dict())


def test_frame_read_from_file_keeps_the_header_covariance(tmp_path: Path) -> None:
    path = tmp_path / "beds.csv"
    rows = [f"{90 + i % 3},{30 + i % 2},a,2" for i in range(12)]
    path.write_text("\n".join([line("a"), HEAD, *rows]), encoding="utf-8")
    frame = vs.read_orientations(path)
    assert frame.attrs["registrations"][0]["rotation_covariance_deg2"] == COVARIANCE
    of_frame, of_file = (vs.stats(each).sets["all"].fisher for each in (frame, path))
    assert of_frame is not None
    assert of_file is not None
    assert of_frame.registration_error_deg == pytest.approx(of_file.registration_error_deg)


def test_a_fold_of_a_bowed_model_is_warned_of(tmp_path: Path) -> None:
    path = tmp_path / "beds.csv"
    told = {"models": ["a"], "rotation_covariance_deg2": COVARIANCE, "bowed_deg": 8.0}
    rows = [f"{azimuth},{dip},a,2" for azimuth, dip in ((90, 3), (270, 3), (90, 1), (272, 2))]
    path.write_text("\n".join([f"# {registration_lines([told])[0]}", HEAD, *rows]))
    assert "fold.bowed" in by_code(vs.fold(path).reasons)
    steep = [f"{azimuth},{dip},a,2" for azimuth, dip in ((90, 30), (270, 30), (90, 1), (272, 2))]
    path.write_text("\n".join([f"# {registration_lines([told])[0]}", HEAD, *steep]))
    assert "fold.bowed" not in by_code(vs.fold(path).reasons)
