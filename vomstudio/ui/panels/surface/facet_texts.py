"""Texts about proposed facets."""

from __future__ import annotations

from collections.abc import Collection

from vomstudio.core.words import tr, tr_n
from vomstudio.extraction.exposure import NEAR_PLANAR_SHARE
from vomstudio.geology.plane_matching import MutualAgreement
from vomstudio.studio.surfaces.facet_proposals import Proposals


def summary_text(
    proposals: Proposals, open_rows: Collection[int], accepted_rows: Collection[int]
) -> str:
    """Return the number of undecided facets and the facets' share of the exposed rock."""
    count = tr_n(
        "{count:,} facet to decide upon", "{count:,} facets to decide upon", len(open_rows)
    )
    share = proposals.share({*open_rows, *accepted_rows}) if proposals.whole else None
    if share is None:
        return f"{count}."
    if share < NEAR_PLANAR_SHARE:
        return tr(
            "{count}; facets are only {share:.0f} % of the exposed rock: pick traces by hand.",
            count=count,
            share=100.0 * share,
        )
    return tr(
        "{count}; facets are {share:.0f} % of the exposed rock.", count=count, share=100.0 * share
    )


def share_text(
    proposals: Proposals, open_rows: Collection[int], accepted_rows: Collection[int]
) -> str:
    """Return the shares of the exposed rock in proposed and accepted facets, as text."""
    if not proposals.whole:
        return tr(
            "This is a part of the model: how much of the exposed rock is near-planar is told of "
            "all of it."
        )
    proposed_share = proposals.share({*open_rows, *accepted_rows})
    accepted_share = proposals.share(accepted_rows)
    if proposed_share is None or accepted_share is None:
        return tr("The model shows no rock without vegetation and debris.")
    text = tr(
        "Of the exposed rock, without vegetation and debris, {proposed:.0f} % lies in facets that "
        "are proposed or accepted, {accepted:.0f} % in accepted ones (30 % recommended).",
        proposed=100.0 * proposed_share,
        accepted=100.0 * accepted_share,
    )
    if proposed_share < NEAR_PLANAR_SHARE:
        text += " " + tr("“Colours by exposure” shows where traces by hand are needed.")
    return text


def agreement_text(agreement: MutualAgreement) -> str:
    """Return how many facets and picked planes agree with each other, as text."""
    text = tr(
        "Picked planes with a facet beside them: {near} of {picked}; {found} of these agree with "
        "one.",
        near=agreement.picks_near,
        picked=agreement.picked,
        found=agreement.picks_found,
    )
    if agreement.median_angle_deg is not None:
        text += " " + tr("Median angle {angle:.1f}°.", angle=agreement.median_angle_deg)
    if agreement.proposed_near:
        text += " " + tr(
            "Facets with a pick beside them: {near} of {proposed}; {found} of these agree with "
            "one.",
            near=agreement.proposed_near,
            proposed=agreement.proposed,
            found=agreement.proposed_borne_out,
        )
    return text
