"""Cache of the World coordinates and judged measurements of features."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cache
from itertools import repeat
from operator import attrgetter, is_not
from typing import Any

from vomstudio.core.errors import GeometryError
from vomstudio.geology.profiles import Thresholds
from vomstudio.project.garbage_collection import pause_collection
from vomstudio.project.kind import Kind
from vomstudio.project.kinds import get_kind
from vomstudio.project.measurement import Measurement, MeasurementContext, Records
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import (
    PROFILE_ID,
    Feature,
    Model,
    ModelFeature,
    Record,
    TypedFeature,
    get,
    get_limits,
)

__all__ = [
    "Measurement",
    "Measurements",
    "depends_on",
    "get_sources",
    "is_equal_except",
    "measure_all",
    "measure_feature",
]


LABEL_FIELDS = frozenset({"name", "set_name", "domain", "station", "notes"})
"""Attributes of features on which no measurement depends."""


class Measurements:
    """Measurements of a project's features, cached until their dependencies change."""

    def __init__(self, thresholds: Thresholds | None = None) -> None:
        self._default_thresholds = self._thresholds = thresholds or Thresholds()
        self._cache: dict[str, tuple[tuple[Record | None, ...], Measurement]] = {}
        self._current: dict[str, Measurement] = {}
        self._current_revision: tuple[RecordMap | None, int] = (None, 0)

    @property
    def default_thresholds(self) -> Thresholds:
        """Thresholds for a project that has no profile."""
        return self._default_thresholds

    def of(self, records: Records, ids: Iterable[str]) -> dict[str, Measurement]:
        """Return the measurements of the `ids` that are features, fitting new ones in one batch."""
        if not isinstance(records, RecordMap):
            return self._look_up(records, ids)
        # The window requests thousands of features repeatedly, so skip the dependency check while
        # the revision is unchanged.
        known_measurements, revision = self._current_revision
        if known_measurements is not records or revision != records.revision:
            self._current, self._current_revision = {}, (records, records.revision)
        requested = list(ids)
        if missing_ids := [id_ for id_ in requested if id_ not in self._current]:
            self._current |= self._look_up(records, missing_ids)
        return {
            id_: measurement
            for id_ in requested
            if (measurement := self._current.get(id_)) is not None
        }

    def _look_up(self, records: Records, ids: Iterable[str]) -> dict[str, Measurement]:
        limits = get_limits(records, self._default_thresholds)
        if limits != self._thresholds:
            self._thresholds, self._cache = limits, {}
        # Single pass without generators, for speed.
        features, new_features, sources = [], [], {}
        for id_ in ids:
            feature = records.get(id_)
            if not isinstance(feature, Feature):
                continue
            features.append(feature)
            dependencies = get_sources(records, feature)
            entry = self._cache.get(id_)
            if entry is None or len(entry[0]) != len(dependencies):
                new_features.append(feature)
                sources[id_] = dependencies
            elif any(map(is_not, entry[0], dependencies)):
                if all(map(is_equal_except, entry[0], dependencies, repeat(LABEL_FIELDS))):
                    self._cache[id_] = (dependencies, entry[1])
                else:
                    new_features.append(feature)
                    sources[id_] = dependencies
        for feature, measurement in zip(
            new_features, self._measure(records, new_features), strict=True
        ):
            self._cache[feature.id] = (sources[feature.id], measurement)
        return {feature.id: self._cache[feature.id][1] for feature in features}

    def keep(
        self,
        records: Records,
        measured_pairs: Iterable[tuple[Feature, Measurement]],
        thresholds: Thresholds,
    ) -> None:
        """Store measurements of features that are about to be added to the project.

        Nothing is stored if the project's thresholds differ from `thresholds`.
        """
        limits = get_limits(records, self._default_thresholds)
        if limits != thresholds:
            return
        if limits != self._thresholds:
            self._thresholds, self._cache = limits, {}
        for feature, measurement in measured_pairs:
            self._cache[feature.id] = (get_sources(records, feature), measurement)

    def measure(self, records: Records, feature: Feature) -> Measurement:
        """Measure a feature that is not part of the project."""
        return self._measure(records, [feature])[0]

    def _measure(self, records: Records, features: list[Feature]) -> list[Measurement]:
        # An intersection of sets may depend on thousands of planes, only one of which has changed.
        dependency_ids = [
            item.id
            for feature in features
            for item in get_kind(feature).dependencies(records, feature)
        ]
        known_measurements = (
            self.of(records, dict.fromkeys(dependency_ids)) if dependency_ids else {}
        )
        with pause_collection():
            return measure_all(records, features, self._default_thresholds, known_measurements)

    def keep_after_edit(self, records: Records, ids: Collection[str]) -> None:
        """Keep the cached measurements after an edit that affects only the features `ids`.

        Some of these features may have been deleted.
        """
        for id_ in ids:
            if id_ not in records:
                self._cache.pop(id_, None)
        known_measurements, revision = self._current_revision
        if not isinstance(records, RecordMap) or known_measurements is not records:
            return
        if revision == records.revision - 1:
            for id_ in ids:
                self._current.pop(id_, None)
            self._current_revision = (records, records.revision)


