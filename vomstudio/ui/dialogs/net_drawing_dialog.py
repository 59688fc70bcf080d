"""The dialog in which circles, lines, a turning and levels of contours are typed for the net."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.notation import format_plane
from vomstudio.products.net.figure_options import parse_levels
from vomstudio.products.net.net_options import (
    Turning,
    parse_cone,
    parse_net_plane,
    parse_plane_circle,
    parse_rotation,
    parse_slip,
)
from vomstudio.ui.base.controls import Label, allow
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.view_settings import NetViewSettings

Made = TypeVar("Made")

_FIELDS = (
    (
        "planes",
        to_translate("Great circles"),
        to_translate("Planes, such as {plane}; several with ; between them."),
    ),
    (
        "cones",
        to_translate("Small circles"),
        to_translate("trend/plunge/half-angle, such as 125/26/30; several with ; between them."),
    ),
    (
        "slips",
        to_translate("Lines on planes"),
        to_translate("dip direction/dip/rake, such as 120/60/40: the plane and the line in it."),
    ),
    (
        "untilt",
        to_translate("Untilt by plane"),
        to_translate("All is turned so that this plane becomes horizontal, such as {plane}."),
    ),
    (
        "rotate",
        to_translate("Turn about axis"),
        to_translate("trend/plunge/angle, right-handed about the downward end, such as 125/26/30."),
    ),
    (
        "levels",
        to_translate("Levels of contours"),
        to_translate("Such as 2, 4, 8; empty for round ones."),
    ),
)


class NetTypingDialog(QDialog):
    """What is typed is drawn at once; what cannot be understood is said and changes nothing."""

    def __init__(self, parent: QWidget, studio: Studio, view_settings: NetViewSettings) -> None:
        super().__init__(parent)
        explain(self, "numbers.md#the-net")
        self._studio, self._view_settings = studio, view_settings
        self.setWindowTitle(tr("Draw and turn on the net"))
        self.fields: dict[str, QLineEdit] = {}
        form = QFormLayout()
        example = format_plane(parse_net_plane("120/60", ""), studio.settings.notation)
        for name, title, about in _FIELDS:
            field = QLineEdit(view_settings.texts.get(name, ""))
            field.setObjectName(f"net_{name}")
            field.setPlaceholderText(tr(about, plane=example))
            field.setToolTip(tr(about, plane=example))
            field.textChanged.connect(lambda _: self._typed())
            # All of what an empty field says is read.
            words = field.fontMetrics().horizontalAdvance(field.placeholderText())
            field.setMinimumWidth(words + 16)
            form.addRow(tr(title), field)
            self.fields[name] = field
        self.fields["levels"].setText(", ".join(f"{v:g}" for v in view_settings.levels))
        self.take = QPushButton(tr("Untilt by the selected plane"))
        self.take.clicked.connect(self._take)
        form.addRow("", self.take)
        self.said = Label()
        self.said.setWordWrap(True)
        self.said.setObjectName("net_said")
        buttons = QDialogButtonBox()
        self.clear = buttons.addButton(tr("Clear"), QDialogButtonBox.ButtonRole.ResetRole)
        self.clear.clicked.connect(self._clear)
        close = buttons.addButton(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.addLayout(form)
        column.addWidget(self.said)
        column.addWidget(buttons)
        # Enter ends the typing of a field, and nothing else.
        for button in (self.clear, close, self.take):
            button.setAutoDefault(False)
        studio.selection_changed.connect(lambda _: self._show_take())
        self._show_take()

    def _typed(self) -> None:
        notation = self._studio.settings.notation
        texts = {name: field.text().strip() for name, field in self.fields.items()}
        try:
            planes = _each(texts["planes"], lambda text: parse_plane_circle(text, notation))
            cones = _each(texts["cones"], parse_cone)
            slips = _each(texts["slips"], parse_slip)
            plane = parse_net_plane(texts["untilt"], "", notation) if texts["untilt"] else None
            turn = parse_rotation(texts["rotate"]) if texts["rotate"] else (None, 0.0)
            levels = parse_levels(texts["levels"].replace(";", ",").strip(", ") or None)
        except VomError as error:
            self.said.setText(error.message)
            return
        self.said.setText("")
        circles = (*planes, *cones, *(circle for circle, _ in slips))
        marks = tuple(mark for _, mark in slips)
        if levels != self._view_settings.levels:
            self._view_settings.set_levels(levels)
        self._view_settings.set_drawings(texts, circles, marks, Turning(plane, *turn))

    def _take(self) -> None:
        plane = self._selected()
        if plane:
            self.fields["untilt"].setText(plane)

    def _selected(self) -> str:
        """The plane of the current feature, as it is typed."""
        current = self._studio.selection.current
        if current is None:
            return ""
        measured = self._studio.measured([current]).get(current)
        if measured is None or measured.plane is None:
            return ""
        return format_plane(measured.plane, self._studio.settings.notation, 1)

    def _show_take(self) -> None:
        allow(self.take, None if self._selected() else Finding("selection.no-plane"))

    def _clear(self) -> None:
        for field in self.fields.values():
            field.clear()


def _each(text: str, make: Callable[[str], Made]) -> tuple[Made, ...]:
    return tuple(make(part.strip()) for part in text.split(";") if part.strip())
