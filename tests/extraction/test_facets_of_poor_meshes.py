"""Facets of meshes whose faces share no corners or lie on each other, and normals that are wrong in
part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from tests.extraction.planes_by_construction import grid_mesh, normal_of, sheet
from tests.messages import by_code
from vomstudio.extraction.facets import find_facets
from vomstudio.extraction.selection.neighbours import build_neighbour_graph
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh


def roof() -> Mesh:
    """Two planes of 2 x 2 m in plan that meet in a ridge."""
    heights = 0.5 * (2.0 - np.abs(np.arange(81) - 40) * 0.05)
    return grid_mesh(np.tile(heights, (41, 1)), 0.05)


@pytest.mark.parametrize("jitter", [1e-9, 1e-6, 2e-5])
def test_nearly_coincident_corners_are_merged(jitter: float) -> None:
    mesh = roof()
    corners = mesh.vertices[mesh.faces.ravel()]
    corners = corners + jitter * np.random.default_rng(1).standard_normal(corners.shape)
    faces = np.arange(mesh.faces.size, dtype=np.int32).reshape(-1, 3)
    result, whole = find_facets(Mesh(corners, faces)), find_facets(mesh)
    assert len(result.facets) == len(whole.facets) == 2
    assert [f.area for f in result.facets] == pytest.approx(
        [f.area for f in whole.facets], rel=0.01
    )
    assert result.labels.shape == (len(corners),)
    assert not result.warnings


def test_disconnected_faces_are_reported() -> None:
    rng = np.random.default_rng(2)
    corners = rng.uniform(0.0, 10.0, (500, 1, 3)) + rng.normal(0.0, 0.05, (500, 3, 3))
    result = find_facets(
        Mesh(corners.reshape(-1, 3), np.arange(1500, dtype=np.int32).reshape(-1, 3))
    )
    assert by_code(result.warnings)["mesh.faces-apart"]["share_percent"] > 90.0


@pytest.mark.parametrize("turned", [False, True])
def test_duplicate_faces_are_merged(turned: bool) -> None:
    mesh = roof()
    again = mesh.faces[:, ::-1] if turned else np.roll(mesh.faces, 1, axis=1)
    whole = find_facets(mesh)
    for faces in (again, again[::2]):
        result = find_facets(replace(mesh, faces=np.concatenate([mesh.faces, faces])))
        assert [f.area for f in result.facets] == pytest.approx([f.area for f in whole.facets])
        assert result.exposure.area_m2 == pytest.approx(whole.exposure.area_m2)
        assert [f.fit.n for f in result.facets] == [f.fit.n for f in whole.facets]
        assert "mesh.faces-doubled" in by_code(result.warnings)
    assert not whole.warnings


@pytest.mark.full
@pytest.mark.parametrize("share", [0.0, 0.1, 0.4])
def test_normals_of_file_are_used_where_correct(
    share: float,
) -> None:
    rng = np.random.default_rng(3)
    attitudes = [(40.0, 70.0), (130.0, 85.0), (250.0, 15.0)]
    points = np.concatenate(
        [sheet(rng, a, (4.0 * i, 0.0, 0.0), noise=0.01) for i, a in enumerate(attitudes)]
    )
    normals = np.repeat([normal_of(*a) for a in attitudes], 4000, axis=0)
    bad = rng.random(len(normals)) < share
    normals = np.where(bad[:, None], rng.standard_normal(normals.shape), normals)
    result = find_facets(PointCloud(points, normals=normals.astype(np.float32)))
    assert result.exposure.coverage is not None
    assert result.exposure.coverage > 0.99
    assert len(result.facets) == 3
    assert ("cloud.normals-partly-unused" in by_code(result.warnings)) == (share > 0.0)


def two_tiles(apart: float = 0.0, gap: float = 0.0, coarse: int = 1) -> Mesh:
    """4 x 2 m of one plane in two meshes that share no corner, rounded apart, with a gap or an
    overlap between them, one coarser than the other."""
    rng = np.random.default_rng(31)
    side = 40 // coarse + 1
    one = grid_mesh(np.zeros((41, 41)), 0.05)
    two = grid_mesh(np.zeros((side, side)), 0.05 * coarse)
    beside = two.vertices + [2.0 + gap, 0.0, 0.0] + rng.uniform(-apart, apart, two.vertices.shape)
    return Mesh(
        np.concatenate([one.vertices, beside]),
        np.concatenate([one.faces, two.faces + len(one.vertices)]).astype(np.int32),
    )


UNSTITCHED = [
    {"apart": 1e-6},
    {"apart": 5e-4},
    {"apart": 2e-3},
    {"gap": 0.02},
    {"gap": -0.02},
    {"coarse": 4},
    {"coarse": 5, "gap": 0.01},
]


@pytest.mark.parametrize("tiles", UNSTITCHED)
def test_a_plane_across_unstitched_tiles_is_one_facet(tiles: dict[str, float]) -> None:
    result = find_facets(two_tiles(**tiles))
    assert len(result.facets) == 1
    facet = result.facets[0]
    assert facet.area == pytest.approx(8.0, rel=0.01)
    border = shapely.from_wkt(facet.border)
    assert border.geom_type == "Polygon"
    assert len(border.interiors) == 0
    assert border.area == pytest.approx(8.0 + 2.0 * tiles.get("gap", 0.0), rel=0.005)
    assert "mesh.faces-apart" not in by_code(result.warnings)


@pytest.mark.parametrize("tiles", UNSTITCHED)
def test_growing_from_a_click_goes_on_across_tiles(tiles: dict[str, float]) -> None:
    mesh = two_tiles(**tiles)
    near = build_neighbour_graph(mesh, 0.05)
    assert near.piece(100, angle_deg=15.0, distance=0.02, is_excluded=None).mask.all()


def test_tiles_separated_by_more_than_edge_length_are_two_facets() -> None:
    assert len(find_facets(two_tiles(gap=0.2)).facets) == 2


def test_tiles_with_a_step_between_them_are_two_facets() -> None:
    mesh = two_tiles()
    mesh.vertices[41 * 41 :, 2] += 0.5
    assert len(find_facets(mesh).facets) == 2
