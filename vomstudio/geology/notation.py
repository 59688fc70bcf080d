"""Parse and format orientations in the notations used in field books.

Planes are formatted in one of the `NOTATIONS`:
    "dipdir/dip"   132/41        dip direction and dip
    "strike/dip"   042/41 RHR    strike by the right-hand rule, and dip
    "quadrant"     N42E 41SE     strike counted from North, dip and the quadrant of the dip

These notations and their usual variants are parsed: other separators (132-41, 132 41, 132°/41°);
the left-hand rule (222/41 LHR: the plane dips to the left); either end of the strike with the
quadrant of the dip (042/41 SE, 222/41 SE); N 42° E, 41° SE; S42W/41SE; E48N/41SE, counted from East
or West; E-W 30N; strike 042 dip 41 SE; the dip followed by an arrow (41 → 132). Lines are given as
trend/plunge (130/25, N50W 25) or as the plunge followed by an arrow (25 → 130). Decimal commas and
minutes (7°30') are accepted. Invalid or ambiguous texts raise InputError with the reason.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.vectors import wrap360

NOTATIONS = ("dipdir/dip", "strike/dip", "quadrant")
"""Output notations of planes."""

PAIR_NOTATIONS = (*NOTATIONS, "strike/dip lhr")
"""Interpretations of two plain numbers in `parse_plane`."""

_COMPASS_AZIMUTHS = {
    "N": 0.0,
    "NNE": 22.5,
    "NE": 45.0,
    "ENE": 67.5,
    "E": 90.0,
    "ESE": 112.5,
    "SE": 135.0,
    "SSE": 157.5,
    "S": 180.0,
    "SSW": 202.5,
    "SW": 225.0,
    "WSW": 247.5,
    "W": 270.0,
    "WNW": 292.5,
    "NW": 315.0,
    "NNW": 337.5,
}
_QUADRANT_SIDES = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
_ANGLE_LABELS = {
    "STRIKE": "strike",
    "STR": "strike",
    "DIP": "dip",
    "DIPDIR": "dipdir",
    "DD": "dipdir",
    "DIPDIRECTION": "dipdir",
    "TREND": "trend",
    "AZIMUTH": "azimuth",
    "PLUNGE": "plunge",
}
_HAND_RULES = {"RHR": "RHR", "RH": "RHR", "LHR": "LHR", "LH": "LHR"}
_ARROW_WORDS = {"->", "→", "=>", "⇒", "TO", "TOWARD", "TOWARDS"}
_FILLER_WORDS = {"AT", "AND", "DEG", "DEGREES", "DEGREE"}

_CHARACTER_REPLACEMENTS = str.maketrans(
    {
        "º": "°",
        "˚": "°",
        "∘": "°",
        "′": "'",
        "’": "'",
        "`": "'",
        "″": '"',
        "”": '"',
        "–": "-",
        "—": "-",
        "−": "-",
        "‐": "-",
        "‑": "-",
        "\u00a0": " ",
        "\u202f": " ",
        "(": " ",
        ")": " ",
        "[": " ",
        "]": " ",
    }
)

_TOKEN = re.compile(
    r"(?P<number>(?:\d+(?:[.,]\d+)?|[.]\d+))(?P<degree>\s*°)?"
    r"(?:\s*(?P<minutes>\d+(?:[.,]\d+)?)\s*')?(?:\s*(?P<seconds>\d+(?:[.,]\d+)?)\s*\")?"
    r"|(?P<arrow>->|→|=>|⇒)|(?P<word>[A-Z]+)|(?P<mark>[/;,:|\\_-])|(?P<other>\S)"
)

MAX_SIDE_ANGLE_DEG = {1: 80.0, 2: 55.0, 3: 45.0}
"""Maximum angle between a dip direction and the compass point of the dip side, by the number of
letters of that point. SE denotes a quadrant (45 degrees to both sides, plus 10 for a rounded
strike); E denotes a half circle, which must not be mistaken for the strike.
"""


@dataclass(frozen=True)
class _Token:
    """Number, bearing (N42E, with its azimuth as value), compass point, label, rule or arrow."""

    kind: str
    text: str
    value: float = 0.0
    comma_numbers: tuple[float, float] | None = None
    """The two numbers if the comma in a number may also be a separator."""
    is_signed: bool = False
    """Whether the number follows a hyphen that may be a minus sign."""


# Reading -------------------------------------------------------------------------------------


def format_exact_plane(plane: Plane) -> str:
    """Format a plane as dip direction/dip with all digits, for `parse_plane`.

    Parameters
    ----------
    plane : Plane

    Returns
    -------
    str
    """
    return _format_exact_angles(plane.dip_direction_deg, plane.dip_deg)


def format_exact_line(line: Line) -> str:
    """Format a line as trend/plunge with all digits, for `parse_line`.

    Parameters
    ----------
    line : Line

    Returns
    -------
    str
    """
    return _format_exact_angles(line.trend_deg, line.plunge_deg)


def _format_exact_angles(*angles_deg: float) -> str:
    return "/".join(np.format_float_positional(angle, trim="-") for angle in angles_deg)


def parse_plane(text: str, notation: str | None = None) -> Plane:
    """Parse a plane.

    Parameters
    ----------
    text : str
    notation : str, optional
        Interpretation of two plain numbers, one of `PAIR_NOTATIONS`; default "dipdir/dip". Explicit
        notations (RHR, LHR, a quadrant, a label, an arrow) have precedence.

    Returns
    -------
    Plane

    Raises
    ------
    InputError
        If the text is not a valid plane.
    ValueError
        If the notation is unknown.
    """
    convention = "dipdir/dip" if notation is None else notation
    if convention not in PAIR_NOTATIONS:
        raise ValueError(f"unknown notation {notation!r}; use one of {PAIR_NOTATIONS}")
    if text.strip().lower() == "horizontal":
        return Plane(0.0, 0.0)
    tokens = _tokenize(text)
    labels = {token.text for token in tokens if token.kind == "label"}
    if labels:
        if labels == {"strike", "dip"}:
            tokens, convention = _take_labelled_angles(text, tokens, "strike", "dip"), "strike/dip"
        elif labels == {"dipdir", "dip"}:
            tokens, convention = _take_labelled_angles(text, tokens, "dipdir", "dip"), "dipdir/dip"
        else:
            raise _notation_error("notation.not-a-plane", text)
    kinds = _token_kinds(tokens)
    if kinds == ["number"] or kinds in (["number", "wind"], ["number", "rule"]):
        tokens = _split_comma(tokens)
        kinds = _token_kinds(tokens)
    if any(token.is_signed for token in tokens[:1]):
        raise _notation_error("notation.signed-azimuth", text)

    match kinds:
        case ["number", "number"]:
            azimuth, dip = tokens
            if convention == "quadrant":
                raise _notation_error("notation.no-quadrant", text)
            return _build_plane(text, azimuth, dip, convention)
        case ["number", "number", "rule"]:
            azimuth, dip, rule = tokens
            rule_convention = "strike/dip" if rule.text == "RHR" else "strike/dip lhr"
            return _build_plane(text, azimuth, dip, rule_convention)
        case ["bearing", "number", "rule"]:
            strike, dip, rule = tokens
            rule_convention = "strike/dip" if rule.text == "RHR" else "strike/dip lhr"
            return _build_plane(text, strike, dip, rule_convention)
        case ["number" | "bearing" | "wind", "number", "wind"]:
            strike, dip, side = tokens
            if convention == "dipdir/dip" and "dipdir" in labels:
                raise _notation_error("notation.needless-quadrant", text)
            return _build_plane_with_side(text, strike, dip, side)
        case ["number" | "bearing" | "wind", "wind", "number"]:
            strike, side, dip = tokens
            return _build_plane_with_side(text, strike, dip, side)
        case ["number", "arrow", "number" | "bearing" | "wind"]:
            dip, _, azimuth = tokens
            return Plane(_azimuth(text, azimuth), _dip_or_plunge(text, dip, "dip"))
        case ["bearing" | "wind", "number"]:
            strike, dip = tokens
            if "dipdir" in labels:
                return Plane(_azimuth(text, strike), _dip_or_plunge(text, dip, "dip"))
            value = _dip_or_plunge(text, dip, "dip")
            if value in (0.0, 90.0):  # the only planes that dip to neither side
                return Plane.from_strike(_azimuth(text, strike), value)
            raise _notation_error("notation.no-quadrant", text)
        case ["number"] | ["bearing"]:
            raise _notation_error("notation.one-angle", text, example="132/41")
    raise _notation_error("notation.not-a-plane", text)


def parse_plane_option(text: str, field: str = "--plane") -> Plane:
    """Parse the plane of a command option, in the form dip direction/dip.

    Parameters
    ----------
    text : str
    field : str, optional
        Name of the option.

    Returns
    -------
    Plane

    Raises
    ------
    UsageError
        If the text is not a valid plane.
    """
    try:
        return parse_plane(text, "dipdir/dip")
    except InputError as error:
        raise UsageError(cause_finding(error), field=field) from error


def parse_line_option(text: str, field: str) -> Line:
    """Parse the line of a command option, in the form trend/plunge.

    Parameters
    ----------
    text : str
    field : str
        Name of the option.

    Returns
    -------
    Line

    Raises
    ------
    UsageError
        If the text is not a valid line.
    """
    try:
        return parse_line(text)
    except InputError as error:
        raise UsageError(cause_finding(error), field=field) from error


def parse_line(text: str) -> Line:
    """Parse a line; a negative plunge (130/-25) denotes a directed line that points up.

    Raises
    ------
    InputError
        If the text is not a valid line.
    """
    if text.strip().lower() == "vertical":
        return Line(0.0, 90.0)
    tokens = _tokenize(text)
    labels = {token.text for token in tokens if token.kind == "label"}
    if labels:
        azimuth_label = "azimuth" if "azimuth" in labels else "trend"
        if labels != {azimuth_label, "plunge"}:
            raise _notation_error("notation.not-a-line", text)
        tokens = _take_labelled_angles(text, tokens, azimuth_label, "plunge")
    if _token_kinds(tokens) == ["number"]:
        tokens = _split_comma(tokens)
    if any(token.is_signed for token in tokens[:1]) and "arrow" not in _token_kinds(tokens):
        raise _notation_error("notation.signed-azimuth", text)
    match _token_kinds(tokens):
        case ["number" | "bearing" | "wind", "number"]:
            trend, plunge = tokens
            return Line(_azimuth(text, trend), _dip_or_plunge(text, plunge, "plunge"))
        case ["number", "arrow", "number" | "bearing" | "wind"]:
            plunge, _, trend = tokens
            return Line(_azimuth(text, trend), _dip_or_plunge(text, plunge, "plunge"))
        case ["number", "bearing"]:
            plunge, trend = tokens
            return Line(_azimuth(text, trend), _dip_or_plunge(text, plunge, "plunge"))
        case ["number"] | ["bearing"]:
            raise _notation_error("notation.one-angle", text, example="130/25")
    raise _notation_error("notation.not-a-line", text)


def parse_azimuth(text: str) -> float:
    """Parse an azimuth such as 45°, N45E or NW.

    Parameters
    ----------
    text : str

    Returns
    -------
    float
        Degrees.

    Raises
    ------
    InputError
        If the text is not a valid azimuth.
    """
    tokens = _tokenize(text, is_azimuth=True)
    if _token_kinds(tokens) not in (["number"], ["bearing"], ["wind"]) or tokens[0].is_signed:
        raise _notation_error("notation.not-an-azimuth", text)
    return _azimuth(text, tokens[0])


def parse_rake(text: str, plane: Plane) -> float:
    """Parse a rake counted from a named end of the strike, as in field books (80SW).

    Parameters
    ----------
    text : str
        Angle from 0 to 90 degrees and the compass point of an end of the strike.
    plane : Plane

    Returns
    -------
    float
        Degrees from the right-hand-rule strike, 0 to 180.

    Raises
    ------
    InputError
        If the text is not a rake, the angle is over 90 degrees, or the compass point is at neither
        end of the strike.
    """
    tokens = _tokenize(text)
    if _token_kinds(tokens) != ["number", "wind"] or tokens[0].is_signed:
        raise _notation_error("notation.not-a-rake", text)
    angle, end = tokens
    if angle.value > 90.0:
        raise _notation_error("notation.rake-out-of-range", text, rake_deg=angle.value)
    distance = abs((end.value - plane.strike_rhr_deg + 180.0) % 360.0 - 180.0)
    if plane.undefined or min(distance, 180.0 - distance) > MAX_SIDE_ANGLE_DEG[len(end.text)]:
        raise _notation_error(
            "notation.not-an-end", text, end=end.text, strike_deg=plane.strike_rhr_deg
        )
    return angle.value if distance < 90.0 else 180.0 - angle.value


def parse_angle(text: str) -> float:
    """Parse an angle such as 7°30'.

    Parameters
    ----------
    text : str

    Returns
    -------
    float
        Degrees.

    Raises
    ------
    InputError
        If the text is not a valid angle.
    """
    tokens = _tokenize(text)
    if _token_kinds(tokens) != ["number"]:
        raise _notation_error("notation.not-an-angle", text)
    return -tokens[0].value if tokens[0].is_signed else tokens[0].value


def _notation_error(code: str, text: str, **values: float | str) -> InputError:
    return InputError(Finding(code, text=" ".join(text.split()), **values))


def _token_kinds(tokens: list[_Token]) -> list[str]:
    return [token.kind for token in tokens]


def _tokenize(text: str, *, is_azimuth: bool = False) -> list[_Token]:
    """Split a text into numbers, bearings, compass points, labels, rules and arrows.

    Separators are omitted.
    """
    if not text.strip():
        raise InputError(Finding("notation.empty"))
    raw_tokens: list[_Token] = []
    is_after_mark = True
    clean_text = text.translate(_CHARACTER_REPLACEMENTS).upper()
    for match in _TOKEN.finditer(clean_text):
        kind = str(match.lastgroup)
        matched_group = match.group(0)
        if match.group("number") is not None:
            token = _parse_number(match)
            if raw_tokens and raw_tokens[-1].kind == "mark" and raw_tokens[-1].text == "-":
                is_negative = match.start() > 0 and clean_text[match.start() - 1] == "-"
                prefix = clean_text[: match.start() - 1] if is_negative else ""
                if is_negative and is_after_mark:
                    raw_tokens.pop()
                    token = _Token("number", "-" + token.text, -token.value, is_signed=True)
                elif is_negative and prefix.endswith(" "):
                    token = _Token(
                        "number",
                        token.text,
                        token.value,
                        comma_numbers=token.comma_numbers,
                        is_signed=True,
                    )
            raw_tokens.append(token)
            is_after_mark = False
            continue
        if kind == "word":
            raw_tokens.extend(_parse_word(text, matched_group))
            is_after_mark = False
        elif kind == "arrow":
            raw_tokens.append(_Token("arrow", matched_group))
            is_after_mark = True
        elif kind == "mark":
            if matched_group != "-":
                is_after_mark = True
            raw_tokens.append(_Token("mark", matched_group))
        else:
            raise _notation_error("notation.unknown-word", text, word=matched_group)
    return _join_bearings(text, raw_tokens, is_azimuth=is_azimuth)


def _parse_number(match: re.Match[str]) -> _Token:
    digits = match.group("number")
    value = float(digits.replace(",", "."))
    for name, divisor in (("minutes", 60.0), ("seconds", 3600.0)):
        if match.group(name) is not None:
            value += float(match.group(name).replace(",", ".")) / divisor
    comma_numbers: tuple[float, float] | None = None
    if "," in digits and not match.group("degree"):
        left, right = digits.split(",")
        comma_numbers = (float(left), float(right))
    return _Token("number", digits, value, comma_numbers)


def _parse_word(text: str, word: str) -> list[_Token]:
    if word in _COMPASS_AZIMUTHS:
        return [_Token("wind", word, _COMPASS_AZIMUTHS[word])]
    if word in ("NS", "SN"):
        return [_Token("bearing", "N-S", 0.0)]
    if word in ("EW", "WE"):
        return [_Token("bearing", "E-W", 90.0)]
    if word in _HAND_RULES:
        return [_Token("rule", _HAND_RULES[word])]
    if word in _ARROW_WORDS:
        return [_Token("arrow", word)]
    if word in _FILLER_WORDS:
        return []
    if word in ("DIR", "DIRECTION"):
        return [_Token("label", "DIRECTION")]
    if word in _ANGLE_LABELS:
        return [_Token("label", _ANGLE_LABELS[word])]
    raise _notation_error("notation.unknown-word", text, word=word)


def _join_bearings(text: str, raw_tokens: list[_Token], *, is_azimuth: bool) -> list[_Token]:
    """Join tokens into bearings (N 42 E), strikes (NE - SW) and labels (dip direction)."""
    joined_tokens: list[_Token] = []
    i = 0
    while i < len(raw_tokens):
        token = raw_tokens[i]
        token_pair, token_triple = raw_tokens[i : i + 2], raw_tokens[i : i + 3]
        if token.kind == "label" and len(token_pair) == 2 and token_pair[1].text == "DIRECTION":
            joined_tokens.append(_Token("label", "dipdir"))
            i += 2
        elif (
            _token_kinds(token_triple) == ["wind", "mark", "wind"]
            and token_triple[1].text == "-"
            and abs(token_triple[0].value - token_triple[2].value) == 180.0
        ):
            joined_tokens.append(
                _Token(
                    "bearing",
                    f"{token.text}-{token_triple[2].text}",
                    min(token.value, token_triple[2].value),
                )
            )
            i += 3
        elif _token_kinds(token_triple) == ["wind", "number", "wind"] and (
            is_azimuth or _is_bearing(raw_tokens, i)
        ):
            angle = token_triple[1].value
            name = f"{token.text}{token_triple[1].text}{token_triple[2].text}"
            if not 0.0 <= angle <= 90.0:
                raise _notation_error("notation.bearing-out-of-range", text, bearing=name)
            is_clockwise = token.text + token_triple[2].text in ("NE", "ES", "SW", "WN")
            joined_tokens.append(
                _Token("bearing", name, wrap360(token.value + (angle if is_clockwise else -angle)))
            )
            i += 3
        elif token.kind == "mark":
            i += 1
        elif token.text == "DIRECTION":
            raise _notation_error("notation.lone-direction", text)
        else:
            joined_tokens.append(token)
            i += 1
    return joined_tokens


def _is_bearing(raw_tokens: list[_Token], first: int) -> bool:
    """Return whether a number between two compass points forms a bearing, such as N42E.

    On its own, E 30 N is a plane that strikes East; next to another angle, it is a bearing.
    """
    start, end = raw_tokens[first].text, raw_tokens[first + 2].text
    if start in ("N", "S"):
        return end in ("E", "W")
    other_tokens = [
        item for item in raw_tokens[:first] + raw_tokens[first + 3 :] if item.kind != "mark"
    ]
    return start in ("E", "W") and end in ("N", "S") and bool(other_tokens)


def _take_labelled_angles(text: str, tokens: list[_Token], first: str, second: str) -> list[_Token]:
    """Return the angles labelled `first` and `second`, followed by the other tokens."""
    values: dict[str, _Token] = {}
    other_tokens: list[_Token] = []
    label: str | None = None
    for token in tokens:
        if token.kind == "label":
            if label is not None or token.text in values:
                raise _notation_error("notation.no-number", text, label=label or token.text)
            label = token.text
        elif label is not None and token.kind in ("number", "bearing", "wind"):
            values[label] = token
            label = None
        else:
            other_tokens.append(token)
    if label is not None:
        raise _notation_error("notation.no-number", text, label=label)
    return [values[first], values[second], *other_tokens]


def _split_comma(tokens: list[_Token]) -> list[_Token]:
    """Split the only number, such as 132,41, at its comma if two numbers are needed."""
    comma_numbers = tokens[0].comma_numbers
    if comma_numbers is None:
        return tokens
    return [
        _Token("number", f"{comma_numbers[0]:g}", comma_numbers[0]),
        _Token("number", tokens[0].text.split(",")[1], comma_numbers[1]),
        *tokens[1:],
    ]


def _azimuth(text: str, token: _Token) -> float:
    if not 0.0 <= token.value <= 360.0:
        raise _notation_error("notation.azimuth-out-of-range", text, azimuth_deg=token.value)
    return token.value


def _dip_or_plunge(text: str, token: _Token, name: str) -> float:
    """Return a dip or plunge. Raises InputError if it is out of range."""
    value = token.value
    if token.is_signed and value > 0:
        raise _notation_error("notation.unclear-minus", text)
    if name == "dip" and value < 0:
        raise _notation_error("notation.signed-dip", text)
    if abs(value) > 90.0:
        if name == "dip":
            raise _notation_error("notation.dip-out-of-range", text, dip_deg=value)
        raise _notation_error("notation.plunge-out-of-range", text, plunge_deg=value)
    return value


def _build_plane(text: str, azimuth: _Token, dip: _Token, convention: str) -> Plane:
    azimuth_deg = _azimuth(text, azimuth)
    # In planes, a hyphen before the dip can only be a separator: 132 -41.
    unsigned_token = _Token("number", dip.text, dip.value) if dip.value >= 0 else dip
    dip_deg = _dip_or_plunge(text, unsigned_token, "dip")
    if convention == "dipdir/dip":
        return Plane(azimuth_deg, dip_deg)
    return Plane.from_strike(
        azimuth_deg if convention == "strike/dip" else azimuth_deg + 180.0, dip_deg
    )


def _build_plane_with_side(text: str, strike: _Token, dip: _Token, side: _Token) -> Plane:
    azimuth = _azimuth(text, strike)
    dip_deg = _dip_or_plunge(text, dip, "dip")
    offset = (side.value - azimuth - 90.0 + 180.0) % 360.0 - 180.0
    if dip_deg > 0.0 and min(abs(offset), 180.0 - abs(offset)) > MAX_SIDE_ANGLE_DEG[len(side.text)]:
        raise _notation_error("notation.other-side", text, strike=strike.text, side=side.text)
    return Plane(azimuth + 90.0 if abs(offset) < 90.0 else azimuth - 90.0, dip_deg)


# Writing -------------------------------------------------------------------------------------


def format_azimuth(azimuth_deg: float, decimals: int = 0) -> str:
    """Format an azimuth with three integer digits; values that round to 360 become 000.

    Parameters
    ----------
    azimuth_deg : float
    decimals : int, optional

    Returns
    -------
    str
    """
    text = _pad_number(wrap360(azimuth_deg), decimals, 3)
    return _pad_number(0.0, decimals, 3) if text.startswith("360") else text


def format_compass_point(azimuth_deg: float) -> str:
    """Format an azimuth as the nearest of the 16 compass points and degrees: SW (225).

    Parameters
    ----------
    azimuth_deg : float

    Returns
    -------
    str
    """
    whole_degrees = round(azimuth_deg) % 360
    point = min(
        _COMPASS_AZIMUTHS,
        key=lambda name: abs((_COMPASS_AZIMUTHS[name] - azimuth_deg + 180.0) % 360.0 - 180.0),
    )
    return f"{point} ({whole_degrees:03d})"


def format_plain_azimuth(azimuth_deg: float, decimals: int = 4) -> str:
    """Format an azimuth for a table cell; values that round to 360 become 0.

    Parameters
    ----------
    azimuth_deg : float
    decimals : int, optional

    Returns
    -------
    str
    """
    return f"{wrap360(round(azimuth_deg, decimals)):.{decimals}f}"


def format_plane(
    plane: Plane, notation: str = "dipdir/dip", decimals: int = 0, *, omit_hand_rule: bool = False
) -> str:
    """Format a plane with a fixed number of digits.

    Parameters
    ----------
    plane : Plane
    notation : str, optional
        One of `NOTATIONS`.
    decimals : int, optional
    omit_hand_rule : bool, optional
        Whether to omit "RHR" after strike/dip, for columns whose header already contains it.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If the notation is unknown.
    """
    dip = _pad_number(plane.dip_deg, decimals, 2)
    if notation == "dipdir/dip":
        return f"{format_azimuth(plane.dip_direction_deg, decimals)}/{dip}"
    if notation == "strike/dip":
        pair = f"{format_azimuth(plane.strike_rhr_deg, decimals)}/{dip}"
        return pair if omit_hand_rule else f"{pair} RHR"
    if notation == "quadrant":
        strike = float(format_azimuth(plane.strike_rhr_deg, decimals))
        side = _QUADRANT_SIDES[round((strike + 90.0) / 45.0) % 8]
        axis = strike % 180.0
        dips_east = axis <= 90.0
        angle = _pad_number(axis if dips_east else 180.0 - axis, decimals, 2)
        return f"N{angle}{'E' if dips_east else 'W'} {dip}{side}"
    raise ValueError(f"unknown notation {notation!r}; use one of {NOTATIONS}")


def format_line(line: Line, decimals: int = 0) -> str:
    """Format a line as trend/plunge with fixed digits; upward plunges are negative.

    Parameters
    ----------
    line : Line
    decimals : int, optional

    Returns
    -------
    str
    """
    return f"{format_azimuth(line.trend_deg, decimals)}/{_pad_number(line.plunge_deg, decimals, 2)}"


def format_attitude(
    attitude: Plane | Line,
    error95_deg: float | None,
    notation: str = "dipdir/dip",
    *,
    omit_hand_rule: bool = False,
) -> str:
    """Format a plane or line with its 95 % error, such as 318/39 ± 2.4°.

    Every measured attitude is formatted by this function. The error determines the number of
    digits.

    Parameters
    ----------
    attitude : Plane or Line
    error95_deg : float or None
        Total 95 % error. If None (unknown), the attitude is formatted without an error.
    notation : {"dipdir/dip", "strike/dip", "quadrant"}
        Notation of planes.
    omit_hand_rule : bool
        See `format_plane`.
    """
    decimals = attitude_decimals(error95_deg)
    text = (
        format_plane(attitude, notation, decimals, omit_hand_rule=omit_hand_rule)
        if isinstance(attitude, Plane)
        else format_line(attitude, decimals)
    )
    return text if error95_deg is None else f"{text} ± {format_error_deg(error95_deg)}"


def attitude_decimals(error95_deg: float | None) -> int:
    """Return the number of decimals that a 95 % error justifies, at most two.

    Parameters
    ----------
    error95_deg : float or None

    Returns
    -------
    int
    """
    if error95_deg is None or error95_deg >= 0.995:
        return 0
    return 1 if error95_deg >= 0.0995 else 2


def format_error_deg(value: float | None) -> str:
    """Format an error, or an angle of similar accuracy, with about two significant digits.

    Parameters
    ----------
    value : float or None
        Degrees; None is formatted as a dash.

    Returns
    -------
    str
    """
    if value is None:
        return "–"
    size = abs(value)
    decimals = 2 if size < 0.995 else 1 if size < 9.95 else 0
    return f"{value:.{decimals}f}°"


def _pad_number(value: float, decimals: int, digits: int) -> str:
    width = digits + (decimals + 1 if decimals else 0)
    text = f"{abs(value):0{width}.{decimals}f}"
    return f"-{text}" if value < 0 and float(text) != 0.0 else text
