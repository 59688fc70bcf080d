"""Plan of an elevation model: a grid over its plane of reference."""

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
    """Grid over a plane of reference, viewed against its upward normal.

    Parameters
    ----------
    plane : Plane
        Plane of reference.
    frame : ViewFrame
        Right along its strike (East over the horizontal), down along its dip (South over the
        horizontal), direction against its upward normal.
    grid : Grid
    reference : (3,) array
        Centre of the model's bounds, World.
    points : (n, 3) array
        Vertices of the model in the axes of the frame.
    notes : tuple of Finding
    metric : bool
        False if the unit of the model is unknown.
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
        """Whether the plane is horizontal: heights are Z, and cells have map coordinates."""
        return self.plane.undefined

    @property
    def height_at_reference(self) -> float:
        """Height at the reference point."""
        return float(self.reference[2]) if self.is_map else 0.0

    @property
    def transform(self) -> Affine:
        """Transform from (column, row) to World x, y over the horizontal.

        Over other planes it leads to metres in the plane, right and up its dip from the reference
        point.
        """
        grid = self.grid
        x, y = grid.left, -grid.top
        if self.is_map:
            x, y = x + float(self.reference[0]), y + float(self.reference[1])
        return (grid.gsd, 0.0, x, 0.0, -grid.gsd, y)

    @property
    def cell_to_world(self) -> FloatArray:
        """Transform (4, 4) from (column, row, height, 1) to World.

        (0, 0) is the outer corner of the top left cell, (0.5, 0.5) its centre.
        """
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
    """Plan the grid of an elevation model.

    Parameters
    ----------
    data : Mesh or PointCloud
    plane : Plane
        Plane of reference.
    to_world : (4, 4) array_like
    gsd : float, optional
        Side of a cell, m; default: mean edge of a mesh, or spacing of a cloud.
    metric : bool

    Raises
    ------
    UsageError
        If the grid is too large.
    InputError
        If the model is empty.
    """
    frame = view_frame(plane)
    layout = lay_grid(data, frame, to_world=to_world, gsd=gsd, textured=False, metric=metric)
    return HeightPlan(
        plane, frame, layout.grid, layout.reference, layout.points, layout.notes, metric
    )


def view_frame(plane: Plane) -> ViewFrame:
    """Return the frame over a plane: rows run down its dip, or South over the horizontal."""
    if plane.undefined:
        return ViewFrame.looking(np.array([0.0, 0.0, -1.0]))
    down, direction = plane.dip_vector(), 0.0 - plane.normal()
    return ViewFrame(np.cross(down, direction), down, direction)
