"""Sentences and codes of the findings in an answer, for tests."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from vomstudio.core.finding_texts import TEXTS
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
    found = set()
    for code, (_, sentence) in TEXTS.items():
        pattern = re.sub(r"\\\{.*?\\\}", ".+?", re.escape(sentence))
        if code != "uncoded" and re.search(pattern, text, re.DOTALL):
            found.add(code)
    return found
