"""Planes as text, as panels and messages show them."""

from __future__ import annotations

from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.planes import PlaneFit
from vomstudio.words import tr


def plane_text(
    fit: PlaneFit | None,
    notation: str,
    *,
    local: bool = False,
    decimals: int | None = None,
    plane: Plane | None = None,
) -> str:
    """A plane, whose attitude may be known already, with a decimal only where its error is under a
    degree, or with `decimals`, so that a column of planes has the same number of digits."""
    if fit is None:
        return "–"
    if decimals is None:
        error = fit.max_confidence95_deg
        decimals = 1 if error is not None and error < 1.0 else 0
    text = format_plane(plane or Plane.from_normal(fit.normal), notation, decimals)
    return tr("{plane} (local frame)", plane=text) if local else text
