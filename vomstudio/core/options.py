"""Options of an operation, declared once for all interfaces.

An options class is a frozen dataclass derived from `Options`, whose fields are created by
`option`. Parsers, forms, copied commands, the Python interface and the tables of the documentation
read the declarations with `declarations`. The class itself checks the values, so every interface
has the same defaults, bounds and messages.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Hashable, Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from typing import Any, Literal

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr

_DECLARATION = "option"
UNITS = {"m": "m", "m2": "m²", "deg": "°", "mm": "mm", "pt": "pt", "px": "px", "s": "s"}
"""Name suffixes that state the unit, with the symbols shown in forms."""
MIN_LENGTH_M, MAX_LENGTH_M = 1e-9, 1e6
"""Bounds of a positive length."""


@dataclass(frozen=True)
class Declaration:
    """Declaration of one option for all interfaces.

    Parameters
    ----------
    name : str
        Name of the field and of the Python parameter, such as ``max_distance_m``.
    kind : type
        float, int, bool or str; for an option that may be repeated, the type of each value.
    default : object
        Default value; None if the program chooses the value or if `is_required` is set.
    help : str
        One sentence without a full stop for ``--help`` and the documentation, in English; it is
        translated when it is displayed.
    tip : str
        Tooltip in a form, with at most 12 words.
    label : str
        Label in a form, with at most three words. If empty, the option is not shown in forms.
    automatic : str
        Description of the default that the program chooses for None, such as "50, or on a mesh 1 %
        of its area".
    choices : tuple of str, optional
        Allowed values.
    titles : tuple of str
        Names of the choices or suggestions in a form, in the same order. If empty, a form shows the
        values.
    suggestions : tuple of str
        Usual values, which a form lists. Other values, such as names in a project, are allowed.
    choice_tips : tuple of str
        Descriptions of the choices, in the same order. If empty, the choices have none.
    minimum, maximum : float, optional
        Bounds, both inclusive.
    metavar : str, optional
        Placeholder of the value in ``--help``.
    decimals : int
        Number of decimals in a form.
    empty : str
        Text that a form shows for None. If empty, a list in a form has no entry for None.
    form_unit : tuple of str and float, optional
        Unit in a form and its number per unit of the option, such as ``("%", 100.0)`` for a share.
    flag_value : str, optional
        Value if the option is given without one. Without `flag_value`, the option requires a value.
    is_required : bool
        Whether a value is required.
    is_repeated : bool
        Whether the option may be repeated. If True, its value is a tuple and its name a plural.
    """

    name: str
    kind: type
    default: Any
    help: str
    tip: str = ""
    label: str = ""
    automatic: str = ""
    choices: tuple[str, ...] | None = None
    titles: tuple[str, ...] = ()
    suggestions: tuple[str, ...] = ()
    choice_tips: tuple[str, ...] = ()
    minimum: float | None = None
    maximum: float | None = None
    metavar: str | None = None
    decimals: int = 3
    empty: str = to_translate("auto")
    form_unit: tuple[str, float] | None = None
    flag_value: str | None = None
    is_required: bool = False
    is_repeated: bool = False

    @property
    def unit(self) -> str | None:
        """Suffix of the name that states the unit, or None if the option has no unit."""
        suffix = self.name.rpartition("_")[2]
        return suffix if suffix in UNITS else None

    @property
    def flag(self) -> str:
        """Command-line option: the name without its unit, and in the singular if repeated."""
        name = self.name.removesuffix("s") if self.is_repeated else self.name
        words = name.split("_")
        if self.unit is not None:
            words.pop()
        return "--" + "-".join(words)

    def check(self, value: Any) -> None:
        """Raise UsageError for a value that the declaration does not allow."""
        if value is None or self.is_repeated:
            return
        if self.choices is not None and value not in self.choices:
            raise self._value_error("option.not-a-choice", value, choices=self.choices)
        if self.minimum is None and self.maximum is None:
            return
        if self.maximum is None:
            if not self.minimum <= value < float("inf"):
                raise self._value_error("option.too-small", value, minimum=self.minimum)
        elif not (self.minimum or 0.0) <= value <= self.maximum:
            if self.minimum == MIN_LENGTH_M:
                raise self._value_error("option.not-a-length", value, maximum=self.maximum)
            raise self._value_error(
                "option.out-of-range",
                value,
                minimum=self.minimum or 0.0,
                maximum=self.maximum,
            )

    def _value_error(self, code: str, value: Any, **values: Any) -> UsageError:
        return UsageError(Finding(code, value=value, **values), field=self.flag)


def option(
    default: Any = MISSING,
    *,
    help: str,
    tip: str = "",
    label: str = "",
    automatic_text: str = "",
    choices: tuple[str, ...] | None = None,
    titles: tuple[str, ...] = (),
    suggestions: tuple[str, ...] = (),
    choice_tips: tuple[str, ...] = (),
    minimum: float | None = None,
    maximum: float | None = None,
    metavar: str | None = None,
    decimals: int = 3,
    empty_text: str = to_translate("auto"),
    form_unit: tuple[str, float] | None = None,
    flag_value: str | None = None,
) -> Any:
    """Declare a field of an options class; see `Declaration` for the parameters.

    `automatic_text` and `empty_text` are its `automatic` and `empty`. An option without a default
    is required.
    """
    metadata = {
        "help": help,
        "tip": tip,
        "label": label,
        "automatic": automatic_text,
        "choices": choices,
        "titles": titles,
        "suggestions": suggestions,
        "choice_tips": choice_tips,
        "minimum": minimum,
        "maximum": maximum,
        "metavar": metavar,
        "decimals": decimals,
        "empty": empty_text,
        "form_unit": form_unit,
        "flag_value": flag_value,
    }
    return field(default=default, metadata={_DECLARATION: metadata})


def declarations(options: type[Any]) -> tuple[Declaration, ...]:
    """Return the declarations of an options class in the order of its fields.

    Parameters
    ----------
    options : type
        Options class.

    Returns
    -------
    tuple of Declaration
    """
    return _declarations(typing.cast(Hashable, options))


def find_declaration(options: type[Any], name: str) -> Declaration:
    """Return the declaration of one option.

    Parameters
    ----------
    options : type
        Options class.
    name : str
        Name of the field.

    Returns
    -------
    Declaration
    """
    return next(item for item in declarations(options) if item.name == name)


@cache
def _declarations(options: Any) -> tuple[Declaration, ...]:
    hints = typing.get_type_hints(options)
    results = []
    for item in fields(options):
        metadata = item.metadata.get(_DECLARATION)
        if metadata is None:
            continue
        kind, choices, is_repeated = _value_type(hints[item.name])
        results.append(
            Declaration(
                name=item.name,
                kind=kind,
                default=None if item.default is MISSING else item.default,
                is_required=item.default is MISSING,
                is_repeated=is_repeated,
                **metadata | {"choices": metadata["choices"] or choices},
            )
        )
    return tuple(results)


def _value_type(hint: Any) -> tuple[type, tuple[str, ...] | None, bool]:
    """Return the type of an option's values, its choices, and whether it is repeated.

    The choices are the values of a `Literal` annotation, or None for other annotations.
    """
    if hint == tuple[str, ...]:
        return str, None, True
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        (hint,) = (item for item in typing.get_args(hint) if item is not type(None))
    if typing.get_origin(hint) is Literal:
        return str, typing.get_args(hint), False
    assert hint in (float, int, bool, str), hint
    return hint, None, False


class Options:
    """Base class of options classes, which checks their values."""

    def __post_init__(self) -> None:
        for item in declarations(type(self)):
            item.check(getattr(self, item.name))


def check_exclusive(options: Any, *names: str) -> None:
    """Raise UsageError if more than one of the named options is given."""
    given_flags = [
        item.flag
        for item in declarations(type(options))
        if item.name in names and getattr(options, item.name) != item.default
    ]
    if len(given_flags) > 1:
        finding = Finding("option.conflict", option=given_flags[0], other=given_flags[1])
        raise UsageError(finding, field=given_flags[1])


def check_alternatives(options: Any, *names: str) -> None:
    """Raise UsageError unless exactly one of the named options is given."""
    check_exclusive(options, *names)
    items = [find_declaration(type(options), name) for name in names]
    if all(getattr(options, item.name) == item.default for item in items):
        flags = [item.flag for item in items]
        raise UsageError(Finding("option.none-given", options=flags), field=flags[0])


def check_requires(options: Any, name: str, required_name: str) -> None:
    """Raise UsageError if an option is given without the other option on which it depends."""
    item, required_item = (find_declaration(type(options), key) for key in (name, required_name))
    is_given = getattr(options, name) != item.default
    if is_given and getattr(options, required_name) == required_item.default:
        finding = Finding("option.requires", option=item.flag, other=required_item.flag)
        raise UsageError(finding, field=item.flag)


def given_options(options: Any) -> Mapping[str, Any]:
    """Return the values that differ from their defaults, by field name."""
    return {
        item.name: getattr(options, item.name)
        for item in declarations(type(options))
        if getattr(options, item.name) != item.default
    }


def option_words(options: Any) -> list[str | tuple[str, str | float]]:
    """Return the command-line words for the options, with a flag and its value as a pair."""
    words: list[str | tuple[str, str | float]] = []
    for item in declarations(type(options)):
        value = getattr(options, item.name)
        if value == item.default:
            continue
        if item.kind is bool:
            words.append(item.flag if value else f"--no-{item.flag.removeprefix('--')}")
        elif value == item.flag_value:
            words.append(item.flag)
        elif item.is_repeated:
            words += [(item.flag, text) for text in value]
        else:
            words.append((item.flag, value if item.kind is float else str(value)))
    return words


def option_texts(options: Any, **effective_values: Any) -> list[str]:
    """Return the label and value of each option that has both, such as "Angle 20°".

    Parameters
    ----------
    options : Options
    **effective_values
        Values that the program used, by the name of the option.

    Returns
    -------
    list of str
    """
    texts = []
    for item in declarations(type(options)):
        value = effective_values.get(item.name, getattr(options, item.name))
        if item.label and value is not None:
            unit = UNITS.get(item.unit or "", "")
            text = f"{value:.3g}" if item.kind is float else str(value)
            texts.append(f"{tr(item.label)} {text}{unit if unit == '°' else f' {unit}'.rstrip()}")
    return texts
