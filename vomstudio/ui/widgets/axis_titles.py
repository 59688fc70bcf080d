"""Titles of fields and columns that name the unit of lengths, which the project's models decide."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QFormLayout, QLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.geometry.units import Axes
from vomstudio.project.records import Model
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.studio import Studio


def project_axes(studio: Studio) -> Axes:
    """Of all models of the project together: metres and north where all have them. Without a model
    points can only be those of World."""
    if not studio.has_project or not studio.session.of(Model):
        return Axes()
    return Axes(studio.metres_known(), studio.north_known())


def length_unit(axes: Axes) -> str:
    """As it stands behind a number or in a title."""
    return "m" if axes.metric else tr("units")


def follow_axes(studio: Studio, show: Callable[[Axes], object]) -> None:
    """Call `show`, which lasts as long as the window, now and whenever the axes have changed."""
    shown: list[Axes] = []

    def look(*_: object) -> None:
        axes = project_axes(studio)
        if shown != [axes]:
            shown[:] = [axes]
            show(axes)

    studio.project_opened.connect(look)
    studio.edited.connect(look)
    look()


def add_length_row(
    form: QFormLayout, studio: Studio, title: Callable[[str], str], field: QWidget | QLayout
) -> None:
    """A row whose title is made of the unit."""
    label = Label()
    if isinstance(field, QWidget):
        label.setBuddy(field)
    form.addRow(label, field)
    follow_axes(studio, lambda axes: label.setText(title(length_unit(axes))))
