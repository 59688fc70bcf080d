"""Short texts about a live fit that are shown beside the cursor."""

from __future__ import annotations

from textwrap import wrap

from vomstudio.geology.quality import Verdict

WRAP_WIDTH = 44
"""Maximum number of characters per line beside the cursor."""


def first_reason_lines(verdict: Verdict) -> list[str]:
    """Return the first reason of a verdict, wrapped to WRAP_WIDTH."""
    return [line for finding in verdict.reasons[:1] for line in wrap(finding.message, WRAP_WIDTH)]
