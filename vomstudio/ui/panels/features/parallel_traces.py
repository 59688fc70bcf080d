"""Description of selected traces as parallel beds, with the distances between them."""

from __future__ import annotations

from html import escape
from itertools import combinations

import numpy as np

from vomstudio.core.errors import GeometryError
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.beds.parallel import SIGNIFICANCE, ParallelBeds, SamePlaneTest, parallel_beds
from vomstudio.geology.notation import format_attitude
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.units import length_text
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import get
from vomstudio.ui.base.number_formatting import format_error_deg
from vomstudio.ui.base.studio import Studio

MAX_TRACES = 12
MIN_P_VALUE = 0.001
MAX_ANGLE_DEG = 15.0
"""Maximum angle between the planes of traces that are treated as parallel beds."""


def describe_parallel_beds(studio: Studio) -> list[str]:
    """Describe the selected traces as parallel beds in rich text.

    The result is empty unless the selection consists of 2 to `MAX_TRACES` traces of one type that
    determine nearly parallel planes.
    """
    ids = list(studio.selection.ids)
    if not 2 <= len(ids) <= MAX_TRACES:
        return []
    traces = [t for id_ in ids if (t := get(studio.records, id_, Trace)) is not None]
    if len(traces) < len(ids) or len({t.type_id for t in traces}) > 1:
        return []
    measurements = studio.measured(t.id for t in traces)
    if _has_divergent_planes([measurements[t.id] for t in traces]):
        return []
    points = [measurements[t.id].points for t in traces]
    offsets = np.cumsum([0, *map(len, points)])
    try:
        beds = parallel_beds([t.id for t in traces], np.concatenate(points), offsets)
    except GeometryError:
        return []
    return _format_beds(studio, beds, {t.id: t.name for t in traces})


def _has_divergent_planes(measurements: list[Measurement]) -> bool:
    """Return whether any two planes differ by more than `MAX_ANGLE_DEG`.

    Planes whose 95 % error is unknown or not smaller than this angle are ignored.
    """
    normals = [
        m.plane.normal()
        for m in measurements
        if m.plane is not None and (m.max_confidence95_deg or 90.0) < MAX_ANGLE_DEG
    ]
    min_cosine = np.cos(np.radians(MAX_ANGLE_DEG))
    return any(abs(float(a @ b)) < min_cosine for a, b in combinations(normals, 2))


def _format_beds(studio: Studio, beds: ParallelBeds, names: dict[str, str]) -> list[str]:
    plane = Plane(beds.dip_direction_deg, beds.dip_deg)
    lines = [
        tr_n(
            "Joint fit of {count} parallel plane: <b>{plane}</b> (95 %; at least {smallest})",
            "Joint fit of {count} parallel planes: <b>{plane}</b> (95 %; at least {smallest})",
            len(names),
            plane=escape(
                format_attitude(plane, beds.max_confidence95_deg, studio.settings.notation)
            ),
            smallest=format_error_deg(beds.min_confidence95_deg),
        )
    ]
    lines += [_format_pair(pair, names, is_metric=studio.are_metres_known()) for pair in beds.same]
    return lines + [f"• {escape(str(warning))}" for warning in beds.warnings]


def _format_pair(pair: SamePlaneTest, names: dict[str, str], *, is_metric: bool) -> str:
    p = tr("p &lt; 0.001") if pair.p < MIN_P_VALUE else tr("p = {p:.2g}", p=pair.p)
    verdict = tr("two beds") if pair.p < SIGNIFICANCE else tr("may be one bed")
    return tr(
        "From {first} up to {second}: perpendicular distance {distance} ± {error} (95 %);"
        " {said}, {p}",
        first=escape(names[pair.first]),
        second=escape(names[pair.second]),
        distance=length_text(pair.distance_m, is_metric=is_metric),
        error=length_text(pair.error95_m, 2, is_metric=is_metric),
        said=verdict,
        p=p,
    )
