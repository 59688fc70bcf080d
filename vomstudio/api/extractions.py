"""Extraction of facets and of lines that follow a contact from models."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from vomstudio.api.checking import (
    path_text,
    warn,
)
from vomstudio.api.comparisons import is_array, load_world_data
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.models import to_model
from vomstudio.api.point_arguments import pixels_or_points, points
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.api.tables import frame
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import CancelToken
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.words import tr
from vomstudio.extraction.facet_table import FacetTable
from vomstudio.extraction.followed_trace import FollowedTrace
from vomstudio.extraction.trace_options import FollowOptions

if TYPE_CHECKING:
    import pandas

    from vomstudio.api.argument_types import ModelArgument, VerticesArgument
    from vomstudio.extraction.calibrated_photos import CalibratedPhotos


@dataclass(frozen=True, eq=False, repr=False)
class Facets(FacetTable):
    """Facets of a model, with the names used by the command.

    Attributes
    ----------
    facets : int
        Number of facets.
    table : DataFrame
        Columns of the orientation table and `wkt` (the border in the World frame), with one row
        per facet. The id of a facet is its label.
    coverage, near_planar_share : float or None
        Area of the facets as a share of the model area, and of the area of exposed rock.
    level_share : float or None
        Share of the exposed rock in facets that dip by less than 10 degrees.
    sets, discontinuities
        Sets and discontinuities as returned by `vs.sets`, if requested.
    labels : dict
        {"facet": (n,), "set": (n,)} int32 labels of the model points; -1 outside facets or sets.
    """

    table: pandas.DataFrame = field(default=None, metadata=HIDDEN_IN_JSON)


def facets(
    model: ModelArgument,
    *,
    angle_deg: float | None = None,
    max_distance_m: float | None = None,
    min_points: int | None = None,
    min_area_m2: float | None = None,
    min_coplanarity: float | None = None,
    propose_sets: bool = False,
    preset: Literal["dse"] | None = None,
    progress: ProgressArgument = None,
    cancel: CancelToken | None = None,
) -> Facets:
    """Find the planar facets of an outcrop, and fit and assess each of them as a patch.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or array (n, 3) of points
        Model in the World frame, metres.
    angle_deg : float, optional
        Maximum angle between the normal of a point and its facet; by default 20.
    max_distance_m : float, optional
        Maximum distance from the plane of the facet; by default the larger of the local point
        spacing and three times the local noise.
    min_points : int, optional
        Minimum number of points of a facet; by default 50, or 1 % of the area for a mesh.
    min_area_m2 : float, optional
        Minimum area of a facet.
    min_coplanarity : float, optional
        Minimum inverse of the smallest normalised eigenvalue; by default the limit of the verdict
        profile.
    propose_sets : bool
        Whether to propose sets among the planes of the facets, as `vs.sets` does.
    preset : {"dse"}, optional
        Find sets among the points first, and then their planes, with the defaults of the
        Discontinuity Set Extractor. `angle_deg` is then the half-angle of the cone about the pole
        of a set (30), and `min_points` is 100.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).
    cancel : vs.CancelToken, optional
        Token that stops the computation.

    Returns
    -------
    Facets
        ``facets`` (number), ``table`` (DataFrame, columns of the orientation table and
        ``wkt``), ``coverage``, ``near_planar_share``, ``sets``, ``labels`` (int32 ``facet``
        and ``set`` of each point of the model; -1 outside). For clouds, the area of a facet is
        the area inside its border.

    Raises
    ------
    vs.errors.UsageError
        If a threshold is invalid, or a distance is combined with the preset.
    vs.errors.GeometryError
        If the model has no surface.
    vs.errors.Cancelled
        If the computation was stopped by ``cancel``.

    Notes
    -----
    Source: region growing as in Wang et al. (2017), Computers & Geosciences 103, 100; the warning
    for a ``near_planar_share`` below 30 % after Tavani et al., section 4.1.3; "dse" after Riquelme
    et al. (2014), Computers & Geosciences 68, 38.

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
    from vomstudio.extraction.facet_search import search_facets

    report = to_progress(progress, cancel)
    options = options_from_arguments(FacetOptions, locals())
    data, crs, _ = load_world_data(model, "model")
    name = getattr(getattr(model, "path", None), "name", None) or ""
    result = search_facets(data, options, model=name, frame=crs or "local", progress=report)
    warn(result.warnings)
    return _to_facets(result)


