"""Text beside the cursor, with the attitude and error of the chosen area."""

from __future__ import annotations

from textwrap import wrap

from vomstudio.core.words import tr
from vomstudio.geometry.units import area_text
from vomstudio.project.measurement_cache import Measurement
from vomstudio.studio.tools.fit_summary import WIDTH, first_reason, indices_text
from vomstudio.studio.tools.polyline import points_text
from vomstudio.studio.tools.tool_context import ToolContext


def plane_reading(
    context: ToolContext, measurement: Measurement | None, *, painting: bool
) -> tuple[str, ...]:
    """Return the lines of text, which are abbreviated while `painting`.

    Parameters
    ----------
    context : ToolContext
    measurement : Measurement or None
    painting : bool

    Returns
    -------
    tuple of str
    """
    if measurement is None:
        return ()
    fit, verdict = measurement.fit, measurement.verdict
    if fit is None or verdict is None:
        problem = tr("No plane yet: {problem}", problem=measurement.problem)
        return tuple(wrap(problem, WIDTH))
    size = (
        points_text(fit.n)
        if measurement.area_m2 is None
        else f"{area_text(measurement.area_m2, metric=measurement.metric)}   n {fit.n}"
    )
    if painting:
        # The text must not cover the surface that is painted next; the panel shows the remaining
        # values.
        return (context.format_attitude(measurement),)
    return (
        context.format_attitude(measurement),
        indices_text(fit, size),
        *first_reason(verdict),
    )
