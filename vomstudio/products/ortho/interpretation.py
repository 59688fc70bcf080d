"""A project's features as they look on a plane: their lines, and the apparent dips of planes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.map_symbols import strike_and_dip
from vomstudio.geology.orientation import planes_to_normals
from vomstudio.project.exports.export import refuse_empty, thresholds_of
from vomstudio.project.journal.database import read_replay
from vomstudio.project.kind import color_of, kind_of
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, Record
from vomstudio.project.records.feature_types import DEFAULT_TYPES
from vomstudio.project.tables.grid_layer import LAYER as GRIDS
from vomstudio.project.tables.project_layers import project_layers
from vomstudio.project.tables.project_table import project_table

Form = Literal["point", "line", "ring"]

LEGEND = "legend"
PARTS = ("traces", "patches", "symbols", LEGEND)
"""What of an interpretation can be drawn: all that is a line, an area or a place; and what the
colours and symbols mean, on a sheet."""
_PART: dict[Form, str] = {"line": "traces", "ring": "patches", "point": "symbols"}

NO_COLOR = "#404040"
EDGE_ON_DEG = 1.0
"""A plane that is parallel to the picture within this has no trace on it: the direction of a trace
would be that of the plane's error."""
MAP_DEG = 10.0
"""A picture that is seen within this of the vertical is a map: it shows strike and dip, since the
trace of a plane on it is near the strike, whatever the dip."""


@dataclass(frozen=True, eq=False)
class Item:
    """A feature in World. form : of `points` (n, 3); normal : (3,) of a plane, upward, None of
    everything else; said : what is written beside it in place of its name; filled : the color is
    that of its area; overturned : of a bed, its younger side is below; domain : part of the
    structure; quality : verdict on a plane; each "" for none"""

    layer: str
    form: Form
    points: FloatArray
    id: str
    name: str
    kind: str
    set: str
    color: str
    normal: FloatArray | None = None
    dip_direction_deg: float | None = None
    dip_deg: float | None = None
    said: str = ""
    filled: bool = False
    overturned: bool = False
    domain: str = ""
    quality: str = ""


@dataclass(frozen=True, eq=False)
class Flat:
    """An item on a plane. points : (n, 2) metres right and up; away : (n,) metres from the plane
    toward the viewer; apparent_dip_deg : of a plane, -90 to 90 from the horizontal of the picture,
    positive where it goes down to the right, None where the plane is parallel to it and on a map;
    symbol : of a plane on a map, polylines (k, 2) about its place, right and up, 1 being half the
    length of the bar"""

    item: Item
    points: FloatArray
    away: FloatArray
    apparent_dip_deg: float | None
    symbol: tuple[FloatArray, ...] = ()


def parse_parts(text: str) -> tuple[str, ...]:
    """Of "traces,legend". Raises UsageError."""
    parts = tuple(dict.fromkeys(word.strip().lower() for word in text.split(",")))
    if unknown := [part for part in parts if part not in PARTS]:
        raise UsageError(
            Finding("option.not-a-choice", value=unknown[0], choices=tuple(PARTS)), field="--show"
        )
    if parts == (LEGEND,):
        raise UsageError(Finding("interpretation.legend-alone"), field="--show")
    return parts


def items_shown(items: tuple[Item, ...], parts: Collection[str]) -> tuple[Item, ...]:
    """Those that belong to one of these parts."""
    return tuple(item for item in items if _PART[item.form] in parts)


def read_items(folder: Path) -> tuple[Item, ...]:
    """All features of a project that have a place, which may be open in a window. Raises
    InputError where it is no project, or has none."""
    kept = read_replay(folder)
    refuse_empty(kept.records, folder)
    return items_of(kept.records, Measurements(thresholds_of(kept.settings)))


