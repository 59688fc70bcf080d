"""What a patch keeps of its points, and how sure its plane is."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.patches import face_points, has_id, ids_of, moments, runs_of

ACROSS, ALONG = 36, 30


def roughness(rng: np.random.Generator, length: float) -> np.ndarray:
    """Heights on a grid of unit size whose correlation falls to 1/e within `length` (0: white)."""
    rows, columns = ALONG, ACROSS
    if length == 0.0:
        return rng.standard_normal((rows, columns))
    big = (4 * rows, 4 * columns)
    spectrum = np.fft.rfft2(rng.standard_normal(big))
    # A Gaussian filter of width s correlates over 2 s: exp(-d^2 / (4 s^2)).
    s = length / 2.0
    fy = np.fft.fftfreq(big[0], 1.0 / ALONG)[:, None]
    fx = np.fft.rfftfreq(big[1], 1.0 / ALONG)[None]
    spectrum *= np.exp(-2.0 * (np.pi * s) ** 2 * (fx**2 + fy**2))
    field = np.fft.irfft2(spectrum, big)[:rows, :columns]
    return field / field.std()


def coverage(length: float, repeats: int, seed: int) -> float:
    """How often the 95 % region holds the true plane z = 0."""
    rng = np.random.default_rng(seed)
    u, v = np.meshgrid(np.arange(ACROSS) / ALONG, np.arange(ALONG) / ALONG)
    held = 0
    for _ in range(repeats):
        z = 0.02 * roughness(rng, length)
        known = moments(np.column_stack([u.ravel(), v.ravel(), z.ravel()]))
        fit = fit_moments(known.n, known.mean, known.scatter, known.n_effective)
        # The tilt of the true normal along the two axes, in units of the half-angles.
        rise = np.array([0.0, 0.0, 1.0]) @ fit.axes.T
        tilt = np.degrees(np.arctan2(rise[:2], rise[2]))
        semi = np.array([fit.min_confidence95_deg, fit.max_confidence95_deg])
        held += bool(((tilt / semi) ** 2).sum() <= 1.0)
    return held / repeats


@pytest.mark.parametrize("length", [0.0, 0.05, 0.1])
def test_the_confidence_of_a_patch_holds_the_true_plane(length):
    """Roughness up to a tenth of the patch."""
    assert coverage(length, 300, seed=7) >= 0.92


@pytest.mark.slow
@pytest.mark.parametrize("length", [0.0, 0.03, 0.05, 0.08, 0.1])
def test_the_confidence_of_a_patch_holds_the_true_plane_in_many_trials(length):
    assert 0.93 <= coverage(length, 3000, seed=8) <= 0.995


def test_a_point_that_stands_twice_counts_once():
    rng = np.random.default_rng(0)
    points = rng.standard_normal((200, 3)) * [1.0, 0.6, 0.01]
    once, twice = moments(points), moments(np.repeat(points, 2, axis=0))
    assert once.n == twice.n == 200
    np.testing.assert_allclose(once.mean, twice.mean)
    np.testing.assert_allclose(once.scatter, twice.scatter)


def test_a_finer_meshed_corner_does_not_draw_the_plane_to_itself():
    """A tent of two equal slopes: its plane is level, however finely one slope is cut."""

    def slope(n: int, sign: float, first: int) -> tuple[np.ndarray, np.ndarray]:
        x, y = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n))
        i = first + np.arange(n * n).reshape(n, n)
        a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
        points = np.column_stack([sign * x.ravel(), y.ravel(), -0.3 * x.ravel()])
        return points, np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])

    left, right = slope(41, -1.0, 0), slope(9, 1.0, 41 * 41)
    mesh = Mesh(
        np.concatenate([left[0], right[0]]), np.concatenate([left[1], right[1]]).astype(np.int32)
    )
    known = moments(*face_points(mesh, np.arange(len(mesh.faces))))
    fit = fit_moments(known.n, known.mean, known.scatter, known.n_effective)
    plain = moments(mesh.vertices)
    assert fit.dip_deg < 1.0 < fit_moments(plain.n, plain.mean, plain.scatter).dip_deg


def test_runs_are_another_way_to_write_ids():
    rng = np.random.default_rng(3)
    ids = np.unique(rng.integers(0, 5000, 900))
    runs = runs_of(rng.permutation(np.repeat(ids, 2)))
    assert ids_of(runs).tolist() == ids.tolist()
    for id_ in range(-1, 5001, 7):
        assert has_id(runs, id_) == (id_ in ids)
    assert runs_of([]) == ()
    assert not has_id((), 0)
