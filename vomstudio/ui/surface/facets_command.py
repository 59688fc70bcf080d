"""The search for facets as a command that finds the same ones."""

from __future__ import annotations

from pathlib import Path

from vomstudio.document.records import Model
from vomstudio.ui.common.command_targets import start_folder
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.forms.copied_command import Word, copy_command, model_words
from vomstudio.words import tr
from vomstudio.workspace.surfaces.facet_proposals import FacetLimits


def why_no_command(limits: FacetLimits) -> str | None:
    """None where the command knows all of these limits."""
    if limits.min_coplanarity is None:
        return None
    return tr("the command knows no least coplanarity; leave it to the program")


def copy_facets(studio: Studio, model: Model | None, limits: FacetLimits) -> None:
    """Put the command on the clipboard."""
    place = None if model is None else model_words(studio, model)
    if place is None:
        return
    words: list[Word | tuple[str, Word]] = ["facets", *place, ("--angle", limits.angle_deg)]
    for name, value in (
        ("--max-distance", limits.max_distance_m),
        ("--min-area", limits.min_area_m2),
    ):
        if value is not None:
            words.append((name, value))
    if limits.min_points is not None:
        words.append(("--min-points", str(limits.min_points)))
    copy_command(studio, [*words, ("-o", Path(start_folder(studio)) / "facets.csv"), "--force"])
