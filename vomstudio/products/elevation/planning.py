"""What an elevation model will be, before a height is found: a grid over its plane of reference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import plane_option
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.io.gis.raster import Affine
from vomstudio.products.ortho.planning import lay_grid
from vomstudio.products.ortho.tiles import Grid


@dataclass(frozen=True, eq=False)
class HeightPlan:
    """A grid over a plane of reference, seen against its upward normal.

    plane : of reference; frame : right along its strike (East over the horizontal), down along its
        dip (South over the horizontal), direction against its upward normal
    reference : (3,) World, the centre of the model's bounds
    points : (n, 3) the model's vertices in the axes of the frame
    metric : False for a model whose unit is not known
    """

    plane: Plane
    frame: ViewFrame
    grid: Grid
    reference: FloatArray
    points: FloatArray
    notes: tuple[Finding, ...]
    metric: bool = True

    @property
    def is_map(self) -> bool:
        """Over the horizontal: heights are Z, and cells have their place on the map."""
        return self.plane.undefined

    @property
    def height_at_reference(self) -> float:
        """Of the plane through the reference point."""
        return float(self.reference[2]) if self.is_map else 0.0

    @property
    def transform(self) -> Affine:
        """From (column, row) to World x, y over the horizontal; else to metres in the plane, right
        and up its dip from the reference point."""
        grid = self.grid
        left, top = grid.left, -grid.top
        if self.is_map:
            left, top = left + float(self.reference[0]), top + float(self.reference[1])
        return (grid.gsd, 0.0, left, 0.0, -grid.gsd, top)

    @property
    def cell_to_world(self) -> FloatArray:
        """(4, 4) from (column, row, height, 1) to World; (0, 0) is the outer corner of the top left
        cell, its centre (0.5, 0.5)."""
        grid = self.grid
        matrix = self.frame.pixel_to_world(grid.gsd, self.reference, grid.left, grid.top)
        matrix[:3, 2] = self.plane.normal()
        if self.is_map:
            matrix[2, 3] = 0.0
        return matrix


def reference_plane(text: str | None) -> Plane:
    """Return the plane of "DD/D", the horizontal for None. Raises UsageError."""
    return Plane(0.0, 0.0) if text is None else plane_option(text)


def plan_heights(
    data: Mesh | PointCloud,
    plane: Plane,
    *,
    to_world: npt.ArrayLike,
    gsd: float | None = None,
    metric: bool = True,
) -> HeightPlan:
    """Fix the grid. gsd : side of a cell, metres; None takes the mean edge of a mesh, the mean
    spacing of a cloud. Raises UsageError for a grid that is too large, InputError for an empty
    model."""
    frame = frame_over(plane)
    laid = lay_grid(data, frame, to_world=to_world, gsd=gsd, textured=False, metric=metric)
    return HeightPlan(plane, frame, laid.grid, laid.reference, laid.points, laid.notes, metric)


def frame_over(plane: Plane) -> ViewFrame:
    """Rows run down dip however gentle it is; over the horizontal they run South."""
    if plane.undefined:
        return ViewFrame.looking(np.array([0.0, 0.0, -1.0]))
    down, direction = plane.dip_vector(), 0.0 - plane.normal()
    return ViewFrame(np.cross(down, direction), down, direction)
