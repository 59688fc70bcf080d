"""What is said of proposed traces."""

from __future__ import annotations

from vomstudio.ui.common.follow_box import COSTS
from vomstudio.words import to_translate, tr, tr_n
from vomstudio.workspace.surfaces.trace_proposals import ProposedLine, ProposedLines

_WHAT = {
    "dark": to_translate("Darker than its surroundings"),
    "light": to_translate("Lighter than its surroundings"),
    "gradient": to_translate("A stronger edge of lightness than its surroundings have"),
    "curvature": to_translate("A sharper edge or furrow than its surroundings have"),
    "onnx": to_translate("More of an edge to the network than its surroundings"),
}


def cost_choices() -> list[tuple[str, str]]:
    """Costs that lines are proposed by, without fields, and what they are called."""
    return [(cost, tr(words)) for cost, words in COSTS if cost in _WHAT]


def summary_text(found: ProposedLines, left: int) -> str:
    """How many are to be decided upon."""
    said = tr_n("{count:,} line to decide upon.", "{count:,} lines to decide upon.", left)
    if not found.lines and not found.known:
        return tr(
            "No line of {length:.3g} m or more stands out of the surface's noise. Look for shorter "
            "ones, or for something else.",
            length=found.told.least_length_m,
        )
    if found.known:
        said += " " + tr_n(
            "{count} more runs along a trace of the project or what was rejected.",
            "{count} more run along traces of the project or what was rejected.",
            found.known,
        )
    return " ".join([said, *map(str, found.told.warnings)])


def reason_text(found: ProposedLines, line: ProposedLine) -> str:
    """Why a line is proposed, how much it is to be doubted, and what its plane is worth."""
    cost = found.options.used_cost
    what = tr(_WHAT[cost]) if cost in _WHAT else tr("Lower {field} than around it", field=cost)
    said = [
        tr(
            "{what}, by {evidence:.1f} standard deviations of the noise on average, over "
            "{length:.3g} m.",
            what=what,
            evidence=line.evidence,
            length=line.length_m,
        ),
        _doubt_text(line.doubt, found.told.surrogates),
    ]
    if line.measured.problem:
        said.append(str(line.measured.problem))
    verdict = line.measured.verdict
    if verdict is not None and verdict.quality != "good":
        said += [reason.message for reason in verdict.reasons]
    return " ".join(said)


def _doubt_text(doubt: float, surrogates: int) -> str:
    as_strong = round(doubt * (1 + surrogates)) - 1
    if as_strong <= 0:
        return tr("None of {count} surfaces of noise has a line as strong.", count=surrogates)
    if as_strong >= surrogates:
        return tr(
            "Each of {count} surfaces of noise has a line as strong: this may well be noise.",
            count=surrogates,
        )
    return tr_n(
        "{count} of {all} surfaces of noise has a line as strong.",
        "{count} of {all} surfaces of noise have a line as strong.",
        as_strong,
        all=surrogates,
    )
