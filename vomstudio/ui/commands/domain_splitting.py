"""Assignment of features to the domains on both sides of the selected plane."""

from __future__ import annotations

from vomstudio.core.findings import Finding
from vomstudio.project.domains import split_by_plane
from vomstudio.project.edit import Edit
from vomstudio.project.records import TypedFeature, get
from vomstudio.ui.base.studio import Studio


def disabled_reason(studio: Studio) -> Finding | None:
    """Return why the selection cannot split domains, or None if it is a single plane."""
    current_id = studio.selection.current if studio.has_project else None
    if (
        len(studio.selection.ids) == 1
        and (feature := get(studio.records, current_id, TypedFeature)) is not None
        and studio.measured([feature.id])[feature.id].plane is not None
    ):
        return None
    return Finding("selection.no-plane")


def split_domains(studio: Studio) -> None:
    """Assign features to domains in one edit and report how many of them cross the plane."""
    current_id = studio.selection.current
    if current_id is None:
        return
    crossing_count = 0

    def create_edit(records: object) -> Edit:
        nonlocal crossing_count
        edit, crossing_count = split_by_plane(studio.records, current_id, studio.measured)
        return edit

    if studio.attempt(create_edit) and crossing_count:
        studio.info(Finding("domain.on-both-sides", count=crossing_count))
