"""Options of planes extended through a model, shared by all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import (
    MAX_LENGTH_M,
    MIN_LENGTH_M,
    Options,
    check_requires,
    option,
)
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class ExtendOptions(Options):
    """Plane to extend, unless it is fitted to points, and the beds parallel to it.

    Raises
    ------
    UsageError
        If a value is out of bounds, or if a plane is given without its point or error.
    """

    plane: str | None = option(
        None,
        metavar="DD/D",
        help=to_translate("dip direction and dip, instead of points (with --through and --error)"),
    )
    through: str | None = option(
        None, metavar="X,Y,Z", help=to_translate("World point on the plane")
    )
    error_deg: float | None = option(
        None, minimum=0.0, maximum=44.9, help=to_translate("95 % error of the plane's attitude")
    )
    through_error_m: float = option(
        0.0,
        minimum=0.0,
        maximum=MAX_LENGTH_M,
        help=to_translate("95 % error of the point, across the plane, m"),
    )
    thickness_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Thickness"),
        help=to_translate("repeat the plane at intervals of this bed thickness, m"),
        tip=to_translate("Repeat the plane at intervals of this bed thickness"),
        empty_text=to_translate("this plane only"),
    )
    thickness_error_m: float = option(
        0.0,
        minimum=0.0,
        maximum=MAX_LENGTH_M,
        label=to_translate("95 % error"),
        help=to_translate("95 % error of the thickness, m; bed k has k times this error"),
        tip=to_translate("95 % error of the thickness"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_requires(self, "plane", "through")
        check_requires(self, "plane", "error_deg")
        for name in ("through", "error_deg", "through_error_m"):
            check_requires(self, name, "plane")
        check_requires(self, "thickness_error_m", "thickness_m")

    def check_points(self, points: object, name: str) -> None:
        """Require either the plane or points, which are the argument `name`.

        Raises
        ------
        UsageError
            If both or neither are given.
        """
        if points is None and self.plane is None:
            raise UsageError(Finding("option.none-given", options=(name, "--plane")), field=name)
        if points is not None and self.plane is not None:
            raise UsageError(
                Finding("option.conflict", option=name, other="--plane"), field="--plane"
            )
