"""Fields for the options of an operation, generated from their declaration."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Generic, TypeVar

from PySide6.QtCore import QObject, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QDoubleSpinBox,
    QFormLayout,
    QGridLayout,
    QHBoxLayout,
    QLineEdit,
    QSizePolicy,
    QSpinBox,
    QWidget,
)

from vomstudio.core.options import UNITS, Declaration, declarations
from vomstudio.core.words import tr
from vomstudio.ui.base.controls import ComboBox, DoubleSpinBox, Label, SpinBox

Options = TypeVar("Options")

_MIN_CELL_WIDTH_PX = 50
MAX_SHOWN = 1e6
"""Maximum value of a field whose option has no upper bound."""


class OptionFields(QObject, Generic[Options]):
    """Form fields for an options class, without a layout.

    An option without a label has no field and keeps its value from `start`. If the program may
    choose a number, its field shows a text such as "auto" at the minimum. `add_rows` arranges all
    fields except those that the form has arranged itself with `place`.

    Parameters
    ----------
    options : type
        An options class (`vomstudio.core.options`).
    prefix : str
        Prefix of the object names: ``facet`` results in ``facet_angle``.
    start : options object, optional
        Initial values. By default, the defaults of the options class are used.
    is_live : bool
        Whether a number takes effect while it is typed, instead of when it is complete.

    Attributes
    ----------
    fields : dict of str to QWidget
        Field of each option, keyed by the name of the option.
    labels : dict of str to Label
        Label of each field, keyed by the name of the option. Check boxes and fields arranged with
        `place` have no label.
    changed : Signal
        Emitted when the value of a field changes.
    """

    changed = Signal()

    def __init__(
        self,
        options: type[Options],
        prefix: str,
        start: Options | None = None,
        *,
        is_live: bool = False,
    ) -> None:
        super().__init__()
        self._is_live = is_live
        self._options_class = options
        self._start = options() if start is None else start
        self._declarations = {item.name: item for item in declarations(options) if item.label}
        self._placed_names: set[str] = set()
        self.fields: dict[str, QWidget] = {}
        self.labels: dict[str, Label] = {}
        for name, item in self._declarations.items():
            field = self._create(item)
            field.setObjectName(f"{prefix}_{item.flag.removeprefix('--').replace('-', '_')}")
            field.setAccessibleName(tr(item.label))
            field.setToolTip(_tip(item))
            self.fields[name] = field
            if item.kind is not bool:
                self.labels[name] = Label(tr(item.label))
        self.show_unit("m")
        self.reset()

    def reset(self) -> None:
        """Show the initial values."""
        for name in self.fields:
            self.show_value(name, getattr(self._start, name))

    def show_value(self, name: str, value: Any) -> None:
        """Set the value of a field."""
        field = self.fields[name]
        if isinstance(field, QCheckBox):
            field.setChecked(bool(value))
        elif isinstance(field, ComboBox):
            field.setCurrentIndex(max(0, field.findData(value)))
        elif isinstance(field, QLineEdit):
            field.setText(value or "")
        elif isinstance(field, QSpinBox | QDoubleSpinBox):
            number = field.minimum() if value is None else value * self._scale(name)
            if isinstance(field, QSpinBox):
                field.setValue(round(number))
            else:
                field.setValue(number)

    def show_automatic(self, name: str, value: float) -> None:
        """Show the number chosen by the program in a field that has no value."""
        field = self.fields[name]
        assert isinstance(field, QSpinBox | QDoubleSpinBox)
        field.setSpecialValueText(f"{value * self._scale(name):.3g}{field.suffix()}")
        if isinstance(field, DoubleSpinBox):
            field.automatic_value = value * self._scale(name)

    def place(self, name: str) -> QWidget:
        """Return a field that the form arranges itself, without a label."""
        self._placed_names.add(name)
        self.labels.pop(name, None)
        return self.fields[name]

    def place_row(self, *names: str) -> tuple[Label, QHBoxLayout]:
        """Return the label of the first field, and a row of all fields with the other labels."""
        row = QHBoxLayout()
        row.setSpacing(4)
        for k, name in enumerate(names):
            self.labels[name].setBuddy(self.fields[name])
            if k:
                row.addWidget(self.labels[name])
            self.fields[name].setMinimumWidth(_MIN_CELL_WIDTH_PX)
            row.addWidget(self.fields[name], 1)
        self._placed_names.update(names)
        return self.labels[names[0]], row

    def add_rows(self, form: QFormLayout) -> None:
        """Add a row for each field that the form has not arranged itself."""
        for name, field in self.fields.items():
            if name in self._placed_names:
                continue
            self._placed_names.add(name)
            if (label := self.labels.get(name)) is None:
                form.addRow(field)
            else:
                label.setBuddy(field)
                form.addRow(label, field)

    def add_cells(self, grid: QGridLayout, first_row: int = 0) -> None:
        """Add the fields that the form has not arranged itself to a grid, two in a row."""
        names = [name for name in self.fields if name not in self._placed_names]
        for k, name in enumerate(names):
            field = self.fields[name]
            row, column = first_row + k // 2, 2 * (k % 2)
            if (label := self.labels.get(name)) is None:
                grid.addWidget(field, row, column, 1, 2)
            else:
                label.setBuddy(field)
                grid.addWidget(label, row, column)
                grid.addWidget(field, row, column + 1)
            # The columns have equal widths, since a distance is as wide as an angle.
            field.setMinimumWidth(_MIN_CELL_WIDTH_PX)
            field.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self._placed_names.update(names)

    def options(self, **others: Any) -> Options:
        """Return the options with the values of the fields.

        Parameters
        ----------
        **others
            Values that replace those of the fields, and values of options without a field.

        Raises
        ------
        UsageError
            If options exclude each other.
        """
        values = {
            item.name: getattr(self._start, item.name) for item in declarations(self._options_class)
        }
        return self._options_class(
            **values | {name: self.value(name) for name in self.fields} | others
        )

    def value(self, name: str) -> Any:
        """Return the value of one field, in the unit of the option."""
        field, declaration = self.fields[name], self._declarations[name]
        if isinstance(field, QCheckBox):
            return field.isChecked()
        if isinstance(field, ComboBox):
            return field.currentData()
        if isinstance(field, QLineEdit):
            return field.text().strip() or None
        assert isinstance(field, QSpinBox | QDoubleSpinBox)
        shown_number = _shown_number(field)
        if _is_automatic(declaration) and shown_number == field.minimum():
            return None
        value = declaration.kind(shown_number / self._scale(name))
        return (
            value
            if declaration.minimum is None
            else max(value, declaration.kind(declaration.minimum))
        )

    def show_unit(self, unit: str) -> None:
        """Set the unit of length, such as m, that is shown for lengths and areas."""
        for name, field in self.fields.items():
            declaration = self._declarations[name]
            symbol = UNITS.get(declaration.unit or "", "")
            if declaration.form_unit is not None:
                symbol = declaration.form_unit[0]
            elif symbol in ("m", "m²"):
                symbol = symbol.replace("m", unit, 1)
            if isinstance(field, QDoubleSpinBox | QSpinBox):
                field.setSuffix(symbol if symbol in ("", "°") else f" {symbol}")

    def _create(self, declaration: Declaration) -> QWidget:
        if declaration.kind is bool:
            box = QCheckBox(tr(declaration.label))
            box.toggled.connect(lambda _: self.changed.emit())
            return box
        if declaration.choices is not None or declaration.suggestions:
            choice = ComboBox()
            choice.keep_narrow()
            fill_choices(choice, declaration)
            choice.activated.connect(lambda _: self.changed.emit())
            return choice
        if declaration.kind is str:
            line = QLineEdit()
            line.setPlaceholderText(tr(declaration.empty))
            line.textChanged.connect(lambda _: self.changed.emit())
            return line
        spin = SpinBox() if declaration.kind is int else DoubleSpinBox()
        scale = self._scale(declaration.name)
        low = 0 if _is_automatic(declaration) else declaration.kind(declaration.minimum or 0)
        high = declaration.kind(min(declaration.maximum or MAX_SHOWN, 2**31 - 1))
        if isinstance(spin, DoubleSpinBox):
            spin.setDecimals(declaration.decimals)
            if declaration.decimals:
                spin.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        if isinstance(spin, DoubleSpinBox):
            spin.setRange(low * scale, high * scale)
        else:
            spin.setRange(round(low * scale), round(high * scale))
        spin.setKeyboardTracking(self._is_live)
        if _is_automatic(declaration) or _is_automatic_at_minimum(declaration):
            spin.setSpecialValueText(tr(declaration.empty))
        spin.valueChanged.connect(lambda _: self.changed.emit())
        return spin

    def _scale(self, name: str) -> float:
        """Return the factor from the unit of an option to the unit of its field."""
        form_unit = self._declarations[name].form_unit
        return 1 if form_unit is None else form_unit[1]


def fill_choices(
    box: ComboBox, declaration: Declaration, others: Iterable[tuple[str, str]] = ()
) -> None:
    """Fill a combo box with the choices or suggestions of an option, and keep its selection.

    Parameters
    ----------
    others : iterable of (str, str)
        Titles and values of further entries, such as names in the project.
    """
    selected_value = box.currentData()
    values = declaration.choices or declaration.suggestions
    with QSignalBlocker(box):
        box.clear()
        if _is_automatic(declaration) and declaration.empty:
            box.addItem(tr(declaration.empty), None)
        first_row = box.count()
        for value, title in zip(values, declaration.titles or values, strict=True):
            box.addItem(tr(title), value)
        for row, tip in enumerate(declaration.choice_tips, first_row):
            box.setItemData(row, tr(tip), Qt.ItemDataRole.ToolTipRole)
        for title, value in others:
            box.addItem(title, value)
        box.setCurrentIndex(max(0, box.findData(selected_value)))


def _shown_number(field: QSpinBox | QDoubleSpinBox) -> float:
    """Return the number in a field, including text that is not yet committed."""
    text = field.text()
    if text == field.specialValueText() or not field.hasAcceptableInput():
        return field.value()
    return field.valueFromText(text)


def _is_automatic(declaration: Declaration) -> bool:
    """Return whether the program may choose the value."""
    return declaration.default is None and not declaration.is_required


def _is_automatic_at_minimum(declaration: Declaration) -> bool:
    """Return whether the program chooses the value if the option has its minimum, such as 0."""
    return bool(declaration.automatic) and declaration.default == declaration.minimum is not None


def _tip(declaration: Declaration) -> str:
    is_automatic = _is_automatic(declaration) or _is_automatic_at_minimum(declaration)
    if declaration.automatic and is_automatic:
        return tr(
            "{tip} ({empty}: {automatic}).",
            tip=tr(declaration.tip),
            empty=tr(declaration.empty),
            automatic=tr(declaration.automatic),
        )
    return f"{tr(declaration.tip)}."
