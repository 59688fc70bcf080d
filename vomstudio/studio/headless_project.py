"""A project worked on without a window, by a command or a script.

Every change is the journalled edit that the window makes, and is made at once, in this thread.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import DocumentError, GeometryError, InputError, UsageError, VomError
from vomstudio.core.findings import Finding, cause_of, finding_of
from vomstudio.core.progress import Progress, Silent
from vomstudio.geology.profiles import PROFILES
from vomstudio.geometry import transform
from vomstudio.geometry.brush import PaintSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coordinate_limits import why_not_at
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.streaming.surfaces import surface_of
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.models import model_cache
from vomstudio.io.models.converted_copy import write_converted
from vomstudio.io.models.frames import establish_frame
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.settings import Settings, read_settings
from vomstudio.project import edits
from vomstudio.project.edit import change
from vomstudio.project.folder import MODELS, Project
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import Feature, FeatureType, Model, Record, Typed, get
from vomstudio.project.registration_frames import registration_in_project
from vomstudio.project.session import Session
from vomstudio.registration.evidence import Evidence, register
from vomstudio.registration.placing import with_warnings
from vomstudio.registration.results import Placed
from vomstudio.registration.surface_points import known_resolution, some_points
from vomstudio.studio.drawn_traces import (
    DrawingTarget,
    DrawnTraces,
    drawn_traces,
    trace_through,
    update_traces,
)
from vomstudio.studio.jobs.drawing_tasks import collect_lines
from vomstudio.studio.layer_export import written_layers
from vomstudio.studio.models import name_of, new_model
from vomstudio.studio.placing.registering import (
    add_reference_error,
    placed_by_points,
    reference_findings,
    registration_of,
    sets_turned_deg,
    turned_deg,
)
from vomstudio.studio.project_options import FeatureValues
from vomstudio.studio.project_summary import matching_ids
from vomstudio.studio.tools.local_surface import measured_anew, of_earlier_rules

if TYPE_CHECKING:
    from vomstudio.products.ortho.back_projection import Brought, Sidecar
    from vomstudio.project.imports.feature_lists import ImportedFeatures
    from vomstudio.studio.placing.reference_fitting import ReferenceFit


Named = TypeVar("Named", Model, FeatureType)


@dataclass(frozen=True, eq=False)
class Picks:
    """Points along one line on a model.

    Parameters
    ----------
    name : str
    points : (n, 3) float64
        World.
    kind : FeatureType or None
        Feature type, None for that of most lines.
    domain : str
        Domain, "" for none.
    """

    name: str
    points: FloatArray
    kind: FeatureType | None = None
    domain: str = ""


@dataclass(frozen=True)
class AddedModel:
    """new : False where the project had this file already"""

    model: Model
    new: bool
    warnings: tuple[Finding, ...]


@dataclass(frozen=True)
class AddedPicks:
    """skipped : name and reason of each that defines no plane"""

    traces: tuple[Trace, ...]
    skipped: tuple[tuple[str, Finding], ...]
    warnings: tuple[Finding, ...]


@dataclass(frozen=True, eq=False)
class _ModelData:
    """Data of a model that measurements need.

    Attributes
    ----------
    surface : PaintSurface or None
        None if the file could not be read.
    bounds : (2, 3) float64 or None
        In the frame of the file.
    extent : (n, 3) float64 or None
        Sample of the points, in the frame of the file.
    resolution : callable
        Returns the resolution in the unit of the file, None if it is not known.
    why_not : tuple of Finding
        Why the file could not be read; empty if it was read.
    """

    surface: PaintSurface | None = None
    bounds: FloatArray | None = None
    extent: FloatArray | None = None
    resolution: Callable[[], float | None] = lambda: None
    why_not: tuple[Finding, ...] = ()

    @classmethod
    def of(cls, data: Mesh | PointCloud) -> _ModelData:
        # Only registrations need the resolution.
        resolution = partial(known_resolution, data)
        return cls(surface_of(data), data.bounds, some_points(data), resolution)


class HeadlessProject:
    """An open project without a window, for commands and scripts.

    Every change is written to the journal at once. `save` marks the changes as saved, so that the
    window does not report unsaved work. As a context manager it closes the project.

    Parameters
    ----------
    project : Project
    settings : Settings
        Settings with which the project was opened.
    warnings : sequence of Finding
        Warnings about the settings.
    progress : Progress, optional

    Attributes
    ----------
    recovered : bool
        Whether the journal contains changes that a crash left unsaved.
    """

    def __init__(
        self,
        project: Project,
        settings: Settings,
        warnings: Sequence[Finding] = (),
        progress: Progress | None = None,
    ) -> None:
        self.project, self.settings, self.warnings = project, settings, tuple(warnings)
        self._progress = progress or Silent()
        self.recovered, self._opened_at = self.session.recovered, self.session.top
        self._model_data: dict[str, _ModelData] = {}

    # --- opening and closing -----------------------------------------------------------------
    @classmethod
    def open(cls, folder: Path, progress: Progress | None = None) -> Self:
        """Open a project. Raises InputError if the folder is not one, or is open elsewhere."""
        settings, problems = read_settings()
        project = Project.open(folder, settings=settings.recorded_settings)
        return cls(project, settings, problems, progress)

    @classmethod
    def create(cls, folder: Path) -> Self:
        """Create a project. Raises TargetError if the folder exists or cannot be made."""
        settings, problems = read_settings()
        project = Project.create(folder, settings=settings.recorded_settings)
        return cls(project, settings, problems)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def save(self) -> list[Finding]:
        """Mark the present state as saved and update the GIS layers; report if that failed."""
        if self.session.dirty:
            self.session.save()
        self._mark_saved()
        return written_layers(self.project.folder, bool(self.session.features()))

    def save_as(self, folder: Path) -> list[Finding]:
        """Save the project in another folder and continue there; report files that are left out."""
        left_out = self.project.save_as(folder)
        self._mark_saved()
        return left_out

    def _mark_saved(self) -> None:
        self.recovered, self._opened_at = False, self.session.top

    def close(self) -> None:
        """Close the project; `undo` can restore its unsaved changes.

        Changes that a crash left unsaved remain unsaved if nothing else was changed.
        """
        session = self.session
        try:
            is_unchanged = self.recovered and session.top == self._opened_at
            # A missing or full folder was reported when writing failed.
            if session.dirty and not is_unchanged and self.project.write_failure is None:
                session.discard_unsaved()
        finally:
            self.project.close()

    @property
    def session(self) -> Session:
        """The project's session."""
        return self.project.session

    # --- finding -----------------------------------------------------------------------------
    def find_model(self, name: str | None) -> Model:
        """A model by id or name, case ignored; None for the only one. Raises UsageError."""
        models = self.session.of(Model)
        matches = _matching(models, name) if name is not None else models
        if len(matches) == 1:
            return matches[0]
        names = [model.name for model in models]
        if not models:
            raise UsageError(Finding("project.no-models"), field="--model")
        if name is None:
            raise UsageError(
                Finding("project.several-models", names=names),
                field="--model",
            )
        if matches:
            ids = [model.id for model in matches]
            raise UsageError(
                Finding("model.ambiguous-name", name=name, ids=ids),
                field="--model",
            )
        raise UsageError(
            Finding("option.not-a-choice", value=name, choices=names),
            field="--model",
        )

    def find_type(self, name: str) -> FeatureType:
        """A feature type by name or id, case ignored. Raises UsageError."""
        types = self.session.of(FeatureType)
        if matches := _matching(types, name):
            return matches[0]
        names = [kind.name for kind in types]
        raise UsageError(
            Finding("option.not-a-choice", value=name, choices=names),
            field="--type",
        )

    def find_features(self, names: Sequence[str]) -> list[Typed]:
        """Return the features with these ids or names. Raises InputError for a missing one."""
        records = self.session.records
        ids = matching_ids(records.values(), names, self.project.folder)
        return [each for each in self.session.of(Typed) if each.id in ids]

    # --- changes -----------------------------------------------------------------------------
    def set_values(self, names: Sequence[str], values: FeatureValues) -> list[Typed]:
        """Change type, set, domain or name of features, as one edit, and return the features.

        Raises
        ------
        InputError, DocumentError
            For a missing feature or value.
        UsageError
            For an unknown type, and for one name of several features.
        """
        features = self.find_features(names)
        if values.name is not None and len(features) > 1:
            raise UsageError(Finding("name.of-several", count=len(features)), field="--name")
        fields = {"name": values.name, "set_name": values.set, "domain": values.domain}
        if values.type is not None:
            fields["type_id"] = self.find_type(values.type).id
        new_values = {field: value for field, value in fields.items() if value is not None}
        ids = [each.id for each in features]
        self.session.apply(edits.set_attributes(self.session.records, ids, **new_values))
        return self.find_features(ids)

    def delete(self, names: Sequence[str]) -> list[Typed]:
        """Delete features, as one edit, and return them. Raises InputError for a missing one."""
        features = self.find_features(names)
        self.session.apply(edits.delete(self.session.records, [each.id for each in features]))
        return features

    def add_model(self, path: Path, options: FrameOptions = DEFAULT_FRAME) -> AddedModel:
        """Read a model and make it part of the project.

        A registration beside the file (`NAME.registration.json`, or `reconstruction.json` of a
        reconstruction) places the model, so that its errors reach all that is measured on it. With
        `options.to_crs` a converted copy is written into the project and added.

        Raises
        ------
        InputError, UsageError
        """
        path = path.resolve()
        if options.to_crs is not None:
            converted, findings = write_converted(
                path, self.project.folder / MODELS, options, self._progress
            )
            added = self.add_model(converted)
            return replace(added, warnings=(*findings, *added.warnings))
        folder = model_cache.folder_of(path, self.project.cache)
        loaded = model_cache.load(path, folder, self._progress)
        models = self.session.of(Model)
        # Looked at first: what cannot be is refused of a file that is there already, too.
        established = establish_frame(replace(loaded, path=path), options)
        same = [m for m in models if m.content_hash == loaded.content_hash]
        if same:
            warning = Finding("model.already-added", model=same[0].name)
            return AddedModel(same[0], False, (warning,))
        placement = established.placement
        if isinstance(placement, Registration):
            placement = registration_in_project(self.session.records, placement)
        model = new_model(
            name_of(path),
            self.project.model_path(path),
            loaded.kind,
            loaded.content_hash or "",
            placement,
        )
        self.session.apply(edits.add_model(self.session.records, model))
        self._model_data[model.id] = _ModelData.of(loaded.data)
        return AddedModel(model, True, (*loaded.warnings, *established.findings))

    def add_picks(
        self, picks: Sequence[Picks], model: Model, kind: FeatureType, set_name: str = ""
    ) -> AddedPicks:
        """Add a trace for each line of picks that defines a plane, all as one edit. Raises
        GeometryError where none does."""
        surface, warnings = self._surface_for_planes(model)
        records = self.session.records
        added: dict[str, Record] = {}
        names = edits.NextNames(records)
        traces: list[Trace] = []
        skipped: list[tuple[str, Finding]] = []
        for pick in picks:
            points = transform.apply(_to_file(model), pick.points)
            if (far := self._why_not_on(model, points)) is not None:
                skipped.append((pick.name, far))
                continue
            own = pick.kind or kind
            trace = trace_through(pick.name, points, model, own.id, set_name, surface)
            trace = replace(trace, name=trace.name or names.next_for(own), domain=pick.domain)
            try:
                edit = edits.add_trace(records, trace)
            except GeometryError as error:
                skipped.append((pick.name, cause_of(error)))
                continue
            named = get(edit.after, trace.id, Trace)
            assert named is not None
            added[trace.id] = named
            names.reserve(named)
            traces.append(named)
        if not traces:
            first = ": ".join(map(str, skipped[0])) if skipped else ""
            raise GeometryError(Finding("picks.no-plane", count=len(picks), first=first))
        after: dict[str, Record | None] = {trace.id: trace for trace in traces}
        what = traces[0].name if len(traces) == 1 else f"{len(traces)} traces"
        self.session.apply(change(self.session.records, f"Add {what}", after))
        return AddedPicks(tuple(traces), tuple(skipped), warnings)

    def add_drawing(
        self,
        brought: Brought,
        names: Iterable[str],
        sidecar: Sidecar,
        drawing: Path,
        model: Model,
        kind: FeatureType | None,
        set_name: str = "",
        *,
        update: bool = False,
    ) -> DrawnTraces:
        """Add the new lines of a drawing as traces, all as one edit.

        Parameters
        ----------
        brought : Brought
            Lines on the surface, in World.
        names : iterable of str
            Names that the drawing states.
        sidecar, drawing
            The picture on which they were drawn, and the file.
        model : Model
        kind : FeatureType or None
            Feature type of new lines, None if each names its own.
        set_name : str
        update : bool
            Whether traces that were edited in the drawing are changed.

        Raises
        ------
        UsageError, GeometryError
            As `drawn_traces`.
        """
        surface, messages = self._surface_for_planes(model)
        found = collect_lines(brought, names, sidecar, messages, _to_file(model))
        far = {
            line.name: why
            for line in found.lines
            if (why := self._why_not_on(model, np.array(line.on_surface))) is not None
        }
        found = replace(found, lines=tuple(line for line in found.lines if line.name not in far))
        type_id = None if kind is None else kind.id
        target = DrawingTarget(model, surface, type_id, set_name, is_type_fixed=kind is not None)
        records = self.session.records
        drawn = drawn_traces(found, drawing, sidecar.path, target, records)
        parts = []
        if drawn.traces:
            parts.append(edits.add_features(records, drawn.traces))
        if drawn.edited and update:
            parts.append(update_traces(records, drawn.edited, drawing.name))
        if parts:
            self.session.apply(parts[0] if len(parts) == 1 else parts[0].followed_by(parts[1]))
        return replace(
            drawn,
            skipped=(*far.items(), *drawn.skipped),
            warnings=drawn.warnings if update else (*drawn.warnings, *drawn.edited_findings),
        )

    def take_in(self, path: Path, model: Model) -> ImportedFeatures:
        """Add the stations, contact lines and rock areas of a file, all as one edit. Raises
        InputError."""
        from vomstudio.io.gis.crs import world_crs
        from vomstudio.project.imports.feature_lists import read_listed_features

        known = self._read(model)
        frame = model.frame
        found = read_listed_features(
            path,
            model,
            self.session.records,
            world_crs(frame.crs, frame.unit_m),
            None if known.surface is None else known.surface.area_inside,
            known.bounds,
            self._progress,
        )
        edit = edits.add_features(self.session.records, found.features)
        self.session.apply(edit)
        added = tuple(r for r in edit.after.values() if isinstance(r, Feature))
        return replace(found, features=added, warnings=(*known.why_not, *found.warnings))

    def _why_not_on(self, model: Model, points: FloatArray) -> Finding | None:
        """Return why points (n, 3) in the frame of its file cannot lie on a model, or None."""
        bounds = self._read(model).bounds
        if bounds is None or not len(points):
            return None
        low, high = bounds
        off = np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=1)
        # The farthest says it for all; what is no number counts as the farthest.
        return why_not_at(points[int(np.argmax(off))], bounds)

    def register(
        self, model: Model, pairs: Pairs, crs: str | None, click_sigma_m: float | None = None
    ) -> tuple[Placed, float, dict[str, float]]:
        """Place a model by points on it; what was measured on it moves with it.

        crs : of the pairs, "EPSG:n" in metres; None for a local frame
        click_sigma_m : error of the click on the model, one sigma; None for half its resolution
        Returns the placement, and by how many degrees the model and each set on it turned. Raises
        GeometryError.
        """
        known = self._read(model)
        placed = placed_by_points(
            pairs,
            known.bounds,
            model,
            crs,
            known.extent,
            click_sigma_m=click_sigma_m,
            resolution=known.resolution(),
        )
        return self._placed(model, placed, registration_of(placed, pairs, model, crs))

    def fit_to_reference(
        self,
        model: Model,
        reference: str | Path,
        pairs: Pairs | None,
        crs: str | None,
        stable: str | Path | None = None,
        click_sigma_m: float | None = None,
    ) -> tuple[Placed, float, dict[str, float], ReferenceFit]:
        """Place a model by another one of the same rock, from where it stands or pairs have it.

        stable : a mask of the reference
        Returns what `register` does, and the fit. Raises InputError, UsageError, and GeometryError
        also where the two leave something free.
        """
        from vomstudio.studio.placing.reference_fitting import Standing, fit_model

        resolution = self._read(model).resolution()
        evidence = Evidence(pairs=pairs, click_sigma_m=click_sigma_m, resolution=resolution)
        frame, registration = model.frame, model.registration
        scale_error = None if registration is None else registration.scale_error
        fitted = fit_model(
            self.read_model(model),
            reference,
            near=None if pairs is None else register(evidence),
            crs=crs,
            stable=stable,
            stands=Standing(model.to_world, frame.crs, frame.has_metres, scale_error),
            progress=self._progress,
        )
        evidence.reference = fitted.fitted.observation
        placed = with_warnings(register(evidence), fitted.warnings)
        if not placed.known.all:
            raise GeometryError(Finding("registration.undetermined", parameters=fitted.fitted.free))
        record = registration_of(placed, pairs, model, fitted.crs, Path(reference).name)
        if fitted.reference is not None:
            record = add_reference_error(record, fitted.reference, scale_fitted=fitted.scale_fitted)
            placed = replace(placed, warnings=(*placed.warnings, *reference_findings(record)))
        return *self._placed(model, placed, record), fitted

    def _placed(
        self, model: Model, placed: Placed, record: Registration
    ) -> tuple[Placed, float, dict[str, float]]:
        self.session.apply(edits.set_registration(self.session.records, record, [model.id]))
        after = get(self.session.records, model.id, Model)
        if after is None:
            return placed, 0.0, {}
        features = self.session.features()
        figures = measure_all(self.session.records, features)
        measured = {f.id: m for f, m in zip(features, figures, strict=True)}
        sets = sets_turned_deg(self.session.records, model, after, measured)
        return placed, turned_deg(model, after), sets

    def judge_by(self, profile: str) -> None:
        """Judge all features by a profile that every project has, "error" or "textbook".

        Raises DocumentError where the project is judged by it already, UsageError for another.
        """
        if profile not in PROFILES:
            raise UsageError(
                Finding("option.not-a-choice", value=profile, choices=list(PROFILES)),
                field="profile",
            )
        self.session.apply(edits.judge_by(self.session.records, PROFILES[profile]))

    def update_surroundings(self) -> tuple[int, tuple[Finding, ...]]:
        """Measure resolution and outcrop face again around features of an earlier rule.

        Returns
        -------
        int
            How many features were measured.
        tuple of Finding
            Why the features on other models keep their earlier values.

        Raises
        ------
        DocumentError
            If there is no such feature.
        """
        measured: dict[str, dict[str, Any]] = {}
        findings: list[Finding] = []
        records = self.session.records
        features = of_earlier_rules(records)
        for model in self.session.of(Model):
            outdated = [f for f in features if f.model_id == model.id]
            if not outdated:
                continue
            data = self._read(model)
            findings += data.why_not
            if data.surface is not None:
                measured |= {f.id: measured_anew(data.surface, f) for f in outdated}
        if features and not measured:
            return 0, tuple(findings)
        self.session.apply(edits.update_surroundings(records, measured))
        return len(measured), tuple(findings)

    def undo(self) -> str:
        """Undo the last edit and return its label. Raises DocumentError where there is none."""
        label = self.session.undo_label
        if label is None:
            raise DocumentError(Finding("edit.nothing-to-undo"))
        self.session.undo()
        return label

    def redo(self) -> str:
        """Redo the last undone edit and return its label. Raises DocumentError."""
        label = self.session.redo_label
        if label is None:
            raise DocumentError(Finding("edit.nothing-to-redo"))
        self.session.redo()
        return label

    # --- models' data ------------------------------------------------------------------------
    def read_model(self, model: Model) -> LoadedModel:
        """The data of a model of the project, in its file's frame. Raises InputError where its file
        is gone, damaged, or not the one that was measured on."""
        path = self.project.find_model(model)
        if path is None:
            raise InputError(
                Finding("model.file-missing", model=model.name),
                file=model.path,
            )
        folder = model_cache.folder_of(path, self.project.cache)
        loaded = model_cache.load(path, folder, self._progress)
        if loaded.content_hash != model.content_hash:
            raise InputError(
                Finding("model.changed", model=model.name),
                file=path,
            )
        return loaded

    def _surface_for_planes(self, model: Model) -> tuple[PaintSurface | None, tuple[Finding, ...]]:
        """Return the surface of a model, and findings about new planes if it is not known."""
        data = self._read(model)
        return data.surface, data.why_not and (*data.why_not, Finding("surroundings.unknown"))

    def _read(self, model: Model) -> _ModelData:
        """Return what the file of a model contains, or why it cannot be read."""
        if model.id not in self._model_data:
            try:
                self._model_data[model.id] = _ModelData.of(self.read_model(model).data)
            except VomError as error:
                self._model_data[model.id] = _ModelData(why_not=(finding_of(error),))
        return self._model_data[model.id]


def _matching(records: Sequence[Named], name: str) -> list[Named]:
    exact = [record for record in records if record.id == name]
    return exact or [r for r in records if r.name.casefold() == name.casefold()]


def _to_file(model: Model) -> FloatArray:
    """Return the matrix (4, 4) from World to the frame of the model's file."""
    return np.asarray(np.linalg.inv(transform.matrix(model.to_world)), np.float64)
