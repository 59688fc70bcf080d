"""An object photographed all around: the mean of all cameras lies inside it and says nothing of
its sides, so each point's side is the one from which its photos saw it."""

import numpy as np
import pytest

from tests.messages import refused, with_code
from tests.photogrammetry import rock_face as rock
from tests.photogrammetry.surface import all_around
from tests.photogrammetry.surface.texture_truth import sample_pages
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.mesh import Mesh
from vomstudio.photogrammetry.dense.fusion import fuse_depth_maps
from vomstudio.photogrammetry.surface.meshing import MeshingOptions, build_surface
from vomstudio.photogrammetry.surface.texture import make_texture
from vomstudio.photogrammetry.surface.topology import cross_products


def volume(mesh: Mesh) -> float:
    """Positive where the triangles are counter-clockwise from outside (divergence theorem)."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


@pytest.fixture(scope="module")
def photographed():
    """(truth, views, photos, cloud, mesh) of the block."""
    truth, views = all_around.block(), all_around.cameras()
    maps = [all_around.exact_map(truth, view) for view in views]
    cloud = fuse_depth_maps([view.name for view in views], maps, None)
    mesh = build_surface(cloud, MeshingOptions(faces=4000)).mesh
    taken = [
        rock.taken(view, rock.photograph(truth, view, seed=k, shaded=False, noise=1.0))
        for k, view in enumerate(views)
    ]
    return truth, views, taken, cloud, mesh


@pytest.mark.full
def test_cloud_normals_face_the_photos_and_out_of_the_object(photographed):
    _, views, _, cloud, _ = photographed
    # The law that needs no cameras: the block is star-shaped about the origin.
    outward = (cloud.normals * cloud.points).sum(axis=1)
    assert (outward > 0).mean() > 0.999
    # The mean of the cameras lies inside, so it calls nearly every one of them wrong.
    middle = np.mean([view.centre for view in views], axis=0)
    assert ((middle - cloud.points) * cloud.normals).sum(axis=1).max() < 0.2


def test_the_surface_of_an_object_photographed_all_around_faces_outwards(photographed):
    truth, _, _, _, mesh = photographed
    assert volume(mesh) == pytest.approx(volume(Mesh(truth.vertices, truth.faces)), rel=0.02)
    cross = cross_products(mesh.vertices, mesh.faces)
    outward = (cross * mesh.vertices[mesh.faces].mean(axis=1)).sum(axis=1)
    area = np.linalg.norm(cross, axis=1)
    assert area[outward < 0].sum() < 0.001 * area.sum()


def test_its_texture_has_the_colours_of_the_object_on_every_side(photographed):
    truth, _, taken, _, mesh = photographed
    made = make_texture(mesh, taken)
    assert made.report.unseen_share < 0.02
    middle = made.mesh.vertices[made.mesh.faces].mean(axis=1)
    third = np.full((len(middle), 2), 1 / 3)
    drawn = sample_pages(made.mesh, made.pages, np.arange(len(middle)), third)
    true = truth.paint(middle)
    for side in (middle[:, 0] > 0, middle[:, 0] < 0, middle[:, 2] > 0, middle[:, 2] < 0):
        likeness = np.corrcoef(drawn[side].mean(axis=1), true[side].mean(axis=1))[0, 1]
        assert likeness > 0.8


def test_inside_out_surface_is_turned_over_and_reported(photographed):
    _, _, taken, _, mesh = photographed
    inside_out = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    made = make_texture(inside_out, taken)
    assert volume(made.mesh) > 0
    assert made.report.unseen_share < 0.02
    assert with_code(made.report.warnings, "texture.turned-over")


def test_model_with_most_of_its_surface_unseen_is_rejected(photographed):
    _, _, taken, _, mesh = photographed
    with refused("texture.mostly-unseen", GeometryError):
        make_texture(mesh, taken[:2])
