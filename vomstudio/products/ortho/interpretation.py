"""Projection of project features onto a plane: lines, and apparent dips of planes."""

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
from vomstudio.geology.map_symbols import strike_and_dip_symbol
from vomstudio.geology.orientation import planes_to_normals
from vomstudio.project.exports.export import get_thresholds, refuse_empty
from vomstudio.project.journal.database import read_replay
from vomstudio.project.kind import get_color, get_kind
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, Record
from vomstudio.project.records.feature_types import DEFAULT_TYPES
from vomstudio.project.tables.grid_layer import LAYER as GRIDS
from vomstudio.project.tables.project_layers import project_layers
from vomstudio.project.tables.project_table import project_table

Form = Literal["point", "line", "ring"]

LEGEND = "legend"
PARTS = ("traces", "patches", "symbols", LEGEND)
"""Parts of an interpretation: lines, areas, point symbols, and the legend of a sheet."""
_PART_BY_FORM: dict[Form, str] = {"line": "traces", "ring": "patches", "point": "symbols"}

DEFAULT_COLOR = "#404040"
MIN_PLANE_ANGLE_DEG = 1.0
"""Minimum angle between a plane and the picture at which the plane has a trace.

At smaller angles, the direction of the trace would depend only on the error of the plane."""
MAX_MAP_ANGLE_DEG = 10.0
"""Maximum angle between the view and the vertical at which a picture counts as a map.

A map shows strike and dip, since the trace of a plane is close to its strike whatever its dip."""


@dataclass(frozen=True, eq=False)
class Item:
    """Feature in the World frame.

    Parameters
    ----------
    layer : str
    form : {"point", "line", "ring"}
    points : (n, 3) array
    id, name, kind, set, color : str
    normal : (3,) array or None
        Upward normal of a plane.
    dip_direction_deg, dip_deg : float or None
    symbol_label : str
        Label that replaces the name.
    is_filled : bool
        Whether the colour fills the area.
    overturned : bool
        Whether the bed is overturned, with its younger side below.
    domain : str
        Domain of the structure to which the feature belongs; "" if it has no domain.
    quality : str
        Verdict on the plane; "" if it has not been judged.
    """

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
    symbol_label: str = ""
    is_filled: bool = False
    overturned: bool = False
    domain: str = ""
    quality: str = ""


@dataclass(frozen=True, eq=False)
class ProjectedItem:
    """Item projected onto a plane.

    Parameters
    ----------
    item : Item
    points : (n, 2) array
        Coordinates to the right and up, m.
    distance : (n,) array
        Distance from the plane towards the viewer, m.
    apparent_dip_deg : float or None
        Apparent dip of a plane from the horizontal of the picture, -90 to 90, positive down to the
        right. None on maps, and if the item is not a plane or is parallel to the picture.
    symbol : tuple of (k, 2) arrays
        Map symbol of a plane as polylines (right, up) relative to its position, in units of half
        the length of the bar.
    """

    item: Item
    points: FloatArray
    distance: FloatArray
    apparent_dip_deg: float | None
    symbol: tuple[FloatArray, ...] = ()


def parse_parts(text: str) -> tuple[str, ...]:
    """Parse a list of parts such as "traces,legend".

    Raises
    ------
    UsageError
        If a part is unknown, or if the legend is the only part.
    """
    parts = tuple(dict.fromkeys(word.strip().lower() for word in text.split(",")))
    if unknown_parts := [part for part in parts if part not in PARTS]:
        raise UsageError(
            Finding("option.not-a-choice", value=unknown_parts[0], choices=tuple(PARTS)),
            field="--show",
        )
    if parts == (LEGEND,):
        raise UsageError(Finding("interpretation.legend-alone"), field="--show")
    return parts


def select_items(items: tuple[Item, ...], parts: Collection[str]) -> tuple[Item, ...]:
    """Return the items that belong to any of the parts."""
    return tuple(item for item in items if _PART_BY_FORM[item.form] in parts)


def read_items(folder: Path) -> tuple[Item, ...]:
    """Read the features of a project that have a position.

    Raises
    ------
    InputError
        If the folder is not a project, or if the project has no features.
    """
    replay = read_replay(folder)
    refuse_empty(replay.records, folder)
    return items_from_records(replay.records, Measurements(get_thresholds(replay.settings)))


