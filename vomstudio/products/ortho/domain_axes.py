"""Axes of the domains of an interpretation, for projection and viewing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.domains import ProjectionAxis, projection_axes
from vomstudio.geology.fold_planes import FoldFilter, select_planes
from vomstudio.geology.notation import format_line
from vomstudio.geology.orientation import Line, angle_between_lines
from vomstudio.products.ortho.interpretation import Item
from vomstudio.products.ortho.planning import OrthophotoPlan
from vomstudio.products.ortho.view_directions import cost_of_deviation

BEDDING_TYPE, FAULT_TYPE = "bedding", "fault"
"""Feature types whose planes define the axes."""
_MIN_DEVIATION_DEG = 1.0


def domain_names(items: Iterable[Item]) -> list[str]:
    """Return the sorted names of the domains of items."""
    return sorted({item.domain for item in items if item.domain})


def no_domains_error(field: str) -> UsageError:
    """Return the error for items without domains."""
    return UsageError(Finding("domain.none"), field=field)


def compute_domain_axes(items: Iterable[Item], field: str) -> dict[str, ProjectionAxis]:
    """Compute the axis of each domain from its bedding planes and from all faults.

    The axis of a domain without bedding planes contains only the reason why it is unknown.

    Raises
    ------
    UsageError
        If no plane belongs to a domain; `field` is the name of the option.
    """
    planes = [item for item in items if item.normal is not None and item.dip_deg is not None]
    beds: dict[str, list[Item]] = {name: [] for name in domain_names(planes)}
    if not beds:
        raise no_domains_error(field)
    for item in planes:
        if item.domain and item.kind.casefold() in (BEDDING_TYPE, ""):
            beds[item.domain].append(item)
    faults = [item for item in planes if item.kind.casefold() == FAULT_TYPE]
    planes_by_domain = {name: _select_planes(beds) for name, beds in beds.items() if beds}
    axes = projection_axes(
        {name: _angles(used_planes) for name, (used_planes, _) in planes_by_domain.items()},
        _angles(faults) if faults else None,
    )
    for name, (used_planes, not_good_count) in planes_by_domain.items():
        if not_good_count:
            text = tr(
                "{axis}; {not_good} of {n} planes not rated good",
                axis=axes[name].description,
                not_good=not_good_count,
                n=len(used_planes),
            )
            axes[name] = replace(axes[name], description=text)
    reason = tr("it has no bedding plane")
    return {name: axes.get(name, ProjectionAxis(None, None, reason)) for name in beds}


def _select_planes(items: list[Item]) -> tuple[list[Item], int | None]:
    """Return the planes for the fold axis, and how many are not good (None if unknown)."""
    selection = select_planes([i.quality for i in items], [i.set for i in items], FoldFilter())
    return [
        item for item, is_used in zip(items, selection.is_used, strict=True) if is_used
    ], selection.not_good


def off_axis_findings(
    items: Iterable[Item], name: str, plan: OrthophotoPlan
) -> tuple[Finding, ...]:
    """Return findings if the direction of a view deviates from the axis of a domain.

    The tolerance is the 95 % error of the axis, but at least `_MIN_DEVIATION_DEG`.
    """
    try:
        axis = compute_domain_axes(items, "")[name]
    except (UsageError, KeyError):
        return ()
    if axis.line is None:
        return ()
    offset = angle_between_lines(axis.line, Line.from_vector(plan.frame.direction))
    if offset <= max(axis.error95_deg or 0.0, _MIN_DEVIATION_DEG):
        return ()
    depth_m = float(np.ptp(plan.points[:, 2]))
    return (
        Finding(
            "view.off-axis",
            off_deg=offset,
            domain=name,
            axis=format_line(axis.line, 0),
            description=axis.description,
        ),
        cost_of_deviation(offset, depth_m, is_metric=plan.view.is_metric),
    )


def _angles(items: list[Item]) -> tuple[np.ndarray, np.ndarray]:
    return (
        np.array([item.dip_direction_deg for item in items], np.float64),
        np.array([item.dip_deg for item in items], np.float64),
    )
