"""Findings about control points and about a completed reconstruction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vomstudio.core.findings import Finding
from vomstudio.ui.base.texts import format_sentence

if TYPE_CHECKING:
    from vomstudio.project.records import Model
    from vomstudio.studio.jobs.reconstruction_tasks import Reconstruction
    from vomstudio.studio.jobs.survey_tasks import ControlSummary


def control_findings(facts: ControlSummary | None, note: Finding | None) -> list[Finding]:
    """Return the findings about the control points.

    Parameters
    ----------
    facts : ControlSummary or None
    note : Finding or None
        Reason why the control points beside the photos are not used; reported only if `facts` is
        None.
    """
    if facts is None:
        return [] if note is None else [note]
    if facts.problem is not None:
        return [facts.problem]
    summary = format_sentence(str(facts.summary))
    if facts.crs:
        summary_finding = Finding("control.registers", crs=facts.crs, summary=summary)
    else:
        summary_finding = Finding("control.registers-locally", summary=summary)
    return [summary_finding, *facts.warnings]


def placement_findings(model: Model, resolution: float | None) -> list[Finding]:
    """Return a finding on the placement of a model, and the warnings of its registration.

    Parameters
    ----------
    model : Model
    resolution : float or None
        Resolution in units of the model file, or None if unknown.
    """
    from vomstudio.registration.summary import placement_facts, summarize_registration

    facts = placement_facts(model, resolution)
    text = "; ".join(f"{name}: {value}" for name, value in facts)
    placement = Finding("model.placed", model=model.name, facts=text)
    registration = model.registration
    warnings = () if registration is None else summarize_registration(registration).warnings
    return [placement, *warnings]


def finished_reconstruction(name: str, result: Reconstruction) -> Finding:
    """Return the notice of a completed reconstruction, with the RMS of its registration.

    Parameters
    ----------
    name : str
        Name of the folder of photos.
    result : Reconstruction
    """
    fit = _registration_rms(result.registration)
    return Finding(
        "reconstruction.finished",
        name=name,
        registered=result.registered,
        photos=result.photos,
        faces=result.faces,
        fit="" if fit is None else fit.message,
        **({} if fit is None else fit.values),
    )


def _registration_rms(registration: Mapping[str, Any]) -> Finding | None:
    """Return the RMS of the control and check points or the camera positions, or None."""
    control, check = registration.get("rms_control_m"), registration.get("rms_check_m")
    if control is not None and check is not None:
        return Finding("registration.check-rms", control_m=control, check_m=check)
    if control is not None:
        return Finding("registration.control-rms", control_m=control)
    if (positions := registration.get("rms_m")) is not None:
        return Finding("registration.positions-rms", positions_m=positions)
    return None
