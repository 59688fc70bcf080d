"""Quantities derived from the records, such as measurements and nearest picks."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from vomstudio.core.findings import Finding
from vomstudio.geology.profiles import Thresholds
from vomstudio.project.edit import Edit
from vomstudio.project.figures import Subject
from vomstudio.project.kinds import KINDS
from vomstudio.project.measurement import Measurement
from vomstudio.project.measurement_cache import Measurements, depends_on
from vomstudio.project.reading_comparison import NearestPick, nearest_picks
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import Feature, Model
from vomstudio.studio.projects import Projects


class DerivedQuantities:
    """Cache of derived quantities, which are recomputed when needed after an edit."""

    def __init__(self, projects: Projects, thresholds: Callable[[], Thresholds]) -> None:
        self._projects, self._thresholds = projects, thresholds
        self.measurements = Measurements(thresholds())
        self._nearest_picks: dict[str, NearestPick] | None = None
        self._cached_affected_ids: tuple[Edit, list[str]] | None = None

    def begin(self) -> None:
        """Reset the cache for another project."""
        self.measurements = self._projects.measurements or Measurements(self._thresholds())
        self._nearest_picks = None
        self._cached_affected_ids = None

    def refresh(self, edit: Edit) -> None:
        """Discard the quantities that an edit has changed."""
        self._nearest_picks = None
        self._cached_affected_ids = None
        self.measurements.keep_after_edit(self._projects.records, self.affected_ids(edit))

    # --- measurements -------------------------------------------------------------------------
    def measured(self, ids: Iterable[str]) -> dict[str, Measurement]:
        """Return the measurements of features in the project, keyed by id."""
        return self.measurements.of(self._projects.records, ids)

    def store_expected_measurements(
        self, measured_pairs: Iterable[tuple[Feature, Measurement]], thresholds: Thresholds
    ) -> None:
        """Store measurements in advance for features that are about to be added."""
        self.measurements.keep(self._projects.records, measured_pairs, thresholds)

    def measure(self, feature: Feature) -> Measurement:
        """Measure a feature that is not part of the project."""
        return self.measurements.measure(self._projects.records, feature)

    def nearest_pick(self, reading_id: str) -> NearestPick | None:
        """Return the pick nearest to a compass reading, or None if there are no picks."""
        if self._nearest_picks is None:
            self._nearest_picks = nearest_picks(self._projects.records, self.measurements)
        return self._nearest_picks.get(reading_id)

    def subject(self, feature: Feature, measured: Measurement) -> Subject:
        """Return a feature with all inputs from which its figures are computed."""
        nearest_pick = partial(self.nearest_pick, feature.id)
        return Subject(feature, measured, self._projects.records, nearest_pick)

    # --- the models' frames ------------------------------------------------------------------
    def is_north_known(self) -> bool:
        """Return whether north is known for every model; False if the project has no models."""
        models = self._projects.of(Model)
        return bool(models) and all(m.frame.has_north for m in models)

    def turn_findings(self) -> tuple[Finding, ...]:
        """Return findings on registrations with orientation errors too large for planes."""
        models = self._projects.of(Model)
        registrations = dict.fromkeys(m.registration for m in models if m.registration)
        if not registrations:
            return ()
        from vomstudio.registration.rotation_uncertainty import turn_findings

        registration_findings = (
            turn_findings(registration.rotation_covariance()) for registration in registrations
        )
        return tuple(finding for findings in registration_findings for finding in findings)

    def are_metres_known(self) -> bool:
        """Return whether the scale of every model of the project is known."""
        return all(m.frame.has_metres for m in self._projects.of(Model))

    def crs_codes(self) -> list[str]:
        """Return the distinct CRS of the models, from the newest model to the oldest."""
        crs = (model.frame.crs for model in reversed(self._projects.of(Model)))
        return list(dict.fromkeys(code for code in crs if code is not None))

    def frame_name(self) -> str:
        """Return the distinct names of the models' frames as one text, separated by slashes."""
        names = list(dict.fromkeys(m.frame.name() for m in self._projects.of(Model)))
        return " / ".join(names)

    # --- dependencies of edits ----------------------------------------------------------------
    def affected_ids(self, edit: Edit) -> list[str]:
        """Return the ids of the features that an edit affects, including deleted features.

        These are the edited features, the features on edited models or of edited feature types,
        and all features that depend on them.
        """
        # Cached because every view of the window requests this for the same edit.
        if self._cached_affected_ids is None or self._cached_affected_ids[0] is not edit:
            self._cached_affected_ids = (edit, _affected_ids(self._projects.records, edit))
        return list(self._cached_affected_ids[1])


def _affected_ids(records: RecordMap, edit: Edit) -> list[str]:
    ids = edit.ids
    parts = [edit.before[i] or edit.after[i] for i in edit.after]
    changed_features = [i for i, r in zip(edit.after, parts, strict=True) if isinstance(r, Feature)]
    # Most features depend only on their model and their type, which are not features.
    may_affect_all = len(changed_features) < len(ids)
    dependents = [
        feature
        for feature_kind in KINDS
        if may_affect_all or feature_kind.depends_on_features
        for feature in records.of(feature_kind.record)
        if feature.id not in ids
    ]
    return changed_features + [f.id for f in dependents if depends_on(records, f, ids)]
