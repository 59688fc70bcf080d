"""Selected traces as parallel beds, in words: how far apart they are, and whether two are one."""

from __future__ import annotations

from html import escape
from itertools import combinations

import numpy as np

from vomstudio.core.errors import GeometryError
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.beds.parallel import SIGNIFICANCE, ParallelBeds, SamePlane, parallel_beds
from vomstudio.geology.notation import format_attitude
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.units import length_text
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import get
from vomstudio.ui.base.number_formatting import degrees
from vomstudio.ui.base.studio import Studio

_MOST = 12
_LEAST_P = 0.001
_APART_DEG = 15.0
"""Between the planes of two traces that are of limbs, or of a bed and something else."""


def parallel_lines(studio: Studio) -> list[str]:
    """Rich text on the selected traces, where all are of one type; empty for others, and where
    together they determine no plane."""
    ids = list(studio.selection.ids)
    if not 2 <= len(ids) <= _MOST:
        return []
    beds = [t for id_ in ids if (t := get(studio.records, id_, Trace)) is not None]
    if len(beds) < len(ids) or len({t.type_id for t in beds}) > 1:
        return []
    measured = studio.measured(t.id for t in beds)
    if _far_apart([measured[t.id] for t in beds]):
        return []
    points = [measured[t.id].points for t in beds]
    offsets = np.cumsum([0, *map(len, points)])
    try:
        found = parallel_beds([t.id for t in beds], np.concatenate(points), offsets)
    except GeometryError:
        return []
    return _result_lines(studio, found, {t.id: t.name for t in beds})


def _far_apart(measured: list[Measurement]) -> bool:
    """Whether two that are known well enough for it run quite another way."""
    normals = [
        m.plane.normal()
        for m in measured
        if m.plane is not None and (m.max_confidence95_deg or 90.0) < _APART_DEG
    ]
    steepest = np.cos(np.radians(_APART_DEG))
    return any(abs(float(a @ b)) < steepest for a, b in combinations(normals, 2))


def _result_lines(studio: Studio, beds: ParallelBeds, names: dict[str, str]) -> list[str]:
    plane = Plane(beds.dip_direction_deg, beds.dip_deg)
    lines = [
        tr_n(
            "Fitted together as {count} parallel plane: <b>{plane}</b> (95 %; {smallest} at least)",
            "Fitted together as {count} parallel planes: <b>{plane}</b> (95 %; "
            "{smallest} at least)",
            len(names),
            plane=escape(
                format_attitude(plane, beds.max_confidence95_deg, studio.settings.notation)
            ),
            smallest=degrees(beds.min_confidence95_deg),
        )
    ]
    lines += [_of_two(each, names, metric=studio.metres_known()) for each in beds.same]
    return lines + [f"• {escape(str(warning))}" for warning in beds.warnings]


def _of_two(each: SamePlane, names: dict[str, str], *, metric: bool) -> str:
    p = tr("p &lt; 0.001") if each.p < _LEAST_P else tr("p = {p:.2g}", p=each.p)
    said = tr("two beds") if each.p < SIGNIFICANCE else tr("may be one bed")
    return tr(
        "From {first} up to {second}: {distance} ± {error} across (95 %); {said}, {p}",
        first=escape(names[each.first]),
        second=escape(names[each.second]),
        distance=length_text(each.distance_m, metric=metric),
        error=length_text(each.error95_m, 2, metric=metric),
        said=said,
        p=p,
    )
