"""Text beside the cursor, with the attitude and error of the selected area."""

from __future__ import annotations

from textwrap import wrap

from vomstudio.core.words import tr
from vomstudio.project.measurement_cache import Measurement
from vomstudio.studio.tools.fit_summary import WRAP_WIDTH, first_reason_lines
from vomstudio.studio.tools.tool_context import ToolContext


def plane_reading(
    context: ToolContext, measurement: Measurement | None, *, is_painting: bool
) -> tuple[str, ...]:
    """Return the lines of text, which are abbreviated while `is_painting`.

    Parameters
    ----------
    context : ToolContext
    measurement : Measurement or None
    is_painting : bool

    Returns
    -------
    tuple of str
    """
    if measurement is None:
        return ()
    verdict = measurement.verdict
    if measurement.fit is None or verdict is None:
        problem = tr("No plane yet: {problem}", problem=measurement.problem)
        return tuple(wrap(problem, WRAP_WIDTH))
    attitude = context.format_attitude(measurement)
    # The text must not cover the surface that is painted next; the panel shows the reason.
    return (attitude,) if is_painting else (attitude, *first_reason_lines(verdict))
