"""Models coloured by the edges that a network detects in their pictures.

The higher the edge probability, the darker the colour. Following dark lines therefore follows edges
at the resolution of the pictures.
"""

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

EDGE_COST = "dark"
"""Cost with which edges are followed on such a model."""

EdgeDetector = Callable[[Sequence[Path], Path], Sequence[Path]]
"""Function that writes the edges in pictures to a folder and returns the paths of the results."""

_MAX_SIDE_PX = 8000
# Pixel size of the picture of a cloud, and depth range of the points visible in a pixel, in typical
# point spacings.
_PIXEL_SIZE_SPACINGS, _DEPTH_RANGE_SPACINGS = 1.0, 6.0


def write_edges(
    network: Path, pictures: Sequence[Path], folder: Path, progress: Progress
) -> list[Path]:
    """Write grey pictures of the detected edges, with values 255 (1 - probability).

    Parameters
    ----------
    network : Path
        ONNX file.
    pictures : sequence of Path
    folder : Path
    progress : Progress

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        If the network or a picture cannot be read, or if the output of the network is invalid.
    Cancelled
        Through `progress`.
    """
    from PIL import Image

    from vomstudio.extraction.proposals.edge_network import EdgeNetwork
    from vomstudio.io.photos.pixels import open_photo

    net = EdgeNetwork(network)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for number, path in enumerate(pictures):
        with open_photo(path) as image:
            pixels = np.asarray(image.convert("RGB"))
        probabilities = net.compute_probability(pixels, progress)
        out = folder / f"edges_{number}.png"
        Image.fromarray(np.round(255.0 * (1.0 - probabilities)).astype(np.uint8)).save(out)
        paths.append(out)
    return paths


def colour_by_edges(
    data: Mesh | PointCloud, spacing: float, find_edges: EdgeDetector, folder: Path
) -> Mesh | PointCloud:
    """Replace the textures of a model, or the colours of its points, with detected edges.

    Parameters
    ----------
    data : Mesh or PointCloud
    spacing : float
        Typical spacing of the points, in the unit of their coordinates.
    find_edges : callable
        Edge detector; its errors are propagated.
    folder : Path
        Folder for the pictures.

    Returns
    -------
    Mesh or PointCloud

    Raises
    ------
    UsageError
        If the model has no colours.
    """
    if isinstance(data, Mesh) and data.colors is None:
        textures = [m.texture for m in data.materials if m.texture is not None]
        if data.uv is not None and textures:
            edge_textures = iter(find_edges(textures, folder))
            materials = tuple(
                m if m.texture is None else replace(m, texture=next(edge_textures))
                for m in data.materials
            )
            return replace(data, materials=materials)
    if data.colors is None:
        raise UsageError(
            Finding("model.no-colours"),
            field="--cost",
        )
    points = data.vertices if isinstance(data, Mesh) else data.points
    grey = _detect_point_edges(points, data.colors, spacing, find_edges, folder)
    return replace(data, colors=np.repeat(grey[:, None], 3, axis=1))


def _detect_point_edges(
    points: FloatArray, colours: ByteArray, spacing: float, find_edges: EdgeDetector, folder: Path
) -> ByteArray:
    """Return the grey values (n,) of edges at points, seen perpendicular to their plane.

    The plane is fitted to all points and is seen from above. The value of hidden points is 255 (no
    edge).
    """
    from PIL import Image
    from scipy.ndimage import distance_transform_edt

    finite_indices = np.flatnonzero(np.isfinite(points).all(axis=1))
    local_points = points[finite_indices] - points[finite_indices].mean(axis=0)
    axes = np.linalg.svd(local_points[:: max(1, len(local_points) // 20_000)], full_matrices=False)[
        2
    ]
    plane_axes, normal = axes[:2], axes[2] if axes[2][2] >= 0.0 else -axes[2]
    plane_coordinates, depth = local_points @ plane_axes.T, local_points @ normal
    low = plane_coordinates.min(axis=0)
    pixel_size = max(
        _PIXEL_SIZE_SPACINGS * spacing,
        float(np.ptp(plane_coordinates, axis=0).max()) / (_MAX_SIDE_PX - 1),
    )
    column, row = np.floor((plane_coordinates - low) / pixel_size).astype(np.int64).T
    shape = int(row.max()) + 1, int(column.max()) + 1
    order = np.argsort(depth, kind="stable")
    picture = np.zeros((*shape, 3), np.uint8)
    nearest_depths = np.full(shape, -np.inf)
    # Write points from back to front, so that the nearest point remains.
    picture[row[order], column[order]] = colours[finite_indices[order]]
    nearest_depths[row[order], column[order]] = depth[order]
    is_empty = ~np.isfinite(nearest_depths)
    position = distance_transform_edt(is_empty, return_distances=False, return_indices=True)
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "points.png"
    Image.fromarray(np.asarray(picture[tuple(position)])).save(file)
    (edge_picture,) = find_edges([file], folder)
    with open_picture(edge_picture) as image:
        edges = np.asarray(image.convert("L"))
    values = np.full(len(points), 255, np.uint8)
    is_visible = depth >= nearest_depths[row, column] - _DEPTH_RANGE_SPACINGS * spacing
    values[finite_indices[is_visible]] = edges[row[is_visible], column[is_visible]]
    return values
