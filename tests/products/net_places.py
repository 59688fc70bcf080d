"""Where artists are drawn, in radii of the net from its centre."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import Collection, LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text


def places(artist: Any) -> np.ndarray:
    """Positions (n, 2) of all points of an artist, through its own transform."""
    return np.concatenate([np.zeros((0, 2)), *parts(artist)])


def parts(artist: Any) -> list[np.ndarray]:
    """Positions of each path of an artist; a rectangle by its corners, a text by its anchor."""
    transform = artist.get_transform()
    if isinstance(artist, Patch):
        return [_in_radii(artist, artist.get_extents().corners())]
    if isinstance(artist, Text):
        given = [np.array([artist.get_position()])]
    elif isinstance(artist, Line2D):
        given = [np.asarray(artist.get_xydata())]
    elif isinstance(artist, LineCollection):
        given = [np.asarray(segment) for segment in artist.get_segments()]
    elif isinstance(artist, Collection):
        given = [np.asarray(path.vertices) for path in artist.get_paths()]
    else:
        given = []
    return [_in_radii(artist, transform.transform(points)) for points in given if len(points)]


def _in_radii(artist: Any, pixels: Any) -> np.ndarray:
    return 2.0 * np.asarray(artist.axes.transAxes.inverted().transform(pixels)) - 1.0