def items_of(records: Mapping[str, Record], measurements: Measurements) -> tuple[Item, ...]:
    table = project_table(records, measurements)
    colors, written = {}, {}
    for record in records.values():
        if isinstance(record, Feature):
            typed = kind_of(record).has_feature_type or bool(kind_of(record).tint(record))
            if kind_of(record).listed:
                written[record.id] = kind_of(record).drawing_label(record)
            colors[record.id] = (color_of(record, records) if typed else "") or NO_COLOR
    found: list[Item] = []
    for layer in project_layers(records, table, measurements):
        if layer.name == GRIDS:
            continue
        columns = layer.columns
        for k, shape in enumerate(layer.shapes):
            said = {name: values[k] for name, values in columns.items()}
            normal = dd = dip = None
            if layer.name == "planes" and math.isfinite(said["dip_deg"]):
                dd, dip = float(said["dip_direction_deg"]), float(said["dip_deg"])
                normal = planes_to_normals(dd, dip)
            text = {key: str(said.get(key) or "") for key in ("id", "name", "set")}
            text["kind"] = str(said.get(layer.by) or "")
            color = colors.get(text["id"], NO_COLOR)
            found.append(
                Item(
                    layer.name,
                    layer.kind,
                    shape,
                    **text,
                    color=color,
                    normal=normal,
                    dip_direction_deg=dd,
                    dip_deg=dip,
                    said=written.get(text["id"], ""),
                    filled=layer.by != "kind",
                    overturned=normal is not None and bool(said.get("overturned")),
                    domain=str(getattr(records.get(text["id"]), "domain", "")),
                    quality=str(said.get("quality") or ""),
                )
            )
    return tuple(found)


def count_features(items: Iterable[Item]) -> int:
    """A trace is an item for its line and one for its plane, and one feature all the same. What has
    no id of its own counts by itself."""
    by_layer: dict[str, Counter[str]] = {}
    for item in items:
        by_layer.setdefault(item.layer, Counter())[item.id] += 1
    most: Counter[str] = Counter()
    for counted in by_layer.values():
        most |= counted
    return most.total()


def items_of_table(places: FloatArray, rows: Sequence[Mapping[str, Any]]) -> tuple[Item, ...]:
    """Return the planes of an orientation table, in the colours of the default feature types.

    Parameters
    ----------
    places : (n, 3) float64
        World, metres.
    rows : sequence of mapping
        `id`, `dip_direction_deg`, `dip_deg`, and where known `name`, `kind`, `set`, `domain`,
        `overturned`.
    """
    colors = {each.name.casefold(): each.color for each in DEFAULT_TYPES}
    return tuple(
        Item(
            "planes",
            "point",
            np.asarray([place]),
            str(row["id"]),
            str(row.get("name") or row["id"]),
            str(row.get("kind") or ""),
            str(row.get("set") or ""),
            colors.get(str(row.get("kind") or "").casefold(), NO_COLOR),
            planes_to_normals(row["dip_direction_deg"], row["dip_deg"]),
            row["dip_direction_deg"],
            row["dip_deg"],
            overturned=bool(row.get("overturned")),
            domain=str(row.get("domain") or ""),
            quality=str(row.get("quality") or ""),
        )
        for place, row in zip(places, rows, strict=True)
    )


def apparent_dip_deg(normal: FloatArray, right: FloatArray, up: FloatArray) -> float | None:
    """Of a plane with this normal on a picture: the angle of the line in which it meets the picture
    from `right`, -90 to 90, positive where it goes down to the right.

    On a vertical picture that is the apparent dip, tan a = tan d sin b, with b between the
    plane's strike and the picture's.
    """
    # The line's components right and up are at right angles to the normal's.
    x, y = float(normal @ up), -float(normal @ right)
    if math.hypot(x, y) < math.sin(math.radians(EDGE_ON_DEG)):
        return None
    if x < 0 or (x == 0 and y > 0):
        x, y = -x, -y
    return math.degrees(math.atan2(-y, x)) + 0.0


def flattened(
    item: Item,
    origin: FloatArray,
    right: FloatArray,
    up: FloatArray,
    along: FloatArray | None = None,
) -> Flat | None:
    """An item projected onto the plane through `origin` that right and up span, at right angles or
    along the direction `along` (3,); None where the direction lies in the plane."""
    toward = np.cross(right, up)
    away = (item.points - origin) @ toward
    points = item.points - origin
    if along is not None:
        share = float(along @ toward)
        if abs(share) < 1e-6:
            return None
        points = points - (away / share)[:, None] * along
    flat = np.stack([points @ right, points @ up], axis=1)
    if item.normal is None or item.dip_deg is None:
        return Flat(item, flat, away, None)
    if is_map(toward):
        azimuth = item.dip_direction_deg or 0.0
        lines = strike_and_dip(np.zeros(3), azimuth, item.dip_deg, 2.0, item.overturned)
        across = np.stack([right, up], axis=1)
        return Flat(item, flat, away, None, tuple(line @ across for line in lines))
    return Flat(item, flat, away, apparent_dip_deg(item.normal, right, up))


def is_map(toward: FloatArray) -> bool:
    """Whether a picture with this normal (3,) is seen from so near above (or below) that it shows
    strikes and dips."""
    return abs(float(toward[2])) >= math.cos(math.radians(MAP_DEG)) - 1e-12
