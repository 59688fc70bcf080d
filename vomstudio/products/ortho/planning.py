"""What an orthophoto will be, before a ray is cast: its grid over the plane of the view."""

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
from vomstudio.products.ortho.view_directions import View
from vomstudio.products.ortho.world_points import in_world

MAX_PIXELS = 300_000_000
EDGE_ON_SHARE = 0.02
"""By so little of its width a flat model is seen within a degree of edge-on."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Plan of an orthophoto, before it is drawn.

    Parameters
    ----------
    view : View
    frame : ViewFrame
    grid : Grid
    reference : (3,) array
        World, the centre of the model's bounds, where depth is 0.
    points : (n, 3) array
        Vertices of the model in the axes of the frame.
    notes : tuple of Finding
        Default choices and warnings.
    """

    view: View
    frame: ViewFrame
    grid: Grid
    reference: FloatArray
    points: FloatArray
    notes: tuple[Finding, ...]

    @property
    def pixel_to_world(self) -> FloatArray:
        return self.frame.pixel_to_world(
            self.grid.gsd, self.reference, self.grid.left, self.grid.top
        )


@dataclass(frozen=True)
class Region:
    """A part of the view plane: so many metres to the right and up, about a World point."""

    centre: tuple[float, float, float]
    width: float
    height: float


def plan(
    data: Mesh | PointCloud,
    view: View,
    *,
    to_world: npt.ArrayLike,
    gsd: float | None = None,
    region: Region | None = None,
) -> Plan:
    """Fix the grid. `points` of the result are the model's vertices in the view's axes.

    gsd : metres per pixel; None takes the resolution of texture or cloud. region : only this part
    of the model is drawn. Raises UsageError where the picture would be too large, with the gsd that
    would do, and InputError for an empty model or where the region shows nothing of it.
    """
    frame = view.frame
    laid = lay_grid(data, frame, to_world=to_world, gsd=gsd, region=region, metric=view.metric)
    return Plan(view, frame, laid.grid, laid.reference, laid.points, laid.notes)


@dataclass(frozen=True, eq=False)
class Laid:
    """Grid over a model. The other fields are those of `Plan`."""

    grid: Grid
    reference: FloatArray
    points: FloatArray
    notes: tuple[Finding, ...]


def lay_grid(
    data: Mesh | PointCloud,
    frame: ViewFrame,
    *,
    to_world: npt.ArrayLike,
    gsd: float | None = None,
    region: Region | None = None,
    textured: bool = True,
    metric: bool = True,
) -> Laid:
    """The grid of `plan`. textured : without a gsd that of the texture is taken where there is one;
    metric : whether lengths are in metres. Raises UsageError, InputError."""
    vertices = data.vertices if isinstance(data, Mesh) else data.points
    if not len(vertices) or (isinstance(data, Mesh) and not len(data.faces)):
        raise InputError(Finding("model.no-surface"))
    world = in_world(to_world, vertices)
    if isinstance(data, Mesh):
        used = np.zeros(len(world), bool)
        used[data.faces.ravel()] = True
        seen = world if used.all() else world[used]
    else:
        seen = world
    reference = seen.min(axis=0) + (seen.max(axis=0) - seen.min(axis=0)) / 2
    points = frame.to_view(world, reference)
    low, high = (f(points if seen is world else points[used], axis=0) for f in (np.min, np.max))
    notes: list[Finding] = []
    if region is not None:
        centre = frame.to_view(np.array([region.centre]), reference)[0]
        half = 0.5 * np.array([region.width, region.height])
        low[:2], high[:2] = (
            np.maximum(low[:2], centre[:2] - half),
            np.minimum(high[:2], centre[:2] + half),
        )
        if (low[:2] > high[:2]).any():
            raise InputError(Finding("view.part-empty"))
    extent = np.maximum(high - low, 0.0)[:2]
    if gsd is None:
        gsd, code = default_gsd(data, to_world, float(extent.max()), textured)
        least = _least_gsd(extent)
        if least > gsd:
            gsd, code = least, "gsd.limited"
        unit, limit = "m" if metric else tr("units"), MAX_PIXELS // 1_000_000
        notes.append(Finding(code, gsd=gsd, unit=unit, limit=limit))
    if not 1e-12 <= gsd < math.inf:
        raise UsageError(Finding("number.not-positive", value=gsd), field="--gsd")
    least = _least_gsd(extent)
    pixels = math.prod(max(1, math.ceil(v / gsd)) for v in extent.tolist())
    if pixels > MAX_PIXELS:
        raise UsageError(
            Finding(
                "gsd.too-many-pixels",
                gsd_m=gsd,
                megapixels=pixels / 1_000_000,
                limit=MAX_PIXELS // 1_000_000,
                least_m=least,
            ),
            field="--gsd",
        )
    if (doubt := edge_on(points if seen is world else points[used], frame, gsd)) is not None:
        notes.append(doubt)
    return Laid(Grid.over(low, high, gsd), reference, points, tuple(notes))


