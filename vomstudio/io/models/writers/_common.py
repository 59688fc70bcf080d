"""Helpers of the writers: names that other programs accept, images, and the CRS file."""

from __future__ import annotations

import itertools
import os
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, TextIO

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray
from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.regular import open_regular_file, read_small_text, read_whole_file
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.crs import parse_crs
from vomstudio.io.models.image_store import image_suffix, plain_name
from vomstudio.io.models.writer import WriteRequest

ROWS_PER_STEP = 100_000


def model_positions(data: Mesh | PointCloud) -> FloatArray:
    return data.vertices if isinstance(data, Mesh) else data.points


def field_names(
    fields: Mapping[str, AnyArray], used_names: Iterable[str], findings: list[Finding]
) -> dict[str, str]:
    """Return a unique ASCII name for each field.

    None of the names is in `used_names` (case-insensitive).

    A finding is appended to `findings` for each renamed field.
    """
    used_folded_names = {name.casefold() for name in used_names}
    result: dict[str, str] = {}
    for name in fields:
        ascii_name = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "field"
        if ascii_name[0].isdigit():
            ascii_name = f"field_{ascii_name}"
        label = (
            ascii_name if ascii_name.casefold() not in used_folded_names else f"field_{ascii_name}"
        )
        suffix = 2
        while label.casefold() in used_folded_names:
            label, suffix = f"{ascii_name}_{suffix}", suffix + 1
        used_folded_names.add(label.casefold())
        result[name] = label
        if label != name:
            findings.append(Finding("model.field-renamed", field=name, new=label))
    return result


def textures_not_written_finding(names: Iterable[str]) -> Finding:
    return Finding("model.textures-not-written", images=tuple(names))


def report_unwritten_faces(data: Mesh | PointCloud, findings: list[Finding]) -> None:
    """Append a finding about the faces of a mesh that a point format cannot store."""
    if not isinstance(data, Mesh):
        return
    findings.append(Finding("model.faces-not-written", count=len(data.faces)))
    images = [material.texture.name for material in data.materials if material.texture is not None]
    if images:
        findings.append(textures_not_written_finding(images))


def step_rows(n: int, request: WriteRequest, title: str) -> Iterator[slice]:
    """Yield blocks of rows and report progress."""
    request.progress.stage(title, n)
    for start in range(0, n, ROWS_PER_STEP):
        yield slice(start, min(start + ROWS_PER_STEP, n))
        request.progress.step(min(start + ROWS_PER_STEP, n))


def shorten_numbers(values: AnyArray) -> list[float]:
    """Return floats whose shortest `repr` restores each value in its precision."""
    if values.dtype != np.float32:
        doubles: list[float] = values.astype(np.float64).tolist()
        return doubles
    doubles_array = values.astype(np.float64)
    result = doubles_array.copy()
    is_remaining = np.isfinite(doubles_array)
    for decimals in range(1, 10):
        rounded_numbers = np.round(doubles_array, decimals)
        is_exact = is_remaining & (rounded_numbers.astype(np.float32) == values)
        result[is_exact] = rounded_numbers[is_exact]
        is_remaining &= ~is_exact
        if not is_remaining.any():
            break
    shortest_numbers: list[float] = result.tolist()
    return shortest_numbers


# --- sidecar files -----------------------------------------------------------------------------


@dataclass(frozen=True)
class ImagePlan:
    """Names and copies of the images of a mesh.

    `names` contains the name of each material's image in the file, or None. `copies` contains the
    source and target of each image to copy, excluding images that already exist with the same
    content.
    """

    names: list[str | None]
    copies: list[tuple[Path, Path]]


def plan_images(mesh: Mesh, request: WriteRequest) -> ImagePlan:
    """Plan the copies of a mesh's textures next to the file, with one file per image.

    An unrelated image with the same name is never replaced; in this case the copy is prefixed with
    the name of the model. Raises TargetError if an image cannot be read.
    """
    folder = request.path.parent
    names_by_source: dict[Path, str] = {}
    copies: list[tuple[Path, Path]] = []
    names: list[str | None] = []
    for material in mesh.materials:
        source = material.texture
        if source is None:
            names.append(None)
            continue
        if source not in names_by_source:
            names_by_source[source] = name = _unused_name(
                source, set(names_by_source.values()), request
            )
            if not _has_same_content(source, folder / name):
                copies.append((source, folder / name))
        names.append(names_by_source[source])
    return ImagePlan(names, copies)


