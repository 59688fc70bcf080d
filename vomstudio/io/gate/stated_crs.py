"""CRS that is stated by a text table, in its comments or in `NAME.prj` next to it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.gis.axis_units import StatedAxes, stated_axes
from vomstudio.io.gis.crs import read_sidecar, sidecar_path

WORLD_COMMENT = "# CRS: local; x East, y North, z Up, metres\n"
"""First line of a table of World coordinates that this program writes for its commands."""
_EPSG_CODE = re.compile(r"\bEPSG:{1,2}\s*(\d{4,6})\b", re.IGNORECASE)
_CODE_IN_LIST = re.compile(r"(?:^|[,;:(])\s*EPSG:{1,2}\s*(\d{4,6})\b", re.IGNORECASE)
_CRS_COMMENT = re.compile(
    r"\s*(?:CRS|Coordinate\s*System|SRS|Projection)\s*[:=]\s*(\S.*)", re.IGNORECASE
)
_WKT = re.compile(r"\s*([A-Z]{3,}_?(?:CRS|CS)\[.*\])\s*$", re.IGNORECASE)
_LOCAL_WORDS = ("local", "none", "engcrs", "engineering", "unknown", "undefined")


@dataclass(frozen=True)
class StatedCrs:
    """Coordinate reference system stated by a table.

    Parameters
    ----------
    text : str or None
        Code, name or WKT; None if the table states no CRS.
    is_local : bool
        Whether the table states that its coordinates are local.
    unit_m : float or None
        Metres per unit of local coordinates, if stated.
    """

    text: str | None = None
    is_local: bool = False
    unit_m: float | None = None


def parse_crs_comments(comments: Sequence[str]) -> StatedCrs:
    """Return the CRS that is stated in the comments of a table.

    The accepted forms are ``CRS: EPSG:32633``, ``CoordinateSystem: WKT`` (as written by Metashape),
    WKT on a separate line, and a code at the start of a comment or after a comma, semicolon, colon
    or bracket, if all comments state the same code.

    Parameters
    ----------
    comments : sequence of str
        Comments without their ``#``.
    """
    for comment in comments:
        if (match := _CRS_COMMENT.match(comment)) is None:
            continue
        text = match[1].strip()
        if _WKT.match(text):
            return StatedCrs(text)
        if text.casefold().startswith(_LOCAL_WORDS):
            return StatedCrs(is_local=text.casefold().startswith(("local", "eng")))
        if (code := _EPSG_CODE.match(text)) is not None:
            return StatedCrs(f"EPSG:{code[1]}")
        return StatedCrs(text.partition(";")[0].strip())
    for comment in comments:
        if (wkt := _WKT.match(comment)) is not None:
            return StatedCrs(wkt[1])
    codes = {code for comment in comments for code in _CODE_IN_LIST.findall(comment)}
    return StatedCrs(f"EPSG:{codes.pop()}" if len(codes) == 1 else None)


def table_crs(path: Path, comments: Sequence[str]) -> tuple[StatedCrs, tuple[Finding, ...]]:
    """Return the CRS of a table of coordinates from its comments, or else from `NAME.prj`.

    Parameters
    ----------
    path : Path
        Path of the table; a path that is not a file has no `NAME.prj`.
    comments : sequence of str

    Returns
    -------
    StatedCrs
    findings : tuple of Finding
        ``frame.crs-unreadable`` for a CRS that is not known and is therefore treated as not stated;
        ``frame.crs-replaced`` if the comments and `NAME.prj` disagree, in which case the comments
        are used.
    """
    stated_crs = parse_crs_comments(comments)
    findings: list[Finding] = []
    if stated_crs.text is not None and _axes(stated_crs.text) is None:
        findings.append(Finding("frame.crs-unreadable", file=path.name, crs=stated_crs.text[:80]))
        stated_crs = StatedCrs()
    name = sidecar_path(path).name
    try:
        sidecar_text = read_sidecar(path)
    except FileNotFoundError:
        return stated_crs, tuple(findings)
    except (OSError, InputError) as error:
        findings.append(Finding("frame.crs-unreadable", file=name, crs=str(error)))
        return stated_crs, tuple(findings)
    shown_text = " ".join(sidecar_text.split())[:80]
    axes = _axes(sidecar_text)
    if axes is None:
        findings.append(Finding("frame.crs-unreadable", file=name, crs=shown_text))
    elif stated_crs.text is None and not stated_crs.is_local:
        stated_crs = StatedCrs(sidecar_text)
    elif stated_crs.text is not None and _has_other_crs(stated_crs.text, axes):
        findings.append(
            Finding(
                "frame.crs-replaced",
                file=name,
                file_crs=axes.crs or shown_text,
                crs=stated_crs.text,
            )
        )
    return stated_crs, tuple(findings)


def _axes(text: str) -> StatedAxes | None:
    try:
        return stated_axes(text)
    except InputError:
        return None


def _has_other_crs(text: str, axes: StatedAxes) -> bool:
    text_axes = _axes(text)
    return text_axes is not None and text_axes.crs != axes.crs
