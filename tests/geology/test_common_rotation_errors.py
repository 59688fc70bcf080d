"""What registrations do to means, fold axes and intersections: closed forms, and turns drawn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from tests.messages import by_code
from vomstudio.geology.common_axes import common_axis
from vomstudio.geology.common_rotation_errors import (
    UNKNOWN_GROUP,
    RotationErrors,
    VectorsWithDerivatives,
    concatenate_vectors,
    cone,
    differentiate_vectors,
    group_rotation_errors,
    intersect_planes,
    principal_axis,
    region,
    resultant,
)
from vomstudio.geology.folds import fold_axis
from vomstudio.geology.orientation import Line, normals_to_planes
from vomstudio.geology.populations.set_statistics import set_statistics
from vomstudio.geology.statistics import orientation_tensor
from vomstudio.geometry.rotation_errors import direction_covariance

FACTOR = float(np.sqrt(chi2.ppf(0.95, 2)))
TILTED = np.array([[4.0, 1.0, 0.5], [1.0, 2.0, -0.3], [0.5, -0.3, 9.0]]) * np.radians(1.0) ** 2


def one_model(n: int, rotation: np.ndarray = TILTED) -> RotationErrors:
    return group_rotation_errors([("r1", rotation)] * n)


def girdle(n: int, noise: float, seed: int = 2) -> np.ndarray:
    """(n, 3) poles about the great circle whose pole plunges to the north-east."""
    rng = np.random.default_rng(seed)
    t = rng.uniform(-1.0, 1.2, n)
    flat = np.stack([np.cos(t), np.sin(t), noise * rng.normal(size=n)], axis=1)
    turned = flat @ Rotation.from_euler("xz", [55.0, 30.0], degrees=True).as_matrix().T
    return np.asarray(turned / np.linalg.norm(turned, axis=1)[:, None])


def drawn(rotations: np.ndarray, group: np.ndarray, size: int, seed: int) -> np.ndarray:
    """(size, n, 3, 3) turns of each vector, one drawn for each registration."""
    rng = np.random.default_rng(seed)
    roots = np.linalg.cholesky(rotations)
    turns = np.einsum("kij,skj->ski", roots, rng.normal(size=(size, len(rotations), 3)))
    each = np.where((group >= 0)[None, :, None], turns[:, np.maximum(group, 0)], 0.0)
    return Rotation.from_rotvec(each.reshape(-1, 3)).as_matrix().reshape(size, len(group), 3, 3)


def estimate_scatter(results: np.ndarray, about: np.ndarray) -> np.ndarray:
    """(3, 3) of unit vectors (size, 3), each turned to the side of one of them."""
    signs = np.sign(results @ about)
    strays = signs[:, None] * results - about
    return np.asarray(strays.T @ strays / len(results))


# --- all of one model: the result turns with it --------------------------------------------------
@pytest.mark.parametrize("index", [0, 1, 2])
def test_axes_of_one_model_rotate_like_a_vector(index: int) -> None:
    poles = girdle(40, 0.1)
    values, axes = orientation_tensor(poles)
    found = principal_axis(differentiate_vectors(poles, one_model(40)), values, axes, index)
    expected = direction_covariance(TILTED, axes[index])[0]
    assert found.covariance()[0] == pytest.approx(expected, abs=1e-9)


def test_mean_rotates_like_a_vector_for_any_number_of_planes() -> None:
    rng = np.random.default_rng(3)
    for n in (2, 30, 3000):
        lines = np.array([0.3, 0.5, -0.8]) + 0.1 * rng.normal(size=(n, 3))
        lines /= np.linalg.norm(lines, axis=1)[:, None]
        found = resultant(differentiate_vectors(lines, one_model(n)))
        expected = direction_covariance(TILTED, found.vectors)[0]
        assert found.covariance()[0] == pytest.approx(expected, abs=1e-12)


def test_intersection_of_planes_rotates_like_a_vector() -> None:
    a, b = np.array([[0.0, 0.6, 0.8]]), np.array([[0.96, 0.0, 0.28]])
    found = intersect_planes(
        differentiate_vectors(a, one_model(1)), differentiate_vectors(b, one_model(1))
    )
    expected = direction_covariance(TILTED, found.vectors)[0]
    assert found.covariance()[0] == pytest.approx(expected, abs=1e-12)
    assert found.vectors[0] @ a[0] == pytest.approx(0.0, abs=1e-12)


# --- several models -------------------------------------------------------------------------------
def test_two_models_with_equal_shares_halve_variance_of_mean() -> None:
    """Of parallel planes: the mean of two independent turns."""
    turns = RotationErrors(np.array([0, 0, 1, 1]), np.array([TILTED, TILTED]))
    pole = np.array([0.0, 0.6, -0.8])
    found = resultant(differentiate_vectors(np.tile(pole, (4, 1)), turns))
    assert found.covariance()[0] == pytest.approx(direction_covariance(TILTED, pole)[0] / 2)


def test_compass_readings_reduce_rotation_error_of_mean() -> None:
    turns = RotationErrors(np.array([0, UNKNOWN_GROUP, UNKNOWN_GROUP, UNKNOWN_GROUP]), TILTED[None])
    pole = np.array([0.0, 0.6, -0.8])
    found = resultant(differentiate_vectors(np.tile(pole, (4, 1)), turns))
    assert found.covariance()[0] == pytest.approx(direction_covariance(TILTED, pole)[0] / 16)


@pytest.mark.full
def test_axis_error_from_two_models_matches_simulation() -> None:
    """3,000 pairs of turns drawn, against the first order."""
    poles = girdle(24, 0.05)
    group = np.array([0] * 10 + [1] * 12 + [UNKNOWN_GROUP] * 2)
    rotations = np.array([TILTED, 0.5 * TILTED[::-1, ::-1]])
    values, axes = orientation_tensor(poles)
    found = principal_axis(
        differentiate_vectors(poles, RotationErrors(group, rotations)), values, axes, 2
    )
    turns = drawn(rotations, group, 3000, 5)
    strayed = np.array([orientation_tensor(np.einsum("nij,nj->ni", t, poles))[1][2] for t in turns])
    expected = estimate_scatter(strayed, axes[2])
    told = found.covariance()[0]
    assert np.trace(told) == pytest.approx(np.trace(expected), rel=0.08)
    assert told == pytest.approx(expected, abs=0.06 * np.trace(expected))


def test_intersection_error_from_two_models_matches_simulation() -> None:
    a, b = np.array([0.0, 0.6, 0.8]), np.array([0.8, 0.36, 0.48])
    rotations = np.array([TILTED, 0.5 * TILTED[::-1, ::-1]])
    both = RotationErrors(np.array([0, 1]), rotations)
    parts = [differentiate_vectors(v[None], both.of([i])) for i, v in enumerate((a, b))]
    found = intersect_planes(*parts)
    turns = drawn(rotations, both.group, 6000, 6)
    lines = np.cross(turns[:, 0] @ a, turns[:, 1] @ b)
    lines /= np.linalg.norm(lines, axis=1)[:, None]
    expected = estimate_scatter(lines, found.vectors[0])
    assert found.covariance()[0] == pytest.approx(expected, abs=0.07 * np.trace(expected))


# --- regions --------------------------------------------------------------------------------------
def test_circular_regions_add_in_quadrature() -> None:
    up = np.array([0.0, 0.0, 1.0])
    found = region(up, np.radians(2.0) ** 2 * np.eye(3), cone(up, 3.0))
    assert found.largest_deg == pytest.approx(np.hypot(3.0, 2.0 * FACTOR))
    assert found.smallest_deg == pytest.approx(np.hypot(3.0, 2.0 * FACTOR))


def test_two_crossed_ellipses_keep_their_own_axes() -> None:
    line = np.array([0.0, 0.6, -0.8])
    # Turned about east, it strays across east.
    rotation = np.diag([np.radians(1.0) ** 2, 0.0, 0.0])
    covariance = direction_covariance(rotation, line)[0]
    found = region(line, covariance, (5.0, 1.0, [1.0, 0.0, 0.0]))
    assert found.largest_deg == pytest.approx(5.0)
    assert np.abs(found.axis) == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert found.smallest_deg == pytest.approx(np.hypot(1.0, FACTOR))


def test_missing_covariance_changes_nothing() -> None:
    line = np.array([0.0, 0.6, -0.8])
    found = region(line, None, (5.0, 1.0, np.array([1.0, 0.0, 0.0])))
    assert (found.largest_deg, found.smallest_deg) == pytest.approx((5.0, 1.0))


def test_an_error_never_exceeds_a_right_angle() -> None:
    assert region([0.0, 0.0, 1.0], 100.0 * np.eye(3)).largest_deg == 90.0


# --- what is published ----------------------------------------------------------------------------
def test_a_mean_states_both_errors_and_both_together() -> None:
    rng = np.random.default_rng(7)
    poles = np.array([0.1, 0.2, -0.9]) + 0.05 * rng.normal(size=(50, 3))
    rotation = np.radians(1.5) ** 2 * np.eye(3)
    found = set_statistics(poles, rotation_errors=one_model(50, rotation)).fisher
    assert found is not None
    assert found.alpha95_deg is not None
    assert found.registration_error_deg == pytest.approx(1.5 * FACTOR)
    assert found.total95_deg == pytest.approx(np.hypot(found.alpha95_deg, 1.5 * FACTOR))
    bare = set_statistics(poles).fisher
    assert bare is not None
    assert (bare.registration_error_deg, bare.total95_deg) == (
        None,
        pytest.approx(bare.alpha95_deg),
    )


def test_fold_axis_states_both_errors_and_their_total() -> None:
    poles = girdle(60, 0.1)
    azimuth, dip, _ = normals_to_planes(poles)
    found = fold_axis(azimuth, dip, one_model(60, np.radians(3.0) ** 2 * np.eye(3)))
    assert found.registration_error_deg == pytest.approx(3.0 * FACTOR)
    assert found.total is not None
    assert found.max_confidence95_deg is not None
    assert found.min_confidence95_deg is not None
    for total, own in (
        (found.total.largest_deg, found.max_confidence95_deg),
        (found.total.smallest_deg, found.min_confidence95_deg),
    ):
        assert total == pytest.approx(np.hypot(own, 3.0 * FACTOR))
    registration = by_code(found.reasons)["fold.registration"]
    assert registration["error_deg"] == found.registration_error_deg
    assert registration["major_deg"] == found.total.largest_deg
    bare = fold_axis(azimuth, dip)
    assert bare.registration_error_deg is None
    assert bare.error95_deg == pytest.approx(bare.max_confidence95_deg)
    assert bare.beta == found.beta


@pytest.mark.full
def test_stated_region_of_fold_axis_contains_true_axis() -> None:
    """Folds of 15 beds that scatter by 3 degrees, on models turned by 2 degrees about up and 1
    about the others: the region with the registration holds the axis in about 95 %, that without
    it far less often."""
    rotation = np.diag([1.0, 1.0, 4.0]) * np.radians(1.0) ** 2
    true = orientation_tensor(girdle(100, 0.0))[1][2]
    turns = drawn(rotation[None], np.zeros(1, int), 600, 8)[:, 0]
    held, narrow = 0, 0
    for i, turn in enumerate(turns):
        poles = girdle(15, np.radians(3.0), 100 + i) @ turn.T
        azimuth, dip, _ = normals_to_planes(poles)
        found = fold_axis(azimuth, dip, one_model(15, rotation))
        assert found.total is not None
        assert found.confidence_axis is not None
        assert found.max_confidence95_deg is not None
        assert found.min_confidence95_deg is not None
        total = (found.total.largest_deg, found.total.smallest_deg, found.total.axis)
        own = (
            found.max_confidence95_deg,
            found.min_confidence95_deg,
            found.confidence_axis.vector(),
        )
        held += within(found.beta, true, *total)
        narrow += within(found.beta, true, *own)
    assert 0.92 < held / len(turns) < 0.985
    assert narrow / len(turns) < 0.85


def within(
    line: Line, true: np.ndarray, largest: float, smallest: float, toward: np.ndarray
) -> bool:
    v = line.vector()
    off = np.sign(true @ v) * true - v
    other = np.cross(v, toward)
    x, y = np.degrees([off @ toward, off @ other])
    return bool((x / largest) ** 2 + (y / smallest) ** 2 <= 1.0)


def test_sets_of_one_model_share_its_rotation() -> None:
    """The common axis of three sets turns with the model, as beta does."""
    poles = girdle(30, 0.02)
    order = np.argsort(poles[:, 0])
    sets, turns = {}, {}
    for name, rows in zip("ABC", np.array_split(order, 3), strict=True):
        azimuth, dip, _ = normals_to_planes(poles[rows])
        sets[name], turns[name] = (azimuth, dip), one_model(len(rows))
    found = common_axis(sets, turns)
    expected = region(found.beta.vector(), direction_covariance(TILTED, found.beta.vector())[0])
    assert found.registration_error_deg == pytest.approx(expected.largest_deg, rel=1e-6)


def test_registrations_are_distinguished_by_key() -> None:
    turns = group_rotation_errors([("a", TILTED), (None, None), ("b", TILTED), ("a", TILTED)])
    assert turns.group.tolist() == [0, UNKNOWN_GROUP, 1, 0]
    assert turns.has_known_errors
    assert not group_rotation_errors([(None, None)]).has_known_errors
    assert turns.of([1]).group.tolist() == [UNKNOWN_GROUP]


def test_vectors_with_derivatives_can_be_concatenated() -> None:
    parts = [differentiate_vectors(np.eye(3)[i : i + 1], one_model(1)) for i in range(2)]
    both = concatenate_vectors(parts)
    assert isinstance(both, VectorsWithDerivatives)
    assert both.covariance() == pytest.approx(direction_covariance(TILTED, np.eye(3)[:2]))
