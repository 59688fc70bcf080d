"""Command line that finds the same facets."""

from __future__ import annotations

from vomstudio.core.options import option_words
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.project.records import Model
from vomstudio.ui.base.command_targets import results_folder
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.copied_command import copy_command, find_model_arguments


def copy_facets(studio: Studio, model: Model | None, options: FacetOptions) -> None:
    """Copy the command that finds the facets to the clipboard."""
    model_arguments = None if model is None else find_model_arguments(studio, model)
    if model_arguments is not None:
        target = results_folder(studio) / "facets.csv"
        arguments = ["facets", *model_arguments, *option_words(options), ("-o", target), "--force"]
        copy_command(studio, arguments)
