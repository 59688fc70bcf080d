"""Interface of a ground control format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from vomstudio.io.control.points import ControlPoint, Mark


@dataclass(frozen=True)
class ControlFormat:
    """One format, detected by the content of its files.

    All functions raise InputError, with line and column or element, for invalid files.

    Attributes
    ----------
    name : str
        Name for the user.
    matches : callable
        Returns whether a file has this format; False for a missing file.
    points : callable
        Returns the points of a file, in a projected CRS in metres (`io.control.projection`), or in
        a local frame.
    marks : callable
        Returns the marks of a file, in pixels of the stored photo, from the outer corner of its
        top left pixel.
    crs : callable
        Returns "EPSG:n" or WKT of `points`; None if the file does not state one.
    holds_marks : bool
        Its files have both points and marks.
    found_as : tuple of str
        Default file names beside the photos.
    certain : bool
        False if a matching file may have another, more specific format.
    extensions : tuple of str
        Usual extensions, for file dialogs.
    marks_beside : callable or None
        Returns the file in the same folder with the marks of a file of points; None without
        exactly one.
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
