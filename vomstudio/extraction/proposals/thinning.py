"""Random sample of the points of a very large model, used to search for lines."""

from __future__ import annotations

import numpy as np

from vomstudio.extraction.texture_colours import TextureColours
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

MAX_POINTS = 1_000_000
"""Maximum number of points, for which the search with all surrogates takes a few minutes."""
_SEED = 20240229


def sample_points(data: Mesh | PointCloud, count: int) -> PointCloud:
    """Draw a random sample of points or vertices, including colours and fields.

    Parameters
    ----------
    data : Mesh or PointCloud
    count : int
        Number of points to draw.

    Returns
    -------
    PointCloud
    """
    points = data.vertices if isinstance(data, Mesh) else data.points
    rows = np.sort(np.random.default_rng(_SEED).choice(len(points), count, replace=False))
    colours = data.colors
    if (
        colours is None
        and isinstance(data, Mesh)
        and (textures := TextureColours(data)).has_textures
    ):
        colours = np.round(textures.vertex_colours).astype(np.uint8)
    return PointCloud(
        points[rows],
        colors=None if colours is None else colours[rows],
        fields={name: values[rows] for name, values in data.fields.items()},
    )
