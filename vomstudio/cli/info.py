"""`vomstudio info`: contents of a model, point cloud, table, picture or photo folder."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    progress_reporter,
    report_reading,
)
from vomstudio.cli.common.output import Output
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr, tr_n

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo

EMPTY_CONTENTS: dict[str, Any] = {
    "path": None,
    "kind": None,
    "points": None,
    "faces": None,
    "materials": [],
    "textures": [],
    "bounds": None,
    "crs": None,
    "units": None,
    "resolution_m": None,
    "fields": [],
    "warnings": [],
}
"""Keys that the result contains for every file, with their default values."""
TABLE_SUFFIXES = {".csv", ".tsv", ".txt", ".dat", ".tab", ".prn"}
PICTURE_SUFFIXES = {".jpg", ".jpeg", ".png", ".bmp", ".webp", ".heic", ".heif"}
RASTER_SUFFIXES = {".tif", ".tiff"}


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``info`` command."""
    parser = add_command(subparsers, "info", run, help_=tr("Describe models, tables and photos"))
    parser.add_argument("files", metavar="FILE", nargs="+", help=tr("file, or folder of photos"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Report the contents of all files.

    A file that cannot be read has an error; the result repeats the first error.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.
    """
    progress = progress_reporter(args)
    files: list[dict[str, Any]] = []
    first_error: dict[str, Any] | None = None
    for number, name in enumerate(args.files, start=1):
        if len(args.files) > 1:
            progress.part(number, len(args.files))
        report_reading(args, name)
        try:
            description = _describe_path(Path(name), progress)
        except InputError as error:
            out.error(f"vomstudio: {error}")
            first_error = first_error or error.to_dict()
            description = {**EMPTY_CONTENTS, "error": error.to_dict()}
        else:
            out.text(_result_text(name, description))
            out.warn([item.with_file(name) for item in description.get("warnings", ())])
        files.append({**EMPTY_CONTENTS, **description, "path": name})
    result: dict[str, Any] = {"files": files}
    if first_error is not None:
        result["error"] = first_error
    out.result(result)


def _describe_path(path: Path, progress: Progress) -> dict[str, Any]:
    """Describe the contents of a file or folder. Raises InputError."""
    if path.is_dir():
        return _describe_folder(path, progress)
    suffix = path.suffix.lower()
    readers: dict[bool, Callable[[Path], dict[str, Any]]] = {
        suffix in TABLE_SUFFIXES: lambda path: _describe_table(path, progress),
        suffix in PICTURE_SUFFIXES: _describe_picture,
        suffix in RASTER_SUFFIXES: lambda path: _describe_grid(path, progress),
    }
    if True in readers:
        return readers[True](path)
    from vomstudio.io.models.opening import describe

    return dict(describe(path, progress))


def _describe_folder(path: Path, progress: Progress) -> dict[str, Any]:
    from vomstudio.project.paths import is_project

    if is_project(path):
        return {**EMPTY_CONTENTS, "kind": "project"}
    from vomstudio.io.photos.reading import read_photos

    survey = read_photos(path, progress)
    photos = survey.photos
    warnings: list[Finding] = list(survey.warnings)
    warnings += [
        Finding("photo.left-out", photo=name, reason=reason) for name, reason in survey.skipped
    ]
    gps_count = sum(photo.latitude_deg is not None for photo in photos)
    return {
        **EMPTY_CONTENTS,
        "kind": "photos",
        # Two copies of a file still count as two photos in the folder.
        "photos": len(photos) + len(survey.duplicates),
        "used": len(photos),
        "with_gps": gps_count,
        "with_masks": sum(photo.mask is not None for photo in photos),
        "cameras": [_describe_camera(group) for group in survey.cameras().values()],
        "warnings": warnings,
    }


def _describe_camera(group: list[Photo]) -> dict[str, Any]:
    """Return the common properties of photos taken with the same lens."""
    first_photo = group[0]
    return {
        "camera": first_photo.camera,
        "lens": first_photo.lens,
        "serial": first_photo.serial,
        "photos": len(group),
        "width": first_photo.width,
        "height": first_photo.height,
        "focal_mm": first_photo.focal_mm,
        "focal_px": first_photo.focal_px,
        "focal_source": first_photo.focal_source,
        "sensor_width_mm": first_photo.sensor_width_mm,
    }


COORDINATE_NAMES = {"x", "y", "z"}
"""Columns that identify a table of points; errors in such a table are reported."""


def _describe_table(path: Path, progress: Progress) -> dict[str, Any]:
    """Describe the rows, columns and bounds of a table. Raises InputError.

    The bounds are in the stated CRS, or None if the table has no coordinates.
    """
    import numpy as np

    from vomstudio.io.gate.points import points_to_world
    from vomstudio.io.gate.stated_crs import table_crs
    from vomstudio.io.text.tables import coordinate_columns, read_table

    table = read_table(path)
    if not len(table):
        raise InputError(Finding("table.no-rows"), file=path, line=table.header_line)
    warnings: list[Finding] = list(table.notes)
    bounds = None
    try:
        points = table.numbers(coordinate_columns(table))
    except InputError as error:
        points = np.empty((0, 3))  # a table with other contents
        if {name.strip().casefold() for name in table.names or ()} >= COORDINATE_NAMES:
            warnings.append(cause_finding(error))
    is_finite_row = np.isfinite(points).all(axis=1)
    if is_finite_row.any():
        bounds = [
            points[is_finite_row].min(axis=0).tolist(),
            points[is_finite_row].max(axis=0).tolist(),
        ]
        if not is_finite_row.all():
            lines = np.asarray(table.line_numbers)[~is_finite_row].tolist()
            warnings.append(
                Finding(
                    "table.rows-left-out",
                    count=len(lines),
                    needed=tr("coordinates"),
                    lines=lines,
                )
            )
    result = {
        **EMPTY_CONTENTS,
        "kind": "table",
        "points": len(table),
        "faces": 0,
        "bounds": bounds,
        "units": None if bounds is None else ["unknown"] * 3,
        "fields": list(table.names or (table.label(i) for i in range(table.width))),
        "warnings": warnings,
    }
    if bounds is None:
        return result
    stated_crs, findings = table_crs(path, table.comments)
    try:
        warnings += points_to_world(points, file=path, comments=table.comments).findings
    except InputError as error:
        if not error.code.startswith("frame."):
            raise
        warnings += [*findings, Finding(error.code, **error.values)]
    return result if stated_crs.text is None else result | _describe_points(path, progress)


def _describe_points(path: Path, progress: Progress) -> dict[str, Any]:
    """Describe points with a stated CRS as a cloud; empty if they cannot be read as one."""
    from vomstudio.io.models.opening import describe

    try:
        cloud = describe(path, progress)
    except InputError:
        return {}
    keys = ("crs", "units", "bounds", "resolution_m", "resolution")
    return {key: cloud[key] for key in keys if key in cloud}


SINGLE_BAND_MODES = ("1", "L", "P")
"""Pillow modes with a single band: black and white, grey, and palette."""


def _describe_picture(path: Path) -> dict[str, Any]:
    """Describe an image file, with its position if it is a map. Raises InputError."""
    from vomstudio.io.text.file_text import require_file

    require_file(path)
    from PIL import UnidentifiedImageError

    from vomstudio.core.files.untrusted.pictures import open_picture

    try:
        with open_picture(path, header_only=True) as image:
            width, height = image.size
            bands = list(image.getbands())
            tags = getattr(image, "tag_v2", None) or {}
    except UnidentifiedImageError as error:
        if path.suffix.lower() in RASTER_SUFFIXES:
            from vomstudio.io.gis.raster import read_size_and_bands

            # Pillow does not support every number type and every number of bands.
            width, height, bands = read_size_and_bands(path)
            return {
                **EMPTY_CONTENTS,
                **(_map_placement(path) or {}),
                "kind": "raster",
                "width": width,
                "height": height,
                "fields": bands,
                "warnings": [],
            }
        raise InputError(Finding("picture.unknown-kind"), file=path) from error
    except (OSError, ValueError, SyntaxError) as error:
        raise InputError(Finding("file.unreadable", reason=error), file=path) from error
    placement, warnings = None, []
    if 33550 in tags or 34264 in tags:
        placement = _map_placement(path)
        if placement is None:
            warnings.append(Finding("picture.place-unreadable"))
    return {
        **EMPTY_CONTENTS,
        **(placement or {}),
        "kind": "raster",
        "width": width,
        "height": height,
        "fields": bands,
        "warnings": warnings,
    }


def _map_placement(path: Path) -> dict[str, Any] | None:
    from vomstudio.io.gis.raster_georeference import read_map_placement

    return read_map_placement(path)


def _describe_grid(path: Path, progress: Progress) -> dict[str, Any]:
    """Describe a height model, or any other TIFF as a picture. Raises InputError."""
    from vomstudio.io.models.opening import describe

    try:
        result = dict(describe(path, progress))
    except InputError as error:
        picture = _describe_picture(path)
        if len(picture["fields"]) == 1 and picture["fields"][0] not in SINGLE_BAND_MODES:
            # Errors of height models are reported, but not those of photographs.
            picture["warnings"].append(cause_finding(error))
        return picture
    from vomstudio.io.gis.raster import read_size_and_bands

    # Pillow does not support 64-bit numbers.
    width, height, bands = read_size_and_bands(path)
    return {
        **EMPTY_CONTENTS,
        **result,
        "kind": "raster",
        "width": width,
        "height": height,
        "fields": bands,
    }


def _extent_rows(description: dict[str, Any]) -> list[tuple[str, str]]:
    """Return bounds and spacing with their unit, and the units stated in the file."""
    rows = []
    units = description.get("units") or ["unknown"] * 3
    is_metric = "resolution" not in description and units[0] != "unknown"
    if bounds := description.get("bounds"):
        for axis, unit, low, high in zip("xyz", units, *bounds, strict=True):
            if low is None:  # a picture has no heights
                continue
            shown_unit = "m" if is_metric else unit
            label = axis if shown_unit == "unknown" else f"{axis}, {shown_unit}"
            rows.append((label, tr("{low:.3f} to {high:.3f}", low=low, high=high)))
    if spacing := description.get("resolution_m"):
        rows.append((tr("resolution, m"), f"{spacing:.4g}"))
    elif spacing := description.get("resolution"):
        rows.append((tr("resolution"), f"{spacing:.4g}"))
    if description.get("units"):
        unit_text = tr("unknown") if set(units) == {"unknown"} else ", ".join(units)
        rows.append((tr("file units"), unit_text))
    return rows


def _camera_text(camera: dict[str, Any]) -> str:
    focal_text = tr("focal length unknown")
    if camera["focal_px"]:
        focal_text = f"f = {camera['focal_px']:.0f} px ({camera['focal_source']})"
    return tr_n(
        "{camera}: {count} photo of {width} x {height} px, {focal}",
        "{camera}: {count} photos of {width} x {height} px, {focal}",
        camera["photos"],
        camera=camera["camera"] or tr("unknown"),
        width=camera["width"],
        height=camera["height"],
        focal=focal_text,
    )


def _result_text(name: str, description: dict[str, Any]) -> str:
    count_titles = {
        "photos": tr("photos"),
        "with_gps": tr("with GPS"),
        "with_masks": tr("with masks"),
        "points": tr("points"),
        "faces": tr("faces"),
        "width": tr("width, px"),
        "height": tr("height, px"),
    }
    list_titles = {"fields": tr("fields"), "materials": tr("materials"), "textures": tr("textures")}
    rows = [
        (label, str(description[key]))
        for key, label in count_titles.items()
        if description.get(key)
    ]
    rows += [(tr("camera"), _camera_text(camera)) for camera in description.get("cameras", ())]
    rows += _extent_rows(description)
    if description["kind"] in ("mesh", "cloud") or description.get("crs"):
        rows.append((tr("CRS"), description.get("crs") or tr("none in the file")))
    rows += [
        (title, ", ".join(map(str, description[k])))
        for k, title in list_titles.items()
        if description.get(k)
    ]
    heading = f"{name}: {description['kind']}"
    return f"{heading}\n{text_tables.label_lines(rows, 14, '  ')}" if rows else heading
