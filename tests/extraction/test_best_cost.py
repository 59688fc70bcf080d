"""The best of several costs: as often right as it states, and good for at least half of the
sample's traces after three clicks each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from tests.benchmarks.bench_followed import holds, outcrop
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.extraction.best_cost import available_costs, follow_best, select_best_path
from vomstudio.extraction.followed_trace import followed_trace
from vomstudio.extraction.following import Follower
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.quality import judge, total_error_deg
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.planes import fit_plane


@dataclass(frozen=True, eq=False)
class Path:
    points: np.ndarray


def bedded(colours: bool = True) -> tuple[PointCloud, np.ndarray]:
    """A wavy slope with a dark bed at z = 1, between lighter ones; three clicks on it."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(0, 4, 0.04), np.arange(0, 4, 0.04)))
    z = 0.5 * y + 0.4 * np.sin(2 * x)
    grey = np.where(np.abs(z - 1.0) < 0.06, 20, 180).astype(np.uint8)
    output = PointCloud(
        np.column_stack([x, y, z]),
        colors=np.repeat(grey[:, None], 3, axis=1) if colours else None,
    )
    at = np.array([0.2, 2.0, 3.7])
    clicks = np.column_stack([at, 2.0 * (1.0 - 0.4 * np.sin(2 * at)), np.ones(3)])
    return output, clicks


def test_path_with_smallest_stated_error_is_selected() -> None:
    data, clicks = bedded()
    surface = SurfaceGraph(data)
    path, cost, candidates = follow_best(surface, clicks, lambda _: 0.04)
    assert {one.cost for one in candidates} == {"colour", "dark", "light", "gradient", "curvature"}
    assert cost == candidates[0].cost
    assert np.array_equal(path.points, Follower(surface, cost).follow(clicks).points)
    errors = [one.error95_deg for one in candidates if one.error95_deg is not None]
    assert errors[0] == min(errors)
    assert np.abs(path.points[:, 2] - 1.0).max() < 0.1
    result = followed_trace(surface, clicks, cost="auto", resolution=0.04, model="m", frame="local")
    assert result.cost == result.to_dict()["tried"][0]["cost"]
    assert result.plane is not None
    assert result.plane["quality"] == "good"
    assert result.plane["dip_deg"] < result.plane["total95_deg"] + 0.5


def test_single_deviating_path_is_not_selected() -> None:
    """Three ways along a straight seam on a wavy wall, which leave its plane open and say so, and
    one that turns off it for a while and comes back: whatever it follows, the seam it is not."""
    rng = np.random.default_rng(11)
    way = np.linspace(0.0, 4.0, 90)
    none = 0.0 * way

    def along(_: str) -> np.ndarray:
        return np.column_stack([way, none, none]) + 0.01 * rng.normal(size=(90, 3))

    off = 0.4 * np.exp(-((way - 1.5) ** 2))
    wrong = np.column_stack([way, off, 0.4 * off + 0.06 * rng.normal(size=90)])
    ways = {"colour": along(""), "dark": along(""), "gradient": along(""), "light": wrong}
    path, cost, candidates = select_best_path(
        list(ways), lambda cost: Path(ways[cost]), lambda _: 0.04
    )
    stated = {one.cost: one.error95_deg for one in candidates}
    assert stated["light"] is not None
    assert 5.0 < stated["light"] < 45.0
    assert stated["dark"] == 90.0
    assert cost != "light"
    assert cost == candidates[0].cost
    assert path.points is ways[cost]


def test_curvature_is_followed_without_colours() -> None:
    data, clicks = bedded(colours=False)
    assert available_costs(SurfaceGraph(data)) == ("curvature",)
    assert follow_best(SurfaceGraph(data), clicks, lambda _: 0.04)[1] == "curvature"


def test_disconnected_parts_are_refused() -> None:
    data, clicks = bedded()
    points = np.concatenate([data.points, data.points + [100.0, 0.0, 0.0]])
    far = np.array([clicks[0], clicks[1] + [100.0, 0.0, 0.0]])
    with pytest.raises(GeometryError):
        follow_best(SurfaceGraph(PointCloud(points)), far, lambda _: 0.04)


@pytest.mark.parametrize("cost", first_in_default_tier(["auto", "dark"]))
@pytest.mark.parametrize("mesh", first_in_default_tier([False, True]))
def test_line_on_flat_face_leaves_plane_undetermined(mesh: bool, cost: str) -> None:
    """Lightness leads away from a dark bed, along the face, whose plane is told exactly so."""
    rng = np.random.default_rng(5)
    count, held = 0, 0
    while count < 2:
        output = outcrop(rng, mesh=mesh, flat=True)
        if output is None:
            continue
        result = followed_trace(
            SurfaceGraph(output.data),
            output.way_points,
            cost=cost,
            resolution=output.spacing,
            model="",
            frame="local",
        )
        assert result.plane is not None
        count += 1
        held += result.plane["quality"] == "poor" and result.plane["total95_deg"] > 60.0
        held += result.band is not None and result.band.turn95_deg > 60.0
    assert held == 4


@pytest.mark.slow
@pytest.mark.parametrize("mesh", [False, True])
def test_stated_error_of_best_path_is_reliable(mesh: bool) -> None:
    rng = np.random.default_rng(3)
    joint, total, good_but_off, good = [], [], 0, 0
    while len(total) < 120:
        output = outcrop(rng, mesh=mesh)
        if output is None:
            continue
        spacing = output.spacing
        try:
            path = follow_best(
                SurfaceGraph(output.data), output.way_points, lambda _, s=spacing: s
            )[0]
            fit = fit_plane(path.points)
        except GeometryError:
            continue
        stated = total_error_deg(fit, spacing)
        cosine = min(abs(float(fit.normal @ output.normal)), 1.0)
        error = float(np.degrees(np.arccos(cosine)))
        joint.append(holds(fit, output.normal))
        total.append(stated is None or error <= stated)
        if judge(fit, resolution_m=spacing, outcrop_normal=None).quality == "good":
            good += 1
            good_but_off += error > 5.0
    # 93 % within what chance does to 120 of them.
    assert np.mean(joint) >= 0.90
    assert np.mean(total) >= 0.92
    assert good_but_off <= 0.05 * good
