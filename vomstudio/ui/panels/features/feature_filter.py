"""The line that filters features: words, and conditions on their figures such as `dip>30`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.project import catalogue as of
from vomstudio.project import slip_figures
from vomstudio.project.figures import Figure, Form
from vomstudio.project.kinds import FIGURES
from vomstudio.ui.panels.features.feature_row import CLASS, Row

_WORDS = (
    of.NAME,
    of.KIND,
    of.SET,
    of.DOMAIN,
    CLASS,
    of.QUALITY,
    of.ATTITUDE_SCALE,
    of.REASONS,
    of.NOTES,
    of.OVERTURNED,
)
_FIGURES = (
    of.DIP,
    of.DIP_DIRECTION,
    of.STRIKE,
    of.TREND,
    of.PLUNGE,
    slip_figures.RAKE,
    of.TOTAL,
    of.MAX_CONFIDENCE,
    of.MIN_CONFIDENCE,
    of.DIP_ERROR,
    of.DIP_DIRECTION_ERROR,
    of.M,
    of.K,
    of.COPLANARITY,
    of.COLLINEARITY,
    of.N_POINTS,
    of.EXTENT,
    of.AREA,
    of.EXTENT_OVER_RESOLUTION,
    of.RMS,
    of.BEND,
)


def _listed(figures: Iterable[Figure]) -> str:
    return " ".join(figure.words[0] for figure in figures)


_HELP = to_translate(
    "Words of any column, and conditions, all of which must be met:\n"
    "  dip>30   dip:20..45   dipdir:350..20   extent<50cm   95<=5\n"
    "  type:joint   type=joint|fault   set:limb   quality:good   overturned:yes\n"
    '  -type:bedding or -word excludes; quotes keep blanks: set:"west limb"\n'
    "Text columns: {words} (: contains, = equals)\n"
    "Numbers: {numbers}"
)


def help_text() -> str:
    """How a filter is written, for a tool tip."""
    numbers = f"{_listed(_FIGURES[:12])}\n{_listed(_FIGURES[12:])}"
    return tr(_HELP, words=_listed(_WORDS), numbers=numbers)


def _known() -> dict[str, tuple[Figure, ...]]:
    """The figures that a word names: those above, and all others by their names in files. `kind` is
    the feature type there, and here has been what a feature is: it means both."""
    found: dict[str, tuple[Figure, ...]] = {}
    for figure in (*_WORDS, *_FIGURES, *FIGURES.values()):
        for word in (*figure.words, figure.name):
            others = found.get(word.casefold(), ())
            if all(other.name != figure.name for other in others):
                found[word.casefold()] = (*others, figure)
    return found


_FIELDS = _known()
_USUAL = [figure.words[0].casefold() for figure in (*_WORDS, *_FIGURES)]

_METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "km": 1000.0}
_SQUARE = {"cm2": 1e-4, "cm²": 1e-4, "m2": 1.0, "m²": 1.0, "km2": 1e6, "km²": 1e6}
_TOKEN = re.compile(r'(?:[^\s"]|"[^"]*"?)+')
_CONDITION = re.compile(r"(?P<key>[\w/]+)(?P<op><=|>=|!=|[:=<>])(?P<value>.*)", re.DOTALL)
_NUMBER = re.compile(r"(?P<number>[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+))\s*(?P<unit>[^\d\s]*)")

Test = Callable[[Row], bool]


def parse_filter(text: str) -> Test:
    """The test that a row has to pass. Raises UsageError where the filter cannot be read."""
    tests = [_test(token) for token in _TOKEN.findall(text)]
    return lambda row: all(test(row) for test in tests)


def _test(token: str) -> Test:
    if token.startswith("-") and len(token) > 1 and not token[1].isdigit():
        inner = _test(token[1:])
        return lambda row: not inner(row)
    condition = None if token.startswith('"') else _CONDITION.fullmatch(token)
    if condition is None:
        word = token.replace('"', "").casefold()
        return lambda row: word in row.everything
    key = condition["key"].casefold()
    figures = _FIELDS.get(key)
    if figures is None:
        near = difflib.get_close_matches(key, _USUAL, 1, 0.4)
        if near:
            raise UsageError(
                Finding("filter.similar-column", name=condition["key"], similar=near[0])
            )
        raise UsageError(Finding("filter.unknown-column", name=condition["key"]))
    # In messages a figure has its usual word.
    if key not in _USUAL and figures[0].words:
        key = figures[0].words[0].casefold()
    op, value = condition["op"], condition["value"].replace('"', "").strip()
    form = figures[0].form
    if not value:
        raise _unreadable(token, key, form)
    if form == "text":
        return _text_test(token, figures, op, value)
    if form == "flag":
        return _flag_test(token, figures[0], op, value)
    return _number_test(token, key, figures[0], op, value)


def _unreadable(token: str, key: str, form: Form) -> UsageError:
    """Return the error about a condition without a valid value, with an example of one."""
    if form == "text":
        example = "joint" if key == "type" else "word"
        return UsageError(Finding("filter.needs-word", condition=token, name=key, example=example))
    code = "filter.needs-yes-or-no" if form == "flag" else "filter.needs-number"
    return UsageError(Finding(code, condition=token, name=key))


def _text_test(token: str, figures: tuple[Figure, ...], op: str, value: str) -> Test:
    wanted = [part for part in value.casefold().split("|") if part]

    def said(row: Row) -> list[str]:
        return [str(row.value(figure) or "").casefold() for figure in figures]

    if op == ":":
        return lambda row: any(w in text for text in said(row) for w in wanted)
    if op == "=":
        return lambda row: any(text in wanted for text in said(row))
    if op == "!=":
        return lambda row: all(text not in wanted for text in said(row))
    raise UsageError(Finding("filter.text-has-no-size", condition=token))


def _flag_test(token: str, figure: Figure, op: str, value: str) -> Test:
    answers = {"yes": True, "true": True, "1": True, "no": False, "false": False, "0": False}
    word = figure.words[0] if figure.words else figure.name
    if value.casefold() not in answers or op not in (":", "=", "!="):
        raise _unreadable(token, word, figure.form)
    wanted = answers[value.casefold()] != (op == "!=")
    return lambda row: bool(row.value(figure)) == wanted


def _number_test(token: str, key: str, figure: Figure, op: str, value: str) -> Test:
    low, dots, high = value.partition("..")
    if dots:
        if op not in (":", "=", "!="):
            raise _unreadable(token, key, figure.form)
        a, b = _number(token, key, figure, low), _number(token, key, figure, high)

        def within(x: float) -> bool:
            if figure.form == "azimuth" and a > b:
                # Across North.
                return x >= a or x <= b
            return a <= x <= b

        return _defined(figure, (lambda x: not within(x)) if op == "!=" else within)
    n = _number(token, key, figure, value)
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
    return _defined(figure, compare[op])


def _defined(figure: Figure, compare: Callable[[float], bool]) -> Test:
    """An undefined figure meets no condition."""

    def test(row: Row) -> bool:
        value = row.value(figure)
        return value is not None and compare(float(value))

    return test


def _number(token: str, key: str, figure: Figure, text: str) -> float:
    found = _NUMBER.fullmatch(text.strip())
    units = {"m": _METRES, "m2": _SQUARE}.get(figure.unit, {"°": 1.0})
    if found is None or (found["unit"] and found["unit"].casefold() not in units):
        raise _unreadable(token, key, figure.form)
    scale = units[found["unit"].casefold()] if found["unit"] else 1.0
    return float(found["number"].replace(",", ".")) * scale
