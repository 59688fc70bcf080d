"""What a format of ground control is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from vomstudio.io.control.points import ControlPoint, Mark


@dataclass(frozen=True)
class ControlFormat:
    """One format, by the content of its files.

    name : as a person says it
    matches : whether a file is of this format; False for one that is not there
    points : of a file, in a projected CRS in metres (`io.control.projection`), or in a local frame
    marks : of a file, in pixels of the photo as stored, from the outer corner of its top left pixel
    crs : "EPSG:n" or WKT of `points`; None where the file states none
    holds_marks : its files have points and marks both
    found_as : names under which its files are looked for beside the photos
    certain : False where a file that matches may be of another format that knows it better
    extensions : that its files usually have, for file dialogs
    marks_beside : the file in the same folder that holds the marks of a file of points; None where
        none does, or several do

    All raise InputError, with line and column or element, for what is wrong in a file.
    """

    name: str
    matches: Callable[[Path], bool]
    points: Callable[[Path], list[ControlPoint]]
    marks: Callable[[Path], list[Mark]]
    crs: Callable[[Path], str | None]
    holds_marks: bool = False
    found_as: tuple[str, ...] = ()
    certain: bool = True
    extensions: tuple[str, ...] = ()
    marks_beside: Callable[[Path], Path | None] | None = None
