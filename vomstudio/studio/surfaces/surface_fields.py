"""Computed fields of open models, which are shown as colours and kept up to date."""

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
    FieldsRequest,
    MeasurableRequest,
)
from vomstudio.studio.model_loading import OpenModel
from vomstudio.studio.models import Models
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs
from vomstudio.studio.surfaces.measurable_planes import (
    EXPECTED,
    MEASURABLE,
    map_names,
    resolve_plane,
)
from vomstudio.studio.surfaces.model_jobs import ModelWork

PLANE_DISTANCE, MODEL_DISTANCE = "plane", "model"
COMPUTED_KINDS = (PLANE_DISTANCE, MODEL_DISTANCE, MEASURABLE, EXPECTED)
DEFAULT_RADIUS_RESOLUTIONS, DEFAULT_TRACE_RESOLUTIONS = 5.0, 100.0
"""Default radius and default trace length, in multiples of the resolution of the model."""
_STYLES: dict[str, dict[str, Any]] = {
    "dip": {"low": 0.0, "high": 90.0},
    # White stands for vertical surfaces.
    "steepness": {"low": 30.0, "high": 150.0, "palette": "RdBu_r"},
    "roughness": {"low": 0.0},
    "collinearity": {"low": 0.0},
    # Yellow marks positions that no pick can improve.
    EXPECTED: {"low": 0.0, "high": 15.0},
}

Arrays = dict[str, GenericArray]
FieldsResult = tuple[Arrays, tuple[Finding, ...]]


@dataclass(frozen=True)
class FieldRequest:
    """Request for a field.

    Parameters
    ----------
    kind : str
        A key of `extraction.surface_fields.KINDS`, or one of COMPUTED_KINDS.
    radius_m : float
        Radius for a field of KINDS, or trace length for MEASURABLE and EXPECTED, metres.
    of : str
        Id of the feature or of the other model, or a plane for
        `measurable_planes.resolve_plane`.
    """

    kind: str
    radius_m: float = 0.0
    of: str = ""

    @classmethod
    def from_dict(cls, values: Any) -> FieldRequest | None:
        """Restore a stored request, or return None if it is not valid."""
        try:
            request = cls(str(values["kind"]), float(values["radius_m"]), str(values["of"]))
        except (KeyError, TypeError, ValueError):
            return None
        is_known = request.kind in KINDS or request.kind in COMPUTED_KINDS
        return request if is_known and 0.0 <= request.radius_m < np.inf else None


@dataclass(frozen=True)
class ShownField:
    """Field that is shown on a model.

    Parameters
    ----------
    request : FieldRequest
    name : str
        Name of the field in the model.
    inputs : object
        Inputs on which the values depend.
    palette : str or None
        Colour map selected by the user.
    findings : tuple of Finding
    """

    request: FieldRequest
    name: str
    inputs: object
    palette: str | None = None
    findings: tuple[Finding, ...] = ()


