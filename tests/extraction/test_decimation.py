"""Meshes far finer than a trace's strip: thinned without holes, and with the map that they had."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.stats import spearmanr

from tests.extraction.test_measurable import waves
from vomstudio.extraction.decimation import ThinnedMesh, thin_mesh
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.surface.measurable_map import measurable_map

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


def divided(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Each face in four; the vertices that were come first."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
    ends.sort(axis=2)
    edges, which = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    ab, bc, ca = which.reshape(-1, 3).T + len(vertices)
    a, b, c = faces.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    finer = np.concatenate([np.stack(part, axis=1) for part in parts])
    return np.concatenate([vertices, vertices[edges].mean(axis=1)]), finer


def ball(rounds: int) -> tuple[Floats, Ints]:
    """Of radius one, its faces outward."""
    places = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
    faces = np.array(
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    )
    for _ in range(rounds):
        places, faces = divided(places, faces)
        places = places / np.linalg.norm(places, axis=1)[:, None]
    return places, faces


def selected_area(vertices: Floats, faces: Ints) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def faces_of_edges(result: ThinnedMesh) -> Ints:
    ends = np.stack([result.faces, np.roll(result.faces, -1, axis=1)], axis=2).reshape(-1, 2)
    return np.unique(np.sort(ends, axis=1), axis=0, return_counts=True)[1]


@pytest.mark.parametrize("cell", [0.1, 0.23, 0.6])
def test_a_closed_surface_stays_closed_and_keeps_its_area(cell: float) -> None:
    vertices, faces = ball(6)
    result = thin_mesh(vertices, faces, cell)
    assert len(result.faces) < 0.3 * len(faces)
    assert np.all(faces_of_edges(result) % 2 == 0)
    assert result.areas.sum() == pytest.approx(selected_area(vertices, faces), rel=1e-9)
    # Each vertex is put where those of its own cube are.
    moved = result.vertices[result.nodes] - vertices
    assert np.abs(moved).max() <= cell
    assert np.linalg.norm(result.vertices, axis=1).min() > 1.0 - cell**2
    # A face stands for one that there was.
    assert np.array_equal(result.nodes[faces[result.rows]], result.faces)


def test_close_but_unconnected_surfaces_are_not_merged() -> None:
    vertices, faces = ball(5)
    both = np.concatenate([vertices, 1.001 * vertices])
    result = thin_mesh(both, np.concatenate([faces, faces + len(vertices)]), 0.2)
    inner, outer = result.nodes[: len(vertices)], result.nodes[len(vertices) :]
    assert not np.isin(inner, outer).any()


def test_small_pieces_are_kept_and_every_vertex_has_a_face() -> None:
    vertices, faces = ball(3)
    places = np.concatenate([vertices, 0.01 * vertices + (5.2, 0.2, 0.2)])
    result = thin_mesh(places, np.concatenate([faces, faces + len(vertices)]), 0.5)
    assert (result.rows >= len(faces)).sum() == len(faces)
    assert np.array_equal(np.unique(result.faces), np.unique(result.nodes))
    # A band of one row of faces, whose tips have one face each.
    along = np.repeat(np.linspace(0.0, 10.0, 400), 2)[:, None] * (1.0, 0.0, 0.0)
    along[1::2, 2] = 0.01
    band = np.arange(798)[:, None] + np.arange(3)
    result = thin_mesh(along, band, 0.3)
    assert np.array_equal(np.unique(result.faces), np.unique(result.nodes))


@pytest.mark.full
def test_subdivided_mesh_gives_same_map() -> None:
    coarse = waves()
    vertices, faces = divided(np.asarray(coarse.vertices), np.asarray(coarse.faces, np.int64))
    vertices, faces = divided(vertices, faces)
    fine = Mesh(vertices, faces.astype(np.int32))
    one, other = (
        measurable_map(
            mesh,
            Plane(40, 30),
            MeasurableOptions(length_m=1.6, resolution_m=0.02, noise_m=0.002),
        )
        for mesh in (coarse, fine)
    )
    assert other.elements < 0.3 * len(faces)
    own = one.as_fields()["expected_error95_deg"].astype(float)
    theirs = other.as_fields()["expected_error95_deg"].astype(float)[: len(own)]
    assert np.isfinite(theirs).all()
    assert spearmanr(own, theirs).statistic > 0.97
    ratio = theirs / own
    assert np.median(ratio) == pytest.approx(1.0, abs=0.03)
    assert np.percentile(np.abs(np.log(ratio)), 90) < 0.15
    assert other.area_m2 == pytest.approx(one.area_m2, rel=1e-3)
    for name, share in one.shares.items():
        assert other.shares[name] == pytest.approx(share, abs=0.03)
