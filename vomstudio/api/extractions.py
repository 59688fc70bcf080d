"""Extraction from models: facets, and lines that follow a contact."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from vomstudio.api.checking import (
    path_text,
    pixels_or_points,
    points,
    warn,
)
from vomstudio.api.comparisons import is_array, load_placed
from vomstudio.api.declared_options import arguments_named, options_from_arguments
from vomstudio.api.models import to_model
from vomstudio.api.reporting import Reported, to_progress
from vomstudio.api.tables import frame
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import CancelToken
from vomstudio.core.results import HIDDEN
from vomstudio.core.words import tr
from vomstudio.extraction.facet_table import FacetTable
from vomstudio.extraction.followed_trace import FollowedTrace
from vomstudio.extraction.trace_options import FollowOptions

if TYPE_CHECKING:
    from vomstudio.extraction.calibrated_photos import CalibratedPhotos


@dataclass(frozen=True, eq=False, repr=False)
class Facets(FacetTable):
    """Facets of a model, with the names of the command.

    Attributes
    ----------
    facets : int
        Number of facets.
    table : DataFrame
        Columns of the orientation table and `wkt` (the border, World), one row per facet, whose
        id is its label.
    coverage, near_planar_share : float or None
        Shares in the model's area, and in that of the exposed rock.
    level_share : float or None
        Share of that rock in facets that dip by less than 10 degrees.
    sets, discontinuities
        As `vs.sets` returns them, if requested.
    labels : dict
        {"facet": (n,), "set": (n,)} int32 of the model's points, -1 for none.
    """

    table: Any = field(default=None, metadata=HIDDEN)


def facets(
    model: Any,
    *,
    angle_deg: float | None = None,
    max_distance_m: float | None = None,
    min_points: int | None = None,
    min_area_m2: float | None = None,
    min_coplanarity: float | None = None,
    propose_sets: bool = False,
    preset: Literal["dse"] | None = None,
    progress: Reported = None,
    cancel: CancelToken | None = None,
) -> Facets:
    """Find planar facets of an outcrop, and fit and judge each as a patch.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or array (n, 3) of points
        World, metres.
    angle_deg : float, optional
        Maximum angle between a point's normal and its facet; 20 if omitted.
    max_distance_m : float, optional
        Maximum distance from the facet's plane; the local spacing of the points if omitted, or
        three times their local noise if that is more.
    min_points : int, optional
        Minimum number of points of a facet; 50 if omitted, or on a mesh 1 % of its area.
    min_area_m2 : float, optional
        Minimum area of a facet.
    min_coplanarity : float, optional
        Minimum of one over the smallest normalised eigenvalue; that of the verdict profile if
        omitted.
    propose_sets : bool
        Propose sets among the planes of the facets, as `vs.sets` does.
    preset : {"dse"}, optional
        First sets among the points, then their planes, with the defaults of the Discontinuity Set
        Extractor; `angle_deg` is then the cone about a set's pole (30), `min_points` 100.
    progress : callable or Progress, optional
        Called with (stage, steps done, all steps or None).
    cancel : vs.CancelToken, optional
        Stops the work.

    Returns
    -------
    Facets
        ``facets`` (number), ``table`` (DataFrame, columns of the orientation table and
        ``wkt``), ``coverage``, ``near_planar_share``, ``sets``, ``labels`` (int32 ``facet``
        and ``set`` of the model's points, -1 for none). Areas of clouds are those of their
        borders.

    Raises
    ------
    vs.errors.UsageError
        For invalid thresholds.
    vs.errors.GeometryError
        If the model has no surface.
    vs.errors.Cancelled

    Notes
    -----
    Source: region growing as in Wang et al. (2017), Computers & Geosciences 103, 100; the 30 %
    rule after Tavani et al., section 4.1.3; "dse" after Riquelme et al. (2014), Computers &
    Geosciences 68, 38.

    Examples
    --------
    >>> import numpy as np
    >>> import vomstudio as vs
    >>> a, b = np.meshgrid(np.arange(0, 4, 0.1), np.arange(0, 4, 0.1))
    >>> flat = np.zeros(a.size)
    >>> east = np.column_stack([flat, a.ravel(), b.ravel()])
    >>> north = np.column_stack([a.ravel() + 0.1, flat, b.ravel()])
    >>> facets = vs.facets(np.concatenate([east, north]))
    >>> facets.facets, sorted(facets.table["dip_deg"].round(3))
    (2, [90.0, 90.0])
    """
    from vomstudio.extraction.facet_options import FacetOptions
    from vomstudio.extraction.facet_search import search

    report = to_progress(progress, cancel)
    options = options_from_arguments(
        FacetOptions,
        angle_deg=angle_deg,
        max_distance_m=max_distance_m,
        min_points=min_points,
        min_area_m2=min_area_m2,
        min_coplanarity=min_coplanarity,
        propose_sets=propose_sets,
        preset=preset,
    )
    data, crs, _ = load_placed(model, "model")
    name = getattr(getattr(model, "path", None), "name", None) or ""
    result = search(data, options, model=name, frame=crs or "local", progress=report)
    warn(result.warnings)
    return _to_facets(result)


def _to_facets(result: FacetTable) -> Facets:
    from vomstudio.project.tables.orientation_table import COLUMNS

    table = frame(result.rows, COLUMNS)
    for column in result.more:
        table[column] = [row[column] for row in result.rows]
    return Facets(**vars(result), table=table)


def follow(
    model: Any,
    through: Any,
    *,
    cost: str | None = None,
    photo: str | Path | None = None,
    cameras: str | Path | None = None,
    onnx_model: str | Path | None = None,
    progress: Reported = None,
    cancel: CancelToken | None = None,
) -> FollowedTrace:
    """Follow a contact over a model, or in a photo of it, from way-point to way-point.

    A path in a photo is projected onto the model.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in World, metres.
    through : (3,) array
        (w, 3) way-points in World, at least two, in their order; with ``photo`` also (w, 2)
        columns and rows of it, the middle of its top-left pixel at (0.5, 0.5).
    cost : str, optional
        "colour" (like the colours at the way-points; the default), "dark", "light",
        "gradient" (edges of lightness), "curvature" (edges of the surface), "auto" (the one
        of these whose plane has the smallest stated error, or, if none is good, whose path
        the others confirm most; see ``tried``), the name of a field, whose low values are
        followed, or "onnx". In a photo one of the first four, "auto" or "onnx".
    photo : str or Path, optional
        Path of a photo of the model, at its full resolution; other photos beside it that
        show the place are compared.
    cameras : str or Path, optional
        File of the photos' poses and lenses in the frame of the model's file (cameras.json,
        COLMAP, Metashape XML ...); by default those beside the model.
    onnx_model : str or Path, optional
        For the cost "onnx": the file of a network, as in `vs.propose_traces`.
    progress : callable or Progress, optional
        Called with (stage, steps done, all steps or None).
    cancel : vs.CancelToken, optional
        Stops the work.

    Returns
    -------
    FollowedTrace
        Result with the names of the command: ``points`` (n, 3) every vertex of the path,
        World, m; ``length_m``; ``snap_m``, maximum distance of a way-point from the path;
        ``plane``, a dict of the orientation table's columns, None if undefined;
        ``warnings``. With ``photo`` also ``pixels`` (n, 2), ``voters`` (names of the other
        photos), ``seen`` and ``agreeing`` (n,): number of photos that could check a vertex,
        and that confirm it; ``agreeing_share``.

    Raises
    ------
    vs.errors.GeometryError
        For a way-point farther than ten resolutions from the model, and if the model is not
        connected between two, or the photo does not show it.
    vs.errors.UsageError
        For a cost that is not available.
    vs.errors.InputError
        For cameras or photos that cannot be read.

    Notes
    -----
    Source: least-cost paths as in Thiele et al. (2017), Solid Earth 8, 1241; Dijkstra (1959);
    traces of photos on models after Seers & Hodgetts (2016), Journal of Structural Geology 82,
    1.

    Examples
    --------
    A dark bed on a slope:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> import tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "slope.csv"
    >>> x, y = (a.ravel() for a in np.meshgrid(np.arange(0, 5, 0.05), np.arange(0, 5, 0.05)))
    >>> z = 0.5 * y + 0.3 * np.sin(3 * x)
    >>> grey = np.where(np.abs(z - 1.0) < 0.05, 10.0, 200.0)
    >>> rows = np.column_stack([x, y, z, grey])
    >>> np.savetxt(path, rows, delimiter=",", header="x,y,z,grey", comments="")
    >>> slope = vs.read(path, up="z", unit="m")
    >>> trace = vs.follow(slope, [[0.05, 1.9, 1.0], [4.9, 1.5, 1.0]], cost="grey")
    >>> bool(np.abs(trace.points[:, 2] - 1.0).max() < 0.06)
    True
    """
    from vomstudio.extraction.followed_trace import followed_trace
    from vomstudio.extraction.photo_trace import photo_trace
    from vomstudio.extraction.proposals.edge_photos import replace_by_edges
    from vomstudio.extraction.proposals.edge_pictures import EDGE_COST, colour_by_edges
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.io.models.opening import resolution
    from vomstudio.studio.jobs.edge_detection import open_edge_finder

    options = options_from_arguments(
        FollowOptions,
        cost=cost,
        photo=path_text(photo, "photo"),
        cameras=path_text(cameras, "cameras"),
        onnx_model=path_text(onnx_model, "onnx_model"),
    )
    report = to_progress(progress, cancel)
    source_model = model if is_array(model) else to_model(model)
    report.stage(tr("Following the contact"))
    with (
        open_edge_finder(options.onnx_model, report, cancel) as edges,
        arguments_named(FollowOptions),
    ):
        data, crs, _ = load_placed(source_model, "model")
        spacing = resolution(data)
        arguments: dict[str, Any] = {
            "cost": options.used_cost if edges is None else EDGE_COST,
            "called": "" if edges is None else options.used_cost,
            "resolution": spacing,
            "model": getattr(getattr(source_model, "path", None), "name", None) or "",
            "frame": crs or "local",
        }
        trace: FollowedTrace
        if options.photo is None:
            if edges is not None:
                data = colour_by_edges(data, spacing, *edges)
            trace = followed_trace(SurfaceGraph(data), points(through, "through"), **arguments)
        else:
            way_points = pixels_or_points(through, "through")
            photos = _photos(source_model, data, spacing, options.photo, options.cameras)
            if edges is not None:
                photos = replace_by_edges(photos, *edges)
            trace = photo_trace(SurfaceGraph(data), photos, way_points, **arguments)
    warn(trace.warnings)
    return trace


def _photos(
    model: Any, data: Any, spacing: float, photo: str, cameras: str | None
) -> CalibratedPhotos:
    from vomstudio.extraction.calibrated_photos import open_photos
    from vomstudio.io.photos.own_cameras.reading import find_own_cameras

    if cameras is None:
        path = getattr(model, "path", None)
        cameras_file = None if path is None else find_own_cameras(path)
        cameras = None if cameras_file is None else str(cameras_file)
    if cameras is None:
        raise UsageError(Finding("cameras.missing"), field="cameras")
    source = getattr(model, "_source", None)
    return open_photos(data, spacing, photo, cameras, None if source is None else source.to_world)
