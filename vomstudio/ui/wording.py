"""Numbers in words: the same notation, units and digits everywhere in the window."""

from __future__ import annotations

import re
from math import floor, isfinite, log10

from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.planes import PlaneFit


def plane_text(
    fit: PlaneFit | None, notation: str, *, local: bool = False, decimals: int | None = None
) -> str:
    """A plane, with a decimal only where its error is under a degree, or with `decimals`, so that
    a column of planes has the same number of digits."""
    if fit is None:
        return "–"
    if decimals is None:
        error = fit.max_confidence95_deg
        decimals = 1 if error is not None and error < 1.0 else 0
    text = format_plane(Plane.from_normal(fit.normal), notation, decimals)
    return f"{text} (local frame)" if local else text


def degrees(value: float | None) -> str:
    """An error: two digits that mean something."""
    if value is None:
        return "–"
    decimals = 2 if value < 0.995 else 1 if value < 9.95 else 0
    return f"{value:.{decimals}f}°"


def number(value: float | None, digits: int = 3) -> str:
    """A ratio or an index, to so many significant digits."""
    if value is None:
        return "–"
    if not isfinite(value):
        return "∞"
    if value == 0 or abs(value) >= 1e6:
        return f"{value:.{digits}g}"
    decimals = max(0, digits - 1 - floor(log10(abs(value))))
    return f"{value:.{decimals}f}"


def length(value_m: float | None) -> str:
    """A length in the unit that suits it."""
    if value_m is None:
        return "–"
    if value_m < 0.01:
        return f"{value_m * 1000:.2g} mm"
    if value_m < 1.0:
        return f"{value_m * 100:.2g} cm"
    if value_m < 1000.0:
        return f"{value_m:.3g} m"
    return f"{value_m / 1000:.3g} km" if value_m < 1e6 else f"{value_m / 1000:.0f} km"


def natural(name: str) -> tuple[tuple[int, int, str], ...]:
    """For sorting: B2 before B10."""
    return tuple(
        (0, int(part), "") if part.isdecimal() else (1, 0, part.casefold())
        for part in re.split(r"(\d+)", name)
        if part
    )
