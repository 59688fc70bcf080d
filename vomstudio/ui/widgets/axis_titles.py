"""Titles of fields and columns with the unit of length of the project."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFormLayout, QLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.geometry.units import Axes
from vomstudio.project.records import Model
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.studio import Studio


def project_axes(studio: Studio) -> Axes:
    """Return the axes that all models of the project share.

    The axes are metric or north-aligned only if all models are. Without a model, the default
    World axes are returned.
    """
    if not studio.has_project or not studio.session.of(Model):
        return Axes()
    return Axes(studio.are_metres_known(), studio.is_north_known())


def length_unit(axes: Axes) -> str:
    """Return the unit of length for numbers and titles."""
    return "m" if axes.metric else tr("units")


def follow_axes(owner: QObject, studio: Studio, show: Callable[[Axes], object]) -> None:
    """Call `show` now and whenever the axes change, as long as the owner exists."""
    _AxesFollower(owner, studio, show).refresh()


class _AxesFollower(QObject):
    def __init__(self, owner: QObject, studio: Studio, show: Callable[[Axes], object]) -> None:
        super().__init__(owner)
        self._studio, self._show_axes = studio, show
        self._axes: Axes | None = None
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self.refresh)

    def refresh(self) -> None:
        axes = project_axes(self._studio)
        if axes != self._axes:
            self._axes = axes
            self._show_axes(axes)


def add_length_row(
    form: QFormLayout, studio: Studio, title: Callable[[str], str], field: QWidget | QLayout
) -> None:
    """Add a row whose title contains the unit."""
    label = Label()
    if isinstance(field, QWidget):
        label.setBuddy(field)
    form.addRow(label, field)
    follow_axes(label, studio, lambda axes: label.setText(title(length_unit(axes))))
