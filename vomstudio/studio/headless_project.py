"""Project without a window, for commands and scripts.

Every change is a journalled edit, as in the window, and is applied immediately in the calling
thread.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import DocumentError, GeometryError, InputError, UsageError, VomError
from vomstudio.core.findings import Finding, cause_finding, to_finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.geology.profiles import PROFILES_BY_NAME
from vomstudio.geology.slip import SlipSense
from vomstudio.geometry import transform
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coordinate_limits import check_near_model
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.streaming.surfaces import create_surface
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.models import model_cache
from vomstudio.io.models.converted_copy import write_converted
from vomstudio.io.models.frames import establish_frame
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.settings import Settings, read_settings
from vomstudio.project import edits
from vomstudio.project.edit import change
from vomstudio.project.folder import MODELS, ProjectFolder
from vomstudio.project.kinds.station import Station, StationKind
from vomstudio.project.measurement_cache import measure_all, measure_feature
from vomstudio.project.records import Feature, FeatureType, Model, Record
from vomstudio.project.registration_import import registration_in_project
from vomstudio.project.session import Session
from vomstudio.registration.register_options import Observations
from vomstudio.studio.drawn_traces import (
    DrawingTarget,
    DrawnTraces,
    create_drawn_traces,
    update_traces,
)
from vomstudio.studio.jobs.drawing_tasks import collect_lines
from vomstudio.studio.layer_export import update_layers
from vomstudio.studio.models import get_name, new_model
from vomstudio.studio.placed_features import (
    SHAPE_NOUNS,
    PickedShape,
    create_feature,
    create_line,
    create_patch,
    elements_inside,
    to_vertices,
)
from vomstudio.studio.placing.registering import rotation_deg, set_rotations_deg
from vomstudio.studio.project_options import FeatureValues
from vomstudio.studio.project_summary import matching_ids
from vomstudio.studio.tools.local_surface import (
    find_outdated_features,
    remeasure,
    surroundings_function,
)

if TYPE_CHECKING:
    from vomstudio.products.ortho.back_projection import ProjectedLines, Sidecar
    from vomstudio.project.imports.feature_lists import ImportedFeatures
    from vomstudio.studio.placing.register_order import RegistrationResult


NamedRecord = TypeVar("NamedRecord", Model, FeatureType)


@dataclass(frozen=True, eq=False)
class Picks:
    """Points that were picked for one feature on a model.

    Parameters
    ----------
    name : str
    points : (n, 3) float64
        Coordinates in the World frame.
    kind : FeatureType or None
        Feature type. If None, the default type of `add_picks` is used.
    domain : str
        Name of the structural domain, or "" for no domain.
    """

    name: str
    points: FloatArray
    kind: FeatureType | None = None
    domain: str = ""


@dataclass(frozen=True)
class AddedModel:
    """Model of a project. `is_new` is False if the project already contained the model's file."""

    model: Model
    is_new: bool
    warnings: tuple[Finding, ...]


@dataclass(frozen=True)
class AddedPicks:
    """Added features; `skipped` contains the name of each rejected group and the reason."""

    features: tuple[Feature, ...]
    skipped: tuple[tuple[str, Finding], ...]
    warnings: tuple[Finding, ...]


@dataclass(frozen=True, eq=False)
class RegisteredModel:
    """Registration of a model of a project.

    Attributes
    ----------
    result : RegistrationResult
    turned_deg : float
        Rotation of the model, degrees.
    sets_turned_deg : dict of str to float
        Rotation of each set of features on the model, degrees.
    """

    result: RegistrationResult
    turned_deg: float
    sets_turned_deg: dict[str, float]


@dataclass(frozen=True, eq=False)
class _ModelData:
    """Data of a model that are required for measurements.

    Attributes
    ----------
    surface : SelectableSurface or None
        Surface of the model, or None if the file could not be read.
    bounds : (2, 3) float64 or None
        Bounding box in the file frame.
    reasons : tuple of Finding
        Reasons why the file could not be read; empty if it was read.
    """

    surface: SelectableSurface | None = None
    bounds: FloatArray | None = None
    reasons: tuple[Finding, ...] = ()

    @classmethod
    def from_data(cls, data: Mesh | PointCloud) -> _ModelData:
        return cls(create_surface(data), data.bounds)


