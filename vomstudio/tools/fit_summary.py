"""A live fit in the few words that stand beside the cursor."""

from __future__ import annotations

from textwrap import wrap

from vomstudio.geology.quality import Verdict
from vomstudio.geometry.planes import PlaneFit

WIDTH = 44
"""Letters of a line beside the cursor."""


def error_text(fit: PlaneFit) -> str:
    if fit.max_confidence95_deg is None:
        return "95 %: undefined"
    return f"95 %: {fit.max_confidence95_deg:.1f}° × {fit.min_confidence95_deg or 0:.1f}°"


def indices_text(fit: PlaneFit, size: str) -> str:
    """M and K where there are such, and the size in words."""
    indices = "   ".join(
        f"{name} {value:.1f}" for name, value in (("M", fit.M), ("K", fit.K)) if value is not None
    )
    return f"{indices}   {size}" if indices else size


def first_reason(verdict: Verdict) -> list[str]:
    return [line for why in verdict.reasons[:1] for line in wrap(why, WIDTH)]
