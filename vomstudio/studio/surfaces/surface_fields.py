"""Fields that are worked out for the open models, shown as colours, and kept up to date."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from typing import Any

import numpy as np

from vomstudio.core.arrays import GenericArray
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.extraction.surface_fields import KINDS, field_name
from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry import transform
from vomstudio.geometry.field_style import FieldStyle
from vomstudio.geometry.mesh import Mesh
from vomstudio.project.edit import Edit
from vomstudio.project.measurement import ToWorld
from vomstudio.project.records import Feature, Model, get_feature
from vomstudio.registration.distances.compare_options import CompareOptions
from vomstudio.studio.background import Background
from vomstudio.studio.derived_quantities import DerivedQuantities
from vomstudio.studio.display import Display
from vomstudio.studio.jobs.surface_tasks import (
    COMPUTE_FIELDS,
    MAP_MEASURABLE,
    ComputedFields,
    FieldsOrder,
    MeasurableOrder,
)
from vomstudio.studio.model_loading import OpenModel
from vomstudio.studio.models import Models
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs
from vomstudio.studio.surfaces.measurable_planes import (
    EXPECTED,
    MEASURABLE,
    map_names,
    plane_meant,
)
from vomstudio.studio.surfaces.model_jobs import ModelWork

TO_PLANE, TO_MODEL = "plane", "model"
_OTHERS = (TO_PLANE, TO_MODEL, MEASURABLE, EXPECTED)
_RESOLUTIONS, _OF_TRACE = 5.0, 100.0
"""The radius that is proposed, in resolutions of the model, and the length of a trace."""
_STYLES: dict[str, dict[str, Any]] = {
    "dip": {"low": 0.0, "high": 90.0},
    # White is vertical.
    "steepness": {"low": 30.0, "high": 150.0, "palette": "RdBu_r"},
    "roughness": {"low": 0.0},
    "collinearity": {"low": 0.0},
    # Yellow is what no pick will tell.
    EXPECTED: {"low": 0.0, "high": 15.0},
}

Arrays = dict[str, GenericArray]
FieldsResult = tuple[Arrays, tuple[Finding, ...]]


@dataclass(frozen=True)
class WantedField:
    """kind : a key of `extraction.surface_fields.KINDS`, TO_PLANE, TO_MODEL, MEASURABLE or
    EXPECTED; radius_m : of the first, and the length of a trace of the last two; of : the id of the
    feature or of the other model, or what `measurable_planes.plane_meant` reads"""

    kind: str
    radius_m: float = 0.0
    of: str = ""

    @classmethod
    def from_dict(cls, values: Any) -> WantedField | None:
        """What a project has kept; None where it is none."""
        try:
            made = cls(str(values["kind"]), float(values["radius_m"]), str(values["of"]))
        except (KeyError, TypeError, ValueError):
            return None
        known = made.kind in KINDS or made.kind in _OTHERS
        return made if known and 0.0 <= made.radius_m < np.inf else None


@dataclass(frozen=True)
class Shown:
    """What is shown of a model: the wish, the name among its fields, what it rests on, the colours
    where they were chosen, and the findings about it."""

    wanted: WantedField
    name: str
    rests_on: object
    palette: str | None = None
    findings: tuple[Finding, ...] = ()


class SurfaceFields(ModelWork):
    """Fields of open models that are computed on request.

    Attributes
    ----------
    shown : dict of str to Shown
        The field that each model shows, by the id of the model.
    """

    def __init__(
        self,
        projects: Projects,
        models: Models,
        derived: DerivedQuantities,
        display: Display,
        jobs: Jobs,
        background: Background,
    ) -> None:
        super().__init__(projects, jobs, background)
        self._models, self._derived, self._display = models, derived, display
        self.shown: dict[str, Shown] = {}
        self._made: dict[str, set[str]] = {}
        models.loaded.connect(self._loaded)

    # --- what can be asked -------------------------------------------------------------------
    def why_not(self, model_id: str) -> Finding | None:
        """Return why no field can be computed for this model; None if one can."""
        opened = self._models.open.get(model_id)
        if opened is None:
            return Finding("model.not-open")
        count = len(opened.data.vertices) if isinstance(opened.data, Mesh) else opened.data.count
        held = len(opened.data.vertices if isinstance(opened.data, Mesh) else opened.data.points)
        if held != count:
            return Finding("model.cloud-too-large", model=self._projects.name_of(model_id))
        return None

    def likely_radius(self, model_id: str) -> float:
        """Five resolutions of a model, m, with two digits."""
        opened, record = self._models.open.get(model_id), self._projects.records.get(model_id)
        if opened is None or not isinstance(record, Model) or not opened.resolution:
            return 0.5
        radius = _RESOLUTIONS * opened.resolution * transform.scale_of(record.to_world)
        return float(f"{max(radius, 1e-6):.2g}")

    def likely_length(self, model_id: str) -> float:
        """Of a trace, m: that of a feature worth measuring (section 4.1.3)."""
        return float(f"{_OF_TRACE / _RESOLUTIONS * self.likely_radius(model_id):.2g}")

    def plane_meant(self, wanted: WantedField) -> Plane | None:
        """Of a map of measurable planes; None where there is none."""
        return plane_meant(self._projects.records, self._derived, wanted.of)

    def name_of(self, model_id: str, wanted: WantedField) -> str | None:
        """The name of a field among those of the model; None where what it is of is gone."""
        records = self._projects.records
        model = records.get(model_id)
        if not isinstance(model, Model):
            return None
        if wanted.kind in KINDS:
            return field_name(wanted.kind, wanted.radius_m, metric=model.frame.has_metres)
        if wanted.kind in (MEASURABLE, EXPECTED):
            plane = self.plane_meant(wanted)
            if plane is None:
                return None
            names = map_names(plane, wanted.radius_m, metric=model.frame.has_metres)
            return names[wanted.kind]
        other: Feature | Model | None = get_feature(records, wanted.of)
        if wanted.kind == TO_MODEL:
            found = records.get(wanted.of)
            other = found if isinstance(found, Model) else None
        if other is None:
            return None
        unit = "m" if model.frame.has_metres else "units"
        what = "plane of " if wanted.kind == TO_PLANE else ""
        return f"distance to {what}{other.name} [{unit}]"

    # --- asking ------------------------------------------------------------------------------
    def ask(self, model_id: str, wanted: WantedField, palette: str | None = None) -> None:
        """Work a field out and show it; what is being worked out is given up."""
        self.stop()
        self.findings = ()
        why = self.why_not(model_id)
        name = self.name_of(model_id, wanted)
        if why is not None:
            self._report(why)
            return
        if name is None:
            self._report(Finding("field.feature-missing"))
            return
        shown = Shown(wanted, name, self._rests_on(model_id, wanted), palette)
        if wanted.kind == TO_PLANE:
            self._ask_plane(model_id, shown)
        elif wanted.kind == TO_MODEL:
            self._ask_distances(model_id, shown)
        elif wanted.kind in (MEASURABLE, EXPECTED):
            self._ask_measurable(model_id, shown)
        else:
            self._ask_surface(model_id, shown)
        self.changed.emit()

    def _ask_surface(self, model_id: str, shown: Shown) -> None:
        # All fields of a radius are computed together.
        model = self._model(model_id)
        if model is None:
            return
        (standing, record), radius = model, shown.wanted.radius_m
        data = self._models.open[model_id].data
        if shown.name in data.fields and shown.name in self._made.get(model_id, ()):
            self._show(model_id, shown, {}, self.shown[model_id].findings)
            return
        metric = record.frame.has_metres
        key = sha256(repr((record.content_hash, record.to_world)).encode()).hexdigest()
        out = standing.cache / "fields" / f"{record.content_hash[:16]}.npz"

        def read() -> Arrays:
            with open_arrays(out) as found:
                return {field_name(k, radius, metric=metric): found[k] for k in KINDS}

        def computed(fields: ComputedFields) -> None:
            self._deliver(model_id, shown, lambda: (read(), fields.warnings))

        self._submit(
            COMPUTE_FIELDS,
            FieldsOrder(standing, radius, key, out),
            tr("Fields of {model} within {radius:g} m", model=record.name, radius=radius),
            computed,
        )

    def _ask_measurable(self, model_id: str, shown: Shown) -> None:
        # Both fields are computed together.
        model, plane = self._model(model_id), self.plane_meant(shown.wanted)
        if model is None or plane is None:
            return
        standing, record = model
        data, length = self._models.open[model_id].data, shown.wanted.radius_m
        if shown.name in data.fields and shown.name in self._made.get(model_id, ()):
            self._show(model_id, shown, {}, self.shown[model_id].findings)
            return
        names = map_names(plane, length, metric=record.frame.has_metres)
        x, y, z = (float(v) for v in plane.normal())
        out = standing.cache / "fields" / f"{model_id}-measurable.npz"
        tilt = ToWorld.from_model(record).tilt_deg(plane.normal()) or 0.0
        options = MeasurableOptions(length_m=length, registration_error_deg=tilt)

        def read() -> Arrays:
            with open_arrays(out) as found:
                arrays = {names[MEASURABLE]: found["measurable"]}
                arrays[names[EXPECTED]] = found["expected_error95_deg"]
                return arrays

        self._submit(
            MAP_MEASURABLE,
            MeasurableOrder(standing, (x, y, z), options, out),
            tr(
                "Where planes of {plane} could be measured on {model}",
                model=record.name,
                plane=format_plane(plane),
            ),
            lambda mapped: self._deliver(model_id, shown, lambda: (read(), mapped.findings)),
        )

    def _ask_distances(self, model_id: str, shown: Shown) -> None:
        model, other_model = self._model(model_id), self._model(shown.wanted.of)
        if model is None or other_model is None:
            return
        standing, other = model[0], other_model[0]
        from vomstudio.studio.jobs.registration_tasks import COMPARE_MODELS, CompareOrder

        out = standing.cache / "fields" / f"{model_id}-distance.npz"

        def read() -> FieldsResult:
            with open_arrays(out) as found:
                return {shown.name: found["distance_m"].astype(np.float32)}, ()

        self._submit(
            COMPARE_MODELS,
            CompareOrder(standing, other, CompareOptions(), out),
            tr("Distances from {model} to {other}", model=standing.name, other=other.name),
            lambda _: self._deliver(model_id, shown, read),
        )

    def _ask_plane(self, model_id: str, shown: Shown) -> None:
        plane, record = shown.rests_on, self._projects.records[model_id]
        assert isinstance(record, Model)
        if not isinstance(plane, tuple) or plane[1] is None:
            self._report(Finding("field.no-plane"))
            return
        centre, normal = np.array(plane[1]), np.array(plane[2])
        data, rows = self._models.open[model_id].data, record.to_world

        def work() -> FieldsResult:
            places = data.vertices if isinstance(data, Mesh) else data.points
            off = (transform.apply(rows, places) - centre) @ normal
            return {shown.name: off.astype(np.float32)}, ()

        self._deliver(model_id, shown, work)

    def _deliver(self, model_id: str, shown: Shown, work: Callable[[], FieldsResult]) -> None:
        """Read or compute fields in a worker thread, and show them."""
        self._read(work, lambda result: self._show(model_id, shown, *result))

    # --- showing -----------------------------------------------------------------------------
    def _show(
        self, model_id: str, shown: Shown, arrays: Arrays, findings: tuple[Finding, ...]
    ) -> None:
        opened = self._models.open.get(model_id)
        if opened is None:
            return
        before = self._display.styles.get(model_id)
        kept = before if before is not None and before.name == shown.name else None
        if arrays:
            # Those of another radius or place would stand beside them in every list. The name may
            # be the same, but the values are others.
            if before is not None and before.name in self._made.get(model_id, ()):
                self._display.show_no_field(model_id)
            opened.drop_fields(self._made.pop(model_id, ()))
            if not opened.give_fields(arrays):
                self._report(Finding("model.fields-too-large"))
                return
            self._made[model_id] = set(arrays)
        self.shown[model_id] = replace(shown, findings=findings)
        self._display.computed[model_id] = asdict(shown.wanted)
        style = kept or FieldStyle(shown.name, **_STYLES.get(shown.wanted.kind, {}))
        if shown.palette is not None:
            style = replace(style, palette=shown.palette)
        self._display.show_field(model_id, style)
        self._report(*findings)

    # --- what has happened meanwhile -----------------------------------------------------------
    def begin(self) -> None:
        """Another project has been opened."""
        self.running, self.findings = None, ()
        self._background.cancel_all()
        self.shown.clear()
        self._made.clear()
        self.changed.emit()

    def edited(self, edit: Edit) -> None:
        """A model was placed anew, or the feature changed whose plane counts."""
        for model_id, shown in list(self.shown.items()):
            now = self._rests_on(model_id, shown.wanted)
            if now == shown.rests_on:
                continue
            opened = self._models.open.get(model_id)
            style = self._display.styles.get(model_id)
            seen = style is not None and style.name in self._made.get(model_id, ())
            del self.shown[model_id]
            if opened is not None:
                if seen:
                    self._display.show_no_field(model_id)
                opened.drop_fields(self._made.pop(model_id, ()))
            if opened is not None and seen and self.name_of(model_id, shown.wanted):
                self.ask(model_id, shown.wanted)

    def _loaded(self, model_id: str) -> None:
        """What was shown when the project was closed is shown again."""
        wanted = WantedField.from_dict(self._display.computed.get(model_id))
        style = self._display.styles.get(model_id)
        if wanted is None or style is None or style.name != self.name_of(model_id, wanted):
            return
        if self.running is None:
            self.ask(model_id, wanted)

    def _rests_on(self, model_id: str, wanted: WantedField) -> object:
        """What makes the values others: how models stand, and where a plane lies."""
        records = self._projects.records
        model = records.get(model_id)
        stands = model.to_world if isinstance(model, Model) else None
        if wanted.kind == TO_MODEL:
            other = records.get(wanted.of)
            return stands, other.to_world if isinstance(other, Model) else None
        if wanted.kind in (MEASURABLE, EXPECTED):
            meant = self.plane_meant(wanted)
            return stands, None if meant is None else (meant.dip_direction_deg, meant.dip_deg)
        if wanted.kind != TO_PLANE or get_feature(records, wanted.of) is None:
            return stands, None
        measured = self._derived.measured([wanted.of])[wanted.of]
        if measured.plane is None or not len(measured.points):
            return stands, None
        centre = measured.points.mean(axis=0) if measured.fit is None else measured.fit.centroid
        normal = measured.plane.normal()
        return (
            stands,
            tuple(float(v) for v in centre),
            tuple(float(v) for v in (normal if normal[2] >= 0.0 else -normal)),
        )


def statistics(values: GenericArray) -> Mapping[str, float] | None:
    """Median, and the ends between which nine tenths of the values lie; None without any."""
    known = np.asarray(values[:: max(1, len(values) // 200_000)], np.float64)
    known = known[np.isfinite(known)]
    if not len(known):
        return None
    low, median, high = np.percentile(known, [5.0, 50.0, 95.0])
    return {"low": float(low), "median": float(median), "high": float(high)}


def values_of(opened: OpenModel, name: str) -> GenericArray | None:
    """Of a field of an open model."""
    return opened.data.fields.get(name)
