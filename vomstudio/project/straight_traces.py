"""Straight traces of a project compared with its other planes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from vomstudio.project.measurement import Measurement

if TYPE_CHECKING:
    from vomstudio.geology.plane_bands import PlaneBand, SetPrior


def band_of_measured(measured: Measurement) -> PlaneBand | None:
    """Return the band of planes that a straight trace allows; None for other features."""
    if measured.fit is None or measured.judged_as != "trace" or measured.line is not None:
        return None
    from vomstudio.geology.plane_bands import find_plane_band

    return find_plane_band(
        measured.fit,
        resolution_m=measured.resolution_m,
        registration_deg=measured.registration_error_deg,
        outcrop_normal=measured.outcrop_normal,
    )


def priors_among(
    features: Iterable[Any],
    measured: Mapping[str, Measurement],
    set_name: Callable[[Any], str],
    excluded_id: str,
) -> list[SetPrior]:
    """The sets of planes, by their names, that a trace may belong to: without the trace itself, and
    without planes that are poor."""
    from vomstudio.geology.band_figures import fit_priors

    groups: dict[str, list[Any]] = {}
    for feature in features:
        measurement = measured.get(feature.id)
        if feature.id == excluded_id or measurement is None or measurement.plane is None:
            continue
        if measurement.verdict is not None and measurement.verdict.quality == "poor":
            continue
        groups.setdefault(name_of(feature), []).append(found.plane.normal())
    return fit_priors(groups)
