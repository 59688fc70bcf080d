"""Lengths and areas in words."""

from __future__ import annotations

import pytest

from vomstudio.geometry.units import (
    METRES_PER_UNIT,
    area_text,
    length_text,
    round_length,
    scale_bar_text,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (0.0, "0 mm"),
        (2e-17, "0 mm"),
        (0.00031, "0.310 mm"),
        (0.0042, "4.20 mm"),
        (0.00999, "9.99 mm"),
        (0.01, "1.00 cm"),
        (0.4567, "45.7 cm"),
        (0.9996, "1.00 m"),
        (1.0, "1.00 m"),
        (12.345, "12.3 m"),
        (999.4, "999 m"),
        (999.7, "1.00 km"),
        (12345.0, "12.3 km"),
        (5e6, "5000 km"),
        (-0.25, "-25.0 cm"),
    ],
)
def test_length_uses_suitable_unit_without_exponent(value, text):
    assert length_text(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (0.0, "0 cm²"),
        (0.0012, "12.0 cm²"),
        (0.0107, "0.0107 m²"),
        (1234.5, "1234 m²"),
        (25000.0, "0.0250 km²"),
    ],
)
def test_area_uses_suitable_unit_without_exponent(value, text):
    assert area_text(value) == text


def test_length_text_has_requested_digits():
    assert length_text(0.0174899, 2) == "1.7 cm"


def test_a_length_of_unknown_scale_is_never_called_metres():
    assert length_text(12345.6, is_metric=False) == "12346 units"
    assert length_text(0.01234, is_metric=False) == "0.0123 units"
    assert area_text(2.5, is_metric=False) == "2.50 units²"
    assert length_text(None, is_metric=False) == "–"


@pytest.mark.parametrize("digits", [2, 3, 4])
@pytest.mark.parametrize("power", range(-6, 7))
def test_length_text_matches_value_to_its_digits(digits, power):
    size = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3}
    for first in (1.0, 1.23456, 4.99949, 9.94, 9.9999):
        value = first * 10.0**power
        for sign in (1.0, -1.0):
            number, unit = length_text(sign * value, digits).split()
            assert float(number) * size[unit] * sign == pytest.approx(
                value, rel=0.6 * 10.0 ** (1 - digits)
            )
            assert "e" not in number
            shown = number.lstrip("-").replace(".", "").lstrip("0")
            whole = number.lstrip("-").partition(".")[0]
            assert len(shown) == max(digits, len(whole) if whole != "0" else 0)


@pytest.mark.parametrize("power", range(-7, 9))
def test_area_text_matches_value_to_its_digits(power):
    size = {"cm²": 1e-4, "m²": 1.0, "km²": 1e6}
    for first in (1.0, 2.34567, 9.9999):
        value = first * 10.0**power
        number, unit = area_text(value).split()
        assert float(number) * size[unit] == pytest.approx(value, rel=0.006)
        assert "e" not in number


def test_lengths_below_a_ten_thousandth_of_a_millimetre_are_zero():
    assert length_text(0.99e-7) == "0 mm"
    assert length_text(1.01e-7) == "0.000101 mm"
    assert area_text(0.99e-14) == "0 cm²"
    assert area_text(1.01e-14) != "0 cm²"


def test_named_units_convert_to_metres():
    inch = 0.0254
    for name, metres in (("ft", 12 * inch), ("us-ft", 12 / 39.37), ("km", 1e3), ("cm", 1e-2)):
        assert METRES_PER_UNIT[name] == pytest.approx(metres, rel=1e-12)
    assert (METRES_PER_UNIT["m"], METRES_PER_UNIT["mm"]) == (1.0, 1e-3)


@pytest.mark.parametrize("text", [length_text, area_text])
def test_non_finite_values_are_formatted_as_such(text):
    assert text(float("inf")).startswith("inf")
    assert text(float("nan")).startswith("nan")


@pytest.mark.parametrize(
    ("longest", "text"),
    [
        (0.0049, "2 mm"),
        (0.005, "5 mm"),
        (0.0199, "1 cm"),
        (0.9, "50 cm"),
        (1.0, "1 m"),
        (7.3, "5 m"),
        (999.0, "500 m"),
        (2500.0, "2 km"),
    ],
)
def test_scale_bar_has_a_round_length_that_fits(longest, text):
    assert scale_bar_text(round_length(longest)) == text


def test_scale_bar_of_unknown_scale_is_in_units():
    assert scale_bar_text(round_length(0.3), is_metric=False) == "0.2 units"
