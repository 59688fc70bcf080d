"""True-to-scale pictures of a model along any direction, with the geometry of each pixel.

The geometry is defined in `geometry.view_frame`. The files are a GeoTIFF (RGBA), a depth raster
(float32, NaN if empty), a world file, and a JSON sidecar with the matrix from (column, row, depth)
to the World frame, and the CRS and north of the World frame. A picture on an oblique plane is not a
map: its GeoTIFF (with an engineering CRS) and its world file are in metres in its own plane, to the
right of and above the reference point.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import ByteArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.atomic import atomic_group, check_target
from vomstudio.core.files.containment import check_generated_path
from vomstudio.core.files.extensions import check_extension
from vomstudio.core.findings import Finding, to_json_list
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.version import __version__
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_plain_azimuth
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frames import world_north
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.raster import (
    Affine,
    Raster,
    open_geotiff,
    view_plane_crs,
    world_file,
    write_tile,
)
from vomstudio.products.ortho.domain_mask import DomainExtent, DomainTileSource
from vomstudio.products.ortho.drawn_features import (
    draw_features,
    drawing_targets,
    picture_id,
    raster_rotation,
    write_drawings,
)
from vomstudio.products.ortho.drawn_tiles import draw_tiles
from vomstudio.products.ortho.interpretation import Item
from vomstudio.products.ortho.planning import OrthophotoPlan, edge_on_finding
from vomstudio.products.ortho.sheet import format_from_path, write_sheet
from vomstudio.products.ortho.tiles import TILE, Grid, Tile, TilePicture, TileSource
from vomstudio.products.ortho.vector_drawing import Drawing


@dataclass(frozen=True, eq=False)
class OrthophotoFiles:
    """Files of an orthophoto; `coverage` is the share of the pixels that show the model."""

    image: Path
    sidecar: Path
    depth: Path
    world_file: Path
    sheet: Path | None
    drawing: dict[str, Path]
    coverage: float
    warnings: tuple[Finding, ...]
    metadata: dict[str, Any]


def orthophoto_outputs(image: str | Path) -> tuple[Path, Path, Path]:
    """Return the paths of the depth raster, sidecar and world file of an image NAME.tif.

    Raises UsageError if the extension is not that of a TIFF file.
    """
    path = Path(image)
    check_extension(path, (".tif", ".tiff"))
    return (
        path.with_name(f"{path.stem}_depth.tif"),
        path.with_suffix(".json"),
        path.with_suffix(".tfw"),
    )


def write_orthophoto(
    data: Mesh | PointCloud,
    plan: OrthophotoPlan,
    image: str | Path,
    *,
    crs: str | None = None,
    model: str | None = None,
    content_hash: str | None = None,
    sheet: str | Path | None = None,
    force: bool = False,
    progress: Progress | None = None,
    threads: int | None = None,
    drawn_source: TileSource | None = None,
    features: tuple[Item, ...] | None = None,
    legend: bool = True,
    domain_extent: DomainExtent | None = None,
) -> OrthophotoFiles:
    """Draw a picture and write all of its files, or none if one fails.

    Parameters
    ----------
    data : Mesh or PointCloud
    plan : OrthophotoPlan
    image : str or Path
    crs : str or None
        CRS of the World frame, "EPSG:n" or WKT.
    model, content_hash : str or None
        Name and content hash of the model, for the sidecar.
    sheet : str or Path, optional
        File of a scaled page (PNG, JPG or PDF) with the features.
    force : bool
    progress : Progress, optional
    threads : int, optional
    drawn_source : TileSource, optional
        The picture, if it has already been drawn for this plan.
    features : tuple of Item, optional
        Features in the World frame, which are written as vector data.
    legend : bool
        Whether to draw a legend of the features on the sheet.
    domain_extent : DomainExtent, optional
        Domain to show in colour; all others are grey.

    Returns
    -------
    OrthophotoFiles

    Raises
    ------
    TargetError, Cancelled, UsageError
    InputError
        If no pixel shows the model.
    """
    progress = progress or SilentProgress()
    image = Path(image)
    depth, sidecar, world = orthophoto_outputs(image)
    is_map = plan.frame.is_vertical
    drawing, outside_count = draw_features(features or (), plan, None)
    drawings = drawing_targets(image) if drawing.shapes else {}
    targets = [image, depth, sidecar, world, *drawings.values()]
    pages = () if sheet is None else (Path(sheet),)
    targets += pages
    _check_targets(targets, (depth, sidecar, world), force)
    grid = plan.grid
    warnings: list[Finding] = [*plan.notes]
    if is_map and crs is None:
        warnings.append(Finding("raster.no-crs"))
    if features is not None:
        warnings += _feature_findings(drawing, outside_count)
    transform = _transform(plan)
    metadata = picture_metadata(plan, crs if is_map else None)
    picture_crs = crs if is_map else view_plane_crs(plan.view.is_metric, picture_id(metadata))
    raster = Raster(grid.width, grid.height, "rgba", transform, picture_crs, _tags(plan))
    progress.stage(tr("Preparing the model"))
    source = _mask_domain(drawn_source or create_source(data, plan), plan, domain_extent)
    reduced_picture = _ReducedPicture(grid) if sheet is not None or drawings else None
    with atomic_group(targets, force, named_files=pages) as temporary_paths:
        paths = dict(zip(targets, temporary_paths, strict=True))
        with (
            open_geotiff(paths[image], raster, image) as picture_file,
            open_geotiff(paths[depth], replace(raster, kind="float"), depth) as depth_file,
        ):
            tiles = draw_tiles(source, grid, progress, threads)
            covered, filled = _draw(tiles, picture_file, depth_file, reduced_picture)
        progress.stage(tr("Writing the orthophoto"))
        _refuse_empty_picture(covered, plan)
        warnings += source.warnings()
        metadata |= {
            "image": image.name,
            "depth": depth.name,
            "world_file": world.name,
            **_drawing_metadata(covered / (grid.width * grid.height), filled, source),
            "model": model,
            "content_hash": content_hash,
            **_position_metadata(plan, crs, metadata),
            "drawing": {format_: target.name for format_, target in drawings.items()} or None,
            "software": f"VOM Studio {__version__}",
        }
        if reduced_picture is not None:
            drawing = replace(drawing, picture=reduced_picture.reduced_picture())
        if drawings:
            progress.stage(tr("Writing the drawing"))
            drawing_paths = {format_: paths[target] for format_, target in drawings.items()}
            write_drawings(
                drawing_paths, drawing, picture_crs, metadata["picture_id"], raster_rotation(plan)
            )
            metadata["drawn"] = len(drawing.shapes)
        metadata["warnings"] = to_json_list(warnings)
        paths[sidecar].write_text(_sidecar_text(metadata), "utf-8")
        paths[world].write_text(world_file(transform), "ascii")
        for page in pages:
            progress.stage(tr("Drawing the sheet"))
            write_sheet(paths[page], drawing, plan.view, format_from_path(page), legend=legend)
    sheet, coverage = next(iter(pages), None), metadata["coverage"]
    return OrthophotoFiles(
        image, sidecar, depth, world, sheet, drawings, coverage, tuple(warnings), metadata
    )


def _sidecar_text(metadata: dict[str, Any]) -> str:
    """Format the sidecar; for an oblique picture, it states only the CRS of the World frame."""
    stated_facts = {
        key: value for key, value in metadata.items() if key != "crs" or value is not None
    }
    return json.dumps(stated_facts, indent=1, ensure_ascii=False) + "\n"


def _drawing_metadata(coverage: float, filled_count: int, source: TileSource) -> dict[str, Any]:
    metadata = {
        "coverage": coverage,
        "holes_filled_px": filled_count,
        "holes_filled_up_to_m": getattr(source, "hole_m", None),
    }
    return metadata | (
        {"domain": source.domain_extent.metadata} if isinstance(source, DomainTileSource) else {}
    )


def _mask_domain(
    source: TileSource, plan: OrthophotoPlan, domain_extent: DomainExtent | None
) -> TileSource:
    return source if domain_extent is None else DomainTileSource(source, plan, domain_extent)


def _refuse_empty_picture(n_covered: int, plan: OrthophotoPlan) -> None:
    if not n_covered:
        raise InputError(
            edge_on_finding(plan.points, plan.frame, plan.grid.gsd) or Finding("view.no-pixels")
        )


def _feature_findings(drawing: Drawing, n_outside: int) -> list[Finding]:
    """Report features outside the view."""
    if not drawing.shapes:
        return [Finding("interpretation.not-in-view")]
    return [Finding("interpretation.partly-in-view", count=n_outside)] if n_outside else []


def _position_metadata(
    plan: OrthophotoPlan, crs: str | None, metadata: dict[str, Any]
) -> dict[str, Any]:
    """Return the metadata of the position of the picture in the World frame.

    `crs` is the CRS of the World frame, regardless of that of the picture.
    """
    north = world_north(crs, is_known=plan.view.is_north_known)
    return {"world_crs": crs, "north": north, "picture_id": picture_id(metadata)}


def _check_targets(targets: Iterable[Path], generated_paths: Iterable[Path], force: bool) -> None:
    """Check the target files; `generated_paths` are those named after the picture.

    Raises
    ------
    TargetError
    """
    for target in generated_paths:
        check_generated_path(target)
    for target in targets:
        check_target(target, force=force)


def _transform(plan: OrthophotoPlan) -> Affine:
    """Return the transform from pixels to map coordinates, or to metres in an oblique plane."""
    grid, matrix = plan.grid, plan.pixel_to_world
    if plan.frame.is_vertical:
        a, b, c = matrix[0, [0, 1, 3]].tolist()
        d, e, f = matrix[1, [0, 1, 3]].tolist()
        return (a, b, c, d, e, f)
    return (grid.gsd, 0.0, grid.left, 0.0, -grid.gsd, -grid.top)


def _tags(plan: OrthophotoPlan) -> dict[str, str]:
    view = plan.view
    return {
        "VOMSTUDIO_VERSION": __version__,
        "VOMSTUDIO_VIEW": f"trend {format_plain_azimuth(view.trend_deg)} "
        f"plunge {view.plunge_deg:.4f} deg",
        "VOMSTUDIO_SENSE": f"{view.sense}. {view.reason.message}",
        "VOMSTUDIO_PIXEL_TO_WORLD": json.dumps(plan.pixel_to_world.tolist()),
    }


def _draw(
    drawn_tiles: Iterable[tuple[Tile, TilePicture]],
    picture_file: Any,
    depth_file: Any,
    reduced_picture: _ReducedPicture | None,
) -> tuple[int, int]:
    """Write tiles to both rasters; return the numbers of covered and of filled pixels."""
    covered_count = filled_count = 0
    for tile, picture in drawn_tiles:
        write_tile(picture_file, tile.column, tile.row, picture.rgba)
        write_tile(depth_file, tile.column, tile.row, picture.depth)
        covered_count += int(np.isfinite(picture.depth).sum())
        filled_count += picture.filled
        if reduced_picture is not None:
            reduced_picture.add(tile.column, tile.row, picture.rgba)
    return covered_count, filled_count


class _ReducedPicture:
    """Reduced picture for the sheet, box-filtered from the tiles."""

    MAX_SIDE_PX = 2400

    def __init__(self, grid: Grid) -> None:
        factor = 1
        while max(grid.width, grid.height) / factor > self.MAX_SIDE_PX and factor < TILE:
            factor *= 2
        self.factor = factor
        self._size = (grid.width, grid.height)
        self.out = np.zeros((-(-grid.height // factor), -(-grid.width // factor), 4), np.uint8)

    def add(self, column: int, row: int, rgba: ByteArray) -> None:
        factor = self.factor
        height, width = rgba.shape[:2]
        padded_tile = np.zeros(
            (-(-height // factor) * factor, -(-width // factor) * factor, 4), np.float32
        )
        padded_tile[:height, :width] = rgba
        padded_tile[:height, :width, :3] *= rgba[..., 3:] / np.float32(255)
        mean = padded_tile.reshape(
            padded_tile.shape[0] // factor, factor, padded_tile.shape[1] // factor, factor, 4
        ).mean(axis=(1, 3))
        alpha = np.maximum(mean[..., 3:] / 255, 1e-6)
        mean[..., :3] = np.where(mean[..., 3:] > 0, mean[..., :3] / alpha, 0)
        position = self.out[row // factor :, column // factor :]
        position[: mean.shape[0], : mean.shape[1]] = np.clip(np.rint(mean), 0, 255)

    def reduced_picture(self) -> ByteArray:
        """Return the picture, resized so that it covers exactly the grid."""
        from PIL import Image

        height, width = self.out.shape[:2]
        box = (0.0, 0.0, self._size[0] / self.factor, self._size[1] / self.factor)
        return np.asarray(Image.fromarray(self.out).resize((width, height), box=box))


def create_source(data: Mesh | PointCloud, plan: OrthophotoPlan) -> TileSource:
    """Create the source of tiles for a plan."""
    if isinstance(data, Mesh):
        from vomstudio.products.ortho.mesh_picture import MeshSource

        return MeshSource(data, plan.points, plan.grid)
    from vomstudio.io.models.opening import point_spacing
    from vomstudio.products.ortho.cloud_picture import CloudSource

    spacing = point_spacing(PointCloud(plan.points))
    if not math.isfinite(spacing) or spacing <= 0:
        spacing = plan.grid.gsd
    return CloudSource(data, plan.points, plan.grid, spacing)


def picture_metadata(plan: OrthophotoPlan, crs: str | None) -> dict[str, Any]:
    """Return the sidecar metadata of a planned picture; only a map has a `crs`."""
    transform = _transform(plan)
    grid, frame, view = plan.grid, plan.frame, plan.view
    unit = "metres" if view.is_metric else "units"
    return {
        "width": grid.width,
        "height": grid.height,
        "gsd_m": grid.gsd,
        "trend_deg": view.trend_deg,
        "plunge_deg": view.plunge_deg,
        "direction": frame.direction.tolist(),
        "right": frame.right.tolist(),
        "down": frame.down.tolist(),
        "sense": view.sense,
        "sense_reason": view.reason.to_dict(),
        "pixel_to_world": plan.pixel_to_world.tolist(),
        "pixel_to_world_means": "(column, row, depth_m, 1) to World x, y, z; (0, 0) is the outer "
        "corner of the top left pixel, its centre is (0.5, 0.5)",
        "reference_point": plan.reference.tolist(),
        "depth_means": f"{unit} along the view direction from the plane through the reference "
        "point, growing away from the viewer; NaN where nothing is seen",
        "unit": "metre" if view.is_metric else "unit of the model, whose scale is not known",
        "north": None if view.is_north_known else "not known: angles are of the model's own frame",
        "crs": crs,
        "geotransform": list(transform),
        "plane_coordinates": None
        if frame.is_vertical
        else f"{unit} right and up of the reference point",
    }
