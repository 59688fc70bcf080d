"""Features of a project as rows of the orientation table, for exports and the window."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, Thresholds
from vomstudio.geometry.frames import crs_label
from vomstudio.geometry.units import WORLD_AXES, Axes
from vomstudio.project.catalogue import DOMAIN, GRID_NORTH_TEXT, MISSING_MODEL_TEXT, STATION
from vomstudio.project.figures import Subject
from vomstudio.project.kind import Kind
from vomstudio.project.kinds import get_kind
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.reading_comparison import nearest_picks
from vomstudio.project.records import Feature, Model, ModelFeature, Record, get, get_limits
from vomstudio.project.repeated_features import COLUMNS as REPEAT_COLUMNS
from vomstudio.project.repeated_features import repeat_columns
from vomstudio.project.tables.orientation_table import Row, build_rows
from vomstudio.project.tables.registration_comments import find_registrations

__all__ = [
    "EXTRA_COLUMNS",
    "GRID_NORTH_TEXT",
    "MISSING_MODEL_TEXT",
    "UNKNOWN_NORTH_TEXT",
    "ProjectTable",
    "feature_rows",
    "project_table",
]
UNKNOWN_NORTH_TEXT = to_translate(
    "unknown: the model is not registered, azimuths are in its local frame"
)

_FIGURES = (DOMAIN, STATION)
EXTRA_COLUMNS = (*(figure.name for figure in _FIGURES), *REPEAT_COLUMNS)
"""Columns that follow those of the orientation table if any feature has a value in them."""


@dataclass(frozen=True)
class ProjectTable:
    """Rows in the order of the records, and the features that have no orientation."""

    rows: list[Row]
    skipped: list[dict[str, Any]]
    """ID, name and reason of each skipped feature."""
    crs: str | None
    """CRS of all rows, or None if they have no common CRS."""
    north: str
    files: tuple[Path, ...] = ()
    """Files written by an export."""
    layers: Mapping[str, int] = field(default_factory=dict)
    """Number of features in each written layer."""
    features: int | None = None
    """Number of distinct features in the layers, or None if only the rows were written."""
    unit_m: float = 1.0
    """Metres per unit of `crs`; the rows are always in metres."""
    axes: Axes = WORLD_AXES
    """Axes and units of x, y, z and lengths of all rows."""
    limits: Thresholds = DEFAULT_THRESHOLDS
    """Thresholds with which all rows were judged."""
    warnings: tuple[Finding, ...] = ()
    """Findings about an export."""
    registrations: tuple[dict[str, Any], ...] = ()
    """Result of `registration_comments.find_registrations`."""

    @property
    def extra_columns(self) -> tuple[str, ...]:
        """Optional columns that are in use: domain, station, interpreter and repeated feature."""
        return tuple(column for column in EXTRA_COLUMNS if any(column in row for row in self.rows))

    def drop_repeats(self) -> ProjectTable:
        """Return the table without repeats, for programs that would count them as structures."""
        repeats = [row for row in self.rows if "repeat_of" in row]
        if not repeats:
            return self
        names = {row["id"]: row["name"] for row in self.rows}
        skipped_repeats = [
            {
                "id": row["id"],
                "name": row["name"],
                "reason": Finding("repeats.not-exported", first=names.get(row["repeat_of"])),
            }
            for row in repeats
        ]
        rows = [row for row in self.rows if "repeat_of" not in row]
        return replace(self, rows=rows, skipped=[*self.skipped, *skipped_repeats])


def project_table(
    records: Mapping[str, Record],
    measurements: Measurements | None = None,
    feature_ids: Collection[str] | None = None,
) -> ProjectTable:
    """Return the planes and lines of a project as rows, all or only those with given IDs."""
    features = [
        record
        for record in records.values()
        if isinstance(record, Feature)
        and get_kind(record).orientations
        and (feature_ids is None or record.id in feature_ids)
    ]
    measurements = measurements or Measurements()
    measurements_by_id = measurements.of(records, [feature.id for feature in features])
    picks = nearest_picks(records, measurements)
    subjects = [
        Subject(feature, measurements_by_id[feature.id], records, partial(picks.get, feature.id))
        for feature in features
    ]
    rows: list[Row] = []
    skipped_rows: list[dict[str, Any]] = []
    for subject, row in zip(subjects, feature_rows(subjects), strict=True):
        if row is None:
            feature = subject.feature
            reason = subject.measured.problem or Finding("feature.without-plane")
            skipped_rows.append({"id": feature.id, "name": feature.name, "reason": reason})
        else:
            rows.append(row)
    placed_features = [*features, *_listed_features(records, feature_ids)] or _features_on_models(
        records, feature_ids
    )
    crs, north, unit_m = _frame(records, placed_features)
    axes = _axes(records, placed_features)
    limits = get_limits(records, measurements.default_thresholds)
    registrations = tuple(find_registrations(records, features))
    return ProjectTable(
        rows,
        skipped_rows,
        crs,
        north,
        unit_m=unit_m,
        axes=axes,
        limits=limits,
        registrations=registrations,
    )


def feature_rows(subjects: Sequence[Subject]) -> list[Row | None]:
    """Return the row of each feature, or None if it has no orientation.

    Remarks of the kind that do not have their own column are appended to the notes.
    """
    rows: list[Row | None] = [None] * len(subjects)
    kinds: dict[Kind, list[int]] = {}
    for i, subject in enumerate(subjects):
        if subject.measured.plane is not None or subject.measured.line is not None:
            kinds.setdefault(get_kind(subject.feature), []).append(i)
    for kind, indices in kinds.items():
        kind_rows = build_rows([subjects[i] for i in indices], kind.figures)
        for i, row in zip(indices, kind_rows, strict=True):
            notes = [subjects[i].feature.notes, *kind.remarks(subjects[i])]
            row["notes"] = "; ".join(filter(None, notes)) or None
            row |= _extra_values(subjects[i])
            rows[i] = row
    return rows


def _extra_values(subject: Subject) -> Row:
    values = {
        figure.name: value for figure in _FIGURES if (value := figure.value(subject)) is not None
    }
    return values | repeat_columns(subject.feature, subject.records)


def _listed_features(
    records: Mapping[str, Record], feature_ids: Collection[str] | None
) -> list[Feature]:
    """Return the features on layers that are listed although they have no orientation."""
    return [
        feature for feature in _features_on_models(records, feature_ids) if get_kind(feature).listed
    ]


def _features_on_models(
    records: Mapping[str, Record], feature_ids: Collection[str] | None
) -> list[Feature]:
    features = (record for record in records.values() if isinstance(record, ModelFeature))
    return [feature for feature in features if feature_ids is None or feature.id in feature_ids]


def _axes(records: Mapping[str, Record], features: list[Feature]) -> Axes:
    """Return the common axis properties of all models that have features."""
    models = [
        get(records, feature.model_id, Model)
        for feature in features
        if isinstance(feature, ModelFeature)
    ]
    axes = [model.frame.axes for model in models if model is not None]
    return Axes(all(axis.metric for axis in axes), all(axis.north for axis in axes))


def _frame(records: Mapping[str, Record], features: list[Feature]) -> tuple[str | None, str, float]:
    """Return the common CRS, north reference, and metres per unit of the CRS of all rows.

    Compass readings and intersections use the frame of the other features.
    """
    models = [
        get(records, feature.model_id, Model)
        for feature in features
        if isinstance(feature, ModelFeature)
    ]
    frames = {None if model is None else model.frame for model in models}
    if not models and features:
        return None, tr(GRID_NORTH_TEXT), 1.0
    if len(frames) != 1:
        return None, tr("see the column frame"), 1.0
    frame = frames.pop()
    if frame is None or not frame.has_north:
        return None, tr(UNKNOWN_NORTH_TEXT), 1.0
    if frame.crs:
        return frame.crs, tr("grid north of {crs}", crs=crs_label(frame.crs)), frame.unit_m
    return None, tr("local frame whose y axis the user declared as north"), 1.0
