"""Parser of feature filters, which consist of words and conditions such as `dip>30`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.project import catalogue, slip_figures
from vomstudio.project.figures import Figure, Form
from vomstudio.project.kinds import FIGURES
from vomstudio.ui.panels.features.feature_row import CLASS, Row

_TEXT_FIGURES = (
    catalogue.NAME,
    catalogue.KIND,
    catalogue.SET,
    catalogue.DOMAIN,
    catalogue.STATION,
    CLASS,
    catalogue.QUALITY,
    catalogue.ATTITUDE_SCALE,
    catalogue.REASONS,
    catalogue.NOTES,
    catalogue.OVERTURNED,
)
_NUMBER_FIGURES = (
    catalogue.DIP,
    catalogue.DIP_DIRECTION,
    catalogue.STRIKE,
    catalogue.TREND,
    catalogue.PLUNGE,
    slip_figures.RAKE,
    catalogue.TOTAL_ERROR,
    catalogue.MAX_CONFIDENCE,
    catalogue.MIN_CONFIDENCE,
    catalogue.DIP_ERROR,
    catalogue.DIP_DIRECTION_ERROR,
    catalogue.M,
    catalogue.K,
    catalogue.COPLANARITY,
    catalogue.COLLINEARITY,
    catalogue.N_POINTS,
    catalogue.EXTENT,
    catalogue.AREA,
    catalogue.EXTENT_OVER_RESOLUTION,
    catalogue.RMS,
    catalogue.BEND,
)


def _join_words(figures: Iterable[Figure]) -> str:
    return " ".join(figure.words[0] for figure in figures)


_HELP_TEXT = to_translate(
    "Words in any column, and conditions that must all be met:\n  dip>30   dip:20..45  "
    " dipdir:350..20   extent<50cm   95<=5\n  type:joint   type=joint|fault   set:limb  "
    " quality:good   overturned:yes\n  -type:bedding or -word excludes; quotes keep spaces:"
    ' set:"west limb"\nText columns: {words} (: contains, = equals)\nNumbers: {numbers}'
)


def help_text() -> str:
    """Return the filter syntax for a tooltip."""
    numbers = f"{_join_words(_NUMBER_FIGURES[:12])}\n{_join_words(_NUMBER_FIGURES[12:])}"
    return tr(_HELP_TEXT, words=_join_words(_TEXT_FIGURES), numbers=numbers)


def _figures_by_word() -> dict[str, tuple[Figure, ...]]:
    """Map each filter word to its figures; the name of a figure in files is also a word.

    `kind` means the feature type in files but the class of the feature in filters, so it is mapped
    to both.
    """
    figures_by_word: dict[str, tuple[Figure, ...]] = {}
    for figure in (*_TEXT_FIGURES, *_NUMBER_FIGURES, *FIGURES.values()):
        for word in (*figure.words, figure.name):
            figures = figures_by_word.get(word.casefold(), ())
            if all(known_figure.name != figure.name for known_figure in figures):
                figures_by_word[word.casefold()] = (*figures, figure)
    return figures_by_word


_FIGURES_BY_WORD = _figures_by_word()
_COMMON_WORDS = [figure.words[0].casefold() for figure in (*_TEXT_FIGURES, *_NUMBER_FIGURES)]

_LENGTH_UNITS_M = {"mm": 0.001, "cm": 0.01, "m": 1.0, "km": 1000.0}
_AREA_UNITS_M2 = {"cm2": 1e-4, "cm²": 1e-4, "m2": 1.0, "m²": 1.0, "km2": 1e6, "km²": 1e6}
_TOKEN_PATTERN = re.compile(r'(?:[^\s"]|"[^"]*"?)+')
_CONDITION_PATTERN = re.compile(r"(?P<key>[\w/]+)(?P<op><=|>=|!=|[:=<>])(?P<value>.*)", re.DOTALL)
_NUMBER_PATTERN = re.compile(
    r"(?P<number>[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+))\s*(?P<unit>(?:[^\d\s]+2?)?)"
)

Test = Callable[[Row], bool]


def parse_filter(text: str) -> Test:
    """Parse a filter into a test that is applied to rows.

    Raises
    ------
    UsageError
        If the filter cannot be parsed.
    """
    tests = [_create_test(token) for token in _TOKEN_PATTERN.findall(text)]
    return lambda row: all(test(row) for test in tests)


def _create_test(token: str) -> Test:
    if token.startswith("-") and len(token) > 1 and not token[1].isdigit():
        inner_test = _create_test(token[1:])
        return lambda row: not inner_test(row)
    condition = None if token.startswith('"') else _CONDITION_PATTERN.fullmatch(token)
    if condition is None:
        word = token.replace('"', "").casefold()
        return lambda row: word in row.search_text
    key = condition["key"].casefold()
    figures = _FIGURES_BY_WORD.get(key)
    if figures is None:
        similar_words = difflib.get_close_matches(key, _COMMON_WORDS, 1, 0.4)
        if similar_words:
            raise UsageError(
                Finding("filter.similar-column", name=condition["key"], similar=similar_words[0])
            )
        raise UsageError(Finding("filter.unknown-column", name=condition["key"]))
    # Messages use the common word for a figure.
    if key not in _COMMON_WORDS and figures[0].words:
        key = figures[0].words[0].casefold()
    op, value = condition["op"], condition["value"].replace('"', "").strip()
    form = figures[0].form
    if not value:
        raise _value_error(token, key, form)
    if form == "text":
        return _create_text_test(token, figures, op, value)
    if form == "flag":
        return _create_flag_test(token, figures[0], op, value)
    return _create_number_test(token=token, key=key, figure=figures[0], op=op, value=value)


def _value_error(token: str, key: str, form: Form) -> UsageError:
    """Create the error about an invalid value in a condition."""
    if form == "text":
        example = "joint" if key == "type" else "word"
        return UsageError(Finding("filter.needs-word", condition=token, name=key, example=example))
    code = "filter.needs-yes-or-no" if form == "flag" else "filter.needs-number"
    return UsageError(Finding(code, condition=token, name=key))


def _create_text_test(token: str, figures: tuple[Figure, ...], op: str, value: str) -> Test:
    words = [option for option in value.casefold().split("|") if option]

    def row_texts(row: Row) -> list[str]:
        return [str(row.value(figure) or "").casefold() for figure in figures]

    if op == ":":
        return lambda row: any(word in text for text in row_texts(row) for word in words)
    if op == "=":
        return lambda row: any(text in words for text in row_texts(row))
    if op == "!=":
        return lambda row: all(text not in words for text in row_texts(row))
    raise UsageError(Finding("filter.text-has-no-size", condition=token))


def _create_flag_test(token: str, figure: Figure, op: str, value: str) -> Test:
    flags = {"yes": True, "true": True, "1": True, "no": False, "false": False, "0": False}
    word = figure.words[0] if figure.words else figure.name
    if value.casefold() not in flags or op not in (":", "=", "!="):
        raise _value_error(token, word, figure.form)
    is_expected = flags[value.casefold()] != (op == "!=")
    return lambda row: bool(row.value(figure)) == is_expected


def _create_number_test(token: str, key: str, figure: Figure, op: str, value: str) -> Test:
    low, separator, high = value.partition("..")
    if separator:
        if op not in (":", "=", "!="):
            raise _value_error(token, key, figure.form)
        a, b = _parse_number(token, key, figure, low), _parse_number(token, key, figure, high)

        def is_within(x: float) -> bool:
            if figure.form == "azimuth" and a > b:
                # The range includes north.
                return x >= a or x <= b
            return a <= x <= b

        return _create_defined_test(
            figure, (lambda x: not is_within(x)) if op == "!=" else is_within
        )
    n = _parse_number(token, key, figure, value)
    # A value matches within the precision of the decimals that were typed.
    _, _, decimals = value.replace(",", ".").partition(".")
    tolerance = 0.5 * 10.0 ** -len(re.match(r"\d*", decimals)[0])  # type: ignore[index]
    compare: dict[str, Callable[[float], bool]] = {
        "<": lambda x: x < n,
        "<=": lambda x: x <= n,
        ">": lambda x: x > n,
        ">=": lambda x: x >= n,
        ":": lambda x: abs(x - n) <= tolerance,
        "=": lambda x: abs(x - n) <= tolerance,
        "!=": lambda x: abs(x - n) > tolerance,
    }
    return _create_defined_test(figure, compare[op])


def _create_defined_test(figure: Figure, compare: Callable[[float], bool]) -> Test:
    """Create a test that compares the values of a figure and rejects undefined values."""

    def test(row: Row) -> bool:
        value = row.value(figure)
        return value is not None and compare(float(value))

    return test


def _parse_number(token: str, key: str, figure: Figure, text: str) -> float:
    match = _NUMBER_PATTERN.fullmatch(text.strip())
    units = {"m": _LENGTH_UNITS_M, "m2": _AREA_UNITS_M2}.get(figure.unit, {"°": 1.0})
    if match is None or (match["unit"] and match["unit"].casefold() not in units):
        raise _value_error(token, key, figure.form)
    scale = units[match["unit"].casefold()] if match["unit"] else 1.0
    return float(match["number"].replace(",", ".")) * scale
