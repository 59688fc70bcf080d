"""Planning of an orthophoto before it is drawn: its grid in the view plane."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.products.ortho.tiles import Grid
from vomstudio.products.ortho.view_directions import ViewDirection
from vomstudio.products.ortho.world_points import transform_to_world

MAX_PIXELS = 300_000_000
MAX_EDGE_ON_SHARE = 0.02
"""Maximum ratio of visible to true width of an edge-on model (about one degree off)."""


@dataclass(frozen=True, eq=False)
class OrthophotoPlan:
    """Plan of an orthophoto, before it is drawn.

    Parameters
    ----------
    view : ViewDirection
    frame : ViewFrame
    grid : Grid
    reference : (3,) array
        Centre of the model's bounds in the World frame, at which the depth is 0.
    points : (n, 3) array
        Vertices of the model in the axes of `frame`.
    notes : tuple of Finding
        Findings about default choices, and warnings.
    """

    view: ViewDirection
    frame: ViewFrame
    grid: Grid
    reference: FloatArray
    points: FloatArray
    notes: tuple[Finding, ...]

    @property
    def pixel_to_world(self) -> FloatArray:
        """Matrix (4, 4) from (column, row, depth, 1) to the World frame."""
        return self.frame.pixel_to_world(
            self.grid.gsd, self.reference, self.grid.left, self.grid.top
        )


@dataclass(frozen=True)
class ViewRegion:
    """Part of the view plane, given by its width and height in metres about a World point."""

    centre: tuple[float, float, float]
    width: float
    height: float


def plan(
    data: Mesh | PointCloud,
    view: ViewDirection,
    *,
    to_world: npt.ArrayLike,
    gsd: float | None = None,
    region: ViewRegion | None = None,
) -> OrthophotoPlan:
    """Plan an orthophoto.

    Parameters
    ----------
    data : Mesh or PointCloud
    view : ViewDirection
    to_world : (4, 4) array_like
    gsd : float, optional
        Metres per pixel. By default, the resolution of the texture or cloud.
    region : ViewRegion, optional
        Part of the model to draw.

    Returns
    -------
    OrthophotoPlan

    Raises
    ------
    UsageError
        If `gsd` is not positive, or if the picture would be too large. In the latter case, the
        error states the smallest possible gsd.
    InputError
        If the model is empty or lies outside the region.
    """
    frame = view.frame
    layout = create_grid_layout(
        data, frame, to_world=to_world, gsd=gsd, region=region, is_metric=view.is_metric
    )
    return OrthophotoPlan(view, frame, layout.grid, layout.reference, layout.points, layout.notes)


@dataclass(frozen=True, eq=False)
class GridLayout:
    """Grid over a model; the other fields are those of `OrthophotoPlan`."""

    grid: Grid
    reference: FloatArray
    points: FloatArray
    notes: tuple[Finding, ...]


def create_grid_layout(
    data: Mesh | PointCloud,
    frame: ViewFrame,
    *,
    to_world: npt.ArrayLike,
    gsd: float | None = None,
    region: ViewRegion | None = None,
    is_textured: bool = True,
    is_metric: bool = True,
) -> GridLayout:
    """Place a grid over a model, as in `plan`.

    If no gsd is given and `is_textured` is True, the resolution of the texture is used if there is
    one. `is_metric` states whether lengths are in metres.

    Raises
    ------
    UsageError, InputError
    """
    vertices = data.vertices if isinstance(data, Mesh) else data.points
    if not len(vertices) or (isinstance(data, Mesh) and not len(data.faces)):
        raise InputError(Finding("model.no-surface"))
    world = transform_to_world(to_world, vertices)
    if isinstance(data, Mesh):
        is_used = np.zeros(len(world), bool)
        is_used[data.faces.ravel()] = True
        used_vertices = world if is_used.all() else world[is_used]
    else:
        used_vertices = world
    reference = (
        used_vertices.min(axis=0) + (used_vertices.max(axis=0) - used_vertices.min(axis=0)) / 2
    )
    points = frame.to_view(world, reference)
    low, high = (
        f(points if used_vertices is world else points[is_used], axis=0) for f in (np.min, np.max)
    )
    notes: list[Finding] = []
    if region is not None:
        centre = frame.to_view(np.array([region.centre]), reference)[0]
        half_size = 0.5 * np.array([region.width, region.height])
        low[:2], high[:2] = (
            np.maximum(low[:2], centre[:2] - half_size),
            np.minimum(high[:2], centre[:2] + half_size),
        )
        if (low[:2] > high[:2]).any():
            raise InputError(Finding("view.part-empty"))
    extent = np.maximum(high - low, 0.0)[:2]
    if gsd is None:
        gsd, code = default_gsd(data, to_world, float(extent.max()), is_textured)
        min_gsd = _min_gsd(extent)
        if min_gsd > gsd:
            gsd, code = min_gsd, "gsd.limited"
        unit, limit = "m" if is_metric else tr("units"), MAX_PIXELS // 1_000_000
        notes.append(Finding(code, gsd=gsd, unit=unit, limit=limit))
    if not 1e-12 <= gsd < math.inf:
        raise UsageError(Finding("number.not-positive", value=gsd), field="--gsd")
    min_gsd = _min_gsd(extent)
    pixels = math.prod(max(1, math.ceil(v / gsd)) for v in extent.tolist())
    if pixels > MAX_PIXELS:
        raise UsageError(
            Finding(
                "gsd.too-many-pixels",
                gsd_m=gsd,
                megapixels=pixels / 1_000_000,
                limit=MAX_PIXELS // 1_000_000,
                least_m=min_gsd,
            ),
            field="--gsd",
        )
    if (
        warning := edge_on_finding(
            points if used_vertices is world else points[is_used], frame, gsd
        )
    ) is not None:
        notes.append(warning)
    return GridLayout(Grid.from_bounds(low, high, gsd), reference, points, tuple(notes))


def edge_on_finding(points: FloatArray, frame: ViewFrame, gsd: float) -> Finding | None:
    """Return a finding if a flat model is viewed edge-on, otherwise None.

    The width of the points about a line is compared in the picture and in space. The view is
    edge-on if the width in the picture is less than a fiftieth of that in space, or less than two
    pixels while that in space exceeds ten pixels.

    Parameters
    ----------
    points : (n, 3) array
        Points in the axes of the frame.
    frame : ViewFrame
    gsd : float
        Side of a pixel, m.
    """
    sample = points[:: max(1, len(points) // 100_000)]
    sample = sample - sample.mean(axis=0)
    values, axes = np.linalg.eigh(sample.T @ sample)
    # The width of a uniform distribution with the same variance.
    width = math.sqrt(12.0 * max(float(values[1]), 0.0) / len(sample))
    scatter_matrix = sample[:, :2].T @ sample[:, :2]
    visible_width = math.sqrt(
        12.0 * max(float(np.linalg.eigvalsh(scatter_matrix)[0]), 0.0) / len(sample)
    )
    if not width**2 > 1e-12 * 12.0 * float(values[2]) / len(sample):
        return None
    if visible_width > MAX_EDGE_ON_SHARE * width and not (
        visible_width < 2.0 * gsd and width > 10.0 * gsd
    ):
        return None
    plane = Plane.from_normal(frame.axes @ axes[:, 0])
    return Finding("view.edge-on", plane=format_plane(plane))


def default_gsd(
    data: Mesh | PointCloud, to_world: npt.ArrayLike, extent: float, is_textured: bool = True
) -> tuple[float, str]:
    """Return the resolution of a model to two digits, and the code of its finding."""
    from vomstudio.geometry.transform import matrix, scale_factor
    from vomstudio.io.models.opening import point_spacing

    scale = scale_factor(matrix(np.asarray(to_world, np.float64)))
    gsd, code = math.nan, ""
    if is_textured and isinstance(data, Mesh):
        from vomstudio.products.ortho.mesh_picture import texel_sizes

        sizes = sorted((size, area) for _, size, area in texel_sizes(data, data.vertices).values())
        if sizes:
            cumulative_share = np.cumsum([area for _, area in sizes])
            gsd = (
                sizes[int(np.searchsorted(cumulative_share, 0.5 * cumulative_share[-1]))][0] * scale
            )
            code = "gsd.texture"
    if not math.isfinite(gsd):
        gsd = point_spacing(data) * scale
        code = "gsd.edges" if isinstance(data, Mesh) else "gsd.spacing"
    if not math.isfinite(gsd) or gsd <= 0:
        gsd, code = max(extent, 1.0) / 1000, "gsd.size"
    return float(f"{gsd:.2g}"), code


def _min_gsd(extent: FloatArray) -> float:
    """Return the smallest gsd, to two digits, at which a picture has at most MAX_PIXELS."""
    width, height = (float(v) for v in extent)
    gsd = max(math.sqrt(width * height / MAX_PIXELS), max(width, height) / MAX_PIXELS, 1e-12)
    step = 10.0 ** (math.floor(math.log10(gsd)) - 1)
    digits = math.ceil(gsd / step)
    while math.ceil(width / (digits * step) + 1) * math.ceil(height / (digits * step) + 1) > (
        MAX_PIXELS
    ):
        digits += 1
    return float(f"{digits * step:.3g}")
