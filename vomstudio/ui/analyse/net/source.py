"""What the project has to show on the net: sets, errors, what is selected and what is picked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.document.measurement import Measurement
from vomstudio.document.records import FeatureType, Typed, get_feature
from vomstudio.document.registration_errors import model_of, models_of, pole_region, turns_of
from vomstudio.document.straight_traces import band_of_measured
from vomstudio.errors import VomError
from vomstudio.geology.common_turns import Turns
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.orientation import Line, Plane, normals_to_planes
from vomstudio.geology.roses import LINES_HAVE
from vomstudio.io.text.repeated_rows import repeats_not_drawn
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
from vomstudio.products.net.net_options import MOST_PLANES, Turning
from vomstudio.products.net.rose_contents import RoseContents, roses_of_sets
from vomstudio.ui.analyse.net.wishes import NetWishes
from vomstudio.ui.analyse.net_sets import (
    Groups,
    alike,
    on_the_net,
    proposed_sets,
    sets_of,
)
from vomstudio.ui.common.number_formatting import natural
from vomstudio.ui.common.studio import Studio
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.products.net.figure_style import FigureStyle

_MARKERS = {"circle": "o", "square": "s", "triangle": "^", "diamond": "D", "pentagon": "p",
            "star": "*"}  # fmt: skip
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

    def sets(self) -> tuple[list[NetSet], list[NetSet]]:
        """All sets of visible features, as measured: one group for each feature type and set, and
        within it for planes, lines and compass readings; and of them those of picked bedding."""
        studio = self._studio
        shown = {kind.id: studio.visible(kind.id) for kind in studio.session.of(FeatureType)}
        features = [
            f
            for f in studio.session.records.once(on_the_net)[0]
            if shown.get(f.type_id, True) and studio.visible(f.id)
        ]
        measured = studio.measured(f.id for f in features)
        turned = turns_of(models_of(studio.records, features))
        turns = {f.id: row for row, f in enumerate(features)}, turned
        groups: dict[str, dict[str, list[Typed]]] = {}
        for feature in features:
            groups.setdefault(feature.type_id, {}).setdefault(feature.set_name, []).append(feature)
        sets: list[NetSet] = []
        beds: list[NetSet] = []
        for kind in studio.session.of(FeatureType):
            own = groups.get(kind.id, {})
            # The same symbol for a set, whether picked or read on a compass.
            for variant, name in enumerate(sorted(own, key=natural)):
                title = f"{kind.name}: {name}" if name else kind.name
                for look, evidence, own_look in alike(own[name]):
                    marker = look.marker or _MARKERS.get(kind.symbol, "o")
                    new = sets_of(
                        kind, f"{title}{look.suffix}", own_look, measured, marker, turns, variant
                    )
                    if kind.id == "bedding" and evidence == "picked":
                        beds += [s for s in new if s.kind == "plane"]
                    sets += new
        if self.groups is not None:
            sets, beds = proposed_sets(sets, self.groups), []
        self.names = [s.name for s in sets]
        return sets, beds

    def shown_sets(self) -> tuple[list[NetSet], list[NetSet]]:
        """Those of `sets` that are not hidden, turned as is wished."""
        turning, hidden = self._wishes.turning, self._wishes.hidden

        def wished(some: Iterable[NetSet]) -> list[NetSet]:
            kept = [s for s in some if s.name not in hidden]
            return [turning.of_set(s) for s in kept] if turning.turns else kept

        sets, beds = self.sets()
        return wished(sets), wished(beds)

    def left_out(self) -> tuple[str, ...]:
        """How many visible features are not shown since they repeat others; nothing for none."""
        studio = self._studio
        again = studio.session.records.once(on_the_net)[1]
        left = sum(studio.visible(f.id) and studio.visible(f.type_id) for f in again)
        return repeats_not_drawn(left)

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
        kind = "line" if wishes.view in LINES_HAVE else "plane"
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

    def of_current_registered(self) -> tuple[AnyEllipse, ...]:
        """That of the current plane or line with the error of its registration, where known."""
        records, current = self._studio.records, self._studio.selection.current
        feature = get_feature(records, current)
        if current is None or feature is None:
            return ()
        measured = self._studio.measured([current])[current]
        if measured.registration_error_deg is None:
            return ()
        if measured.line is not None:
            total = measured.total
            if total is None:
                return ()
            return self._turned([NetLineEllipse.of(measured.line.vector(), total)])
        pole = pole_region(measured, model_of(records, feature))
        if pole is None or measured.plane is None:
            return ()
        return self._turned([NetLineEllipse.of(-measured.plane.normal(), pole)])

    def _turned(self, ellipses: Iterable[AnyEllipse]) -> tuple[AnyEllipse, ...]:
        turning = self._wishes.turning
        return tuple(turning.of_ellipse(e) if turning.turns else e for e in ellipses)

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
                if plane is None or len(found) >= MOST_PLANES:
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
    return NetEllipse.with_total(plane, own, smallest, fit.error_rake_deg, total)


def _line_ellipse(measured: Measurement) -> NetLineEllipse | None:
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
    ellipse = None if live.ellipse is None else turning.of_ellipse(live.ellipse)
    return replace(live, plane=plane, line=line, ellipse=ellipse)


def _length(measured: Measurement) -> float | None:
    """Of a plane along its longest direction, or of a line; None where it has none."""
    if measured.line_fit is not None:
        return measured.line_fit.length
    return None if measured.fit is None else measured.fit.extent


def with_fold(net: NetContents, beds: Sequence[NetSet]) -> NetContents:
    """The net with the fold axis of these beds; in any thread, since thousands take long."""
    return replace(net, fold=_fold_of(beds)) if beds else net


def _fold_of(beds: Sequence[NetSet]) -> FoldAxis | None:
    """Fold axis of picked bedding only: feature types are never pooled silently."""
    azimuth = np.concatenate([np.zeros(0), *(s.azimuth_deg for s in beds)])
    angle = np.concatenate([np.zeros(0), *(s.angle_deg for s in beds)])
    if len(azimuth) < 3:
        return None
    turns = None
    if any(s.registered for s in beds):
        own = [s.turns for s in beds if s.turns is not None]
        turns = Turns(np.concatenate([t.group for t in own]), own[0].rotations)
    rotations = None if turns is None else (turns.group.tobytes(), turns.rotations.tobytes())
    return _fold_of_planes(azimuth.tobytes(), angle.tobytes(), rotations)


@lru_cache(maxsize=2)
def _fold_of_planes(
    azimuth: bytes, angle: bytes, turns: tuple[bytes, bytes] | None
) -> FoldAxis | None:
    """Remembered for the nets that are drawn anew with the same beds, as after each selection."""
    known = turns and Turns(
        np.frombuffer(turns[0], np.int64), np.frombuffer(turns[1]).reshape(-1, 3, 3)
    )
    try:
        return fold_axis(np.frombuffer(azimuth), np.frombuffer(angle), known)
    except VomError:
        return None
