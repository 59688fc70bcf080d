"""What the straight traces of a document determine, held against its other planes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from vomstudio.project.measurement import Measurement

if TYPE_CHECKING:
    from vomstudio.geology.plane_bands import PlaneBand, SetPrior


def band_of_measured(measured: Measurement) -> PlaneBand | None:
    """The band of planes that a straight trace allows; None for everything else."""
    if measured.fit is None or measured.judged_as != "trace" or measured.line is not None:
        return None
    from vomstudio.geology.plane_bands import band_of

    return band_of(
        measured.fit,
        resolution_m=measured.resolution_m,
        registration_deg=measured.registration_error_deg,
        outcrop_normal=measured.outcrop_normal,
    )


def priors_among(
    features: Iterable[Any],
    measured: Mapping[str, Measurement],
    name_of: Callable[[Any], str],
    leave_out: str,
) -> list[SetPrior]:
    """The sets of planes, by their names, that a trace may belong to: without the trace itself, and
    without planes that are poor."""
    from vomstudio.geology.band_figures import priors_of

    groups: dict[str, list[Any]] = {}
    for feature in features:
        found = measured.get(feature.id)
        if feature.id == leave_out or found is None or found.plane is None:
            continue
        if found.verdict is not None and found.verdict.quality == "poor":
            continue
        groups.setdefault(name_of(feature), []).append(found.plane.normal())
    return priors_of(groups)
