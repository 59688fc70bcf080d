"""Fields that are generated from the declaration of options."""

from __future__ import annotations

from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QComboBox, QDoubleSpinBox, QLineEdit

from vomstudio.core.options import declarations
from vomstudio.geology.fold_options import FoldOptions
from vomstudio.geology.sets.proposals import parse_seeds
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.ui.widgets.options_form import OptionFields


def create_fields(qtbot: Any, options: type[Any]) -> OptionFields[Any]:
    made = OptionFields(options, "made")
    for widget in (*made.fields.values(), *made.labels.values()):
        qtbot.addWidget(widget)
    return made


@pytest.fixture
def fields(qtbot: Any) -> OptionFields[SetOptions]:
    return create_fields(qtbot, SetOptions)


def type_seeds(fields: OptionFields[SetOptions], text: str) -> str | None:
    field = fields.fields["seeds"]
    assert isinstance(field, QLineEdit)
    field.setText(text)
    return fields.options().seeds


def test_text_keeps_inner_spaces(fields: OptionFields[SetOptions]) -> None:
    assert type_seeds(fields, "  a path/b c ") == "a path/b c"


@pytest.mark.parametrize("text", ["", "  "])
def test_blank_text_is_the_default(fields: OptionFields[SetOptions], text: str) -> None:
    assert type_seeds(fields, text) is None


@pytest.mark.parametrize("text", ["120/45, 300/80", " 120/45 , 300/80 ", "120 / 45,300 / 80"])
def test_spaces_around_numbers_are_allowed(fields: OptionFields[SetOptions], text: str) -> None:
    assert parse_seeds(type_seeds(fields, text)) == parse_seeds("120/45,300/80")


@pytest.mark.parametrize("text", ["0.25", "0,25"])
def test_numbers_have_either_decimal_mark(qtbot: Any, text: str) -> None:
    made = create_fields(qtbot, RegisterOptions)
    field = made.fields["click_sigma_m"]
    assert isinstance(field, QDoubleSpinBox)
    field.selectAll()
    QTest.keyClicks(field, text)
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert made.options().click_sigma_m == 0.25


def test_choices_have_titles(qtbot: Any) -> None:
    made = create_fields(qtbot, FoldOptions)
    box = made.fields["quality"]
    assert isinstance(box, QComboBox)
    (declared,) = (item for item in declarations(FoldOptions) if item.name == "quality")
    titles = [box.itemText(row) for row in range(box.count())]
    assert titles == [declared.empty, *declared.titles]
    box.setCurrentText(declared.titles[0])
    assert made.options().quality == declared.choices[0]
