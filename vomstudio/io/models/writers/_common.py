"""What the writers share: names that other programs can read, images, the CRS beside a file."""

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
from vomstudio.core.files.regular import open_regular, read_small_text, read_whole
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.crs import parse_crs
from vomstudio.io.models.image_store import ending_of, plain_name
from vomstudio.io.models.writer import Outgoing

ROWS_PER_STEP = 100_000


def positions_of(data: Mesh | PointCloud) -> FloatArray:
    return data.vertices if isinstance(data, Mesh) else data.points


def field_names(
    fields: Mapping[str, AnyArray], used_names: Iterable[str], messages: list[Finding]
) -> dict[str, str]:
    """Return a unique ASCII name for each field, none of them in `used_names` (case-insensitive).

    Appends a message for each renamed field.
    """
    used = {name.casefold() for name in used_names}
    result: dict[str, str] = {}
    for name in fields:
        plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "field"
        if plain[0].isdigit():
            plain = f"field_{plain}"
        free = plain if plain.casefold() not in used else f"field_{plain}"
        number = 2
        while free.casefold() in used:
            free, number = f"{plain}_{number}", number + 1
        used.add(free.casefold())
        result[name] = free
        if free != name:
            messages.append(Finding("model.field-renamed", field=name, new=free))
    return result


def textures_not_written(names: Iterable[str]) -> Finding:
    return Finding("model.textures-not-written", images=tuple(names))


def bare_points(data: Mesh | PointCloud, messages: list[Finding]) -> None:
    """Append a message about the faces of a mesh that a format of points cannot store."""
    if not isinstance(data, Mesh):
        return
    messages.append(Finding("model.faces-not-written", count=len(data.faces)))
    images = [m.texture.name for m in data.materials if m.texture is not None]
    if images:
        messages.append(textures_not_written(images))


def step_rows(n: int, out: Outgoing, title: str) -> Iterator[slice]:
    """Blocks of rows, reported and cancellable."""
    out.progress.stage(title, n)
    for start in range(0, n, ROWS_PER_STEP):
        yield slice(start, min(start + ROWS_PER_STEP, n))
        out.progress.step(min(start + ROWS_PER_STEP, n))


def shortest(values: AnyArray) -> list[float]:
    """Floats whose `repr` is the shortest text that gives back each value of its own precision."""
    if values.dtype != np.float32:
        found: list[float] = values.astype(np.float64).tolist()
        return found
    wide = values.astype(np.float64)
    result = wide.copy()
    left = np.isfinite(wide)
    for decimals in range(1, 10):
        rounded = np.round(wide, decimals)
        fits = left & (rounded.astype(np.float32) == values)
        result[fits] = rounded[fits]
        left &= ~fits
        if not left.any():
            break
    short: list[float] = result.tolist()
    return short


# --- files beside ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Images:
    """names : of each material's image as the file names it, or None. copies : what must be copied
    where; images that are there already with the same content are not."""

    names: list[str | None]
    copies: list[tuple[Path, Path]]


def plan_images(mesh: Mesh, out: Outgoing) -> Images:
    """Where the textures of a mesh go, beside the file: one file per image. An image of somebody
    else that has the name already is never replaced; the name of the model goes before ours then.
    Raises TargetError where an image cannot be read."""
    folder = out.path.parent
    chosen: dict[Path, str] = {}
    copies: list[tuple[Path, Path]] = []
    names: list[str | None] = []
    for material in mesh.materials:
        source = material.texture
        if source is None:
            names.append(None)
            continue
        if source not in chosen:
            chosen[source] = name = _free_name(source, set(chosen.values()), out)
            if not _same_content(source, folder / name):
                copies.append((source, folder / name))
        names.append(chosen[source])
    return Images(names, copies)


def _free_name(source: Path, taken: set[str], out: Outgoing) -> str:
    stem = plain_name(source.stem) or "texture"
    ending = source.suffix.lower()
    if not re.fullmatch(r"\.\w{2,5}", ending):
        ending = ending_of(image_bytes(source)[:16])
    ours = f"{plain_name(out.path.stem) or 'model'}_{stem}"
    used = {name.casefold() for name in taken}
    for number in itertools.count(1):
        for label in (stem, ours):
            name = f"{label}{'' if number == 1 else f'_{number}'}{ending}"
            if name.casefold() in used:
                continue
            there = out.path.with_name(name)
            free = not os.path.lexists(there) or _same_content(source, there)
            if free or (label == ours and out.force and there.is_file()):
                return name
    raise AssertionError("unreachable")


def _same_content(source: Path, target: Path) -> bool:
    try:
        if not target.is_file() or target.stat().st_size != source.stat().st_size:
            return False
        return target.samefile(source) or read_whole(target) == read_whole(source)
    except (InputError, OSError):
        return False


def image_bytes(path: Path) -> bytes:
    """Raises TargetError: an output without its texture is not what was asked for."""
    try:
        return read_whole(path)
    except (InputError, OSError) as error:
        raise _unreadable(path, error) from error


def copy_images(images: Images, temporaries: list[Path]) -> None:
    for (source, _), temporary in zip(images.copies, temporaries, strict=True):
        with _opened(source) as file, open(temporary, "wb") as target:
            shutil.copyfileobj(file, target, 1 << 20)


def _opened(path: Path) -> BinaryIO:
    try:
        return open_regular(path)
    except (InputError, OSError) as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: InputError | OSError) -> TargetError:
    return TargetError(
        Finding(
            "texture.unreadable",
            reason=error.message if isinstance(error, InputError) else error.strerror,
        ),
        file=path,
    )


def prj_beside(
    out: Outgoing, messages: list[Finding], esri: bool = False
) -> list[tuple[Path, str]]:
    """`NAME.prj` with the CRS, for formats that have no place for one; nothing where it stands
    there already. esri : in the words of ESRI, as a shapefile has it"""
    path = out.path.with_suffix(".prj")
    if out.crs is None:
        if path.exists():
            messages.append(Finding("frame.stale-crs-file", file=path.name))
        return []
    text = prj_text(out.crs, esri)
    return [] if says_the_same(path, text, out.crs) else [(path, text)]


def prj_text(crs: str, esri: bool = False) -> str:
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    known = CRS.from_user_input(crs)
    try:
        return str(known.to_wkt("WKT1_ESRI" if esri else "WKT1_GDAL")) + "\n"
    except CRSError:
        return str(known.to_wkt()) + "\n"


def says_the_same(path: Path, text: str, crs: str) -> bool:
    """Whether a .prj file that is there names this CRS, in whatever words."""
    try:
        there = read_small_text(path)
    except (InputError, OSError, UnicodeDecodeError):
        return False
    if there.strip() == text.strip():
        return True
    try:
        return parse_crs(there)[0] == crs
    except InputError:
        return False


def write_lines(file: TextIO, columns: list[list[Any]], form: str) -> None:
    """One line per row, `form` as a % format."""
    if columns and columns[0]:
        file.write("\n".join(map(form.__mod__, zip(*columns, strict=True))))
        file.write("\n")
