"""Validation of arguments before any computation."""

from __future__ import annotations

import errno
import operator
import os
import warnings as python_warnings
from collections.abc import Iterable, Iterator, Mapping, Set
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import InputError, UsageError, VomError, VomWarning
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import format_exact_plane, parse_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.coordinate_limits import find_invalid_points
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.tables import COORDINATES

MAX_ANGLE_DEG = 720
"""Maximum angle; larger values are typing errors or in another unit, as in tables."""
MAX_COUNT = 2**53
"""Maximum count; larger floating-point numbers are not exact integers."""


def warn(findings: Iterable[Finding], depth: int = 3, *, notes: bool = False) -> None:
    """Issue each message as a Python warning at the user's line.

    Parameters
    ----------
    findings : iterable of Finding
    depth : int, optional
        Stack level of the user's line, as `warnings.warn` counts it from this function.
    notes : bool, optional
        Whether messages of severity "info" are also issued, for results that have no
        ``.warnings``.
    """
    for finding in findings:
        if finding.severity == "info" and not notes:
            continue
        warning = VomWarning(finding.message, finding.code, finding.values)
        python_warnings.warn(warning, stacklevel=depth)


@contextmanager
def name_argument_in_errors(name: str, *others: str) -> Iterator[None]:
    """Name an argument as the cause of errors that are raised inside the block.

    Only errors that refer to one of the other names, or to neither a field nor a file, are changed.

    Parameters
    ----------
    name : str
        Name of the argument.
    *others : str
        Names of the same argument in the called code, such as the option of the command.
    """
    try:
        yield
    except VomError as error:
        if error.field in others or (error.field is None and error.file is None):
            error.field = name
        raise


def numbers(values: Any, name: str) -> FloatArray:
    """Convert values to a float64 array of any shape.

    Parameters
    ----------
    values : object
    name : str
        Name of the argument.

    Returns
    -------
    ndarray

    Raises
    ------
    InputError
        If a value is masked or is not a number.
    """
    if np.ma.isMaskedArray(values) and np.ma.getmaskarray(values).any():
        raise InputError(Finding("array.masked"), field=name)
    try:
        array = np.asarray(values)
        if array.dtype.kind in "OV" and hasattr(values, "astype"):
            array = np.asarray(values.astype(np.float64))
    except (ValueError, TypeError, OverflowError) as error:
        raise _not_numeric_error(values, name) from error
    if array.dtype.kind == "O":
        try:
            array = array.astype(np.float64)
        except (ValueError, TypeError, OverflowError) as error:
            raise _not_numeric_error(values, name) from error
    if array.dtype.kind not in "iuf":
        raise _not_numeric_error(values, name)
    return np.asarray(array, np.float64)


def _not_numeric_error(values: Any, name: str) -> InputError:
    return InputError(Finding("array.not-numbers", type=type(values).__name__), field=name)


def wrong_type_error(value: Any, expected: str, name: str) -> InputError:
    """Return the error for a value that does not have the expected type.

    Parameters
    ----------
    value : object
    expected : str
        Expected type, such as "int".
    name : str
        Name of the argument.

    Returns
    -------
    InputError
    """
    finding = Finding("argument.wrong-type", type=type(value).__name__, expected=expected)
    return InputError(finding, field=name)


def requires_type_error(option: str, argument: str, expected: str) -> UsageError:
    """Return the error for an option that requires another type of an argument.

    Parameters
    ----------
    option : str
        Name of the option.
    argument : str
        Name of the argument.
    expected : str
        Required type of the argument.

    Returns
    -------
    UsageError
    """
    finding = Finding("argument.requires-type", option=option, argument=argument, expected=expected)
    return UsageError(finding, field=option)


def array_points(values: Any, name: str = "points") -> FloatArray:
    """Convert an array, or a DataFrame with x, y, z, to finite points (n, 3).

    Raises
    ------
    InputError
        If the array is empty, has another shape or contains an invalid row; the error states the
        first such row.
    """
    array = numbers(_select_coordinates(values, name), name)
    if array.size == 0:
        raise InputError(Finding("argument.empty"), field=name)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(Finding("array.not-points", shape=array.shape), field=name)
    require_valid_rows(find_invalid_points(array), name)
    return np.ascontiguousarray(array)


