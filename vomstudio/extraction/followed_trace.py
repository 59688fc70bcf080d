"""What `vomstudio trace` and `vs.follow` tell of a followed trace."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.spreadsheet_cells import comment_line
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN
from vomstudio.core.version import __version__
from vomstudio.core.words import tr
from vomstudio.extraction.best_cost import AUTO, Tried, follow_best
from vomstudio.extraction.following import Follower
from vomstudio.extraction.path_jumps import find_jumps
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.band_figures import BandFigures, describe_band
from vomstudio.geology.doubtful_stretches import (
    DoubtfulStretch,
    RemainingTrace,
    fit_remaining_plane,
)
from vomstudio.geology.plane_bands import SetPrior, find_plane_band
from vomstudio.geology.profiles import DEFAULTS, Thresholds
from vomstudio.geology.quality import judge
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.planes import fit_plane
from vomstudio.geometry.surface import VertexSurface
from vomstudio.project.tables.orientation_table import Row, plane_row

FARTHEST = 10.0
"""A way-point farther from the model than so many resolutions is not on it."""


@dataclass(frozen=True, eq=False, repr=False)
class FollowedTrace(PrintableResult):
    """points : (n, 3) every vertex of the path, World, m; length_m : along it
    snap_m : the farthest that a way-point lies from the path's vertex for it
    plane : row of the orientation table, or None where there is no plane
    band : of the planes that a straight trace allows; None where its plane is determined
    way_points : how many; cost : what was followed; vertices : n
    tried : of each cost by which it was followed, the best first, where the best was asked for
    doubtful : stretches that may be on another contact, each with first and last vertex
    """

    points: FloatArray = field(repr=False, metadata=HIDDEN)
    length_m: float
    snap_m: float
    plane: Row | None
    band: BandFigures | None
    way_points: int
    cost: str
    vertices: int
    warnings: tuple[Finding, ...]
    tried: tuple[Tried, ...] = field(default=(), kw_only=True)
    doubtful: tuple[DoubtfulStretch, ...] = field(default=(), kw_only=True)


def off_the_model(surface: SurfaceGraph, way_points: FloatArray, resolution: float) -> int | None:
    """The row of the first way-point that is not on the model; None where all are."""
    limit = FARTHEST * resolution
    far = np.flatnonzero(~(surface.snapped(way_points) <= limit))
    return int(far[0]) if len(far) and np.isfinite(resolution) else None


def off_model_finding(number: int, distance_m: float, resolution_m: float) -> Finding:
    """Report a way-point, counted from 1, that is not on the model."""
    return Finding(
        "path.off-model",
        number=number,
        distance_m=distance_m,
        maximum_m=FARTHEST * resolution_m,
        resolution_m=resolution_m,
    )


def followed_trace(
    surface: SurfaceGraph,
    way_points: FloatArray,
    *,
    cost: str,
    resolution: float,
    model: str,
    frame: str,
    thresholds: Thresholds = DEFAULTS,
    priors: Sequence[SetPrior] = (),
    called: str = "",
) -> FollowedTrace:
    """Follow a contact through way-points (w, 3) in World and fit its plane.

    surface : of a model in World; cost : of COSTS, a field, or "auto" for the best of COSTS;
    resolution : of the model, m; priors : sets against which a straight trace is held; called : the
    cost by another name
    Raises GeometryError for a way-point that is not on the model, for fewer than two, and where the
    model does not hang together between two; UsageError for a cost that the model does not have.
    """
    follower = None if cost == AUTO else Follower(surface, cost)
    require_on_model(surface, way_points, resolution)
    near = near_surface(surface)
    tried: tuple[Tried, ...] = ()
    if follower is None:
        path, cost, tried = follow_best(
            surface, way_points, near.resolution_near, near.outcrop_normal, whole=True
        )
    else:
        path = follower.follow(way_points, whole=True)
    cost = called or cost
    notes = tr("followed through {count} way-points by {cost}", count=len(way_points), cost=cost)
    own = near.resolution_near(path.points) or 0.0
    rest = fit_remaining_plane(path.points, find_jumps(path.points, path.costs, path.at, own))
    plane, band, said = plane_of(
        path.points,
        near,
        model=model,
        frame=frame,
        thresholds=thresholds,
        notes=notes,
        priors=priors,
        rest=rest,
    )
    return FollowedTrace(
        points=path.points,
        length_m=path.length,
        snap_m=float(path.snaps.max()),
        plane=plane,
        band=band,
        way_points=len(way_points),
        cost=cost,
        vertices=len(path.points),
        warnings=said,
        tried=tried,
        doubtful=() if rest is None else rest.stretches,
    )


def near_surface(surface: SurfaceGraph) -> VertexSurface:
    """What is asked of a model around the points of a path."""
    data = surface.data
    own = None
    if isinstance(data, Mesh) and data.undivided is not data:
        own = data.undivided.vertices
    near = VertexSurface(surface.places + surface.origin, own)
    near.build()
    return near


def require_on_model(surface: SurfaceGraph, way_points: FloatArray, resolution: float) -> None:
    """Raises GeometryError for fewer than two way-points, and for one that is not on the model."""
    if len(way_points) < 2:
        raise GeometryError(Finding("feature.too-few-points", count=2 - len(way_points), minimum=2))
    if (row := off_the_model(surface, way_points, resolution)) is not None:
        distance_m = float(surface.snapped(way_points)[row])
        raise GeometryError(off_model_finding(row + 1, distance_m, resolution))


def plane_of(
    points: FloatArray,
    near: VertexSurface,
    *,
    model: str,
    frame: str,
    thresholds: Thresholds,
    notes: str,
    priors: Sequence[SetPrior],
    rest: RemainingTrace | None = None,
) -> tuple[Row | None, BandFigures | None, tuple[Finding, ...]]:
    """The row of the plane through points (n, 3) of the model `near`, or None; the band of planes
    that they allow where they are straight; why there is no plane, and which stretches are
    doubtful. rest : what is outside of these"""
    findings = () if rest is None else tuple(rest.findings())
    try:
        fit = fit_plane(points)
    except GeometryError as error:
        return None, None, (cause_of(error), *findings)
    own, face = near.resolution_near(points), near.outcrop_normal(points)
    stretch = None if rest is None else rest.error95_deg(fit, own, face)
    verdict = judge(
        fit,
        resolution_m=own,
        outcrop_normal=face,
        thresholds=thresholds,
        surface_findings=() if rest is None else rest.findings(),
        stretch_error_deg=stretch,
    )
    row = plane_row(
        fit,
        verdict,
        id="1",
        resolution_m=own,
        stretch_error_deg=stretch,
        outcrop_normal=face,
        model=model,
        frame=frame,
        notes=notes,
    )
    band = find_plane_band(fit, resolution_m=own, outcrop_normal=face)
    return row, None if band is None else describe_band(band, priors), findings


def write_path(
    path: str | Path,
    points: FloatArray,
    *,
    crs: str | None,
    notes: Sequence[str] = (),
    force: bool = False,
) -> None:
    """A row x, y, z for each vertex (n, 3), World, m; whole or not at all. Raises TargetError."""
    head = [
        f"VOM Studio {__version__}, followed trace",
        f"CRS: {crs or 'none declared, coordinates as given'}",
        *notes,
    ]
    rows = [f"{x:.6f},{y:.6f},{z:.6f}" for x, y, z in points.tolist()]
    text = "".join(map(comment_line, head)) + "\n".join(["x,y,z", *rows]) + "\n"
    write_bytes(path, text.encode(), force=force)
