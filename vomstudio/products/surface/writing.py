"""Output of deviations as a raster, points or a table, and of profiles as a table."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import Float32Array
from vomstudio.core.files.atomic import atomic_group, write_bytes
from vomstudio.core.files.extensions import check_extension
from vomstudio.core.files.spreadsheet_cells import comment_line
from vomstudio.core.findings import Finding
from vomstudio.core.version import __version__
from vomstudio.geology.notation import format_plain_azimuth
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.units import WORLD_AXES, Axes, table_columns
from vomstudio.io.gis.raster import Raster, open_geotiff, view_plane_crs, write_tile
from vomstudio.products.ortho.tiles import TILE
from vomstudio.products.surface.analysis import SurfaceFigures

SUFFIXES = (".tif", ".tiff", ".ply", ".csv")
FIELDS = ("deviation_m", "plane_holds")
PROFILE_COLUMNS = ("profile", "distance_m", "deviation_m", "x", "y", "z")


def format_from_path(path: str | Path) -> str:
    """Return the extension of a deviation file.

    Raises
    ------
    UsageError
        If the extension is not supported.
    """
    return check_extension(path, SUFFIXES)


def deviation_fields(figures: SurfaceFigures) -> dict[str, Float32Array]:
    """Return point fields: the deviation in m, and 1 where the plane is valid, else 0."""
    return {
        FIELDS[0]: figures.point_deviations.astype(np.float32),
        FIELDS[1]: figures.holds.astype(np.float32),
    }


def write_deviations(
    path: str | Path,
    figures: SurfaceFigures,
    data: Mesh | PointCloud,
    *,
    crs: str | None,
    force: bool,
    axes: Axes = WORLD_AXES,
) -> list[Finding]:
    """Write the deviations to one file, either completely or not at all.

    Returns the warnings of the writer.

    Parameters
    ----------
    path : str or Path
    figures : SurfaceFigures
    data : Mesh or PointCloud
        The patch.
    crs : str or None
    force : bool
    axes : Axes
        Units and axes of the model.

    Raises
    ------
    UsageError, TargetError
    """
    suffix = format_from_path(path)
    if suffix == ".csv":
        write_bytes(path, _table(figures, data, crs, axes).encode("utf-8"), force=force)
        return []
    if suffix == ".ply":
        from vomstudio.io.models.writing import write_model

        fields = {**data.fields, **deviation_fields(figures)}
        return write_model(replace(data, fields=fields), crs, path, force=force)
    plan = figures.plan
    assert plan is not None
    raster = Raster(
        plan.grid.width,
        plan.grid.height,
        "float",
        plan.transform,
        crs if plan.is_map else view_plane_crs(axes.metric),
        {
            "VOMSTUDIO_VERSION": __version__,
            "VOMSTUDIO_PLANE": "dip direction "
            f"{format_plain_azimuth(plan.plane.dip_direction_deg)} dip "
            f"{plan.plane.dip_deg:.4f} deg; deviations from it in {axes.unit}",
        },
    )
    with (
        atomic_group([Path(path)], force) as temporary_paths,
        open_geotiff(temporary_paths[0], raster, path) as out,
    ):
        values = figures.deviations.astype(np.float32)
        for row in range(0, values.shape[0], TILE):
            for column in range(0, values.shape[1], TILE):
                write_tile(out, column, row, values[row : row + TILE, column : column + TILE])
    return []


def _table(figures: SurfaceFigures, data: Mesh | PointCloud, crs: str | None, axes: Axes) -> str:
    points = data.vertices if isinstance(data, Mesh) else data.points
    file = io.StringIO()
    file.write(_header(crs, axes))
    out = csv.writer(file, lineterminator="\n")
    out.writerow(["x", "y", "z", *table_columns(FIELDS, is_metric=axes.metric)])
    out.writerows(
        [f"{x:.6f}", f"{y:.6f}", f"{z:.6f}", f"{deviation:.6g}", int(is_planar)]
        for (x, y, z), deviation, is_planar in zip(
            points.tolist(), figures.point_deviations.tolist(), figures.holds.tolist(), strict=True
        )
    )
    return file.getvalue()


def write_profiles(
    path: str | Path,
    figures: SurfaceFigures,
    *,
    crs: str | None,
    force: bool,
    axes: Axes = WORLD_AXES,
) -> None:
    """Write the cells of the profiles along and across as CSV.

    Raises
    ------
    TargetError
    """
    file = io.StringIO()
    file.write(_header(crs, axes))
    out = csv.writer(file, lineterminator="\n")
    out.writerow(table_columns(PROFILE_COLUMNS, is_metric=axes.metric))
    for profile in figures.profiles:
        out.writerows(
            [
                profile.name,
                f"{distance:.6g}",
                f"{deviation:.6g}",
                f"{x:.6f}",
                f"{y:.6f}",
                f"{z:.6f}",
            ]
            for distance, deviation, (x, y, z) in zip(
                profile.distance_m, profile.deviation_m, profile.points.tolist(), strict=True
            )
        )
    write_bytes(path, file.getvalue().encode("utf-8"), force=force)


def _header(crs: str | None, axes: Axes) -> str:
    return comment_line(
        f"VOM Studio {__version__}, deviations of a surface from its plane"
    ) + comment_line(
        f"CRS: {crs or 'local'}; {axes.description}; "
        "deviations are positive along the upward normal"
    )
