"""Options of an operation, declared once.

An options class is a frozen dataclass whose fields are made by `option`. Parsers, forms and tables
of the documentation read the declarations with `declarations`; the class itself checks the values,
so that every door has the same defaults, bounds and messages.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from typing import Any

from vomstudio.errors import UsageError
from vomstudio.words import tr

_DECLARATION = "option"


@dataclass(frozen=True)
class Declaration:
    """How one option looks at every door.

    Parameters
    ----------
    name : str
        Name of the field, such as ``max_distance_m``.
    default : object
    help : str
        One sentence for ``--help`` and the documentation (English; translated where shown).
    tip : str
        The same for a form, in at most 12 words.
    choices : tuple of str, optional
        The allowed values.
    minimum, maximum : float, optional
        Bounds, both allowed.
    metavar : str, optional
        What stands for the value in ``--help``.
    """

    name: str
    default: Any
    help: str
    tip: str = ""
    choices: tuple[str, ...] | None = None
    minimum: float | None = None
    maximum: float | None = None
    metavar: str | None = None

    @property
    def flag(self) -> str:
        """The option on the command line: the name without its unit."""
        words = self.name.split("_")
        if words[-1] in ("m", "m2", "deg", "mm", "px", "s"):
            words.pop()
        return "--" + "-".join(words)

    def check(self, value: Any) -> None:
        """Raise UsageError for a value that the declaration does not allow."""
        if value is None:
            return
        if self.choices is not None and value not in self.choices:
            raise UsageError(
                tr(
                    "“{value}” is not valid. Choose one of: {choices}.",
                    value=value,
                    choices=", ".join(self.choices),
                ),
                field=self.flag,
            )
        if self.minimum is None and self.maximum is None:
            return
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        if not low <= value <= high:
            raise UsageError(
                tr(
                    "{value:g} is not between {low:g} and {high:g}.",
                    value=value,
                    low=low,
                    high=high,
                ),
                field=self.flag,
            )


def option(
    default: Any,
    *,
    help: str,
    tip: str = "",
    choices: tuple[str, ...] | None = None,
    minimum: float | None = None,
    maximum: float | None = None,
    metavar: str | None = None,
) -> Any:
    """Declare one field of an options class; see `Declaration` for the parameters."""
    stated = {
        "help": help,
        "tip": tip,
        "choices": choices,
        "minimum": minimum,
        "maximum": maximum,
        "metavar": metavar,
    }
    return field(default=default, metadata={_DECLARATION: stated})


def declarations(options: type[Any]) -> tuple[Declaration, ...]:
    """Return the declarations of an options class in the order of its fields."""
    return tuple(
        Declaration(
            name=each.name,
            default=None if each.default is MISSING else each.default,
            **each.metadata[_DECLARATION],
        )
        for each in fields(options)
        if _DECLARATION in each.metadata
    )


def check_options(options: Any) -> None:
    """Raise UsageError if a value of an options object is not allowed."""
    for each in declarations(type(options)):
        each.check(getattr(options, each.name))


def given_options(options: Any) -> Mapping[str, Any]:
    """Return the values that differ from their defaults, by field name."""
    return {
        each.name: getattr(options, each.name)
        for each in declarations(type(options))
        if getattr(options, each.name) != each.default
    }
