"""Comparison of straight traces of a project with its other planes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from vomstudio.project.measurement import Measurement

if TYPE_CHECKING:
    from vomstudio.geology.plane_bands import PlaneBand, SetPrior


def measured_band(measurement: Measurement) -> PlaneBand | None:
    """Return the band of planes compatible with a straight trace, or None for other features."""
    if (
        measurement.fit is None
        or measurement.verdict_kind != "trace"
        or measurement.line is not None
    ):
        return None
    from vomstudio.geology.plane_bands import find_plane_band

    return find_plane_band(
        measurement.fit,
        resolution_m=measurement.resolution_m,
        registration_deg=measurement.registration_error_deg,
        outcrop_normal=measurement.outcrop_normal,
    )


def select_priors(
    features: Iterable[Any],
    measurements: Mapping[str, Measurement],
    set_name: Callable[[Any], str],
    excluded_id: str,
) -> list[SetPrior]:
    """Return the sets of planes, by name, to which a trace may belong.

    The trace itself and planes of poor quality are excluded.
    """
    from vomstudio.geology.band_figures import fit_priors

    groups: dict[str, list[Any]] = {}
    for feature in features:
        measurement = measurements.get(feature.id)
        if feature.id == excluded_id or measurement is None or measurement.plane is None:
            continue
        if measurement.verdict is not None and measurement.verdict.quality == "poor":
            continue
        groups.setdefault(set_name(feature), []).append(measurement.plane.normal())
    return fit_priors(groups)
