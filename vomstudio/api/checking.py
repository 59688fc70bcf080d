"""What users hand over, checked before anything is computed with it."""

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
from vomstudio.geology.notation import exact_plane, parse_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.coordinate_limits import no_places
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.tables import COORDINATES

_MAX_ANGLE_DEG = 720
"""An angle beyond two turns is a slip of the pen or of the unit, as in a table."""
_MOST_COUNT = 2**53
"""What lies beyond is no count of anything, and not a whole number in floating point."""


def warn(messages: Iterable[Finding], depth: int = 3, *, notes: bool = False) -> None:
    """Issue each message as a Python warning at the user's line.

    notes : whether those of severity "info" are issued, for results without ``.warnings``
    depth : stack depth of the caller below the user's line
    """
    for finding in messages:
        if finding.severity == "info" and not notes:
            continue
        warning = VomWarning(finding.message, finding.code, finding.values)
        python_warnings.warn(warning, stacklevel=depth)


@contextmanager
def naming(name: str, *others: str) -> Iterator[None]:
    """What goes wrong inside is of the argument of this name.

    others : what it is called below, such as the command's option, where something goes wrong
    """
    try:
        yield
    except VomError as error:
        if error.field in others or (error.field is None and error.file is None):
            error.field = name
        raise


def numbers(values: Any, name: str) -> FloatArray:
    """Values as float64 of whatever shape. Raises InputError."""
    if np.ma.isMaskedArray(values) and np.ma.getmaskarray(values).any():
        raise InputError(Finding("array.masked"), field=name)
    try:
        array = np.asarray(values)
        if array.dtype.kind in "OV" and hasattr(values, "astype"):
            array = np.asarray(values.astype(np.float64))
    except (ValueError, TypeError, OverflowError) as error:
        raise _no_numbers(values, name) from error
    if array.dtype.kind == "O":
        try:
            array = array.astype(np.float64)
        except (ValueError, TypeError, OverflowError) as error:
            raise _no_numbers(values, name) from error
    if array.dtype.kind not in "iuf":
        raise _no_numbers(values, name)
    return np.asarray(array, np.float64)


def _no_numbers(values: Any, name: str) -> InputError:
    return InputError(Finding("array.not-numbers", type=type(values).__name__), field=name)


def wrong_type(value: Any, expected: str, name: str) -> InputError:
    """Return the error of a value of another type than expected, such as "int"."""
    finding = Finding("argument.wrong-type", type=type(value).__name__, expected=expected)
    return InputError(finding, field=name)


def requires_type(option: str, argument: str, expected: str) -> UsageError:
    """Return the error of an option that is for another type of an argument."""
    finding = Finding("argument.requires-type", option=option, argument=argument, expected=expected)
    return UsageError(finding, field=option)


def points(values: Any, name: str = "points") -> FloatArray:
    """(n, 3) finite coordinates of an array, a list of triples, or a DataFrame with x, y, z.
    Raises InputError that names the first row that is none."""
    array = numbers(_coordinates_of(values, name), name)
    if array.size == 0:
        raise InputError(Finding("argument.empty"), field=name)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(Finding("array.not-points", shape=array.shape), field=name)
    refuse_rows(no_places(array), name)
    return np.ascontiguousarray(array)


def pixels_or_points(values: Any, name: str) -> FloatArray:
    """(n, 3) as `points`, or (n, 2) finite columns and rows of a photo. Raises InputError."""
    if hasattr(values, "columns") or np.ndim(values) != 2 or np.shape(values)[1] != 2:
        return points(values, name)
    array = numbers(values, name)
    refuse_rows(np.asarray(~np.isfinite(array).all(axis=1)), name)
    return np.ascontiguousarray(array)


def _coordinates_of(values: Any, name: str) -> Any:
    if not hasattr(values, "columns"):
        return values
    return values[coordinate_names(list(values.columns), name)]


def coordinate_names(columns: list[Any], name: str) -> list[Any]:
    """Which columns of a DataFrame are x, y and z. Raises InputError."""
    known = {column: normalise_name(str(column)) for column in columns}
    found = []
    for letter, others in COORDINATES.items():
        matches = [c for c, word in known.items() if word == letter]
        matches = matches or [c for c, word in known.items() if word in others]
        if len(matches) > 1:
            finding = Finding("table.repeated-column", column=letter, columns=matches)
            raise InputError(finding, field=name)
        if not matches:
            finding = Finding(
                "table.missing-column", column=letter, columns=columns, names=(letter,)
            )
            raise InputError(finding, field=name)
        found.append(matches[0])
    return found


