"""A model that wears the edges which a network finds in its pictures: the more likely an edge, the
darker. So whatever follows or looks for what is dark follows edges, at the pictures' resolution."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.files.untrusted.pictures import open_picture
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

DRAWN = "dark"
"""By which such a model is looked at."""

Find = Callable[[Sequence[Path], Path], Sequence[Path]]
"""Takes pictures and a folder, and gives the pictures of their edges in it."""

_MOST_SIDE = 8000
# Of the usual spacing of points: a pixel of the picture of a cloud, and how far behind the nearest
# point of a pixel others are seen too.
_PIXEL, _BEHIND = 1.0, 6.0


def write_edges(
    network: Path, pictures: Sequence[Path], folder: Path, progress: Progress
) -> list[Path]:
    """Grey pictures of 255 (1 - probability) in a folder. Raises InputError for a network or a
    picture that cannot be read, Cancelled."""
    from PIL import Image

    from vomstudio.extraction.proposals.edge_network import EdgeNetwork
    from vomstudio.io.photos.pixels import open_photo

    net = EdgeNetwork(network)
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    for number, path in enumerate(pictures):
        with open_photo(path) as image:
            pixels = np.asarray(image.convert("RGB"))
        found = net.probability(pixels, progress)
        out = folder / f"edges_{number}.png"
        Image.fromarray(np.round(255.0 * (1.0 - found)).astype(np.uint8)).save(out)
        made.append(out)
    return made


def wearing_edges(
    data: Mesh | PointCloud, spacing: float, find: Find, folder: Path
) -> Mesh | PointCloud:
    """The model with its textures, or else the colours of its points, taken for those of edges.

    spacing : usual, of its points; find : by which edges are found; folder : for pictures
    Raises UsageError for a model without colours, and what `find` raises.
    """
    if isinstance(data, Mesh) and data.colors is None:
        worn = [m.texture for m in data.materials if m.texture is not None]
        if data.uv is not None and worn:
            made = iter(find(worn, folder))
            materials = tuple(
                m if m.texture is None else replace(m, texture=next(made)) for m in data.materials
            )
            return replace(data, materials=materials)
    if data.colors is None:
        raise UsageError(
            Finding("model.no-colours"),
            field="--cost",
        )
    points = data.vertices if isinstance(data, Mesh) else data.points
    grey = _edges_of_points(points, data.colors, spacing, find, folder)
    return replace(data, colors=np.repeat(grey[:, None], 3, axis=1))


def _edges_of_points(
    points: FloatArray, colours: ByteArray, spacing: float, find: Find, folder: Path
) -> ByteArray:
    """(n,) of points, seen at right angles to the plane in which they lie as a whole, from above
    or from outside; 255, which is no edge, for those that others hide there."""
    from PIL import Image
    from scipy.ndimage import distance_transform_edt

    sound = np.flatnonzero(np.isfinite(points).all(axis=1))
    local = points[sound] - points[sound].mean(axis=0)
    axes = np.linalg.svd(local[:: max(1, len(local) // 20_000)], full_matrices=False)[2]
    across, normal = axes[:2], axes[2] if axes[2][2] >= 0.0 else -axes[2]
    flat, depth = local @ across.T, local @ normal
    low = flat.min(axis=0)
    pixel = max(_PIXEL * spacing, float(np.ptp(flat, axis=0).max()) / (_MOST_SIDE - 1))
    column, row = np.floor((flat - low) / pixel).astype(np.int64).T
    shape = int(row.max()) + 1, int(column.max()) + 1
    order = np.argsort(depth, kind="stable")
    picture = np.zeros((*shape, 3), np.uint8)
    nearest = np.full(shape, -np.inf)
    # The last one that is written is the nearest to whoever looks.
    picture[row[order], column[order]] = colours[sound[order]]
    nearest[row[order], column[order]] = depth[order]
    gaps = ~np.isfinite(nearest)
    at = distance_transform_edt(gaps, return_distances=False, return_indices=True)
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "points.png"
    Image.fromarray(np.asarray(picture[tuple(at)])).save(file)
    (made,) = find([file], folder)
    with open_picture(made) as image:
        edges = np.asarray(image.convert("L"))
    found = np.full(len(points), 255, np.uint8)
    seen = depth >= nearest[row, column] - _BEHIND * spacing
    found[sound[seen]] = edges[row[seen], column[seen]]
    return found
