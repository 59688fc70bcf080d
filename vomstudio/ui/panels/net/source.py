"""Contents of the net from the project: sets, errors, selection and open feature."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.orientation import Line, Plane, normals_to_planes, planes_to_normals
from vomstudio.geology.roses import LINE_ANGLES
from vomstudio.io.text.repeated_rows import repeats_note
from vomstudio.products.net.contents import (
    AnyEllipse,
    LiveFeature,
    NetBand,
    NetCircle,
    NetContents,
    NetEllipse,
    NetLineEllipse,
    NetSet,
)
from vomstudio.products.net.net_options import MAX_PLANES, NetRotation
from vomstudio.products.net.rose_contents import RoseContents, roses_from_sets
from vomstudio.project.fold_planes import FoldPlanes
from vomstudio.project.kinds import get_kind
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import FeatureType, TypedFeature, get_feature
from vomstudio.project.registration_errors import get_models, get_rotation_errors
from vomstudio.project.straight_traces import measured_band
from vomstudio.studio.fold_choice import is_bed
from vomstudio.studio.surfaces.proposed_planes import ProposedPlanes
from vomstudio.ui.base.feature_colors import UNKNOWN_COLOR, feature_class, set_colors
from vomstudio.ui.base.number_formatting import natural_sort_key
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.feature_sets import (
    UNASSIGNED_COLOR,
    Groups,
    build_sets,
    distinct_symbols,
    group_by_appearance,
    net_features,
    proposed_sets,
    split_set,
)
from vomstudio.ui.panels.net.view_settings import NetViewSettings

if TYPE_CHECKING:
    from vomstudio.products.net.figure_style import FigureStyle

_MARKERS = {
    "circle": "o",
    "square": "s",
    "triangle": "^",
    "diamond": "D",
    "pentagon": "p",
    "star": "*",
}
MIN_FOLD_PLANES = 3
MAX_ROSES = 3
"""Maximum number of roses by set; otherwise there is one for each type."""
MAX_ERROR_ELLIPSES = 500
"""Maximum number of error ellipses; a larger number would overlap too much to be legible."""


class NetSource:
    """Source that collects the contents of the net from the project.

    Attributes
    ----------
    groups : Groups or None
        Proposed sets, which replace the sets of the project on the net, or None if no sets are
        proposed.
    proposed : dict of str to ProposedPlanes
        Planes of proposed features, by the name of their panel.
    names : list of str
        Names of the sets returned by the last call of `sets`, including hidden sets.
    types : list of str
        Names of the types of these sets.
    """

    def __init__(self, studio: Studio, view_settings: NetViewSettings) -> None:
        self._studio, self._view_settings = studio, view_settings
        self.groups: Groups | None = None
        self.proposed: dict[str, ProposedPlanes] = {}
        self.names: list[str] = []
        self.types: list[str] = []

    def sets(self) -> list[NetSet]:
        """Return the sets of visible features, without rotation.

        For each feature type and set, planes, lines and compass readings form separate sets.
        """
        studio = self._studio
        visible_types = {
            feature_type.id: studio.visible(feature_type.id)
            for feature_type in studio.session.of(FeatureType)
        }
        features = [
            f
            for f in studio.session.records.cached(net_features)[0]
            if visible_types.get(f.type_id, True) and studio.visible(f.id)
        ]
        measurements = studio.measured(f.id for f in features)
        model_rotations = get_rotation_errors(get_models(studio.records, features))
        feature_rotations = {f.id: row for row, f in enumerate(features)}, model_rotations
        groups: dict[str, dict[str, list[TypedFeature]]] = {}
        for feature in features:
            groups.setdefault(feature.type_id, {}).setdefault(feature.set_name, []).append(feature)
        colors = studio.session.records.cached(set_colors)
        sets: list[NetSet] = []
        for feature_type in studio.session.of(FeatureType):
            type_sets = groups.get(feature_type.id, {})
            # Picked planes and compass readings of the same set share one symbol.
            for number, name in enumerate(sorted(type_sets, key=natural_sort_key)):
                color, variant = colors.get((feature_type.id, name), UNKNOWN_COLOR), 0
                if studio.settings.color_by != "set":
                    color, variant = feature_type.color, number
                title = f"{feature_type.name}: {name}" if name else feature_type.name
                for appearance, members in group_by_appearance(type_sets[name]):
                    marker = appearance.marker or _MARKERS.get(feature_type.symbol, "o")
                    sets += build_sets(
                        feature_type=replace(feature_type, color=color),
                        name=f"{title}{appearance.suffix}",
                        features=members,
                        measurements=measurements,
                        marker=marker,
                        rotations=feature_rotations,
                        variant=variant,
                    )
        sets = distinct_symbols(sets)
        if self.groups is not None:
            sets = proposed_sets(sets, self.groups)
        self.names = [s.name for s in sets]
        self.types = list(dict.fromkeys(s.group for s in sets if s.group))
        return sets

    def visible_sets(self) -> list[NetSet]:
        """Return the sets that are not hidden, rotated according to the view settings."""
        rotation, hidden_sets = self._view_settings.rotation, self._view_settings.hidden_sets
        sets = [s for s in self.sets() if s.name not in hidden_sets]
        return [rotation.rotate_set(s) for s in sets] if rotation.has_rotation else sets

    def contoured_type(self, sets: Iterable[NetSet]) -> str | None:
        """Return the name of the type that is contoured, or None for all sets together.

        If the selected type is not shown, or its name is empty, the most frequent type is returned.
        """
        selected_contoured_type = self._view_settings.contoured_type
        if selected_contoured_type is None or self.groups is not None:
            return None
        counts = Counter[str]()
        for s in sets:
            counts[s.group_name] += len(s)
        if selected_contoured_type in counts:
            return selected_contoured_type
        return max(counts, key=counts.__getitem__, default=None)

    def proposals(self) -> list[NetSet]:
        """Return the proposed features as grey sets, rotated according to the view settings."""
        sets = []
        for proposed in self.proposed.values():
            planes, rotation = proposed.planes, self._view_settings.rotation
            net_set = NetSet(
                name=proposed.title,
                kind="plane",
                azimuth_deg=np.array([plane.dip_direction_deg for plane in planes]),
                angle_deg=np.array([plane.dip_deg for plane in planes]),
                ids=proposed.ids,
                color=UNASSIGNED_COLOR,
                marker="o",
            )
            sets.append(rotation.rotate_set(net_set) if rotation.has_rotation else net_set)
        return [net_set for net_set in sets if len(net_set)]

    def selected_ids(self) -> frozenset[str]:
        """Return the ids of the selected features and proposals."""
        proposals = (proposed.selected_ids for proposed in self.proposed.values())
        return frozenset(self._studio.selection.ids).union(*proposals)

    def color_sets(self, sets: Sequence[NetSet]) -> tuple[NetSet, ...]:
        """Split sets whose features have different colours according to the settings."""
        studio = self._studio
        if studio.settings.color_by in ("type", "set") or self.groups is not None:
            return tuple(sets)
        measurements = studio.measured(id_ for s in sets for id_ in s.ids)
        classes = {
            id_: feature_class(studio, feature, measurements[id_])
            for id_ in measurements
            if (feature := get_feature(studio.records, id_)) is not None
        }
        return tuple(split for s in sets for split in split_set(s, classes))

    def fold_planes(self, sets: Iterable[NetSet]) -> FoldPlanes | None:
        """Return the rotated planes that define the fold axis.

        The result is None if no bedding is shown or proposed sets replace the sets of the project.
        """
        if self.groups is not None:
            return None
        records = self._studio.records
        if not any(is_bed(records.get(id_)) for s in sets for id_ in s.ids):
            return None
        planes, rotation = self._studio.fold.planes(), self._view_settings.rotation
        if not rotation.has_rotation:
            return planes
        normals = planes_to_normals(planes.azimuth_deg, planes.dip_deg)
        azimuth, dip, _ = normals_to_planes(rotation.vectors(normals))
        return replace(planes, azimuth_deg=azimuth, dip_deg=dip, rotation_errors=None)

    def repeat_notes(self) -> tuple[str, ...]:
        """Return a note on the number of omitted repeated picks; empty if none are omitted."""
        studio = self._studio
        repeats = studio.session.records.cached(net_features)[1]
        count = sum(studio.visible(f.id) and studio.visible(f.type_id) for f in repeats)
        return repeats_note(count)

    def type_colors(self, ids: Iterable[str], style: FigureStyle) -> dict[str, str]:
        """Return the figure colours (#rrggbb) of the features' types, by type name.

        The names are in lower case, as in tables.
        """
        types = {}
        records = self._studio.records
        for id_ in ids:
            feature = get_feature(records, id_)
            feature_type = (
                records.get(feature.type_id) if isinstance(feature, TypedFeature) else None
            )
            if isinstance(feature_type, FeatureType):
                types[feature_type.id] = feature_type
        # Tables contain type names in lower case.
        return {
            feature_type.name.casefold(): style.colors.get(feature_type.color, feature_type.color)
            for feature_type in types.values()
        }

    def roses(self, sets: Sequence[NetSet]) -> RoseContents:
        """Return the roses or histograms of the sets according to the view settings."""
        view_settings, weights = self._view_settings, None
        geometry = "line" if view_settings.view in LINE_ANGLES else "plane"
        sets = [s for s in sets if s.kind == geometry]
        is_pooled = len(sets) > MAX_ROSES and self.groups is None
        sets = self._pool_by_type(sets) if is_pooled else sets
        if view_settings.is_length_weighted:
            ids = [id_ for s in sets for id_ in s.ids]
            measurements = self._studio.measured(ids)
            weights = {id_: _length(measurements[id_]) for id_ in ids}
        net_contents = roses_from_sets(
            sets,
            view_settings.view,
            bin_deg=view_settings.bin_deg,
            weights=weights,
            weight=tr("length") if weights is not None else None,
            is_area_scaled=view_settings.is_area_scaled,
        )
        skipped_count = sum(map(len, sets)) - sum(rose.n for rose in net_contents.roses.values())
        notes = self.repeat_notes()
        if is_pooled:
            notes = (*notes, tr("the sets of each type are combined"))
        if not skipped_count:
            return replace(net_contents, notes=notes)
        code = "rose.left-out-by-length" if view_settings.is_length_weighted else "rose.left-out"
        return replace(net_contents, notes=(*notes, Finding(code, count=skipped_count).message))

    def _pool_by_type(self, sets: Sequence[NetSet]) -> list[NetSet]:
        """Join sets of equal type and appearance, because small roses are not informative."""
        records = self._studio.records
        groups: dict[str, list[NetSet]] = {}
        for s in sets:
            feature = get_feature(records, s.ids[0])
            if feature is None:
                continue
            feature_type = records.get(getattr(feature, "type_id", ""))
            appearance = get_kind(feature).net
            suffix = "" if appearance is None else appearance.suffix
            groups.setdefault(
                f"{feature_type.name if feature_type else s.name}{suffix}", []
            ).append(s)
        return [
            replace(
                members[0],
                name=name,
                azimuth_deg=np.concatenate([s.azimuth_deg for s in members]),
                angle_deg=np.concatenate([s.angle_deg for s in members]),
                ids=tuple(id_ for s in members for id_ in s.ids),
                rotation_errors=None,
                slips=None,
            )
            for name, members in groups.items()
        ]

    # --- errors ------------------------------------------------------------------------------
    def error_ellipses(self, sets: Iterable[NetSet]) -> tuple[AnyEllipse, ...]:
        """Return the 95 % error ellipses of the features in the sets.

        Features with unknown error are omitted. The result is empty for more than
        `MAX_ERROR_ELLIPSES` features.
        """
        ids = [id_ for s in sets for id_ in s.ids]
        if len(ids) > MAX_ERROR_ELLIPSES:
            return ()
        measurements = self._studio.measured(ids)
        ellipses = (error_ellipse(measurements[id_]) for id_ in ids)
        return self._rotate_ellipses(e for e in ellipses if e is not None)

    def current_ellipses(self) -> tuple[AnyEllipse, ...]:
        """Return the error ellipse of the current plane or line, or an empty tuple if unknown."""
        current = self._studio.selection.current
        if current is None or get_feature(self._studio.records, current) is None:
            return ()
        ellipse = error_ellipse(self._studio.measured([current])[current])
        return () if ellipse is None else self._rotate_ellipses([ellipse])

    def _rotate_ellipses(self, ellipses: Iterable[AnyEllipse]) -> tuple[AnyEllipse, ...]:
        rotation = self._view_settings.rotation
        return tuple(rotation.rotate_ellipse(e) if rotation.has_rotation else e for e in ellipses)

    # --- open feature ------------------------------------------------------------------------
    def live(self) -> LiveFeature | None:
        """Return the open feature of a tool, or None if it does not yet define a plane or line."""
        measurement = getattr(self._studio.open_tool, "measurement", None)
        if not isinstance(measurement, Measurement):
            return None
        if measurement.plane is None and measurement.line is None:
            return None
        feature = LiveFeature(measurement.plane, measurement.line, error_ellipse(measurement))
        rotation = self._view_settings.rotation
        return _rotate_live_net(feature, rotation) if rotation.has_rotation else feature

    # --- lines on planes ---------------------------------------------------------------------
    def slip_planes(self, sets: Iterable[NetSet]) -> tuple[NetCircle, ...]:
        """Return the distinct planes in which rakes were measured, at most `MAX_PLANES`."""
        rotation = self._view_settings.rotation
        circles: dict[tuple[float, float], NetCircle] = {}
        for s in sets:
            if s.kind != "line":
                continue
            measurements = self._studio.measured(s.ids)
            for id_ in s.ids:
                plane = measurements[id_].on_plane
                if plane is None or len(circles) >= MAX_PLANES:
                    continue
                pole = Line.from_vector(rotation.vectors(plane.normal()))
                key = round(pole.trend_deg, 6), round(pole.plunge_deg, 6)
                circles.setdefault(key, NetCircle(pole, 90.0, "", s.color))
        return tuple(circles.values())


def error_ellipse(measurement: Measurement) -> AnyEllipse | None:
    """Return the 95 % error ellipse of a pole or line, or None if its error is unknown.

    A straight trace is represented by a band of possible poles instead.
    """
    if measurement.line is not None:
        return _line_ellipse(measurement)
    if (band := measured_band(measurement)) is not None:
        return NetBand(band.outline())
    fit, total = measurement.fit, measurement.total95_deg
    if fit is None or total is None or fit.error_rake_deg is None:
        return None
    plane = Plane.from_normal(fit.normal)
    major_deg, minor_deg = fit.max_confidence95_deg or 0.0, fit.min_confidence95_deg or 0.0
    return NetEllipse.enlarge_to_total(plane, major_deg, minor_deg, fit.error_rake_deg, total)


def _line_ellipse(measurement: Measurement) -> NetLineEllipse | None:
    total = measurement.total
    if measurement.line is not None and total is not None and measurement.registration_error_deg:
        return NetLineEllipse(measurement.line, total.largest_deg, total.smallest_deg, total.axis)
    line, major_deg, minor_deg = (
        measurement.line,
        measurement.max_confidence95_deg,
        measurement.min_confidence95_deg,
    )
    if line is None or major_deg is None or minor_deg is None:
        return None
    # A circular cone has no major axis, so any perpendicular direction can be used.
    axis = measurement.confidence_axis
    if axis is None:
        axis = np.cross(line.vector(), np.eye(3)[int(np.argmin(np.abs(line.vector())))])
    return NetLineEllipse(line, major_deg, minor_deg, axis)


def _rotate_live_net(live_net: LiveFeature, rotation: NetRotation) -> LiveFeature:
    plane, line = live_net.plane, live_net.line
    if plane is not None:
        direction, dip, _ = normals_to_planes(rotation.vectors(plane.normal()))
        plane = Plane(float(direction[0]), float(dip[0]))
    if line is not None:
        line = Line.from_vector(rotation.vectors(line.vector()))
    ellipse = None if live_net.ellipse is None else rotation.rotate_ellipse(live_net.ellipse)
    return replace(live_net, plane=plane, line=line, ellipse=ellipse)


def _length(measurement: Measurement) -> float | None:
    """Return the length of a line or the longest extent of a plane, or None if unknown."""
    if measurement.line_fit is not None:
        return measurement.line_fit.length
    return None if measurement.fit is None else measurement.fit.extent


def add_fold_axis(net: NetContents, planes: FoldPlanes | None) -> NetContents:
    """Return a copy of the net with the fold axis of the planes. Runs in any thread.

    If the axis cannot be computed, the net is returned unchanged.
    """
    if planes is None or len(planes) < MIN_FOLD_PLANES:
        return net
    try:
        return replace(net, fold=planes.axis(), fold_not_good_count=planes.not_good)
    except VomError:
        return net