def refuse_rows(bad: BoolArray, name: str, code: str = "array.not-finite") -> None:
    """Raise InputError with the number of bad rows and the first, counted from 0."""
    if bad.any():
        finding = Finding(code, count=int(bad.sum()), first_row=int(np.argmax(bad)))
        raise InputError(finding, field=name)


def wrong_shape(array: FloatArray, expected: str, name: str) -> InputError:
    """Return the error of an array of another shape than expected, such as "(n, 2)"."""
    return InputError(Finding("array.shape", shape=array.shape, expected=expected), field=name)


def refuse_other_lengths(one: FloatArray, other: FloatArray, names: tuple[str, str]) -> None:
    """Raise InputError if two arrays do not have the same number of rows."""
    if len(one) != len(other):
        finding = Finding(
            "array.lengths-differ",
            name=names[0],
            count=len(one),
            other=names[1],
            other_count=len(other),
        )
        raise InputError(finding, field=names[1])


def pairs(first: Any, second: Any, names: tuple[str, str]) -> tuple[FloatArray, FloatArray]:
    """Two arrays (n,) of finite numbers. Raises InputError."""
    a, b = (np.atleast_1d(numbers(v, n)) for v, n in zip((first, second), names, strict=True))
    for array, name in zip((a, b), names, strict=True):
        if array.ndim != 1:
            raise wrong_shape(array, "(n,)", name)
    refuse_other_lengths(a, b, names)
    if not len(a):
        raise InputError(Finding("argument.empty"), field=names[0])
    for array, name in zip((a, b), names, strict=True):
        refuse_rows(~np.isfinite(array), name)
    return a, b


def positive(value: float | None, name: str) -> float | None:
    """A length in metres, or None. Raises InputError."""
    number = single_number(value, name)
    if number is not None and not 0.0 < number < np.inf:
        raise InputError(Finding("number.not-positive", value=number), field=name)
    return number


def one_of(value: Any, known: Iterable[str], name: str) -> None:
    """Raises InputError unless it is one of these words."""
    choices = list(known)
    if not isinstance(value, str):
        raise wrong_type(value, ", ".join(choices), name)
    if value not in choices:
        raise InputError(Finding("option.not-a-choice", value=value, choices=choices), field=name)


def flag(value: Any, name: str) -> bool:
    """Raises InputError for what is neither True nor False."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise wrong_type(value, "bool", name)


def looks_like_radians(azimuth: FloatArray, angle: FloatArray) -> bool:
    """Whether all angles are so small that they may be radians.

    They may be degrees all the same: beds that dip by less than 1.6 degrees, all to within 6.3
    degrees of north. So this is a warning and not an error.
    """
    sound = np.isfinite(azimuth) & np.isfinite(angle) & (angle != 0.0)
    a, b = azimuth[sound], np.abs(angle[sound])
    small = len(a) >= 3 and (a >= 0.0).all() and (a <= 2 * np.pi).all() and (b <= np.pi / 2).all()
    return bool(small and (a != np.round(a)).any())


def single_number(value: Any, name: str) -> float | None:
    """None for None. Raises InputError, with the argument's name, for what is no single number."""
    if value is None:
        return None
    array = numbers(value, name)
    if array.shape != ():
        raise wrong_type(value, "float", name)
    return float(array)


def required_number(value: Any, name: str) -> float:
    """As `single_number`, of what cannot be left out. Raises InputError."""
    number = single_number(value, name)
    if number is None:
        raise InputError(Finding("option.missing"), field=name)
    return number


def whole_number(value: Any, name: str) -> int | None:
    """None for None. Raises InputError for what is no whole number."""
    if value is None:
        return None
    try:
        if not isinstance(value, bool | np.bool_) and abs(operator.index(value)) < _MOST_COUNT:
            return operator.index(value)
    except TypeError:
        pass
    raise wrong_type(value, "int", name)


