"""Planning of an elevation model: a grid over its reference plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import parse_plane_option
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.io.gis.raster import Affine
from vomstudio.products.ortho.planning import create_grid_layout
from vomstudio.products.ortho.tiles import Grid


@dataclass(frozen=True, eq=False)
class HeightPlan:
    """Grid over a reference plane, viewed against its upward normal.

    Parameters
    ----------
    plane : Plane
        Reference plane.
    frame : ViewFrame
        View frame: right along the strike of the plane (East if horizontal), down along its dip
        (South if horizontal), and the viewing direction against its upward normal.
    grid : Grid
    reference : (3,) array
        Centre of the model's bounds in the World frame.
    points : (n, 3) array
        Vertices of the model in the axes of the frame.
    notes : tuple of Finding
    is_metric : bool
        Whether the model is in metres; False if its unit is unknown.
    """

    plane: Plane
    frame: ViewFrame
    grid: Grid
    reference: FloatArray
    points: FloatArray
    notes: tuple[Finding, ...]
    is_metric: bool = True

    @property
    def is_map(self) -> bool:
        """Whether the plane is horizontal, so that heights are Z and cells have map coordinates."""
        return self.plane.undefined

    @property
    def reference_height(self) -> float:
        """Height at the reference point."""
        return float(self.reference[2]) if self.is_map else 0.0

    @property
    def transform(self) -> Affine:
        """Affine transform from (column, row) to coordinates.

        The coordinates are World x, y over a horizontal plane. Over other planes, they are metres
        in the plane, to the right and up-dip from the reference point.
        """
        grid = self.grid
        x, y = grid.left, -grid.top
        if self.is_map:
            x, y = x + float(self.reference[0]), y + float(self.reference[1])
        return (grid.gsd, 0.0, x, 0.0, -grid.gsd, y)

    @property
    def cell_to_world(self) -> FloatArray:
        """Matrix (4, 4) from (column, row, height, 1) to the World frame.

        (0, 0) is the outer corner of the top left cell, and (0.5, 0.5) its centre.
        """
        grid = self.grid
        matrix = self.frame.pixel_to_world(grid.gsd, self.reference, grid.left, grid.top)
        matrix[:3, 2] = self.plane.normal()
        if self.is_map:
            matrix[2, 3] = 0.0
        return matrix


def parse_reference_plane(text: str | None) -> Plane:
    """Parse a plane given as "DD/D"; None is the horizontal plane. Raises UsageError."""
    return Plane(0.0, 0.0) if text is None else parse_plane_option(text)


def plan_heights(
    data: Mesh | PointCloud,
    plane: Plane,
    *,
    to_world: npt.ArrayLike,
    gsd: float | None = None,
    is_metric: bool = True,
) -> HeightPlan:
    """Plan the grid of an elevation model.

    Parameters
    ----------
    data : Mesh or PointCloud
    plane : Plane
        Reference plane.
    to_world : (4, 4) array_like
    gsd : float, optional
        Cell size, m. By default, the mean edge of a mesh or the spacing of a cloud.
    is_metric : bool

    Raises
    ------
    UsageError
        If the grid is too large.
    InputError
        If the model is empty.
    """
    frame = view_frame(plane)
    layout = create_grid_layout(
        data, frame, to_world=to_world, gsd=gsd, is_textured=False, is_metric=is_metric
    )
    return HeightPlan(
        plane, frame, layout.grid, layout.reference, layout.points, layout.notes, is_metric
    )


def view_frame(plane: Plane) -> ViewFrame:
    """Return the view frame of a plane, in which rows run down-dip, or South if horizontal."""
    if plane.undefined:
        return ViewFrame.from_direction(np.array([0.0, 0.0, -1.0]))
    down, direction = plane.dip_vector(), 0.0 - plane.normal()
    return ViewFrame(np.cross(down, direction), down, direction)
