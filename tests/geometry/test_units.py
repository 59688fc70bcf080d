"""Lengths and areas in words."""

from __future__ import annotations

import pytest

from vomstudio.geometry.units import area_text, length_text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"), (0.0, "0 mm"), (2e-17, "0 mm"), (0.00031, "0.310 mm"), (0.0042, "4.20 mm"),
        (0.00999, "9.99 mm"), (0.01, "1.00 cm"), (0.4567, "45.7 cm"), (0.9996, "1.00 m"),
        (1.0, "1.00 m"), (12.345, "12.3 m"), (999.4, "999 m"), (999.7, "1.00 km"),
        (12345.0, "12.3 km"), (5e6, "5000 km"), (-0.25, "-25.0 cm"),
    ],
)  # fmt: skip
def test_a_length_stands_in_the_unit_that_suits_it_without_an_exponent(value, text):
    assert length_text(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (0.0, "0 cm²"), (0.0012, "12.0 cm²"), (0.0107, "0.0107 m²"), (1234.5, "1234 m²"),
     (25000.0, "0.0250 km²")],
)  # fmt: skip
def test_an_area_stands_in_the_unit_that_suits_it_without_an_exponent(value, text):
    assert area_text(value) == text


def test_an_error_has_the_digits_that_it_is_asked_for():
    assert length_text(0.0174899, 2) == "1.7 cm"


def test_a_length_of_unknown_scale_is_never_called_metres():
    assert length_text(12345.6, metric=False) == "12346 units"
    assert length_text(0.01234, metric=False) == "0.0123 units"
    assert area_text(2.5, metric=False) == "2.50 units²"
    assert length_text(None, metric=False) == "–"
