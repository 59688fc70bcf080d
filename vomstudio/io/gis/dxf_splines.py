"""Splines of drawings for CAD that state only the points that they go through.

GDAL refuses a whole drawing for one of them. What it is given instead is a copy in which these have
the control points of the same curve: the cubic spline through the points by their distances, with
the tangents at its ends that are stated (AutoCAD DXF Reference: SPLINE, groups 11, 12 and 13), and
free ends or, where it is closed, a smooth seam otherwise.
"""

from __future__ import annotations

import contextlib
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.files.regular import read_small
from vomstudio.io.gis.dxf_groups import LARGEST, DxfPiece, Groups, is_binary, text_pieces

_CLOSED = 1
_SHAPE = frozenset(range(10, 14)) | frozenset(range(20, 24)) | frozenset(range(30, 34))
_SHAPE |= frozenset(range(40, 45)) | frozenset(range(70, 75))
"""Codes that say how a spline runs. Its layer, colour and direction have others."""
_XDATA = 1000


@contextlib.contextmanager
def with_control_points(path: Path) -> Iterator[Path]:
    """The drawing itself, or a copy of it that is there as long as this lasts. Raises InputError
    where it is too large, OSError."""
    data = read_small(path, LARGEST)
    changed = None if is_binary(data) or b"SPLINE" not in data else _changed(data)
    if changed is None:
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="vomstudio-") as folder:
        copy = Path(folder) / "drawing.dxf"
        copy.write_bytes(changed)
        yield copy


def curve_through(
    points: FloatArray, closed: bool, start: FloatArray | None = None, end: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Knots and control points of the cubic B-spline through points (n, 3), whose parameter is the
    distance along them; each of its pieces is a Bezier curve. start, end : tangents there."""
    from scipy.interpolate import CubicSpline

    if closed and (points[0] != points[-1]).any():
        points = np.vstack([points, points[:1]])
    apart = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], apart > 0.0])]
    if len(points) < 2:
        # A line without length, which is left out and told as others are.
        return np.repeat([0.0, 1.0], 4), np.repeat(points[:1], 4, axis=0)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    ends = "periodic" if closed and len(points) > 2 else (_end(start), _end(end))
    slopes = CubicSpline(along, points, bc_type=ends)(along, 1)
    third = np.diff(along)[:, None] / 3.0
    control = np.empty((3 * len(points) - 2, 3))
    control[0::3] = points
    control[1::3] = points[:-1] + third * slopes[:-1]
    control[2::3] = points[1:] - third * slopes[1:]
    return np.concatenate([along[:1], np.repeat(along, 3), along[-1:]]), control


def _end(tangent: FloatArray | None) -> tuple[int, FloatArray]:
    length = 0.0 if tangent is None else float(np.linalg.norm(tangent))
    if tangent is None or length == 0.0:
        return 2, np.zeros(3)
    return 1, tangent / length


def _changed(data: bytes) -> bytes | None:
    """None where nothing is to be changed."""
    parts: list[bytes] = []
    done = 0
    for piece in text_pieces(data):
        if piece.kind != b"SPLINE" or (groups := _with_control(piece)) is None:
            continue
        begin, end = piece.span
        parts += [data[done:begin], groups]
        done = end
    return b"".join([*parts, data[done:]]) if parts else None


def _with_control(piece: DxfPiece) -> bytes | None:
    """Its groups anew; None where it has control points, or its points make no sense."""
    groups = piece.groups()
    codes = {code for code, _ in groups}
    if 11 not in codes or 10 in codes:
        return None
    try:
        points = _places(groups, 11)
        flags = int(next((value for code, value in groups if code == 70), 0))
        tangents = [_places(groups, code) if code in codes else None for code in (12, 13)]
        if not np.isfinite(points).all():
            return None
        knots, control = curve_through(
            points, bool(flags & _CLOSED), *(None if t is None else t[0] for t in tangents)
        )
    except ValueError:
        return None
    kept: Groups = [g for g in groups if g[0] not in _SHAPE and g[0] < _XDATA]
    kept += [(70, 8 | flags & _CLOSED), (71, 3), (72, len(knots)), (73, len(control)), (74, 0)]
    kept += [(40, repr(float(knot)).encode()) for knot in knots]
    for place in control:
        kept += [(10 * (k + 1), repr(float(value)).encode()) for k, value in enumerate(place)]
    lines = [
        str(code).encode() + b"\n" + (v if isinstance(v, bytes) else str(v).encode())
        for code, v in kept
    ]
    return b"\n".join(lines) + b"\n"


def _places(groups: Groups, first: int) -> FloatArray:
    """(n, 3) of the groups first, first + 10 and first + 20, the last of which may lack. Raises
    ValueError."""
    found: list[list[float]] = []
    for code, value in groups:
        if code == first:
            found.append([float(value), math.nan, 0.0])
        elif code in (first + 10, first + 20) and found:
            found[-1][(code - first) // 10] = float(value)
    return np.array(found, np.float64)
