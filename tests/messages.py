"""Sentences and codes of the findings in an answer, for tests."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from vomstudio.core.finding_texts import TEXTS, texts_of
from vomstudio.core.findings import as_finding


def messages(answer: Mapping[str, Any]) -> list[str]:
    """Return the sentences of an answer's warnings, from ``--json`` or from Python."""
    return [
        each["message"] if isinstance(each, dict) else as_finding(each).message
        for each in answer["warnings"]
    ]


def codes(answer: Mapping[str, Any]) -> list[str]:
    """Return the codes of an answer's warnings, from ``--json`` or from Python."""
    return [
        each["code"] if isinstance(each, dict) else as_finding(each).code
        for each in answer["warnings"]
    ]


def shown_codes(text: str) -> set[str]:
    """Return the codes of the findings that a text, such as that of a window, contains."""
    return {
        code
        for code in TEXTS.keys() - {"uncoded"}
        if any(re.search(_pattern(sentence), text, re.DOTALL) for sentence in texts_of(code))
    }


def _pattern(sentence: str) -> str:
    return re.sub(r"\\\{.*?\\\}", ".+?", re.escape(sentence))
