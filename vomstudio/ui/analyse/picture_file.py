"""The dialog that asks for the file of a figure."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.ui.common.command_targets import start_folder
from vomstudio.ui.common.studio import Studio
from vomstudio.words import to_translate, tr

_FORMATS = {
    "svg": to_translate("SVG drawing (*.svg)"),
    "pdf": to_translate("PDF document (*.pdf)"),
    "png": to_translate("PNG picture, 300 dpi (*.png)"),
}


def ask_for_picture(parent: QWidget, studio: Studio, title: str, stem: str) -> Path | None:
    """A path that ends in .svg, .pdf or .png, or None. stem : proposed, behind the name of the
    project"""
    formats = {tr(pattern): suffix for suffix, pattern in _FORMATS.items()}
    project = studio.project
    proposed = stem if project.untitled else f"{project.name}-{stem}"
    name, pattern = QFileDialog.getSaveFileName(
        parent, title, str(Path(start_folder(studio)) / f"{proposed}.svg"), ";;".join(formats)
    )
    if not name:
        return None
    path = Path(name)
    if path.suffix.lower().removeprefix(".") not in _FORMATS:
        path = Path(f"{name}.{formats.get(pattern, 'svg')}")
    return path
