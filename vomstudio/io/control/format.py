"""Interface of ground control formats."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from vomstudio.io.control.points import ControlPoint, Mark


@dataclass(frozen=True)
class ControlFormat:
    """Ground control format, which is detected from the content of a file.

    All functions raise InputError with line and column or element if a file is not valid.

    Attributes
    ----------
    name : str
        Display name.
    matches : callable
        Function that returns whether a file has this format, or may have it if `is_certain` is
        False. For `default_names`, it returns False if the file is missing.
    points : callable
        Function that returns the points of a file, either in a projected CRS in metres
        (`io.control.projection`) or in a local frame.
    marks : callable
        Function that returns the marks of a file, in pixels of the stored photo measured from the
        outer corner of its top-left pixel.
    crs : callable
        Function that returns "EPSG:n" or WKT of `points`, or None if the file does not state a CRS.
    has_marks : bool
        Whether a file contains both points and marks.
    default_names : tuple of str
        Default file names next to the photos.
    is_certain : bool
        Whether matching is conclusive. If False, a matching file may have another, more specific
        format.
    extensions : tuple of str
        Usual file extensions, for file dialogs.
    find_marks : callable or None
        Function that returns the file with the marks for a file of points in the same folder, or
        None unless there is exactly one.
    find_points : callable or None
        Function that returns the file in a folder that contains points of this format, whatever its
        name, or None unless there is exactly one.
    """

    name: str
    matches: Callable[[Path], bool]
    points: Callable[[Path], list[ControlPoint]]
    marks: Callable[[Path], list[Mark]]
    crs: Callable[[Path], str | None]
    has_marks: bool = False
    default_names: tuple[str, ...] = ()
    is_certain: bool = True
    extensions: tuple[str, ...] = ()
    find_marks: Callable[[Path], Path | None] | None = None
    find_points: Callable[[Path], Path | None] | None = None
