"""The line that filters features: words, and conditions on their figures such as `dip>30`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from vomstudio.errors import UsageError
from vomstudio.ui.common.wording import orientation_text
from vomstudio.ui.interpret.feature_row import Row

HELP = (
    "Words of any column, and conditions; all of them must hold:\n"
    "  dip>30   dip:20..45   dipdir:350..20   extent<50cm   95<=5\n"
    "  type:joint   type=joint|fault   set:limb   quality:good   overturned:yes\n"
    '  -type:bedding or -word leaves out; quotes keep blanks: set:"west limb"\n'
    "Words: name type set kind quality reasons notes overturned (: contains, = is)\n"
    "Figures: dip dipdir strike trend plunge rake 95 95min dip_error dipdir_error M K\n"
    "coplanarity collinearity n extent area resolution rms"
)


@dataclass(frozen=True)
class _Field:
    kind: Literal["text", "number", "angle", "flag"]
    value: Callable[[Row], Any]


def _fit(name: str) -> Callable[[Row], Any]:
    return lambda r: r.fit(name)


_TEXTS: dict[str, Callable[[Row], Any]] = {
    "name": lambda r: r.feature.name,
    "type": lambda r: r.type_name,
    "set": lambda r: r.set_name,
    "kind": lambda r: r.class_name,
    "quality": lambda r: r.quality or "",
    "reasons": lambda r: r.reasons,
    "notes": lambda r: r.feature.notes,
}
_NUMBERS: dict[str, Callable[[Row], Any]] = {
    "dip": lambda r: r.dip,
    "plunge": lambda r: r.plunge,
    "rake": lambda r: r.rake,
    "95": lambda r: r.measured.max_confidence95_deg,
    "95min": lambda r: r.measured.min_confidence95_deg,
    "dip_error": _fit("dip_error_deg"),
    "dipdir_error": _fit("dip_direction_error_deg"),
    "m": _fit("M"),
    "k": _fit("K"),
    "coplanarity": _fit("coplanarity"),
    "collinearity": _fit("collinearity"),
    "n": _fit("n"),
    "extent": _fit("extent"),
    "area": lambda r: r.measured.area_m2,
    "resolution": lambda r: r.ratio,
    "rms": _fit("rms"),
}
_ANGLES: dict[str, Callable[[Row], Any]] = {
    "dipdir": lambda r: r.dip_direction,
    "strike": lambda r: r.strike,
    "trend": lambda r: r.trend,
}
_FIELDS: dict[str, _Field] = {
    **{name: _Field("text", value) for name, value in _TEXTS.items()},
    **{name: _Field("number", value) for name, value in _NUMBERS.items()},
    **{name: _Field("angle", value) for name, value in _ANGLES.items()},
    "overturned": _Field("flag", lambda r: bool(r.overturned)),
}
_OTHER_NAMES = {"95max": "95", "error": "95", "dd": "dipdir", "azimuth": "dipdir", "note": "notes",
                "ext/res": "resolution", "ratio": "resolution", "verdict": "quality",
                "class": "kind"}  # fmt: skip

_METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "km": 1000.0}
_SQUARE = {"cm2": 1e-4, "cm²": 1e-4, "m2": 1.0, "m²": 1.0, "km2": 1e6, "km²": 1e6}
_TOKEN = re.compile(r'(?:[^\s"]|"[^"]*"?)+')
_CONDITION = re.compile(r"(?P<key>[\w/]+)(?P<op><=|>=|!=|[:=<>])(?P<value>.*)", re.DOTALL)
_NUMBER = re.compile(r"(?P<number>[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+))\s*(?P<unit>[^\d\s]*)")

Test = Callable[[Row], bool]


def parse_filter(text: str) -> Test:
    """The test that a row has to pass. Raises UsageError with a sentence about what cannot be
    read."""
    tests = [_test(token) for token in _TOKEN.findall(text)]
    return lambda row: all(test(row) for test in tests)


def _test(token: str) -> Test:
    if token.startswith("-") and len(token) > 1 and not token[1].isdigit():
        inner = _test(token[1:])
        return lambda row: not inner(row)
    condition = None if token.startswith('"') else _CONDITION.fullmatch(token)
    if condition is None:
        word = token.replace('"', "").casefold()
        return lambda row: word in _everything(row)
    key = condition["key"].casefold()
    key = _OTHER_NAMES.get(key, key)
    field = _FIELDS.get(key)
    if field is None:
        near = difflib.get_close_matches(key, _FIELDS, 1, 0.4)
        meant = f"did you mean {near[0]}? " if near else ""
        raise UsageError(
            f"There is no “{condition['key']}” to filter by: {meant}The names are in the tip of "
            "this line; words with : stand in quotes."
        )
    op, value = condition["op"], condition["value"].replace('"', "").strip()
    if not value:
        raise UsageError(f"“{token}” is not finished: {_wanted(key, field)}.")
    if field.kind == "text":
        return _text_test(token, field, op, value)
    if field.kind == "flag":
        return _flag_test(token, field, op, value)
    return _number_test(token, key, field, op, value)


def _wanted(key: str, field: _Field) -> str:
    if field.kind == "text":
        return f"a word is wanted, such as {key}:{'joint' if key == 'type' else 'word'}"
    if field.kind == "flag":
        return f"yes or no is wanted, such as {key}:yes"
    return f"a number is wanted, such as {key}>30 or {key}:20..45"


def _text_test(token: str, field: _Field, op: str, value: str) -> Test:
    wanted = [part for part in value.casefold().split("|") if part]
    if op == ":":
        return lambda row: any(w in field.value(row).casefold() for w in wanted)
    if op == "=":
        return lambda row: field.value(row).casefold() in wanted
    if op == "!=":
        return lambda row: field.value(row).casefold() not in wanted
    raise UsageError(f"“{token}”: words have no order; write : (contains) or = (is).")


def _flag_test(token: str, field: _Field, op: str, value: str) -> Test:
    answers = {"yes": True, "true": True, "1": True, "no": False, "false": False, "0": False}
    if value.casefold() not in answers or op not in (":", "=", "!="):
        raise UsageError(f"“{token}”: write overturned:yes or overturned:no.")
    wanted = answers[value.casefold()] != (op == "!=")
    return lambda row: field.value(row) == wanted


def _number_test(token: str, key: str, field: _Field, op: str, value: str) -> Test:
    low, dots, high = value.partition("..")
    if dots:
        if op not in (":", "=", "!="):
            raise UsageError(f"“{token}”: a range is written {key}:20..45.")
        a, b = _number(token, key, field, low), _number(token, key, field, high)

        def within(x: float) -> bool:
            if field.kind == "angle" and a > b:
                # Across North.
                return x >= a or x <= b
            return a <= x <= b

        return _defined(field, (lambda x: not within(x)) if op == "!=" else within)
    n = _number(token, key, field, value)
    # What is written with so many decimals is meant to so many.
    _, _, decimals = value.replace(",", ".").partition(".")
    close = 0.5 * 10.0 ** -len(re.match(r"\d*", decimals)[0])  # type: ignore[index]
    compare: dict[str, Callable[[float], bool]] = {
        "<": lambda x: x < n,
        "<=": lambda x: x <= n,
        ">": lambda x: x > n,
        ">=": lambda x: x >= n,
        ":": lambda x: abs(x - n) <= close,
        "=": lambda x: abs(x - n) <= close,
        "!=": lambda x: abs(x - n) > close,
    }
    return _defined(field, compare[op])


def _defined(field: _Field, compare: Callable[[float], bool]) -> Test:
    """What is undefined fulfils no condition."""

    def test(row: Row) -> bool:
        value = field.value(row)
        return value is not None and compare(float(value))

    return test


def _number(token: str, key: str, field: _Field, text: str) -> float:
    found = _NUMBER.fullmatch(text.strip())
    units = _METRES if key in ("extent", "rms") else _SQUARE if key == "area" else {"°": 1.0}
    if found is None or (found["unit"] and found["unit"].casefold() not in units):
        raise UsageError(f"“{token}” cannot be read: {_wanted(key, field)}.")
    scale = units[found["unit"].casefold()] if found["unit"] else 1.0
    return float(found["number"].replace(",", ".")) * scale


def _everything(row: Row) -> str:
    """All that a row says in words, for words of no particular column."""
    return "\n".join(
        (
            row.feature.name,
            row.type_name,
            row.set_name,
            row.class_name,
            row.quality or "",
            row.reasons,
            row.feature.notes,
            "overturned" if row.overturned else "",
            orientation_text(row.measured, row.notation),
        )
    ).casefold()
