"""Sections against shapes whose sections are known, and against VTK."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista as pv

from tests.messages import refused
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.ortho.interpretation import Item, apparent_dip_deg, count_features
from vomstudio.products.section.cutting import cut_model
from vomstudio.products.section.directions import ProjectionDirections
from vomstudio.products.section.section_lines import Curtain, curtain_from_line, curtain_from_plane
from vomstudio.products.section.writing import project_items

UTM = np.array([576_700.0, 5_188_150.0, 160.0])


def mesh_of(shape: pv.PolyData, shift=(0, 0, 0)) -> Mesh:  # type: ignore[no-untyped-def]
    shape = shape.triangulate()
    faces = np.ascontiguousarray(shape.faces.reshape(-1, 4)[:, 1:], np.int32)
    return Mesh(np.asarray(shape.points, np.float64) + shift, faces)


CUBE = mesh_of(pv.Box((-1, 1, -1, 1, -1, 1)).triangulate(), UTM)


@pytest.mark.parametrize("azimuth", [0.0, 30.0, 45.0, 90.0, 251.0])
def test_vertical_section_of_a_cube_is_a_rectangle(azimuth: float) -> None:
    """A rectangle 2 high, as wide as the cube is along the section's strike."""
    cut = cut_model(CUBE, curtain_from_plane(Plane(azimuth, 90), UTM))
    a = np.radians(azimuth % 90)
    width = 2 / max(np.cos(a), np.sin(a))
    assert len(cut.lines) == 1
    assert (cut.lines[0][0] == cut.lines[0][-1]).all()
    assert cut.length_m == pytest.approx(2 * (width + 2), abs=1e-8)
    low, high = cut.lines[0].min(axis=0), cut.lines[0].max(axis=0)
    assert [*low, *high] == pytest.approx([-width / 2, 159, width / 2, 161], abs=1e-8)


def test_the_section_across_a_cubes_diagonal_is_a_hexagon() -> None:
    cut = cut_model(CUBE, curtain_from_plane(Plane(45, np.degrees(np.arctan(np.sqrt(2)))), UTM))
    assert len(cut.lines) == 1
    assert cut.length_m == pytest.approx(6 * np.sqrt(2), abs=1e-8)


@pytest.mark.parametrize("plane", [Plane(20, 70), Plane(0, 0), Plane(111, 90)], ids=str)
def test_section_matches_the_cut_of_vtk(plane: Plane) -> None:
    rng = np.random.default_rng(2)
    terrain = pv.ParametricRandomHills(number_of_hills=20, random_seed=3)
    mesh = mesh_of(terrain)
    through = mesh.vertices[rng.integers(len(mesh.vertices))] + 0.01
    cut = cut_model(mesh, curtain_from_plane(plane, through))
    vtk = terrain.triangulate().slice(
        normal=plane.normal(), origin=through, generate_triangles=False
    )
    assert cut.length_m == pytest.approx(vtk.compute_cell_sizes()["Length"].sum(), rel=1e-5)
    normal = plane.normal()
    for line in cut.world:
        assert np.abs((line - through) @ normal).max() < 1e-9
    joined = vtk.connectivity()["RegionId"].max() + 1
    assert len(cut.lines) == joined


def test_duplicate_vertices_do_not_split_a_line() -> None:
    apart = Mesh(
        CUBE.vertices[CUBE.faces].reshape(-1, 3), np.arange(36, dtype=np.int32).reshape(-1, 3)
    )
    cut = cut_model(apart, curtain_from_plane(Plane(30, 60), UTM))
    assert len(cut.lines) == 1
    # A plane along a face of the cube.
    touching = cut_model(CUBE, curtain_from_plane(Plane(90, 90), UTM + [1, 0, 0]))
    assert touching.length_m in (pytest.approx(8), 0.0)


