"""Integer origin and CRS of float32 coordinates, in `NAME.offset.txt` next to a model.

The file contains a line such as `EPSG:32615; World = (x, -z, y) + offset 576000 5188000 0`; a CRS
without a code follows on a separate line as `CRS: ` and its WKT.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_small_file
from vomstudio.core.findings import Finding
from vomstudio.geometry.coordinate_limits import MAX_COORDINATE_M
from vomstudio.io.gis.crs import parse_crs
from vomstudio.io.text.encodings import decode_text

MAX_BYTES = 100_000
_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_SEPARATOR = r"[\s,;]+"
_THREE_NUMBERS = f"({_NUMBER}){_SEPARATOR}({_NUMBER}){_SEPARATOR}({_NUMBER})"
_OFFSET = re.compile(rf"(?:offset|origin|shift)[\s:=(\[]*{_THREE_NUMBERS}(?![\w.])", re.IGNORECASE)
_NUMBERS_ONLY = re.compile(rf"\s*{_THREE_NUMBERS}\s*")
_EPSG = re.compile(r"\bEPSG:\s*(\d{4,6})\b", re.IGNORECASE)
_WKT = re.compile(r"^[ \t]*CRS:[ \t]*(\S.*)$", re.IGNORECASE | re.MULTILINE)


@dataclass(frozen=True)
class Offset:
    """Content of an offset file.

    Attributes
    ----------
    origin : tuple of float or None
        Origin that is added to the coordinates of the file.
    crs : str or None
        As for LoadedModel.
    problem : Finding or None
        Reason why an existing file cannot be used.
    """

    origin: tuple[float, float, float] | None = None
    crs: str | None = None
    problem: Finding | None = None


def offset_path(model: Path) -> Path:
    """Return the path of the offset file of a model."""
    return model.with_name(f"{model.stem}.offset.txt")


def read_offset(model: Path) -> Offset:
    """Read `NAME.offset.txt` of a model; the result is empty if the file is missing."""
    path = offset_path(model)
    try:
        text = decode_text(read_small_file(path, MAX_BYTES))
    except FileNotFoundError:
        return Offset()
    except (InputError, OSError, UnicodeDecodeError):
        return Offset(problem=Finding("model.origin-invalid", file=path.name))
    match = _OFFSET.search(text) or _NUMBERS_ONLY.fullmatch(text)
    crs, crs_finding = parse_file_crs(extract_crs_text(text), path.name)
    if match is None:
        return Offset(None, crs, Finding("model.origin-invalid", file=path.name))
    origin = parse_origin([float(number) for number in match.groups()])
    if origin is None:
        return Offset(None, crs, Finding("model.origin-invalid", file=path.name))
    return Offset(origin, crs, crs_finding)


def extract_crs_text(text: str) -> str | None:
    """Return the CRS stated in a text as a code or WKT, or None."""
    code, wkt = _EPSG.search(text), _WKT.search(text)
    if wkt is not None:
        return wkt.group(1).strip()
    return None if code is None else f"EPSG:{code.group(1)}"


def parse_file_crs(text: object, file_name: str) -> tuple[str | None, Finding | None]:
    """Return the CRS stated by a file, or None, and a finding if it is not valid."""
    if text is None:
        return None, None
    if isinstance(text, str) and len(text) <= MAX_BYTES:
        try:
            return parse_crs(text)[0], None
        except InputError:
            pass
    return None, Finding("frame.crs-unreadable", file=file_name, crs=str(text)[:60])


def parse_origin(numbers: object) -> tuple[float, float, float] | None:
    """Return three finite numbers that are plausible as a position in metres, or None."""
    if not isinstance(numbers, Sequence) or len(numbers) != 3:
        return None
    for number in numbers:
        if isinstance(number, bool) or not isinstance(number, int | float):
            return None
        if not abs(number) <= MAX_COORDINATE_M:
            return None
    x, y, z = (float(number) for number in numbers)
    return x, y, z


def offset_text(origin: Sequence[float], crs: str | None, axes: str) -> str:
    """Return the content of an offset file.

    `axes` describes the conversion of x, y, z in the file to World coordinates without the offset,
    such as "glTF is +Y up (x = East, y = Up, z = -North); World = (x, -z, y)".
    """
    x, y, z = (f"{number:.15g}" for number in origin)
    code = crs if crs is not None and len(crs) < 20 else None
    lines = [f"{code or 'local'}; {axes} + offset {x} {y} {z}"]
    if crs is not None and code is None:
        lines.append(f"CRS: {' '.join(crs.split())}")
    return "\n".join(lines) + "\n"
