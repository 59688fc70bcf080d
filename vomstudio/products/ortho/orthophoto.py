"""Scale-true pictures of a model along any direction, with what each pixel means.

The geometry is that of `geometry.view_frame`. What is written: a GeoTIFF (RGBA), a depth raster
(float32, NaN = nothing), a JSON sidecar with the matrix from (column, row, depth) to World, and,
for a view straight down or up only, a world file. A picture on a slanting plane is no map: its
GeoTIFF has an engineering CRS in metres of its own plane, from the reference point right and up.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import UsageError
from vomstudio.files.atomic import atomic_write, check_target
from vomstudio.files.inside import check_beside
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.gis.raster import (
    Affine,
    Raster,
    open_geotiff,
    view_plane_crs,
    world_file,
    write_tile,
)
from vomstudio.products.ortho.planning import Plan
from vomstudio.products.ortho.sheet import draw_sheet
from vomstudio.products.ortho.tiles import TILE, Grid, Source, Tile, TilePicture
from vomstudio.progress import Progress, Silent
from vomstudio.version import __version__
from vomstudio.words import to_translate, tr

Array = npt.NDArray[np.float64]

MAX_THREADS = 8
_NO_CRS = to_translate(
    "The model has no coordinate reference system (CRS). The orthophoto is written in the model's "
    "coordinates, without a CRS."
)


@dataclass(frozen=True, eq=False)
class Made:
    """What was written. coverage : share of the pixels that show the model."""

    image: Path
    sidecar: Path
    depth: Path
    world_file: Path | None
    sheet: Path | None
    coverage: float
    warnings: tuple[str, ...]
    facts: dict[str, Any]


def outputs_of(image: str | Path) -> tuple[Path, Path, Path]:
    """Depth raster, sidecar and world file beside an image NAME.tif: NAME_depth.tif, NAME.json,
    NAME.tfw."""
    path = Path(image)
    if path.suffix.lower() not in (".tif", ".tiff"):
        raise UsageError(
            tr("An orthophoto is a GeoTIFF. Choose a name that ends in .tif."),
            file=path,
            field="--output",
        )
    return (
        path.with_name(f"{path.stem}_depth.tif"),
        path.with_suffix(".json"),
        path.with_suffix(".tfw"),
    )


def write_orthophoto(
    data: Mesh | PointCloud,
    plan: Plan,
    image: str | Path,
    *,
    crs: str | None = None,
    model: str | None = None,
    content_hash: str | None = None,
    sheet: str | Path | None = None,
    force: bool = False,
    progress: Progress | None = None,
    threads: int | None = None,
    drawn: Source | None = None,
) -> Made:
    """Draw and write all files, whole or none of them.

    crs : of World ("EPSG:n" or WKT). model, content_hash : for the sidecar. sheet : a picture for
    people (PNG, JPG or PDF) with scale bar and orientation. drawn : the picture, where it has been
    drawn by this plan already. Raises TargetError, Cancelled.
    """
    progress = progress or Silent()
    image = Path(image)
    depth, sidecar, world = outputs_of(image)
    is_map = plan.frame.is_vertical
    targets = [image, depth, sidecar]
    targets += [world] if is_map else []
    targets += [Path(sheet)] if sheet is not None else []
    # A world file of an earlier picture would place another one in the landscape.
    _check_targets([*targets, world], (depth, sidecar, world), force)
    grid = plan.grid
    warnings = [*plan.notes, *([tr(_NO_CRS)] if is_map and crs is None else [])]
    transform = _transform(plan)
    facts = picture_facts(plan, crs if is_map else None)
    shown_crs = crs if is_map else view_plane_crs(plan.view.metric)
    raster = Raster(grid.width, grid.height, "rgba", transform, shown_crs, _tags(plan))
    progress.stage(tr("Preparing the model"))
    source = drawn or source_of(data, plan)
    small = _Reduced(grid) if sheet is not None else None
    with contextlib.ExitStack() as files:
        paths = {target: files.enter_context(atomic_write(target, force)) for target in targets}
        with (
            open_geotiff(paths[image], raster, image) as picture_file,
            open_geotiff(paths[depth], replace(raster, kind="float"), depth) as depth_file,
        ):
            covered, filled = _draw(
                drawn_tiles(source, grid, progress, threads), picture_file, depth_file, small
            )
        coverage = covered / (grid.width * grid.height)
        warnings += source.warnings()
        facts |= {
            "image": image.name,
            "depth": depth.name,
            "world_file": world.name if is_map else None,
            "coverage": coverage,
            "holes_filled_px": filled,
            "holes_filled_up_to_m": getattr(source, "hole_m", None),
            "model": model,
            "content_hash": content_hash,
            "warnings": warnings,
            "software": f"VOM Studio {__version__}",
        }
        paths[sidecar].write_text(json.dumps(facts, indent=1, ensure_ascii=False) + "\n", "utf-8")
        if is_map:
            paths[world].write_text(world_file(transform), "ascii")
        if sheet is not None and small is not None:
            draw_sheet(paths[Path(sheet)], small.picture(), small.factor * grid.gsd, plan.view)
    if not is_map:
        # One of an earlier picture of this name would put this one on the map.
        world.unlink(missing_ok=True)
    return Made(
        image,
        sidecar,
        depth,
        world if is_map else None,
        None if sheet is None else Path(sheet),
        coverage,
        tuple(warnings),
        facts,
    )


def _check_targets(targets: Iterable[Path], ours: Iterable[Path], force: bool) -> None:
    """ours : those whose names follow from the picture's. Raises TargetError."""
    for target in ours:
        check_beside(target)
    for target in targets:
        check_target(target, force=force)


