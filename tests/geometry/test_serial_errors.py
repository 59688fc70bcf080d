"""Errors that follow each other: how alike neighbours are, and what that does to a fit."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from vomstudio.geometry.serial_errors import correlate, fit_serial_correlation, whiten

Array = npt.NDArray[np.float64]


def drifting(rng: np.random.Generator, n: int, rho: float) -> Array:
    """(n, 3) with variance 1."""
    errors = rng.normal(size=(n, 3))
    for i in range(1, n):
        errors[i] = rho * errors[i - 1] + np.sqrt(1.0 - rho**2) * errors[i]
    return errors


def lines(n: int) -> Array:
    """(n, 3, 6) a straight line in each coordinate."""
    moves = np.zeros((n, 3, 6))
    for axis in range(3):
        moves[:, axis, 2 * axis] = 1.0
        moves[:, axis, 2 * axis + 1] = np.linspace(-1.0, 1.0, n)
    return moves


def left_by_lines(errors: Array) -> Array:
    x = lines(len(errors)).reshape(-1, 6)
    y = errors.ravel()
    return (y - x @ np.linalg.lstsq(x, y, rcond=None)[0]).reshape(errors.shape)


@pytest.mark.parametrize("rho", [0.3, 0.7, 0.95])
def test_correlate_applies_correlation_matrix_and_whiten_inverts_it(rho: float) -> None:
    lag = np.abs(np.subtract.outer(np.arange(12), np.arange(12)))
    matrix = rho**lag
    rng = np.random.default_rng(0)
    values = rng.normal(size=(12, 2))
    assert correlate(values, rho) == pytest.approx(matrix @ values)
    root = whiten(np.eye(12), rho)
    assert root @ matrix @ root.T == pytest.approx(np.eye(12), abs=1e-12)


def test_independent_errors_are_rarely_reported_as_drift() -> None:
    rng = np.random.default_rng(1)
    found = [
        fit_serial_correlation(lines(20), left_by_lines(rng.normal(size=(20, 3))))
        for _ in range(300)
    ]
    assert sum(rho > 0.0 for rho in found) <= 10


@pytest.mark.parametrize("rho", [0.5, 0.8, 0.9])
def test_correlation_estimate_corrects_for_fitted_parameters(rho: float) -> None:
    rng = np.random.default_rng(2)
    found = [
        fit_serial_correlation(lines(60), left_by_lines(drifting(rng, 60, rho))) for _ in range(60)
    ]
    assert np.median(found) == pytest.approx(rho, abs=0.06)


def test_few_errors_give_zero_correlation() -> None:
    errors = np.ones((5, 3))
    assert fit_serial_correlation(lines(5), errors) == 0.0


def test_reversing_order_and_scaling_do_not_change_correlation() -> None:
    rng = np.random.default_rng(3)
    errors = left_by_lines(drifting(rng, 40, 0.7))
    found = fit_serial_correlation(lines(40), errors)
    assert found > 0.4
    assert fit_serial_correlation(lines(40)[::-1], errors[::-1]) == found
    assert fit_serial_correlation(lines(40), errors * 7.0) == found
