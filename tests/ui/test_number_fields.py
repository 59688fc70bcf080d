"""Number fields: what is typed is read in full, or the last number stays with a reason."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QLocale, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolTip

from vomstudio.ui.base.controls import DoubleSpinBox, SpinBox
from vomstudio.ui.base.numbers import is_partial_quantity, parse_numbers, parse_quantity

REFUSED = ("-1e999", "-3", "1e9", "nan", "abc", "30 kg", "1..5", "400/95 ± ∞", "9" * 500)


@pytest.fixture(params=["de_DE", "en_US", "C"])
def language(request):
    before = QLocale()
    QLocale.setDefault(QLocale(request.param))
    yield
    QLocale.setDefault(before)


def show(qtbot, field, suffix: str = " m"):
    qtbot.addWidget(field)
    field.setRange(0, 2000)
    field.setSuffix(suffix)
    field.setValue(7)
    field.setKeyboardTracking(False)
    field.show()
    return field


def enter(field, text: str) -> float:
    line = field.lineEdit()
    line.selectAll()
    QTest.keyClick(line, Qt.Key.Key_Delete)
    # QTest has no keys for letters beyond ASCII.
    QTest.keyClicks(line, text) if text.isascii() else line.insert(text)
    QTest.keyClick(line, Qt.Key.Key_Return)
    return field.value()


@pytest.mark.usefixtures("language")
@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.5", 1.5),
        ("1,5", 1.5),
        ("1,234.5", 1234.5),
        ("1.234,5", 1234.5),
        ("1e3", 1000.0),
        ("30 cm", 0.3),
        ("30cm", 0.3),
        ("3 m", 3.0),
        ("0,5km", 500.0),
    ],
)
def test_numbers_accept_either_decimal_mark_and_units(qtbot, text, value) -> None:
    field = show(qtbot, DoubleSpinBox())
    assert enter(field, text) == value
    assert field.text() == f"{value:.2f} m"


@pytest.mark.usefixtures("language")
@pytest.mark.parametrize("kind", [SpinBox, DoubleSpinBox])
@pytest.mark.parametrize("text", REFUSED)
def test_invalid_input_keeps_the_last_number_and_shows_the_limits(qtbot, kind, text) -> None:
    field = show(qtbot, kind())
    assert enter(field, text) == 7
    assert field.hasAcceptableInput()
    assert "0 m" in QToolTip.text()
    assert "2000 m" in QToolTip.text()
    QToolTip.hideText()


def test_integers_have_no_decimals(qtbot) -> None:
    field = show(qtbot, SpinBox(), " %")
    assert enter(field, "1.5") == 7
    assert enter(field, "1,5") == 7
    assert enter(field, "12") == 12
    assert enter(field, "13 %") == 13
    QToolTip.hideText()


@pytest.mark.parametrize("kind", [SpinBox, DoubleSpinBox])
def test_an_automatic_number_can_be_typed_again(qtbot, kind) -> None:
    field = show(qtbot, kind())
    field.setSpecialValueText("auto")
    assert enter(field, "auto") == 0
    assert field.text() == "auto"
    field.stepUp()
    assert field.value() == 1
    field.stepDown()
    assert field.text() == "auto"
    assert field.hasAcceptableInput()
    assert enter(field, "3") == 3


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("30", "", 30.0),
        ("30 cm", "mm", 300.0),
        ("30 ft", "ft", 30.0),
        ("30 ft", "m", None),
        ("12,5°", "°", 12.5),
        ("30 cm", "°", None),
        ("30 cm", "", None),
        ("cm", "m", None),
        ("", "m", None),
    ],
)
def test_quantities_are_converted_to_the_unit_of_the_field(text, unit, value) -> None:
    assert parse_quantity(text, unit) == (None if value is None else pytest.approx(value))


@pytest.mark.parametrize(
    ("text", "unit", "is_partial"),
    [
        ("30 c", "m", True),
        ("0,5k", "m", True),
        ("30 cm", "m", True),
        ("30 t", "m", False),
        ("30 c", "°", False),
        ("c", "m", False),
        ("", "m", False),
    ],
)
def test_unit_letters_are_accepted_only_after_a_number(text, unit, is_partial) -> None:
    assert is_partial_quantity(text, unit) == is_partial


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1,2,3", [1, 2, 3]),
        ("1, 2, 3", [1, 2, 3]),
        ("1.5,2.5", [1.5, 2.5]),
        ("1,5; 2,5", [1.5, 2.5]),
        ("1,5 2", [1.5, 2]),
        ("1,5, 2,5", [1.5, 2.5]),
        ("1 2\n3", [1, 2, 3]),
        ("", []),
        ("1, x", None),
        ("1;;2", None),
    ],
)
def test_a_decimal_comma_never_separates_two_numbers(text, values) -> None:
    assert parse_numbers(text) == values
