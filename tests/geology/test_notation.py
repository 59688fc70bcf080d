"""Field-book notations: what is read, what is refused and why, and that printing comes back."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.messages import refused
from vomstudio.core.errors import InputError
from vomstudio.geology.notation import (
    NOTATIONS,
    format_azimuth,
    format_line,
    format_plane,
    parse_azimuth,
    parse_line,
    parse_plane,
    parse_rake,
)
from vomstudio.geology.orientation import (
    Line,
    Plane,
    angle_between_lines,
    angle_between_planes,
)

SAME_PLANE = [
    "132/41",
    "132-41",
    "132 41",
    "132 - 41",
    "132°/41°",
    "132º 41º",
    "(132/41)",
    "132;41",
    "132, 41",
    "132,41",
    "132,0/41,0",
    "132.0 41.0",
    "132\u00a041",
    "132–41",
    "132°0'/41°0'",
    "041->132",
    "41 → 132",
    "41° → S48E",
    "dip direction 132, dip 41",
    "DipDir 132 Dip 41",
    "dd: 132; dip: 41",
    "042/41 RHR",
    "042/41 rhr",
    "42 41 RH",
    "222/41 LHR",
    "042/41 SE",
    "042/41SE",
    "222/41 SE",
    "042,41 SE",
    "strike 042 dip 41",
    "strike 042 dip 41 SE",
    "strike 222, dip 41 SE",
    "N42E 41SE",
    "N42E41SE",
    "N 42° E, 41° SE",
    "S42W/41SE",
    "E48N 41SE",
    "W48S / 41 SE",
    "n42e / 41 se",
    "N42E 41 S",
    "N42E 41 E",
    "N42E 41 SSE",
    "N42E/41 RHR",
    "N42E at 41 SE",
]


@pytest.mark.parametrize("text", SAME_PLANE)
def test_common_notations_of_one_plane_parse_alike(text: str) -> None:
    plane = parse_plane(text)
    assert plane.dip_direction_deg == pytest.approx(132)
    assert plane.dip_deg == pytest.approx(41)


@pytest.mark.parametrize(
    ("text", "dip_direction", "dip"),
    [
        ("E-W 30N", 0, 30),
        ("W-E 30 N", 0, 30),
        ("EW 30S", 180, 30),
        ("N-S 45E", 90, 45),
        ("NS/45W", 270, 45),
        ("NE-SW 30 SE", 135, 30),
        ("N90E 5N", 0, 5),
        ("N0E 45E", 90, 45),
        ("N30W 60NE", 60, 60),
        ("S30E 60SW", 240, 60),
        ("360/45", 0, 45),
        ("7°30'/41°15'", 7.5, 41.25),
        ("132,5/41,25", 132.5, 41.25),
        ("N42E 90", 132, 90),
        ("E10N 30S", 170, 30),
        ("E10N/30N", 350, 30),
        ("W30N 40NE", 30, 40),
        ("strike W10S dip 20 S", 170, 20),
        ("41 → E48S", 138, 41),
        ("E 30 N", 0, 30),
        ("horizontal", 0, 0),
        ("000/00", 0, 0),
    ],
)
def test_other_plane_notations_parse(text: str, dip_direction: float, dip: float) -> None:
    assert parse_plane(text) == Plane(dip_direction, dip)


def test_bare_numbers_use_default_notation_but_explicit_notation_wins() -> None:
    assert parse_plane("042/41", "strike/dip") == Plane(132, 41)
    assert parse_plane("222/41", "strike/dip lhr") == Plane(132, 41)
    assert parse_plane("042/41 RHR", "dipdir/dip") == Plane(132, 41)
    assert parse_plane("222/41 LHR", "strike/dip") == Plane(132, 41)
    assert parse_plane("41 → 132", "strike/dip") == Plane(132, 41)


@pytest.mark.parametrize(
    ("text", "code", "values"),
    [
        ("", "empty", {}),
        ("   ", "empty", {}),
        ("132", "one-angle", {"example": "132/41"}),
        ("N42E", "one-angle", {"example": "132/41"}),
        ("132/41/20", "not-a-plane", {}),
        ("41/132", "dip-out-of-range", {"dip_deg": 132.0}),
        ("132 → 41", "dip-out-of-range", {"dip_deg": 132.0}),
        ("400/20", "azimuth-out-of-range", {"azimuth_deg": 400.0}),
        ("-10/30", "signed-azimuth", {}),
        ("132/-41", "signed-dip", {}),
        ("N100E 20SE", "bearing-out-of-range", {"bearing": "N100E"}),
        ("N42E 41", "no-quadrant", {}),
        ("N42E 41NE", "other-side", {"strike": "N42E", "side": "NE"}),
        ("132/41 SE", "other-side", {"strike": "132", "side": "SE"}),
        ("042/41 XY", "unknown-word", {"word": "XY"}),
        ("042/41 right", "unknown-word", {"word": "RIGHT"}),
        ("abc", "unknown-word", {"word": "ABC"}),
        ("nan/41", "unknown-word", {"word": "NAN"}),
        ("1e3/41", "not-a-plane", {}),
        ("132/41?", "unknown-word", {"word": "?"}),
        ("strike 042", "not-a-plane", {}),
        ("strike dip 042 41", "no-number", {"label": "strike"}),
        ("trend 130 plunge 25", "not-a-plane", {}),
        ("dip direction 132 dip 41 SE", "needless-quadrant", {}),
    ],
)
def test_invalid_plane_text_is_rejected_with_reason(
    text: str, code: str, values: dict[str, object]
) -> None:
    with refused(f"notation.{code}", **values) as refusal:
        parse_plane(text)
    # What was written is named.
    assert text.strip() in refusal.value.message


ROSE = (
    "N",
    "NNE",
    "NE",
    "ENE",
    "E",
    "ESE",
    "SE",
    "SSE",
    "S",
    "SSW",
    "SW",
    "WSW",
    "W",
    "WNW",
    "NW",
    "NNW",
)


@pytest.mark.parametrize("number", range(16))
def test_compass_points_parse_as_azimuths(number: int) -> None:
    assert parse_line(f"{ROSE[number]} 30") == Line(22.5 * number, 30)
    opposite = ROSE[(number + 8) % 16]
    strike = parse_plane(f"{ROSE[number]}-{opposite} 90")
    assert strike.strike_rhr_deg == min(22.5 * number, 22.5 * ((number + 8) % 16))


@pytest.mark.parametrize(("side", "reach"), [("E", 80), ("SE", 55), ("ESE", 45), ("N", 80)])
def test_plane_dips_toward_named_side_within_its_angular_range(side: str, reach: float) -> None:
    """A half for one letter, a quadrant for two, less for three; the strike itself is no side."""
    toward = 22.5 * ROSE.index(side)
    for off in range(-reach + 1, reach, 7):  # type: ignore[call-overload]
        dip_direction = (toward + off) % 360
        for strike in ((dip_direction + 90) % 360, (dip_direction - 90) % 360):
            plane = parse_plane(f"{strike:g}/41 {side}")
            assert plane.dip_direction_deg == pytest.approx(dip_direction)
    for off in (-reach - 1, reach + 1):
        strike = (toward + off + 90) % 360
        with refused("notation.other-side", side=side):
            parse_plane(f"{strike:g}/41 {side}")
        assert parse_plane(f"{strike:g}/00 {side}").undefined  # level planes dip nowhere


def test_bare_number_pair_is_rejected_if_quadrant_is_required() -> None:
    with refused("notation.no-quadrant", text="042/41"):
        parse_plane("042/41", "quadrant")


@pytest.mark.parametrize(
    ("text", "trend", "plunge"),
    [
        ("130/25", 130, 25),
        ("130-25", 130, 25),
        ("130° 25°", 130, 25),
        ("25 → 130", 130, 25),
        ("25->130", 130, 25),
        ("25 toward S50E", 130, 25),
        ("N30E 25", 30, 25),
        ("25 N30E", 30, 25),
        ("S20W/30", 200, 30),
        ("NE 30", 45, 30),
        ("130,5/25,5", 130.5, 25.5),
        ("130,25", 130, 25),
        ("130/-25", 130, -25),
        ("-25 → 130", 130, -25),
        ("trend 130 plunge 25", 130, 25),
        ("plunge 25, trend 130", 130, 25),
        ("vertical", 0, 90),
    ],
)
def test_common_line_notations_parse(text: str, trend: float, plunge: float) -> None:
    assert parse_line(text) == Line(trend, plunge)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("130", "one-angle"),
        ("130/95", "plunge-out-of-range"),
        ("130 -25", "unclear-minus"),
        ("25/130", "plunge-out-of-range"),
        ("130/25 SE", "not-a-line"),
        ("", "empty"),
        ("strike 10 dip 20", "not-a-line"),
    ],
)
def test_invalid_line_text_is_rejected_with_reason(text: str, code: str) -> None:
    with refused(f"notation.{code}") as refusal:
        parse_line(text)
    assert refusal.value.values.get("text", "") == text


def test_planes_print_with_fixed_digits() -> None:
    plane = Plane(2.34, 5.06)
    assert format_plane(plane) == "002/05"
    assert format_plane(plane, decimals=1) == "002.3/05.1"
    assert format_plane(plane, "strike/dip", 1) == "272.3/05.1 RHR"
    assert format_plane(plane, "strike/dip", omit_hand_rule=True) == "272/05"
    assert format_plane(plane, "quadrant") == "N88W 05N"
    assert format_plane(Plane(132, 41), "quadrant") == "N42E 41SE"
    assert format_line(Line(5, 7)) == "005/07"


@pytest.mark.parametrize(
    ("azimuth", "decimals", "text"),
    [(359.96, 1, "000.0"), (359.94, 1, "359.9"), (359.6, 0, "000"), (-1e-12, 2, "000.00")],
)
def test_azimuths_rounding_to_360_are_formatted_as_zero(
    azimuth: float, decimals: int, text: str
) -> None:
    assert format_azimuth(azimuth, decimals) == text


def test_plunge_rounding_to_zero_has_no_minus_sign() -> None:
    assert format_line(Line(10, -0.04), 1) == "010.0/00.0"
    assert format_line(Line(10, -3.06), 1) == "010.0/-03.1"


@given(st.floats(0, 360), st.floats(0, 90), st.sampled_from(NOTATIONS), st.integers(0, 4))
@example(359.996, 90.0, "quadrant", 2)
@example(90.0, 0.3, "quadrant", 0)
@example(0.5, 89.5, "quadrant", 0)
def test_formatted_plane_round_trips(azimuth: float, dip: float, name: str, decimals: int) -> None:
    plane = Plane(azimuth, dip)
    text = format_plane(plane, name, decimals)
    back = parse_plane(text)
    assert angle_between_planes(plane, back) <= 1.01 * 10.0**-decimals
    assert format_plane(back, name, decimals) == text or back.undefined
    assert len(text) == len(format_plane(Plane(132, 41), name, decimals)) or name == "quadrant"


@given(st.floats(0, 360), st.floats(-90, 90), st.integers(0, 4))
def test_formatted_line_round_trips(trend: float, plunge: float, decimals: int) -> None:
    line = Line(trend, plunge)
    back = parse_line(format_line(line, decimals))
    assert angle_between_lines(line, back, is_directed=True) <= 1.01 * 10.0**-decimals


@given(st.text(max_size=20))
def test_arbitrary_text_parses_or_raises_input_error(text: str) -> None:
    for parse in (parse_plane, parse_line):
        with contextlib.suppress(InputError):
            assert parse(text) is not None


@given(st.text(alphabet="NSEWnsew0123456789 .,/-°'→>RHLdip", max_size=16))
def test_near_miss_text_parses_or_raises_input_error(text: str) -> None:
    for parse in (parse_plane, parse_line):
        with contextlib.suppress(InputError):
            assert parse(text) is not None


@pytest.mark.parametrize(
    ("text", "azimuth"), [("E10N", 80), ("W30N", 300), ("W10S", 260), ("E0S", 90), ("N10E", 10)]
)
def test_azimuths_can_be_measured_from_any_compass_point(text: str, azimuth: float) -> None:
    assert parse_azimuth(text) == azimuth
    assert parse_line(f"{text} 25") == Line(azimuth, 25)


@pytest.mark.parametrize(("text", "rake"), [("80NE", 80), ("80 E", 80), ("80SW", 100), ("0S", 180)])
def test_rake_is_measured_from_the_named_strike_end(text: str, rake: float) -> None:
    assert parse_rake(text, Plane(132, 41)) == rake


@pytest.mark.parametrize("text", ["80", "80SE", "95NE", "-10E", "80X", "E"])
def test_rake_measured_from_direction_off_strike_is_rejected(text: str) -> None:
    with pytest.raises(InputError):
        parse_rake(text, Plane(132, 41))
