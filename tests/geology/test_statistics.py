"""Sets of orientations against published figures, closed forms, scipy and mplstereonet."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.geology.samples import fisher_sample
from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import (
    Line,
    angle_between_lines,
    lines_to_vectors,
    planes_to_poles,
)
from vomstudio.geology.populations.set_statistics import set_statistics
from vomstudio.geology.statistics import (
    axial_mean,
    fisher,
    no_fisher_reason,
    orientation_tensor,
    vollmer,
    woodcock,
)

# Nine directions of a tight group, as trend and plunge.
DIRECTIONS = lines_to_vectors(
    [144, 137, 140, 132, 151, 148, 139, 143, 146], [57, 58, 52, 60, 49, 55, 54, 62, 51]
)


# The tensor and its shape


def test_big_elk_has_its_published_tensor(big_elk: tuple[np.ndarray, np.ndarray]) -> None:
    values, _ = orientation_tensor(planes_to_poles(*big_elk))
    np.testing.assert_allclose(values, [0.5901, 0.3525, 0.0573], atol=6e-5)
    assert woodcock(values) == (pytest.approx(0.2837, abs=6e-5), pytest.approx(2.3312, abs=6e-5))
    assert vollmer(values) == tuple(pytest.approx(v, abs=6e-5) for v in (0.2376, 0.5904, 0.1720))


def test_orientation_tensor_matches_its_definition() -> None:
    rng = np.random.default_rng(1)
    v = rng.normal(size=(50, 3))
    v /= np.linalg.norm(v, axis=1)[:, None]
    values, axes = orientation_tensor(v)
    np.testing.assert_allclose(axes.T @ np.diag(values) @ axes, v.T @ v / 50, atol=1e-14)
    assert values.sum() == pytest.approx(1, abs=1e-14)
    assert (axes[:, 2] <= 0).all()


def test_eigenvectors_match_mplstereonet_after_eigenvalue_correction(
    mplstereonet: Any, big_elk: tuple[np.ndarray, np.ndarray]
) -> None:
    dip_direction, dip = big_elk
    plunges, trends, theirs = mplstereonet.eigenvectors(
        dip_direction - 90.0, dip.copy(), measurement="poles"
    )
    ours, axes = orientation_tensor(planes_to_poles(dip_direction, dip))
    n = len(dip)
    assert sum(theirs) == pytest.approx(2 * n / (2 * n - 1))  # the trap
    np.testing.assert_allclose(np.array(theirs) * (2 * n - 1) / (2 * n), ours, atol=1e-12)
    for axis, trend, plunge in zip(axes, trends, plunges, strict=True):
        assert angle_between_lines(Line.from_vector(axis), Line(trend, plunge)) < 1e-6


@given(
    st.lists(st.tuples(st.floats(0, 360), st.floats(0, 90)), min_size=1, max_size=20),
    st.lists(st.booleans(), min_size=20, max_size=20),
)
def test_orientation_tensor_ignores_vector_signs(
    orientations: list[tuple[float, float]], flips: list[bool]
) -> None:
    v = lines_to_vectors(*np.array(orientations).T)
    signs = np.where(np.array(flips[: len(v)]), -1.0, 1.0)[:, None]
    np.testing.assert_allclose(
        orientation_tensor(v)[0], orientation_tensor(signs * v)[0], atol=1e-13
    )


def test_fabric_shapes_of_three_end_members() -> None:
    cluster, girdle, uniform = [1, 0, 0], [0.5, 0.5, 0], [1 / 3, 1 / 3, 1 / 3]
    assert vollmer(cluster) == (1, 0, 0)
    assert vollmer(girdle) == (0, 1, 0)
    assert vollmer(uniform) == pytest.approx((0, 0, 1))
    assert woodcock(cluster) == (None, None)
    assert woodcock(girdle) == (0.0, None)
    assert woodcock(uniform) == (None, pytest.approx(0))
    # S2 = S3: a round cluster has no K; S1 = S2: a perfect girdle has K = 0.
    assert woodcock([0.8, 0.1, 0.1])[0] is None
    assert woodcock([0.45, 0.45, 0.1])[0] == pytest.approx(0)
    # Woodcock (1977), fig. 1: K = 1 parts clusters from girdles: S1/S2 = S2/S3.
    assert woodcock([4 / 7, 2 / 7, 1 / 7]) == (pytest.approx(1), pytest.approx(math.log(4)))


def test_mean_of_opposite_dipping_planes_is_between_them() -> None:
    # Two nearly vertical planes that dip to opposite sides: vectors would average to nonsense.
    mean = axial_mean(planes_to_poles([90, 270], [88, 88])).normal_plane()
    assert mean.dip_deg == pytest.approx(90)
    assert mean.strike_rhr_deg % 180 == pytest.approx(0, abs=1e-9)


def test_uniform_girdle_has_no_mean() -> None:
    with refused("orientation.no-mean", GeometryError):
        axial_mean(lines_to_vectors([0, 60, 120], [0, 0, 0]))


# Fisher


def test_directed_fisher_statistics_match_closed_forms() -> None:
    result = fisher(DIRECTIONS, is_directed=True)
    n = len(DIRECTIONS)
    total = DIRECTIONS.sum(axis=0)
    r = math.sqrt(float(total @ total))
    assert pytest.approx(r) == result.R
    assert result.kappa == pytest.approx((n - 1) / (n - r))
    cone = math.degrees(math.acos(1 - (n - r) / r * (20 ** (1 / (n - 1)) - 1)))
    assert result.alpha95_deg == pytest.approx(cone)
    assert result.mean.trend_deg == pytest.approx(math.degrees(math.atan2(total[0], total[1])))
    # The usual approximation for large n, 140 / sqrt(kappa n), comes near even with nine.
    assert result.alpha95_deg == pytest.approx(140 / math.sqrt(result.kappa * n), rel=0.15)


def test_fisher_agrees_with_mplstereonet(mplstereonet: Any) -> None:
    rng = np.random.default_rng(2)
    trend, plunge = rng.normal(120, 8, 30), rng.normal(50, 6, 30)
    vector, (r_mean, angle, kappa) = mplstereonet.stereonet_math.fisher_stats(
        *mplstereonet.line(plunge.copy(), trend.copy()), conf=95
    )
    ours = fisher(lines_to_vectors(trend, plunge), is_directed=True)
    assert pytest.approx(r_mean) == ours.R / 30
    assert ours.kappa == pytest.approx(kappa)
    assert ours.alpha95_deg == pytest.approx(angle)
    theirs = mplstereonet.stereonet_math.geographic2plunge_bearing(*np.atleast_2d(vector).T)
    assert angle_between_lines(ours.mean, Line(float(theirs[1][0]), float(theirs[0][0]))) < 1e-6


def test_axial_data_are_flipped_before_they_are_averaged() -> None:
    rng = np.random.default_rng(3)
    v = fisher_sample(rng, 40, 60, lines_to_vectors(77, 1))
    mixed = np.where(rng.random(40)[:, None] < 0.5, -v, v)
    a, b = fisher(mixed, is_directed=False), fisher(v, is_directed=True)
    assert pytest.approx(b.R) == a.R
    assert angle_between_lines(a.mean, b.mean) < 1e-9


def test_directed_means_may_point_up() -> None:
    stats = set_statistics(
        lines_to_vectors([10, 12, 8], [-20, -22, -21]), "lines", is_directed=True
    ).to_dict()
    found = stats["fisher"]
    assert isinstance(found, dict)
    assert found["plunge_deg"] == pytest.approx(-21, abs=0.2)
    assert stats["axial"] is False


def test_alpha95_contains_true_mean_in_95_percent_of_runs() -> None:
    rng = np.random.default_rng(11)
    truth = np.array([0, 0, 1.0])
    runs, held = 2000, 0
    for _ in range(runs):
        f = fisher(fisher_sample(rng, 8, 30), is_directed=True)
        assert f.alpha95_deg is not None
        angle = math.degrees(math.acos(min(1.0, float(f.mean.vector() @ truth))))
        held += angle <= f.alpha95_deg
    # 95 % within four standard deviations of the binomial
    assert abs(held - 0.95 * runs) < 4 * math.sqrt(runs * 0.95 * 0.05)


def test_identical_directions_have_infinite_kappa_and_zero_alpha95() -> None:
    stats = set_statistics(planes_to_poles([132] * 4, [41] * 4)).to_dict()
    assert stats["fisher"]["kappa"] is None  # type: ignore[index]
    assert stats["fisher"]["alpha95_deg"] == pytest.approx(0, abs=1e-6)  # type: ignore[index]
    assert stats["fisher_reason"] == Finding("fisher.identical").to_dict()
    assert stats["woodcock"] == {"K": None, "C": None}


# Where Fisher does not speak


def test_girdle_gets_reason_instead_of_fisher_mean(
    big_elk: tuple[np.ndarray, np.ndarray],
) -> None:
    stats = set_statistics(planes_to_poles(*big_elk)).to_dict()
    assert stats["fisher"] is None
    reason = stats["fisher_reason"]
    assert isinstance(reason, dict)
    assert reason["code"] == "fisher.girdle"
    assert reason["girdle"] > reason["point"]


def test_uniform_scatter_gets_reason_instead_of_fisher_mean() -> None:
    v = np.random.default_rng(5).normal(size=(50, 3))
    reason = no_fisher_reason(v, is_directed=False)
    assert reason is not None
    assert reason.code == "fisher.uniform"
    assert reason.values["random"] > reason.values["point"]


def test_single_plane_gets_reason_instead_of_fisher_mean() -> None:
    stats = set_statistics(planes_to_poles([132], [41])).to_dict()
    assert stats["fisher"] is None
    assert stats["fisher_reason"] == Finding("fisher.single").to_dict()


def test_two_planes_close_together_have_a_fisher_mean_between_them() -> None:
    # Poles 90/10 and 270/10 are 20 degrees apart as axes: R = 2 cos 10, kappa = 1 / (2 - R).
    found = set_statistics(planes_to_poles([270, 90], [80, 80])).to_dict()["fisher"]
    assert isinstance(found, dict)
    assert found["R"] == pytest.approx(2 * math.cos(math.radians(10)))
    assert found["kappa"] == pytest.approx(1 / (2 - found["R"]))
    assert found["plunge_deg"] == pytest.approx(0.0, abs=1e-9)


def test_directions_that_cancel_out_get_no_fisher_mean() -> None:
    v = lines_to_vectors([0, 120, 240], [0, 0, 0])
    assert no_fisher_reason(v, is_directed=True) == Finding("fisher.no-mean")


def test_a_tight_cluster_of_elongated_shape_is_still_a_cluster() -> None:
    # Three beds within a few degrees: Woodcock's K is under 1, yet nobody would call it a girdle.
    v = planes_to_poles([130, 130.1, 130, 130.2], [35, 41, 47, 53])
    assert woodcock(orientation_tensor(v)[0])[0] < 1.0  # type: ignore[operator]
    assert no_fisher_reason(v, is_directed=False) is None


def test_clusters_get_their_fisher_mean() -> None:
    rng = np.random.default_rng(6)
    sound = sum(
        no_fisher_reason(fisher_sample(rng, 20, kappa), is_directed=False) is None
        for kappa in (10, 30, 100, 300)
        for _ in range(50)
    )
    assert sound > 190


# The promised object


@settings(max_examples=60)
@given(
    st.lists(st.tuples(st.floats(0, 360), st.floats(0, 90)), min_size=1, max_size=12),
    st.booleans(),
)
def test_statistics_always_serialize_to_valid_json(
    orientations: list[tuple[float, float]], directed: bool
) -> None:
    stats = set_statistics(lines_to_vectors(*np.array(orientations).T), "lines", directed).to_dict()
    json.dumps(stats, allow_nan=False)
    assert stats["n"] == len(orientations)
    assert (stats["fisher"] is None) <= (stats["fisher_reason"] is not None)


@pytest.mark.parametrize("vectors", [np.zeros((0, 3)), np.zeros((2, 3)), [[np.nan, 0, 1]]])
def test_empty_input_and_null_directions_are_rejected(vectors: np.ndarray) -> None:
    with pytest.raises(GeometryError):
        set_statistics(vectors)


def test_rotation_about_vertical_rotates_the_mean() -> None:
    v = planes_to_poles([130, 135, 128, 140], [40, 44, 39, 42])
    before = axial_mean(v)
    after = axial_mean(planes_to_poles([190, 195, 188, 200], [40, 44, 39, 42]))
    assert (after.trend_deg - before.trend_deg) % 360 == pytest.approx(60)
    assert after.plunge_deg == pytest.approx(before.plunge_deg)
