"""Views that show next to nothing of a model say so, and how to look at it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.elevation.heights import compute_heights
from vomstudio.products.elevation.planning import plan_heights
from vomstudio.products.elevation.writing import elevation_figures
from vomstudio.products.ortho.orthophoto import write_orthophoto
from vomstudio.products.ortho.planning import OrthophotoPlan, plan
from vomstudio.products.ortho.view_directions import view_against_plane, view_along_line

WALL = Plane(130.0, 35.0)


def sheet(rough: float = 0.0, bowed: float = 0.0) -> Mesh:
    """Twenty metres square, of the plane WALL."""
    n = 21
    s, t = (v.ravel() for v in np.meshgrid(np.linspace(-10, 10, n), np.linspace(-10, 10, n)))
    off = rough * np.random.default_rng(1).normal(size=s.size) + bowed * s**2 / 100
    strike, down = WALL.strike_vector(), WALL.dip_vector()
    points = np.outer(s, strike) + np.outer(t, down) + np.outer(off, WALL.normal())
    corner = np.arange(n * n).reshape(n, n)[:-1, :-1].ravel()
    faces = np.stack([corner, corner + 1, corner + n, corner + 1, corner + n + 1, corner + n], 1)
    return Mesh(points, faces.reshape(-1, 3).astype(np.int32))


def planned(mesh: Mesh, trend: float, plunge: float, gsd: float = 0.25) -> OrthophotoPlan:
    return plan(mesh, view_along_line(trend, plunge), to_world=np.eye(4), gsd=gsd)


EDGE_ON = Finding("view.edge-on", plane="130/35")


def test_edge_on_view_is_rejected_with_the_plane_to_look_at(tmp_path: Path) -> None:
    mesh = sheet()
    with refused("view.edge-on", plane="130/35"):
        write_orthophoto(mesh, planned(mesh, 40, 0, 0.1), tmp_path / "o.tif")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("view", [(40, 0), (220, 0), (130, 35), (130, 34.5)])
def test_nearly_edge_on_view_gives_a_warning(view: tuple[float, float]) -> None:
    assert EDGE_ON in planned(sheet(0.01), *view).notes
    # Whatever is thinner than a pixel or two.
    assert EDGE_ON in planned(sheet(0.01), 130, 32, 1.3).notes


@pytest.mark.parametrize("view", [(0, 90), (130, 20), (310, 55), (60, 0), (90, 10)])
def test_view_of_a_wall_gives_no_warning(view: tuple[float, float]) -> None:
    assert not planned(sheet(0.01), *view).notes


def test_curved_wall_or_single_row_seen_edge_on_gives_no_warning() -> None:
    assert not planned(sheet(0.0, bowed=6.0), 130, 35).notes
    line = np.linspace(0, 10, 50)[:, None] * [1.0, 0.0, 0.0]
    ends = np.vstack([line, line + [0.0, 0.01, 0.3]])
    faces = np.array([[k, k + 1, k + 50] for k in range(49)], np.int32)
    assert not plan(Mesh(ends, faces), view_along_line(0, 0), to_world=np.eye(4), gsd=0.1).notes


def test_elevation_model_over_a_perpendicular_plane_is_reported() -> None:
    mesh = sheet()
    laid = plan_heights(mesh, Plane(310.0, 55.0), to_world=np.eye(4), gsd=1.0)
    assert EDGE_ON in laid.notes
    heights, limit = compute_heights(mesh, laid, None)
    heights[:] = np.nan
    with refused("view.edge-on", plane="130/35"):
        elevation_figures(heights, laid, limit, None)
    assert not plan(mesh, view_against_plane(WALL), to_world=np.eye(4), gsd=1.0).notes
