"""Sets of the net, built from the features of a project or from proposed groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geology.common_rotation_errors import RotationErrors
from vomstudio.products.net.contents import MARKERS, OKABE_ITO, NetSet
from vomstudio.project.kind import NetAppearance
from vomstudio.project.kinds import KINDS, get_kind
from vomstudio.project.measurement import Measurement
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import FeatureType, TypedFeature
from vomstudio.project.repeated_features import is_repeat
from vomstudio.rendering.qt.legend_painting import ColorEntry

Groups = tuple[tuple[str, tuple[str, ...]], ...]
"""Name and plane ids of each proposed set; the name of unassigned planes is empty."""

UNASSIGNED_COLOR = "#8c8c8c"
_SYMBOLS = (*MARKERS, ">", "p", "h")


def group_by_appearance(
    features: Sequence[TypedFeature],
) -> list[tuple[NetAppearance, list[TypedFeature]]]:
    """Group features by the appearance of their kind on the net, in the order of the kinds."""
    features_by_class: dict[type[TypedFeature], list[TypedFeature]] = {}
    for feature in features:
        features_by_class.setdefault(type(feature), []).append(feature)
    result: dict[NetAppearance, list[TypedFeature]] = {}
    for feature_kind in KINDS:
        if feature_kind.net is not None and feature_kind.record in features_by_class:
            result.setdefault(feature_kind.net, []).extend(features_by_class[feature_kind.record])
    return list(result.items())


def net_features(records: RecordMap) -> tuple[list[TypedFeature], list[TypedFeature]]:
    """Return the features that the net shows, and the repeated picks that it omits."""
    features = records.of(TypedFeature)
    has_net_by_class = {
        type(f): get_kind(f).net is not None for f in {type(f): f for f in features}.values()
    }
    originals: list[TypedFeature] = []
    repeats: list[TypedFeature] = []
    for feature in features:
        if has_net_by_class[type(feature)]:
            (repeats if is_repeat(feature, records) else originals).append(feature)
    return originals, repeats


def build_sets(
    feature_type: FeatureType,
    name: str,
    features: Sequence[TypedFeature],
    measurements: Mapping[str, Measurement],
    marker: str,
    rotations: tuple[Mapping[str, int], RotationErrors],
    variant: int = 0,
) -> list[NetSet]:
    """Build a set of the planes and a set of the lines among the features.

    Features without an orientation are omitted.
    """
    planes, lines = [], []
    for feature in features:
        measurement = measurements[feature.id]
        if (plane := measurement.plane) is not None:
            planes.append((feature.id, plane))
        elif (line := measurement.line) is not None:
            lines.append((feature.id, line))
    result = []
    rows, model_rotations = rotations
    if planes:
        azimuth = np.array([p.dip_direction_deg for _, p in planes], dtype=float)
        angle = np.array([p.dip_deg for _, p in planes], dtype=float)
        ids = tuple(id_ for id_, _ in planes)
        set_rotation_errors = model_rotations.of([rows[id_] for id_ in ids])
        result.append(
            NetSet(
                name=name,
                kind="plane",
                azimuth_deg=azimuth,
                angle_deg=angle,
                ids=ids,
                color=feature_type.color,
                marker=marker,
                variant=variant,
                rotation_errors=set_rotation_errors,
                group=feature_type.name,
            )
        )
    if lines:
        azimuth = np.array([line.trend_deg for _, line in lines], dtype=float)
        angle = np.array([line.plunge_deg for _, line in lines], dtype=float)
        ids = tuple(id_ for id_, _ in lines)
        set_rotation_errors = model_rotations.of([rows[id_] for id_ in ids])
        slips = _slip_vectors([measurements[id_] for id_ in ids])
        result.append(
            NetSet(
                name=name,
                kind="line",
                azimuth_deg=azimuth,
                angle_deg=angle,
                ids=ids,
                color=feature_type.color,
                marker=marker,
                variant=variant,
                rotation_errors=set_rotation_errors,
                slips=slips,
                group=feature_type.name,
            )
        )
    return result


def distinct_symbols(sets: Sequence[NetSet]) -> list[NetSet]:
    """Assign a different symbol to each set while symbols are available.

    The first set of a type has the symbol of the type.

    Parameters
    ----------
    sets : sequence of NetSet

    Returns
    -------
    list of NetSet
    """
    unused_symbols = [marker for marker in _SYMBOLS if all(s.marker != marker for s in sets)]
    used_symbols: set[str] = set()
    result = []
    for s in sets:
        marker = (
            s.marker
            if s.marker not in used_symbols
            else unused_symbols.pop(0)
            if unused_symbols
            else ""
        )
        used_symbols.add(s.marker)
        result.append(replace(s, marker=marker, variant=0) if marker else s)
    return result


def _slip_vectors(measurements: Sequence[Measurement]) -> FloatArray | None:
    """Return the slip vectors (n, 3) of the hanging wall, or None if all are unknown.

    Unknown vectors are NaN.
    """
    slips = [m.slip_vector() for m in measurements]
    if all(slip is None for slip in slips):
        return None
    return np.array([(np.nan,) * 3 if slip is None else slip for slip in slips])


def split_set(net_set: NetSet, classes: Mapping[str, ColorEntry]) -> list[NetSet]:
    """Split a set into one set per class, in the colours of the classes.

    Parameters
    ----------
    net_set : NetSet
    classes : mapping of str to ColorEntry
        Class of each feature by ID.

    Returns
    -------
    list of NetSet
    """
    rows: dict[ColorEntry, list[int]] = {}
    for row, id_ in enumerate(net_set.ids):
        rows.setdefault(classes[id_], []).append(row)
    return [
        replace(
            net_set,
            name=f"{net_set.name}, {set_name.text}",
            azimuth_deg=net_set.azimuth_deg[members],
            angle_deg=net_set.angle_deg[members],
            ids=tuple(net_set.ids[row] for row in members),
            color=set_name.color,
            rotation_errors=None
            if net_set.rotation_errors is None
            else net_set.rotation_errors.of(members),
            slips=None if net_set.slips is None else net_set.slips[members],
        )
        for set_name, members in sorted(rows.items(), key=lambda item: item[1][0])
    ]


def proposed_sets(sets: Sequence[NetSet], groups: Groups) -> list[NetSet]:
    """Build one set per proposed group, each with its own colour and symbol.

    Planes that belong to no group are grey.
    """
    position_by_id = {
        id_: (k, row)
        for k, s in enumerate(sets)
        if s.kind == "plane"
        for row, id_ in enumerate(s.ids)
    }
    result = []
    for number, (name, ids) in enumerate(groups):
        members = [id_ for id_ in ids if id_ in position_by_id]
        if not members:
            continue
        positions = [position_by_id[id_] for id_ in members]
        title = tr("{set} (proposed)", set=name) if name else tr("no set")
        result.append(
            NetSet(
                name=title,
                kind="plane",
                azimuth_deg=np.array([sets[k].azimuth_deg[row] for k, row in positions]),
                angle_deg=np.array([sets[k].angle_deg[row] for k, row in positions]),
                ids=tuple(members),
                color=set_color(number) if name else UNASSIGNED_COLOR,
                marker=MARKERS[number % len(MARKERS)] if name else "o",
                rotation_errors=_rotation_errors(sets, positions),
            )
        )
    return result


def set_color(number: int, has_name: bool = True) -> str:
    """Return the colour (#rrggbb) of a proposed set by index; unassigned planes are grey."""
    return OKABE_ITO[number % len(OKABE_ITO)] if has_name else UNASSIGNED_COLOR


def _rotation_errors(
    sets: Sequence[NetSet], positions: Sequence[tuple[int, int]]
) -> RotationErrors | None:
    """Return the rotation errors of some planes, or None if they are unknown.

    All sets of a net share the same rotations.
    """
    group, rotations = [], None
    for k, row in positions:
        rotation_errors = sets[k].rotation_errors
        if rotation_errors is None:
            return None
        group.append(int(rotation_errors.group[row]))
        rotations = rotation_errors.rotations
    return None if rotations is None else RotationErrors(np.array(group, np.int64), rotations)
