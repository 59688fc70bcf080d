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
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError, InputError, UsageError
from vomstudio.geology.orientation import Plane, lines_to_vectors, vectors_to_lines, wrap360
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.products.ortho.tiles import Grid, Source, TilePicture
from vomstudio.progress import Progress, Silent
from vomstudio.version import __version__

Array = npt.NDArray[np.float64]

MAX_PIXELS = 300_000_000
MAX_THREADS = 8

Basis = Literal["line", "plane", "fold"]


@dataclass(frozen=True)
class View:
    """A directed view, and in words why it looks this way and not the other.

    trend_deg, plunge_deg : the way the viewer looks; a negative plunge looks up
    sense : "as given", "against the upward normal", "along the upward normal", "down-plunge",
        "up-plunge"
    reason : one sentence
    north_known, metric : False for a model whose north or whose scale is not known: the sheet then
        names no winds, and counts units
    """

    trend_deg: float
    plunge_deg: float
    sense: str
    reason: str
    north_known: bool = True
    metric: bool = True

    @property
    def frame(self) -> ViewFrame:
        return ViewFrame.looking(lines_to_vectors(self.trend_deg, self.plunge_deg))

    def flipped(self) -> View:
        """From the other side: a mirror image."""
        other = {
            "down-plunge": "up-plunge",
            "up-plunge": "down-plunge",
            "against the upward normal": "along the upward normal",
            "along the upward normal": "against the upward normal",
            "as given": "against the given direction",
            "against the given direction": "as given",
        }
        return View(
            wrap360(self.trend_deg + 180.0),
            0.0 - self.plunge_deg,
            other[self.sense],
            f"Flipped by request; {_lower(self.reason)}",
        )


def view_along_line(trend_deg: float, plunge_deg: float) -> View:
    """A view as typed. Raises UsageError for a plunge beyond 90 degrees."""
    if not (math.isfinite(trend_deg) and math.isfinite(plunge_deg)) or abs(plunge_deg) > 90:
        raise UsageError(
            "a view needs a trend in degrees and a plunge from -90 (up) to 90 (down).",
            field="--plunge",
        )
    return View(
        wrap360(trend_deg), plunge_deg, "as given", "The viewer looks along the direction given."
    )


def view_of_plane(plane: Plane) -> View:
    """Against the plane's upward normal; a vertical plane is looked at toward its dip direction
    + 180."""
    return _along(
        -plane.normal(),
        "against the upward normal",
        "The viewer looks against the upward normal of the plane.",
    )


def view_along_axis(
    trend_deg: float, plunge_deg: float, data: Mesh | PointCloud, to_world: npt.ArrayLike
) -> View:
    """Along a fold axis (axial): down-plunge, unless most of what that view hits turns its back to
    the viewer, which is a cliff seen from inside: then up-plunge."""
    down = lines_to_vectors(trend_deg, plunge_deg)
    if plunge_deg < 0:
        down = -down
    away, guessed = _facing_away(data, ViewFrame.looking(down), to_world)
    how = ", judged by surfaces taken to face up" if guessed else ""
    if math.isfinite(away) and away > 0.5:
        return _along(
            -down,
            "up-plunge",
            f"Down-plunge {away:.0%} of what is hit faces away from the viewer{how}.",
        )
    share = "" if math.isnan(away) else f": {1 - away:.0%} of what is hit faces the viewer{how}"
    return _along(down, "down-plunge", f"Down-plunge{share}.")


