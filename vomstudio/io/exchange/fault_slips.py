"""Fault slips for FaultKin and Win-Tensor.

- FaultKin (R. W. Allmendinger, R. A. Marrett, T. Cladouhos): tab-separated text with a header
  line: strike and dip of the fault by the right-hand rule, trend and plunge of the striae, and the
  sense of slip as two letters, T (thrust) or N (normal) and R (right-lateral) or L (left-lateral).
- Win-Tensor (D. Delvaux): tab-separated columns of its data sheet, into which they are pasted:
  format 11 (fault with striae), dip and dip direction, plunge and azimuth of the striae, sense N,
  I, S, D or X (unknown), confidence C, P, S or X.
"""

from __future__ import annotations

from collections.abc import Sequence

from vomstudio.geology.orientation import ANGLE_TOLERANCE_DEG, Plane
from vomstudio.io.exchange.columns import Row, delimited_text, label, round_angle

FAULTKIN_COLUMNS = ("strike", "dip", "trend", "plunge", "sense", "label")
WINTENSOR_COLUMNS = (
    "Id",
    "Format",
    "Dip",
    "DipDir",
    "Plunge",
    "Azimuth",
    "Sense",
    "Confidence",
    "Weight",
    "Comment",
)
FAULT_WITH_STRIAE_FORMAT = 11
_SENSE_CODES = {"normal": "N", "reverse": "I", "sinistral": "S", "dextral": "D"}
_CONFIDENCE_CODES = {"certain": "C", "probable": "P", "supposed": "S"}


def is_line_on_plane(row: Row) -> bool:
    """Return whether a row is a line on a known plane."""
    return row["element"] == "line" and row["on_plane_dip_deg"] is not None


def faultkin_table(rows: Sequence[Row]) -> str:
    """Return the table of lines on planes with a known direction of slip."""
    return delimited_text(FAULTKIN_COLUMNS, [_faultkin_row(row) for row in rows], "\t")


def _faultkin_row(row: Row) -> list[object]:
    plane = Plane(row["on_plane_dip_direction_deg"], row["on_plane_dip_deg"])
    return [
        round_angle(plane.strike_rhr_deg),
        round_angle(plane.dip_deg),
        round_angle(row["trend_deg"]),
        round_angle(row["plunge_deg"]),
        faultkin_sense(row["slip_rake_deg"]),
        label(row),
    ]


def faultkin_sense(slip_rake_deg: float) -> str:
    """Return the two letters for a directed rake.

    N is used if there is no dip-slip component, and L if there is no strike-slip component.
    """
    is_strike_slip = abs(slip_rake_deg) % 180.0 < ANGLE_TOLERANCE_DEG
    is_thrust = slip_rake_deg > 0.0 and not is_strike_slip
    is_right_lateral = abs(slip_rake_deg) > 90.0 + ANGLE_TOLERANCE_DEG
    return ("T" if is_thrust else "N") + ("R" if is_right_lateral else "L")


def wintensor_table(rows: Sequence[Row]) -> str:
    """Return the table of lines on planes; an unknown sense of slip is written as X."""
    return delimited_text(
        WINTENSOR_COLUMNS, [_wintensor_row(n, row) for n, row in enumerate(rows, 1)], "\t"
    )


def _wintensor_row(number: int, row: Row) -> list[object]:
    sense = _SENSE_CODES.get(row["slip_sense"] or "", "X")
    has_sense = sense != "X" and row["slip_rake_deg"] is not None
    return [
        number,
        FAULT_WITH_STRIAE_FORMAT,
        round_angle(row["on_plane_dip_deg"]),
        round_angle(row["on_plane_dip_direction_deg"]),
        round_angle(row["plunge_deg"]),
        round_angle(row["trend_deg"]),
        sense if has_sense else "X",
        _CONFIDENCE_CODES.get(row["slip_confidence"] or "", "X") if has_sense else "X",
        1,
        label(row),
    ]
