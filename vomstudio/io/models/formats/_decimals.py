"""Conversion of decimal text to float64 with correct rounding, in compiled code.

Two exact shortcuts are used; all other tokens are passed to Python's float():
- Clinger 1990 (*PLDI*, "How to read floating point numbers accurately"): a mantissa of at most
  2**53 and a power of ten of at most 22 are both exact doubles, so one multiplication or division
  rounds only once;
- mantissas of up to 18 digits divided by at most 10**22: the quotient is computed in double-double
  (Dekker 1971, *Numerische Mathematik* 18, 224) and used only if all values within its error bound
  round to the same double.
"""

from __future__ import annotations

import numpy as np

from vomstudio.geometry.kernels.jit import part, step

MAX_EXACT_INTEGER = 1 << 53
MAX_DIGITS = 18
POWERS = 10.0 ** np.arange(23)

READY, UNPARSED, NOT_A_NUMBER = 0, 1, 2


@part
def is_space(c):  # type: ignore[no-untyped-def]
    """Return whether a byte is a blank within a line, which excludes the line end (10)."""
    return c == 32 or c == 9 or c == 13 or c == 11 or c == 12


@part
def _quotient(mantissa, power):  # type: ignore[no-untyped-def]
    """Return ``mantissa / 10**power``, correctly rounded, or NaN if that is not certain."""
    p = POWERS[power]
    high = float(mantissa)
    low = float(mantissa - np.int64(high))
    q = high / p
    # Exact q * p as product + tail: Dekker's product of two doubles.
    splitter = 134217729.0
    t = splitter * q
    q1 = t - (t - q)
    q2 = q - q1
    t = splitter * p
    p1 = t - (t - p)
    p2 = p - p1
    product = q * p
    tail = ((q1 * p1 - product) + q1 * p2 + q2 * p1) + q2 * p2
    correction = (((high - product) - tail) + low) / p
    rounded_quotient = q + correction
    remainder = correction - (rounded_quotient - q)
    tolerance = abs(rounded_quotient) * 2.0**-98
    if (
        rounded_quotient + (remainder + tolerance) == rounded_quotient
        and rounded_quotient + (remainder - tolerance) == rounded_quotient
    ):
        return rounded_quotient
    return np.nan


@step
def _round(mantissa, exponent):  # type: ignore[no-untyped-def]
    """Return ``mantissa * 10**exponent``, correctly rounded, or NaN if that is not certain."""
    if mantissa == 0:
        return 0.0
    if mantissa <= MAX_EXACT_INTEGER and -22 <= exponent <= 22:
        value = float(mantissa)
        if exponent < 0:
            value /= POWERS[-exponent]
        elif exponent > 0:
            value *= POWERS[exponent]
        return value
    if -22 <= exponent < 0:
        return _quotient(mantissa, -exponent)
    return np.nan


@step
def _parse_power(data, i, end):  # type: ignore[no-untyped-def]
    """Parse a power of ten at i; return its value, whether it is valid, and its end."""
    is_negative = False
    if i < end and (data[i] == 45 or data[i] == 43):
        is_negative = data[i] == 45
        i += 1
    power = np.int64(0)
    is_valid = False
    while i < end:
        d = np.int64(data[i]) - 48
        if d < 0 or d > 9:
            break
        is_valid = True
        if power < 100000:
            power = power * 10 + d
        i += 1
    return (-power if is_negative else power), is_valid, i


@part
def number(data, start, end):  # type: ignore[no-untyped-def]
    """Parse the token from `start` to a blank or `end`; return its value, state and end.

    The state is READY, UNPARSED (to be parsed by Python: long, extreme, nan, inf, or not a number),
    or NOT_A_NUMBER.
    """
    i = start
    is_negative = False
    if i < end and (data[i] == 45 or data[i] == 43):
        is_negative = data[i] == 45
        i += 1
    mantissa = np.int64(0)
    digits = 0
    exponent = np.int64(0)
    is_valid = False
    is_long = False
    while i < end:
        d = np.int64(data[i]) - 48
        if d < 0 or d > 9:
            break
        is_valid = True
        if digits < MAX_DIGITS:
            mantissa = mantissa * 10 + d
            if mantissa != 0:
                digits += 1
        else:
            is_long = True
        i += 1
    if i < end and data[i] == 46:
        i += 1
        while i < end:
            d = np.int64(data[i]) - 48
            if d < 0 or d > 9:
                break
            is_valid = True
            if digits < MAX_DIGITS:
                mantissa = mantissa * 10 + d
                exponent -= 1
                if mantissa != 0:
                    digits += 1
            elif d != 0:
                is_long = True
            i += 1
    if is_valid and i < end and (data[i] == 101 or data[i] == 69):
        power, is_valid, i = _parse_power(data, i + 1, end)
        exponent += power
    if i < end and not is_space(data[i]):
        is_valid = False
    if not is_valid or is_long:
        while i < end and not is_space(data[i]):
            i += 1
        c = data[start] | 32
        # A word that cannot be nan or inf with any sign does not need to be parsed by Python.
        if 97 <= c <= 122 and c != 110 and c != 105:
            return 0.0, NOT_A_NUMBER, i
        return 0.0, UNPARSED, i
    value = _round(mantissa, exponent)
    if np.isnan(value):
        return 0.0, UNPARSED, i
    return -value if is_negative else value, READY, i


def python_number(token: bytes) -> float | None:
    """Parse a number that compiled code could not parse, or return None if it is not one.

    NaN in any spelling counts as a number.
    """
    try:
        text = token.decode("ascii").lower()
        return None if "_" in text else float(text)
    except ValueError:
        unsigned = token.lower().lstrip(b"+-")
        # Microsoft's C library writes 1.#IND, 1.#QNAN, 1.#INF, and nan(ind).
        if unsigned.startswith((b"1.#", b"nan", b"inf")):
            return float("nan")
        return None
