"""Texts of other parts of the program become sentences, and long lists become short."""

from __future__ import annotations

import pytest

from tests.tiers import first_in_default_tier
from vomstudio.ui.base.texts import abbreviate_names, first_sentence, format_sentence


@pytest.mark.parametrize(
    ("text", "said"),
    first_in_default_tier(
        [
            ("no photo is aligned", "No photo is aligned."),
            ("Open a model first.", "Open a model first."),
            ("“x” is not a number", "“x” is not a number."),
            ("Is it there?", "Is it there?"),
            (" Reading…", "Reading…"),
            ("éclair", "Éclair."),
            ("", ""),
        ]
    ),
)
def test_text_becomes_a_sentence_and_a_sentence_is_unchanged(text: str, said: str) -> None:
    assert format_sentence(text) == said
    assert format_sentence(said) == said


def test_long_name_lists_are_abbreviated() -> None:
    assert abbreviate_names([]) == ""
    assert abbreviate_names(["a", "b", "c"]) == "a, b, c"
    assert abbreviate_names(["a", "b", "c", "d", "e"]) == "a, b, c and 2 more"
    assert abbreviate_names(["a", "b"], max_names=1) == "a and 1 more"


def test_first_sentence_ends_at_its_full_stop() -> None:
    assert first_sentence("No model. Open one first.") == "No model."
    assert first_sentence("1.5 m is too short.") == "1.5 m is too short."
