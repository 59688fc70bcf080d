"""What the project has to show on the net: sets, errors, what is selected and what is picked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.errors import VomError
from vomstudio.core.words import tr
from vomstudio.geology.orientation import Line, Plane, normals_to_planes, planes_to_normals
from vomstudio.geology.roses import LINE_ANGLES
from vomstudio.io.text.repeated_rows import repeats_note
from vomstudio.products.net.contents import (
    AnyEllipse,
    NetBand,
    NetCircle,
    NetContents,
    NetEllipse,
    NetLineEllipse,
    NetLive,
    NetSet,
)
from vomstudio.products.net.net_options import MAX_PLANES, Turning
from vomstudio.products.net.rose_contents import RoseContents, roses_of_sets
from vomstudio.project.fold_planes import FoldPlanes
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import FeatureType, Typed, get_feature
from vomstudio.project.registration_errors import models_of, turns_of
from vomstudio.project.straight_traces import band_of_measured
from vomstudio.studio.fold_choice import is_bed
from vomstudio.ui.base.number_formatting import natural_sort_key
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.feature_sets import (
    Groups,
    alike,
    on_the_net,
    proposed_sets,
    sets_of,
)
from vomstudio.ui.panels.net.view_settings import NetWishes

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
MOST_ERRORS = 500
"""Ellipses of more features would be one blot."""


class NetSource:
    """groups : of proposed sets, which are shown instead of the project's own
    names : of the sets that were looked for last, hidden or not
    """

    def __init__(self, studio: Studio, wishes: NetWishes) -> None:
        self._studio, self._wishes = studio, wishes
        self.groups: Groups | None = None
        self.names: list[str] = []

    def sets(self) -> list[NetSet]:
        """All sets of visible features, as measured: one group for each feature type and set, and
        within it for planes, lines and compass readings."""
        studio = self._studio
        shown = {kind.id: studio.visible(kind.id) for kind in studio.session.of(FeatureType)}
        features = [
            f
            for f in studio.session.records.cached(on_the_net)[0]
            if shown.get(f.type_id, True) and studio.visible(f.id)
        ]
        measured = studio.measured(f.id for f in features)
        turned = turns_of(models_of(studio.records, features))
        turns = {f.id: row for row, f in enumerate(features)}, turned
        groups: dict[str, dict[str, list[Typed]]] = {}
        for feature in features:
            groups.setdefault(feature.type_id, {}).setdefault(feature.set_name, []).append(feature)
        sets: list[NetSet] = []
        for kind in studio.session.of(FeatureType):
            own = groups.get(kind.id, {})
            # The same symbol for a set, whether picked or read on a compass.
            for variant, name in enumerate(sorted(own, key=natural_sort_key)):
                title = f"{kind.name}: {name}" if name else kind.name
                for look, own_look in alike(own[name]):
                    marker = look.marker or _MARKERS.get(kind.symbol, "o")
                    sets += sets_of(
                        kind, f"{title}{look.suffix}", own_look, measured, marker, turns, variant
                    )
        if self.groups is not None:
            sets = proposed_sets(sets, self.groups)
        self.names = [s.name for s in sets]
        return sets

    def shown_sets(self) -> list[NetSet]:
        """Those of `sets` that are not hidden, turned as is wished."""
        turning, hidden = self._wishes.turning, self._wishes.hidden
        kept = [s for s in self.sets() if s.name not in hidden]
        return [turning.rotate_set(s) for s in kept] if turning.turns else kept

    def fold_planes(self, sets: Iterable[NetSet]) -> FoldPlanes | None:
        """The planes of the fold axis, turned as is wished; None while no bedding is shown."""
        if self.groups is not None:
            return None
        records = self._studio.records
        if not any(is_bed(records.get(id_)) for s in sets for id_ in s.ids):
            return None
        planes, turning = self._studio.fold.planes(), self._wishes.turning
        if not turning.turns:
            return planes
        normals = planes_to_normals(planes.azimuth_deg, planes.dip_deg)
        azimuth, dip, _ = normals_to_planes(turning.vectors(normals))
        return replace(planes, azimuth_deg=azimuth, dip_deg=dip, turns=None)

    def left_out(self) -> tuple[str, ...]:
        """How many visible features are not shown since they repeat others; nothing for none."""
        studio = self._studio
        again = studio.session.records.cached(on_the_net)[1]
        left = sum(studio.visible(f.id) and studio.visible(f.type_id) for f in again)
        return repeats_note(left)

    def colors_of(self, ids: Iterable[str], style: FigureStyle) -> dict[str, str]:
        """#rrggbb of these features' types in figures, by what a table calls the type."""
        found = {}
        records = self._studio.records
        for id_ in ids:
            feature = get_feature(records, id_)
            kind = records.get(feature.type_id) if isinstance(feature, Typed) else None
            if isinstance(kind, FeatureType):
                found[kind.id] = kind
        # Tables write the names of types small.
        return {
            kind.name.casefold(): style.colors.get(kind.color, kind.color)
            for kind in found.values()
        }

    def roses(self, sets: Sequence[NetSet]) -> RoseContents:
        """Of the sets, as is wished."""
        wishes, weights = self._wishes, None
        if wishes.by_length:
            ids = [id_ for s in sets for id_ in s.ids]
            measured = self._studio.measured(ids)
            weights = {id_: _length(measured[id_]) for id_ in ids}
        found = roses_of_sets(
            sets,
            wishes.view,
            bin_deg=wishes.bin_deg,
            weights=weights,
            weight=tr("length") if weights is not None else None,
            by_area=wishes.by_area,
        )
        kind = "line" if wishes.view in LINE_ANGLES else "plane"
        left = sum(len(s) for s in sets if s.kind == kind) - sum(
            rose.n for rose in found.roses.values()
        )
        again = self.left_out()
        if not left:
            return replace(found, notes=again)
        said = (
            tr("{count:,} without such an angle or a length are left out", count=left)
            if wishes.by_length
            else tr("{count:,} without such an angle are left out", count=left)
        )
        return replace(found, notes=(*again, said))

    # --- errors ------------------------------------------------------------------------------
    def errors(self, sets: Iterable[NetSet]) -> tuple[AnyEllipse, ...]:
        """The 95 % ellipses of all features of these sets, where they are known."""
        ids = [id_ for s in sets for id_ in s.ids]
        if len(ids) > MOST_ERRORS:
            return ()
        measured = self._studio.measured(ids)
        found = (ellipse_of(measured[id_]) for id_ in ids)
        return self._turned(e for e in found if e is not None)

    def of_current(self) -> tuple[AnyEllipse, ...]:
        """The ellipse of the current plane or line, where its error is known."""
        current = self._studio.selection.current
        if current is None or get_feature(self._studio.records, current) is None:
            return ()
        found = ellipse_of(self._studio.measured([current])[current])
        return () if found is None else self._turned([found])

    def _turned(self, ellipses: Iterable[AnyEllipse]) -> tuple[AnyEllipse, ...]:
        turning = self._wishes.turning
        return tuple(turning.rotate_ellipse(e) if turning.turns else e for e in ellipses)

    # --- what is being picked ----------------------------------------------------------------
    def live(self) -> NetLive | None:
        """The open feature of a tool, where it has a plane or a line by now."""
        measured = getattr(self._studio.open_tool, "measurement", None)
        if not isinstance(measured, Measurement):
            return None
        if measured.plane is None and measured.line is None:
            return None
        found = NetLive(measured.plane, measured.line, ellipse_of(measured))
        turning = self._wishes.turning
        return _turned_live(found, turning) if turning.turns else found

    # --- lines on planes ---------------------------------------------------------------------
    def slip_planes(self, sets: Iterable[NetSet]) -> tuple[NetCircle, ...]:
        """The planes on which the rakes of the lines in these sets were counted, each once."""
        turning = self._wishes.turning
        found: dict[tuple[float, float], NetCircle] = {}
        for s in sets:
            if s.kind != "line":
                continue
            measured = self._studio.measured(s.ids)
            for id_ in s.ids:
                plane = measured[id_].on_plane
                if plane is None or len(found) >= MAX_PLANES:
                    continue
                pole = Line.from_vector(turning.vectors(plane.normal()))
                key = round(pole.trend_deg, 6), round(pole.plunge_deg, 6)
                found.setdefault(key, NetCircle(pole, 90.0, "", s.color))
        return tuple(found.values())