def is_equal_except(
    first: Record | None, second: Record | None, ignored_fields: frozenset[str]
) -> bool:
    """Return whether two records are equal, or features that differ only in some fields.

    Parameters
    ----------
    first, second : Record or None
    ignored_fields : frozenset of str
        Names of the fields in which features may differ.
    """
    if first is second:
        return True
    if type(first) is not type(second) or not isinstance(first, Feature):
        return False
    # Mypy takes the hash of a class for that of its objects.
    record_class: Any = type(first)
    values = _compared_values(record_class, ignored_fields)
    return bool(values(first) == values(second))


@cache
def _compared_values(
    record_class: type[Feature], ignored_fields: frozenset[str]
) -> Callable[[Any], tuple[Any, ...]]:
    return attrgetter(
        *(field.name for field in fields(record_class) if field.name not in ignored_fields)
    )


def get_sources(records: Records, feature: Feature) -> tuple[Record | None, ...]:
    """Return the records that a feature's measurement depends on, starting with the feature."""
    model = (get(records, feature.model_id, Model),) if isinstance(feature, ModelFeature) else ()
    dependencies = get_kind(feature).dependencies(records, feature)
    if not dependencies:
        return (feature, *model)
    return (
        feature,
        *model,
        *(source for item in dependencies for source in get_sources(records, item)),
    )


def depends_on(records: Records, feature: Feature, ids: Collection[str]) -> bool:
    """Return whether editing the records `ids` may change the measurement of a feature."""
    if PROFILE_ID in ids:
        return True
    if isinstance(feature, ModelFeature) and feature.model_id in ids:
        return True
    if isinstance(feature, TypedFeature) and feature.type_id in ids:
        return True
    kind = get_kind(feature)
    if kind.has_dynamic_dependencies:
        # Members of its groups may have changed; such features are few and are measured again.
        return True
    ids_of_dependencies = kind.dependency_ids(feature)
    if not ids_of_dependencies:
        return False
    return any(id_ in ids for id_ in ids_of_dependencies) or any(
        record.id in ids for record in get_sources(records, feature) if record is not None
    )


def measure_all(
    records: Records,
    features: Sequence[Feature],
    default_thresholds: Thresholds | None = None,
    known_measurements: Mapping[str, Measurement] | None = None,
) -> list[Measurement]:
    """Measure features in one batch per kind.

    Parameters
    ----------
    records : Records
    features : sequence of Feature
    default_thresholds : Thresholds or None
        Thresholds for a project that has no profile.
    known_measurements : mapping of str to Measurement, optional
        Measurements of dependencies that have already been computed, by feature ID.
    """
    thresholds = get_limits(records, default_thresholds or Thresholds())
    known_measurements = dict(known_measurements or {})
    dependencies = {
        item.id: item
        for feature in features
        for item in get_kind(feature).dependencies(records, feature)
    }
    missing_ids = [item for id_, item in dependencies.items() if id_ not in known_measurements]
    if missing_ids:
        measurements = measure_all(records, missing_ids, thresholds)
        known_measurements |= {
            item.id: measurement
            for item, measurement in zip(missing_ids, measurements, strict=True)
        }
    inputs = MeasurementContext(records, thresholds, known_measurements)
    features_by_kind: dict[Kind, list[Feature]] = {}
    for feature in features:
        features_by_kind.setdefault(get_kind(feature), []).append(feature)
    measurements_by_kind = {
        kind: iter(kind.measure(inputs, batch)) for kind, batch in features_by_kind.items()
    }
    return [next(measurements_by_kind[get_kind(feature)]) for feature in features]


def measure_feature(
    feature: Feature, model: Model | None, thresholds: Thresholds | None = None
) -> Measurement:
    """Measure one feature. Raises GeometryError if it cannot be measured."""
    records: dict[str, Record] = {} if model is None else {model.id: model}
    measurement = measure_all(records, [feature], thresholds)[0]
    if measurement.problem is not None:
        raise GeometryError(measurement.problem, field=feature.name or None)
    return measurement
