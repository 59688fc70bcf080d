"""The search for facets as a command that finds the same ones."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.options import option_words
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.project.records import Model
from vomstudio.ui.base.command_targets import start_folder
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.copied_command import copy_command, find_model_arguments


def copy_facets(studio: Studio, model: Model | None, options: FacetOptions) -> None:
    """Put the command on the clipboard."""
    place = None if model is None else find_model_arguments(studio, model)
    if place is not None:
        target = Path(start_folder(studio)) / "facets.csv"
        words = ["facets", *place, *option_words(options), ("-o", target), "--force"]
        copy_command(studio, words)
