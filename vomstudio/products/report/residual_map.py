"""Picture of a registration: its points with residuals, and its weakest axis."""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.words import tr
from vomstudio.products.figure_layout import label_symbols
from vomstudio.products.report.page import svg_picture

# Length of the longest arrow, relative to the width of the picture.
_MAX_ARROW_SHARE = 0.12
_MAX_LABELS = 25


def residual_map(registration: Mapping[str, Any], is_scaled: bool) -> str:
    """Draw the residuals of at least three points from above and from the side, as HTML.

    Returns "" for fewer points.

    Parameters
    ----------
    registration : mapping
        Registration in a reconstruction result.
    is_scaled : bool
        Whether lengths are in metres.
    """
    from matplotlib.figure import Figure

    labels, positions, residuals, check = _points(registration)
    if len(labels) < 3:
        return ""
    centre = positions.mean(axis=0)
    offsets = positions - centre
    sizes = np.linalg.norm(residuals, axis=1)
    extent = float(np.ptp(offsets, axis=0).max()) or 1.0
    exaggeration = _round_down(_MAX_ARROW_SHARE * extent / sizes.max()) if sizes.max() > 0 else 1.0
    figure = Figure(figsize=(9.5, 4.4), layout="constrained")
    unit = "m" if is_scaled else tr("model units")
    weakest_axis = _weakest_axis(registration)
    sides = ((0, 1, "xy", tr("from above")), (0, 2, "xz", tr("from the south")))
    for axes, (i, j, names, title) in zip(figure.subplots(1, 2), sides, strict=True):
        if weakest_axis is not None:
            axis_end = 0.55 * extent * weakest_axis
            axes.plot(
                [-axis_end[i], axis_end[i]],
                [-axis_end[j], axis_end[j]],
                "--",
                color="#d55e00",
                lw=1.2,
            )
        for is_selected, mark in ((~check, "o"), (check, "s")):
            axes.plot(
                offsets[is_selected, i],
                offsets[is_selected, j],
                mark,
                color="#0072b2",
                markersize=4.0,
                markerfacecolor="#0072b2" if mark == "o" else "white",
            )
        axes.quiver(
            offsets[:, i],
            offsets[:, j],
            exaggeration * residuals[:, i],
            exaggeration * residuals[:, j],
            color="#222222",
            angles="xy",
            scale_units="xy",
            scale=1.0,
            width=0.004,
        )
        axes.margins(0.15)
        axes.set_aspect("equal", "datalim")
        axes.set_xlabel(f"{names[0]}, {unit}")
        axes.set_ylabel(f"{names[1]}, {unit}")
        axes.set_title(title)
    for axes, (i, j, _, _) in zip(figure.axes, sides, strict=True):
        label_symbols(
            axes,
            offsets[:, [i, j]],
            dict(enumerate(labels[:_MAX_LABELS])),
            symbol_pt=4.0,
            font_pt=7.0,
            color="#222222",
        )
    return embed_figure(
        figure,
        tr(
            "Registration points relative to their centre (squares: check points); arrows:"
            " residuals, exaggerated {times:,.0f} times; dashed: weakest rotation axis.",
            times=exaggeration,
        )
        if exaggeration >= 1.0
        else tr(
            "Registration points relative to their centre (squares: check points); arrows:"
            " residuals, exaggerated {times:.2g} times; dashed: weakest rotation axis.",
            times=exaggeration,
        ),
    )


def embed_figure(figure: Any, caption: str) -> str:
    """Embed a matplotlib figure in an HTML page."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    buffer = BytesIO()
    # Qt's browser cannot draw letters as paths.
    with rc_context({"svg.fonttype": "none"}):
        FigureCanvasSVG(figure).print_svg(buffer)
    return svg_picture(buffer.getvalue(), caption)


def _points(registration: Mapping[str, Any]) -> tuple[list[str], FloatArray, FloatArray, BoolArray]:
    """Return the labels, positions and residuals of points, and a mask of check points."""
    rows = [
        (row["label"], row["surveyed"], row["residual_m"], row["role"] == "check")
        for row in registration.get("points", ())
        if row.get("role") in ("control", "check") and row.get("residual_m") and row.get("surveyed")
    ]
    rows += [
        (row["name"], row["surveyed"], [row[axis] for axis in ("dx", "dy", "dz")], False)
        for row in registration.get("residuals", ())
        if row.get("used") and row.get("surveyed")
    ]
    return (
        [str(row[0]) for row in rows],
        np.array([row[1] for row in rows], np.float64).reshape(-1, 3),
        np.array([row[2] for row in rows], np.float64).reshape(-1, 3),
        np.array([row[3] for row in rows], bool),
    )


def _weakest_axis(registration: Mapping[str, Any]) -> FloatArray | None:
    covariance = np.array(registration.get("covariance", []), np.float64)
    if covariance.shape != (7, 7) or not covariance.any():
        return None
    return np.asarray(np.linalg.eigh(covariance[:3, :3])[1][:, -1], np.float64)


def _round_down(value: float) -> float:
    """Round a value down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1.0, 2.0, 5.0) if step * power <= value) * power)
