"""Fields that are generated from the declaration of options."""

from __future__ import annotations

from typing import Any

import pytest
from PySide6.QtWidgets import QLineEdit

from vomstudio.geology.sets.proposals import parse_seeds
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.ui.widgets.options_form import OptionFields


@pytest.fixture
def fields(qtbot: Any) -> OptionFields[SetOptions]:
    made = OptionFields(SetOptions, "sets")
    for widget in (*made.fields.values(), *made.labels.values()):
        qtbot.addWidget(widget)
    return made


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
