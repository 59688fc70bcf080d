"""By how much a face bends as a whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.messages import with_code
from vomstudio.geology.quality import Verdict, judge, total_error_deg
from vomstudio.geometry.heights.bends import measure_bend
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.patches import moments

Floats = np.ndarray


def face(heights: Floats, size: float = 2.0) -> Floats:
    """(n, 3) square grid of this size with heights (k, k)."""
    x, y = np.meshgrid(*2 * [np.linspace(-size / 2, size / 2, len(heights))])
    return np.column_stack([x.ravel(), y.ravel(), heights.ravel()])


def grid(k: int = 40) -> tuple[Floats, Floats]:
    x, y = np.meshgrid(*2 * [np.linspace(-1.0, 1.0, k)])
    return x, y


@pytest.mark.parametrize("radius", [5.0, 20.0])
@pytest.mark.parametrize("turned", [False, True])
def test_a_cylinder_bends_by_the_angle_of_its_arc(radius: float, turned: bool) -> None:
    x, _ = grid()
    points = face(np.sqrt(radius**2 - x**2) - radius)
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0] if turned else np.eye(3)
    noise = np.random.default_rng(1).normal(0.0, 1e-3, points.shape)
    found = measure_bend(3.0 * (points + noise) @ turn.T + 4e5, turn[:, 2])
    # An even strip is the square root of 12 standard deviations wide, a disc 4 of them.
    arc = np.degrees(2.0 * np.arcsin(1.0 / radius)) * 4.0 / np.sqrt(12.0)
    assert found == pytest.approx(arc, rel=0.04)


def test_noise_and_waves_shorter_than_the_face_are_not_bends() -> None:
    rng = np.random.default_rng(3)
    told = [
        measure_bend(face(rng.normal(0.0, 0.01, (30, 30))), (0.0, 0.0, 1.0)) for _ in range(200)
    ]
    assert sum(one is not None for one in told) <= 2
    x, _ = grid()
    waves = face(0.02 * np.sin(8.0 * np.pi * x) + rng.normal(0.0, 1e-3, x.shape))
    assert measure_bend(waves, (0.0, 0.0, 1.0)) is None


def test_few_points_and_planes_have_no_bend() -> None:
    x, _ = grid(6)
    assert measure_bend(face(x * x), (0.0, 0.0, 1.0)) is None
    assert measure_bend(np.zeros((100, 3)), (0.0, 0.0, 1.0)) is None
    x, _ = grid()
    assert measure_bend(face(0.0 * x), (0.0, 0.0, 1.0)) is None
    assert measure_bend(np.zeros((0, 3)), (0.0, 0.0, 1.0)) is None


def test_bent_face_gets_a_note_and_keeps_its_verdict() -> None:
    x, _ = grid()
    points = face(x * x / 20.0 + np.random.default_rng(1).normal(0.0, 1e-3, x.shape))
    known = moments(points)
    fit = fit_moments(known.n, known.mean, known.scatter, known.n_effective)
    bend = measure_bend(points, fit.normal)
    assert bend is not None

    def judged(bend_deg: float | None) -> Verdict:
        return judge(fit, resolution_m=0.01, outcrop_normal=None, kind="patch", bend_deg=bend_deg)

    plain, bent = judged(None), judged(bend)
    assert judged(0.01) == plain
    (note,) = with_code(bent.notes, "plane.local")
    assert bent == replace(plain, notes=(*plain.notes, note))
    error_deg = total_error_deg(fit, 0.01, "patch")
    assert error_deg is not None
    assert note.values == {
        "bend_deg": bend,
        "regional_deg": pytest.approx(np.hypot(error_deg, bend)),
    }
