"""Cutting large triangles, against what halving a right triangle must give."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.core.errors import GeometryError
from vomstudio.extraction import refinement

# Equal legs of 1: each half has them shorter by the root of two. No side above 0.1 takes eight
# halvings, and triangles with three equal sides of 0.1 would cover it in 116.
CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
FACE = np.array([[0, 1, 2]])
LONGEST = 0.1


def test_a_right_triangle_is_halved_eight_times() -> None:
    vertices, faces, of = refinement.subdivide_mesh(CORNERS, FACE, LONGEST)
    assert len(faces) == 256
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert max(np.linalg.norm(p - q, axis=1).max() for p, q in ((a, b), (b, c), (c, a))) <= LONGEST
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    assert areas == pytest.approx(np.full(256, 0.5 / 256))
    assert (of == 0).all()


@pytest.mark.parametrize("most", [200, 100])
def test_exceeding_face_limit_is_refused_before_or_during_subdivision(
    most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(refinement, "MAX_FACES", most)
    cut: list[int] = []
    whole = refinement._split_faces
    monkeypatch.setattr(refinement, "_split_faces", lambda *a: (cut.append(1), whole(*a))[1])
    with pytest.raises(GeometryError, match="longer"):
        refinement.subdivide_mesh(CORNERS, FACE, LONGEST)
    assert bool(cut) == (most == 200)


def test_subdivision_up_to_face_limit_is_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refinement, "MAX_FACES", 256)
    assert len(refinement.subdivide_mesh(CORNERS, FACE, LONGEST)[1]) == 256
