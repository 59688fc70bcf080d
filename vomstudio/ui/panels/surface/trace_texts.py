"""User-facing texts that describe proposed traces."""

from __future__ import annotations

from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.studio.surfaces.trace_proposals import ProposedLine, ProposedLines

_FEATURE_TEXTS = {
    "dark": to_translate("Darker than its surroundings"),
    "light": to_translate("Lighter than its surroundings"),
    "gradient": to_translate("Stronger brightness edge than in its surroundings"),
    "curvature": to_translate("Sharper edge or furrow than in its surroundings"),
    "onnx": to_translate("Higher edge probability than in its surroundings"),
}


def summary_text(proposals: ProposedLines, open_count: int) -> str:
    """Return the number of undecided lines, and warnings about them."""
    text = tr_n("{count:,} proposed line.", "{count:,} proposed lines.", open_count)
    if not proposals.lines and not proposals.known:
        return tr(
            "No line of {length:.3g} m or more is significant. Search for shorter lines, or"
            " for another kind.",
            length=proposals.result.least_length_m,
        )
    if proposals.known:
        text += " " + tr_n(
            "{count} more coincides with an existing trace or a rejected line.",
            "{count} more coincide with existing traces or rejected lines.",
            proposals.known,
        )
    return " ".join([text, *map(str, proposals.result.warnings)])


def reason_text(proposals: ProposedLines, line: ProposedLine) -> str:
    """Return the evidence for a proposed line and the verdict on its plane."""
    cost = proposals.options.used_cost
    feature = (
        tr(_FEATURE_TEXTS[cost])
        if cost in _FEATURE_TEXTS
        else tr("Lower {field} than in its surroundings", field=cost)
    )
    sentences = [
        tr(
            "{what}, by {evidence:.1f} standard deviations of the noise on average, over "
            "{length:.3g} m.",
            what=feature,
            evidence=line.evidence,
            length=line.length_m,
        ),
        _doubt_text(line.doubt, proposals.result.surrogates),
    ]
    if line.measured.problem:
        sentences.append(str(line.measured.problem))
    verdict = line.measured.verdict
    if verdict is not None and verdict.quality != "good":
        sentences += [reason.message for reason in verdict.reasons]
    return " ".join(sentences)


def _doubt_text(p_value: float, surrogates: int) -> str:
    stronger_count = round(p_value * (1 + surrogates)) - 1
    if stronger_count <= 0:
        return tr(
            "None of {count} simulated noise surfaces has a line this strong.", count=surrogates
        )
    if stronger_count >= surrogates:
        return tr(
            "Each of {count} simulated noise surfaces has a line this strong, so it may be noise.",
            count=surrogates,
        )
    return tr_n(
        "{count} of {all} simulated noise surfaces has a line this strong.",
        "{count} of {all} simulated noise surfaces have a line this strong.",
        stronger_count,
        all=surrogates,
    )
