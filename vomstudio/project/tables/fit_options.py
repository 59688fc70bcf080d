"""Options for fitting planes to points, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import Options, check_requires, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class FitOptions(Options):
    """Options for fitting and judging planes.

    Raises
    ------
    UsageError
        If a value is not allowed.
    """

    by: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate(
            "column that groups the points; segment: lines of --- separate the groups"
        ),
        automatic_text=to_translate("one plane"),
    )
    method: Literal["pca", "regression"] = option(
        "pca",
        help=to_translate(
            "least squares: pca of perpendicular distances, regression of distances along one axis"
        ),
    )
    axis: Literal["auto", "x", "y", "z"] = option(
        "auto",
        help=to_translate("axis of the regression; auto: the axis nearest the normal"),
    )
    profile: Literal["error", "textbook"] = option(
        "error",
        help=to_translate("assess planes by their 95 % error, or by the textbook limits"),
    )


@dataclass(frozen=True)
class FitTogether(Options):
    """Options of the command for fitting several traces together and drawing the result.

    Raises
    ------
    UsageError
        If `same` is given without `parallel`.
    """

    parallel: bool = option(
        False,
        help=to_translate("also fit parallel planes to all traces, such as beds of one series"),
    )
    same: tuple[str, ...] = option(
        (),
        metavar="A,B",
        help=to_translate("with --parallel: test whether these two traces belong to one bed"),
    )
    curved: bool = option(
        False, help=to_translate("also fit one curved bed to all traces, with its local dips")
    )
    crossing: tuple[str, ...] = option(
        (),
        metavar="A,B",
        help=to_translate("find the plane that contains these two straight traces"),
    )
    plot: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("plot coplanarity against collinearity (.svg, .pdf or .png)"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_requires(self, "same", "parallel")