def path_of(value: Any, name: str) -> Path:
    """With `~` for the home folder. Raises InputError for what names no file or folder."""
    if isinstance(value, str | os.PathLike):
        path = os.fspath(value)
        if isinstance(path, str):
            path = os.path.expanduser(path)
            _check_name(path, name)
            return Path(path)
    raise wrong_type(value, "str, pathlib.Path", name)


def _check_name(path: str, name: str) -> None:
    """Raises InputError for a path that no file can have, whatever is there."""
    try:
        os.lstat(path)
    except ValueError as error:  # A zero byte, or half of a pair of surrogates.
        raise InputError(Finding("path.invalid", reason=error), field=name) from error
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise InputError(Finding("disk.name-too-long"), field=name) from error


def maybe_path(value: Any, name: str) -> Path | None:
    """As `path_of`, None for None. Raises InputError."""
    return None if value is None else path_of(value, name)


def path_text(value: Any, name: str) -> str | None:
    """Return a path as text, None for None. Raises InputError."""
    path = maybe_path(value, name)
    return None if path is None else str(path)


def is_path(value: Any) -> bool:
    """Whether somebody means a file by it."""
    return isinstance(value, str | os.PathLike)


def words_of(value: Any, name: str) -> str | None:
    """None for None. Raises InputError for what is no text, or none that a file can hold."""
    if value is None:
        return None
    if isinstance(value, str):
        if "\0" in value or any("\ud800" <= letter <= "\udfff" for letter in value):
            raise InputError(Finding("text.invalid-characters"), field=name)
        return value
    raise wrong_type(value, "str", name)


def required_text(value: Any, name: str) -> str:
    """Return a text that cannot be left out. Raises InputError."""
    text = words_of(value, name)
    if text is None:
        raise InputError(Finding("option.missing"), field=name)
    return text


def column_of(value: Any, name: str = "by") -> str | None:
    """The name or the number of a column as a text, None for None. Raises InputError."""
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        return str(value)
    return words_of(value, name)


def items_of(given: Any, name: str) -> list[Any]:
    """Several of what may be given once as a text. Raises InputError for what cannot be gone
    through in an order of its own."""
    if isinstance(given, str):
        return [given]
    if isinstance(given, Iterable) and not isinstance(given, bytes | Mapping | Set):
        try:
            return list(given)
        except TypeError:  # An array without dimensions.
            pass
    raise wrong_type(given, "list", name)


def angles_of(given: Any, name: str, count: int) -> tuple[float, ...]:
    """So many finite numbers. Raises InputError."""
    array = numbers(given, name)
    if array.shape != (count,):
        raise wrong_shape(array, f"({count},)", name)
    for angle in array.tolist():
        if not abs(angle) <= _MAX_ANGLE_DEG:
            finding = Finding(
                "angle.out-of-range", value=angle, minimum=-_MAX_ANGLE_DEG, maximum=_MAX_ANGLE_DEG
            )
            raise InputError(finding, field=name)
    return tuple(array.tolist())


def slashed(given: Any, name: str, count: int) -> str:
    """Angles as the command takes them, "125/26/30". Raises InputError."""
    if isinstance(given, str):
        return given
    return "/".join(repr(v).removesuffix(".0") for v in angles_of(given, name, count))


def joined(values: Any, separator: str = ",") -> str:
    """Return numbers as the command line takes them, with all digits and no exponent."""
    return separator.join(np.format_float_positional(v, trim="-") for v in np.ravel(values))


def plane_text(given: Any, name: str) -> str:
    """Return a plane, as `attitude_of` takes it, as "DD/D". Raises InputError, GeometryError."""
    return exact_plane(attitude_of(given, name))


def attitude_of(given: Any, name: str) -> Plane:
    """A plane of "DD/D", of (dip direction, dip), or of a fit. Raises InputError, GeometryError."""
    with naming(name, "dip direction", "dip"):
        if isinstance(given, str):
            return parse_plane(given)
        if hasattr(given, "dip_direction_deg") and hasattr(given, "dip_deg"):
            # A horizontal plane has no dip direction, and none is needed.
            azimuth = given.dip_direction_deg
            given = (0.0 if azimuth is None else azimuth, given.dip_deg)
        if numbers(given, name).shape != (2,):
            raise wrong_type(given, "'120/45', (120, 45), PlaneFit", name)
        return Plane(*angles_of(given, name, 2))
