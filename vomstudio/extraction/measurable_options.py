"""Options of the map of measurable planes, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import (
    MAX_LENGTH_M,
    MIN_LENGTH_M,
    Options,
    check_alternatives,
    check_requires,
    option,
)
from vomstudio.core.words import to_translate

DEFAULT_ANGLE_DEG = 10.0
MIN_POINTS, MAX_POINTS = 4, 1_000_000


@dataclass(frozen=True)
class MeasurableOptions(Options):
    """Options for the map of measurable planes: traces to pick, and accuracy of the model.

    Raises
    ------
    UsageError
        If a value is outside its bounds.
    """

    length_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Trace length"),
        help=to_translate("length of a trace, m"),
        tip=to_translate("Length of the traces to be picked"),
        automatic_text=to_translate("100 times the model resolution"),
    )
    noise_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        help=to_translate(
            "standard deviation of a trace's vertices perpendicular to their plane, m"
        ),
        automatic_text=to_translate("1/20 of the resolution, about half a photo pixel"),
    )
    points: int | None = option(
        None,
        minimum=MIN_POINTS,
        maximum=MAX_POINTS,
        help=to_translate("number of vertices of a trace"),
        automatic_text=to_translate("trace length divided by the resolution"),
    )
    resolution_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        help=to_translate("resolution of the model, m"),
        automatic_text=to_translate("estimated locally from its points"),
    )
    angle_deg: float = option(
        DEFAULT_ANGLE_DEG,
        minimum=0.1,
        maximum=45.0,
        help=to_translate("maximum angle between the plane and the faces of a patch"),
    )
    registration_error_deg: float | None = option(
        None,
        minimum=0.0,
        maximum=89.0,
        help=to_translate("95 % error of the plane caused by the registration"),
        automatic_text=to_translate("from --project, otherwise 0"),
    )

    @property
    def used_registration_error_deg(self) -> float:
        """Effective registration error in degrees; 0 by default."""
        return self.registration_error_deg or 0.0


@dataclass(frozen=True)
class MeasurableTarget(Options):
    """Plane and output raster of the command.

    Raises
    ------
    UsageError
        If not exactly one plane is given, if a set is given without a table, or if the cell size is
        outside its bounds.
    """

    plane: str | None = option(
        None, metavar="DD/D", help=to_translate("dip direction and dip of the plane")
    )
    mean: str | None = option(
        None,
        metavar="TABLE",
        help=to_translate("use the mean plane of this table (orientation tensor)"),
    )
    set: str | None = option(
        None, metavar="NAME", help=to_translate("use only this set of the table")
    )
    gsd_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        help=to_translate("cell size of the raster, m"),
        automatic_text=to_translate("1/40 of the trace length, at least the resolution"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_alternatives(self, "plane", "mean")
        check_requires(self, "set", "mean")
