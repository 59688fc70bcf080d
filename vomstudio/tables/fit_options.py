"""Options of the fit of planes to points, declared once for every door."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import check_options, option
from vomstudio.words import to_translate


@dataclass(frozen=True)
class FitOptions:
    """How planes are fitted and judged.

    Raises
    ------
    UsageError
        For a value that is not allowed.
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

    def __post_init__(self) -> None:
        check_options(self)
