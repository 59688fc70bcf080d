"""World coordinates and judged figures of the features, each worked out once per revision."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from operator import is_not

from vomstudio.core.errors import GeometryError
from vomstudio.geology.profiles import Thresholds
from vomstudio.project.garbage_collection import no_collection
from vomstudio.project.kind import Kind
from vomstudio.project.kinds import kind_of
from vomstudio.project.measurement import Measurement, Measuring, Records
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import (
    PROFILE_ID,
    Feature,
    Model,
    OnAModel,
    Record,
    Typed,
    get,
    limits_of,
)

__all__ = [
    "Measurement",
    "Measurements",
    "measure_all",
    "measure_one",
    "rests_on",
    "sources_of",
]


class Measurements:
    """Measurements of a document's features, kept as long as what they rest on stays what it is."""

    def __init__(self, thresholds: Thresholds | None = None) -> None:
        self._otherwise = self._judged_by = thresholds or Thresholds()
        self._kept: dict[str, tuple[tuple[Record | None, ...], Measurement]] = {}
        self._sure: dict[str, Measurement] = {}
        self._sure_of: tuple[RecordMap | None, int] = (None, 0)

    @property
    def otherwise(self) -> Thresholds:
        """The limits for a document without a profile of its own."""
        return self._otherwise

    def of(self, records: Records, ids: Iterable[str]) -> dict[str, Measurement]:
        """The measurements of those `ids` that are features; new ones are fitted in one batch."""
        if not isinstance(records, RecordMap):
            return self._looked_up(records, ids)
        # The window asks for all of thousands again and again: what rests on records that are the
        # same as then is not looked at once more.
        known, revision = self._sure_of
        if known is not records or revision != records.revision:
            self._sure, self._sure_of = {}, (records, records.revision)
        wanted = list(ids)
        if new := [id_ for id_ in wanted if id_ not in self._sure]:
            self._sure |= self._looked_up(records, new)
        return {id_: m for id_ in wanted if (m := self._sure.get(id_)) is not None}

    def _looked_up(self, records: Records, ids: Iterable[str]) -> dict[str, Measurement]:
        limits = limits_of(records, self._otherwise)
        if limits != self._judged_by:
            self._judged_by, self._kept = limits, {}
        # One pass, no generators.
        features, new, sources = [], [], {}
        for id_ in ids:
            feature = records.get(id_)
            if not isinstance(feature, Feature):
                continue
            features.append(feature)
            rests_on = sources_of(records, feature)
            kept = self._kept.get(id_)
            if kept is None or len(kept[0]) != len(rests_on) or any(map(is_not, kept[0], rests_on)):
                new.append(feature)
                sources[id_] = rests_on
        for feature, measurement in zip(new, self._measure(records, new), strict=True):
            self._kept[feature.id] = (sources[feature.id], measurement)
        return {feature.id: self._kept[feature.id][1] for feature in features}

    def keep(
        self,
        records: Records,
        measured: Iterable[tuple[Feature, Measurement]],
        judged_by: Thresholds,
    ) -> None:
        """Features that are about to come into the document, with what was measured of them on its
        models as they are; nothing is kept where the document has other limits than `judged_by`."""
        limits = limits_of(records, self._otherwise)
        if limits != judged_by:
            return
        if limits != self._judged_by:
            self._judged_by, self._kept = limits, {}
        for feature, measurement in measured:
            self._kept[feature.id] = (sources_of(records, feature), measurement)

    def one(self, records: Records, feature: Feature) -> Measurement:
        """The measurement of a feature that is not in the document."""
        return self._measure(records, [feature])[0]

    def _measure(self, records: Records, features: list[Feature]) -> list[Measurement]:
        # An intersection of sets may rest on thousands of planes, of which one has changed.
        below = [each.id for f in features for each in kind_of(f).below(records, f)]
        known = self.of(records, dict.fromkeys(below)) if below else {}
        with no_collection():
            return measure_all(records, features, self._otherwise, known)

    def edited(self, records: Records, ids: Collection[str]) -> None:
        """Nothing has changed since these measurements were asked for last but what one edit did,
        after which the features `ids` may look different; some of them may be gone."""
        for id_ in ids:
            if id_ not in records:
                self._kept.pop(id_, None)
        known, revision = self._sure_of
        if not isinstance(records, RecordMap) or known is not records:
            return
        if revision == records.revision - 1:
            for id_ in ids:
                self._sure.pop(id_, None)
            self._sure_of = (records, records.revision)


def sources_of(records: Records, feature: Feature) -> tuple[Record | None, ...]:
    """The records that a feature's figures rest on, itself first."""
    own = (get(records, feature.model_id, Model),) if isinstance(feature, OnAModel) else ()
    below = kind_of(feature).below(records, feature)
    if not below:
        return (feature, *own)
    return (feature, *own, *(s for each in below for s in sources_of(records, each)))


def rests_on(records: Records, feature: Feature, ids: Collection[str]) -> bool:
    """Whether a feature looks different after an edit of the records `ids`."""
    if PROFILE_ID in ids:
        return True
    if isinstance(feature, OnAModel) and feature.model_id in ids:
        return True
    if isinstance(feature, Typed) and feature.type_id in ids:
        return True
    kind = kind_of(feature)
    if kind.regroups:
        # Members of its groups may have come or gone: such features are few, and looked at again.
        return True
    named = kind.names(feature)
    if not named:
        return False
    return any(id_ in ids for id_ in named) or any(
        r.id in ids for r in sources_of(records, feature) if r is not None
    )


def measure_all(
    records: Records,
    features: Sequence[Feature],
    otherwise: Thresholds | None = None,
    known: Mapping[str, Measurement] | None = None,
) -> list[Measurement]:
    """Measure features, those of one kind in one batch; `known` are measurements of what they rest
    on, by id, where these have been made already. They are judged by the document's
    profile, else by `otherwise`."""
    thresholds = limits_of(records, otherwise or Thresholds())
    known = dict(known or {})
    below = {each.id: each for f in features for each in kind_of(f).below(records, f)}
    missing = [each for id_, each in below.items() if id_ not in known]
    if missing:
        found = measure_all(records, missing, thresholds)
        known |= {each.id: m for each, m in zip(missing, found, strict=True)}
    at = Measuring(records, thresholds, known)
    own: dict[Kind, list[Feature]] = {}
    for feature in features:
        own.setdefault(kind_of(feature), []).append(feature)
    measured = {kind: iter(kind.measure(at, batch)) for kind, batch in own.items()}
    return [next(measured[kind_of(feature)]) for feature in features]


def measure_one(
    feature: Feature, model: Model | None, thresholds: Thresholds | None = None
) -> Measurement:
    """A batch of one; raises GeometryError where no figure can be had."""
    records: dict[str, Record] = {} if model is None else {model.id: model}
    measurement = measure_all(records, [feature], thresholds)[0]
    if measurement.problem is not None:
        raise GeometryError(measurement.problem, field=feature.name or None)
    return measurement
