"""Back-projection of lines drawn on an orthophoto in another program onto the surface."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import MAX_SIDECAR_BYTES, open_regular_file, read_json
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.dxf_properties import read_dxf_properties
from vomstudio.io.gis.line_reading import (
    DEFAULT_LAYERS,
    FeatureAttributes,
    GisLine,
    GisLines,
    read_gis_lines,
)
from vomstudio.io.gis.svg_lines import SvgDrawing, read_svg
from vomstudio.products.ortho.drawn_features import picture_comment, picture_id
from vomstudio.products.ortho.visible_depth import visible_depths

ASPECT_TOLERANCE = 0.01
"""Tolerance of the aspect ratio for identifying a page or picture as the orthophoto."""
MIN_INSIDE_SHARE = 0.5
"""Minimum share of the vertices of a drawing that must lie inside its picture."""
PROGRAM_LAYERS = ("traces", "patches", "planes", "lines", "frame")
"""Layers of drawings written by this program; layers of interpretations are named differently."""
POSITION_TOLERANCE = 1e-3
"""Maximum distance between identical pictures, relative to their size."""
_MAX_PIXELS = 1 << 31
_MARK = re.compile(r"(?:VOM Studio picture|VOM Studio view plane) ([0-9a-f]{16})")


@dataclass(frozen=True, eq=False)
class Sidecar:
    """Geometry of an orthophoto.

    Parameters
    ----------
    path : Path
    width, height : int
    matrix : (4, 4) array
        Matrix from (column, row, depth, 1) to the World frame.
    transform : (3, 3) array
        Matrix from pixels to the coordinates of the GeoTIFF.
    crs : str or None
        CRS of the GeoTIFF; None if the picture is on an oblique plane.
    is_oblique : bool
        Whether the picture is on an oblique plane.
    id : str
    content_hash : str or None
    image : str
    """

    path: Path
    width: int
    height: int
    matrix: FloatArray
    transform: FloatArray
    crs: str | None
    is_oblique: bool
    id: str
    content_hash: str | None
    image: str


@dataclass(frozen=True, eq=False)
class BackProjectedLine:
    """Line back-projected onto the surface.

    Parameters
    ----------
    name : str
    layer : str
        Layer on which the line was drawn.
    words : FeatureAttributes
    pixels : (m, 2) float64
        Column and row of the vertices on the picture.
    is_on_surface : (m,) bool
        Whether the ray of each vertex intersects the surface.
    points : (n, 3) float64
        Intersections of the rays with the surface, in the World frame.
    """

    name: str
    layer: str
    words: FeatureAttributes
    pixels: FloatArray
    is_on_surface: BoolArray
    points: FloatArray


@dataclass(frozen=True, eq=False)
class ProjectedLines:
    """Lines of a drawing on the surface; lines with fewer than two points are `skipped`."""

    lines: tuple[BackProjectedLine, ...]
    skipped: tuple[BackProjectedLine, ...]

    @property
    def points(self) -> int:
        """Total number of points."""
        return sum(len(line.points) for line in self.lines)

    @property
    def off_surface_count(self) -> int:
        """Number of points that do not hit the surface."""
        return sum(int((~line.is_on_surface).sum()) for line in (*self.lines, *self.skipped))

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """Findings about points off the surface."""
        return off_surface_findings(self.off_surface_count, len(self.skipped))


def off_surface_findings(points: int, lines: int) -> tuple[Finding, ...]:
    """Return findings about points off the surface, and lines with fewer than two on it."""
    findings: tuple[Finding, ...] = ()
    if points:
        findings = (Finding("drawing.points-off-surface", count=points),)
    if lines:
        findings += (Finding("drawing.lines-off-surface", count=lines),)
    return findings


def read_sidecar(path: str | Path) -> Sidecar:
    """Read the sidecar of an orthophoto.

    Raises
    ------
    InputError
        If the file cannot be read, is not a sidecar, or contains no valid geometry.
    """
    path = Path(path)
    try:
        metadata = read_json(path, MAX_SIDECAR_BYTES)
        matrix = np.array(metadata["pixel_to_world"], np.float64).reshape(4, 4)
        a, b, c, d, e, f = (float(v) for v in metadata["geotransform"])
        width, height = int(metadata["width"]), int(metadata["height"])
        is_oblique = metadata["plane_coordinates"] is not None
        crs, content_hash = _text(metadata.get("crs")), _text(metadata.get("content_hash"))
    except OSError as error:
        raise InputError(
            Finding("file.unreadable", reason=error.strerror), file=path, field="--sidecar"
        ) from error
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise InputError(Finding("sidecar.other-file"), file=path, field="--sidecar") from error
    transform = np.array([[a, b, c], [d, e, f], [0.0, 0.0, 1.0]])
    if not (np.isfinite(matrix).all() and np.isfinite(transform).all() and width > 0 < height):
        raise InputError(Finding("sidecar.no-place"), file=path)
    with np.errstate(all="ignore"):
        is_singular = not (abs(np.linalg.det(matrix)) > 0 < abs(np.linalg.det(transform)))
    if is_singular or max(width, height) > _MAX_PIXELS:
        raise InputError(Finding("sidecar.no-place"), file=path)
    return Sidecar(
        path,
        width,
        height,
        matrix,
        transform,
        crs,
        is_oblique,
        str(metadata.get("picture_id") or picture_id(metadata)),
        content_hash,
        str(metadata.get("image") or path.name),
    )


@np.errstate(all="ignore")
def read_drawing(
    path: str | Path, sidecar: Sidecar, progress: Progress | None = None
) -> tuple[tuple[GisLine, ...], tuple[Finding, ...]]:
    """Read the lines of a drawing in picture pixels (column, row), with warnings.

    Raises
    ------
    InputError
        If the file cannot be read, contains no lines, or belongs to another picture.
    """
    path = Path(path)
    warnings: list[Finding] = []
    if path.suffix.lower() in (".svg", ".svgz"):
        drawing = read_svg(path)
        _check_marks(drawing.marks, sidecar, path)
        to_pixels = _page_to_pixels(drawing, sidecar, path)
        lines = [_transform_line(line, to_pixels) for line in drawing.lines]
    else:
        lines, findings = _read_gis_lines(path, sidecar, progress)
        warnings += findings
        if path.suffix.lower() == ".dxf":
            # Lines in CAD files have no names, so use the layer instead.
            lines = [replace(line, name=line.name or _layer_name(line.layer)) for line in lines]
    if not lines:
        raise InputError(Finding("drawing.no-traces"), file=path)
    if not all(np.isfinite(line.points).all() for line in lines):
        raise InputError(Finding("drawing.not-finite"), file=path)
    if _inside_share(lines, sidecar) < MIN_INSIDE_SHARE:
        raise InputError(Finding("drawing.other-picture"), file=path, field="--sidecar")
    return tuple(lines), tuple(warnings)


def find_sidecars(drawing: Path, progress: Progress | None = None) -> list[Path]:
    """Find the sidecars in a drawing's folder whose pictures match the drawing.

    If the name of the drawing begins with the names of matching sidecars, only the one with the
    longest name is returned.
    """
    progress = progress or SilentProgress()
    matches = []
    candidates = sorted(drawing.parent.glob("*.json"))
    for done_count, path in enumerate(candidates):
        progress.stage(tr("Finding the orthophoto of the drawing"), len(candidates))
        progress.step(done_count)
        try:
            read_drawing(drawing, read_sidecar(path), progress)
        except InputError:
            continue
        matches.append(path)
    matches_by_name = [path for path in matches if drawing.stem.startswith(path.stem)]
    return [max(matches_by_name, key=lambda path: len(path.stem))] if matches_by_name else matches


def transform_sidecar(sidecar: Sidecar, to_world: Sequence[Sequence[float]]) -> Sidecar:
    """Transform a sidecar to the frame of a model file, given the matrix to the World frame.

    The model itself then does not have to be transformed.
    """
    world_to_file = np.asarray(
        np.linalg.inv(np.array(to_world, np.float64).reshape(4, 4)), np.float64
    )
    matrix = world_to_file @ sidecar.matrix
    matrix[:3, 2] /= np.linalg.norm(matrix[:3, 2])
    return replace(sidecar, matrix=matrix)


def project_lines(
    lines: Sequence[GisLine], sidecar: Sidecar, data: Mesh | PointCloud, step: float | None = None
) -> ProjectedLines:
    """Project the vertices of lines (pixels) onto the surface shown by the picture.

    Parameters
    ----------
    lines : sequence of GisLine
    sidecar : Sidecar
    data : Mesh or PointCloud
        Model in the frame of the sidecar's matrix, m.
    step : float, optional
        Maximum distance between points; if given, points are inserted between the vertices, m.

    Returns
    -------
    ProjectedLines

    Raises
    ------
    InputError
        If no line has two points on the surface.
    """
    gsd = float(np.linalg.norm(sidecar.matrix[:3, 0]))
    pixels = [line.points if step is None else _densify(line.points, step / gsd) for line in lines]
    size = (sidecar.width, sidecar.height)
    depths = visible_depths(data, sidecar.matrix, size, np.concatenate(pixels))
    parts = np.split(depths, np.cumsum([len(part) for part in pixels])[:-1])
    projected_lines: list[BackProjectedLine] = []
    skipped_lines: list[BackProjectedLine] = []
    names = _make_unique([line.name for line in lines])
    for line_pixels, depth, name, line in zip(pixels, parts, names, lines, strict=True):
        is_on_surface = np.isfinite(depth)
        position = np.column_stack([line_pixels[is_on_surface], depth[is_on_surface]])
        points = position @ sidecar.matrix[:3, :3].T + sidecar.matrix[:3, 3]
        projected_line = BackProjectedLine(
            name, line.layer, line.words, line_pixels, is_on_surface, points
        )
        (projected_lines if len(points) > 1 else skipped_lines).append(projected_line)
    if not projected_lines:
        raise InputError(Finding("drawing.off-surface"))
    return ProjectedLines(tuple(projected_lines), tuple(skipped_lines))


def _page_to_pixels(drawing: SvgDrawing, sidecar: Sidecar, path: Path) -> FloatArray:
    """Return the matrix (3, 3) from the drawing's units to pixels.

    It is derived from the embedded picture with the name of the orthophoto, otherwise from a
    picture of the same shape. If the drawing contains no pictures, it is derived from the page.
    Raises InputError if nothing matches or if different positions match.
    """
    ratio = sidecar.width / sidecar.height
    stem = Path(sidecar.image).stem.casefold()
    image_boxes = [
        (image.name, image.fitted_corners(ratio), image.corners) for image in drawing.images
    ]
    matching_boxes = [
        box for name, box, _ in image_boxes if name and Path(name).stem.casefold() == stem
    ]
    positions = matching_boxes or [
        box for _, box, corners in image_boxes if _has_matching_aspect(corners, sidecar)
    ]
    if not drawing.images and drawing.page is not None:
        x, y, width, height = drawing.page
        page = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
        positions = [page] if _has_matching_aspect(page, sidecar) else []
    if not positions:
        raise InputError(Finding("drawing.other-picture"), file=path, field="--sidecar")
    first_position = positions[0]
    size = float(np.ptp(first_position, axis=0).max())
    if any(np.abs(box - first_position).max() > POSITION_TOLERANCE * size for box in positions[1:]):
        raise InputError(
            Finding("drawing.several-pictures", count=len(positions), name=sidecar.image),
            file=path,
        )
    matrix = np.eye(3)
    matrix[:2, 0] = (first_position[1] - first_position[0]) / sidecar.width
    matrix[:2, 1] = (first_position[3] - first_position[0]) / sidecar.height
    matrix[:2, 2] = first_position[0]
    if not abs(np.linalg.det(matrix)) > 0:
        raise InputError(Finding("drawing.other-picture"), file=path, field="--sidecar")
    return np.asarray(np.linalg.inv(matrix))


def _has_matching_aspect(box: FloatArray, sidecar: Sidecar) -> bool:
    """Return whether a picture or page (4, 2) has the shape of the orthophoto."""
    width, height = (float(np.hypot(*(box[k] - box[0]))) for k in (1, 3))
    limit = ASPECT_TOLERANCE + 1 / min(sidecar.width, sidecar.height)
    ratio = sidecar.width / sidecar.height
    return height > 0 and abs(width / height / ratio - 1) <= limit


def _read_gis_lines(
    path: Path, sidecar: Sidecar, progress: Progress | None
) -> tuple[list[GisLine], list[Finding]]:
    """Read the lines of a GIS layer or a CAD drawing in pixels, with warnings."""
    gis_lines = read_gis_lines(path, progress)
    warnings: list[Finding] = list(gis_lines.warnings)
    _check_marks((_read_header(path),), sidecar, path)
    lines, findings = _transform_layers(gis_lines, sidecar, path)
    warnings += findings
    inverse = np.asarray(np.linalg.inv(sidecar.transform), np.float64)
    pixels = [_transform_line(line, inverse) for line in lines]
    if not pixels or _inside_share(pixels, sidecar) >= MIN_INSIDE_SHARE:
        return pixels, warnings
    unit = read_dxf_properties(path).unit_m if path.suffix.lower() == ".dxf" else None
    if unit not in (None, 1.0):
        scaled_lines = [
            _transform_line(replace(line, points=line.points * unit), inverse) for line in lines
        ]
        if _inside_share(scaled_lines, sidecar) >= MIN_INSIDE_SHARE:
            warnings.append(Finding("drawing.unit-converted", unit_m=unit))
            return scaled_lines, warnings
    return pixels, warnings


def _inside_share(lines: Sequence[GisLine], sidecar: Sidecar) -> float:
    """Return the share of vertices that lie within the picture."""
    pixels = np.concatenate([line.points for line in lines])
    size = np.array([sidecar.width, sidecar.height])
    return float(((pixels >= -1) & (pixels <= size + 1)).all(axis=1).mean())


def _transform_layers(
    source_lines: GisLines, sidecar: Sidecar, path: Path
) -> tuple[list[GisLine], list[Finding]]:
    """Transform lines to the coordinates of the GeoTIFF, and report omitted layers.

    Raises
    ------
    InputError
        If no line remains.
    """
    is_geojson = path.suffix.lower() in (".geojson", ".json")
    systems = dict.fromkeys((line.layer, line.crs) for line in source_lines.lines)
    used_lines: list[GisLine] = []
    other_names: list[str] = []
    reasons: list[InputError] = []
    for layer, crs in systems:
        lines = [line for line in source_lines.lines if (line.layer, line.crs) == (layer, crs)]
        try:
            _check_marks((source_lines.described.get(layer, ""), crs or ""), sidecar, path)
            used_lines += _transform_layer(lines, crs, is_geojson, sidecar, path)
        except InputError as error:
            other_names.append(layer)
            reasons.append(error)
    if reasons and not used_lines:
        raise reasons[0]
    if not other_names:
        return used_lines, []
    return used_lines, [
        Finding("drawing.layers-left-out", count=len(other_names), names=other_names)
    ]


def _transform_layer(
    lines: list[GisLine], crs: str | None, is_geojson: bool, sidecar: Sidecar, path: Path
) -> list[GisLine]:
    """Transform the lines of one layer to the coordinates of the GeoTIFF.

    Raises
    ------
    InputError
        If the layer has map coordinates but the picture is on an oblique plane.
    """
    if crs is None:
        return lines
    from pyproj import CRS, Transformer
    from pyproj.exceptions import CRSError

    try:
        drawing_crs = CRS.from_user_input(crs)
        picture_crs = None if sidecar.crs is None else CRS.from_user_input(sidecar.crs)
    except CRSError:
        return lines
    if not (drawing_crs.is_projected or drawing_crs.is_geographic):
        return lines
    # GeoJSON without a CRS is in degrees according to the standard, but in metres if the picture is
    # in its own plane.
    is_crs_missing = is_geojson and drawing_crs.is_geographic
    if sidecar.is_oblique or picture_crs is None:
        if is_crs_missing:
            return lines
        if sidecar.is_oblique:
            raise InputError(Finding("drawing.on-map", crs=drawing_crs.name), file=path)
        return lines
    if drawing_crs == picture_crs:
        return lines
    all_points = np.concatenate([line.points for line in lines])
    if is_crs_missing and (np.abs(all_points) > [360.0, 90.0]).any():
        return lines
    transformer = Transformer.from_crs(drawing_crs, picture_crs, always_xy=True)
    return [
        replace(line, points=np.stack(transformer.transform(*line.points.T), 1)) for line in lines
    ]


def _check_marks(texts: Sequence[str], sidecar: Sidecar, path: Path) -> None:
    ids = {mark for text in texts for mark in _MARK.findall(text)}
    if ids and sidecar.id not in ids:
        raise InputError(Finding("drawing.other-picture"), file=path, field="--sidecar")
    assert _MARK.search(picture_comment(sidecar.id)) or not ids


def _text(value: object) -> str | None:
    return value if isinstance(value, str) else None


def _read_header(path: Path) -> str:
    """Return the start of a DXF file, in which a comment identifies the picture.

    GDAL ignores this comment. For other formats, the text is empty.
    """
    if path.suffix.lower() != ".dxf":
        return ""
    with open_regular_file(path) as file:
        return file.read(400).decode("latin-1")


def _transform_line(line: GisLine, matrix: FloatArray) -> GisLine:
    points = line.points @ matrix[:2, :2].T + matrix[:2, 2]
    return replace(line, points=points)


def _densify(points: FloatArray, step: float) -> FloatArray:
    """Insert points so that neighbouring points are at most `step` apart."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    counts = np.maximum(1, np.ceil(lengths / step)).astype(int)
    parts = [
        start + (end - start) * np.arange(count)[:, None] / count
        for start, end, count in zip(points[:-1], points[1:], counts, strict=True)
    ]
    return np.concatenate([*parts, points[-1:]])


def _layer_name(layer: str) -> str:
    name = layer.strip()
    return "" if name.casefold() in (*DEFAULT_LAYERS, *PROGRAM_LAYERS) else name


def _make_unique(names: Sequence[str]) -> list[str]:
    """Make names unique; a missing name is replaced by the number of the line."""
    used_names: set[str] = set()
    labels = []
    for k, name in enumerate(names):
        label = base = name.strip() or str(k + 1)
        suffix = 1
        while label in used_names:
            suffix += 1
            label = f"{base}-{suffix}"
        used_names.add(label)
        labels.append(label)
    return labels


def command_output(projected_lines: ProjectedLines, table: str) -> Mapping[str, Any]:
    """Return the output of the command as plain values."""
    return {
        "lines": len(projected_lines.lines),
        "points": projected_lines.points,
        "off_surface": projected_lines.off_surface_count,
        "table": table,
        "skipped": [line.name for line in projected_lines.skipped],
    }
