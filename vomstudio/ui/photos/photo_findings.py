"""What the Photos panel says of control points and of a finished reconstruction."""

from __future__ import annotations

from vomstudio.jobs.reconstruction_tasks import Reconstruction
from vomstudio.jobs.survey_tasks import ControlFacts
from vomstudio.ui.common.sentences import as_sentence
from vomstudio.words import tr


def control_findings(facts: ControlFacts | None, note: str) -> list[tuple[str, str]]:
    """Severity and text of each finding about the control points. note : why control points beside
    the photos are not used, "" where they are; it is said where there are no facts."""
    if facts is None:
        return [("warning", note)] if note else []
    if facts.problem:
        return [("error", as_sentence(facts.problem))]
    summary = as_sentence(facts.summary)
    if facts.crs:
        first = tr(
            "The model will be registered by ground control in {crs}. {summary}",
            crs=facts.crs,
            summary=summary,
        )
    else:
        first = tr(
            "The model will be registered by ground control in a local frame. {summary}",
            summary=summary,
        )
    return [("info", first), *(("warning", as_sentence(text)) for text in facts.warnings)]


def finished_text(name: str, result: Reconstruction) -> str:
    """The notice of a finished reconstruction of the photos of this name."""
    return tr(
        "The reconstruction of {name} is finished: {registered} of {photos} photos are aligned, "
        "and the mesh has {faces:,} faces.",
        name=name,
        registered=result.registered,
        photos=result.photos,
        faces=result.faces,
    )