def is_model(value: Any) -> bool:
    """Return whether a value is a path, a model, a model of a project or a PyVista data set.

    Parameters
    ----------
    value : object

    Returns
    -------
    bool
    """
    if is_path(value):
        return True
    if hasattr(value, "columns"):  # A DataFrame has its columns as attributes.
        return False
    return any(hasattr(value, name) for name in ("field_data", "to_pyvista", "read"))


def _select_coordinates(values: Any, name: str) -> Any:
    if not hasattr(values, "columns"):
        return values
    return values[coordinate_names(list(values.columns), name)]


def coordinate_names(columns: list[Any], name: str) -> list[Any]:
    """Return the columns of a DataFrame that contain x, y and z.

    Parameters
    ----------
    columns : list of object
    name : str
        Name of the argument.

    Returns
    -------
    list of object

    Raises
    ------
    InputError
        If a coordinate has no matching column, or more than one.
    """
    normalised_names = {column: normalise_name(str(column)) for column in columns}
    coordinate_columns = []
    for letter, synonyms in COORDINATES.items():
        matches = [c for c, word in normalised_names.items() if word == letter]
        matches = matches or [c for c, word in normalised_names.items() if word in synonyms]
        if len(matches) > 1:
            finding = Finding("table.repeated-column", column=letter, columns=matches)
            raise InputError(finding, field=name)
        if not matches:
            finding = Finding(
                "table.missing-column", column=letter, columns=columns, names=(letter,)
            )
            raise InputError(finding, field=name)
        coordinate_columns.append(matches[0])
    return coordinate_columns


def require_valid_rows(is_invalid: BoolArray, name: str, code: str = "array.not-finite") -> None:
    """Check that no row is invalid; the error states how many are, and the first (from 0).

    Parameters
    ----------
    is_invalid : (n,) ndarray of bool
    name : str
        Name of the argument.
    code : str, optional
        Code of the finding.

    Raises
    ------
    InputError
        If a row is invalid.
    """
    if is_invalid.any():
        finding = Finding(code, count=int(is_invalid.sum()), first_row=int(np.argmax(is_invalid)))
        raise InputError(finding, field=name)


def wrong_shape_error(array: FloatArray, expected: str, name: str) -> InputError:
    """Return the error for an array that does not have the expected shape.

    Parameters
    ----------
    array : ndarray
    expected : str
        Expected shape, such as "(n, 2)".
    name : str
        Name of the argument.

    Returns
    -------
    InputError
    """
    return InputError(Finding("array.shape", shape=array.shape, expected=expected), field=name)


def require_equal_lengths(first: FloatArray, second: FloatArray, names: tuple[str, str]) -> None:
    """Check that two arrays have the same number of rows.

    Parameters
    ----------
    first, second : ndarray
    names : tuple of str
        Names of the arguments.

    Raises
    ------
    InputError
        If the numbers of rows differ.
    """
    if len(first) != len(second):
        finding = Finding(
            "array.lengths-differ",
            name=names[0],
            count=len(first),
            other=names[1],
            other_count=len(second),
        )
        raise InputError(finding, field=names[1])


def to_array_pair(first: Any, second: Any, names: tuple[str, str]) -> tuple[FloatArray, FloatArray]:
    """Convert two arrays of equal length to finite numbers.

    Parameters
    ----------
    first, second : object
    names : tuple of str
        Names of the arguments.

    Returns
    -------
    first, second : (n,) ndarray

    Raises
    ------
    InputError
        If the arrays are empty, differ in length or are not one-dimensional, or if a value is not
        finite.
    """
    a, b = (np.atleast_1d(numbers(v, n)) for v, n in zip((first, second), names, strict=True))
    for array, name in zip((a, b), names, strict=True):
        if array.ndim != 1:
            raise wrong_shape_error(array, "(n,)", name)
    require_equal_lengths(a, b, names)
    if not len(a):
        raise InputError(Finding("argument.empty"), field=names[0])
    for array, name in zip((a, b), names, strict=True):
        require_valid_rows(~np.isfinite(array), name)
    return a, b


def require_positive(value: float | None, name: str) -> float | None:
    """Check that a length is positive; None remains None.

    Parameters
    ----------
    value : float or None
        Length, metres.
    name : str
        Name of the argument.

    Returns
    -------
    float or None

    Raises
    ------
    InputError
        If the length is not positive and finite.
    """
    number = optional_number(value, name)
    if number is not None and not 0.0 < number < np.inf:
        raise InputError(Finding("number.not-positive", value=number), field=name)
    return number