def _to_facets(result: FacetTable) -> Facets:
    from vomstudio.project.tables.orientation_table import COLUMNS

    table = frame(result.rows, COLUMNS)
    for column in result.more:
        table[column] = [row[column] for row in result.rows]
    return Facets(**vars(result), table=table)


def follow(
    model: ModelArgument,
    through: VerticesArgument,
    *,
    cost: str | None = None,
    photo: str | Path | None = None,
    cameras: str | Path | None = None,
    onnx_model: str | Path | None = None,
    progress: ProgressArgument = None,
    cancel: CancelToken | None = None,
) -> FollowedTrace:
    """Follow a contact between way-points on a model, or in a photo of the model.

    A path in a photo is projected onto the model.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in the World frame, metres.
    through : (w, 3) or (w, 2) array
        At least two way-points (w, 3) in the World frame, in order along the contact. With
        ``photo``, also columns and rows (w, 2) in the photo, with the centre of the top-left
        pixel at (0.5, 0.5).
    cost : str, optional
        "colour" (similarity to the colours at the way-points; the default), "dark", "light",
        "gradient" (edges of lightness), "curvature" (edges of the surface), the name of a
        field whose low values are followed, or "onnx". "auto" selects the cost whose plane
        has the smallest stated error or, if no plane is good, whose path agrees best with
        the others; see ``tried``. In a photo, only the first four, "auto" and "onnx" are
        available.
    photo : str or Path, optional
        Path of a photo of the model at full resolution. Other photos in the same folder that
        show the contact are used for comparison.
    cameras : str or Path, optional
        File with the poses and lenses of the photos in the file frame of the model
        (such as cameras.json, COLMAP or Metashape XML); by default the file next to the model.
    onnx_model : str or Path, optional
        File of the network for the cost "onnx"; see `vs.propose_traces`.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).
    cancel : vs.CancelToken, optional
        Token that stops the computation.

    Returns
    -------
    FollowedTrace
        Result with the names used by the command: ``points`` (n, 3), all vertices of the
        path in the World frame, m; ``length_m``; ``snap_m``, maximum distance of a way-point
        from the path; ``plane``, a dict of the columns of the orientation table, or None if
        undefined; ``warnings``. With ``photo``, also ``pixels`` (n, 2); ``voters``, the
        names of the other photos; ``seen`` and ``agreeing`` (n,), the number of photos that
        show a vertex and that confirm it; ``agreeing_share``.

    Raises
    ------
    vs.errors.GeometryError
        If a way-point is farther from the model than ten times its resolution, the model is
        not connected between two way-points, or the photo does not show the model.
    vs.errors.UsageError
        If the cost is not available, or no cameras are found for the photo.
    vs.errors.InputError
        If the cameras or photos cannot be read.

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
        name_arguments_in_errors(FollowOptions),
    ):
        data, crs, _ = load_world_data(source_model, "model")
        spacing = resolution(data)
        arguments: dict[str, Any] = {
            "cost": options.used_cost if edges is None else EDGE_COST,
            "name": "" if edges is None else options.used_cost,
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
            waypoints = pixels_or_points(through, "through")
            photos = _open_photos(source_model, data, spacing, options.photo, options.cameras)
            if edges is not None:
                photos = replace_by_edges(photos, *edges)
            trace = photo_trace(SurfaceGraph(data), photos, waypoints, **arguments)
    warn(trace.warnings)
    return trace


def _open_photos(
    model: Any, data: Any, spacing: float, photo: str, cameras: str | None
) -> CalibratedPhotos:
    from vomstudio.extraction.calibrated_photos import open_photos
    from vomstudio.io.photos.own_cameras.reading import find_camera_file

    if cameras is None:
        path = getattr(model, "path", None)
        cameras_file = None if path is None else find_camera_file(path)
        cameras = None if cameras_file is None else str(cameras_file)
    if cameras is None:
        raise UsageError(Finding("cameras.missing"), field="cameras")
    source = getattr(model, "_source", None)
    return open_photos(data, spacing, photo, cameras, None if source is None else source.to_world)