@dataclass(frozen=True, eq=False)
class Plan:
    """What an orthophoto will be, before a ray is cast.

    reference : (3,) World, the centre of the model's bounds, where depth is 0
    notes : what was chosen for the user, one sentence each
    """

    view: View
    frame: ViewFrame
    grid: Grid
    reference: Array
    points: Array
    notes: tuple[str, ...]

    @property
    def pixel_to_world(self) -> Array:
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
    vertices = data.vertices if isinstance(data, Mesh) else data.points
    if not len(vertices) or (isinstance(data, Mesh) and not len(data.faces)):
        raise InputError("there is no surface in this model to look at.")
    world = _to_world(to_world, vertices)
    if isinstance(data, Mesh):
        used = np.zeros(len(world), bool)
        used[data.faces.ravel()] = True
        seen = world if used.all() else world[used]
    else:
        seen = world
    reference = seen.min(axis=0) + (seen.max(axis=0) - seen.min(axis=0)) / 2
    frame = view.frame
    points = frame.to_view(world, reference)
    low, high = (f(points if seen is world else points[used], axis=0) for f in (np.min, np.max))
    notes: list[str] = []
    if region is not None:
        centre = frame.to_view(np.array([region.centre]), reference)[0]
        half = 0.5 * np.array([region.width, region.height])
        low[:2], high[:2] = (
            np.maximum(low[:2], centre[:2] - half),
            np.minimum(high[:2], centre[:2] + half),
        )
        if (low[:2] > high[:2]).any():
            raise InputError("nothing of this model is in the chosen part of the view.")
    extent = np.maximum(high - low, 0.0)[:2]
    if gsd is None:
        gsd, why = default_gsd(data, to_world, float(extent.max()))
        least = _least_gsd(extent)
        if least > gsd:
            gsd = least
            why = f"the finest that stays under {MAX_PIXELS // 1_000_000} million pixels"
        notes.append(f"gsd {gsd:g} m per pixel: {why}")
    if not math.isfinite(gsd) or gsd <= 0:
        raise UsageError("the size of a pixel must be a length in metres.", field="--gsd")
    least = _least_gsd(extent)
    pixels = math.prod(max(1, math.ceil(v / gsd)) for v in extent.tolist())
    if pixels > MAX_PIXELS:
        raise UsageError(
            f"pixels of {gsd:g} m would make a picture of {pixels / 1e6:.0f} million pixels; at "
            f"most {MAX_PIXELS // 1_000_000} million are made: --gsd {least:g} would do.",
            field="--gsd",
        )
    return Plan(view, frame, Grid.over(low, high, gsd), reference, points, tuple(notes))


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
            "an orthophoto is a GeoTIFF; let its name end in .tif.", file=path, field="--output"
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
) -> Made:
    """Draw and write all files, whole or none of them.

    crs : of World ("EPSG:n" or WKT). model, content_hash : for the sidecar. sheet : a picture for
    people (PNG, JPG or PDF) with scale bar and orientation. Raises TargetError, Cancelled.
    """
    from vomstudio.files.atomic import atomic_write, check_target
    from vomstudio.io.gis.raster import VIEW_PLANE_CRS, Raster, open_geotiff, world_file

    progress = progress or Silent()
    image = Path(image)
    depth, sidecar, world = outputs_of(image)
    is_map = plan.frame.is_vertical
    targets = [image, depth, sidecar]
    targets += [world] if is_map else []
    targets += [Path(sheet)] if sheet is not None else []
    for target in [*targets, *([world] if world.exists() and not is_map else [])]:
        check_target(target, force=force)
    grid, matrix = plan.grid, plan.pixel_to_world
    warnings = list(plan.notes)
    if is_map and crs is None:
        warnings.append(
            "the model names no CRS, so the picture has the model's coordinates without one."
        )
    transform = (
        (*matrix[0, [0, 1, 3]].tolist(), *matrix[1, [0, 1, 3]].tolist())
        if is_map
        else (grid.gsd, 0.0, grid.left, 0.0, -grid.gsd, -grid.top)
    )
    facts = _facts(plan, crs if is_map else None, transform)
    trend = wrap360(round(plan.view.trend_deg, 4))
    tags = {
        "VOMSTUDIO_VERSION": __version__,
        "VOMSTUDIO_VIEW": f"trend {trend:.4f} plunge {plan.view.plunge_deg:.4f} deg",
        "VOMSTUDIO_SENSE": f"{plan.view.sense}. {plan.view.reason}",
        "VOMSTUDIO_PIXEL_TO_WORLD": json.dumps(matrix.tolist()),
    }
    raster = Raster(
        grid.width, grid.height, "rgba", transform, crs if is_map else VIEW_PLANE_CRS, tags
    )
    progress.stage("preparing the model")
    source = _source(data, plan)
    covered = filled = 0
    small = _Reduced(grid) if sheet is not None else None
    with contextlib.ExitStack() as files:
        paths = {target: files.enter_context(atomic_write(target, force)) for target in targets}
        with (
            open_geotiff(paths[image], raster, image) as picture_file,
            open_geotiff(paths[depth], replace(raster, kind="float"), depth) as depth_file,
        ):
            for tile, drawn in _drawn(source, grid, progress, threads):
                from vomstudio.io.gis.raster import write_tile

                write_tile(picture_file, tile.column, tile.row, drawn.rgba)
                write_tile(depth_file, tile.column, tile.row, drawn.depth)
                covered += int(np.isfinite(drawn.depth).sum())
                filled += drawn.filled
                if small is not None:
                    small.add(tile.column, tile.row, drawn.rgba)
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
            from vomstudio.products.ortho.sheet import draw_sheet

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


def _drawn(source: Source, grid: Grid, progress: Progress, threads: int | None) -> Any:
    """Yield (tile, picture) as they are done; a few at a time, so that memory stays bounded."""
    tiles = grid.tiles()
    progress.stage("casting rays", len(tiles))
    workers = max(1, min(threads or os.cpu_count() or 1, MAX_THREADS, len(tiles)))
    waiting = iter(tiles)
    running: dict[Future[TilePicture], Any] = {}
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
        from vomstudio.products.ortho.tiles import TILE

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