def check_choice(value: Any, allowed_values: Iterable[str], name: str) -> None:
    """Check that a value is one of the allowed values.

    Parameters
    ----------
    value : object
    allowed_values : iterable of str
    name : str
        Name of the argument.

    Raises
    ------
    InputError
        If the value is not allowed.
    """
    choices = list(allowed_values)
    if not isinstance(value, str):
        raise wrong_type_error(value, ", ".join(choices), name)
    if value not in choices:
        raise InputError(Finding("option.not-a-choice", value=value, choices=choices), field=name)


def check_flag(value: Any, name: str) -> bool:
    """Check that a value is True or False.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    bool

    Raises
    ------
    InputError
        If the value is not a boolean.
    """
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise wrong_type_error(value, "bool", name)


def looks_like_radians(azimuth: FloatArray, angle: FloatArray) -> bool:
    """Return whether all angles are small enough to be radians.

    At least three angles other than zero are required, and azimuths that are all integers are
    regarded as degrees. The angles may still be in degrees if all beds dip by less than 1.6 degrees
    toward 0 to 6.3 degrees. The result is therefore a reason for a warning, not for an error.

    Parameters
    ----------
    azimuth, angle : (n,) ndarray

    Returns
    -------
    bool
    """
    is_valid = np.isfinite(azimuth) & np.isfinite(angle) & (angle != 0.0)
    a, b = azimuth[is_valid], np.abs(angle[is_valid])
    is_small = (
        len(a) >= 3 and (a >= 0.0).all() and (a <= 2 * np.pi).all() and (b <= np.pi / 2).all()
    )
    return bool(is_small and (a != np.round(a)).any())


def optional_number(value: Any, name: str) -> float | None:
    """Convert a value to a number; None remains None.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    float or None

    Raises
    ------
    InputError
        If the value is not a single number.
    """
    if value is None:
        return None
    array = numbers(value, name)
    if array.shape != ():
        raise wrong_type_error(value, "float", name)
    return float(array)


def required_number(value: Any, name: str) -> float:
    """Convert a value to a number.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the value is None or not a single number.
    """
    number = optional_number(value, name)
    if number is None:
        raise InputError(Finding("option.missing"), field=name)
    return number


def optional_integer(value: Any, name: str) -> int | None:
    """Convert a value to an integer; None remains None.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    int or None

    Raises
    ------
    InputError
        If the value is not an integer, or is too large for a float.
    """
    if value is None:
        return None
    try:
        if not isinstance(value, bool | np.bool_) and abs(operator.index(value)) < MAX_COUNT:
            return operator.index(value)
    except TypeError:
        pass
    raise wrong_type_error(value, "int", name)


def to_path(value: Any, name: str) -> Path:
    """Convert a value to a path, expanding `~` to the home folder.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the value is not a path, or no file can have this name.
    """
    if isinstance(value, str | os.PathLike):
        path = os.fspath(value)
        if isinstance(path, str):
            path = os.path.expanduser(path)
            _check_name(path, name)
            return Path(path)
    raise wrong_type_error(value, "str, pathlib.Path", name)


def _check_name(path: str, name: str) -> None:
    """Raise InputError if the path is not valid for any file."""
    try:
        os.lstat(path)
    except ValueError as error:  # A null character, or half of a surrogate pair.
        raise InputError(Finding("path.invalid", reason=error), field=name) from error
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise InputError(Finding("disk.name-too-long"), field=name) from error


def optional_path(value: Any, name: str) -> Path | None:
    """Convert a value to a path; None remains None.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    Path or None

    Raises
    ------
    InputError
        Under the conditions of `to_path`.
    """
    return None if value is None else to_path(value, name)


def path_text(value: Any, name: str) -> str | None:
    """Convert a path to text; None remains None.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    str or None

    Raises
    ------
    InputError
        Under the conditions of `to_path`.
    """
    path = optional_path(value, name)
    return None if path is None else str(path)


def is_path(value: Any) -> bool:
    """Return whether a value is a path.

    Parameters
    ----------
    value : object

    Returns
    -------
    bool
    """
    return isinstance(value, str | os.PathLike)


