"""Opening any model, and describing it."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tests.messages import codes, refused
from vomstudio.cli.common.output import to_json
from vomstudio.core.errors import InputError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import describe, point_spacing, read_model, resolution

OFFSET = np.array([5e5, 5e6, 0.0])


@pytest.mark.parametrize("name", ["no.obj", "no.ply", "folder.obj"])
def test_missing_file_or_folder_is_rejected_by_name(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(InputError) as caught:
        read_model(tmp_path / name)
    assert name in str(caught.value)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may read everything")
def test_unreadable_file_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "model.obj"
    path.write_text("v 0 0 0\n")
    path.chmod(0)
    with refused("file.no-permission"):
        read_model(path)


def test_content_hash_is_the_file_hash(tmp_path: Path) -> None:
    path = tmp_path / "model.obj"
    content = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" * 9
    path.write_bytes(content)
    assert read_model(path).content_hash == hashlib.sha256(content).hexdigest()


def test_resolution_of_a_mesh_is_its_mean_edge() -> None:
    vertices = np.array([[0, 0, 0], [3, 0, 0], [0, 4, 0]], float) + OFFSET
    mesh = Mesh(vertices, np.array([[0, 1, 2]], np.int32))
    assert resolution(mesh) == pytest.approx(4.0)


@pytest.mark.parametrize("side", [40, 1200])
def test_resolution_of_a_grid_of_points_is_its_spacing(side: int) -> None:
    x, y = np.meshgrid(np.arange(side) * 0.05, np.arange(side) * 0.05)
    points = np.stack([x, y, 0 * x], -1).reshape(-1, 3) + OFFSET
    order = np.random.default_rng(2).permutation(len(points))
    assert resolution(PointCloud(points[order])) == pytest.approx(0.05, rel=0.05)


@pytest.mark.parametrize("seed", range(40))
def test_spacing_of_few_points_is_bit_identical_to_tree_search(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(2, 300)), 3)) * 10.0 ** rng.uniform(-3, 6)
    points = np.round(points, 1) if seed % 3 == 0 else points
    points = rng.choice(points, len(points)) if seed % 2 else points
    local = points - points[0]
    # Itself, and with it those that stand at the same place.
    near = np.sort(cKDTree(local).query(local, k=len(local))[0][:, :4], axis=1)
    nearest = [row[row > 0][0] for row in near if (row > 0).any()]
    found = point_spacing(PointCloud(points))
    assert found == np.mean(nearest) if nearest else np.isnan(found)


def test_random_point_resolution_matches_poisson_process() -> None:
    rng = np.random.default_rng(8)
    points = np.column_stack([rng.random((600_000, 2)) * 100, np.zeros(600_000)])
    assert resolution(PointCloud(points)) == pytest.approx(1.0 / np.sqrt(60.0), rel=0.05)
    # Mean nearest neighbour in a plane: 1 / (2 sqrt(density)) (Clark & Evans 1954).
    assert point_spacing(PointCloud(points)) == pytest.approx(0.5 / np.sqrt(60.0), rel=0.03)


@pytest.mark.full
def test_duplicate_points_do_not_improve_resolution() -> None:
    x, y = np.meshgrid(np.arange(20.0), np.arange(20.0))
    points = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    assert resolution(PointCloud(np.repeat(points, 2, axis=0))) == pytest.approx(1.0, rel=0.08)
    assert np.isnan(resolution(PointCloud(points[:1])))
    assert np.isnan(resolution(PointCloud(np.zeros((300_000, 3)))))


def test_description_has_the_documented_keys_and_is_json(tmp_path: Path) -> None:
    path = tmp_path / "model.obj"
    path.write_text("v 1 2 3 0 0 1\nv 4 2 3 0 0 1\nv 1 6 3 0 0 1\nf 1 2 3\nf 1 2 9\n")
    told = json.loads(to_json(describe(path)))
    for key in (
        "path",
        "kind",
        "points",
        "faces",
        "materials",
        "textures",
        "bounds",
        "crs",
        "resolution_m",
        "fields",
        "warnings",
    ):
        assert key in told
    assert told["bounds"] == [[1, 2, 3], [4, 6, 3]]
    assert (told["kind"], told["points"], told["faces"]) == ("mesh", 3, 1)
    # An OBJ file states no unit.
    assert told["units"] == ["unknown"] * 3
    assert told["resolution_m"] is None
    assert told["resolution"] == pytest.approx(4.0)
    assert codes(told) == ["model.faces-without-vertices", "frame.assumed"]


def test_single_point_has_null_resolution_in_json(tmp_path: Path) -> None:
    path = tmp_path / "point.obj"
    path.write_text("v 1 2 3\n")
    assert describe(path)["resolution_m"] is None


def test_the_survey_model_is_described(data_dir: Path) -> None:
    told = describe(data_dir / "brighton_model" / "brighton_utm15n.obj")
    assert told["faces"] == 133_830
    assert len(told["textures"]) == 9  # type: ignore[arg-type]
    assert told["bounds"][1][1] == 5188208.903  # type: ignore[index]
