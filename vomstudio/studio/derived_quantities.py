"""Quantities that follow from the records: measurements, nearest picks, known frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from vomstudio.core.findings import Finding
from vomstudio.geology.profiles import Thresholds
from vomstudio.project.edit import Edit
from vomstudio.project.figures import Subject
from vomstudio.project.kinds import KINDS
from vomstudio.project.kinds.reading import comparison_text
from vomstudio.project.measurement import Measurement
from vomstudio.project.measurement_cache import Measurements, depends_on
from vomstudio.project.reading_comparison import NearestPick, nearest_picks
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import Feature, Model
from vomstudio.studio.projects import Projects


class DerivedQuantities:
    """Computed when they are asked for, and anew after an edit."""

    def __init__(self, projects: Projects, thresholds: Callable[[], Thresholds]) -> None:
        self._projects, self._thresholds = projects, thresholds
        self.measurements = Measurements(thresholds())
        self._nearest: dict[str, NearestPick] | None = None
        self._affected: tuple[Edit, list[str]] | None = None

    def begin(self) -> None:
        """Another project has been opened."""
        self.measurements = self._projects.measurements or Measurements(self._thresholds())
        self._nearest = None
        self._affected = None

    def refresh(self, edit: Edit) -> None:
        """Forget what an edit has changed."""
        self._nearest = None
        self._affected = None
        self.measurements.keep_after_edit(self._projects.records, self.affected(edit))

    # --- figures -----------------------------------------------------------------------------
    def measured(self, ids: Iterable[str]) -> dict[str, Measurement]:
        """The measurements of features of the project, by id."""
        return self.measurements.of(self._projects.records, ids)

    def foresee(
        self, measured: Iterable[tuple[Feature, Measurement]], judged_by: Thresholds
    ) -> None:
        """Features that are about to be added, with their measurements."""
        self.measurements.keep(self._projects.records, measured, judged_by)

    def measure(self, feature: Feature) -> Measurement:
        """The measurement of a feature that is not in the document."""
        return self.measurements.measure(self._projects.records, feature)

    def nearest_pick(self, reading_id: str) -> NearestPick | None:
        """The pick with which a compass reading is compared, computed for all readings at once."""
        if self._nearest is None:
            self._nearest = nearest_picks(self._projects.records, self.measurements)
        return self._nearest.get(reading_id)

    def nearest_text(self, reading_id: str) -> str:
        """How far a reading is from the nearest pick, and from which, in words."""
        return comparison_text(self.nearest_pick(reading_id))

    def subject(self, feature: Feature, measured: Measurement) -> Subject:
        """A feature of the project with what its figures are read from."""
        nearest = partial(self.nearest_pick, feature.id)
        return Subject(feature, measured, self._projects.records, nearest)

    # --- the models' frames ------------------------------------------------------------------
    def north_known(self) -> bool:
        """Every model of the project knows its north."""
        models = self._projects.of(Model)
        return bool(models) and all(m.frame.has_north for m in models)

    def turn_findings(self) -> tuple[Finding, ...]:
        """Findings on registrations that make planes on their models poor."""
        models = self._projects.of(Model)
        registrations = dict.fromkeys(m.registration for m in models if m.registration)
        if not registrations:
            return ()
        from vomstudio.registration.turn_checks import turn_findings

        each = (turn_findings(one.rotation_covariance()) for one in registrations)
        return tuple(finding for findings in each for finding in findings)

    def metres_known(self) -> bool:
        """No model of the project is of unknown scale."""
        return all(m.frame.has_metres for m in self._projects.of(Model))

    def frame_name(self) -> str:
        """The names of the models' frames, each once."""
        names = list(dict.fromkeys(m.frame.name() for m in self._projects.of(Model)))
        return " / ".join(names)

    # --- what an edit touches ----------------------------------------------------------------
    def affected(self, edit: Edit) -> list[str]:
        """The ids of features that look different after an edit: its own, those of its models and
        feature types, and those that depend on them. Deleted ones are among them."""
        # Every view of the window asks for those of the same edit.
        if self._affected is None or self._affected[0] is not edit:
            self._affected = (edit, _affected(self._projects.records, edit))
        return list(self._affected[1])


def _affected(records: RecordMap, edit: Edit) -> list[str]:
    ids = edit.ids
    parts = [edit.before[i] or edit.after[i] for i in edit.after]
    own = [i for i, r in zip(edit.after, parts, strict=True) if isinstance(r, Feature)]
    # Most features rest on their model and their type alone, and neither is a feature.
    all_may = len(own) < len(ids)
    others = [
        feature
        for kind in KINDS
        if all_may or kind.depends_on_features
        for feature in records.of(kind.record)
        if feature.id not in ids
    ]
    return own + [f.id for f in others if depends_on(records, f, ids)]
