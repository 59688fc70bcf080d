"""Short texts about a live fit that are shown beside the cursor."""

from __future__ import annotations

from textwrap import wrap

from vomstudio.geology.quality import Verdict
from vomstudio.geometry.planes import FittedPlane

WIDTH = 44
"""Maximum number of characters per line beside the cursor."""


def indices_text(fit: FittedPlane, size: str) -> str:
    """Return a text with M and K, if they are defined, and the size."""
    indices = "   ".join(
        f"{name} {value:.1f}" for name, value in (("M", fit.M), ("K", fit.K)) if value is not None
    )
    return f"{indices}   {size}" if indices else size


def first_reason(verdict: Verdict) -> list[str]:
    """Return the first reason of a verdict, wrapped to WIDTH."""
    return [line for why in verdict.reasons[:1] for line in wrap(why.message, WIDTH)]
