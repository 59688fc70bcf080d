"""Limbs of folds of known shape: the right angle between them, or none with the reason."""

from __future__ import annotations

import numpy as np
import pytest

from tests.geology import folded
from tests.geology.folded import planes
from vomstudio.geology.folds import FoldAxis, fold_axis


def fold_of(rng: folded.Rng, dips: np.ndarray, noise: float = 2.0) -> FoldAxis:
    """Beds with these dips about an axis in any direction, positive toward one side."""
    _, up, across = folded.axis_frame(rng)
    t = np.radians(dips)[:, None]
    return fold_axis(*planes(folded.strayed(rng, np.cos(t) * up + np.sin(t) * across, noise)))


@pytest.mark.parametrize("hinge", [4, 8, 15])
@pytest.mark.parametrize("half", [70.0, 75.0, 80.0, 84.0, 88.0])
def test_a_tight_fold_with_its_hinge_has_no_wrong_angle(half: float, hinge: int) -> None:
    """The poles of both limbs fall together, as those of one limb at right angles to the hinge."""
    rng = np.random.default_rng(int(half) + hinge)
    for _ in range(4):
        limbs = np.repeat([-half, half], 15)
        found = fold_of(rng, np.concatenate([limbs, rng.uniform(-10, 10, hinge)]))
        if found.limbs is not None:
            assert found.limbs.interlimb_angle_deg == pytest.approx(180 - 2 * half, abs=8)
        elif half >= 80:
            assert any("no interlimb angle" in reason for reason in found.reasons)


@pytest.mark.parametrize("half", [30.0, 45.0, 60.0])
def test_two_limbs_keep_their_angle(half: float) -> None:
    """About an axis that is flat, upright or tilted a little: the angle on the side of the hinge is
    that of the upward normals."""
    rng = np.random.default_rng(int(half))
    told = 0
    for _ in range(12):
        dips = np.radians(np.repeat([-half, half], (16, 24)) + rng.normal(0, 2, 40))
        off = np.radians(rng.normal(0, 2, 40))
        normals = np.stack([np.sin(dips), np.sin(off), np.cos(dips) * np.cos(off)], axis=1)
        found = fold_axis(*planes(normals / np.linalg.norm(normals, axis=1)[:, None]))
        if found.limbs is not None:
            told += 1
            assert found.limbs.interlimb_angle_deg == pytest.approx(180 - 2 * half, abs=3)
            assert found.limbs.axial_plane.dip_deg == pytest.approx(90.0, abs=2)
    assert told >= 11


def test_an_arc_beside_a_limb_is_no_second_limb() -> None:
    rng = np.random.default_rng(7)
    for _ in range(5):
        found = fold_of(rng, np.concatenate([np.full(30, -50.0), rng.uniform(-50, 60, 10)]))
        assert found.limbs is None


@pytest.mark.parametrize("n", [9, 19, 39])
@pytest.mark.parametrize("apart", [40.0, 60.0, 120.0])
def test_a_limb_of_one_plane_proves_no_shape_and_is_named(n: int, apart: float) -> None:
    rng = np.random.default_rng(n)
    for _ in range(5):
        poles = folded.one_and_the_other(rng, n, apart, 1.5)
        found = fold_axis(*planes(poles), names=[f"B{k}" for k in range(n + 1)])
        assert found.verdict in ("undetermined", "homoclinal")
        if found.verdict == "undetermined":
            assert any(f"B{n} " in r and "measure more planes" in r for r in found.reasons)


def test_sound_folds_rest_on_many_planes() -> None:
    rng = np.random.default_rng(4)
    said = 0
    for _ in range(40):
        found = fold_axis(*planes(folded.bent(rng, 12, 100, 3)))
        said += any("rests on one plane" in reason for reason in found.reasons)
    assert said == 0
