"""Options for the frame of input files, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import Options, declarations, given_options, option
from vomstudio.core.words import to_translate
from vomstudio.geometry.units import METRES_PER_UNIT

UpAxis = Literal["z", "y"]


@dataclass(frozen=True)
class FrameOptions(Options):
    """Up axis, unit and CRS of a file, and the CRS to which it is converted.

    If one of the first three is None, the statement of the file is used. If `to_crs` is None, the
    coordinates are not converted.

    Raises
    ------
    UsageError
        If a value is not one of the choices.
    """

    up: UpAxis | None = option(
        None,
        choices=("y", "z"),
        help=to_translate("up axis of the file (default: as defined by its format, otherwise z)"),
        tip=to_translate("Up axis of the file"),
    )
    unit: str | None = option(
        None,
        choices=tuple(METRES_PER_UNIT),
        help=to_translate(
            "unit of the file's coordinates (default: as specified in the file, otherwise m)"
        ),
        tip=to_translate("Unit of the file's coordinates"),
    )
    crs: str | None = option(
        None,
        metavar="EPSG",
        help=to_translate(
            "coordinate reference system of the file (default: as specified in the file)"
        ),
        tip=to_translate("Coordinate reference system of the file"),
    )
    to_crs: str | None = option(
        None,
        metavar="EPSG",
        help=to_translate("convert the coordinates to this projected CRS in metres"),
        tip=to_translate("Convert the coordinates to this CRS"),
    )

    @property
    def is_given(self) -> bool:
        """Whether any option is given."""
        return self != FrameOptions()

    @property
    def first_option(self) -> str | None:
        """Flag of the first option that is given, or None if no option is given."""
        options = given_options(self)
        return next((item.flag for item in declarations(type(self)) if item.name in options), None)


DEFAULT_FRAME = FrameOptions()
"""No options; the frame is that stated by the file."""