def _unused_name(source: Path, used_names: set[str], request: WriteRequest) -> str:
    stem = plain_name(source.stem) or "texture"
    suffix = source.suffix.lower()
    if not re.fullmatch(r"\.\w{2,5}", suffix):
        suffix = image_suffix(image_bytes(source)[:16])
    prefixed_stem = f"{plain_name(request.path.stem) or 'model'}_{stem}"
    used_folded_names = {name.casefold() for name in used_names}
    for number in itertools.count(1):
        for label in (stem, prefixed_stem):
            name = f"{label}{'' if number == 1 else f'_{number}'}{suffix}"
            if name.casefold() in used_folded_names:
                continue
            target = request.path.with_name(name)
            is_available = not os.path.lexists(target) or _has_same_content(source, target)
            if is_available or (label == prefixed_stem and request.force and target.is_file()):
                return name
    raise AssertionError("unreachable")


def _has_same_content(source: Path, target: Path) -> bool:
    try:
        if not target.is_file() or target.stat().st_size != source.stat().st_size:
            return False
        return target.samefile(source) or read_whole_file(target) == read_whole_file(source)
    except (InputError, OSError):
        return False


def image_bytes(path: Path) -> bytes:
    """Read an image. Raises TargetError because an output without its texture is incomplete."""
    try:
        return read_whole_file(path)
    except (InputError, OSError) as error:
        raise _copying_error(path, error) from error


def copy_images(images: ImagePlan, temporary_paths: list[Path]) -> None:
    for (source, _), temporary in zip(images.copies, temporary_paths, strict=True):
        with _open_image(source) as file, open(temporary, "wb") as target:
            shutil.copyfileobj(file, target, 1 << 20)


def _open_image(path: Path) -> BinaryIO:
    try:
        return open_regular_file(path)
    except (InputError, OSError) as error:
        raise _copying_error(path, error) from error


def _copying_error(path: Path, error: InputError | OSError) -> TargetError:
    return TargetError(
        Finding(
            "texture.unreadable",
            reason=error.message if isinstance(error, InputError) else error.strerror,
        ),
        file=path,
    )


def prj_sidecar(
    request: WriteRequest, findings: list[Finding], uses_esri_wkt: bool = False
) -> list[tuple[Path, str]]:
    """Return path and text of `NAME.prj` for formats that cannot store a CRS.

    The list is empty if there is no CRS or if an existing file states it. `uses_esri_wkt` selects
    ESRI WKT, as used in shapefiles.
    """
    path = request.path.with_suffix(".prj")
    if request.crs is None:
        if path.exists():
            findings.append(Finding("frame.stale-crs-file", file=path.name))
        return []
    text = prj_text(request.crs, uses_esri_wkt)
    return [] if is_same_prj(path, text, request.crs) else [(path, text)]


def prj_text(crs: str, uses_esri_wkt: bool = False) -> str:
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    parsed_crs = CRS.from_user_input(crs)
    try:
        return str(parsed_crs.to_wkt("WKT1_ESRI" if uses_esri_wkt else "WKT1_GDAL")) + "\n"
    except CRSError:
        return str(parsed_crs.to_wkt()) + "\n"


def is_same_prj(path: Path, text: str, crs: str) -> bool:
    """Return whether an existing .prj file states this CRS in any form."""
    try:
        stored_text = read_small_text(path)
    except (InputError, OSError, UnicodeDecodeError):
        return False
    if stored_text.strip() == text.strip():
        return True
    try:
        return parse_crs(stored_text)[0] == crs
    except InputError:
        return False


def write_lines(file: TextIO, columns: list[list[Any]], template: str) -> None:
    """Write one line per row; `template` is a % format."""
    if columns and columns[0]:
        file.write("\n".join(map(template.__mod__, zip(*columns, strict=True))))
        file.write("\n")