def test_a_profile_follows_its_line() -> None:
    """Across a roof of two slopes: heights are those of the roof, distances add up."""
    x = np.array([-10.0, 0, 10])
    corners = np.array([(a, b, 10 - abs(a)) for a in x for b in (-10.0, 10.0)])
    faces = np.array([[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]], np.int32)
    line = np.array([[-8, -8], [4, 1], [4, 1], [4, 9]])
    cut = cut_model(Mesh(corners, faces), curtain_from_line(line))
    assert len(cut.lines) == 1
    s, z = cut.lines[0].T
    assert s.min() == pytest.approx(0)
    assert s.max() == pytest.approx(15 + 8)
    world = cut.world[0]
    assert world[:, 2] == pytest.approx(10 - np.abs(world[:, 0]), abs=1e-5)
    assert z == pytest.approx(world[:, 2])
    # It crosses the ridge after 8 / 0.8.
    assert s[np.argmax(z)] == pytest.approx(10, abs=1e-5)
    with refused("section.no-length", field="--section-line"):
        curtain_from_line([[1, 1], [1, 1]])


@pytest.mark.parametrize(
    "curtain",
    [
        curtain_from_plane(Plane(30, 60), UTM),
        curtain_from_line(UTM[:2] + np.array([[-4.0, -1.0], [0.3, 0.2], [3.0, -2.0]])),
    ],
    ids=["plane", "line"],
)
def test_section_from_the_other_side_is_a_mirror_image(curtain: Curtain) -> None:
    other = curtain.flipped()
    assert other.normal == pytest.approx(-curtain.normal)
    assert other.ends == pytest.approx(curtain.ends[::-1])
    cut, mirrored = cut_model(CUBE, curtain), cut_model(CUBE, other)
    assert mirrored.length_m == pytest.approx(cut.length_m)
    places, along = np.concatenate(cut.world), np.concatenate(cut.lines)
    places_there, along_there = np.concatenate(mirrored.world), np.concatenate(mirrored.lines)
    nearest = np.linalg.norm(places[:, None] - places_there, axis=2).argmin(axis=1)
    assert places_there[nearest] == pytest.approx(places, abs=1e-6)
    total = along[:, 0] + along_there[nearest, 0]
    assert total == pytest.approx(np.full(len(total), total[0]), abs=1e-6)
    assert along_there[nearest, 1] == pytest.approx(along[:, 1], abs=1e-6)
    back = cut_model(CUBE, other.flipped())
    assert np.concatenate(back.lines) == pytest.approx(along, abs=1e-6)


def test_a_cloud_is_cut_by_a_slab() -> None:
    rng = np.random.default_rng(4)
    v = rng.normal(size=(60_000, 3))
    cloud = PointCloud(UTM + 5 * v / np.linalg.norm(v, axis=1)[:, None])
    # An open arc: the upper half of the sphere.
    cloud = PointCloud(cloud.points[cloud.points[:, 2] > 160])
    cut = cut_model(cloud, curtain_from_plane(Plane(70, 90), UTM), spacing=0.05)
    assert cut.slab_m == pytest.approx(0.2)
    assert len(cut.lines) == 1
    assert cut.length_m == pytest.approx(np.pi * 5, rel=0.15)
    assert np.abs(np.linalg.norm(cut.world[0] - UTM, axis=1) - 5).max() < 0.01
    assert np.abs((cut.world[0] - UTM) @ Plane(70, 90).normal()).max() < 1e-6


@pytest.mark.parametrize(("noise", "longest"), [(0.0, 1.01), (0.02, 1.15)])
@pytest.mark.parametrize("across", [0.0, 0.6, -1.2])
def test_section_line_of_an_inclined_cloud_has_no_zigzag(
    across: float, noise: float, longest: float
) -> None:
    """Of a plane z = 0.4 x + across y the section along x is straight: its length is known."""
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-5, 5, (2, 20000))
    z = 0.4 * x + across * y + rng.normal(0, noise, 20000)
    cloud = PointCloud(UTM + np.column_stack((x, y, z)))
    cut = cut_model(cloud, curtain_from_plane(Plane(0, 90), UTM), spacing=0.07)
    (line,) = cut.world
    truth = float(np.hypot(1.0, 0.4) * np.ptp(line[:, 0]))
    assert np.ptp(line[:, 0]) > 9.7
    assert 0.99 * truth < cut.length_m < longest * truth
    off = (line - UTM) @ np.array([-0.4, -across, 1.0])
    assert np.sqrt(np.mean(off**2)) < 0.01 + 0.8 * noise


