"""Output files of an elevation model, and their description."""

from __future__ import annotations

import contextlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, Float32Array
from vomstudio.core.errors import InputError
from vomstudio.core.files.atomic import atomic_group, check_target
from vomstudio.core.files.extensions import check_extension
from vomstudio.core.findings import Finding, to_json_list
from vomstudio.core.version import __version__
from vomstudio.geology.notation import format_plain_azimuth
from vomstudio.geometry.frames import world_north
from vomstudio.io.gis.raster import Raster, open_geotiff, view_plane_crs, write_tile
from vomstudio.products.elevation.contours import contour_lines, write_contours
from vomstudio.products.elevation.dem_options import DemFiles
from vomstudio.products.elevation.planning import HeightPlan
from vomstudio.products.elevation.results import ElevationFigures, WrittenElevation
from vomstudio.products.elevation.shading import compute_dips, hillshade
from vomstudio.products.ortho.planning import edge_on_finding
from vomstudio.products.ortho.tiles import TILE

DEFAULT_FILES = DemFiles()


def elevation_outputs(raster: str | Path, files: DemFiles) -> dict[str, Path]:
    """Return the files to write, by kind: NAME.json, NAME_hillshade.tif and so on.

    Raises
    ------
    UsageError
        If the extension is not that of a TIFF file.
    """
    path = Path(raster)
    check_extension(path, (".tif", ".tiff"))
    outputs = {"raster": path, "sidecar": path.with_suffix(".json")}
    for name in ("hillshade", "slope", "aspect"):
        if getattr(files, name):
            outputs[name] = path.with_name(f"{path.stem}_{name}.tif")
    if files.contours_m is not None:
        outputs["contours"] = path.with_name(f"{path.stem}_contours.gpkg")
    return outputs


def check_targets(raster: str | Path, files: DemFiles, *, force: bool) -> None:
    """Check that the files can be written, before the computation starts.

    Raises
    ------
    UsageError, TargetError
    """
    for target in elevation_outputs(raster, files).values():
        check_target(target, force=force)


def elevation_figures(
    heights: Float32Array, plan: HeightPlan, limit: float | None, crs: str | None
) -> ElevationFigures:
    """Compute the figures of an elevation model.

    Parameters
    ----------
    heights : (h, w) array
        Heights in metres.
    plan : HeightPlan
    limit : float or None
        Maximum side of a triangle, m.
    crs : str or None
        CRS of the World frame.

    Raises
    ------
    InputError
        If no cell has a height.
    """
    is_known = np.isfinite(heights)
    covered_count = int(is_known.sum())
    if not covered_count:
        raise InputError(
            edge_on_finding(plan.points, plan.frame, plan.grid.gsd) or Finding("dem.no-heights")
        )
    grid, plane, frame = plan.grid, plan.plane, plan.frame
    return ElevationFigures(
        grid.width,
        grid.height,
        grid.gsd,
        covered_count / heights.size,
        plan.reference,
        plane.dip_direction_deg,
        plane.dip_deg,
        frame.right,
        frame.down,
        plane.normal(),
        float(np.nanmin(heights)),
        float(np.nanmax(heights)),
        limit,
        plan.cell_to_world,
        crs if plan.is_map else None,
    )


