"""Large triangles cut into smaller ones, so that a surface has pieces everywhere."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.extraction.measurable_kernels import longest_sides
from vomstudio.geometry.kernels.jit import for_reading
from vomstudio.geometry.patches import triangle_areas

MOST = 6_000_000
"""Faces that cutting may make."""
_ROUNDS = 40
# Area of the largest triangle without a side above 1: that with equal sides.
_LARGEST = np.sqrt(3.0) / 4.0


def finer(
    vertices: FloatArray, faces: IntArray, longest: float
) -> tuple[FloatArray, IntArray, IntArray]:
    """The same surface with no edge above `longest`: vertices, faces, and of which face each is.

    An edge is halved for all of its faces alike, so that neighbours stay neighbours. Raises
    GeometryError where that makes too many faces.
    """
    square = np.empty(len(faces))
    longest_sides(for_reading(vertices, np.float64), for_reading(faces, np.int64), square)
    near = np.zeros(len(vertices), np.bool_)
    near[faces[square > longest**2].ravel()] = True
    # An edge of a long face has both of its ends.
    asked = near[faces].sum(axis=1) >= 2
    of = np.flatnonzero(asked)
    done: list[tuple[IntArray, IntArray]] = [(faces[~asked], np.flatnonzero(~asked))]
    faces = faces[asked]
    area = float(triangle_areas(*(vertices[faces[:, k]] for k in range(3))).sum())
    if area > MOST * _LARGEST * longest**2:
        # Before half a minute goes by in finding that out.
        raise GeometryError(Finding("faces.length-too-small"))
    for _ in range(_ROUNDS):
        ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
        # By its nodes, not by the order in which a face has them: both faces must find the same.
        low, high = ends.min(axis=2), ends.max(axis=2)
        length = np.linalg.norm(vertices[low] - vertices[high], axis=2)
        # Only a face's longest edge: its pieces stay as round as it is (Rivara 1984). A face whose
        # shorter edge was a neighbour's longest is cut there too.
        long = (length >= length.max(axis=1, keepdims=True) * (1.0 - 1e-9)) & (length > longest)
        if not long.any():
            done.append((faces, of))
            break
        key = low * np.int64(len(vertices)) + high
        cut = np.unique(key[long])
        place = np.searchsorted(cut, key)
        place[place == len(cut)] = 0
        found = cut[place] == key
        # Faces that no cut edge touches will be touched by none that comes later unless they are
        # long themselves; those are not: an edge that is cut later is longer than `longest`.
        still = (length > longest).any(axis=1) | found.any(axis=1)
        done.append((faces[~still], of[~still]))
        faces, of, place, found = faces[still], of[still], place[still], found[still]
        middle = np.where(found, place + len(vertices), -1)
        vertices = np.concatenate(
            [vertices, 0.5 * (vertices[cut // len(vertices)] + vertices[cut % len(vertices)])]
        )
        faces, of = _cut(faces, middle, of)
        if len(faces) + sum(len(part) for part, _ in done) > MOST:
            raise GeometryError(Finding("faces.length-too-small"))
    return (
        vertices,
        np.concatenate([part for part, _ in done]),
        np.concatenate([own for _, own in done]),
    )


def _cut(faces: IntArray, middle: IntArray, of: IntArray) -> tuple[IntArray, IntArray]:
    """Each face in two to four at the middles (k, 3) of its edges, -1 where none."""
    count = (middle >= 0).sum(axis=1)
    made, own = [faces[count == 0]], [of[count == 0]]
    for corner in range(3):
        # The numbers of a face's corners and middles from this corner on.
        a, b, c = (faces[:, (corner + k) % 3] for k in range(3))
        ab, bc, ca = (middle[:, (corner + k) % 3] for k in range(3))
        one = (count == 1) & (ab >= 0)
        two = (count == 2) & (ca < 0)
        three = (count == 3) & (corner == 0)
        for rows, parts in (
            (one, ((a, ab, c), (ab, b, c))),
            (two, ((a, ab, c), (ab, b, bc), (ab, bc, c))),
            (three, ((a, ab, ca), (ab, b, bc), (bc, c, ca), (ab, bc, ca))),
        ):
            for part in parts:
                made.append(np.stack([node[rows] for node in part], axis=1))
                own.append(of[rows])
    return np.concatenate(made), np.concatenate(own)