def edge_on(points: FloatArray, frame: ViewFrame, gsd: float) -> Finding | None:
    """Return a finding if a flat model is viewed edge-on.

    The width of its points about a line is compared in the picture and in space. The view is
    edge-on if it is a fiftieth of that in space, or under two pixels if that in space exceeds ten.

    Parameters
    ----------
    points : (n, 3) array
        In the axes of the frame.
    frame : ViewFrame
    gsd : float
        Side of a pixel.
    """
    few = points[:: max(1, len(points) // 100_000)]
    few = few - few.mean(axis=0)
    values, axes = np.linalg.eigh(few.T @ few)
    # As wide as an even distribution is.
    wide = math.sqrt(12.0 * max(float(values[1]), 0.0) / len(few))
    flat = few[:, :2].T @ few[:, :2]
    seen = math.sqrt(12.0 * max(float(np.linalg.eigvalsh(flat)[0]), 0.0) / len(few))
    if not wide**2 > 1e-12 * 12.0 * float(values[2]) / len(few):
        return None
    if seen > EDGE_ON_SHARE * wide and not (seen < 2.0 * gsd and wide > 10.0 * gsd):
        return None
    plane = Plane.from_normal(frame.axes @ axes[:, 0])
    return Finding("view.edge-on", plane=format_plane(plane))


def default_gsd(
    data: Mesh | PointCloud, to_world: npt.ArrayLike, extent: float, textured: bool = True
) -> tuple[float, str]:
    """Return the resolution of a model, rounded to two digits, and the code of its finding."""
    from vomstudio.geometry.transform import matrix, scale_of
    from vomstudio.io.models.opening import point_spacing

    scale = scale_of(matrix(np.asarray(to_world, np.float64)))
    gsd, code = math.nan, ""
    if textured and isinstance(data, Mesh):
        from vomstudio.products.ortho.mesh_picture import texel_sizes

        sizes = sorted((size, area) for _, size, area in texel_sizes(data, data.vertices).values())
        if sizes:
            share = np.cumsum([area for _, area in sizes])
            gsd = sizes[int(np.searchsorted(share, 0.5 * share[-1]))][0] * scale
            code = "gsd.texture"
    if not math.isfinite(gsd):
        gsd = point_spacing(data) * scale
        code = "gsd.edges" if isinstance(data, Mesh) else "gsd.spacing"
    if not math.isfinite(gsd) or gsd <= 0:
        gsd, code = max(extent, 1.0) / 1000, "gsd.size"
    return float(f"{gsd:.2g}"), code


def _least_gsd(extent: FloatArray) -> float:
    """The smallest gsd, of two digits, whose picture has no more than MAX_PIXELS."""
    width, height = (float(v) for v in extent)
    gsd = max(math.sqrt(width * height / MAX_PIXELS), max(width, height) / MAX_PIXELS, 1e-12)
    step = 10.0 ** (math.floor(math.log10(gsd)) - 1)
    digits = math.ceil(gsd / step)
    while math.ceil(width / (digits * step) + 1) * math.ceil(height / (digits * step) + 1) > (
        MAX_PIXELS
    ):
        digits += 1
    return float(f"{digits * step:.3g}")