class HeadlessProject:
    """Open project without a window, for commands and scripts.

    Every change is written to the journal immediately. `save` marks the changes as saved, so
    that the window does not report unsaved work. A `with` statement closes the project at its
    end.

    Parameters
    ----------
    project : ProjectFolder
    settings : Settings
        User settings with which the project was opened.
    warnings : sequence of Finding
        Warnings about the settings.
    progress : Progress, optional

    Attributes
    ----------
    is_recovered : bool
        Whether the journal contains changes that a crash left unsaved.
    """

    def __init__(
        self,
        project: ProjectFolder,
        settings: Settings,
        warnings: Sequence[Finding] = (),
        progress: Progress | None = None,
    ) -> None:
        self.project, self.settings, self.warnings = project, settings, tuple(warnings)
        self._progress = progress or SilentProgress()
        self.is_recovered, self._initial_top = self.session.is_recovered, self.session.top
        self._model_data: dict[str, _ModelData] = {}

    # --- opening and closing -----------------------------------------------------------------
    @classmethod
    def open(cls, folder: Path, progress: Progress | None = None) -> Self:
        """Open a project. Raises InputError if it is not a project or is open elsewhere."""
        settings, problems = read_settings()
        project = ProjectFolder.open(folder, settings=settings.recorded_settings)
        return cls(project, settings, problems, progress)

    @classmethod
    def create(cls, folder: Path) -> Self:
        """Create a project. Raises TargetError if the folder exists or cannot be created."""
        settings, problems = read_settings()
        project = ProjectFolder.create(folder, settings=settings.recorded_settings)
        return cls(project, settings, problems)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def save(self) -> list[Finding]:
        """Mark the present state as saved and update the GIS layers. Return any errors."""
        if self.session.dirty:
            self.session.save()
        self._mark_saved()
        return update_layers(self.project.folder, bool(self.session.features()))

    def save_as(self, folder: Path) -> list[Finding]:
        """Save the project in another folder and continue there. Return the omitted files."""
        skipped_files = self.project.save_as(folder)
        self._mark_saved()
        return skipped_files

    def _mark_saved(self) -> None:
        self.is_recovered, self._initial_top = False, self.session.top

    def close(self) -> None:
        """Close the project and discard its unsaved changes, which `undo` can restore.

        Changes that were unsaved when the program crashed remain unsaved if nothing else was
        changed.
        """
        session = self.session
        try:
            is_unchanged = self.is_recovered and session.top == self._initial_top
            # A missing folder or a full disk was already reported when writing failed.
            if session.dirty and not is_unchanged and self.project.write_failure is None:
                session.discard_unsaved()
        finally:
            self.project.close()

    @property
    def session(self) -> Session:
        """Session of the project."""
        return self.project.session

    # --- lookup -------------------------------------------------------------------------------
    def find_model(self, name: str | None) -> Model:
        """Return a model by its id or name, ignoring case, or by default the only model.

        Raises
        ------
        UsageError
            If no model or more than one model matches.
        """
        models = self.session.of(Model)
        matches = _find_matches(models, name) if name is not None else models
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
        """Return a feature type by its name or id, ignoring case. Raises UsageError."""
        types = self.session.of(FeatureType)
        if matches := _find_matches(types, name):
            return matches[0]
        names = [feature_type.name for feature_type in types]
        raise UsageError(
            Finding("option.not-a-choice", value=name, choices=names),
            field="--type",
        )

    def find_features(self, names: Sequence[str]) -> list[Feature]:
        """Return the features with these ids or names. Raises InputError if one is missing."""
        records = self.session.records
        ids = matching_ids(records.values(), names, self.project.folder)
        return [feature for feature in self.session.features() if feature.id in ids]

    # --- changes -----------------------------------------------------------------------------
    def set_values(self, names: Sequence[str], values: FeatureValues) -> list[Feature]:
        """Change the type, set, domain or name of features in one edit, and return them.

        Raises
        ------
        InputError, DocumentError
            If a feature or value is missing.
        UsageError
            If the type is unknown, or if several features are given the same name.
        """
        features = self.find_features(names)
        if values.name is not None and len(features) > 1:
            raise UsageError(Finding("name.of-several", count=len(features)), field="--name")
        fields = {"name": values.name, "set_name": values.set, "domain": values.domain}
        if values.type is not None:
            fields["type_id"] = self.find_type(values.type).id
        new_fields = {field: value for field, value in fields.items() if value is not None}
        ids = [feature.id for feature in features]
        self.session.apply(edits.set_attributes(self.session.records, ids, **new_fields))
        return self.find_features(ids)

    def delete(self, names: Sequence[str]) -> list[Feature]:
        """Delete features in one edit, and return them. Raises InputError if one is missing."""
        features = self.find_features(names)
        self.session.apply(edits.delete(self.session.records, [feature.id for feature in features]))
        return features

    def add_model(self, path: Path, options: FrameOptions = DEFAULT_FRAME) -> AddedModel:
        """Read a model and add it to the project.

        A registration beside the file (`NAME.registration.json`, or `reconstruction.json` for a
        reconstruction) defines the placement of the model, and its errors are propagated to all
        measurements on the model. With `options.to_crs`, a converted copy is written into the
        project and added. If the project already contains the file, its model is returned.

        Raises
        ------
        InputError, UsageError
        """
        path = path.resolve()
        if options.to_crs is not None:
            converted_model, findings = write_converted(
                path, self.project.folder / MODELS, options, self._progress
            )
            added_model = self.add_model(converted_model)
            return replace(added_model, warnings=(*findings, *added_model.warnings))
        folder = model_cache.cache_folder(path, self.project.cache)
        loaded_model = model_cache.load(path, folder, self._progress)
        models = self.session.of(Model)
        # Checked first, because an invalid frame is an error even if the project contains the
        # file.
        established_frame = establish_frame(replace(loaded_model, path=path), options)
        models_of_file = [m for m in models if m.content_hash == loaded_model.content_hash]
        if models_of_file:
            warning = Finding("model.already-added", model=models_of_file[0].name)
            return AddedModel(models_of_file[0], False, (warning,))
        placement = established_frame.placement
        if isinstance(placement, Registration):
            placement = registration_in_project(self.session.records, placement)
        model = new_model(
            get_name(path),
            self.project.model_path(path),
            loaded_model.kind,
            loaded_model.content_hash or "",
            placement,
        )
        self.session.apply(edits.add_model(self.session.records, model))
        self._model_data[model.id] = _ModelData.from_data(loaded_model.data)
        return AddedModel(model, True, (*loaded_model.warnings, *established_frame.findings))

    def new_model_file(self, name: str) -> Path:
        """Return a free path in the folder `models` for a model that is created in memory."""
        stem = re.sub(r"[^\w .-]", "_", name).strip(" .") or "model"
        folder = self.project.folder / MODELS
        folder.mkdir(exist_ok=True)
        numbered_names = (f"{stem}_{number}" for number in count(2))
        paths = (folder / f"{file_stem}.ply" for file_stem in chain([stem], numbered_names))
        return next(path for path in paths if not path.exists())

    def add_picks(
        self,
        picks: Sequence[Picks],
        model: Model,
        kind: FeatureType,
        set_name: str = "",
        shape: PickedShape = "trace",
    ) -> AddedPicks:
        """Add a trace, line or patch for each group of points that defines one, in one edit.

        Parameters
        ----------
        picks : sequence of Picks
        model : Model
        kind : FeatureType
            Feature type of the picks without a type.
        set_name : str
        shape : {"trace", "line", "patch"}
            Geometry of the points: a trace, a line (see `add_line`), or the outline of a patch.

        Raises
        ------
        InputError
            If `shape` is "patch", and the file of the model cannot be read.
        GeometryError
            If no group defines a feature.
        """
        if shape == "patch":
            self.read_model(model)
        surface, warnings = self._surface_for_planes(model)
        records = self.session.records
        names = edits.NextNames(records)
        features: list[Feature] = []
        skipped_picks: list[tuple[str, Finding]] = []
        for pick in picks:
            feature_type = pick.kind or kind
            try:
                points = self._to_file_points(model, pick.points)
                feature = create_feature(shape, points, model, feature_type, surface)
                measure_feature(feature, model)
            except GeometryError as error:
                skipped_picks.append((pick.name, cause_finding(error)))
                continue
            name = pick.name or names.propose_name(feature_type)
            feature = feature.replace_fields(name=name, set_name=set_name, domain=pick.domain)
            names.reserve(feature)
            features.append(feature)
        if not features:
            first_problem = ": ".join(map(str, skipped_picks[0])) if skipped_picks else ""
            code = "picks.no-plane" if shape == "trace" else "picks.none-usable"
            raise GeometryError(Finding(code, count=len(picks), first=first_problem))
        changed_records: dict[str, Record | None] = {feature.id: feature for feature in features}
        subject = f"{len(features)} {SHAPE_NOUNS[shape]}"
        if len(features) == 1:
            subject = features[0].name
        self.session.apply(change(records, f"Add {subject}", changed_records))
        return AddedPicks(tuple(features), tuple(skipped_picks), warnings)

    def add_line(
        self,
        points: FloatArray,
        model: Model,
        kind: FeatureType,
        *,
        plane: str | None = None,
        slip: SlipSense = "",
        **labels: str,
    ) -> Feature:
        """Add a lineation, or a contact line if the type consists of planes, in one edit.

        Parameters
        ----------
        points : (n, 3) float64
            Points along the line in the World frame.
        model : Model
        kind : FeatureType
        plane : str, optional
            Id or name of the plane that contains the lineation.
        slip : str
            Movement of the hanging wall along the lineation.
        **labels : str
            `name`, `set_name`, `domain` and `notes` of the feature.

        Raises
        ------
        InputError
            If the plane is not in the project.
        UsageError
            If `plane` or `slip` is given for a contact line.
        GeometryError
            If the points are far from the model or do not define a line.
        """
        line = create_line(
            self._to_file_points(model, points), model, kind, self._surface_for_planes(model)[0]
        )
        if kind.geometry != "plane":
            plane_id = "" if plane is None else self.find_features([plane])[0].id
            labels |= {"plane_id": plane_id, "slip": slip}
        elif plane is not None or slip:
            names = [each.name for each in self.session.of(FeatureType) if each.geometry == "line"]
            raise UsageError(
                Finding("option.not-a-choice", value=kind.name, choices=names), field="--type"
            )
        return self._add_feature(line.replace_fields(**labels))

    def add_station(
        self, point: FloatArray, model: Model, what: StationKind = "station", **labels: str
    ) -> Feature:
        """Add a station or sample at a point (3,) in the World frame, in one edit.

        `labels` are its `name`, `number`, `photo` and `notes`.

        Raises
        ------
        GeometryError
            If the point is far from the model.
        """
        vertices = to_vertices(self._to_file_points(model, point.reshape(1, 3)))
        station = Station(new_id("station"), "", model.id, model.content_hash, vertices, what)
        return self._add_feature(station.replace_fields(**labels))

    def add_patch(
        self,
        model: Model,
        kind: FeatureType,
        area: FloatArray | IntArray | BoolArray,
        **labels: str,
    ) -> Feature:
        """Add a patch of the surface of a model, in one edit.

        Parameters
        ----------
        model : Model
        kind : FeatureType
        area : (n, 3) float64, (k,) int or (m,) bool
            Outline in the World frame, or the faces or points.
        **labels : str
            `name`, `set_name`, `domain` and `notes` of the feature.

        Raises
        ------
        InputError
            If the file of the model cannot be read, or if an element does not exist.
        GeometryError
            If the outline contains no part of the model, or the patch has no plane.
        """
        self.read_model(model)
        surface = self._read_model_data(model).surface
        assert surface is not None
        if area.ndim == 2:
            elements = elements_inside(
                surface, self._to_file_points(model, np.asarray(area, np.float64))
            )
        else:
            is_mask = area.dtype == bool
            elements = np.asarray(np.flatnonzero(area) if is_mask else np.unique(area), np.int64)
            is_invalid = len(area) != surface.count if is_mask else False
            if is_invalid or (
                len(elements) and not 0 <= elements[0] <= elements[-1] < surface.count
            ):
                raise InputError(
                    Finding(
                        "array.no-such-element", maximum=surface.count - 1, total=surface.count
                    ),
                    field="elements",
                )
        return self._add_feature(
            create_patch(elements, model, kind, surface).replace_fields(**labels)
        )

    def _to_file_points(self, model: Model, points: FloatArray) -> FloatArray:
        """Return World points (n, 3) in the file frame of a model. Raises GeometryError."""
        file_points = transform.apply(_to_file(model), points)
        if (reason := self._points_problem(model, file_points)) is not None:
            raise GeometryError(reason)
        return file_points

    def _add_feature(self, feature: Feature) -> Feature:
        """Add a feature in one edit. Raises GeometryError if it cannot be measured."""
        records = self.session.records
        (measurement,) = measure_all({**records, feature.id: feature}, [feature])
        if measurement.problem is not None:
            raise GeometryError(measurement.problem)
        edit = edits.add_features(records, [feature])
        self.session.apply(edit)
        added_feature = edit.after[feature.id]
        assert isinstance(added_feature, Feature)
        return added_feature

    def add_drawing(
        self,
        projected_lines: ProjectedLines,
        names: Iterable[str],
        sidecar: Sidecar,
        drawing: Path,
        model: Model,
        feature_type: FeatureType | None,
        set_name: str = "",
        *,
        update: bool = False,
    ) -> DrawnTraces:
        """Add the new lines of a drawing as traces in one edit.

        Parameters
        ----------
        projected_lines : ProjectedLines
            Lines projected onto the surface, in the World frame.
        names : iterable of str
            Names of the lines as stated by the drawing.
        sidecar, drawing
            Sidecar of the picture on which the lines were drawn, and path of the drawing.
        model : Model
        feature_type : FeatureType or None
            Feature type of new lines. If None, each line must name its type.
        set_name : str
        update : bool
            Whether to update traces of the project that were edited in the drawing.

        Raises
        ------
        UsageError, GeometryError
            As `create_drawn_traces`.
        """
        surface, findings = self._surface_for_planes(model)
        lines = collect_lines(projected_lines, names, sidecar, findings, _to_file(model))
        reason = {
            line.name: reason
            for line in lines.lines
            if (reason := self._points_problem(model, np.array(line.surface_points))) is not None
        }
        lines = replace(lines, lines=tuple(line for line in lines.lines if line.name not in reason))
        type_id = None if feature_type is None else feature_type.id
        target = DrawingTarget(
            model, surface, type_id, set_name, is_type_fixed=feature_type is not None
        )
        records = self.session.records
        traces = create_drawn_traces(lines, drawing, sidecar.path, target, records)
        parts = []
        if traces.traces:
            parts.append(edits.add_features(records, traces.traces))
        if traces.edited and update:
            parts.append(update_traces(records, traces.edited, drawing.name))
        if parts:
            self.session.apply(parts[0] if len(parts) == 1 else parts[0].merge_with(parts[1]))
        return replace(
            traces,
            skipped=(*reason.items(), *traces.skipped),
            warnings=traces.warnings if update else (*traces.warnings, *traces.edited_findings),
        )

    def import_features(self, path: Path, model: Model) -> ImportedFeatures:
        """Import the features of a file in one edit, as `read_listed_features` reads them.

        Raises
        ------
        InputError
        """
        from vomstudio.io.gis.crs import world_crs
        from vomstudio.project.imports.feature_lists import read_listed_features

        model_data = self._read_model_data(model)
        frame = model.frame
        features = read_listed_features(
            path,
            model,
            self.session.records,
            world_crs(frame.crs, frame.unit_m),
            None if model_data.surface is None else model_data.surface.area_inside,
            model_data.bounds,
            self._progress,
            surroundings_function(model_data.surface),
        )
        edit = edits.add_features(self.session.records, features.features)
        self.session.apply(edit)
        added_features = tuple(r for r in edit.after.values() if isinstance(r, Feature))
        return replace(
            features, features=added_features, warnings=(*model_data.reasons, *features.warnings)
        )

    def _points_problem(self, model: Model, points: FloatArray) -> Finding | None:
        """Return why points (n, 3) in a model's file frame cannot lie on the model, or None."""
        bounds = self._read_model_data(model).bounds
        if bounds is None or not len(points):
            return None
        low, high = bounds
        distance = np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=1)
        # It is enough to test the farthest point; a non-finite point counts as the farthest.
        return check_near_model(points[int(np.argmax(distance))], bounds)

    def register(
        self, model: Model, options: Observations, pairs: Pairs | None = None
    ) -> RegisteredModel:
        """Register a model in one edit; the features on it move with the model.

        Parameters
        ----------
        model : Model
        options : Observations
        pairs : Pairs, optional
            Points on the model and their coordinates, in place of a table in `options`.

        Raises
        ------
        InputError, UsageError, GeometryError
            Also if a fit to a reference leaves a parameter undetermined.
        """
        from vomstudio.studio.placing.register_order import register_model_of_project

        path = self.project.find_model(model) or Path(model.path)
        loaded_model = replace(self.read_model(model), path=path)
        result = register_model_of_project(loaded_model, model, options, self._progress, pairs)
        if result.reference is not None and not result.placed.known.all:
            free_parameters = result.reference.fitted.free
            raise GeometryError(Finding("registration.undetermined", parameters=free_parameters))
        assert result.registration is not None
        self.session.apply(
            edits.set_registration(self.session.records, result.registration, [model.id])
        )
        model_after = self.find_model(model.id)
        features = self.session.features()
        feature_measurements = measure_all(self.session.records, features)
        measurements_by_id = {f.id: m for f, m in zip(features, feature_measurements, strict=True)}
        sets = set_rotations_deg(self.session.records, model, model_after, measurements_by_id)
        return RegisteredModel(result, rotation_deg(model, model_after), sets)

    def judge_by(self, profile: str) -> None:
        """Assess all features with a built-in profile, "error" or "textbook".

        Raises
        ------
        DocumentError
            If the project already uses the profile.
        UsageError
            If the profile is unknown.
        """
        if profile not in PROFILES_BY_NAME:
            raise UsageError(
                Finding("option.not-a-choice", value=profile, choices=list(PROFILES_BY_NAME)),
                field="profile",
            )
        self.session.apply(edits.judge_by(self.session.records, PROFILES_BY_NAME[profile]))

    def update_surroundings(self) -> tuple[int, tuple[Finding, ...]]:
        """Update the resolution and outcrop face of features measured by an earlier rule.

        Returns
        -------
        int
            Number of updated features.
        tuple of Finding
            Reasons why models could not be read; their features keep the earlier values.

        Raises
        ------
        DocumentError
            If every feature was measured by the present rule.
        """
        measured_fields: dict[str, dict[str, Any]] = {}
        findings: list[Finding] = []
        records = self.session.records
        features = find_outdated_features(records)
        for model in self.session.of(Model):
            outdated_features = [f for f in features if f.model_id == model.id]
            if not outdated_features:
                continue
            data = self._read_model_data(model)
            findings += data.reasons
            if data.surface is not None:
                measured_fields |= {f.id: remeasure(data.surface, f) for f in outdated_features}
        if features and not measured_fields:
            return 0, tuple(findings)
        self.session.apply(edits.update_surroundings(records, measured_fields))
        return len(measured_fields), tuple(findings)

    def undo(self) -> str:
        """Undo the last edit and return its label. Raises DocumentError if no edit is left."""
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
        """Return the data of a model of the project in its file frame.

        Raises
        ------
        InputError
            If the file is missing, damaged, or has changed since the measurements.
        """
        path = self.project.find_model(model)
        if path is None:
            raise InputError(
                Finding("model.file-missing", model=model.name),
                file=model.path,
            )
        folder = model_cache.cache_folder(path, self.project.cache)
        loaded_model = model_cache.load(path, folder, self._progress)
        if loaded_model.content_hash != model.content_hash:
            raise InputError(
                Finding("model.changed", model=model.name),
                file=path,
            )
        return loaded_model

    def _surface_for_planes(
        self, model: Model
    ) -> tuple[SelectableSurface | None, tuple[Finding, ...]]:
        """Return the surface of a model, or None with findings about the effect on new planes."""
        data = self._read_model_data(model)
        return data.surface, data.reasons and (*data.reasons, Finding("surroundings.unknown"))

    def _read_model_data(self, model: Model) -> _ModelData:
        """Read the data of a model's file, or the reason why the file cannot be read."""
        if model.id not in self._model_data:
            try:
                self._model_data[model.id] = _ModelData.from_data(self.read_model(model).data)
            except VomError as error:
                self._model_data[model.id] = _ModelData(reasons=(to_finding(error),))
        return self._model_data[model.id]


def _find_matches(records: Sequence[NamedRecord], name: str) -> list[NamedRecord]:
    exact_matches = [record for record in records if record.id == name]
    return exact_matches or [r for r in records if r.name.casefold() == name.casefold()]


def _to_file(model: Model) -> FloatArray:
    """Return the matrix (4, 4) from the World frame to the file frame of a model."""
    return np.asarray(np.linalg.inv(transform.matrix(model.to_world)), np.float64)
