"""Conversion of DXF splines that only state the points through which they pass.

GDAL rejects a whole drawing because of one such spline. Therefore it reads a copy in which these
splines have the control points of the same curve: the cubic spline through the points, parametrised
by distance, with the stated end tangents (AutoCAD DXF Reference: SPLINE, groups 11, 12 and 13), or
otherwise with free ends or, if it is closed, a smooth seam.
"""

from __future__ import annotations

import contextlib
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.files.regular import read_small_file
from vomstudio.io.gis.dxf_groups import MAX_BYTES, DxfPiece, Groups, is_binary, text_pieces

_CLOSED_FLAG = 1
_SHAPE_CODES = frozenset(range(10, 14)) | frozenset(range(20, 24)) | frozenset(range(30, 34))
_SHAPE_CODES |= frozenset(range(40, 45)) | frozenset(range(70, 75))
"""Group codes of the geometry of a spline, as opposed to its layer, colour and direction."""
_FIRST_XDATA_CODE = 1000


@contextlib.contextmanager
def add_spline_control_points(path: Path) -> Iterator[Path]:
    """Yield the path of a drawing or of a temporary copy with control points.

    Raises
    ------
    InputError
        If the file is too large.
    OSError
        If the file cannot be read, or the copy cannot be written.
    """
    data = read_small_file(path, MAX_BYTES)
    changed_data = None if is_binary(data) or b"SPLINE" not in data else _add_control_points(data)
    if changed_data is None:
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="vomstudio-") as folder:
        copy = Path(folder) / "drawing.dxf"
        copy.write_bytes(changed_data)
        yield copy


def interpolate_spline(
    points: FloatArray,
    is_closed: bool,
    start: FloatArray | None = None,
    end: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Compute the cubic B-spline through points, parametrised by the distance along them.

    Each segment is a Bezier curve.

    Parameters
    ----------
    points : (n, 3) float
    is_closed : bool
    start, end : (3,) float, optional
        Tangents at the ends.

    Returns
    -------
    knots : (m + 4,) float
    control : (m, 3) float
        Control points.
    """
    from scipy.interpolate import CubicSpline

    if is_closed and (points[0] != points[-1]).any():
        points = np.vstack([points, points[:1]])
    distances = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], distances > 0.0])]
    if len(points) < 2:
        # A line without length is excluded and reported like other such lines.
        return np.repeat([0.0, 1.0], 4), np.repeat(points[:1], 4, axis=0)
    distance = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    ends = (
        "periodic"
        if is_closed and len(points) > 2
        else (_end_condition(start), _end_condition(end))
    )
    slopes = CubicSpline(distance, points, bc_type=ends)(distance, 1)
    third_steps = np.diff(distance)[:, None] / 3.0
    control = np.empty((3 * len(points) - 2, 3))
    control[0::3] = points
    control[1::3] = points[:-1] + third_steps * slopes[:-1]
    control[2::3] = points[1:] - third_steps * slopes[1:]
    return np.concatenate([distance[:1], np.repeat(distance, 3), distance[-1:]]), control


def _end_condition(tangent: FloatArray | None) -> tuple[int, FloatArray]:
    length = 0.0 if tangent is None else float(np.linalg.norm(tangent))
    if tangent is None or length == 0.0:
        return 2, np.zeros(3)
    return 1, tangent / length


def _add_control_points(data: bytes) -> bytes | None:
    """Return the drawing with control points added, or None if no spline needs them."""
    parts: list[bytes] = []
    copied_end = 0
    for piece in text_pieces(data):
        if piece.kind != b"SPLINE" or (groups := _control_groups(piece)) is None:
            continue
        start, end = piece.span
        parts += [data[copied_end:start], groups]
        copied_end = end
    return b"".join([*parts, data[copied_end:]]) if parts else None


def _control_groups(piece: DxfPiece) -> bytes | None:
    """Return the groups of a spline with control points, or None if not needed or invalid."""
    groups = piece.groups()
    codes = {code for code, _ in groups}
    if 11 not in codes or 10 in codes:
        return None
    try:
        points = _points(groups, 11)
        flags = int(next((value for code, value in groups if code == 70), 0))
        tangents = [_points(groups, code) if code in codes else None for code in (12, 13)]
        if not np.isfinite(points).all():
            return None
        knots, control = interpolate_spline(
            points,
            bool(flags & _CLOSED_FLAG),
            *(None if tangent is None else tangent[0] for tangent in tangents),
        )
    except ValueError:
        return None
    new_groups: Groups = [
        group for group in groups if group[0] not in _SHAPE_CODES and group[0] < _FIRST_XDATA_CODE
    ]
    new_groups += [
        (70, 8 | flags & _CLOSED_FLAG),
        (71, 3),
        (72, len(knots)),
        (73, len(control)),
        (74, 0),
    ]
    new_groups += [(40, repr(float(knot)).encode()) for knot in knots]
    for point in control:
        new_groups += [(10 * (k + 1), repr(float(value)).encode()) for k, value in enumerate(point)]
    lines = [
        str(code).encode() + b"\n" + (v if isinstance(v, bytes) else str(v).encode())
        for code, v in new_groups
    ]
    return b"\n".join(lines) + b"\n"


def _points(groups: Groups, first_code: int) -> FloatArray:
    """Return the points (n, 3) in the groups first, first + 10 and first + 20 (optional).

    Raises ValueError.
    """
    points: list[list[float]] = []
    for code, value in groups:
        if code == first_code:
            points.append([float(value), math.nan, 0.0])
        elif code in (first_code + 10, first_code + 20) and points:
            points[-1][(code - first_code) // 10] = float(value)
    return np.array(points, np.float64)