def items_from_records(
    records: Mapping[str, Record], measurements: Measurements
) -> tuple[Item, ...]:
    """Return the features of a project to draw on a picture."""
    table = project_table(records, measurements)
    colors, labels_by_id = {}, {}
    for record in records.values():
        if isinstance(record, Feature):
            has_type = get_kind(record).has_feature_type or bool(get_kind(record).tint(record))
            if get_kind(record).listed:
                labels_by_id[record.id] = get_kind(record).drawing_label(record)
            colors[record.id] = (get_color(record, records) if has_type else "") or DEFAULT_COLOR
    items: list[Item] = []
    for layer in project_layers(records, table, measurements):
        if layer.name == GRIDS:
            continue
        columns = layer.columns
        for k, shape in enumerate(layer.shapes):
            row_values = {name: values[k] for name, values in columns.items()}
            normal = dd = dip = None
            if layer.name == "planes" and math.isfinite(row_values["dip_deg"]):
                dd, dip = float(row_values["dip_direction_deg"]), float(row_values["dip_deg"])
                normal = planes_to_normals(dd, dip)
            text = {key: str(row_values.get(key) or "") for key in ("id", "name", "set")}
            text["kind"] = str(row_values.get(layer.by) or "")
            color = colors.get(text["id"], DEFAULT_COLOR)
            items.append(
                Item(
                    layer.name,
                    layer.kind,
                    shape,
                    **text,
                    color=color,
                    normal=normal,
                    dip_direction_deg=dd,
                    dip_deg=dip,
                    symbol_label=labels_by_id.get(text["id"], ""),
                    is_filled=layer.by != "kind",
                    overturned=normal is not None and bool(row_values.get("overturned")),
                    domain=str(getattr(records.get(text["id"]), "domain", "")),
                    quality=str(row_values.get("quality") or ""),
                )
            )
    return tuple(items)


def count_features(items: Iterable[Item]) -> int:
    """Count the features of items.

    Items of one feature on several layers, such as the line and the plane of a trace, count once.
    """
    counters: dict[str, Counter[str]] = {}
    for item in items:
        counters.setdefault(item.layer, Counter())[item.id] += 1
    largest_counts: Counter[str] = Counter()
    for counter in counters.values():
        largest_counts |= counter
    return largest_counts.total()


def items_from_table(positions: FloatArray, rows: Sequence[Mapping[str, Any]]) -> tuple[Item, ...]:
    """Return the planes of an orientation table, in the colours of default feature types.

    Parameters
    ----------
    positions : (n, 3) float64
        Positions in the World frame, m.
    rows : sequence of mapping
        Mappings with `id`, `dip_direction_deg`, `dip_deg` and, if known, `name`, `kind`, `set`,
        `domain`, `quality` and `overturned`.
    """
    colors = {item.name.casefold(): item.color for item in DEFAULT_TYPES}
    return tuple(
        Item(
            "planes",
            "point",
            np.asarray([position]),
            str(row["id"]),
            str(row.get("name") or row["id"]),
            str(row.get("kind") or ""),
            str(row.get("set") or ""),
            colors.get(str(row.get("kind") or "").casefold(), DEFAULT_COLOR),
            planes_to_normals(row["dip_direction_deg"], row["dip_deg"]),
            row["dip_direction_deg"],
            row["dip_deg"],
            overturned=bool(row.get("overturned")),
            domain=str(row.get("domain") or ""),
            quality=str(row.get("quality") or ""),
        )
        for position, row in zip(positions, rows, strict=True)
    )


def apparent_dip_deg(normal: FloatArray, right: FloatArray, up: FloatArray) -> float | None:
    """Return the apparent dip of a plane on a picture.

    This is the angle between `right` and the intersection, -90 to 90, positive down to the right.
    On a vertical picture, the apparent dip a is given by tan a = tan d sin b, where d is the dip of
    the plane and b the angle between the strikes of the plane and the picture.

    Parameters
    ----------
    normal, right, up : (3,) arrays

    Returns
    -------
    float or None
        Apparent dip in degrees, or None if the plane is parallel to the picture.
    """
    # In the picture, the intersection is perpendicular to the projected normal.
    x, y = float(normal @ up), -float(normal @ right)
    if math.hypot(x, y) < math.sin(math.radians(MIN_PLANE_ANGLE_DEG)):
        return None
    if x < 0 or (x == 0 and y > 0):
        x, y = -x, -y
    return math.degrees(math.atan2(-y, x)) + 0.0


def project_item(
    item: Item,
    origin: FloatArray,
    right: FloatArray,
    up: FloatArray,
    direction: FloatArray | None = None,
) -> ProjectedItem | None:
    """Project an item onto the plane through `origin` that is spanned by `right` and `up`.

    The projection is perpendicular to the plane, or along `direction` (3,). Returns None
    if this direction lies in the plane.
    """
    plane_normal = np.cross(right, up)
    distances = (item.points - origin) @ plane_normal
    points = item.points - origin
    if direction is not None:
        cosine = float(direction @ plane_normal)
        if abs(cosine) < 1e-6:
            return None
        points = points - (distances / cosine)[:, None] * direction
    projected_points = np.stack([points @ right, points @ up], axis=1)
    if item.normal is None or item.dip_deg is None:
        return ProjectedItem(item, projected_points, distances, None)
    if is_map(plane_normal):
        azimuth = item.dip_direction_deg or 0.0
        lines = strike_and_dip_symbol(np.zeros(3), azimuth, item.dip_deg, 2.0, item.overturned)
        projection_axes = np.stack([right, up], axis=1)
        return ProjectedItem(
            item, projected_points, distances, None, tuple(line @ projection_axes for line in lines)
        )
    return ProjectedItem(
        item, projected_points, distances, apparent_dip_deg(item.normal, right, up)
    )


def is_map(direction: FloatArray) -> bool:
    """Return whether the normal (3,) of a picture is close enough to vertical for a map."""
    return abs(float(direction[2])) >= math.cos(math.radians(MAX_MAP_ANGLE_DEG)) - 1e-12
