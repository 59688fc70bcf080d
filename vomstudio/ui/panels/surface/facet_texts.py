"""User-facing texts that describe proposed facets."""

from __future__ import annotations

from collections.abc import Collection

from vomstudio.core.words import tr, tr_n
from vomstudio.extraction.exposure import MIN_NEAR_PLANAR_SHARE
from vomstudio.geology.plane_matching import MutualAgreement
from vomstudio.studio.surfaces.facet_proposals import Proposals


def summary_text(
    proposals: Proposals, open_rows: Collection[int], accepted_rows: Collection[int]
) -> str:
    """Return the number of undecided facets and the facets' share of the exposed rock."""
    count = tr_n("{count:,} proposed facet", "{count:,} proposed facets", len(open_rows))
    share = proposals.share({*open_rows, *accepted_rows}) if proposals.is_whole_model else None
    if share is None:
        return f"{count}."
    if share < MIN_NEAR_PLANAR_SHARE:
        return tr(
            "{count}; facets cover only {share:.0f} % of the exposed rock: pick traces by hand.",
            count=count,
            share=100.0 * share,
        )
    return tr(
        "{count}, covering {share:.0f} % of the exposed rock.", count=count, share=100.0 * share
    )


def share_text(
    proposals: Proposals, open_rows: Collection[int], accepted_rows: Collection[int]
) -> str:
    """Return the shares of the exposed rock in proposed and accepted facets, as text."""
    if not proposals.is_whole_model:
        return tr(
            "These facets cover only a part of the model. To get the near-planar share of the rock,"
            " choose Find on model."
        )
    proposed_share = proposals.share({*open_rows, *accepted_rows})
    accepted_share = proposals.share(accepted_rows)
    if proposed_share is None or accepted_share is None:
        return tr("The model shows only vegetation and debris, no rock.")
    text = tr(
        "Excluding vegetation and debris, {proposed:.0f} % of the exposed rock lies in proposed or"
        " accepted facets, {accepted:.0f} % in accepted ones (30 % recommended).",
        proposed=100.0 * proposed_share,
        accepted=100.0 * accepted_share,
    )
    if proposed_share < MIN_NEAR_PLANAR_SHARE:
        text += " " + tr("“Colours by exposure” shows where to pick traces by hand.")
    return text


def agreement_text(agreement: MutualAgreement) -> str:
    """Return how many facets and picked planes agree with each other, as text."""
    text = tr(
        "{near} of {picked} picked planes are near a facet; {found} of these agree with it.",
        near=agreement.picks_near,
        picked=agreement.picked,
        found=agreement.picks_found,
    )
    if agreement.median_angle_deg is not None:
        text += " " + tr("Median angle {angle:.1f}°.", angle=agreement.median_angle_deg)
    if agreement.proposed_near:
        text += " " + tr(
            "{near} of {proposed} facets are near a pick; {found} of these agree with it.",
            near=agreement.proposed_near,
            proposed=agreement.proposed,
            found=agreement.proposed_borne_out,
        )
    return text
