"""Opening any model, and saying what is in it."""

from __future__ import annotations

import hashlib
import os
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.crs import sidecar_crs
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.models.registry import choose_reader, read_head
from vomstudio.progress import Progress, Silent
from vomstudio.words import tr

HASH_BLOCK_BYTES = 4 * 1024 * 1024
SAMPLED_FACES = 200_000
SAMPLED_POINTS = 20_000
WINDOWS = 16
FEW_POINTS = 300


def read_model(path: str | Path, progress: Progress | None = None) -> LoadedModel:
    """The model in a file, by whichever reader knows it.

    What is unsound in the file is left out and said in `warnings`. A CRS that the file does not
    name is taken from `NAME.prj` beside it. `content_hash` is the sha256 of
    the file itself (of an OBJ file without its MTL and images: geometry is what measurements hang
    on). Raises InputError, or Cancelled through `progress`.
    """
    path = Path(path)
    progress = progress or Silent()
    reader = choose_reader(path, read_head(path))
    hasher = _Hasher(path)
    hasher.start()
    try:
        # Damaged files hold NaN of every kind; readers look for them themselves.
        with np.errstate(all="ignore"):
            loaded = reader.read(path, progress)
    except MemoryError:
        hasher.stop()
        raise InputError(
            tr("The model is larger than the free memory. Divide it into tiles."), file=path
        ) from None
    except BaseException:
        hasher.stop()
        raise
    crs, warnings = loaded.crs, loaded.warnings
    if crs is None:
        crs, problem = sidecar_crs(path)
        warnings = (*warnings, problem) if problem else warnings
    return LoadedModel(
        loaded.data,
        loaded.kind,
        crs,
        warnings,
        path,
        loaded.content_hash or hasher.result(),
        loaded.turned_about,
    )


def file_hash(path: Path, wanted: Callable[[], bool] = lambda: True) -> str:
    """sha256 of a file in hex; senseless where it is no longer `wanted`. Raises InputError where it
    cannot be read."""
    hasher = _Hasher(path, wanted)
    hasher.run()
    return hasher.result()


class _Hasher(threading.Thread):
    """sha256 beside the reading: hashlib lets go of the GIL, and the file is in memory then."""

    def __init__(self, path: Path, wanted: Callable[[], bool] = lambda: True) -> None:
        super().__init__(daemon=True)
        self._path, self._wanted = path, wanted
        self._stopped = False
        self._digest = ""
        self._error: OSError | None = None

    def run(self) -> None:
        total = hashlib.sha256()
        try:
            with open(self._path, "rb") as file:
                while (
                    not self._stopped and self._wanted() and (block := file.read(HASH_BLOCK_BYTES))
                ):
                    total.update(block)
        except OSError as error:
            self._error = error
        self._digest = total.hexdigest()

    def stop(self) -> None:
        self._stopped = True

    def result(self) -> str:
        if self.is_alive():
            self.join()
        if self._error is not None:
            raise InputError(
                tr("The file cannot be read ({reason}).", reason=self._error.strerror),
                file=self._path,
            )
        return self._digest


def resolution(data: Mesh | PointCloud) -> float:
    """Mean spacing in units of the file: of a mesh the mean edge length, of a cloud the mean
    distance from a point to its nearest neighbour (points that stand twice not counted).

    Of big models a sample is taken: every k-th face; all points within windows around points spread
    over the file. NaN where there is no spacing (one point).
    """
    if isinstance(data, Mesh):
        step = max(1, len(data.faces) // SAMPLED_FACES)
        corners = data.vertices[data.faces[::step]]
        edges = corners - np.roll(corners, 1, axis=1)
        lengths = np.sqrt(np.einsum("ijk,ijk->ij", edges, edges))
        return float(lengths[lengths > 0].mean()) if np.any(lengths > 0) else float("nan")
    return _point_spacing(data.points)


def _point_spacing(points: npt.NDArray[np.float64]) -> float:
    n = len(points)
    if n < 2:
        return float("nan")
    if n <= FEW_POINTS:
        return _mean_of(_nearest_of_few(points - points[0]))
    from scipy.spatial import cKDTree

    if n <= 10 * SAMPLED_POINTS:
        local = points - points[0]
        return _mean_nearest(cKDTree(local), local[:: max(1, n // SAMPLED_POINTS)])
    # The spacing of a thinned cloud tells how large a window holds some hundred points of the full
    # one (points lie on a surface, so spacing goes with the root of their number).
    step = n // SAMPLED_POINTS
    thin = np.ascontiguousarray(points[::step]) - points[0]
    rough = _mean_nearest(cKDTree(thin), thin) / np.sqrt(step)
    if not np.isfinite(rough) or rough <= 0:
        return float("nan")
    half = 15.0 * rough
    found: list[npt.NDArray[np.float64]] = []
    # Gone through once for every window: several times as fast on its own.
    x = np.ascontiguousarray(points[:, 0])
    for row in np.linspace(0, n - 1, WINDOWS).astype(np.int64):
        centre = points[row]
        near = np.flatnonzero((x >= centre[0] - half) & (x <= centre[0] + half))
        local = points[near] - centre
        local = local[(np.abs(local[:, 1:]) <= half).all(axis=1)]
        if len(local) < 2:
            continue
        inner = local[(np.abs(local) <= 0.6 * half).all(axis=1)]
        distance, _ = cKDTree(local).query(inner, k=min(4, len(local)))
        found.append(_first_positive(distance))
    distances = np.concatenate(found) if found else np.empty(0)
    distances = distances[np.isfinite(distances)]
    return float(distances.mean()) if len(distances) else float(rough)


def _mean_nearest(tree: object, queries: npt.NDArray[np.float64]) -> float:
    k = min(4, tree.n)  # type: ignore[attr-defined]
    distance, _ = tree.query(queries, k=k)  # type: ignore[attr-defined]
    return _mean_of(distance)


def _nearest_of_few(local: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """What a tree would say, to the bit, without the import of scipy, which takes longer."""
    x, y, z = (local[:, None, j] - local[None, :, j] for j in range(3))
    return np.sort(np.sqrt(x * x + y * y + z * z), axis=1)[:, :4]


def _mean_of(distance: npt.NDArray[np.float64]) -> float:
    nearest = _first_positive(distance)
    nearest = nearest[np.isfinite(nearest)]
    return float(nearest.mean()) if len(nearest) else float("nan")


def _first_positive(distance: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The nearest neighbour that is another place; NaN where all that were asked for are the
    same."""
    positive = distance > 0
    nearest = distance[np.arange(len(distance)), positive.argmax(axis=1)]
    return np.where(positive.any(axis=1), nearest, np.nan)


def describe(path: str | Path, progress: Progress | None = None) -> dict[str, object]:
    """What is in a model, in the words of the command line's `info`; safe for JSON.

    `points` counts vertices of a mesh as the file's surface needs them (a vertex with two texture
    coordinates counts twice). Raises InputError.
    """
    loaded = read_model(path, progress)
    data = loaded.data
    spacing = resolution(data)
    mesh = data if isinstance(data, Mesh) else None
    fields = list(data.fields)
    if data.colors is not None:
        fields.insert(0, "rgb")
    if isinstance(data, PointCloud) and data.normals is not None:
        fields.insert(0, "normals")
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
        "bounds": [[float(x) for x in corner] for corner in data.bounds],
        "crs": loaded.crs,
        "resolution_m": spacing if np.isfinite(spacing) else None,
        "fields": fields,
        "warnings": list(loaded.warnings),
        "content_hash": loaded.content_hash,
    }
