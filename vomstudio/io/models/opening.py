"""Opening any model, and saying what is in it."""

from __future__ import annotations

import hashlib
import itertools
import os
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.memory_limit import limit_for_file
from vomstudio.core.files.regular import open_regular
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.threads import run_in_thread
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.model_transform import moved
from vomstudio.geometry.resolution import COUNTS, FewPoints, effective_resolution, resolving_points
from vomstudio.geometry.units import METRES
from vomstudio.io.gate.axes import choose_axes, require_crs, unreadable
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.reprojection import Reprojection
from vomstudio.io.gis.axis_units import (
    UNKNOWN,
    StatedAxes,
    refusal,
    unit_findings,
)
from vomstudio.io.gis.crs import sidecar_crs
from vomstudio.io.models.frames import frame_findings
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.models.registry import choose_reader, read_head
from vomstudio.io.photos.cameras_file import scale_known

HASH_BLOCK_BYTES = 4 * 1024 * 1024
SAMPLED_FACES = 200_000
SAMPLED_POINTS = 20_000
SAMPLED_PLACES = 1_000
WINDOWS = 16
FEW_POINTS = 300
MOST_FIELDS = 300


def read_model(
    path: str | Path, progress: Progress | None = None, options: FrameOptions = DEFAULT_FRAME
) -> LoadedModel:
    """Read the model in a file, by whichever reader knows it, in a metric frame.

    Damaged parts of the file are left out and reported in `warnings`. A CRS that neither options
    nor file name is taken from `NAME.prj` beside it. x, y and z are in one unit, that of the CRS's
    horizontal axes: heights in another one are converted, which is reported. `content_hash` is the
    sha256 of the file itself (of an OBJ file without its MTL and images: measurements depend on
    the geometry).

    Parameters
    ----------
    path : str or Path
    progress : Progress, optional
    options : FrameOptions
        Its CRS replaces the one that the file names; with `to_crs` the coordinates are converted.

    Raises
    ------
    InputError
        For a file that cannot be read, and for coordinates in degrees that are not converted.
    Cancelled
        Through `progress`.
    """
    loaded, refused = with_axes(_read(Path(path), progress), options)
    if refused is not None:
        raise InputError(refused, file=path, field="CRS")
    return loaded


def _read(path: Path, progress: Progress | None) -> LoadedModel:
    """As the reader gives it."""
    progress = progress or Silent()
    reader = choose_reader(path, read_head(path))
    is_stopped = threading.Event()
    # hashlib releases the GIL, and the file is read only once while it is in memory.
    content_hash = run_in_thread(file_hash, path, lambda: not is_stopped.is_set(), name="file hash")
    try:
        # Damaged files hold NaN of every kind; readers look for them themselves.
        with np.errstate(all="ignore"), limit_for_file(path):
            loaded = reader.read(path, progress)
    except MemoryError:
        is_stopped.set()
        raise InputError(Finding("file.exceeds-memory"), file=path) from None
    except BaseException:
        is_stopped.set()
        raise
    loaded = _with_fields_that_are_meant(loaded)
    return replace(loaded, path=path, content_hash=loaded.content_hash or content_hash.result())


def _with_fields_that_are_meant(loaded: LoadedModel) -> LoadedModel:
    """Each value of a point becomes a file of the project's cache."""
    fields = loaded.data.fields
    if len(fields) <= MOST_FIELDS:
        return loaded
    said = Finding("model.fields-limited", count=len(fields), limit=MOST_FIELDS)
    kept = dict(itertools.islice(fields.items(), MOST_FIELDS))
    return replace(
        loaded, data=replace(loaded.data, fields=kept), warnings=(*loaded.warnings, said)
    )


def file_hash(path: Path, wanted: Callable[[], bool] = lambda: True) -> str:
    """Compute the SHA-256 of a file in hex; of a part of it if it is no longer `wanted`.

    Raises InputError if the file cannot be read.
    """
    total = hashlib.sha256()
    try:
        with open_regular(path) as file:
            while wanted() and (block := file.read(HASH_BLOCK_BYTES)):
                total.update(block)
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    return total.hexdigest()


