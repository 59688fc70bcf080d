"""From files of traces, an area or scanlines to the figures of the map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vomstudio.errors import InputError, UsageError
from vomstudio.geology.fractures.network import Counted, Mapped, fracture_network
from vomstudio.geology.fractures.pieces import Shapes, circle_area, pieces_of
from vomstudio.geology.fractures.scanlines import in_ranges
from vomstudio.geology.fractures.windows import directions_of
from vomstudio.io.gis.drawn_layers import (
    DrawnLayer,
    drawn_lines,
    read_area,
    read_lines,
    same_frame,
)
from vomstudio.io.text.repeated_rows import repeats_left_out
from vomstudio.progress import Progress
from vomstudio.words import tr

SET_COLUMN = "set"
_REPEAT = "repeat_of"


@dataclass(frozen=True)
class FractureOrder:
    """What `vomstudio fractures` is asked: files, circle (x, y, radius in metres), the tolerance
    of nodes, the attribute that names sets or ranges of strikes, the cap of Terzaghi weights, the
    layer of the traces."""

    traces: Path | None
    area: Path | None = None
    circle: tuple[float, float, float] | None = None
    scanline: Path | None = None
    snap_m: float = 0.0
    set_column: str | None = None
    strikes: tuple[tuple[float, float], ...] = ()
    terzaghi_cap: float | None = None
    layer: str | None = None


def map_fractures(
    order: FractureOrder,
    *,
    lines: Shapes | None = None,
    counted: Counted | None = None,
    sets: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> Mapped:
    """lines : (n,) in place of the file of traces; counted : in place of that of the area or the
    scanline; sets : (n,) the set of each trace, in place of an attribute.
    Raises InputError, UsageError and GeometryError with the file that is to blame."""
    asked = [order.area, order.circle, order.scanline, counted]
    if sum(given is not None for given in asked) > 1:
        raise UsageError(tr("Give an area, a circle or a scanline: one of them."), field="--area")
    drawn = (
        drawn_lines(lines)
        if lines is not None or order.traces is None
        else read_lines(
            order.traces, order.layer, _attributes(order) if sets is None else (_REPEAT,), progress
        )
    )
    drawn = _first_picks(drawn)
    said = list(drawn.warnings)
    if order.circle is not None:
        counted = Counted(circle_area(*order.circle), circle=order.circle)
    elif order.area is not None:
        area, read = read_area(order.area, progress=progress)
        same_frame(drawn, read)
        said += read.warnings
        counted = Counted(area)
    elif order.scanline is not None:
        read = read_lines(order.scanline, progress=progress)
        same_frame(drawn, read)
        said += read.warnings
        counted = Counted(scanlines=read.shapes)
    if sets is None:
        sets = sets_of(drawn, order.set_column, order.strikes)
    elif lines is None or len(sets) != len(lines):
        raise UsageError(
            tr("Every trace needs its set: there are {count} sets.", count=len(sets)), field="by"
        )
    else:
        sets = [sets[i - 1] for i in drawn.feature]
    if progress is not None:
        progress.stage(tr("Analysing the fracture network"))
    return fracture_network(
        drawn.shapes,
        counted,
        sets=sets,
        snap_m=order.snap_m,
        terzaghi_cap=order.terzaghi_cap,
        warnings=said,
    )


def _attributes(order: FractureOrder) -> list[str]:
    """Of the traces, those that are asked for anything."""
    return [_REPEAT, SET_COLUMN, *([] if order.set_column is None else [order.set_column])]


def _first_picks(drawn: DrawnLayer) -> DrawnLayer:
    """Without lines that repeat another, as their attribute `repeat_of` says."""
    name = next((n for n in drawn.columns if n.casefold() == _REPEAT), None)
    if name is None:
        return drawn
    first = np.array([not word for word in drawn.column(name, name)], np.bool_)
    if first.all():
        return drawn
    if not first.any():
        raise InputError(
            tr("All lines repeat others, which are not in the layer."), file=drawn.path, field=name
        )
    return replace(
        drawn,
        shapes=drawn.shapes[first],
        feature=drawn.feature[first],
        columns={key: values[first] for key, values in drawn.columns.items()},
        warnings=(*drawn.warnings, repeats_left_out(int((~first).sum()))),
    )


def sets_of(
    drawn: DrawnLayer, column: str | None, strikes: Sequence[tuple[float, float]]
) -> list[str] | None:
    """(n,) the set of each trace by an attribute or by ranges of its strike; by neither: the
    attribute `set` where there is one, else None."""
    if strikes:
        x, y = directions_of(pieces_of(drawn.shapes)).T
        row = in_ranges(np.degrees(np.arctan2(x, y)) % 180.0, strikes)
        names = [f"{low:03g}-{high:03g}" for low, high in strikes]
        return ["" if i < 0 else names[i] for i in row]
    if column is not None:
        return drawn.column(column, "--set")
    if any(name.casefold() == SET_COLUMN for name in drawn.columns):
        return drawn.column(SET_COLUMN, "--set")
    return None


def parse_circle(text: str) -> tuple[float, float, float]:
    """X,Y,R as typed. Raises UsageError."""
    words = text.split(",")
    try:
        x, y, radius = (float(word) for word in words)
    except ValueError:
        x = y = radius = math.nan
    if not (math.isfinite(x) and math.isfinite(y) and 0 < radius < math.inf):
        raise UsageError(
            tr("“{text}” is no circle; write its centre and radius in metres like 10,20,5.",
               text=text),
            field="--circle",
        )  # fmt: skip
    return x, y, radius


def parse_strikes(text: str | None) -> tuple[tuple[float, float], ...]:
    """Ranges of strikes such as 340-020,060-100, clockwise. Raises UsageError."""
    found = []
    for part in [] if text is None else text.split(","):
        low, _, high = part.partition("-")
        try:
            pair = (float(low), float(high))
        except ValueError:
            pair = (math.nan, math.nan)
        if not all(0 <= end <= 360 for end in pair):
            raise UsageError(
                tr("“{text}” is no range of strikes; write them like 340-020,060-100.", text=part),
                field="--strikes",
            )
        found.append(pair)
    return tuple(found)
