"""Followed trace with its plane, the result of `vomstudio trace` and `vs.follow`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.spreadsheet_cells import comment_line
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.version import __version__
from vomstudio.core.words import tr
from vomstudio.extraction.best_cost import AUTO, CostTrial, follow_best
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
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, Thresholds
from vomstudio.geology.quality import judge
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.planes import fit_plane
from vomstudio.geometry.surface import VertexSurface
from vomstudio.project.tables.orientation_table import Row, plane_row

MAX_SNAP_RESOLUTIONS = 10.0
"""Maximum distance between a way-point and the model, in model resolutions."""


@dataclass(frozen=True, eq=False, repr=False)
class FollowedTrace(PrintableResult):
    """Trace that was followed on a model, with its plane.

    Parameters
    ----------
    points : (n, 3) array
        Vertices of the path in the World frame, m.
    length_m : float
        Length along the path, m.
    snap_m : float
        Maximum distance between a way-point and its vertex of the path, m.
    plane : dict or None
        Row of the orientation table; None if no plane can be fitted.
    band : BandFigures or None
        Band of planes that are compatible with a straight trace; None if the plane is determined
        or cannot be fitted.
    way_points, vertices : int
        Numbers of way-points and of vertices.
    cost : str
        Cost that was used.
    warnings : tuple of Finding
    tried : tuple of CostTrial
        Costs that were compared for the cost "auto", the selected one first.
    doubtful : tuple of DoubtfulStretch
        Stretches that may follow another contact, with their first and last vertices.
    """

    points: FloatArray = field(repr=False, metadata=HIDDEN_IN_JSON)
    length_m: float
    snap_m: float
    plane: Row | None
    band: BandFigures | None
    way_points: int
    cost: str
    vertices: int
    warnings: tuple[Finding, ...]
    tried: tuple[CostTrial, ...] = field(default=(), kw_only=True)
    doubtful: tuple[DoubtfulStretch, ...] = field(default=(), kw_only=True)


def find_way_point_off_model(
    surface: SurfaceGraph, way_points: FloatArray, resolution: float
) -> int | None:
    """Return the row of the first way-point that is not on the model.

    Parameters
    ----------
    surface : SurfaceGraph
    way_points : (n, 3) ndarray
        Way-points in the World frame, m.
    resolution : float
        Effective resolution of the model, m.

    Returns
    -------
    int or None
        None if all way-points are on the model, or if the resolution is not finite.
    """
    limit = MAX_SNAP_RESOLUTIONS * resolution
    rows = np.flatnonzero(~(surface.snap_distances(way_points) <= limit))
    return int(rows[0]) if len(rows) and np.isfinite(resolution) else None


def off_model_finding(number: int, distance_m: float, resolution_m: float) -> Finding:
    """Report a way-point that is not on the model.

    Parameters
    ----------
    number : int
        Number of the way-point, counted from 1.
    distance_m : float
        Distance from the model, m.
    resolution_m : float
        Effective resolution of the model, m.

    Returns
    -------
    Finding
    """
    return Finding(
        "path.off-model",
        number=number,
        distance_m=distance_m,
        maximum_m=MAX_SNAP_RESOLUTIONS * resolution_m,
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
    thresholds: Thresholds = DEFAULT_THRESHOLDS,
    priors: Sequence[SetPrior] = (),
    name: str = "",
) -> FollowedTrace:
    """Follow a contact through way-points and fit the plane of the trace.

    Parameters
    ----------
    surface : SurfaceGraph
        Surface of a model in the World frame.
    way_points : (w, 3) array
        Way-points in the World frame, m.
    cost : str
        One of `COST_NAMES`, the name of a field, or "auto" for the best of `COST_NAMES`.
    resolution : float
        Resolution of the model, m.
    model, frame : str
        Names used in the orientation table.
    thresholds : Thresholds
    priors : sequence of SetPrior
        Sets with which the band of a straight trace is compared.
    name : str
        Name of the cost in the result; by default, `cost`.

    Returns
    -------
    FollowedTrace

    Raises
    ------
    GeometryError
        If there are fewer than two way-points, if they coincide, if one is not on the model, or if
        two are on separate parts of it.
    UsageError
        If the cost is not available for the model.
    """
    follower = None if cost == AUTO else Follower(surface, cost)
    require_on_model(surface, way_points, resolution)
    vertices = index_vertices(surface)
    trials: tuple[CostTrial, ...] = ()
    if follower is None:
        path, cost, trials = follow_best(
            surface,
            way_points,
            vertices.local_resolution,
            vertices.outcrop_normal,
            uses_whole_surface=True,
        )
    else:
        path = follower.follow(way_points, uses_whole_surface=True)
    cost = name or cost
    notes = tr(
        "followed through {count} way-points, using the cost {cost}",
        count=len(way_points),
        cost=cost,
    )
    local_resolution = vertices.local_resolution(path.points) or 0.0
    remaining_trace = fit_remaining_plane(
        path.points, find_jumps(path.points, path.costs, path.way_point_rows, local_resolution)
    )
    plane, band, warnings = fit_trace_plane(
        path.points,
        vertices,
        model=model,
        frame=frame,
        thresholds=thresholds,
        notes=notes,
        priors=priors,
        remaining_trace=remaining_trace,
    )
    return FollowedTrace(
        points=path.points,
        length_m=path.length,
        snap_m=float(path.snap_distances.max()),
        plane=plane,
        band=band,
        way_points=len(way_points),
        cost=cost,
        vertices=len(path.points),
        warnings=warnings,
        tried=trials,
        doubtful=() if remaining_trace is None else remaining_trace.stretches,
    )


def index_vertices(surface: SurfaceGraph) -> VertexSurface:
    """Build an index of the vertices of a surface for queries around the points of a path.

    Parameters
    ----------
    surface : SurfaceGraph

    Returns
    -------
    VertexSurface
    """
    data = surface.data
    undivided_vertices = None
    if isinstance(data, Mesh) and data.undivided is not data:
        undivided_vertices = data.undivided.vertices
    vertices = VertexSurface(surface.places + surface.origin, undivided_vertices)
    vertices.build()
    return vertices


def require_on_model(surface: SurfaceGraph, way_points: FloatArray, resolution: float) -> None:
    """Require at least two way-points that are all on the model.

    Raises
    ------
    GeometryError
        If there are fewer than two way-points, or if one is not on the model.
    """
    if len(way_points) < 2:
        raise GeometryError(Finding("feature.too-few-points", count=2 - len(way_points), minimum=2))
    if (row := find_way_point_off_model(surface, way_points, resolution)) is not None:
        distance_m = float(surface.snap_distances(way_points)[row])
        raise GeometryError(off_model_finding(row + 1, distance_m, resolution))


def fit_trace_plane(
    points: FloatArray,
    vertex_surface: VertexSurface,
    *,
    model: str,
    frame: str,
    thresholds: Thresholds,
    notes: str,
    priors: Sequence[SetPrior],
    remaining_trace: RemainingTrace | None = None,
) -> tuple[Row | None, BandFigures | None, tuple[Finding, ...]]:
    """Fit the plane of a trace and judge its quality.

    Parameters
    ----------
    points : (n, 3) array
        Points of the trace in the World frame, m.
    vertex_surface : VertexSurface
        Vertices of the model.
    model, frame, notes : str
        Values used in the orientation table.
    thresholds : Thresholds
    priors : sequence of SetPrior
    remaining_trace : RemainingTrace, optional
        Trace without its doubtful stretches.

    Returns
    -------
    row : dict or None
        Row of the orientation table; None if no plane can be fitted.
    band : BandFigures or None
        Band of planes that are compatible with a straight trace; None if the plane is determined
        or cannot be fitted.
    findings : tuple of Finding
        Reason for a missing plane, and doubtful stretches.
    """
    findings = () if remaining_trace is None else tuple(remaining_trace.findings())
    try:
        fit = fit_plane(points)
    except GeometryError as error:
        return None, None, (cause_finding(error), *findings)
    resolution, outcrop_normal = (
        vertex_surface.local_resolution(points),
        vertex_surface.outcrop_normal(points),
    )
    stretch = (
        None
        if remaining_trace is None
        else remaining_trace.error95_deg(fit, resolution, outcrop_normal)
    )
    verdict = judge(
        fit,
        resolution_m=resolution,
        outcrop_normal=outcrop_normal,
        thresholds=thresholds,
        surface_findings=() if remaining_trace is None else remaining_trace.findings(),
        stretch_error_deg=stretch,
    )
    row = plane_row(
        fit,
        verdict,
        id="1",
        resolution_m=resolution,
        stretch_error_deg=stretch,
        outcrop_normal=outcrop_normal,
        model=model,
        frame=frame,
        notes=notes,
    )
    band = find_plane_band(fit, resolution_m=resolution, outcrop_normal=outcrop_normal)
    return row, None if band is None else describe_band(band, priors), findings


def write_path(
    path: str | Path,
    points: FloatArray,
    *,
    crs: str | None,
    notes: Sequence[str] = (),
    force: bool = False,
) -> None:
    """Write a path as one row x, y, z per vertex (n, 3), in the World frame, m.

    The file is written completely or not at all.

    Raises
    ------
    TargetError
        If the file cannot be written.
    """
    header_lines = [
        f"VOM Studio {__version__}, followed trace",
        f"CRS: {crs or 'none declared, coordinates as given'}",
        *notes,
    ]
    rows = [f"{x:.6f},{y:.6f},{z:.6f}" for x, y, z in points.tolist()]
    text = "".join(map(comment_line, header_lines)) + "\n".join(["x,y,z", *rows]) + "\n"
    write_bytes(path, text.encode(), force=force)