def resolution(data: Mesh | PointCloud) -> float:
    """Effective resolution in units of the file: the larger of mean spacing and noise, see
    `geometry.resolution` (points that stand twice count once), and of the mean edge of a mesh; of a
    mesh that was subdivided, as it was before.

    Of big models a sample is taken: every k-th face; all points within windows around points spread
    over the file. NaN where there is none (one point).
    """
    of_points = _of_cloud(resolving_points(data))
    if not isinstance(data, Mesh):
        return of_points
    edge = point_spacing(data.undivided)
    # Of few vertices neither density nor noise can be told.
    few = len(data.undivided.vertices) < COUNTS[0]
    return edge if few or np.isnan(of_points) else max(edge, of_points)


def point_spacing(data: Mesh | PointCloud) -> float:
    """How far drawn points must reach to meet: of a mesh the mean edge length, of a cloud the mean
    distance from a point to its nearest neighbour, in units of the file; NaN where there is
    none."""
    if isinstance(data, Mesh):
        step = max(1, len(data.faces) // SAMPLED_FACES)
        corners = data.vertices[data.faces[::step]]
        edges = corners - np.roll(corners, 1, axis=1)
        lengths = np.sqrt(np.einsum("ijk,ijk->ij", edges, edges))
        return float(lengths[lengths > 0].mean()) if np.any(lengths > 0) else float("nan")
    return _point_spacing(data.points)


def _point_spacing(points: FloatArray) -> float:
    n = len(points)
    if n < 2:
        return float("nan")
    if n <= FEW_POINTS:
        return _mean_of(_nearest_of_few(points - points[0]))
    from scipy.spatial import cKDTree

    if n <= 10 * SAMPLED_POINTS:
        local = points - points[0]
        return _mean_nearest(cKDTree(local), local[:: max(1, n // SAMPLED_POINTS)])
    rough = _rough_spacing(points)
    if not np.isfinite(rough) or rough <= 0:
        return float("nan")
    half = 15.0 * rough
    found: list[FloatArray] = []
    for local in _windows(points, half):
        inner = local[(np.abs(local) <= 0.6 * half).all(axis=1)]
        distance, _ = cKDTree(local).query(inner, k=min(4, len(local)))
        found.append(_first_positive(distance))
    distances = np.concatenate(found) if found else np.empty(0)
    distances = distances[np.isfinite(distances)]
    return float(distances.mean()) if len(distances) else float(rough)


def _windows(points: FloatArray, half: float) -> Iterator[FloatArray]:
    """The points of boxes around some points of the cloud, less these; `half` : of a box's side.
    Boxes of a single point are left out."""
    # Gone through once for every window: several times as fast on its own.
    x = np.ascontiguousarray(points[:, 0])
    for row in np.linspace(0, len(points) - 1, WINDOWS).astype(np.int64):
        centre = points[row]
        near = np.flatnonzero((x >= centre[0] - half) & (x <= centre[0] + half))
        local = points[near] - centre
        local = local[(np.abs(local[:, 1:]) <= half).all(axis=1)]
        if len(local) > 1:
            yield local


def _rough_spacing(points: FloatArray) -> float:
    """By a thinned cloud: points lie on a surface, so spacing goes with the root of their
    number."""
    from scipy.spatial import cKDTree

    step = len(points) // SAMPLED_POINTS
    thin = np.ascontiguousarray(points[::step]) - points[0]
    return float(_mean_nearest(cKDTree(thin), thin) / np.sqrt(step))


def _of_cloud(points: FloatArray) -> float:
    n = len(points)
    if n < 2:
        return float("nan")
    if n <= FEW_POINTS:
        local = points - points[0]
        found = effective_resolution(local, FewPoints(local), local)
        return float("nan") if found is None else found
    from scipy.spatial import cKDTree

    if n <= 10 * SAMPLED_POINTS:
        local = points - points[0]
        found = effective_resolution(local, cKDTree(local), local[:: max(1, n // SAMPLED_PLACES)])
        return float("nan") if found is None else found
    spacing = _rough_spacing(points)
    if not np.isfinite(spacing) or spacing <= 0:
        return float("nan")
    # Some thousand points, of which the inner ones have all their neighbours there.
    half = 30.0 * spacing
    found_there = []
    for local in _windows(points, half):
        inner = local[(np.abs(local) <= 0.4 * half).all(axis=1)]
        inner = inner[:: max(1, len(inner) // (SAMPLED_PLACES // WINDOWS))]
        one = effective_resolution(local, cKDTree(local), inner)
        if one is not None:
            found_there.append(one)
    return float(np.median(found_there)) if found_there else float(spacing)


def _mean_nearest(tree: object, queries: FloatArray) -> float:
    k = min(4, tree.n)  # type: ignore[attr-defined]
    distance, _ = tree.query(queries, k=k)  # type: ignore[attr-defined]
    return _mean_of(distance)


def _nearest_of_few(local: FloatArray) -> FloatArray:
    """What a tree would say, to the bit, without the import of scipy, which takes longer."""
    x, y, z = (local[:, None, j] - local[None, :, j] for j in range(3))
    return np.sort(np.sqrt(x * x + y * y + z * z), axis=1)[:, :4]


def _mean_of(distance: FloatArray) -> float:
    nearest = _first_positive(distance)
    nearest = nearest[np.isfinite(nearest)]
    return float(nearest.mean()) if len(nearest) else float("nan")


def _first_positive(distance: FloatArray) -> FloatArray:
    """The nearest neighbour that is another place; NaN where all that were asked for are the
    same."""
    positive = distance > 0
    nearest = distance[np.arange(len(distance)), positive.argmax(axis=1)]
    return np.where(positive.any(axis=1), nearest, np.nan)


def with_axes(
    loaded: LoadedModel, options: FrameOptions = DEFAULT_FRAME
) -> tuple[LoadedModel, Finding | None]:
    """Settle the CRS of what a reader returned, with x, y, z in one unit.

    Returns
    -------
    loaded : LoadedModel
    refused : Finding or None
        Why the data cannot be used as a model.
    """
    messages: list[Finding] = list(loaded.warnings)
    axes = _axes(loaded, options, messages)
    if axes.kind == "none" and loaded.units != UNKNOWN:
        axes = replace(axes, units=loaded.units, unit_m=METRES.get(loaded.units[0]))
    if options.to_crs is not None and not axes.unusual_directions:
        return _reprojected(loaded, axes, options, messages), None
    refused = refusal(axes, loaded.data.bounds)
    messages += unit_findings(axes) if refused is None else ()
    named = axes.kind not in ("none", "local") and refused is None
    if axes.crs is None and named and not axes.unusual_directions:
        messages.append(unreadable(loaded.path, loaded.crs or axes.kind))
    data = _scaled(loaded.data, axes)
    unit_m = 1.0 if axes.kind == "local" and axes.unit_m else axes.unit_m
    settled = replace(
        loaded, data=data, crs=axes.crs, warnings=tuple(messages), units=axes.units, unit_m=unit_m
    )
    return settled, refused


def _axes(loaded: LoadedModel, options: FrameOptions, messages: list[Finding]) -> StatedAxes:
    """Return the axes by the options, else the file, else the file beside it."""
    text = loaded.crs
    if text is None:
        text, problem = sidecar_crs(loaded.path, np.asarray(loaded.data.bounds, np.float64))
        if problem is not None and options.crs is None:
            messages.append(problem)
    axes, findings = choose_axes(text, options, file=loaded.path, height_unit=loaded.height_unit)
    messages += findings
    return axes


def _reprojected(
    loaded: LoadedModel, axes: StatedAxes, options: FrameOptions, messages: list[Finding]
) -> LoadedModel:
    """Return the model with its coordinates converted to another CRS, in metres."""
    assert options.to_crs is not None
    conversion = Reprojection.create(
        require_crs(axes, loaded.path), options.to_crs, height_factor=axes.metres[2]
    )
    data, turned = loaded.data, loaded.turned_about
    if options.up == "y" and turned is None:
        data, turned = moved(data, Frame(up_axis="y").to_world()), (0.0, 0.0, 0.0)
    if isinstance(data, Mesh):
        data = replace(data, vertices=conversion.apply(data.vertices))
    else:
        normals = data.normals
        if normals is not None:
            # A normal is perpendicular to the surface: it goes through the inverse transpose.
            middle = np.asarray(data.bounds, np.float64).mean(axis=0)
            normals = normals @ np.linalg.inv(conversion.jacobian(middle))
            normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
            normals = np.ascontiguousarray(normals, np.float32)
        points = conversion.apply(data.points)
        data = replace(data, points=points, normals=normals, arrangement=None)
    messages.append(conversion.finding)
    return replace(
        loaded,
        data=data,
        crs=conversion.target,
        warnings=tuple(messages),
        units=axes.units,
        unit_m=1.0,
        turned_about=turned,
    )


def _scaled(data: Mesh | PointCloud, axes: StatedAxes) -> Mesh | PointCloud:
    """With heights in the unit of x and y; all in metres where the CRS is a local one."""
    flat, high = axes.unit_factor, axes.unit_factor * axes.height_factor
    if flat == high == 1.0:
        return data
    factors = np.array([flat, flat, high])
    if isinstance(data, Mesh):
        return replace(data, vertices=data.vertices * factors)
    normals = data.normals
    if normals is not None and flat != high:
        # A plane stretched along z has the normal of the inverse stretch.
        turned = normals / factors
        length = np.sqrt(np.einsum("ij,ij->i", turned, turned))[:, None]
        normals = np.where(length > 0, turned / np.where(length > 0, length, 1.0), normals)
        normals = np.ascontiguousarray(normals, np.float32)
    return replace(data, points=data.points * factors, normals=normals, arrangement=None)


def describe(
    path: str | Path, progress: Progress | None = None, options: FrameOptions = DEFAULT_FRAME
) -> dict[str, object]:
    """What is in a model, in the words of the command line's `info`; safe for JSON.

    `points` counts vertices of a mesh as the file's surface needs them (a vertex with two texture
    coordinates counts twice). `bounds` are in metres where the unit of x and y is known (World),
    else as the file has them; `units` are the file's own. Raises InputError.
    """
    loaded, refused = with_axes(_read(Path(path), progress), options)
    data = loaded.data
    spacing = resolution(data)
    mesh = data if isinstance(data, Mesh) else None
    fields = list(data.fields)
    if data.colors is not None:
        fields.insert(0, "rgb")
    if isinstance(data, PointCloud) and data.normals is not None:
        fields.insert(0, "normals")
    noticed = [refused] if refused else frame_findings(loaded, options)
    units, metres = loaded.units, loaded.unit_m
    if units == UNKNOWN and scale_known(loaded.path):
        units, metres = ("m", "m", "m"), 1.0
    shown = spacing if np.isfinite(spacing) else None
    size: dict[str, float | None] = {"resolution_m": None, "resolution": shown}
    if metres:
        size = {"resolution_m": None if shown is None else shown * metres}
    return {
        "path": os.fspath(loaded.path),
        "kind": loaded.kind,
        "points": len(mesh.vertices) if mesh else len(data.points),  # type: ignore[union-attr]
        "faces": len(mesh.faces) if mesh else 0,
        "materials": [m.name for m in mesh.materials] if mesh else [],
        "textures": [
            os.fspath(t) for t in dict.fromkeys(m.texture for m in mesh.materials) if t is not None
        ]
        if mesh
        else [],
        "bounds": (data.bounds * (metres or 1.0)).tolist(),
        "crs": loaded.crs,
        "units": list(units),
        **size,
        "fields": fields,
        "warnings": [*loaded.warnings, *noticed],
        "content_hash": loaded.content_hash,
    }
