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
        help=to_translate("column that groups the points; segment: the parts between --- lines"),
        automatic=to_translate("one plane"),
    )
    method: Literal["pca", "regression"] = option(
        "pca", help=to_translate("least distances from the plane (pca), or along one axis")
    )
    axis: Literal["auto", "x", "y", "z"] = option(
        "auto",
        help=to_translate("axis that a regression minimises; auto: the one nearest the normal"),
    )
    profile: Literal["error", "textbook"] = option(
        "error",
        help=to_translate("judge planes by their 95 % error, or by the limits of the textbook"),
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
        False, help=to_translate("also fit parallel planes to all, such as traces of one series")
    )
    same: tuple[str, ...] = option(
        (), metavar="A,B", help=to_translate("with --parallel: test if these two are in one plane")
    )
    curved: bool = option(
        False, help=to_translate("also fit one bed that bends to all, with its local dips")
    )
    crossing: tuple[str, ...] = option(
        (),
        metavar="A,B",
        help=to_translate("find the plane that contains these two straight traces"),
    )
    plot: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("draw the planes' coplanarity by their collinearity: .svg, .pdf or .png"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_requires(self, "same", "parallel")