class ModelFields(ModelWork):
    """Fields of open models, which are computed on request.

    Attributes
    ----------
    shown_fields : dict of str to ShownField
        Field shown on each model, keyed by model id.
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
        self.shown_fields: dict[str, ShownField] = {}
        self._computed_names: dict[str, set[str]] = {}
        models.loaded.connect(self._follow_model)

    # --- availability -------------------------------------------------------------------------
    def disabled_reason(self, model_id: str) -> Finding | None:
        """Return why no field can be computed for a model, or None if one can."""
        open_model = self._models.open_models.get(model_id)
        if open_model is None:
            return Finding("model.not-open")
        count = (
            len(open_model.data.vertices)
            if isinstance(open_model.data, Mesh)
            else open_model.data.count
        )
        element_count = len(
            open_model.data.vertices
            if isinstance(open_model.data, Mesh)
            else open_model.data.points
        )
        if element_count != count:
            return Finding("model.cloud-too-large", model=self._projects.get_name(model_id))
        return None

    def suggest_radius(self, model_id: str) -> float:
        """Return five times the resolution of a model, metres, to two significant digits.

        Returns 0.5 if the resolution is unknown.
        """
        open_model, record = (
            self._models.open_models.get(model_id),
            self._projects.records.get(model_id),
        )
        if open_model is None or not isinstance(record, Model) or not open_model.resolution:
            return 0.5
        radius = (
            DEFAULT_RADIUS_RESOLUTIONS
            * open_model.resolution
            * transform.scale_factor(record.to_world)
        )
        return float(f"{max(radius, 1e-6):.2g}")

    def suggest_length(self, model_id: str) -> float:
        """Return the minimum useful length of a trace, metres (textbook 4.1.3)."""
        ratio = DEFAULT_TRACE_RESOLUTIONS / DEFAULT_RADIUS_RESOLUTIONS
        return float(f"{ratio * self.suggest_radius(model_id):.2g}")

    def resolve_plane(self, request: FieldRequest) -> Plane | None:
        """Return the plane of a map of measurable planes, or None if it is not available."""
        return resolve_plane(self._projects.records, self._derived, request.of)

    def get_name(self, model_id: str, request: FieldRequest) -> str | None:
        """Return the name of a requested field in the model, or None if its source is missing."""
        records = self._projects.records
        model = records.get(model_id)
        if not isinstance(model, Model):
            return None
        if request.kind in KINDS:
            return field_name(request.kind, request.radius_m, is_metric=model.frame.has_metres)
        if request.kind in (MEASURABLE, EXPECTED):
            plane = self.resolve_plane(request)
            if plane is None:
                return None
            names = map_names(plane, request.radius_m, is_metric=model.frame.has_metres)
            return names[request.kind]
        source: Feature | Model | None = get_feature(records, request.of)
        if request.kind == MODEL_DISTANCE:
            record = records.get(request.of)
            source = record if isinstance(record, Model) else None
        if source is None:
            return None
        unit = "m" if model.frame.has_metres else "units"
        subject = "plane of " if request.kind == PLANE_DISTANCE else ""
        return f"distance to {subject}{source.name} [{unit}]"

    # --- requests -----------------------------------------------------------------------------
    def request_field(
        self, model_id: str, request: FieldRequest, palette: str | None = None
    ) -> None:
        """Compute a field and show it, cancelling a running computation."""
        self.stop()
        self.findings = ()
        reason = self.disabled_reason(model_id)
        name = self.get_name(model_id, request)
        if reason is not None:
            self._report(reason)
            return
        if name is None:
            self._report(Finding("field.feature-missing"))
            return
        shown_field = ShownField(request, name, self._inputs(model_id, request), palette)
        if request.kind == PLANE_DISTANCE:
            self._request_plane(model_id, shown_field)
        elif request.kind == MODEL_DISTANCE:
            self._request_distances(model_id, shown_field)
        elif request.kind in (MEASURABLE, EXPECTED):
            self._request_measurable(model_id, shown_field)
        else:
            self._request_surface(model_id, shown_field)
        self.changed.emit()

    def _request_surface(self, model_id: str, shown_field: ShownField) -> None:
        # All fields with the same radius are computed together.
        model = self._model(model_id)
        if model is None:
            return
        (placed_model, record), radius = model, shown_field.request.radius_m
        data = self._models.open_models[model_id].data
        if shown_field.name in data.fields and shown_field.name in self._computed_names.get(
            model_id, ()
        ):
            self._show_field(model_id, shown_field, {}, self.shown_fields[model_id].findings)
            return
        is_metric = record.frame.has_metres
        key = sha256(repr((record.content_hash, record.to_world)).encode()).hexdigest()
        out = placed_model.cache / "fields" / f"{record.content_hash[:16]}.npz"

        def read() -> Arrays:
            with open_arrays(out) as arrays:
                return {field_name(k, radius, is_metric=is_metric): arrays[k] for k in KINDS}

        def computed(fields: ComputedFields) -> None:
            self._deliver(model_id, shown_field, lambda: (read(), fields.warnings))

        self._submit(
            COMPUTE_FIELDS,
            FieldsRequest(placed_model, radius, key, out),
            tr("Fields of {model} within {radius:g} m", model=record.name, radius=radius),
            computed,
        )

    def _request_measurable(self, model_id: str, shown_field: ShownField) -> None:
        # Both fields are computed together.
        model, plane = self._model(model_id), self.resolve_plane(shown_field.request)
        if model is None or plane is None:
            return
        placed_model, record = model
        data, length = self._models.open_models[model_id].data, shown_field.request.radius_m
        if shown_field.name in data.fields and shown_field.name in self._computed_names.get(
            model_id, ()
        ):
            self._show_field(model_id, shown_field, {}, self.shown_fields[model_id].findings)
            return
        names = map_names(plane, length, is_metric=record.frame.has_metres)
        x, y, z = (float(v) for v in plane.normal())
        out = placed_model.cache / "fields" / f"{model_id}-measurable.npz"
        tilt = ToWorld.from_model(record).tilt_deg(plane.normal()) or 0.0
        options = MeasurableOptions(length_m=length, registration_error_deg=tilt)

        def read() -> Arrays:
            with open_arrays(out) as stored:
                arrays = {names[MEASURABLE]: stored["measurable"]}
                arrays[names[EXPECTED]] = stored["expected_error95_deg"]
                return arrays

        self._submit(
            MAP_MEASURABLE,
            MeasurableRequest(placed_model, (x, y, z), options, out),
            tr(
                "Measurability of planes {plane} on {model}",
                model=record.name,
                plane=format_plane(plane),
            ),
            lambda mapped: self._deliver(model_id, shown_field, lambda: (read(), mapped.findings)),
        )

    def _request_distances(self, model_id: str, shown_field: ShownField) -> None:
        model, other_model = self._model(model_id), self._model(shown_field.request.of)
        if model is None or other_model is None:
            return
        placed_model, other_placed_model = model[0], other_model[0]
        from vomstudio.studio.jobs.registration_tasks import COMPARE_MODELS, ComparisonRequest

        out = placed_model.cache / "fields" / f"{model_id}-distance.npz"

        def read() -> FieldsResult:
            with open_arrays(out) as arrays:
                return {shown_field.name: arrays["distance_m"].astype(np.float32)}, ()

        self._submit(
            COMPARE_MODELS,
            ComparisonRequest(placed_model, other_placed_model, CompareOptions(), out),
            tr(
                "Distances from {model} to {other}",
                model=placed_model.name,
                other=other_placed_model.name,
            ),
            lambda _: self._deliver(model_id, shown_field, read),
        )

    def _request_plane(self, model_id: str, shown_field: ShownField) -> None:
        plane, record = shown_field.inputs, self._projects.records[model_id]
        assert isinstance(record, Model)
        if not isinstance(plane, tuple) or plane[1] is None:
            self._report(Finding("field.no-plane"))
            return
        centre, normal = np.array(plane[1]), np.array(plane[2])
        data, rows = self._models.open_models[model_id].data, record.to_world

        def work() -> FieldsResult:
            positions = data.vertices if isinstance(data, Mesh) else data.points
            distance = (transform.apply(rows, positions) - centre) @ normal
            return {shown_field.name: distance.astype(np.float32)}, ()

        self._deliver(model_id, shown_field, work)

    def _deliver(
        self, model_id: str, shown_field: ShownField, work: Callable[[], FieldsResult]
    ) -> None:
        """Read or compute fields in a worker thread, and show them."""
        self._read_in_background(
            work, lambda result: self._show_field(model_id, shown_field, *result)
        )

    # --- showing -----------------------------------------------------------------------------
    def _show_field(
        self, model_id: str, shown_field: ShownField, arrays: Arrays, findings: tuple[Finding, ...]
    ) -> None:
        open_model = self._models.open_models.get(model_id)
        if open_model is None:
            return
        current_style = self._display.styles.get(model_id)
        same_style = (
            current_style
            if current_style is not None and current_style.name == shown_field.name
            else None
        )
        if arrays:
            # Fields with another radius or position would clutter the lists. They may have the
            # same name but different values.
            if current_style is not None and current_style.name in self._computed_names.get(
                model_id, ()
            ):
                self._display.hide_field(model_id)
            open_model.remove_fields(self._computed_names.pop(model_id, ()))
            if not open_model.add_fields(arrays):
                self._report(Finding("model.fields-too-large"))
                return
            self._computed_names[model_id] = set(arrays)
        self.shown_fields[model_id] = replace(shown_field, findings=findings)
        self._display.computed[model_id] = asdict(shown_field.request)
        style = same_style or FieldStyle(
            shown_field.name, **_STYLES.get(shown_field.request.kind, {})
        )
        if shown_field.palette is not None:
            style = replace(style, palette=shown_field.palette)
        self._display.show_field(model_id, style)
        self._report(*findings)

    # --- changes of the project ---------------------------------------------------------------
    def begin(self) -> None:
        """Reset for another project."""
        self.running, self.findings = None, ()
        self._background.cancel_all()
        self.shown_fields.clear()
        self._computed_names.clear()
        self.changed.emit()

    def follow_edit(self, edit: Edit) -> None:
        """Update the fields of models that were moved, and those of planes that have changed."""
        for model_id, shown_field in list(self.shown_fields.items()):
            inputs = self._inputs(model_id, shown_field.request)
            if inputs == shown_field.inputs:
                continue
            open_model = self._models.open_models.get(model_id)
            style = self._display.styles.get(model_id)
            is_visible = style is not None and style.name in self._computed_names.get(model_id, ())
            del self.shown_fields[model_id]
            if open_model is not None:
                if is_visible:
                    self._display.hide_field(model_id)
                open_model.remove_fields(self._computed_names.pop(model_id, ()))
            if (
                open_model is not None
                and is_visible
                and self.get_name(model_id, shown_field.request)
            ):
                self.request_field(model_id, shown_field.request)

    def _follow_model(self, model_id: str) -> None:
        """Request the field that was shown when the project was closed."""
        request = FieldRequest.from_dict(self._display.computed.get(model_id))
        style = self._display.styles.get(model_id)
        if request is None or style is None or style.name != self.get_name(model_id, request):
            return
        if self.running is None:
            self.request_field(model_id, request)

    def _inputs(self, model_id: str, request: FieldRequest) -> object:
        """Return the inputs on which the values depend, such as placements or a plane."""
        records = self._projects.records
        model = records.get(model_id)
        to_world = model.to_world if isinstance(model, Model) else None
        if request.kind == MODEL_DISTANCE:
            source = records.get(request.of)
            return to_world, source.to_world if isinstance(source, Model) else None
        if request.kind in (MEASURABLE, EXPECTED):
            plane = self.resolve_plane(request)
            return to_world, None if plane is None else (plane.dip_direction_deg, plane.dip_deg)
        if request.kind != PLANE_DISTANCE or get_feature(records, request.of) is None:
            return to_world, None
        measurements = self._derived.measured([request.of])[request.of]
        if measurements.plane is None or not len(measurements.points):
            return to_world, None
        centre = (
            measurements.points.mean(axis=0)
            if measurements.fit is None
            else measurements.fit.centroid
        )
        normal = measurements.plane.normal()
        return (
            to_world,
            tuple(float(v) for v in centre),
            tuple(float(v) for v in (normal if normal[2] >= 0.0 else -normal)),
        )


def statistics(values: GenericArray) -> Mapping[str, float] | None:
    """Return the median and the bounds of the central 90 % of the values, or None."""
    finite_sample = np.asarray(values[:: max(1, len(values) // 200_000)], np.float64)
    finite_sample = finite_sample[np.isfinite(finite_sample)]
    if not len(finite_sample):
        return None
    low, median, high = np.percentile(finite_sample, [5.0, 50.0, 95.0])
    return {"low": float(low), "median": float(median), "high": float(high)}


def field_values(opened_model: OpenModel, name: str) -> GenericArray | None:
    """Return the values of a field of an open model, or None."""
    return opened_model.data.fields.get(name)
