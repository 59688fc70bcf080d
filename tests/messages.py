"""Sentences and codes of the findings in an answer, for tests."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from vomstudio.core.finding_texts import TEXTS, texts_of
from vomstudio.core.findings import Finding, as_finding
from vomstudio.errors import InputError, VomError, VomWarning


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
        each["message"] if isinstance(each, dict) else as_finding(each).message
        for each in answer["warnings"]
    ]


def codes(answer: Mapping[str, Any]) -> list[str]:
    """Return the codes of an answer's warnings, from ``--json`` or from Python."""
    return [
        each["code"] if isinstance(each, dict) else as_finding(each).code
        for each in answer["warnings"]
    ]


def with_code(findings: Iterable[Any], code: str) -> list[Finding]:
    """Return the findings with a code, from ``--json`` or from Python."""
    return [each for each in map(_finding, findings) if each.code == code]


def by_code(findings: Iterable[Any]) -> dict[str, dict[str, Any]]:
    """Return the values of findings by their codes; of a code that occurs twice the last."""
    return {each.code: each.values for each in map(_finding, findings)}


def _finding(each: Any) -> Finding:
    return Finding.from_dict(each) if isinstance(each, dict) else as_finding(each)


def shown_codes(text: str) -> set[str]:
    """Return the codes of the findings that a text, such as that of a window, contains."""
    return {
        code
        for code in TEXTS.keys() - {"uncoded"}
        if any(re.search(_pattern(sentence), text, re.DOTALL) for sentence in texts_of(code))
    }


def shown_values(text: str, code: str) -> dict[str, str]:
    """Return the values, as they are shown, of a finding that a text contains."""
    for sentence in texts_of(code):
        if match := re.search(_pattern(sentence), text, re.DOTALL):
            return match.groupdict()
    raise AssertionError(f"{code} is not in {text!r}")


def figures(text: str) -> list[float]:
    """Return the numbers in a text, such as that of a label, without their signs."""
    return [float(each.replace(",", "")) for each in re.findall(r"\d[\d,]*(?:\.\d+)?", text)]


def _pattern(sentence: str) -> str:
    """Return a pattern of a text whose values may be anything, and at the end nothing."""
    names: set[str] = set()

    def group(match: re.Match[str]) -> str:
        is_first = match[1] not in names
        names.add(match[1])
        return f"(?P<{match[1]}>.+?)" if is_first else ".+?"

    pattern = re.sub(r"\\\{(\w+).*?\\\}", group, re.escape(sentence))
    # A value at the end may be empty.
    return re.sub(r"\\ \(\?P<(\w+)>\.\+\?\)$", r"(?: (?P<\1>.+))?$", pattern)
