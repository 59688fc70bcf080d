"""A project's features as rows of the orientation table, for every way out and for the window."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.profiles import DEFAULTS, Thresholds
from vomstudio.geometry.frames import crs_label
from vomstudio.geometry.units import WORLD, Axes
from vomstudio.project.catalogue import DOMAIN, IN_WORLD, NO_MODEL
from vomstudio.project.figures import Subject
from vomstudio.project.kind import Kind
from vomstudio.project.kinds import kind_of
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.reading_comparison import nearest_picks
from vomstudio.project.records import Feature, Model, OnAModel, Record, get, limits_of
from vomstudio.project.repeated_features import COLUMNS as REPEAT_COLUMNS
from vomstudio.project.repeated_features import told
from vomstudio.project.tables.orientation_table import Row, rows_of
from vomstudio.project.tables.registration_comments import registrations_of

__all__ = ["FURTHER", "IN_WORLD", "NO_MODEL", "ProjectTable", "feature_rows", "project_table"]

FURTHER = ("domain", *REPEAT_COLUMNS)
"""Columns of the orientation table that stand behind the others where any feature has one."""


@dataclass(frozen=True)
class ProjectTable:
    """Rows in the order of the records, and the features that have no orientation."""

    rows: list[Row]
    skipped: list[dict[str, Any]]
    """id, name and reason of each."""
    crs: str | None
    """The one CRS of all rows, None where there is none, or more than one."""
    north: str
    files: tuple[Path, ...] = ()
    """What an export has written."""
    layers: Mapping[str, int] = field(default_factory=dict)
    """How many features each layer has that was written."""
    features: int | None = None
    """How many features these are together, each once; None where only the rows were written."""
    unit_m: float = 1.0
    """Metres in a unit of `crs`; the rows are in metres whatever it is."""
    axes: Axes = WORLD
    """What is known of x, y, z and lengths of all rows."""
    limits: Thresholds = DEFAULTS
    """By which all rows were judged."""
    registrations: tuple[dict[str, Any], ...] = ()
    """As `registration_lines.registrations_of` tells them."""

    @property
    def more(self) -> tuple[str, ...]:
        """The columns behind the others: domains, who picked what, and what repeats another."""
        return tuple(c for c in FURTHER if any(c in row for row in self.rows))

    def without_repeats(self) -> ProjectTable:
        """For programs that would take a second pick for a second structure."""
        again = [row for row in self.rows if "repeat_of" in row]
        if not again:
            return self
        names = {row["id"]: row["name"] for row in self.rows}
        left = [
            {
                "id": row["id"],
                "name": row["name"],
                "reason": Finding("repeats.not-exported", first=names.get(row["repeat_of"])),
            }
            for row in again
        ]
        rows = [row for row in self.rows if "repeat_of" not in row]
        return replace(self, rows=rows, skipped=[*self.skipped, *left])


def project_table(
    records: Mapping[str, Record],
    measurements: Measurements | None = None,
    only: Collection[str] | None = None,
) -> ProjectTable:
    """All planes and lines of a document as rows, in World. only : the ids of some of them"""
    features = [
        r
        for r in records.values()
        if isinstance(r, Feature) and kind_of(r).orientations and (only is None or r.id in only)
    ]
    measurements = measurements or Measurements()
    measured = measurements.of(records, [feature.id for feature in features])
    picks = nearest_picks(records, measurements)
    subjects = [Subject(f, measured[f.id], records, partial(picks.get, f.id)) for f in features]
    rows: list[Row] = []
    skipped: list[dict[str, Any]] = []
    for subject, row in zip(subjects, feature_rows(subjects), strict=True):
        if row is None:
            feature = subject.feature
            reason = subject.measured.problem or Finding("feature.without-plane")
            skipped.append({"id": feature.id, "name": feature.name, "reason": reason})
        else:
            rows.append(row)
    placed = [*features, *_listed(records, only)] or _on_models(records, only)
    crs, north, unit_m = _frame(records, placed)
    axes = _axes(records, placed)
    limits = limits_of(records, measurements.otherwise)
    told = tuple(registrations_of(records, features))
    return ProjectTable(
        rows, skipped, crs, north, unit_m=unit_m, axes=axes, limits=limits, registrations=told
    )


def feature_rows(subjects: Sequence[Subject]) -> list[Row | None]:
    """The row of each feature, None where it has no orientation. What its kind remarks, for which
    there is no column, stands in its notes."""
    rows: list[Row | None] = [None] * len(subjects)
    kinds: dict[Kind, list[int]] = {}
    for i, subject in enumerate(subjects):
        if subject.measured.plane is not None or subject.measured.line is not None:
            kinds.setdefault(kind_of(subject.feature), []).append(i)
    for kind, own in kinds.items():
        made = rows_of([subjects[i] for i in own], kind.figures)
        for i, row in zip(own, made, strict=True):
            said = [subjects[i].feature.notes, *kind.remarks(subjects[i])]
            row["notes"] = "; ".join(filter(None, said)) or None
            row |= _further(subjects[i])
            rows[i] = row
    return rows


def _further(subject: Subject) -> Row:
    domain = DOMAIN.value(subject)
    own = {} if domain is None else {DOMAIN.name: domain}
    return own | told(subject.feature, subject.records)


def _listed(records: Mapping[str, Record], only: Collection[str] | None) -> list[Feature]:
    """What is interpreted without an orientation: layers have it beside the rows."""
    return [f for f in _on_models(records, only) if kind_of(f).listed]


def _on_models(records: Mapping[str, Record], only: Collection[str] | None) -> list[Feature]:
    wanted = (r for r in records.values() if isinstance(r, OnAModel))
    return [r for r in wanted if only is None or r.id in only]


def _axes(records: Mapping[str, Record], features: list[Feature]) -> Axes:
    """What is known of the axes of every model that was measured on."""
    models = [get(records, f.model_id, Model) for f in features if isinstance(f, OnAModel)]
    axes = [model.frame.axes for model in models if model is not None]
    return Axes(all(a.metric for a in axes), all(a.north for a in axes))


def _frame(records: Mapping[str, Record], features: list[Feature]) -> tuple[str | None, str, float]:
    """CRS, north, and metres in a unit of the CRS, of all rows together; compass readings and
    intersections go by the others."""
    models = [get(records, f.model_id, Model) for f in features if isinstance(f, OnAModel)]
    frames = {None if model is None else model.frame for model in models}
    if not models and features:
        return None, tr(IN_WORLD), 1.0
    if len(frames) != 1:
        return None, tr("see the column frame"), 1.0
    frame = frames.pop()
    if frame is None or not frame.has_north:
        north = tr("unknown: the model is not registered, azimuths are in its local frame")
        return None, north, 1.0
    if frame.crs:
        return frame.crs, tr("grid north of {crs}", crs=crs_label(frame.crs)), frame.unit_m
    return None, tr("local frame whose y axis the user declared as north"), 1.0