def _source(data: Mesh | PointCloud, plan: Plan) -> Source:
    if isinstance(data, Mesh):
        from vomstudio.products.ortho.mesh_picture import MeshSource

        return MeshSource(data, plan.points, plan.grid)
    from vomstudio.io.models.opening import resolution
    from vomstudio.products.ortho.cloud_picture import CloudSource

    spacing = resolution(PointCloud(plan.points))
    if not math.isfinite(spacing) or spacing <= 0:
        spacing = plan.grid.gsd
    return CloudSource(data, plan.points, plan.grid, spacing)


def _facts(plan: Plan, crs: str | None, transform: tuple[float, ...]) -> dict[str, Any]:
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


def cost_of_direction(error_deg: float | None, depth_m: float, *, metric: bool = True) -> str:
    """What a direction that is off costs in a picture so deep (CONVENTIONS: lengths times cos d in
    the direction of tilt, displacements h sin d along the view), in a sentence. error_deg: the
    larger 95 % semi-axis of the direction; None where unknown, and 5 degrees are supposed."""
    off = 5.0 if error_deg is None else error_deg
    unit = "m" if metric else "units"
    known = "" if error_deg is None else ", the semi-axis of its 95 % confidence,"
    return (
        f"an axis wrong by {off:.1f} deg{known} shortens lengths in the direction of tilt by "
        f"{1 - math.cos(math.radians(off)):.1%} and displaces points against each other by up to "
        f"{depth_m * math.sin(math.radians(off)):.3g} {unit} over the {depth_m:.3g} {unit} that "
        "this view is deep."
    )


def default_gsd(
    data: Mesh | PointCloud, to_world: npt.ArrayLike, extent: float
) -> tuple[float, str]:
    """Two significant digits of what the model can show, and where that comes from."""
    from vomstudio.geometry.transform import matrix, scale_of
    from vomstudio.io.models.opening import resolution

    scale = scale_of(matrix(np.asarray(to_world, np.float64)))
    found, why = math.nan, ""
    if isinstance(data, Mesh):
        from vomstudio.products.ortho.mesh_picture import texel_sizes

        sizes = sorted((size, area) for _, size, area in texel_sizes(data, data.vertices).values())
        if sizes:
            share = np.cumsum([area for _, area in sizes])
            found = sizes[int(np.searchsorted(share, 0.5 * share[-1]))][0] * scale
            why = "the texture's own resolution on the surface"
    if not math.isfinite(found) or found <= 0:
        found = resolution(data) * scale
        why = (
            "the mean length of the mesh's edges"
            if isinstance(data, Mesh)
            else "the cloud's mean spacing"
        )
    if not math.isfinite(found) or found <= 0:
        found, why = max(extent, 1.0) / 1000, "a thousandth of the model's size"
    return float(f"{found:.2g}"), why


def _least_gsd(extent: Array) -> float:
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


def _facing_away(
    data: Mesh | PointCloud, frame: ViewFrame, to_world: npt.ArrayLike
) -> tuple[float, bool]:
    if isinstance(data, Mesh):
        from vomstudio.products.ortho import mesh_picture

        if not len(data.faces):
            raise InputError("there is no surface in this model to look at.")
        world = _to_world(to_world, data.vertices)
        return mesh_picture.share_facing_away(frame.to_view(world, world[0]), data.faces), False
    from vomstudio.geometry.transform import rotate
    from vomstudio.products.ortho import cloud_picture

    if not len(data.points):
        raise InputError("there is no point in this model to look at.")
    world = _to_world(to_world, data.points)
    normals = None
    if data.normals is not None:
        normals = rotate(np.asarray(to_world, np.float64), data.normals) @ frame.axes
    up = np.array([0.0, 0.0, 1.0]) @ frame.axes
    return cloud_picture.share_facing_away(data, frame.to_view(world, world[0]), normals, up)


def _to_world(to_world: npt.ArrayLike, points: Array) -> Array:
    from vomstudio.geometry.transform import apply

    m = np.asarray(to_world, np.float64)
    if m.shape != (4, 4) or not np.isfinite(m).all():
        raise GeometryError("The model's transform to World is not a matrix of 4 x 4 numbers.")
    return points if np.array_equal(m, np.eye(4)) else apply(m, points)


def _along(direction: Array, sense: str, reason: str) -> View:
    trend, plunge, _ = vectors_to_lines(direction, directed=True)
    return View(float(trend[0]), float(plunge[0]), sense, reason)


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]
