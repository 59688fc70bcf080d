"""Scatter of marks in photos, and errors of the points that they locate."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from tests.io.photos.camera_files import ring
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.triangulation import triangulate
from vomstudio.registration.marks.mark_errors import (
    MIN_MARK_ERROR_PX,
    Marks,
    mark_error_px,
    mark_scatter_px,
    position_covariance,
    robust_position,
)
from vomstudio.registration.marks.wrong_marks import do_rays_intersect, find_consistent_marks

Array = npt.NDArray[np.float64]
VIEWS = ring()


def marked(
    noise_px: float, photos: int, *, points: int = 60, wrong: int = 0, each: int = 1
) -> list[Marks]:
    """wrong : marks of every `each`-th point that are 400 px and more off"""
    rng = np.random.default_rng(1)
    found = []
    for number, place in enumerate(rng.uniform(-1.5, 1.5, (points, 3))):
        views = [VIEWS[int(row)] for row in rng.choice(len(VIEWS), photos, replace=False)]
        pixels = np.array([view.project(place)[0] for view in views])
        pixels += rng.normal(0, noise_px, pixels.shape)
        if number % each == 0:
            pixels[:wrong] += rng.uniform(400.0, 900.0, (wrong, 2))
        found.append(Marks(views, pixels))
    return found


@pytest.mark.parametrize("noise_px", first_in_default_tier([1.0, 25.0]))
@pytest.mark.parametrize("photos", first_in_default_tier([2, 3, 8]))
def test_mark_scatter_matches_the_simulated_noise(noise_px: float, photos: int) -> None:
    assert mark_scatter_px(marked(noise_px, photos)) == pytest.approx(noise_px, rel=0.2)


@pytest.mark.full
@pytest.mark.parametrize(("photos", "wrong", "each"), [(2, 1, 3), (5, 2, 1), (8, 3, 1)])
def test_mark_scatter_is_robust_to_wrong_marks(photos: int, wrong: int, each: int) -> None:
    marks = marked(5.0, photos, points=20, wrong=wrong, each=each)
    assert 3.5 < mark_scatter_px(marks) < 10.0


def test_majority_of_marks_locates_the_point_and_the_others_are_reported() -> None:
    (marks,) = marked(1.0, 8, points=1, wrong=3)
    right = triangulate(marks.views[3:], marks.pixels[3:])
    assert robust_position(marks) == pytest.approx(right, abs=0.02)
    rows, wrong = find_consistent_marks("A", marks, 6.0)
    assert rows.tolist() == [3, 4, 5, 6, 7]
    assert [mark.photo for mark in wrong] == [view.name for view in marks.views[:3]]
    assert do_rays_intersect(Marks(marks.views[3:], marks.pixels[3:]), 6.0)


def test_mark_error_has_a_lower_limit() -> None:
    assert mark_error_px(marked(0.1, 4)) == MIN_MARK_ERROR_PX
    assert mark_error_px([]) == MIN_MARK_ERROR_PX


def test_marks_that_scatter_randomly_are_rejected() -> None:
    rng = np.random.default_rng(2)
    wild = [Marks(m.views, rng.uniform(0, 3000, m.pixels.shape)) for m in marked(1.0, 6, points=6)]
    with pytest.raises(GeometryError) as failure:
        mark_error_px(wild)
    assert failure.value.code == "control.marks-scattered"


def test_position_errors_of_two_perpendicular_cameras_match_the_formula() -> None:
    """At the distance d with the focal length f a pixel is d / f; both photos see the height."""
    lens = Intrinsics.pinhole(4000, 3000, 2000.0, 2000.0, 1500.0)
    looks_north = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    looks_east = np.array([[0, -1.0, 0], [0, 0, -1.0], [1.0, 0, 0]])
    views = [
        View("a", lens, looks_north, -looks_north @ [0.0, -10.0, 0.0]),
        View("b", lens, looks_east, -looks_east @ [-10.0, 0.0, 0.0]),
    ]
    marks = Marks(views, np.array([view.project(np.zeros(3))[0] for view in views]))
    pixel = 3.0 * 10.0 / 2000.0
    expected = np.diag([pixel**2, pixel**2, pixel**2 / 2.0])
    np.testing.assert_allclose(
        position_covariance(marks, np.zeros(3), 3.0), expected, rtol=1e-4, atol=1e-9
    )
