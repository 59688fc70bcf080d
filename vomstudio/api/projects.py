"""Projects opened without a window."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from vomstudio.api import feature_tables
from vomstudio.api.checking import (
    check_flag,
    name_argument_in_errors,
    required_text,
    to_path,
    warn,
)
from vomstudio.api.models import Mesh, PointCloud, apply_recorded_placement
from vomstudio.api.planes import LineFit, PlaneFit, to_line_fit, to_plane_fit
from vomstudio.api.project_changes import ProjectChanges
from vomstudio.core.errors import DocumentError, GeometryError, InputError, VomWarning
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.reprs import html_table, text_table
from vomstudio.project.exports.export import export_records, refuse_empty
from vomstudio.project.journal.database import journal_files
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Model
from vomstudio.project.verify import Verification, verify
from vomstudio.studio.headless_project import HeadlessProject
from vomstudio.studio.project_summary import ModelSummary, fitted_records, summarise_models
from vomstudio.studio.surfaces.grid_coverage import GridShare, grid_shares

if TYPE_CHECKING:
    from geopandas import GeoDataFrame

    from vomstudio.products.report.project import ProjectReport
    from vomstudio.rendering.plots.plotting import Plotter


@dataclass(frozen=True, eq=False, kw_only=True)
class ProjectModel(ModelSummary):
    """Model of a project.

    Attributes
    ----------
    id, name, kind : str
        Id, name and kind; the kind is "mesh" or "cloud".
    path : str
        Path of the model file, as stored in the project.
    frame : str
        Description of the placement.
    crs : str or None
        CRS as "EPSG:n".
    features : int
        Number of features on the model.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import vomstudio as vs
    >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "cliff.vom") as project:
    ...     _ = project.add_model(vs.sample("sample.obj"))
    ...     project.models[0].name, project.models[0].crs, project.models[0].features
    ('sample', 'EPSG:32633', 0)
    """

    _project: Project = field(repr=False)

    def read(self) -> Mesh | PointCloud:
        """Read the model in the World frame.

        Raises
        ------
        vs.errors.InputError
            If the file is missing or has changed since the measurements were made.
        """
        return self._project._read(self.id)

    def plot(self) -> Plotter:
        """Return a plotter that shows the model; see `Mesh.plot`."""
        return self.read().plot()


class Project(ProjectChanges):
    """Project on disk, equivalent to the project in the window.

    Every change is recorded as an edit in the journal and written immediately.

    ``Project.open(path)`` and ``Project.create(path)`` are context managers. Leaving the block
    without calling ``save()`` discards the changes, as does closing the window without
    saving; ``undo()`` restores them after the project is reopened. A project can be open in
    only one program at a time.

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

    def __init__(self, project: HeadlessProject) -> None:
        self._headless_project: HeadlessProject | None = project
        self._folder = project.project.folder
        self._measurements = Measurements(project.settings.thresholds)

    # --- opening and closing ------------------------------------------------------------------
    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Open the project in a folder NAME.vom.

        Changes that were not saved because of a crash are included, with a warning.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Project

        Raises
        ------
        vs.errors.InputError
            If the folder is not a project, was written by a newer version, or is open in a
            window or notebook, which the error names.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> folder = pathlib.Path(tempfile.mkdtemp()) / "face.vom"
        >>> vs.Project.create(folder).close()
        >>> with vs.Project.open(folder) as project:
        ...     project.models
        ()
        """
        headless_project = HeadlessProject.open(to_path(path, "path"))
        project = cls(headless_project)
        warnings = [*headless_project.warnings, *headless_project.project.problems]
        if headless_project.is_recovered:
            warnings.append(Finding("project.recovered"))
        try:
            warn(warnings)
        except VomWarning:
            # If warnings are errors, the caller could not close the project.
            project.close()
            raise
        return project

    @classmethod
    def create(cls, path: str | Path) -> Self:
        """Create a project in the folder NAME.vom.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Project

        Raises
        ------
        vs.errors.TargetError
            If the folder exists or cannot be created.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> folder = pathlib.Path(tempfile.mkdtemp()) / "face.vom"
        >>> with vs.Project.create(folder) as project:
        ...     project.path == folder
        True
        """
        project = HeadlessProject.create(to_path(path, "path"))
        warn(project.warnings)
        return cls(project)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        exception_type: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the project and discard unsaved changes, which ``undo()`` can restore.

        Changes recovered after a crash remain if nothing else was changed. Closing a closed project
        has no effect.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> project = vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom")
        >>> project.close()
        >>> project
        Project
          folder  ...
          state   closed
        """
        project, self._headless_project = self._headless_project, None
        if project is not None:
            project.close()

    def save(self) -> None:
        """Save the current state and update the GIS layers (project.gpkg).

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     project.save()
        ...     project.unsaved
        False
        """
        warn(self._open_project().save())

    def save_as(self, path: str | Path) -> None:
        """Save the project with its history in another folder NAME.vom, and continue there.

        The original project remains as last saved. All changes are in memory, so this also works
        if the original folder was deleted or replaced, or if its disk is full. Files that can no
        longer be read are listed in a warning.

        Parameters
        ----------
        path : str or Path

        Raises
        ------
        vs.errors.TargetError
            If the target exists or cannot be written; the project is then unchanged.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     project.save_as(project.path.with_name("copy.vom"))
        ...     project.path.name
        'copy.vom'
        """
        project = self._open_project()
        skipped_files = project.save_as(to_path(path, "path"))
        self._folder = project.project.folder
        warn(skipped_files)

    # --- queries ------------------------------------------------------------------------------
    @property
    def path(self) -> Path:
        """Folder of the project.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     project.path.name
        'face.vom'
        """
        return self._folder

    @property
    def models(self) -> tuple[ProjectModel, ...]:
        """Models in the order in which they were added.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     [(each.name, each.kind) for each in project.models]
        [('face', 'mesh')]
        """
        return tuple(
            ProjectModel(**vars(facts), _project=self) for facts in summarise_models(self._records)
        )

    @property
    def unsaved(self) -> bool:
        """Whether there are changes since the last save.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     project.unsaved
        True
        """
        return self._open_project().session.dirty

    def planes(self) -> GeoDataFrame:
        """Return all planes, with the columns of the orientation table.

        Returns
        -------
        geopandas.GeoDataFrame
            ``geometry`` is the centroid as a shapely Point with z (World frame, metres), or None
            if the plane has no position. ``crs`` is the CRS of the World frame, or None if the
            features have no common CRS. ``.attrs["north"]`` describes the north of the azimuths.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     project.planes()[["name", "kind"]].values.tolist()
        [['J1', 'joint']]
        """
        return feature_tables.orientations(self._records, self._measurements, "plane")

    def lines(self) -> GeoDataFrame:
        """Return all lines (lineations, fold axes), with the columns of the orientation table.

        Returns
        -------
        geopandas.GeoDataFrame
            ``geometry`` is the centroid; see `planes`.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     line = project.add_line([[0, 0, 0], [4, 1, 3]], type="lineation")
        ...     project.lines()["trend_deg"].round().tolist()
        [256.0]
        """
        return feature_tables.orientations(self._records, self._measurements, "line")

    def traces(self) -> GeoDataFrame:
        """Return all traces.

        Returns
        -------
        geopandas.GeoDataFrame
            ``geometry`` contains shapely LineStrings with z (World frame, metres); ``crs`` as
            in `planes`.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     project.traces().geometry[0].geom_type
        'LineString'
        """
        return feature_tables.shapes(self._records, self._measurements, "traces")

    def patches(self) -> GeoDataFrame:
        """Return all patches.

        Returns
        -------
        geopandas.GeoDataFrame
            ``geometry`` contains the outlines as shapely Polygons with z (World frame, metres);
            ``crs`` as in `planes`.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     patch = project.add_patch(elements=[0, 1], type="joint")
        ...     project.patches().geometry[0].has_z
        True
        """
        return feature_tables.shapes(self._records, self._measurements, "patches")

    def stations(self) -> GeoDataFrame:
        """Return all stations and samples.

        Returns
        -------
        geopandas.GeoDataFrame
            Table with ``number`` and ``photo``; ``geometry`` contains shapely Points with z.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     station = project.add_station([0, 0, 0], number="7")
        ...     project.stations()["number"].tolist()
        ['7']
        """
        return feature_tables.shapes(self._records, self._measurements, "stations")

    def contacts(self) -> GeoDataFrame:
        """Return all contact lines, which have no plane.

        Returns
        -------
        geopandas.GeoDataFrame
            Table with ``length_m``; ``geometry`` contains shapely LineStrings with z.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     contact = project.add_line(corners[:2], type="contact")
        ...     project.contacts()["length_m"].tolist()
        [4.0]
        """
        return feature_tables.shapes(self._records, self._measurements, "contacts")

    def lithologies(self) -> GeoDataFrame:
        """Return all rock areas.

        Returns
        -------
        geopandas.GeoDataFrame
            Table with ``lithology``, ``area_m2`` (area of the enclosed surface) and
            ``outline_m2`` (area of the flattened outline); ``geometry`` contains the outlines as
            shapely Polygons with z.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     len(project.lithologies())
        0
        """
        return feature_tables.shapes(self._records, self._measurements, "lithologies")

    def coverage(self) -> list[GridShare]:
        """Return the coverage of each grid.

        Returns
        -------
        list of GridShare
            ``id``, ``name``, ``model`` and ``coverage`` (``cells``, ``done``, ``empty``,
            ``unmeasurable``, ``not_looked_at``, ``looked_at_share``, ``density_1_per_m2``,
            ``P21_1_per_m``; areas in m2). A grid whose model is missing is omitted, with a
            warning.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     project.coverage()
        []
        """
        shares, findings = grid_shares(self._open_project())
        warn(findings)
        return shares

    def fit(self, id: str) -> PlaneFit | LineFit:
        """Return the PlaneFit or LineFit of one feature.

        Parameters
        ----------
        id : str
            Id or name of the feature.

        Returns
        -------
        PlaneFit or LineFit

        Raises
        ------
        vs.errors.InputError
            If the feature does not exist.
        vs.errors.GeometryError
            If the feature has no orientation.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     fit = project.fit("J1")
        ...     round(fit.dip_direction_deg), round(fit.dip_deg)
        (180, 72)
        """
        feature = required_text(id, "id")
        orientations = fitted_records(self._records, self._measurements, self._folder, [feature])
        if orientations.rows:
            row = orientations.rows[0]
            measurement = self._measurements.of(self._records, [row["id"]])[row["id"]]
            warnings = () if measurement.verdict is None else measurement.verdict.warnings
            convert_row = to_plane_fit if row["element"] == "plane" else to_line_fit
            return convert_row(row, warnings)
        missing_plane = Finding("feature.without-plane")
        reason = orientations.skipped[0]["reason"] if orientations.skipped else missing_plane
        raise GeometryError(reason, field=id)

    def verify(self) -> Verification:
        """Verify every row and file of the project.

        Returns
        -------
        Verification
            ``sound``, ``problems``, ``steps``, ``models``, ``features``, ``assets``,
            ``schema``.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     project.verify().sound
        True
        """
        self._open_project()
        return verify(self._folder)

    def plot(self) -> Plotter:
        """Return a PyVista plotter with models, features, labels and planes; see `Mesh.plot`.

        A model whose file is missing is omitted, with a warning.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     project.plot().screenshot(return_img=True).ndim
        3
        """
        from vomstudio.api.plots import create_plotter

        models = []
        for model in self.models:
            try:
                models.append(model.read()._data)
            except InputError as error:
                warn([to_finding(error)])
        return create_plotter(models, feature_tables.drawings(self._records, self._measurements))

    # --- export -------------------------------------------------------------------------------
    def export(
        self, format: str, path: str | Path, *, projected: bool = False, force: bool = False
    ) -> tuple[Path, ...]:
        """Write the features for other programs.

        Features without an orientation are omitted, with a warning.

        Parameters
        ----------
        format : str
            "csv", "gpkg" (with a QGIS map), "shp", "geojson", "dxf", "kml", "stereonet",
            "orient", "faultkin", "wintensor", "gempy", "loopstructural" or "gems".
        path : str or Path
        projected : bool
            Whether to write GeoJSON in the CRS of the project in place of WGS 84.
        force : bool
            Whether to replace an existing file.

        Returns
        -------
        tuple of Path
            Paths of the written files.

        Raises
        ------
        vs.errors.UsageError
            If the format is unknown.
        vs.errors.InputError
            If the format cannot represent any of the features.
        vs.errors.TargetError
            If the file exists or cannot be written.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     (file,) = project.export("csv", project.path.with_name("planes.csv"))
        ...     file.name
        'planes.csv'
        """
        from vomstudio.core.files.atomic import check_target

        target, replace, format_name = (
            to_path(path, "path"),
            check_flag(force, "force"),
            required_text(format, "format"),
        )
        is_projected = check_flag(projected, "projected")
        check_target(target, force=replace, inputs=journal_files(self._folder))
        records = self._records
        refuse_empty(records, self._folder)
        thresholds = self._measurements.default_thresholds
        with name_argument_in_errors("format", "--to"):
            table = export_records(
                records,
                format_name,
                target,
                is_projected=is_projected,
                force=replace,
                thresholds=thresholds,
            )
        warn(table.warnings)
        warn(
            Finding("feature.left-out", feature=item["name"], reason=item["reason"])
            for item in table.skipped
        )
        return tuple(table.files)

    def report(self, path: str | Path, *, force: bool = False) -> ProjectReport:
        """Write an HTML report with the models, features, verdicts, statistics and net.

        Features without an orientation are listed with the reason.

        Parameters
        ----------
        path : str or Path
            File with the extension ".html".
        force : bool
            Whether to replace an existing file.

        Returns
        -------
        ProjectReport
            ``file``, ``planes``, ``lines`` (their numbers), ``quality`` (number of features with
            each verdict) and ``skipped`` (``id``, ``name``, ``reason``).

        Raises
        ------
        vs.errors.UsageError
            If the extension is not ".html".
        vs.errors.TargetError
            If the file exists or cannot be written.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> with vs.Project.create(folder / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, model=model, type="joint")
        ...     report = project.report(folder / "face.html")
        ...     report.planes, report.lines
        (1, 0)
        """
        from vomstudio.core.files.atomic import check_target
        from vomstudio.products.report.project import write_project_report

        target, replace = to_path(path, "path"), check_flag(force, "force")
        with name_argument_in_errors("path", "--output"):
            check_target(target, force=replace, inputs=journal_files(self._folder))
            return write_project_report(
                target,
                self._records,
                self._measurements,
                title=self._folder.stem,
                force=replace,
            )

    # --- implementation -----------------------------------------------------------------------
    def _open_project(self) -> HeadlessProject:
        if self._headless_project is None:
            raise DocumentError(Finding("project.closed"), file=self._folder)
        return self._headless_project

    @property
    def _records(self) -> Any:
        return self._open_project().session.records

    def _read(self, model_id: str) -> Mesh | PointCloud:
        project = self._open_project()
        model = project.find_model(model_id)
        return apply_recorded_placement(project.read_model(model), model)

    def _repr_values(self) -> dict[str, Any]:
        if self._headless_project is None:
            return {"folder": str(self._folder), "state": "closed"}
        session = self._headless_project.session
        return {
            "folder": str(self._folder),
            "models": tuple(model.name for model in session.of(Model)),
            "features": len(session.features()),
            "state": "unsaved changes" if session.dirty else "saved",
        }

    def __repr__(self) -> str:
        return text_table("Project", self._repr_values())

    def _repr_html_(self) -> str:
        return html_table("Project", self._repr_values())