def ellipse_of(measured: Measurement) -> AnyEllipse | None:
    """The 95 % ellipse of a plane's pole or of a line, where its error is known; of a straight
    trace the band of poles that it allows."""
    if measured.line is not None:
        return _line_ellipse(measured)
    if (band := band_of_measured(measured)) is not None:
        return NetBand(band.outline())
    fit, total = measured.fit, measured.total95_deg
    if fit is None or total is None or fit.error_rake_deg is None:
        return None
    plane = Plane.from_normal(fit.normal)
    own, smallest = fit.max_confidence95_deg or 0.0, fit.min_confidence95_deg or 0.0
    return NetEllipse.enlarge_to_total(plane, own, smallest, fit.error_rake_deg, total)


def _line_ellipse(measured: Measurement) -> NetLineEllipse | None:
    total = measured.total
    if measured.line is not None and total is not None and measured.registration_error_deg:
        return NetLineEllipse(measured.line, total.largest_deg, total.smallest_deg, total.axis)
    line, largest, smallest = (
        measured.line,
        measured.max_confidence95_deg,
        measured.min_confidence95_deg,
    )
    if line is None or largest is None or smallest is None:
        return None
    # A cone has no larger axis: any direction across it will do.
    axis = measured.confidence_axis
    if axis is None:
        axis = np.cross(line.vector(), np.eye(3)[int(np.argmin(np.abs(line.vector())))])
    return NetLineEllipse(line, largest, smallest, axis)


def _turned_live(live: NetLive, turning: Turning) -> NetLive:
    plane, line = live.plane, live.line
    if plane is not None:
        direction, dip, _ = normals_to_planes(turning.vectors(plane.normal()))
        plane = Plane(float(direction[0]), float(dip[0]))
    if line is not None:
        line = Line.from_vector(turning.vectors(line.vector()))
    ellipse = None if live.ellipse is None else turning.rotate_ellipse(live.ellipse)
    return replace(live, plane=plane, line=line, ellipse=ellipse)


def _length(measured: Measurement) -> float | None:
    """Of a plane along its longest direction, or of a line; None where it has none."""
    if measured.line_fit is not None:
        return measured.line_fit.length
    return None if measured.fit is None else measured.fit.extent


def with_fold(net: NetContents, planes: FoldPlanes | None) -> NetContents:
    """The net with the fold axis of these planes; in any thread, since thousands take long."""
    if planes is None or len(planes) < MIN_FOLD_PLANES:
        return net
    try:
        return replace(net, fold=planes.axis(), fold_not_good=planes.not_good)
    except VomError:
        return net