def _transform(plan: Plan) -> Affine:
    """Of a map from pixels to World; of any other picture to metres in its own plane."""
    grid, matrix = plan.grid, plan.pixel_to_world
    if plan.frame.is_vertical:
        a, b, c = matrix[0, [0, 1, 3]].tolist()
        d, e, f = matrix[1, [0, 1, 3]].tolist()
        return (a, b, c, d, e, f)
    return (grid.gsd, 0.0, grid.left, 0.0, -grid.gsd, -grid.top)


def _tags(plan: Plan) -> dict[str, str]:
    view = plan.view
    trend = wrap360(round(view.trend_deg, 4))
    return {
        "VOMSTUDIO_VERSION": __version__,
        "VOMSTUDIO_VIEW": f"trend {trend:.4f} plunge {view.plunge_deg:.4f} deg",
        "VOMSTUDIO_SENSE": f"{view.sense}. {view.reason}",
        "VOMSTUDIO_PIXEL_TO_WORLD": json.dumps(plan.pixel_to_world.tolist()),
    }


def _draw(
    drawn: Iterable[tuple[Tile, TilePicture]],
    picture_file: Any,
    depth_file: Any,
    small: _Reduced | None,
) -> tuple[int, int]:
    """Write the tiles to both rasters. Returns how many pixels show the model, and how many of them
    were holes."""
    covered = filled = 0
    for tile, picture in drawn:
        write_tile(picture_file, tile.column, tile.row, picture.rgba)
        write_tile(depth_file, tile.column, tile.row, picture.depth)
        covered += int(np.isfinite(picture.depth).sum())
        filled += picture.filled
        if small is not None:
            small.add(tile.column, tile.row, picture.rgba)
    return covered, filled


def drawn_tiles(
    source: Source, grid: Grid, progress: Progress, threads: int | None
) -> Iterator[tuple[Tile, TilePicture]]:
    """Yield (tile, picture) as they are done; a few at a time, so that memory stays bounded."""
    tiles = grid.tiles()
    progress.stage(tr("Casting rays"), len(tiles))
    workers = max(1, min(threads or os.cpu_count() or 1, MAX_THREADS, len(tiles)))
    waiting = iter(tiles)
    running: dict[Future[TilePicture], Tile] = {}
    done = 0
    with ThreadPoolExecutor(workers) as pool:
        try:
            while True:
                for tile in waiting:
                    running[pool.submit(source.draw, tile)] = tile
                    if len(running) > workers:
                        break
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
                    done += 1
                    progress.step(done)
        finally:
            for future in running:
                future.cancel()


class _Reduced:
    """The picture for the sheet, box-averaged while tiles come in."""

    LONGEST = 2400

    def __init__(self, grid: Grid) -> None:
        factor = 1
        while max(grid.width, grid.height) / factor > self.LONGEST and factor < TILE:
            factor *= 2
        self.factor = factor
        self._out = np.zeros((-(-grid.height // factor), -(-grid.width // factor), 4), np.uint8)

    def add(self, column: int, row: int, rgba: npt.NDArray[np.uint8]) -> None:
        f = self.factor
        h, w = rgba.shape[:2]
        padded = np.zeros((-(-h // f) * f, -(-w // f) * f, 4), np.float32)
        padded[:h, :w] = rgba
        padded[:h, :w, :3] *= rgba[..., 3:] / np.float32(255)
        mean = padded.reshape(padded.shape[0] // f, f, padded.shape[1] // f, f, 4).mean(axis=(1, 3))
        share = np.maximum(mean[..., 3:] / 255, 1e-6)
        mean[..., :3] = np.where(mean[..., 3:] > 0, mean[..., :3] / share, 0)
        at = self._out[row // f :, column // f :]
        at[: mean.shape[0], : mean.shape[1]] = np.clip(np.rint(mean), 0, 255)

    def picture(self) -> npt.NDArray[np.uint8]:
        return self._out


def source_of(data: Mesh | PointCloud, plan: Plan) -> Source:
    """What draws the tiles of the plan's grid."""
    if isinstance(data, Mesh):
        from vomstudio.products.ortho.mesh_picture import MeshSource

        return MeshSource(data, plan.points, plan.grid)
    from vomstudio.io.models.opening import point_spacing
    from vomstudio.products.ortho.cloud_picture import CloudSource

    spacing = point_spacing(PointCloud(plan.points))
    if not math.isfinite(spacing) or spacing <= 0:
        spacing = plan.grid.gsd
    return CloudSource(data, plan.points, plan.grid, spacing)


def picture_facts(plan: Plan, crs: str | None) -> dict[str, Any]:
    """What the sidecar says of a planned picture. crs : of a map, else None"""
    transform = _transform(plan)
    grid, frame, view = plan.grid, plan.frame, plan.view
    unit = "metres" if view.metric else "units"
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
        "sense_reason": view.reason,
        "pixel_to_world": plan.pixel_to_world.tolist(),
        "pixel_to_world_means": "(column, row, depth_m, 1) to World x, y, z; (0, 0) is the outer "
        "corner of the top left pixel, its centre is (0.5, 0.5)",
        "reference_point": plan.reference.tolist(),
        "depth_means": f"{unit} along the view direction from the plane through the reference "
        "point, growing away from the viewer; NaN where nothing is seen",
        "unit": "metre" if view.metric else "unit of the model, whose scale is not known",
        "north": None if view.north_known else "not known: angles are of the model's own frame",
        "crs": crs,
        "geotransform": list(transform),
        "plane_coordinates": None
        if frame.is_vertical
        else f"{unit} right and up of the reference point",
    }
