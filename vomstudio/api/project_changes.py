"""Changes to a project from a script; each is recorded as an edit in the journal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vomstudio.api.checking import (
    check_choice,
    is_path,
    name_argument_in_errors,
    optional_text,
    path_text,
    required_text,
    requires_type_error,
    to_list,
    to_path,
    warn,
    wrong_type_error,
)
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.frame_arguments import frame_options, name_frame_arguments_in_errors
from vomstudio.api.models import to_model
from vomstudio.api.planes import to_groups
from vomstudio.api.point_arguments import points
from vomstudio.api.registrations import observations_from_arguments, pairs_from_arguments
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import given_options
from vomstudio.core.progress import CancelToken
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.geology.slip import SENSES, SlipSense
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.project.kinds.station import STATION_KINDS, StationKind
from vomstudio.project.records import FeatureType, Model
from vomstudio.registration.results import ModelPlacement
from vomstudio.studio.headless_project import HeadlessProject, Picks
from vomstudio.studio.placed_features import SHAPE_NOUNS, PickedShape
from vomstudio.studio.project_options import AcceptOptions, FeatureValues, PlacementOptions

if TYPE_CHECKING:
    import numpy.typing as npt

    from vomstudio.api.argument_types import GroupsArgument, ModelArgument, PointsArgument
    from vomstudio.studio.project_summary import ModelSummary

Quality = Literal["good", "doubtful"]


class ProjectChanges:
    """Changes to a project, which `undo` reverts; the base class of `vs.Project`."""

    def _open_project(self) -> HeadlessProject:
        raise NotImplementedError

    # --- models -------------------------------------------------------------------------------
    def add_model(
        self,
        path: ModelArgument,
        *,
        name: str | None = None,
        crs: str | None = None,
        up: Literal["y", "z"] | None = None,
        unit: str | None = None,
        to_crs: str | None = None,
    ) -> str:
        """Add a model to the project.

        A registration next to the file places the model, so that the errors of the registration
        are propagated to all measurements on the model. If the file does not state its frame, a
        local frame in metres with z up is assumed, and a warning is issued. A file that the
        project already contains is not added again.

        Parameters
        ----------
        path : str, Path, Mesh, PointCloud, PyVista data set or (n, 3) array
            Path of a model; or a model in memory (World frame, metres), which is written to the
            folder ``models`` of the project.
        name : str, optional
            Name of a model in memory, by default "model".
        crs, up, unit, to_crs : str, optional
            See `vs.read`; for files only. If `to_crs` is given, the project contains a converted
            copy.

        Returns
        -------
        str
            Id of the model.

        Raises
        ------
        vs.errors.InputError
            If the model cannot be read.
        vs.errors.UsageError
            If the frame is invalid, or an argument does not apply to this kind of model.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> face = vs.Mesh.from_arrays([[0, 0, 0], [4, 0, 0], [0, 0, 3]], [[0, 1, 2]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     project.models[0].name, len(project.models[0].read().faces)
        ('face', 1)
        """
        project = self._open_project()
        options = frame_options(crs, up, unit, to_crs)
        if is_path(path):
            if name is not None:
                raise requires_type_error("name", "path", "vs.Mesh, vs.PointCloud")
            file = to_path(path, "path")
        else:
            for option in given_options(options):
                raise requires_type_error(option, "path", "str, pathlib.Path")
            file, options = self._write_model(path, optional_text(name, "name") or "model")
        with name_frame_arguments_in_errors():
            record = project.add_model(file, options)
        warn(record.warnings, notes=True)
        return record.model.id

    def _write_model(self, value: Any, name: str) -> tuple[Path, FrameOptions]:
        """Write a model in memory to the project, and return its path and frame."""
        model = to_model(value, "path")
        target = self._open_project().new_model_file(name)
        model.save(target)
        # A model from a file may have an unknown scale, which the copy states.
        is_in_memory = not model.path.is_file()
        frame = FrameOptions(crs=model.crs, up="z", unit="m") if is_in_memory else DEFAULT_FRAME
        return target, frame

    def register(
        self,
        model_points: PointsArgument | None = None,
        world_points: PointsArgument | None = None,
        *,
        model: str | ModelSummary | None = None,
        sigma_m: npt.ArrayLike | None = None,
        click_sigma_m: float | None = None,
        check: npt.ArrayLike | None = None,
        keep_scale: bool = False,
        robust: bool = False,
        pairs: str | Path | None = None,
        gcp: str | Path | None = None,
        marks: str | Path | None = None,
        model_cameras: str | Path | None = None,
        cameras: str | Path | bool | None = None,
        attitudes: str | Path | bool | None = None,
        horizon: str | Path | None = None,
        orientations: str | Path | None = None,
        azimuth: Literal["strike", "dipdir"] | None = None,
        scale_bars: str | Path | None = None,
        scale: npt.ArrayLike = (),
        bearing: npt.ArrayLike = (),
        level: npt.ArrayLike = (),
        plumb: npt.ArrayLike = (),
        reference: str | Path | None = None,
        stable: str | Path | None = None,
        north: Literal["grid", "true", "magnetic"] = "grid",
        date: str | None = None,
        declination_deg: float | None = None,
        north_sigma_deg: float | None = None,
        crs: str | None = None,
        to_crs: str | None = None,
        without: Sequence[str] | str = (),
    ) -> ModelPlacement:
        """Register a model of the project; the features on it move with the model.

        Parameters that the observations do not determine keep their values.

        Parameters
        ----------
        model_points : (n, 3) array, optional
            Points in the frame and unit of the model's file.
        world_points : (n, 3) array, optional
            The same points in the World frame, metres.
        model : str or ProjectModel, optional
            Id or name of the model; by default the only model.
        sigma_m, check, click_sigma_m, keep_scale, robust
            See `vs.register`. ``click_sigma_m`` is by default half the resolution of the model.
        pairs, gcp, marks, model_cameras, cameras, attitudes, horizon, orientations, scale_bars
            Tables and folders of observations; see `vs.register`.
        azimuth : {"strike", "dipdir"}, optional
            Meaning of a column named ``azimuth`` in the table of orientations.
        scale, bearing, level, plumb
            Rows of numbers; see `vs.register`.
        reference, stable : str or Path, optional
            Reference model to which the model is fitted, starting with its present placement, and
            the stable part of the reference.
        north, date, declination_deg, north_sigma_deg
            North of the azimuths; see `vs.register`.
        crs, to_crs : str, optional
            Projected CRS of the World frame, and the CRS to which the positions are converted.
        without : sequence of str or str, optional
            Labels of excluded observations.

        Returns
        -------
        ModelPlacement
            See `vs.register`.

        Raises
        ------
        vs.errors.InputError, vs.errors.UsageError, vs.errors.GeometryError
            As `vs.register`; the project is then unchanged.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import numpy as np
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> points = np.array([*corners, [2, 0.5, 1.5]])
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, model=model, type="joint")
        ...     before = project.fit(trace).dip_direction_deg
        ...     turned = points[:, [1, 0, 2]] * [-1, 1, 1] + [500, 100, 20]
        ...     check = [False] * 4 + [True]
        ...     placed = project.register(points, turned, check=check, click_sigma_m=0)
        ...     round((project.fit(trace).dip_direction_deg - before) % 360, 6)
        270.0
        """
        project = self._open_project()
        record = self._model(model)
        options = observations_from_arguments(PlacementOptions, locals(), model=record.id)
        point_pairs = None
        if model_points is not None or world_points is not None:
            if pairs is not None:
                conflict = Finding("option.conflict", option="model_points", other="pairs")
                raise UsageError(conflict, field="pairs")
            point_pairs = pairs_from_arguments(model_points, world_points, sigma_m, check)
        else:
            for name, value in (("sigma_m", sigma_m), ("check", check)):
                if value is not None:
                    raise requires_type_error(name, "model_points", "numpy.ndarray")
        with name_arguments_in_errors(PlacementOptions):
            placement = project.register(record, options, point_pairs).result.placed
        warn(placement.warnings)
        return placement

    # --- features -----------------------------------------------------------------------------
    def add_trace(
        self,
        points: PointsArgument,
        *,
        model: str | ModelSummary | None = None,
        type: str,
        name: str | None = None,
        set: str | None = None,
        domain: str | None = None,
    ) -> str:
        """Add points along a bed, fault or joint as a trace.

        Parameters
        ----------
        points : (n, 3) array or DataFrame
            Points in the World frame, metres, n >= 3, in order along the trace.
        model : str or ProjectModel, optional
            Id or name of the model on which the points lie; by default the only model.
        type : str
            Name of a feature type, ignoring case.
        name : str, optional
            Name of the trace; by default the next number of its type.
        set : str, optional
            Set of the trace.
        domain : str, optional
            Part of the structure in which the trace lies.

        Returns
        -------
        str
            Id of the trace.

        Raises
        ------
        vs.errors.InputError
            If the array has another shape.
        vs.errors.GeometryError
            If the points do not define a plane or are far from the model.
        vs.errors.UsageError
            If the model or the type does not exist.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, model=model, type="joint", set="steep")
        ...     project.traces()[["name", "set"]].values.tolist()
        [['J01', 'steep']]
        """
        # Check before the edit, because the journal would be unreadable with any other value.
        labels = _labels(name=name, domain=domain)
        picks = Picks(labels["name"], _to_points(points), domain=labels["domain"])
        return self._add_picks([picks], model, type, set)[0]

    def add_points(
        self,
        points: GroupsArgument,
        *,
        by: str | None = None,
        model: str | ModelSummary | None = None,
        type: str,
        shape: PickedShape = "trace",
        set: str | None = None,
        domain: str | None = None,
    ) -> tuple[str, ...]:
        """Add one trace, line or patch for each group of points, as one step.

        Groups that do not define such a feature are left out, with a warning.

        Parameters
        ----------
        points : DataFrame or dict of str to (n, 3) array
            Points in the World frame, metres: columns x, y, z of a table, or arrays by the names
            of the features.
        by : str, optional
            Column of the table with the names of the features.
        shape : {"trace", "line", "patch"}, optional
            Feature that the points of a group define: a trace, a line (see `add_line`), or the
            outline of a patch (see `add_patch`).
        model, type, set, domain
            See `add_trace`.

        Returns
        -------
        tuple of str
            Ids of the features.

        Raises
        ------
        vs.errors.InputError, vs.errors.UsageError
            As `add_trace`.
        vs.errors.GeometryError
            If no group defines such a feature.

        Examples
        --------
        >>> import tempfile, pathlib, pandas
        >>> import vomstudio as vs
        >>> picks = pandas.read_csv(vs.sample("picks.csv"), comment="#")
        >>> joints = picks[picks["kind"] == "joint"]
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "cliff.vom") as project:
        ...     model = project.add_model(vs.sample("sample.obj"))
        ...     traces = project.add_points(joints, by="pick", model=model, type="joint")
        ...     len(traces) == joints["pick"].nunique()
        True
        """
        with name_argument_in_errors("points", "groups"):
            groups = to_groups(points, by)
        warn(groups.messages)
        check_choice(shape, SHAPE_NOUNS, "shape")
        domain_name = _labels(domain=domain)["domain"]
        ends = zip(groups.offsets, groups.offsets[1:], strict=False)
        picks = [
            Picks(_to_name(id_), groups.points[first:stop], domain=domain_name)
            for id_, (first, stop) in zip(groups.ids, ends, strict=True)
        ]
        return self._add_picks(picks, model, type, set, shape)

    def _add_picks(
        self,
        picks: Sequence[Picks],
        model: str | ModelSummary | None,
        type: str,
        set: str | None,
        shape: PickedShape = "trace",
    ) -> tuple[str, ...]:
        set_name = _labels(set=set)["set_name"]
        record, kind = self._find_target(model, type)
        result = self._open_project().add_picks(picks, record, kind, set_name, shape)
        warn(
            Finding("feature.left-out", feature=name, reason=reason)
            for name, reason in result.skipped
        )
        warn(result.warnings)
        return tuple(feature.id for feature in result.features)

    def add_line(
        self,
        points: PointsArgument,
        *,
        model: str | ModelSummary | None = None,
        type: str,
        name: str | None = None,
        set: str | None = None,
        domain: str | None = None,
        on: str | None = None,
        slip_sense: SlipSense = "",
    ) -> str:
        """Add a line: a lineation or fold axis, or a contact line without a plane.

        Parameters
        ----------
        points : (n, 3) array or DataFrame
            Points in the World frame, metres, n >= 2, in order along the line.
        model : str or ProjectModel, optional
            Id or name of the model on which the points lie; by default the only model.
        type : str
            Name of a feature type. If its features are lines ("lineation", "fold axis"), the line
            has a trend and a plunge (`lines`); otherwise it is a contact line (`contacts`).
        name, set, domain : str, optional
            See `add_trace`.
        on : str, optional
            Id or name of the plane that contains the lineation, which then has a rake.
        slip_sense : {"", "normal", "reverse", "sinistral", "dextral"}, optional
            Movement of the hanging wall along the lineation.

        Returns
        -------
        str
            Id of the line.

        Raises
        ------
        vs.errors.InputError
            If the array has another shape, or the plane does not exist.
        vs.errors.GeometryError
            If there are fewer than two distinct points, or they are far from the model.
        vs.errors.UsageError
            If the model or the type does not exist, or a contact line has a plane or a sense.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     fault = project.add_trace(corners, model=model, type="fault")
        ...     line = project.add_line(
        ...         [[1, 0, 0], [2, 1, 3]], model=model, type="lineation", on=fault
        ...     )
        ...     contact = project.add_line([[0, 0, 0], [4, 0, 0]], model=model, type="contact")
        ...     round(project.fit(line).rake_deg), project.contacts()["length_m"].tolist()
        (108, [4.0])
        """
        vertices, labels = _to_points(points), _labels(name=name, set=set, domain=domain)
        plane = optional_text(on, "on")
        check_choice(slip_sense, (sense for sense, _ in SENSES), "slip_sense")
        record, kind = self._find_target(model, type)
        with name_argument_in_errors("points"), name_argument_in_errors("type", "--type"):
            line = self._open_project().add_line(
                vertices, record, kind, plane=plane, slip=slip_sense, **labels
            )
        return line.id

    def add_patch(
        self,
        outline: PointsArgument | None = None,
        *,
        elements: npt.ArrayLike | None = None,
        model: str | ModelSummary | None = None,
        type: str,
        name: str | None = None,
        set: str | None = None,
        domain: str | None = None,
    ) -> str:
        """Add a patch of the surface of a model, such as a joint face, and fit its plane.

        Parameters
        ----------
        outline : (n, 3) array or DataFrame, optional
            Points around the patch in the World frame, metres, n >= 3, in order. The patch
            consists of the connected faces (by their centroids) or points inside the outline, as
            seen along its normal.
        elements : (k,) int or (m,) bool array, optional
            Faces of the mesh or points of the cloud, in place of an outline.
        model : str or ProjectModel, optional
            Id or name of the model; by default the only model.
        type : str
            Name of a feature type, ignoring case.
        name, set, domain : str, optional
            See `add_trace`.

        Returns
        -------
        str
            Id of the patch.

        Raises
        ------
        vs.errors.InputError
            If an array has another shape, an element does not exist, or the model cannot be read.
        vs.errors.GeometryError
            If the outline contains no part of the model, or the patch has no plane.
        vs.errors.UsageError
            If the model or the type does not exist, or not exactly one of `outline` and
            `elements` is given.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import numpy as np
        >>> import vomstudio as vs
        >>> x, z = (a.ravel() for a in np.meshgrid(np.arange(0, 4, 0.1), np.arange(0, 3, 0.1)))
        >>> cloud = np.column_stack([x, 0.5 * z, z])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(cloud, name="face")
        ...     ring = [[0.5, 0.5, 1], [3, 0.5, 1], [3, 1, 2], [0.5, 1, 2]]
        ...     first = project.add_patch(ring, model=model, type="joint")
        ...     second = project.add_patch(elements=z < 1.5, model=model, type="joint")
        ...     round(project.fit(first).dip_deg), round(project.fit(second).dip_deg)
        (63, 63)
        """
        record, kind = self._find_target(model, type)
        labels = _labels(name=name, set=set, domain=domain)
        if (outline is None) == (elements is None):
            names = ("outline", "elements")
            if outline is None:
                raise UsageError(Finding("option.none-given", options=names), field="outline")
            conflict = Finding("option.conflict", option=names[0], other=names[1])
            raise UsageError(conflict, field="elements")
        area = _to_points(outline, "outline") if elements is None else _to_elements(elements)
        argument = "outline" if elements is None else "elements"
        with name_argument_in_errors(argument):
            return self._open_project().add_patch(record, kind, area, **labels).id

    def add_station(
        self,
        point: npt.ArrayLike,
        *,
        model: str | ModelSummary | None = None,
        what: StationKind = "station",
        name: str | None = None,
        number: str | None = None,
        photo: str | None = None,
        notes: str | None = None,
    ) -> str:
        """Add a station or sample, which has a position but no orientation.

        Parameters
        ----------
        point : (3,) array
            Position in the World frame, metres.
        model : str or ProjectModel, optional
            Id or name of the model; by default the only model.
        what : {"station", "sample"}, optional
            Kind of the station.
        name : str, optional
            Name, by default the next number.
        number : str, optional
            Number as written in the field book or on the sample bag.
        photo : str, optional
            Names or paths of photos, separated by semicolons.
        notes : str, optional
            Description.

        Returns
        -------
        str
            Id of the station.

        Raises
        ------
        vs.errors.InputError
            If the point does not have three finite coordinates.
        vs.errors.GeometryError
            If the point is far from the model.
        vs.errors.UsageError
            If the model does not exist.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> face = vs.Mesh.from_arrays([[0, 0, 0], [4, 0, 0], [0, 0, 3]], [[0, 1, 2]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     sample = project.add_station([1, 0, 1], model=model, what="sample", number="K-7")
        ...     project.stations()[["kind", "number"]].values.tolist()
        [['sample', 'K-7']]
        """
        (position,) = _to_points([point], "point")
        check_choice(what, (kind for kind, _ in STATION_KINDS), "what")
        texts = {"name": name, "number": number, "photo": photo, "notes": notes}
        labels = {key: optional_text(text, key) or "" for key, text in texts.items()}
        record = self._model(model)
        with name_argument_in_errors("point"):
            return self._open_project().add_station(position, record, what, **labels).id

    def import_file(
        self, path: str | Path, *, model: str | ModelSummary | None = None
    ) -> tuple[str, ...]:
        """Add the traces, planes, stations, contact lines and rock areas of a file in one step.

        Features that cannot be added are left out, with a warning.

        Parameters
        ----------
        path : str or Path
            GeoPackage, GeoJSON, shapefile, DXF or KML; table of points; file as written by
            `export`; or export of CloudCompare (Compass, Facets), PRo3D or Move.
        model : str or ProjectModel, optional
            Id or name of the model on which the features lie; by default the only model.

        Returns
        -------
        tuple of str
            Ids of the features.

        Raises
        ------
        vs.errors.InputError
            If the file cannot be read or contains no such features.
        vs.errors.UsageError
            If the model does not exist.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> _ = (folder / "stations.csv").write_text("name,x,y,z" + chr(10) + "S1,1,0,1")
        >>> face = vs.Mesh.from_arrays([[0, 0, 0], [4, 0, 0], [0, 0, 3]], [[0, 1, 2]])
        >>> with vs.Project.create(folder / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     stations = project.import_file(folder / "stations.csv")
        ...     project.stations()["name"].tolist()
        ['S1']
        """
        file, record = to_path(path, "path"), self._model(model)
        result = self._open_project().import_features(file, record)
        warn(
            Finding("feature.left-out", feature=name, reason=reason)
            for name, reason in result.skipped
        )
        warn(result.warnings)
        return tuple(feature.id for feature in result.features)

    def accept_facets(
        self,
        *,
        model: str | ModelSummary | None = None,
        type: str,
        set: str | None = None,
        quality: Quality | None = None,
        angle_deg: float | None = None,
        max_distance_m: float | None = None,
        min_points: int | None = None,
        min_area_m2: float | None = None,
        min_coplanarity: float | None = None,
        progress: ProgressArgument = None,
        cancel: CancelToken | None = None,
    ) -> tuple[str, ...]:
        """Find the planar facets of a model, and add them as patches, as one step.

        Parameters
        ----------
        model : str or ProjectModel, optional
            Id or name of the model; by default the only model.
        type : str
            Name of the feature type of the patches.
        set : str, optional
            Set of the patches.
        quality : {"good", "doubtful"}, optional
            Minimum quality of a patch; by default all facets are added.
        angle_deg, max_distance_m, min_points, min_area_m2, min_coplanarity
            Thresholds of the search; see `vs.facets`.
        progress, cancel
            See `vs.facets`.

        Returns
        -------
        tuple of str
            Ids of the patches.

        Raises
        ------
        vs.errors.DocumentError
            If no facet has the quality.
        vs.errors.InputError, vs.errors.UsageError, vs.errors.GeometryError
            As `vs.facets`, and if the model or the type does not exist.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import numpy as np
        >>> import vomstudio as vs
        >>> a, b = (v.ravel() for v in np.meshgrid(np.arange(0, 4, 0.1), np.arange(0, 4, 0.1)))
        >>> east, north = np.column_stack([0 * a, a, b]), np.column_stack([a + 0.1, 0 * a, b])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "walls.vom") as project:
        ...     model = project.add_model(np.concatenate([east, north]), name="walls")
        ...     patches = project.accept_facets(type="joint", quality="good")
        ...     project.planes()["dip_deg"].round().tolist()
        [90.0, 90.0]
        """
        search = options_from_arguments(FacetOptions, locals())
        return self._accept_proposals(search, model, type, set, quality, progress, cancel)

    def accept_traces(
        self,
        *,
        model: str | ModelSummary | None = None,
        type: str,
        set: str | None = None,
        quality: Quality | None = None,
        cost: str | None = None,
        min_length_m: float | None = None,
        max_lines: int = 50,
        onnx_model: str | Path | None = None,
        progress: ProgressArgument = None,
        cancel: CancelToken | None = None,
    ) -> tuple[str, ...]:
        """Propose lines on a model, and add them as traces, as one step.

        Lines that are already traces are not added again.

        Parameters
        ----------
        model, type, set, quality
            See `accept_facets`.
        cost, min_length_m, max_lines, onnx_model, progress, cancel
            See `vs.propose_traces`.

        Returns
        -------
        tuple of str
            Ids of the traces.

        Raises
        ------
        vs.errors.DocumentError
            If no line has the quality.
        vs.errors.InputError, vs.errors.UsageError, vs.errors.GeometryError
            As `vs.propose_traces`, and if the model or the type does not exist.

        Examples
        --------
        A dark bed on a slope:

        >>> import tempfile, pathlib
        >>> import numpy as np
        >>> import vomstudio as vs
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> x, y = (a.ravel() for a in np.meshgrid(np.arange(0, 3, 0.05), np.arange(0, 3, 0.05)))
        >>> z = 0.5 * y + 0.2 * np.sin(3 * x)
        >>> grey = np.where(np.abs(z - 0.7) < 0.04, 90.0, 200.0)
        >>> grey += np.random.default_rng(1).normal(0.0, 10.0, len(x))
        >>> rows = np.column_stack([x, y, z, grey])
        >>> np.savetxt(folder / "slope.csv", rows, delimiter=",", header="x,y,z,grey", comments="")
        >>> with vs.Project.create(folder / "slope.vom") as project:
        ...     model = project.add_model(folder / "slope.csv", up="z", unit="m")
        ...     traces = project.accept_traces(
        ...         type="bedding", cost="grey", min_length_m=2.0, max_lines=1
        ...     )
        ...     len(traces), bool(project.planes()["dip_deg"][0] < 5)
        (1, True)
        """
        search = options_from_arguments(
            ProposalOptions, locals(), onnx_model=path_text(onnx_model, "onnx_model")
        )
        return self._accept_proposals(search, model, type, set, quality, progress, cancel)

    def _accept_proposals(
        self,
        search: FacetOptions | ProposalOptions,
        model: str | ModelSummary | None,
        type: str,
        set: str | None,
        quality: Quality | None,
        progress: ProgressArgument,
        cancel: CancelToken | None,
    ) -> tuple[str, ...]:
        from vomstudio.studio.surfaces.headless_proposals import accept_proposals

        report = to_progress(progress, cancel)
        record, kind = self._find_target(model, type)
        options = options_from_arguments(
            AcceptOptions,
            model=record.id,
            type=kind.id,
            set=optional_text(set, "set"),
            quality=quality,
        )
        with name_arguments_in_errors(search.__class__):
            result = accept_proposals(self._open_project(), search, options, report)
        warn(result.warnings)
        return tuple(feature.id for feature in result.features)

    def set_type(self, features: str | Sequence[str], type: str) -> tuple[str, ...]:
        """Change the type of features, as one step.

        Parameters
        ----------
        features : str or sequence of str
            Ids or names.
        type : str
            Name of a feature type, ignoring case.

        Returns
        -------
        tuple of str
            Ids of the features.

        Raises
        ------
        vs.errors.InputError
            If a feature does not exist.
        vs.errors.UsageError
            If the type does not exist.
        vs.errors.DocumentError
            If the features have this type already.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, model=model, type="joint")
        ...     changed = project.set_type(trace, "fault")
        ...     project.planes()["kind"].tolist()
        ['fault']
        """
        return self.set_values(features, type=required_text(type, "type"))

    def set_values(
        self,
        features: str | Sequence[str],
        *,
        type: str | None = None,
        set: str | None = None,
        domain: str | None = None,
        name: str | None = None,
    ) -> tuple[str, ...]:
        """Change the type, set, domain or name of features, as one step.

        Parameters
        ----------
        features : str or sequence of str
            Ids or names.
        type : str, optional
            Name of a feature type, ignoring case.
        set, domain : str, optional
            Set and domain; empty to remove them.
        name : str, optional
            Name of a single feature.

        Returns
        -------
        tuple of str
            Ids of the features.

        Raises
        ------
        vs.errors.InputError
            If a feature does not exist.
        vs.errors.UsageError
            If the type does not exist, no value is given, or several features would have the
            same name.
        vs.errors.DocumentError
            If the features have these values already.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, model=model, type="joint")
        ...     changed = project.set_values(trace, set="steep", name="J7")
        ...     project.planes()[["name", "set"]].values.tolist()
        [['J7', 'steep']]
        """
        names = _feature_names(features)
        values = options_from_arguments(FeatureValues, locals())
        with name_argument_in_errors("features"), name_arguments_in_errors(FeatureValues):
            changed_features = self._open_project().set_values(names, values)
        return tuple(feature.id for feature in changed_features)

    def delete(self, features: str | Sequence[str]) -> tuple[str, ...]:
        """Delete features, as one step.

        Features that depend on them remain, and report their missing inputs.

        Parameters
        ----------
        features : str or sequence of str
            Ids or names.

        Returns
        -------
        tuple of str
            Ids of the deleted features.

        Raises
        ------
        vs.errors.InputError
            If a feature does not exist.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, model=model, type="joint", name="J1")
        ...     deleted = project.delete("J1")
        ...     label = project.undo()
        ...     len(project.traces())
        1
        """
        names = _feature_names(features)
        with name_argument_in_errors("features"):
            deleted_features = self._open_project().delete(names)
        return tuple(feature.id for feature in deleted_features)

    # --- history and verdicts -----------------------------------------------------------------
    def judge_by(self, profile: str) -> None:
        """Set the verdict profile of all features.

        Parameters
        ----------
        profile : {"error", "textbook"}

        Raises
        ------
        vs.errors.UsageError
            If the profile is unknown.
        vs.errors.DocumentError
            If the project already uses this profile.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     project.judge_by("textbook")
        ...     project.fit("J1").profile
        'textbook'
        """
        self._open_project().judge_by(required_text(profile, "profile"))

    def update_surroundings(self) -> int:
        """Remeasure the surroundings of features that were measured by an earlier method.

        The surroundings are the resolution and the outcrop face around a feature. Features on a
        model that cannot be read keep their values, with a warning.

        Returns
        -------
        int
            Number of updated features.

        Raises
        ------
        vs.errors.DocumentError
            If all features were measured by the current method.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     try:
        ...         project.update_surroundings()
        ...     except vs.errors.DocumentError as error:
        ...         error.code
        'surroundings.up-to-date'
        """
        updated_count, findings = self._open_project().update_surroundings()
        warn(findings)
        return updated_count

    def undo(self) -> str:
        """Undo the last step, even of an earlier session.

        Returns
        -------
        str
            Label of the step.

        Raises
        ------
        vs.errors.DocumentError
            If the project has no step to undo.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     label = project.undo()
        ...     len(project.traces())
        0
        """
        return self._open_project().undo()

    def redo(self) -> str:
        """Redo the last undone step.

        Returns
        -------
        str
            Label of the step.

        Raises
        ------
        vs.errors.DocumentError
            If the project has no step to redo.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> corners = [[0, 0, 0], [4, 0, 0], [4, 1, 3], [0, 1, 3]]
        >>> face = vs.Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        >>> with vs.Project.create(pathlib.Path(tempfile.mkdtemp()) / "face.vom") as project:
        ...     model = project.add_model(face, name="face")
        ...     trace = project.add_trace(corners, type="joint", name="J1")
        ...     label = project.undo()
        ...     label = project.redo()
        ...     len(project.traces())
        1
        """
        return self._open_project().redo()

    # --- arguments ----------------------------------------------------------------------------
    def _model(self, model: str | ModelSummary | None) -> Model:
        """Return the record of a model. Raises InputError or UsageError."""
        name = getattr(model, "id", None) or optional_text(model, "model")
        with name_argument_in_errors("model", "--model"):
            return self._open_project().find_model(name)

    def _find_target(
        self, model: str | ModelSummary | None, type: str
    ) -> tuple[Model, FeatureType]:
        """Return the model and the type of new features. Raises InputError or UsageError."""
        with name_argument_in_errors("type", "--type"):
            kind = self._open_project().find_type(required_text(type, "type"))
        return self._model(model), kind


def _labels(**texts: Any) -> dict[str, str]:
    """Return the fields of a record for the arguments `name`, `set` and `domain`."""
    return {
        "set_name" if name == "set" else name: optional_text(text, name) or ""
        for name, text in texts.items()
    }


def _to_name(value: Any) -> str:
    """Return the name of a group of points, such as "7" for the number 7.0."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _feature_names(features: Any) -> list[str]:
    """Return the ids or names of features. Raises InputError."""
    return [required_text(name, "features") for name in to_list(features, "features")]


def _to_points(value: Any, name: str = "points") -> FloatArray:
    return points(value, name)


def _to_elements(value: Any) -> IntArray | BoolArray:
    """Convert indices of elements, or a mask, to an array (n,). Raises InputError."""
    try:
        array = np.asarray(value)
    except ValueError as error:  # Rows of different lengths.
        raise wrong_type_error(value, "numpy.ndarray", "elements") from error
    is_empty = array.ndim == 1 and not array.size
    if array.ndim != 1 or not (array.dtype.kind in "biu" or is_empty):
        raise wrong_type_error(value, "numpy.ndarray", "elements")
    return array if array.dtype == bool else array.astype(np.int64)
