"""Dialog for the file of a figure."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.core.words import to_translate, tr
from vomstudio.ui.base.command_targets import ask_for_target
from vomstudio.ui.base.studio import Studio

_FORMATS = {
    "svg": to_translate("SVG drawing"),
    "pdf": to_translate("PDF document"),
    "png": to_translate("PNG picture, 300 dpi"),
}


def choose_figure_file(parent: QWidget, studio: Studio, title: str, stem: str) -> Path | None:
    """Ask for the file of a figure.

    Parameters
    ----------
    stem : str
        Proposed file name without extension, which follows the name of a saved project.

    Returns
    -------
    Path or None
        Path that ends in .svg, .pdf or .png, or None if the user cancels.
    """
    project = studio.project
    proposed_stem = stem if project.is_untitled else f"{project.name}-{stem}"
    formats = {suffix: tr(name) for suffix, name in _FORMATS.items()}
    return ask_for_target(parent, studio, title, f"{proposed_stem}.svg", formats)
