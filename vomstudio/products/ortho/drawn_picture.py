"""Picture that is drawn in memory, with the geometry of its pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import ByteArray, Float32Array
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.ortho.drawn_tiles import draw_tiles
from vomstudio.products.ortho.orthophoto import create_source, picture_metadata
from vomstudio.products.ortho.planning import OrthophotoPlan
from vomstudio.products.ortho.requests import OrthophotoFigures, figures_from_metadata
from vomstudio.products.ortho.tiles import Tile, TilePicture


@dataclass(frozen=True, eq=False)
class DrawnPicture:
    """Drawn picture, which also serves as a source of tiles to write it without redrawing.

    Parameters
    ----------
    rgba : (h, w, 4) uint8 array
    depth : (h, w) float32 array
        Depth of each pixel; NaN if the pixel is empty.
    filled : int
        Number of pixels in holes that were filled.
    hole_m : float or None
        Maximum width of the holes that were closed in a cloud; None for a mesh.
    findings : tuple of Finding
    """

    rgba: ByteArray
    depth: Float32Array
    filled: int
    hole_m: float | None
    findings: tuple[Finding, ...]

    def draw(self, tile: Tile) -> TilePicture:
        part = np.s_[tile.row : tile.row + tile.height, tile.column : tile.column + tile.width]
        # Count filled pixels only once, for the whole picture.
        n_filled = self.filled if tile.number == 0 else 0
        return TilePicture(self.rgba[part], self.depth[part], n_filled)

    def warnings(self) -> list[Finding]:
        return list(self.findings)


def draw_picture(
    data: Mesh | PointCloud, plan: OrthophotoPlan, progress: Progress | None = None
) -> DrawnPicture:
    """Draw a planned picture.

    Raises
    ------
    Cancelled
    """
    progress = progress or SilentProgress()
    progress.stage(tr("Preparing the model"))
    grid = plan.grid
    source = create_source(data, plan)
    rgba = np.zeros((grid.height, grid.width, 4), np.uint8)
    depth = np.full((grid.height, grid.width), np.nan, np.float32)
    filled_count = 0
    for tile, picture in draw_tiles(source, grid, progress, None):
        rows, columns = slice(tile.row, tile.row + tile.height), slice(tile.column, None)
        rgba[rows, columns][:, : tile.width] = picture.rgba
        depth[rows, columns][:, : tile.width] = picture.depth
        filled_count += picture.filled
    hole_m = getattr(source, "hole_m", None)
    return DrawnPicture(rgba, depth, filled_count, hole_m, tuple(source.warnings()))


def picture_figures(
    drawn_picture: DrawnPicture, plan: OrthophotoPlan, crs: str | None
) -> OrthophotoFigures:
    """Return the figures of a drawn picture; `crs` is the World CRS, "EPSG:n" or WKT."""
    metadata = picture_metadata(plan, crs if plan.frame.is_vertical else None)
    metadata |= {
        "coverage": float(np.isfinite(drawn_picture.depth).mean()),
        "holes_filled_px": drawn_picture.filled,
        "holes_filled_up_to_m": drawn_picture.hole_m,
    }
    return figures_from_metadata(metadata)
