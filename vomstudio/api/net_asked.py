"""What a script asks of a net beside its data, checked before anything is drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from vomstudio.api.checking import (
    attitude_of,
    flag,
    items_of,
    naming,
    one_of,
    required_number,
    single_number,
    slashed,
    words_of,
)
from vomstudio.errors import InputError
from vomstudio.geology.density import SIGMA
from vomstudio.geology.fold_planes import MIN_QUALITIES, FoldFilter
from vomstudio.products.net.contents import Contouring
from vomstudio.products.net.contours import check_contouring
from vomstudio.products.net.figure_style import FigureStyle
from vomstudio.products.net.net_options import (
    Turning,
    turn_of,
    typed_cone,
    typed_plane,
    typed_slip,
)
from vomstudio.products.net.net_wishes import FINDINGS, NetWishes
from vomstudio.words import tr

Typed = TypeVar("Typed")


@dataclass(frozen=True)
class NetAsked:
    """The options of `vs.stereonet`, read. size_mm : of a new figure, None for the usual one"""

    contouring: Contouring
    wishes: NetWishes
    style: FigureStyle
    size_mm: tuple[float, float] | None

    @classmethod
    def of(cls, given: dict[str, Any], contour: str | None) -> NetAsked:
        """Takes what it knows out of `given`. Raises InputError, also for what is left, and
        UsageError."""
        size = given.pop("size_mm", None)
        wide, high = (None, None) if size is None else _size(size)
        style = FigureStyle(
            wide,
            high,
            words_of(given.pop("font", None), "font") or "",
            single_number(given.pop("font_pt", None), "font_pt"),
            single_number(given.pop("symbol_pt", None), "symbol_pt"),
            single_number(given.pop("line_pt", None), "line_pt"),
            flag(given.pop("grey", False), "grey"),
        )
        style.check()
        slips = _each(given, "slip_lines", "--slip-line", 3, typed_slip)
        planes = _each(given, "planes", "--plane", 2, typed_plane)
        cones = _each(given, "cones", "--cone", 3, typed_cone)
        made = cls(
            _contouring(given, contour),
            NetWishes(
                _turning(given),
                (*planes, *cones, *(circle for circle, _ in slips)),
                tuple(mark for _, mark in slips),
                frozenset([name for name in FINDINGS if flag(given.pop(name, False), name)]),
                flag(given.pop("intersections", False), "intersections"),
                flag(given.pop("errors", False), "errors"),
                _fold(given),
            ),
            style,
            None if size is None else style.size_mm,
        )
        for name in given:
            raise InputError(tr("Nothing of this name is known."), field=name)
        return made


def _each(
    given: dict[str, Any], name: str, option: str, count: int, read: Callable[[str], Typed]
) -> list[Typed]:
    """What was typed to be drawn, as the command's option reads it. Raises InputError,
    UsageError."""
    with naming(name, option, "dip direction", "dip"):
        return [read(slashed(one, name, count)) for one in items_of(given.pop(name, ()), name)]


def _size(given: Any) -> tuple[float, float]:
    try:
        wide, high = given
    except (TypeError, ValueError):
        raise InputError(tr("A size is (width, height) in millimetres."), field="size_mm") from None
    return required_number(wide, "size_mm"), required_number(high, "size_mm")


def _contouring(given: dict[str, Any], contour: str | None) -> Contouring:
    asked = given.pop("levels", None)
    levels = [] if asked is None else items_of(asked, "levels")
    wanted = tuple(sorted({required_number(level, "levels") for level in levels}))
    sigma = required_number(given.pop("sigma", SIGMA), "sigma")
    check_contouring(contour, wanted, sigma)
    filled = given.pop("filled", None)
    return Contouring(
        wanted,
        None if filled is None else flag(filled, "filled"),
        flag(given.pop("each_set", False), "each_set"),
        sigma,
    )


def _fold(given: dict[str, Any]) -> FoldFilter | None:
    quality, only_set = given.pop("quality", None), given.pop("only_set", None)
    if not flag(given.pop("fold", False), "fold"):
        for name, value in (("quality", quality), ("only_set", only_set)):
            if value is not None:
                raise InputError(
                    tr("It chooses planes of the fold axis: give fold=True."), field=name
                )
        return None
    if quality is not None:
        one_of(quality, MIN_QUALITIES, "quality")
    return FoldFilter(quality, words_of(only_set, "only_set"))


def _turning(given: dict[str, Any]) -> Turning:
    untilt, rotate = given.pop("untilt", None), given.pop("rotate", None)
    plane = None if untilt is None else attitude_of(untilt, "untilt")
    if rotate is None:
        return Turning(plane)
    with naming("rotate", "--rotate"):
        return Turning(plane, *turn_of(slashed(rotate, "rotate", 3)))
