"""Projects: what was measured, worked on without a window."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

from vomstudio.api import feature_tables
from vomstudio.api.checking import flag, naming, path_of, points, required_text, warn, words_of
from vomstudio.api.frame_arguments import frame_arguments_named, frame_options
from vomstudio.api.models import Mesh, PointCloud, as_recorded
from vomstudio.api.planes import LineFit, PlaneFit, line_of_row, plane_of_row
from vomstudio.core.errors import DocumentError, GeometryError, InputError, VomWarning
from vomstudio.core.findings import Finding, finding_of
from vomstudio.core.reprs import html_table, text_table
from vomstudio.project.exports.export import export_records, refuse_empty
from vomstudio.project.journal.database import own_files
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Model
from vomstudio.project.verify import Verification, verify
from vomstudio.studio.headless_project import HeadlessProject, Picks
from vomstudio.studio.project_summary import ModelFacts, fitted_records, model_facts
from vomstudio.studio.surfaces.grid_coverage import GridShare, shares_of


@dataclass(frozen=True, eq=False, kw_only=True)
class ProjectModel(ModelFacts):
    """A model of a project.

    id, name, kind ("mesh" or "cloud"); path : of its file, as the project keeps it; frame : how it
    stands, in words; crs : "EPSG:n" or None; features : how many were measured on it

    >>> import tempfile, pathlib
    >>> import vomstudio as vs
    >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "cliff.vom") as project:
    ...     _ = project.add_model(vs.sample("sample.obj"))
    ...     project.models[0].name, project.models[0].crs, project.models[0].features
    ('sample', 'EPSG:32633', 0)
    """

    _project: Project = field(repr=False)

    def read(self) -> Mesh | PointCloud:
        """Its data in World. Raises vs.errors.InputError where the file is gone or has changed
        since features were measured on it."""
        return self._project._read(self.id)

    def plot(self) -> Any:
        """As `Mesh.plot`."""
        return self.read().plot()


class Project:
    """A project on disk, as the window has it: every change is an edit of its journal, can be
    undone, and is on the disk at once.

    ``Project.open(path)`` and ``Project.create(path)`` are context managers. Leaving the block
    without ``save()`` puts what was changed in it aside, as closing the window without saving does;
    ``undo()`` after opening it again takes that back. One program at a time has a project open.

    Examples
    --------
    >>> import tempfile, pathlib, pandas
    >>> import vomstudio as vs
    >>> picks = pandas.read_csv(vs.sample("picks.csv"), comment="#")
    >>> bed = picks[picks["pick"] == "B01"]
    >>> folder = pathlib.Path(tempfile.mkdtemp()) / "cliff.vom"
    >>> with vs.Project.create(folder) as project:
    ...     cliff = project.add_model(vs.sample("sample.obj"))
    ...     trace = project.add_trace(bed[["x", "y", "z"]], model=cliff, type="bedding")
    ...     project.save()
    >>> with vs.Project.open(folder) as project:
    ...     project.planes()[["name", "dip_deg", "quality"]].round(0).values.tolist()
    [['B01', 38.0, 'good']]
    """

    def __init__(self, desk: HeadlessProject) -> None:
        self._desk: HeadlessProject | None = desk
        self._folder = desk.project.folder
        self._measurements = Measurements(desk.settings.thresholds)

    # --- coming and going ------------------------------------------------------------------------
    @classmethod
    def open(cls, path: str | Path) -> Self:
        """The project in a folder NAME.vom.

        Raises vs.errors.InputError where it is none, a newer one, or open in a window or another
        notebook, which is named. Work that a crash left unsaved is part of it, and a warning says
        so.
        """
        desk = HeadlessProject.open(path_of(path, "path"))
        project = cls(desk)
        warnings = [*desk.warnings, *desk.project.problems]
        if desk.recovered:
            warnings.append(Finding("project.recovered"))
        try:
            warn(warnings)
        except VomWarning:
            # Where warnings are errors nobody gets it, so nobody could close it.
            project.close()
            raise
        return project

    @classmethod
    def create(cls, path: str | Path) -> Self:
        """A new project in the folder NAME.vom. Raises vs.errors.TargetError where there is one
        already, or the folder cannot be made."""
        desk = HeadlessProject.create(path_of(path, "path"))
        warn(desk.warnings)
        return cls(desk)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Leave it; what was not saved is put aside, and can be taken back by ``undo()``. What a
        crash had left unsaved stays as it is where nothing else was changed. Closing it twice does
        no harm."""
        desk, self._desk = self._desk, None
        if desk is not None:
            desk.close()

    def save(self) -> None:
        """Make what was done the state that the next who opens it finds, and bring its GIS layers
        (project.gpkg) up to date."""
        warn(self._open_desk().save())

    def save_as(self, path: str | Path) -> None:
        """Go on in another folder NAME.vom, with the whole history, saved; what was open stays
        behind as it was last saved. Also where the project's own folder was deleted or replaced
        meanwhile, or its disk is full: everything that was done is in memory.

        Raises vs.errors.TargetError where there is something already, or it cannot be written;
        then all is as before. Files that can no longer be read are named in a warning.
        """
        desk = self._open_desk()
        left_out = desk.save_as(path_of(path, "path"))
        self._folder = desk.project.folder
        warn(left_out)

    # --- looking ---------------------------------------------------------------------------------
    @property
    def path(self) -> Path:
        """Its folder."""
        return self._folder

    @property
    def models(self) -> tuple[ProjectModel, ...]:
        """In the order in which they came."""
        return tuple(
            ProjectModel(**vars(facts), _project=self) for facts in model_facts(self._records)
        )

    @property
    def unsaved(self) -> bool:
        """There are changes since the last save."""
        return self._open_desk().session.dirty

    def planes(self) -> Any:
        """All planes as a DataFrame with the columns of the orientation table; ``geometry`` is the
        centre as a shapely Point with z (World, metres), None for a plane without a place."""
        return feature_tables.orientations(self._records, self._measurements, "plane")

    def lines(self) -> Any:
        """All lines (lineations, fold axes) likewise."""
        return feature_tables.orientations(self._records, self._measurements, "line")

    def traces(self) -> Any:
        """All traces as a DataFrame; ``geometry`` is a shapely LineString with z (World, m)."""
        return feature_tables.shapes(self._records, self._measurements, "traces")

    def patches(self) -> Any:
        """All patches likewise; ``geometry`` is the outline as a shapely Polygon with z."""
        return feature_tables.shapes(self._records, self._measurements, "patches")

    def stations(self) -> Any:
        """All stations and samples likewise, with ``number`` and ``photo``; ``geometry`` is a
        shapely Point with z."""
        return feature_tables.shapes(self._records, self._measurements, "stations")

    def contacts(self) -> Any:
        """All contact lines likewise, with ``length_m``; they have no plane."""
        return feature_tables.shapes(self._records, self._measurements, "contacts")

    def lithologies(self) -> Any:
        """All rock areas likewise: ``lithology``, ``area_m2`` of the surface inside, ``outline_m2``
        of the outline laid flat; ``geometry`` is the outline as a shapely Polygon with z."""
        return feature_tables.shapes(self._records, self._measurements, "lithologies")

    def looked_at(self) -> list[GridShare]:
        """What was looked at of each face with a grid: ``id``, ``name``, ``model`` and ``found``
        (``cells``, ``done``, ``empty``, ``unmeasurable``, ``not_looked_at``, ``looked_at_share``,
        ``density_1_per_m2``, ``P21_1_per_m``; areas in m2). A grid whose model is gone is left out
        with a warning."""
        found, said = shares_of(self._open_desk())
        warn(said)
        return found

    def fit(self, id: str) -> PlaneFit | LineFit:
        """Return the figures of one feature by its id or name: a PlaneFit or a LineFit.

        Raises vs.errors.InputError if the feature does not exist, vs.errors.GeometryError if it
        has no orientation."""
        feature = required_text(id, "id")
        fits = fitted_records(self._records, self._measurements, self._folder, [feature])
        if fits.rows:
            row = fits.rows[0]
            return plane_of_row(row) if row["element"] == "plane" else line_of_row(row)
        no_plane = Finding("feature.without-plane")
        reason = fits.skipped[0]["reason"] if fits.skipped else no_plane
        raise GeometryError(reason, field=id)

    def verify(self) -> Verification:
        """Read every row and file of it: ``sound``, ``problems`` (sentences), ``steps``,
        ``models``, ``features``, ``assets``, ``schema``."""
        self._open_desk()
        return verify(self._folder)

    def plot(self) -> Any:
        """A PyVista plotter with its models, features, labels and planes; see `Mesh.plot`. A model
        whose file is gone is left out with a warning."""
        from vomstudio.api.plots import plotted

        models = []
        for model in self.models:
            try:
                models.append(model.read()._data)
            except InputError as error:
                warn([finding_of(error)])
        return plotted(models, feature_tables.drawings(self._records, self._measurements))

    # --- changing --------------------------------------------------------------------------------
    def add_model(
        self,
        path: str | Path,
        *,
        crs: str | None = None,
        up: Literal["y", "z"] | None = None,
        unit: str | None = None,
        to_crs: str | None = None,
    ) -> str:
        """Make a model part of the project; returns its id.

        crs, up, unit, to_crs : as in `vs.read`; with `to_crs` the project contains a converted
        copy. A registration beside the file places the model, so that
        its errors reach all that is measured on it. A file that does not say how it stands is
        taken as local, in metres, z up, with a warning. A file that the project has already is not
        added twice. Raises vs.errors.InputError, vs.errors.UsageError.
        """
        options = frame_options(crs, up, unit, to_crs)
        with frame_arguments_named():
            added = self._open_desk().add_model(path_of(path, "path"), options)
        warn(added.warnings, notes=True)
        return added.model.id

    def add_trace(
        self,
        points: Any,
        *,
        model: str | ProjectModel,
        type: str,
        name: str | None = None,
        set: str | None = None,
        domain: str | None = None,
    ) -> str:
        """Add points along a bed, fault or joint; returns the id of the trace.

        points : (n, 3) in World, metres, n >= 3, in order along the trace
        model : id or name of the model that they lie on; type : name of a feature type, case
        forgiven; name : None for the next number of its type; set : that it belongs to; domain :
        part of the structure that it lies in

        Raises vs.errors.InputError for an array of another shape, vs.errors.GeometryError where
        they define no plane, vs.errors.UsageError for a model or type that is not there.
        """
        desk = self._open_desk()
        model_name = model.id if isinstance(model, ProjectModel) else required_text(model, "model")
        # Checked before the edit is made: the journal could not be read with anything else in it.
        part = words_of(domain, "domain") or ""
        picks = Picks(words_of(name, "name") or "", _points(points), domain=part)
        with naming("type", "--type"):
            feature_type = desk.find_type(required_text(type, "type"))
            group = words_of(set, "set") or ""
        with naming("model", "--model"):
            on = desk.find_model(model_name)
        added = desk.add_picks([picks], on, feature_type, group)
        warn(added.warnings)
        return added.traces[0].id

    def judge_by(self, profile: str) -> None:
        """Judge all features by a profile, "error" or "textbook"; `undo` takes it back.

        Raises vs.errors.UsageError for another name, vs.errors.DocumentError where it is in use.
        """
        self._open_desk().judge_by(required_text(profile, "profile"))

    def undo(self) -> str:
        """Take the last step back, also one of an earlier day; returns what it was. Raises
        vs.errors.DocumentError where there is none."""
        return self._open_desk().undo()

    def redo(self) -> str:
        """Do again what was taken back; returns what it was. Raises vs.errors.DocumentError."""
        return self._open_desk().redo()

    def export(self, format: str, path: str | Path, *, force: bool = False) -> tuple[Path, ...]:
        """Write its features for other programs; returns the files.

        format : "csv", "gpkg" (with a map of QGIS beside), "shp", "geojson", "dxf", "kml",
            "stereonet", "orient", "faultkin", "wintensor", "gempy", "loopstructural" or "gems"

        force : replace a file that is there. Features without an orientation are left out with a
        warning. Raises vs.errors.UsageError for another format, vs.errors.InputError where there
        is nothing that the format can hold, vs.errors.TargetError where the file cannot be written.
        """
        from vomstudio.core.files.atomic import check_target

        target, replace, wanted = (
            path_of(path, "path"),
            flag(force, "force"),
            required_text(format, "format"),
        )
        check_target(target, force=replace, inputs=own_files(self._folder))
        records = self._records
        refuse_empty(records, self._folder)
        thresholds = self._measurements.default_thresholds
        with naming("format", "--to"):
            table = export_records(records, wanted, target, force=replace, thresholds=thresholds)
        warn(
            Finding("feature.left-out", feature=item["name"], reason=item["reason"])
            for item in table.skipped
        )
        return tuple(table.files)

    # --- within ----------------------------------------------------------------------------------
    def _open_desk(self) -> HeadlessProject:
        if self._desk is None:
            raise DocumentError(Finding("project.closed"), file=self._folder)
        return self._desk

    @property
    def _records(self) -> Any:
        return self._open_desk().session.records

    def _read(self, model_id: str) -> Mesh | PointCloud:
        desk = self._open_desk()
        model = desk.find_model(model_id)
        return as_recorded(desk.read_model(model), model)

    def _figures(self) -> dict[str, Any]:
        if self._desk is None:
            return {"folder": str(self._folder), "state": "closed"}
        session = self._desk.session
        return {
            "folder": str(self._folder),
            "models": tuple(model.name for model in session.of(Model)),
            "features": len(session.features()),
            "state": "unsaved changes" if session.dirty else "saved",
        }

    def __repr__(self) -> str:
        return text_table("Project", self._figures())

    def _repr_html_(self) -> str:
        return html_table("Project", self._figures())


def _points(given: Any) -> Any:
    return points(given)