def write_elevation(
    heights: Float32Array,
    plan: HeightPlan,
    figures: ElevationFigures,
    raster: str | Path,
    *,
    files: DemFiles = DEFAULT_FILES,
    world: str | None = None,
    is_north_known: bool = True,
    model: str | None = None,
    content_hash: str | None = None,
    warnings: tuple[Finding, ...] = (),
    force: bool = False,
) -> WrittenElevation:
    """Write all files of an elevation model, or none if one fails.

    Parameters
    ----------
    heights : (h, w) array
        Heights in metres.
    plan : HeightPlan
    figures : ElevationFigures
    raster : str or Path
    files : DemFiles
    world : str or None
        CRS of the World frame, for the sidecar.
    is_north_known : bool
    model, content_hash : str or None
        Name and content hash of the model, for the sidecar.
    warnings : tuple of Finding
    force : bool

    Raises
    ------
    TargetError, UsageError
    """
    targets = elevation_outputs(raster, files)
    if plan.is_map and figures.crs is None:
        warnings = (*warnings, Finding("raster.no-crs"))
    crs = figures.crs if plan.is_map else view_plane_crs(plan.is_metric)
    lines = None
    if files.contours_m is not None:
        lines = contour_lines(heights, plan.transform, files.contours_m)
        if not lines:
            warnings = (*warnings, Finding("dem.no-contours"))
    path_by_name = {name: str(target) for name, target in targets.items()}
    result = WrittenElevation(
        str(raster),
        figures,
        path_by_name["sidecar"],
        path_by_name.get("hillshade"),
        path_by_name.get("slope"),
        path_by_name.get("aspect"),
        path_by_name.get("contours"),
        warnings,
    )
    metadata = _sidecar_metadata(result, plan, world, is_north_known) | {
        "model": model,
        "content_hash": content_hash,
    }
    base = Raster(
        plan.grid.width,
        plan.grid.height,
        "float",
        plan.transform,
        crs,
        {
            "VOMSTUDIO_VERSION": __version__,
            "VOMSTUDIO_PLANE": "dip direction "
            f"{format_plain_azimuth(figures.dip_direction_deg)} dip "
            f"{figures.dip_deg:.4f} deg",
        },
    )
    with atomic_group(list(targets.values()), force) as temporary_paths:
        path_by_target = dict(zip(targets, temporary_paths, strict=True))
        _write(path_by_target["raster"], base, heights, targets["raster"])
        if "slope" in path_by_target or "aspect" in path_by_target:
            dip, direction = compute_dips(heights, plan.grid.gsd, plan.frame)
            for name, values in (("slope", dip), ("aspect", direction)):
                if name in path_by_target:
                    _write(path_by_target[name], base, values, targets[name])
        if "hillshade" in path_by_target:
            shade = hillshade(heights, plan.grid.gsd)
            _write(
                path_by_target["hillshade"], replace(base, kind="grey"), shade, targets["hillshade"]
            )
        if lines is not None:
            path_by_target["contours"].unlink()
            write_contours(path_by_target["contours"], lines, crs)
        path_by_target["sidecar"].write_text(
            json.dumps(
                metadata | {"warnings": to_json_list(warnings)}, indent=1, ensure_ascii=False
            )
            + "\n",
            "utf-8",
        )
    return result


def _sidecar_metadata(
    result: WrittenElevation, plan: HeightPlan, world: str | None, is_north_known: bool
) -> dict[str, Any]:
    """Collect the content of the sidecar."""
    heights = "metres along the upward normal of the plane of reference through the reference point"
    north = world_north(world, is_known=is_north_known)
    return {
        **result.to_dict(),
        "raster": Path(result.raster).name,
        "cell_to_world_means": "(column, row, height, 1) to World x, y, z; (0, 0) is the outer "
        "corner of the top left cell, its centre is (0.5, 0.5)",
        "heights_mean": "Z of World" if plan.is_map else heights,
        "world_crs": world,
        "north": north,
        "slope_means": "dip of the surface from the horizontal of World, degrees",
        "aspect_means": "dip direction of the surface, degrees clockwise from north",
        "software": f"VOM Studio {__version__}",
    }


def _write(path: Path, raster: Raster, values: AnyArray, display_path: Path) -> None:
    with contextlib.ExitStack() as files:
        file = files.enter_context(open_geotiff(path, raster, display_path))
        for row in range(0, values.shape[0], TILE):
            for column in range(0, values.shape[1], TILE):
                write_tile(file, column, row, values[row : row + TILE, column : column + TILE])
