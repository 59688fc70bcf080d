"""Traces of a plane on a model: where it truly meets it, and how far off it may be there."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.extraction.planes_by_construction import grid_mesh, normal_of
from tests.messages import refused
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.geology.beds.extended import (
    plane_estimate_from_attitude,
    plane_estimate_from_fit,
    repeat_planes,
)
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.planes import fit_plane
from vomstudio.products.section.extend_options import ExtendOptions
from vomstudio.products.section.extension import band_edges, extend, write_traces

ATTITUDE = (60.0, 30.0)


def hilly(step: float = 0.25) -> Mesh:
    y, x = np.mgrid[0:81, 0:81] * step
    return grid_mesh(1.5 * np.sin(x / 3) * np.cos(y / 4), step)


def test_traces_lie_on_the_planes_and_on_the_surface() -> None:
    mesh = hilly()
    through = np.array([10.0, 10.0, 0.4])
    belief = plane_estimate_from_attitude(Plane(*ATTITUDE), through, 1.0, 0.02)
    result = extend(mesh, belief, ExtendOptions(thickness_m=1.2, thickness_error_m=0.05))
    assert [bed.bed for bed in result.beds] == sorted(bed.bed for bed in result.beds)
    assert {bed.bed for bed in result.beds} >= {-2, -1, 0, 1, 2}
    normal = normal_of(*ATTITUDE)
    for trace in result.traces:
        off = (trace.points - through) @ normal - 1.2 * trace.bed
        assert np.abs(off).max() < 1e-9
        x, y, z = trace.points.T
        assert np.abs(z - 1.5 * np.sin(x / 3) * np.cos(y / 4)).max() < 0.01
        flat = np.linalg.norm(
            trace.points - through - ((trace.points - through) @ normal)[:, None] * normal, axis=1
        )
        tilt = math.tan(math.radians(1.0)) * 1.959964 / math.sqrt(5.991465)
        expected = np.sqrt(0.02**2 + (tilt * flat) ** 2 + (0.05 * trace.bed) ** 2)
        assert trace.error95_m == pytest.approx(expected, rel=1e-6)
    assert result.max_error95_deg == pytest.approx(1.0)
    assert result.length_m == pytest.approx(
        sum(np.linalg.norm(np.diff(t.points, axis=0), axis=1).sum() for t in result.traces)
    )


def test_band_edges_are_at_the_distance_of_the_error() -> None:
    mesh = hilly(0.1)
    belief = plane_estimate_from_attitude(Plane(*ATTITUDE), np.array([4.0, 4.0, 0.2]), 3.0, 0.05)
    for side, pieces in zip((1.0, -1.0), band_edges(mesh, belief), strict=True):
        assert len(pieces) > 50
        points = pieces.reshape(-1, 3)
        half = belief.t95 * belief.position_sd(points)
        assert belief.distances(points) == pytest.approx(side * half, abs=1e-3)


def test_band_of_a_repeated_bed_includes_the_thickness_error() -> None:
    mesh = hilly(0.1)
    belief = plane_estimate_from_attitude(Plane(*ATTITUDE), np.array([4.0, 4.0, 0.2]), 1.0, 0.02)
    beds = repeat_planes(belief, mesh.vertices, 1.5, 0.05)
    for number in beds.numbers.tolist():
        for side, pieces in zip((1.0, -1.0), band_edges(mesh, belief, beds, number), strict=True):
            points = pieces.reshape(-1, 3)
            sd = np.hypot(belief.position_sd(points), number * 0.05 / 1.959964)
            expected = 1.5 * number + side * belief.t95 * sd
            assert belief.distances(points) == pytest.approx(expected, abs=1e-3)


def test_band_contains_the_true_bed_in_95_percent_of_cases() -> None:
    # Traces of a true plane on a hill, digitised with noise along a short stretch: all of its true
    # trace, far away too, is within the band in about 95 of 100 places.
    rng = np.random.default_rng(1)
    through = np.array([10.0, 10.0, 0.3])
    exact = extend(hilly(), plane_estimate_from_attitude(Plane(*ATTITUDE), through, 0.0))
    whole = np.concatenate([trace.points for trace in exact.traces])
    near = whole[np.linalg.norm(whole - through, axis=1) < 5.0]
    held = []
    for _ in range(300):
        picked = near[rng.choice(len(near), 25, replace=False)]
        belief = plane_estimate_from_fit(
            fit_plane(picked + 0.02 * rng.standard_normal(picked.shape), is_ordered=False)
        )
        half = belief.t95 * belief.position_sd(whole)
        held.append(np.abs(belief.distances(whole)) <= half)
    assert 0.92 < np.mean(held) < 0.975


def test_cloud_gives_the_same_traces_as_a_mesh() -> None:
    mesh = hilly(0.1)
    belief = plane_estimate_from_attitude(Plane(*ATTITUDE), np.array([4.0, 4.0, 0.2]), 1.0)
    cloud = extend(PointCloud(mesh.vertices), belief, spacing=0.1)
    exact = extend(mesh, belief)
    assert cloud.length_m == pytest.approx(exact.length_m, rel=0.15)


def test_indistinguishable_beds_are_reported() -> None:
    belief = plane_estimate_from_attitude(Plane(*ATTITUDE), np.array([10.0, 10.0, 0.2]), 8.0)
    (warning,) = extend(hilly(), belief, ExtendOptions(thickness_m=0.5)).warnings
    assert warning.code == "extension.beds-indistinct"
    assert extend(hilly(), belief).warnings == ()


def test_impossible_extension_is_rejected(tmp_path: Path) -> None:
    belief = plane_estimate_from_attitude(Plane(*ATTITUDE), np.array([10.0, 10.0, 500.0]), 1.0)
    with refused("extension.misses-model", GeometryError):
        extend(hilly(), belief)
    with pytest.raises(UsageError) as error:
        ExtendOptions(thickness_m=-1.0)
    assert (error.value.code, error.value.field) == ("option.not-a-length", "--thickness")
    near = plane_estimate_from_attitude(Plane(*ATTITUDE), np.array([10.0, 10.0, 0.5]), 1.0)
    with refused("output.unknown-format", UsageError, suffix=".shp", formats=(".csv", ".gpkg")):
        write_traces(tmp_path / "a.shp", extend(hilly(), near), crs=None, model="", force=False)


def test_gis_lines_contain_their_bed_and_largest_error(tmp_path: Path) -> None:
    import pyogrio

    belief = plane_estimate_from_attitude(Plane(*ATTITUDE), np.array([10.0, 10.0, 0.5]), 1.0)
    result = extend(hilly(), belief, ExtendOptions(thickness_m=1.0))
    path = tmp_path / "beds.gpkg"
    write_traces(path, result, crs="EPSG:32615", model="hill", force=False)
    meta, _, _, columns = pyogrio.raw.read(path)
    assert meta["crs"] == "EPSG:32615"
    report = dict(zip(meta["fields"], columns, strict=True))
    assert report["bed"].tolist() == [trace.bed for trace in result.traces]
    assert report["error95_m"] == pytest.approx([t.error95_m.max() for t in result.traces])
