"""Conversion of the arguments of Python functions to options objects."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeVar

from vomstudio.api.checking import check_flag, optional_integer, optional_number, optional_text
from vomstudio.core.errors import InputError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.options import Declaration, declarations

Options = TypeVar("Options")


_CONVERTERS: dict[type, Callable[[Any, str], Any]] = {
    float: optional_number,
    int: optional_integer,
    bool: check_flag,
    str: optional_text,
}


def options_from_arguments(
    options: type[Options], arguments: Mapping[str, Any] | None = None, **converted: Any
) -> Options:
    """Create an options object from arguments with the names of its fields.

    Parameters
    ----------
    options : type
        Options class of the operation.
    arguments : mapping of str to object, optional
        Arguments of the calling function (its ``locals()``). Names that are not options are
        ignored.
    **converted
        Values that replace arguments, such as a plane converted to text.

    Raises
    ------
    InputError
        If a required value is missing or a value has another type; the error names the argument.
    UsageError
        If a value is not allowed; the error names the argument.
    """
    declarations_by_name = {item.name: item for item in declarations(options)}
    values = {**(arguments or {}), **converted}
    option_values = {
        name: _convert_value(item, values[name])
        for name, item in declarations_by_name.items()
        if name in values
    }
    for name, value in option_values.items():
        if value is None and (
            declarations_by_name[name].is_required or declarations_by_name[name].default is not None
        ):
            raise InputError(Finding("option.missing"), field=name)
    with name_arguments_in_errors(options):
        return options(**option_values)


def _convert_value(option: Declaration, value: Any) -> Any:
    """Return a value of the type of an option. Raises InputError."""
    is_automatic = value is None and option.default is None
    return (
        value
        if is_automatic or option.is_repeated
        else _CONVERTERS[option.kind](value, option.name)
    )


@contextmanager
def name_arguments_in_errors(options: type[Any]) -> Iterator[None]:
    """Replace the names of command-line options in errors by the names of arguments.

    Parameters
    ----------
    options : type
        Options class of the operation.
    """
    try:
        yield
    except VomError as error:
        names = {item.flag: item.name for item in declarations(options)}
        error.field = names.get(error.field or "", error.field)
        values = {key: _argument_name(value, names) for key, value in error.values.items()}
        if values != error.values:
            error.values, error.message = values, Finding(error.code, **values).message
        raise


def _argument_name(value: Any, names: dict[str, str]) -> Any:
    """Return the argument of an option, or of each option in a tuple.

    Other values are returned unchanged.
    """
    if isinstance(value, tuple):
        return tuple(_argument_name(item, names) for item in value)
    return names.get(value, value) if isinstance(value, str) else value
