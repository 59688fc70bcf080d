"""What is asked wrongly is refused by name, and never answered with something else."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.geology import stereonet as nets
from vomstudio.geology.common_axes import common_axis
from vomstudio.geology.density import density
from vomstudio.geology.folds import fold_axis
from vomstudio.geology.intersections import (
    UncertainPlane,
    deviation95,
    intersection_line,
    mean_plane,
    scatter_deg,
    uncertain_plane,
)
from vomstudio.geology.notation import format_plane, parse_plane
from vomstudio.geology.orientation import (
    Line,
    Plane,
    compute_rake,
    intersection,
    planes_to_normals,
    planes_to_poles,
)
from vomstudio.geology.populations.set_statistics import set_statistics
from vomstudio.geology.statistics import (
    axial_mean,
    fisher,
    no_fisher_reason,
    unit_vectors,
)

ONE = ([90.0], [40.0])
ELLIPSE = "net.ellipse-direction"


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: format_plane(Plane(10, 20), "dip/dipdir"), "unknown notation 'dip/dipdir'"),
        (lambda: parse_plane("132/41", "dip/dipdir"), "unknown notation 'dip/dipdir'"),
        (lambda: set_statistics([[0, 0, 1]], of="beds"), "beds"),
        (lambda: nets.project([[0, 0, 1]], "Area"), "unknown projection 'Area'"),
        (lambda: nets.unproject([[0, 0]], "wulff"), "unknown projection 'wulff'"),
        (lambda: density([[0, 0, 1]], [[0, 0, 1]], "heat"), "unknown method 'heat'"),
    ],
)
def test_invalid_choice_error_names_the_value(ask: Callable[[], object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ask()


@pytest.mark.parametrize(
    ("ask", "code", "values"),
    [
        (lambda: fold_axis([10.0], [20.0]), "fold.one-plane", {"n": 1}),
        (lambda: fold_axis([], []), "fold.one-plane", {"n": 0}),
        (lambda: fold_axis([10.0] * 5, [20.0] * 5), "fold.parallel-planes", {"n": 5}),
        (lambda: common_axis({"a": ONE}), "fold.too-few-sets", {}),
        (lambda: common_axis({"a": ONE, "b": ([], [])}), "sets.empty", {"set": "b"}),
        (lambda: common_axis({"a": ONE, "b": ONE}), "fold.parallel-means", {"sets": ("a", "b")}),
        (lambda: mean_plane([]), "sets.no-members", {}),
        (lambda: intersection(Plane(40, 30), Plane(40, 30)), "planes.parallel", {}),
        (lambda: compute_rake(Plane(40, 30).pole(), Plane(40, 30)), "line.across-plane", {}),
        (lambda: unit_vectors(np.zeros((0, 3))), "sets.no-orientations", {}),
        (lambda: unit_vectors(np.zeros((2, 2))), "sets.no-orientations", {}),
        (
            lambda: unit_vectors([[0, 0, 1], [0, 0, 0]]),
            "orientation.not-a-direction",
            {"number": 2, "n": 2},
        ),
        (
            lambda: unit_vectors([[np.nan, 0, 1]]),
            "orientation.not-a-direction",
            {"number": 1, "n": 1},
        ),
        (lambda: axial_mean([[1, 0, 0], [0, 1, 0]]), "orientation.no-mean", {}),
        (lambda: fisher([[0, 0, 1], [0, 0, -1]], is_directed=True), "orientation.no-mean", {}),
        (lambda: nets.confidence_ellipse([0, 0, -1], [0, 0, 1], 5, 2), ELLIPSE, {}),
        (lambda: nets.confidence_ellipse([0, 0, -1], [np.nan, 0, 1], 5, 2), ELLIPSE, {}),
        (lambda: Line.from_vector([0, 0, 0]), "vector.invalid", {"name": "direction"}),
        (lambda: Line.from_vector([[0, 0, 1]]), "vector.invalid", {"name": "direction"}),
        (lambda: Plane.from_normal([0, np.inf, 1]), "vector.invalid", {"name": "normal"}),
        (lambda: Plane(10, 90.01), "angle.out-of-range", {"value": 90.01, "field": "dip"}),
        (lambda: Plane(10, -0.01), "angle.out-of-range", {"value": -0.01, "field": "dip"}),
        (lambda: Line(10, 90.01), "angle.out-of-range", {"value": 90.01, "field": "plunge"}),
        (lambda: Line(10, -90.01), "angle.out-of-range", {"value": -90.01, "field": "plunge"}),
        (lambda: Line(math.nan, 10), "number.not-an-angle", {"field": "trend"}),
        (lambda: Plane(10, math.inf), "number.not-an-angle", {"field": "dip"}),
        (lambda: Plane.from_strike(math.nan, 10), "number.not-an-angle", {"field": "strike"}),
    ],
)
def test_undefined_results_raise_with_reason(
    ask: Callable[[], object], code: str, values: dict[str, object]
) -> None:
    with refused(code, GeometryError, **values):
        ask()


def test_limits_of_valid_ranges_are_accepted() -> None:
    assert Plane(10, 90).vertical
    assert Plane(10, 0).undefined
    assert Line(10, -90).undefined
    assert intersection(Plane(40, 30), Plane(40, 30.0001)).plunge_deg >= 0.0
    assert no_fisher_reason([[0, 0, 1.0]], is_directed=True) is not None


@pytest.mark.parametrize(("apart", "meet"), [(0.0099, False), (0.0101, True)])
def test_planes_intersect_if_at_least_a_hundredth_of_a_degree_apart(
    apart: float, meet: bool
) -> None:
    a, b = (UncertainPlane(Plane(40, dip).normal(), None) for dip in (30.0, 30.0 + apart))
    if meet:
        line = intersection_line(a, b)
        assert line.angle_deg == pytest.approx(apart)
        # Along the strike, which both have.
        assert min(abs(line.line.trend_deg - k) for k in (130.0, 310.0)) < 0.01
    else:
        with refused("planes.parallel", GeometryError):
            intersection_line(a, b)


def test_poles_point_down_without_negative_zeros_and_normals_up() -> None:
    azimuth, dip = np.meshgrid(np.arange(0.0, 360.0, 30.0), [0.0, 20.0, 90.0])
    up, down = planes_to_normals(azimuth, dip), planes_to_poles(azimuth, dip)
    assert np.array_equal(down, -up)
    assert (up[dip < 90.0][:, 2] > 0.0).all()
    assert not np.signbit(down[down == 0.0]).any()
    for a, d, pole in zip(azimuth.ravel(), dip.ravel(), down.reshape(-1, 3), strict=True):
        assert pole == pytest.approx(Plane(a, d).pole().vector(), abs=1e-12)


def test_a_cone_is_drawn_every_two_degrees() -> None:
    axis = Line(30, 60)
    assert len(nets.pole_ellipse(Plane(30, 40), 5, 2, 10)[0]) == 181
    assert len(nets.confidence_ellipse(axis.vector(), [0, 0, 1], 5, 2)[0]) == 181
    assert len(nets.great_circle(Plane(30, 40))) == 91
    assert nets.great_circles([10, 20], [30, 40]).shape == (2, 91, 3)


# Planes of one set


def test_plane_scatter_is_rms_angle_independent_of_normal_sign() -> None:
    angles = np.array([0.0, 3.0, 4.0, 12.0])
    turned = np.radians(angles)
    normals = np.column_stack([np.sin(turned), 0 * turned, np.cos(turned)])
    signs = np.array([1.0, -1.0, 1.0, -1.0])[:, None]
    planes = [UncertainPlane(v, None) for v in normals * signs]
    mean = UncertainPlane(np.array([0.0, 0.0, 1.0]), None)
    wanted = math.sqrt((angles**2).mean())
    assert scatter_deg(planes, mean) == pytest.approx(wanted)
    assert scatter_deg(planes, UncertainPlane(-mean.normal, None)) == pytest.approx(wanted)
    assert scatter_deg([], mean) == 0.0
    assert scatter_deg(planes[:1], mean) == pytest.approx(0.0, abs=1e-9)


def test_a_plane_that_was_not_fitted_has_no_roughness() -> None:
    """Only who fits points knows how rough they are; a separation would be called uncertain."""
    planes = [UncertainPlane(Plane(40 + k, 30).normal(), None) for k in range(5)]
    assert UncertainPlane(planes[0].normal, None).roughness == 0.0
    assert mean_plane(planes).roughness == 0.0
    assert uncertain_plane([0, 0, 1], [1, 0, 0], 3.0, 1.0).roughness == 0.0
    assert UncertainPlane(planes[0].normal, None).degrees_of_freedom == math.inf


def test_mean_plane_has_hotelling_region_and_degrees_of_freedom() -> None:
    """Of two or three planes a round one; against scipy's F."""
    from scipy.special import fdtri

    rng = np.random.default_rng(5)
    for n in (2, 3, 4, 9):
        normals = [0.0, 0.0, 1.0] + 0.05 * rng.normal(size=(n, 3)) * [1.0, 0.4, 0.0]
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        mean = mean_plane([UncertainPlane(v, None) for v in normals])
        assert mean.spread95 is not None
        off = normals - (normals @ mean.normal)[:, None] * mean.normal
        scatter = off.T @ off
        free = n - 2
        if n <= 3:
            free = 2 * (n - 1)
            scatter = np.trace(scatter) * (np.eye(3) - np.outer(mean.normal, mean.normal))
        assert mean.degrees_of_freedom == free
        wanted = 2.0 * fdtri(2.0, free, 0.95) / free * scatter / n
        assert mean.spread95 == pytest.approx(wanted, rel=1e-6, abs=1e-12)
        assert mean.normal[2] > 0.0
        turned = mean_plane([UncertainPlane(-v, None) for v in normals])
        assert turned.normal == pytest.approx(mean.normal)


@pytest.mark.parametrize("angle", [0.5, 20.0, 89.9, 89.95, 90.0])
def test_deviation_of_very_uncertain_plane_stays_finite(angle: float) -> None:
    plane = uncertain_plane([0, 0, 1], [1, 0, 0], angle, 0.2)
    limit = math.tan(math.radians(min(angle, 89.9)))
    assert deviation95(plane, [1, 0, 0]) == pytest.approx(limit)
    assert deviation95(plane, [0, 1, 0]) == pytest.approx(math.tan(math.radians(0.2)))
    assert deviation95(plane, [0, 0, 1]) == 0.0
    for unknown in ((None, 1.0), (1.0, None)):
        assert deviation95(uncertain_plane([0, 0, 1], [1, 0, 0], *unknown), [1, 0, 0]) is None
