"""Faces and points chosen by what they are worth: a field of the model, or a colour like that of
what is chosen already."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import AnyArray, BoolArray, FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.extraction.texture_colours import TextureColours
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.field_style import ELEVATION, field_names
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud

_SAMPLE = 50_000
_FINE = 64
"""Colours are told apart in so many steps of red, green and blue each."""


def fields_of(data: Mesh | PointCloud) -> tuple[str, ...]:
    """The names of the fields that can be asked for, ELEVATION first; none of a cloud that is read
    as it is looked at."""
    return () if isinstance(data, StreamedCloud) else field_names(data)


def range_of(data: Mesh | PointCloud, to_world: FloatArray, name: str) -> tuple[float, float]:
    """Least and greatest value of a field; NaN where it has none."""
    values = _values(data, to_world, name)
    known = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    return (float(known.min()), float(known.max())) if len(known) else (np.nan, np.nan)


def within(
    data: Mesh | PointCloud, to_world: FloatArray, name: str, low: float, high: float
) -> BoolArray:
    """(n,) which faces, by the mean of their corners, or points have a value from low to high;
    where low is above high, as azimuths about north, those outside of it. to_world : (4, 4)"""
    values = _values(data, to_world, name)
    if isinstance(data, Mesh):
        if low > high:
            # The mean of 359 and 1 is no azimuth between them: each corner by itself.
            inside = (values >= low) | (values <= high)
            corners = inside[data.faces]
            return np.asarray(corners.sum(axis=1) >= 2)
        a, b, c = np.asarray(data.faces).T
        values = (values[a].astype(np.float64) + values[b] + values[c]) / 3.0
    if low > high:
        return np.asarray((values >= low) | (values <= high))
    return np.asarray((values >= low) & (values <= high))


class ElementColours:
    """Of the faces of a mesh, from its textures or its vertices, or of the points of a cloud.
    Raises GeometryError where the model has no colours."""

    def __init__(self, data: Mesh | PointCloud) -> None:
        self._faces = np.asarray(data.faces) if isinstance(data, Mesh) else None
        colours = data.colors
        if isinstance(data, Mesh) and colours is None:
            textures = TextureColours(data)
            if not textures.any:
                raise GeometryError(Finding("model.no-colours"))
            colours = np.clip(np.round(textures.of_vertices), 0, 255).astype(np.uint8)
        if colours is None or isinstance(data, StreamedCloud):
            raise GeometryError(Finding("model.no-colours"))
        small = (np.asarray(colours) // (256 // _FINE)).astype(np.int32)
        self._codes = (small[:, 0] * _FINE + small[:, 1]) * _FINE + small[:, 2]

    def like(self, ids: IntArray, tolerance: float) -> BoolArray:
        """(n,) which have a colour within the tolerance of one of those of `ids`: of their mean, in
        CIE L*a*b* with half the weight for lightness, since a face in the shade is darker and no
        other rock. 2.3 is what the eye just tells apart (Mahy et al. 1994, Color Res. Appl. 19,
        105)."""
        some = ids[:: max(1, len(ids) // _SAMPLE)]
        every = _lab(_cells())
        own = every[
            self._codes[self._faces[some]].ravel() if self._faces is not None else self._codes[some]
        ]
        off = every - own.mean(axis=0)
        off[:, 0] *= 0.5
        near = np.sqrt((off * off).sum(axis=1)) <= tolerance
        inside = near[self._codes]
        if self._faces is None:
            return np.asarray(inside)
        a, b, c = self._faces.T
        return np.asarray(inside[a].astype(np.int8) + inside[b] + inside[c] >= 2)


def _values(data: Mesh | PointCloud, to_world: FloatArray, name: str) -> AnyArray:
    places = data.vertices if isinstance(data, Mesh) else data.points
    if name == ELEVATION:
        return np.asarray(places @ to_world[2, :3] + to_world[2, 3])
    return np.asarray(data.fields[name])


def _cells() -> FloatArray:
    """(_FINE^3, 3) colours in the middle of the steps, 0..1."""
    steps = (np.arange(_FINE) + 0.5) / _FINE
    red, green, blue = np.meshgrid(steps, steps, steps, indexing="ij")
    return np.stack([red.ravel(), green.ravel(), blue.ravel()], axis=1)


def _lab(rgb: FloatArray) -> FloatArray:
    """CIE L*a*b* (D65) of sRGB 0..1 (IEC 61966-2-1, CIE 15)."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    turn = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = linear @ turn.T / np.array([0.95047, 1.0, 1.08883])
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16.0 / 116.0)
    return np.stack(
        [116.0 * f[:, 1] - 16.0, 500.0 * (f[:, 0] - f[:, 1]), 200.0 * (f[:, 1] - f[:, 2])], axis=1
    )
