"""Errors of the click on the model beside the surveyed accuracy of control points."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

import vomstudio as vs
from vomstudio.cli.common.entry import main
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.registration.evidence import Evidence, register
from vomstudio.registration.observations import Points
from vomstudio.registration.placing import place, register_points
from vomstudio.registration.results import ModelPlacement
from vomstudio.registration.similarity import jacobians

Array = npt.NDArray[np.float64]
RNG = np.random.default_rng(7)
MODEL = RNG.uniform([0, 0, 0], [40, 25, 15], (7, 3))
TURN = Rotation.from_euler("zyx", [130.0, 12.0, -7.0], degrees=True).as_matrix()
WORLD = 2.0 * MODEL @ TURN.T + [900.0, 800.0, 70.0] + RNG.normal(size=(7, 3)) * 0.04
SIGMA = np.full((7, 3), 0.01)
NO_CLICK_ERROR = "control.click-error-unknown"


def codes(placed: ModelPlacement) -> list[str]:
    return [each.code for each in placed.warnings]


def pairs(sigma: Array = SIGMA) -> Pairs:
    return Pairs(tuple("ABCDEFG"), MODEL, WORLD, sigma, np.zeros(7, bool))


def test_survey_and_click_errors_are_added_in_quadrature() -> None:
    with_click = register_points(MODEL, WORLD, SIGMA, click_sigma_m=0.04)
    together = register_points(MODEL, WORLD, np.hypot(SIGMA, 0.04))
    np.testing.assert_allclose(with_click.covariance, together.covariance)
    np.testing.assert_allclose(with_click.matrix, together.matrix)
    assert with_click.click_sigma_m == 0.04
    assert NO_CLICK_ERROR not in codes(with_click)


def test_default_click_error_is_half_the_model_resolution() -> None:
    by_resolution = register(Evidence(pairs=pairs(), resolution=0.04))
    given = register(Evidence(pairs=pairs(), click_sigma_m=0.5 * 0.04 * by_resolution.scale))
    assert by_resolution.click_sigma_m == pytest.approx(0.04, rel=0.01)
    np.testing.assert_allclose(by_resolution.covariance, given.covariance, rtol=1e-6, atol=1e-15)
    assert NO_CLICK_ERROR not in codes(by_resolution)


def test_unknown_click_error_is_reported_if_accuracies_are_stated() -> None:
    exact = register_points(MODEL, WORLD, SIGMA)
    assert exact.click_sigma_m == 0.0
    assert NO_CLICK_ERROR in codes(exact)
    assert NO_CLICK_ERROR not in codes(register_points(MODEL, WORLD))
    assert NO_CLICK_ERROR not in codes(register_points(MODEL, WORLD, SIGMA, click_sigma_m=0.0))


def test_anisotropic_errors_give_the_generalised_least_squares_covariance() -> None:
    """The covariance is (J' V^-1 J)^-1 of the definition, whatever the axes of the errors."""
    factors = np.random.default_rng(3).normal(size=(7, 3, 3)) * 0.02
    covariance = factors @ np.swapaxes(factors, 1, 2) + 1e-4 * np.eye(3)
    wide = Points(list("ABCDEFG"), MODEL, WORLD, np.full((7, 3), 0.2), covariance=covariance)
    placed = place([wide])
    turn = np.array(placed.matrix)[:3, :3]
    total = turn @ covariance @ turn.T + 0.2**2 * np.eye(3)
    moves = jacobians(placed(MODEL) - placed.centre)
    information = np.einsum("nik,nij,njl->kl", moves, np.linalg.inv(total), moves)
    np.testing.assert_allclose(placed.covariance, np.linalg.inv(information), rtol=1e-4, atol=1e-12)


def test_point_errors_rotate_with_the_world() -> None:
    factors = np.random.default_rng(3).normal(size=(7, 3, 3)) * 0.02
    points = Points(
        list("ABCDEFG"), MODEL, WORLD, SIGMA, covariance=factors @ np.swapaxes(factors, 1, 2)
    )
    turn = Rotation.from_euler("z", 37.0, degrees=True).as_matrix()
    first, second = place([points]), place([replace(points, world=WORLD @ turn.T)])
    there = turn @ np.array(first.covariance)[:3, :3] @ turn.T
    np.testing.assert_allclose(np.array(second.covariance)[:3, :3], there, rtol=1e-4, atol=1e-12)


@pytest.mark.full
def test_optimistic_accuracies_do_not_cause_false_blunders() -> None:
    """The click is four times as bad as stated: right points are not accused, a wrong one is."""
    flagged = found = 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        model = rng.uniform(0, 30, (6, 3))
        world = model + rng.normal(size=model.shape) * 0.04
        sigma = np.full(model.shape, 0.01)
        flagged += bool(register_points(model, world, sigma).blunders)
        world[2] += [4.0, 0.0, 0.0]
        found += "3" in [b.label for b in register_points(model, world, sigma).blunders]
    assert flagged <= 1
    assert found >= 29


@pytest.mark.parametrize("sigma", [True, False])
def test_drift_is_reported_for_control_points_as_for_cameras(sigma: bool) -> None:
    rng = np.random.default_rng(5)
    n, rho = 30, 0.9
    model = np.column_stack([np.linspace(0, 200, n), np.tile([0.0, 40.0], n // 2), rng.random(n)])
    errors = rng.normal(size=(n, 3))
    for row in range(1, n):
        errors[row] = rho * errors[row - 1] + np.sqrt(1 - rho**2) * errors[row]
    world = model @ TURN.T + 0.02 * errors
    stated = np.full((n, 3), 0.02 if sigma else np.nan)
    labels = [str(row) for row in range(n)]
    points, cameras = (
        place([Points(labels, model, world, stated, name)]) for name in ("points", "cameras")
    )
    np.testing.assert_allclose(points.covariance, cameras.covariance)
    assert "control.drift" in codes(points)
    assert "cameras.drift" in codes(cameras)


# --- doors ------------------------------------------------------------------------------------
def table(folder: Path) -> Path:
    path = folder / "pairs.csv"
    rows = ["label,model_x,model_y,model_z,x,y,z,sigma_x,sigma_y,sigma_z"]
    rows += [
        ",".join([label, *(repr(float(v)) for v in (*m, *w)), "0.01,0.01,0.01"])
        for label, m, w in zip("ABCDEFG", MODEL, WORLD, strict=True)
    ]
    path.write_text("\n".join(rows) + "\n")
    return path


def test_command_and_python_apply_the_same_click_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(table(tmp_path))
    assert main(["register", "-", "--pairs", path, "--click-sigma", "0.04", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    with pytest.warns(vs.errors.VomWarning):
        placed = vs.register(MODEL, WORLD, sigma_m=SIGMA, click_sigma_m=0.04)
    assert result["click_sigma_m"] == 0.04
    assert result["rotation_error_deg"]["about_up"] == pytest.approx(
        placed.rotation_error_deg.about_up
    )
    assert main(["register", "-", "--pairs", path, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["click_sigma_m"] == 0.0
    assert NO_CLICK_ERROR in [each["code"] for each in result["warnings"]]


def test_default_click_error_comes_from_the_model_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = tmp_path / "faces.obj"
    mesh.write_text(
        "v 0 0 0\nv 3 0 0\nv 0 4 0\nv 40 25 15\nv 43 25 15\nv 40 29 15\nf 1 2 3\nf 4 5 6\n"
    )
    assert main(["register", str(mesh), "--pairs", str(table(tmp_path)), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    resolution = vs.read(mesh, up="z", unit="m").resolution_m
    assert result["click_sigma_m"] == pytest.approx(0.5 * result["scale"] * resolution)


@pytest.mark.parametrize("value", ["-0.01", "x", "1e9", "nan"])
def test_invalid_click_error_is_rejected(value: str, tmp_path: Path) -> None:
    path = str(table(tmp_path))
    assert main(["register", "-", "--pairs", path, f"--click-sigma={value}"]) == 2