@pytest.mark.parametrize("turn", [0.0, 30.0, 200.0])
@pytest.mark.parametrize(("dip", "b"), [(30, 90), (30, 40), (72, 15), (55, -35), (45, 0), (90, 40)])
def test_apparent_dips_follow_the_closed_formula(turn: float, dip: float, b: float) -> None:
    """tan a = tan d sin b, b from the section's strike to the plane's."""
    section = Plane(90 + turn, 90)
    panel = curtain_from_plane(section, UTM).panels[0]
    # Along North when the world is not turned; b = 90: the plane dips along the section.
    plane = Plane((90 + b + turn) % 360, dip)
    result = apparent_dip_deg(plane.normal(), panel.right, panel.up)
    expected = np.degrees(np.arctan(np.tan(np.radians(dip)) * np.sin(np.radians(abs(b)))))
    assert result is not None
    assert abs(result) == pytest.approx(expected, abs=1e-9)
    if b and dip < 90:
        toward = plane.dip_vector() @ panel.right
        assert np.sign(result) == np.sign(toward)
    assert apparent_dip_deg(section.normal(), panel.right, panel.up) is None


def test_features_are_projected_along_the_given_direction() -> None:
    curtain = curtain_from_plane(Plane(180, 90), UTM)
    plane = Plane(90, 40)
    item = Item(
        "planes",
        "point",
        UTM[None] + [1, 5, 2],
        "a",
        "B",
        "bedding",
        "",
        "#000000",
        plane.normal(),
        90,
        40,
    )
    # The viewer looks North: East is at the right.
    (flat,), left_out = project_items((item,), curtain, ProjectionDirections(None), 6.0)
    assert left_out == 0
    assert flat.points[0] == pytest.approx([1, 162])
    assert flat.distance[0] == pytest.approx(-5)
    assert flat.apparent_dip_deg == pytest.approx(40)
    along = np.array([0.0, np.cos(np.radians(30)), -np.sin(np.radians(30))])
    (flat,), _ = project_items((item,), curtain, ProjectionDirections(along), None)
    assert flat.points[0] == pytest.approx([1, 162 + 5 * np.tan(np.radians(30))])
    assert project_items((item,), curtain, ProjectionDirections(None), 4.0) == ((), 1)
    far = curtain_from_line([[UTM[0] + 3, UTM[1]], [UTM[0] + 9, UTM[1]]])
    assert project_items((item,), far, ProjectionDirections(None), None) == ((), 1)


def test_a_trace_with_its_line_and_its_plane_is_one_feature() -> None:
    curtain = curtain_from_plane(Plane(180, 90), UTM)

    def item(layer: str, id_: str, away: float) -> Item:
        return Item(layer, "point", UTM[None] + [1, away, 2], id_, id_, "bedding", "", "#000000")

    near, far = (("planes", "a"), ("traces", "a"), ("planes", "b")), (("planes", "c"),)
    items = [*(item(*each, 5.0) for each in near), *(item(*each, 50.0) for each in far)]
    # Of one that reaches into the section not all lies out of it.
    items += [item("traces", "d", 50.0), item("planes", "d", 5.0)]
    flats, left_out = project_items(tuple(items), curtain, ProjectionDirections(None), 6.0)
    assert len(flats) == 4
    assert count_features(flat.item for flat in flats) == 3
    assert left_out == 1
    # Rows of a table may have one id: each counts.
    assert count_features([item("planes", "", 1.0), item("planes", "", 2.0)]) == 2