def optional_text(value: Any, name: str) -> str | None:
    """Convert a value to text; None remains None.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    str or None

    Raises
    ------
    InputError
        If the value is not text, or is text that no file can contain.
    """
    if value is None:
        return None
    if isinstance(value, str):
        if "\0" in value or any("\ud800" <= letter <= "\udfff" for letter in value):
            raise InputError(Finding("text.invalid-characters"), field=name)
        return value
    raise wrong_type_error(value, "str", name)


def required_text(value: Any, name: str) -> str:
    """Convert a value to text; the value is required.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    str

    Raises
    ------
    InputError
        Under the conditions of `optional_text`, or if the value is None.
    """
    text = optional_text(value, name)
    if text is None:
        raise InputError(Finding("option.missing"), field=name)
    return text


def column_name(value: Any, name: str = "by") -> str | None:
    """Convert the name or number of a column to text; None remains None.

    Parameters
    ----------
    value : object
    name : str, optional
        Name of the argument.

    Returns
    -------
    str or None

    Raises
    ------
    InputError
        If the value is neither text nor an integer.
    """
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        return str(value)
    return optional_text(value, name)


def to_list(value: Any, name: str) -> list[Any]:
    """Convert a value to a list of items; a single text becomes a list of one item.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    list of object

    Raises
    ------
    InputError
        If the value is not iterable or has no order.
    """
    if isinstance(value, str):
        return [value]
    if isinstance(value, Iterable) and not isinstance(value, bytes | Mapping | Set):
        try:
            return list(value)
        except TypeError:  # An array without dimensions.
            pass
    raise wrong_type_error(value, "list", name)


def parse_angles(value: Any, name: str, count: int) -> tuple[float, ...]:
    """Convert a value to a fixed number of finite angles.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.
    count : int
        Number of angles.

    Returns
    -------
    tuple of float

    Raises
    ------
    InputError
        If the number of angles differs from `count`, or an angle exceeds `MAX_ANGLE_DEG`.
    """
    array = numbers(value, name)
    if array.shape != (count,):
        raise wrong_shape_error(array, f"({count},)", name)
    for angle in array.tolist():
        if not abs(angle) <= MAX_ANGLE_DEG:
            finding = Finding(
                "angle.out-of-range", value=angle, minimum=-MAX_ANGLE_DEG, maximum=MAX_ANGLE_DEG
            )
            raise InputError(finding, field=name)
    return tuple(array.tolist())


def join_angles(value: Any, name: str, count: int) -> str:
    """Format angles as on the command line, for example "125/26/30".

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.
    count : int
        Number of angles.

    Returns
    -------
    str

    Raises
    ------
    InputError
        Under the conditions of `parse_angles`; a text is returned unchanged.
    """
    if isinstance(value, str):
        return value
    return "/".join(repr(v).removesuffix(".0") for v in parse_angles(value, name, count))


def join_numbers(values: Any, separator: str = ",") -> str:
    """Join numbers as on the command line, with all digits and without exponents.

    Parameters
    ----------
    values : object
    separator : str, optional

    Returns
    -------
    str
    """
    return separator.join(np.format_float_positional(v, trim="-") for v in np.ravel(values))


def plane_text(value: Any, name: str) -> str:
    """Format a plane as "DD/D" (dip direction/dip).

    Parameters
    ----------
    value : object
        See `to_plane`.
    name : str
        Name of the argument.

    Returns
    -------
    str

    Raises
    ------
    InputError, GeometryError
        If the value is not a valid plane.
    """
    return format_exact_plane(to_plane(value, name))


def to_plane(value: Any, name: str) -> Plane:
    """Convert a text "DD/D", a pair (dip direction, dip) or a fit to a plane.

    Raises
    ------
    InputError, GeometryError
        If the value is not a valid plane.
    """
    with name_argument_in_errors(name, "dip direction", "dip"):
        if isinstance(value, str):
            return parse_plane(value)
        if hasattr(value, "dip_direction_deg") and hasattr(value, "dip_deg"):
            # A horizontal plane has no dip direction.
            azimuth = value.dip_direction_deg
            value = (0.0 if azimuth is None else azimuth, value.dip_deg)
        if numbers(value, name).shape != (2,):
            raise wrong_type_error(value, "'120/45', (120, 45), PlaneFit", name)
        return Plane(*parse_angles(value, name, 2))
