"""Fields that are generated from the declaration of options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QApplication,
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QGridLayout,
    QLabel,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.options import Options, find_declaration, option
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.geology.fold_options import FoldOptions
from vomstudio.geology.sets.proposals import parse_seeds
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.shell.work_panels import work_panels
from vomstudio.ui.widgets.options_form import OptionFields, fill_choices


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
    declared = find_declaration(FoldOptions, "quality")
    titles = [box.itemText(row) for row in range(box.count())]
    assert titles == [declared.empty, *declared.titles]
    box.setCurrentText(declared.titles[0])
    assert made.options().quality == declared.choices[0]


def test_names_of_the_project_are_added_to_the_suggestions(qtbot: Any) -> None:
    made = create_fields(qtbot, ProposalOptions)
    box, declared = made.fields["cost"], find_declaration(ProposalOptions, "cost")
    assert isinstance(box, ComboBox)
    assert [box.itemData(row) for row in range(box.count())] == list(declared.suggestions)
    fill_choices(box, declared, [("low values of height", "height")])
    box.setCurrentIndex(box.findData("height"))
    fill_choices(box, declared, [("low values of depth", "depth"), ("of height", "height")])
    assert made.options().cost == "height"
    fill_choices(box, declared)
    assert made.options().cost == declared.suggestions[0]


@dataclass(frozen=True)
class ShownInOtherUnits(Options):
    share: float = option(
        0.7, minimum=0.6, maximum=0.95, help="", label="Share", decimals=0, form_unit=("%", 100.0)
    )
    size_m: float | None = option(None, minimum=1e-9, help="", label="Size", form_unit=("mm", 1e3))
    is_closed: bool = option(False, help="", label="Closed")


def test_form_can_use_another_unit_than_the_option(qtbot: Any) -> None:
    made = create_fields(qtbot, ShownInOtherUnits)
    share, size = made.fields["share"], made.fields["size_m"]
    assert isinstance(share, QDoubleSpinBox)
    assert isinstance(size, QDoubleSpinBox)
    assert (share.text(), share.minimum(), share.maximum()) == ("70 %", 60.0, 95.0)
    assert made.options() == ShownInOtherUnits()
    share.setValue(95.0)
    made.show_value("size_m", 0.0125)
    assert size.value() == 12.5
    assert made.options() == ShownInOtherUnits(0.95, 0.0125)


@pytest.mark.parametrize("layout", [QFormLayout, QGridLayout])
@pytest.mark.parametrize("placed", [(), ("share",), ("share", "size_m")])
def test_each_field_is_in_the_form_once(qtbot: Any, layout: type, placed: tuple[str, ...]) -> None:
    made = OptionFields(ShownInOtherUnits, "made")
    page, form = QWidget(), layout()
    qtbot.addWidget(page)
    column = QVBoxLayout(page)
    if placed:
        label, row = made.place_row(*placed)
        column.addWidget(label)
        column.addLayout(row)
    if isinstance(form, QGridLayout):
        made.add_cells(form)
    else:
        made.add_rows(form)
    column.addLayout(form)
    for widget in (*made.fields.values(), *made.labels.values()):
        assert widget.window() is page


@pytest.mark.full
def test_each_field_is_in_its_panel(window: Any) -> None:
    for name, *_ in work_panels():
        window.docks.bring_forward(name)
    kinds = (QAbstractSpinBox, QCheckBox, QComboBox, QLabel, QLineEdit)
    loose = [each for each in QApplication.topLevelWidgets() if isinstance(each, kinds)]
    assert [each.objectName() for each in loose if not each.inherits("QTipLabel")] == []
