"""Sentences and codes of the findings in an answer, for tests."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from vomstudio.core.errors import InputError, VomError, VomWarning
from vomstudio.core.finding_texts import TEXTS, get_texts
from vomstudio.core.findings import Finding


@contextmanager
def refused(
    code: str, kind: type[VomError] = InputError, /, **values: Any
) -> Iterator[pytest.ExceptionInfo[VomError]]:
    """Expect an error with a code and some of its values, such as ``column="dip"``.

    The values may include the location of the cause: ``file``, ``line`` and ``field``.
    """
    with pytest.raises(kind) as error:
        yield error
    answer = error.value.to_dict()
    expected = {name: _in_json(x) for name, x in values.items()}
    assert (answer["code"], {name: answer.get(name) for name in expected}) == (code, expected), str(
        error.value
    )


@contextmanager
def warned(code: str, /, **values: Any) -> Iterator[None]:
    """Expect a Python warning with a code and some of its values."""
    with pytest.warns(VomWarning) as record:
        yield
    found = [each.message for each in record if isinstance(each.message, VomWarning)]
    assert any(
        (each.code, values) == (code, {name: each.values.get(name) for name in values})
        for each in found
    ), [(each.code, each.values) for each in found]


def _in_json(value: Any) -> Any:
    if isinstance(value, tuple):
        return list(value)
    return str(value) if isinstance(value, Path) else value


def messages(answer: Mapping[str, Any]) -> list[str]:
    """Return the sentences of an answer's warnings, from ``--json`` or from Python."""
    return [
        each["message"] if isinstance(each, dict) else each.message for each in answer["warnings"]
    ]


def codes(answer: Mapping[str, Any]) -> list[str]:
    """Return the codes of an answer's warnings, from ``--json`` or from Python."""
    return [each["code"] if isinstance(each, dict) else each.code for each in answer["warnings"]]


def with_code(findings: Iterable[Any], code: str) -> list[Finding]:
    """Return the findings with a code, from ``--json`` or from Python."""
    return [each for each in map(_finding, findings) if each.code == code]


def by_code(findings: Iterable[Any]) -> dict[str, dict[str, Any]]:
    """Return the values of findings by their codes; of a code that occurs twice the last."""
    return {each.code: each.values for each in map(_finding, findings)}


def _finding(each: Any) -> Finding:
    return Finding.from_dict(each) if isinstance(each, dict) else each


def error_of(answer: Mapping[str, Any], code: str, /, **values: Any) -> dict[str, Any]:
    """Return the error of an answer of ``--json``, of which code and some values are compared."""
    error: dict[str, Any] = answer["error"]
    expected = {"code": code} | {name: _in_json(value) for name, value in values.items()}
    assert {name: error.get(name) for name in expected} == expected, error["message"]
    return error


def shown_codes(text: str) -> set[str]:
    """Return the codes of the findings that a text, such as that of a window, contains.

    A text that consists of values, such as that of ``uncoded``, would be in every text.
    """
    return {
        code
        for code in TEXTS
        if any(
            pattern and re.search(pattern, text, re.MULTILINE)
            for pattern in map(_pattern, get_texts(code))
        )
    }


def shown_values(text: str, code: str) -> dict[str, str]:
    """Return the values, as they are shown, of a finding that a text contains."""
    for sentence in get_texts(code):
        if match := re.search(_pattern(sentence), text, re.MULTILINE):
            return match.groupdict()
    raise AssertionError(f"{code} is not in {text!r}")


def figures(text: str) -> list[float]:
    """Return the numbers in a text, such as that of a label, without their signs.

    Digits in names, such as those of B01, are not numbers.
    """
    found = re.findall(r"(?<![\w.])(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d+)?", text)
    return [float(each.replace(",", "")) for each in found]


@cache
def _pattern(sentence: str) -> str:
    """Return a pattern of one line with a text, "" if the text has no words of its own.

    Counts are digits, values with a format have no spaces, others are anything, and at the end of
    the text also nothing.
    """
    if not re.search(r"[a-z]{2}", re.sub(r"\{.*?\}", "", sentence)):
        return ""
    names: set[str] = set()

    def group(match: re.Match[str]) -> str:
        name, has_format = match[1], match[2].startswith(":")
        value = r"\d[\d,]*" if name == "count" else r"\S+?" if has_format else ".+?"
        is_first = name not in names
        names.add(name)
        return f"(?P<{name}>{value})" if is_first else value

    # The point after "1.5" ends a sentence, that within it does not.
    pattern = re.sub(r"\\\{(\w+)(.*?)\\\}", group, re.escape(sentence))
    # A value at the end may be empty.
    pattern = re.sub(r"\\ \(\?P<(\w+)>\.\+\?\)$", r"(?: (?P<\1>.+))?$", pattern)
    return pattern + r"(?!\d)"
