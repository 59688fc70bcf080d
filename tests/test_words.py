"""Strings that users see: filled, translated, and never broken by a translation."""

from __future__ import annotations

import gettext
from collections.abc import Iterator

import pytest

from vomstudio.core.words import to_translate, tr, tr_n, use_catalogue

POINTS = "{name} has {length:.2f} m."
ONE, MANY = "{count} photo of {name}", "{count} photos of {name}"


class Catalogue(gettext.NullTranslations):
    def __init__(self, entries: dict[str, str]) -> None:
        super().__init__()
        self.entries = entries

    def gettext(self, message: str) -> str:
        return self.entries.get(message, message)

    def ngettext(self, one: str, many: str, count: int) -> str:
        # Polish: 1, then 2 to 4, then 5 and more.
        english = one if count == 1 else many
        form = "one" if count == 1 else "few" if count in (2, 3, 4) else "many"
        return self.entries.get(form, english)


@pytest.fixture(autouse=True)
def english() -> Iterator[None]:
    yield
    use_catalogue(None)


def test_untranslated_text_is_the_string_in_the_code() -> None:
    assert tr("Open") == to_translate("Open") == "Open"
    assert tr(POINTS, name="A", length=2) == "A has 2.00 m."
    assert [tr_n(ONE, MANY, n, name="B") for n in (0, 1, 2)] == [
        "0 photos of B",
        "1 photo of B",
        "2 photos of B",
    ]


def test_braces_without_values_are_unchanged() -> None:
    assert tr("A JSON object begins with {") == "A JSON object begins with {"


def test_translation_may_reorder_placeholders() -> None:
    use_catalogue(Catalogue({POINTS: "{length:.1f} m misst {name}.", "Open": "Öffnen"}))
    assert tr("Open") == "Öffnen"
    assert tr(POINTS, name="A", length=2.26) == "2.3 m misst A."
    assert tr("Save") == "Save"


def test_plural_forms_follow_the_language() -> None:
    forms = {"one": "{count} zdjęcie {name}", "few": "{count} zdjęcia {name}"}
    use_catalogue(Catalogue(forms | {"many": "{count} zdjęć {name}"}))
    said = [tr_n(ONE, MANY, n, name="C") for n in (1, 3, 5)]
    assert said == ["1 zdjęcie C", "3 zdjęcia C", "5 zdjęć C"]


@pytest.mark.parametrize(
    "broken",
    [
        "{name} hat {laenge:.2f} m.",  # another name
        "{name} hat Meter.",  # a number is lost
        "{name} hat {length:.2f} m",  # sound: shown as it is
        "{name hat {length} m.",  # a brace is missing
        "{0} hat {length} m.",
        "{name.__class__} hat {length} m.",
        "{name[0]} hat {length} m.",
        "{name:.2f} hat {length} m.",  # a format that text does not have
        "{name!z} hat {length} m.",
        "",
    ],
)
def test_a_broken_translation_falls_back_to_english(broken: str) -> None:
    use_catalogue(Catalogue({POINTS: broken}))
    sound = broken == "{name} hat {length:.2f} m"
    assert tr(POINTS, name="A", length=2) == ("A hat 2.00 m" if sound else "A has 2.00 m.")


def test_singular_form_may_omit_the_count() -> None:
    one, many = "one photo", "{count} photos"
    assert [tr_n(one, many, n) for n in (1, 4)] == ["one photo", "4 photos"]
    use_catalogue(Catalogue({"one": "ein Foto", "few": "{count} Fotos"}))
    assert [tr_n(one, many, n) for n in (1, 4)] == ["ein Foto", "4 Fotos"]
