"""Selection of faces and points by a field of the model, or by similarity of colour."""

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

_MAX_SAMPLE = 50_000
_COLOUR_STEPS = 64
"""Number of quantization steps for each of red, green and blue."""


def selectable_fields(data: Mesh | PointCloud) -> tuple[str, ...]:
    """List the fields of a model, starting with ELEVATION; empty for a streamed cloud.

    Parameters
    ----------
    data : Mesh or PointCloud

    Returns
    -------
    tuple of str
    """
    return () if isinstance(data, StreamedCloud) else field_names(data)


def field_range(data: Mesh | PointCloud, to_world: FloatArray, name: str) -> tuple[float, float]:
    """Return the minimum and maximum of a field.

    Parameters
    ----------
    data : Mesh or PointCloud
    to_world : (4, 4) ndarray
        Similarity from the file frame to the World frame, used for elevations.
    name : str
        Name of the field.

    Returns
    -------
    low, high : float
        Limits of the field; NaN if it has no values.
    """
    values = _values(data, to_world, name)
    finite_field = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    return (
        (float(finite_field.min()), float(finite_field.max()))
        if len(finite_field)
        else (np.nan, np.nan)
    )


def select_by_value(
    data: Mesh | PointCloud, to_world: FloatArray, name: str, low: float, high: float
) -> BoolArray:
    """Select faces (by the mean of their corners) or points with a value from low to high.

    If low exceeds high, as for azimuths around north, values from low up and from high down are
    selected; a face is then selected if at least two of its corners have such a value.

    Parameters
    ----------
    data : Mesh or PointCloud
    to_world : (4, 4) array
        Transform from the frame of the file to the World frame.
    name : str
        Name of the field.
    low, high : float

    Returns
    -------
    (n,) bool array
    """
    values = _values(data, to_world, name)
    if isinstance(data, Mesh):
        if low > high:
            # The mean of 359 and 1 is not an azimuth between them, so the corners are tested.
            is_inside = (values >= low) | (values <= high)
            corners = is_inside[data.faces]
            return np.asarray(corners.sum(axis=1) >= 2)
        a, b, c = np.asarray(data.faces).T
        values = (values[a].astype(np.float64) + values[b] + values[c]) / 3.0
    if low > high:
        return np.asarray((values >= low) | (values <= high))
    return np.asarray((values >= low) & (values <= high))


class ElementColours:
    """Colours of mesh faces (from textures or vertices) or of the points of a cloud.

    Raises
    ------
    GeometryError
        If the model has no colours, or if it is a streamed cloud.
    """

    def __init__(self, data: Mesh | PointCloud) -> None:
        self._faces = np.asarray(data.faces) if isinstance(data, Mesh) else None
        colours = data.colors
        if isinstance(data, Mesh) and colours is None:
            textures = TextureColours(data)
            if not textures.has_textures:
                raise GeometryError(Finding("model.no-colours"))
            colours = np.clip(np.round(textures.vertex_colours), 0, 255).astype(np.uint8)
        if colours is None or isinstance(data, StreamedCloud):
            raise GeometryError(Finding("model.no-colours"))
        colour_classes = (np.asarray(colours) // (256 // _COLOUR_STEPS)).astype(np.int32)
        self._codes = (
            colour_classes[:, 0] * _COLOUR_STEPS + colour_classes[:, 1]
        ) * _COLOUR_STEPS + colour_classes[:, 2]

    def like(self, ids: IntArray, tolerance: float) -> BoolArray:
        """Select elements whose colour is similar to the mean colour of `ids`.

        A face is selected if at least two of its corners have a similar colour.

        The tolerance is a distance in CIE L*a*b* with half the weight for lightness, because rock
        in the shade is darker. The smallest visible difference is 2.3 (Mahy et al. 1994, Color Res.
        Appl. 19, 105).

        Parameters
        ----------
        ids : (k,) int array
        tolerance : float

        Returns
        -------
        (n,) bool array
        """
        sample = ids[:: max(1, len(ids) // _MAX_SAMPLE)]
        palette = _srgb_to_lab(_palette())
        sample_colours = palette[
            self._codes[self._faces[sample]].ravel()
            if self._faces is not None
            else self._codes[sample]
        ]
        differences = palette - sample_colours.mean(axis=0)
        differences[:, 0] *= 0.5
        is_near = np.sqrt((differences * differences).sum(axis=1)) <= tolerance
        is_similar = is_near[self._codes]
        if self._faces is None:
            return np.asarray(is_similar)
        a, b, c = self._faces.T
        return np.asarray(is_similar[a].astype(np.int8) + is_similar[b] + is_similar[c] >= 2)


def _values(data: Mesh | PointCloud, to_world: FloatArray, name: str) -> AnyArray:
    positions = data.vertices if isinstance(data, Mesh) else data.points
    if name == ELEVATION:
        return np.asarray(positions @ to_world[2, :3] + to_world[2, 3])
    return np.asarray(data.fields[name])


def _palette() -> FloatArray:
    """Return the colours (_COLOUR_STEPS^3, 3) at the centres of the steps, from 0 to 1."""
    steps = (np.arange(_COLOUR_STEPS) + 0.5) / _COLOUR_STEPS
    red, green, blue = np.meshgrid(steps, steps, steps, indexing="ij")
    return np.stack([red.ravel(), green.ravel(), blue.ravel()], axis=1)


def _srgb_to_lab(rgb: FloatArray) -> FloatArray:
    """Convert sRGB values from 0 to 1 to CIE L*a*b* (D65; IEC 61966-2-1, CIE 15)."""
    linear_rgb = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    rgb_to_xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    xyz = linear_rgb @ rgb_to_xyz.T / np.array([0.95047, 1.0, 1.08883])
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16.0 / 116.0)
    return np.stack(
        [116.0 * f[:, 1] - 16.0, 500.0 * (f[:, 0] - f[:, 1]), 200.0 * (f[:, 1] - f[:, 2])], axis=1
    )
