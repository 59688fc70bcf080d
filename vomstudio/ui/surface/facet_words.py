"""What is said of proposed facets."""

from __future__ import annotations

from collections.abc import Collection

from vomstudio.extraction.exposure import NEAR_PLANAR_SHARE
from vomstudio.geology.agreement_both_ways import BothWays
from vomstudio.words import tr, tr_n
from vomstudio.workspace.surfaces.facet_proposals import Proposals


def summary_text(found: Proposals, left: Collection[int], accepted: Collection[int]) -> str:
    """How many are to be decided upon, and how much of the rock facets stand for, in a line."""
    count = tr_n("{count:,} facet to decide upon", "{count:,} facets to decide upon", len(left))
    share = found.share({*left, *accepted}) if found.whole else None
    if share is None:
        return f"{count}."
    if share < NEAR_PLANAR_SHARE:
        return tr(
            "{count}; facets are only {share:.0f} % of the exposed rock: pick traces by hand.",
            count=count, share=100.0 * share,
        )  # fmt: skip
    return tr(
        "{count}; facets are {share:.0f} % of the exposed rock.", count=count, share=100.0 * share
    )


def share_text(found: Proposals, left: Collection[int], accepted: Collection[int]) -> str:
    """The share of the exposed rock that lies in facets, proposed and accepted, and where not."""
    if not found.whole:
        return tr(
            "This is a part of the model: how much of the exposed rock is near-planar is told of "
            "all of it."
        )
    proposed, taken = found.share({*left, *accepted}), found.share(accepted)
    if proposed is None or taken is None:
        return tr("The model shows no rock without vegetation and debris.")
    said = tr(
        "Of the exposed rock, without vegetation and debris, {proposed:.0f} % lies in facets that "
        "are proposed or accepted, {accepted:.0f} % in accepted ones (30 % recommended).",
        proposed=100.0 * proposed,
        accepted=100.0 * taken,
    )
    if proposed < NEAR_PLANAR_SHARE:
        said += " " + tr("“Colours by exposure” shows where traces by hand are needed.")
    return said


def agreement_text(held: BothWays) -> str:
    """How far facets and picks bear each other out."""
    said = tr(
        "Picked planes with a facet beside them: {near} of {picked}; {found} of these agree with "
        "one.",
        near=held.picks_near,
        picked=held.picked,
        found=held.picks_found,
    )
    if held.median_angle_deg is not None:
        said += " " + tr("Median angle {angle:.1f}°.", angle=held.median_angle_deg)
    if held.proposed_near:
        said += " " + tr(
            "Facets with a pick beside them: {near} of {proposed}; {found} of these agree with "
            "one.",
            near=held.proposed_near,
            proposed=held.proposed,
            found=held.proposed_borne_out,
        )
    return said
