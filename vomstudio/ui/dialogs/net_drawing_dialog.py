"""Dialog for circles, lines, a rotation and contour levels of the net."""

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
    NetRotation,
    parse_cone,
    parse_net_plane,
    parse_plane_circle,
    parse_rotation,
    parse_slip,
)
from vomstudio.ui.base.controls import Label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.view_settings import NetViewSettings

Item = TypeVar("Item")

_FIELDS = (
    (
        "planes",
        to_translate("Great circles"),
        to_translate("Planes, such as {plane}, separated by semicolons."),
    ),
    (
        "cones",
        to_translate("Small circles"),
        to_translate("Trend/plunge/half-angle, such as 125/26/30, separated by semicolons."),
    ),
    (
        "slips",
        to_translate("Lines on planes"),
        to_translate("Dip direction/dip/rake of a line on a plane, such as 120/60/40."),
    ),
    (
        "untilt",
        to_translate("Untilt by plane"),
        to_translate("Rotate everything so that a plane becomes horizontal, such as {plane}."),
    ),
    (
        "rotate",
        to_translate("Rotate about axis"),
        to_translate("Trend/plunge/angle, right-handed about the downward end, such as 125/26/30."),
    ),
    (
        "levels",
        to_translate("Contour levels"),
        to_translate("Such as 2, 4, 8; empty for automatic levels."),
    ),
)


class NetDrawingDialog(QDialog):
    """Dialog that draws entered elements immediately, and reports invalid input."""

    def __init__(self, parent: QWidget, studio: Studio, view_settings: NetViewSettings) -> None:
        super().__init__(parent)
        set_help_topic(self, "numbers.md#the-net")
        self._studio, self._view_settings = studio, view_settings
        self.setWindowTitle(tr("Draw and rotate"))
        self.fields: dict[str, QLineEdit] = {}
        form = QFormLayout()
        example = format_plane(parse_net_plane("120/60", ""), studio.settings.notation)
        for name, title, hint in _FIELDS:
            field = QLineEdit(view_settings.texts.get(name, ""))
            field.setObjectName(f"net_{name}")
            field.setPlaceholderText(tr(hint, plane=example))
            field.setToolTip(tr(hint, plane=example))
            field.textChanged.connect(lambda _: self._apply_texts())
            # Make the whole placeholder visible.
            hint_width = field.fontMetrics().horizontalAdvance(field.placeholderText())
            field.setMinimumWidth(hint_width + 16)
            form.addRow(tr(title), field)
            self.fields[name] = field
        self.fields["levels"].setText(", ".join(f"{v:g}" for v in view_settings.levels))
        self.use_plane_button = QPushButton(tr("Use selected plane"))
        self.use_plane_button.clicked.connect(self._use_selected_plane)
        form.addRow("", self.use_plane_button)
        self.message = Label()
        self.message.setWordWrap(True)
        self.message.setObjectName("net_said")
        buttons = QDialogButtonBox()
        self.clear_button = buttons.addButton(tr("Clear"), QDialogButtonBox.ButtonRole.ResetRole)
        self.clear_button.clicked.connect(self._clear_fields)
        close_button = buttons.addButton(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.message)
        layout.addWidget(buttons)
        # Enter in a field must not press a button.
        for button in (self.clear_button, close_button, self.use_plane_button):
            button.setAutoDefault(False)
        studio.selection_changed.connect(lambda _: self._refresh_plane_button())
        self._refresh_plane_button()

    def _apply_texts(self) -> None:
        notation = self._studio.settings.notation
        texts = {name: field.text().strip() for name, field in self.fields.items()}
        try:
            planes = _parse_items(texts["planes"], lambda text: parse_plane_circle(text, notation))
            cones = _parse_items(texts["cones"], parse_cone)
            slips = _parse_items(texts["slips"], parse_slip)
            plane = parse_net_plane(texts["untilt"], "", notation) if texts["untilt"] else None
            rotation = parse_rotation(texts["rotate"]) if texts["rotate"] else (None, 0.0)
            levels = parse_levels(texts["levels"].replace(";", ",").strip(", ") or None)
        except VomError as error:
            self.message.setText(error.message)
            return
        self.message.setText("")
        circles = (*planes, *cones, *(circle for circle, _ in slips))
        marks = tuple(mark for _, mark in slips)
        if levels != self._view_settings.levels:
            self._view_settings.set_levels(levels)
        self._view_settings.set_drawings(texts, circles, marks, NetRotation(plane, *rotation))

    def _use_selected_plane(self) -> None:
        plane = self._selected_plane_text()
        if plane:
            self.fields["untilt"].setText(plane)

    def _selected_plane_text(self) -> str:
        """Return the plane of the current feature in the notation of the field, or ""."""
        current_id = self._studio.selection.current
        if current_id is None:
            return ""
        measurement = self._studio.measured([current_id]).get(current_id)
        if measurement is None or measurement.plane is None:
            return ""
        return format_plane(measurement.plane, self._studio.settings.notation, 1)

    def _refresh_plane_button(self) -> None:
        set_enabled(
            self.use_plane_button,
            None if self._selected_plane_text() else Finding("selection.no-plane"),
        )

    def _clear_fields(self) -> None:
        for field in self.fields.values():
            field.clear()


def _parse_items(text: str, parse: Callable[[str], Item]) -> tuple[Item, ...]:
    return tuple(parse(item_text.strip()) for item_text in text.split(";") if item_text.strip())
