"""A part of the points of a very large model, among which lines are looked for."""

from __future__ import annotations

import numpy as np

from vomstudio.extraction.texture_colours import TextureColours
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

MOST_POINTS = 1_000_000
"""Of some minutes' work with all surfaces of noise."""
_SEED = 20240229


def few_enough(data: Mesh | PointCloud, most: int) -> PointCloud:
    """So many points or vertices of a model that has more, drawn at random with the same chance,
    with their colours and fields."""
    points = data.vertices if isinstance(data, Mesh) else data.points
    rows = np.sort(np.random.default_rng(_SEED).choice(len(points), most, replace=False))
    colours = data.colors
    if colours is None and isinstance(data, Mesh) and (worn := TextureColours(data)).any:
        colours = np.round(worn.of_vertices).astype(np.uint8)
    return PointCloud(
        points[rows],
        colors=None if colours is None else colours[rows],
        fields={name: values[rows] for name, values in data.fields.items()},
    )
