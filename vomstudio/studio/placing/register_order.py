"""Registration of a model with the files and options of the command `register`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.progress import Progress
from vomstudio.core.results import FLATTENED_IN_JSON, HIDDEN_IN_JSON, OPTIONAL_IN_JSON, Result
from vomstudio.geometry import transform
from vomstudio.geometry.coordinate_limits import check_error
from vomstudio.geometry.frames import UNDECLARED_FRAME, Frame
from vomstudio.geometry.matrices import IDENTITY
from vomstudio.geometry.registration_frames import change_file_frame
from vomstudio.geometry.registrations import NorthReference, Registration
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.project.records import Model
from vomstudio.registration.evidence import Evidence
from vomstudio.registration.level_evidence import KnownDirection
from vomstudio.registration.register_options import BESIDE, Observations, RegisterOptions
from vomstudio.studio.placing.known_lines import photo_up, solve_placement, up_direction

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray
    from vomstudio.io.control.attitude_tables import AttitudeTable
    from vomstudio.io.control.observation_tables import Pairs, Positions
    from vomstudio.io.models.reader import LoadedModel
    from vomstudio.io.photos.own_cameras.result import ModelCameras
    from vomstudio.registration.attitude_evidence import AttitudeResidual
    from vomstudio.registration.compass_evidence import Segment
    from vomstudio.registration.north import NorthInputs
    from vomstudio.registration.results import ModelPlacement
    from vomstudio.studio.placing.reference_fitting import ReferenceFit

# Survey formats in which z is a height even if they state no CRS.
SURVEY_FORMATS = (".las", ".laz", ".tif", ".tiff")


@dataclass(frozen=True, eq=False)
class RegistrationResult(Result):
    """Result of a registration.

    `placed` is the placement with all warnings, and `attitudes` are the residuals of photo
    attitudes. `loaded` is the model, or None if only a placement was computed. `crs` is the CRS
    of the World frame, and `reference` is the fit to the reference. `registration` is a record
    as in a project, from the file frame of the model to the World frame, or None if only a
    placement was computed.
    """

    placed: ModelPlacement = field(metadata=FLATTENED_IN_JSON)
    attitudes: Sequence[AttitudeResidual] = field(metadata=OPTIONAL_IN_JSON)
    loaded: LoadedModel | None = field(metadata=HIDDEN_IN_JSON)
    crs: str | None = field(metadata=HIDDEN_IN_JSON)
    reference: ReferenceFit | None = field(metadata=OPTIONAL_IN_JSON)
    registration: Registration | None = field(default=None, metadata=HIDDEN_IN_JSON)

    @property
    def registration_in_world(self) -> Registration | None:
        """Registration for the model written in World, or None.

        It is the identity with the errors of `registration`.
        """
        if self.registration is None:
            return None
        return change_file_frame(self.registration, self.registration.matrix)


def register_model(model: str, options: RegisterOptions, progress: Progress) -> RegistrationResult:
    """Register a model with the given observations.

    Parameters
    ----------
    model : str
        Path of the model, or "-" to compute only a placement.
    options : RegisterOptions
    progress : Progress

    Raises
    ------
    UsageError, InputError, GeometryError
    """
    for flag, value in (("--up", options.up), ("--unit", options.unit)):
        if value is not None and model == "-":
            raise UsageError(Finding("option.needs-model", option=flag), field="MODEL")
    crs = _metric_crs(options)
    loaded_model = None
    if model != "-":
        from vomstudio.io.models.opening import read_model

        loaded_model = read_model(Path(model), progress)
    findings = list[Finding]()
    record = None if loaded_model is None else _model_record(loaded_model, options, findings)
    unit_m = METRES_PER_UNIT[options.unit or "m"]
    start = _Start(
        record,
        up=None if loaded_model is None else _known_up_direction(loaded_model, options),
        to_world=transform.matrix(Frame("local", None, unit_m, options.up or "z").to_world()),
    )
    if options.unit is not None:
        start = replace(start, scale=unit_m)
    elif record is not None and record.registration is not None:
        scale = transform.scale_factor(record.registration.matrix)
        start = replace(start, kept_scale=scale, scale_error=record.registration.scale_error)
    return _register(loaded_model, options, crs, start, findings, progress)


def register_model_of_project(
    loaded_model: LoadedModel,
    record: Model,
    options: Observations,
    progress: Progress,
    pairs: Pairs | None = None,
) -> RegistrationResult:
    """Register a model of a project, starting with its present placement.

    Parameters
    ----------
    loaded_model : LoadedModel
    record : Model
        The model before the registration.
    options : Observations
    progress : Progress
    pairs : Pairs, optional
        Points on the model and their coordinates, in addition to the observations of `options`.

    Raises
    ------
    UsageError, InputError, GeometryError
    """
    registration = record.registration
    start = _Start(
        record,
        up=up_direction(record),
        to_world=transform.matrix(record.to_world),
        kept_scale=transform.scale_factor(transform.matrix(record.to_world)),
        scale_error=None if registration is None else registration.scale_error,
        is_in_project=True,
    )
    return _register(loaded_model, options, _metric_crs(options), start, [], progress, pairs)


@dataclass(frozen=True, eq=False)
class _Start:
    """Placement of a model before its registration.

    Attributes
    ----------
    record : Model or None
        The model, or None if only a placement is computed.
    up : (3,) float64 or None
        Up direction in the file frame, or None if unknown.
    to_world : (4, 4) float64
        Placement whose parameters are kept if the observations do not determine them.
    scale : float or None
        Fixed scale, or None to estimate it.
    kept_scale, scale_error : float or None
        Scale that `keep_scale` fixes, and its relative one-sigma error.
    is_in_project : bool
        Whether the model is part of a project.
    """

    record: Model | None
    up: FloatArray | None
    to_world: FloatArray
    scale: float | None = None
    kept_scale: float = 1.0
    scale_error: float | None = None
    is_in_project: bool = False

    def is_in_file_crs(self, crs: str | None) -> bool:
        """Return whether the model is placed by the coordinates in its file.

        The position of a registered model of a project differs from that in its file.
        """
        if not self.is_in_project or self.record is None:
            return True
        return self.record.registration is None and self.record.frame.crs == crs


def _register(
    loaded_model: LoadedModel | None,
    options: Observations,
    crs: str | None,
    start: _Start,
    findings: list[Finding],
    progress: Progress,
    pairs: Pairs | None = None,
) -> RegistrationResult:
    from vomstudio.registration.coordinate_checks import require_on_model
    from vomstudio.registration.evidence import attitude_residuals

    unused = list[Finding]()
    evidence, crs, read_north = _collect_evidence(
        options, crs, loaded_model, findings, unused, pairs
    )
    if start.scale is not None:
        evidence.scale = start.scale
    elif options.keep_scale:
        evidence.scale, evidence.scale_error = start.kept_scale, start.scale_error
    evidence.up, evidence.crs = start.up, crs
    evidence.photo_up = None if loaded_model is None else photo_up(loaded_model.path)
    if start.is_in_project and loaded_model is not None and evidence.pairs is not None:
        require_on_model(evidence.pairs.model, loaded_model.data.bounds)
    reference_fit = _fit_to_reference(options, evidence, loaded_model, crs, start, progress)
    if reference_fit is not None:
        crs = reference_fit.crs
        evidence.reference = reference_fit.fitted.observation
        findings += reference_fit.warnings
    try:
        placement = _solve(evidence, loaded_model, start)
    except GeometryError as failure:
        if failure.file is None and failure.field is None:
            failure.file = _pairs_file(options)
        if unused:
            raise _unused_marks_error(failure, unused, evidence) from failure
        raise
    registration = None
    if start.record is not None:
        registration = _registration(
            placement, evidence, start.record, crs, reference_fit, read_north, findings
        )
    if start.is_in_file_crs(crs):
        findings += _relocation_findings(placement, loaded_model, crs)
    warnings = [*findings, *placement.warnings]
    for name, error in _bars_as_checks(evidence, placement):
        warnings.append(Finding("scale.check-bar", name=name, error_m=error))
    result = replace(placement, warnings=tuple(warnings))
    misses = attitude_residuals(evidence, placement)
    return RegistrationResult(result, misses, loaded_model, crs, reference_fit, registration)


def _metric_crs(options: Observations) -> str | None:
    """Return the CRS of the observations, or None; in metres unless they are converted.

    Raises UsageError if the CRS is not in metres.
    """
    from vomstudio.io.gis.crs import metric_crs

    if options.crs is None or options.to_crs is not None:
        return options.crs
    return metric_crs(options.crs, "--crs")


def _model_record(
    loaded_model: LoadedModel, options: RegisterOptions, findings: list[Finding]
) -> Model:
    """Return the record of the model before the registration.

    Findings about the registration file beside the model are appended to `findings`.
    """
    from vomstudio.io.gate.frame_options import FrameOptions
    from vomstudio.io.models.frames import file_frame, stored_registration

    path = loaded_model.path
    stored_result = stored_registration(
        loaded_model, FrameOptions(up=options.up, unit=options.unit)
    )
    findings += stored_result.findings
    placement = stored_result.registration or file_frame(path, loaded_model.crs)
    return Model("", path.stem, str(path), loaded_model.kind, loaded_model.content_hash, placement)


def _registration(
    placement: ModelPlacement,
    evidence: Evidence,
    model: Model,
    crs: str | None,
    reference_fit: ReferenceFit | None,
    read_north: NorthReference | None,
    findings: list[Finding],
) -> Registration:
    """Return the registration record of a placement, as created by the window.

    Findings about the record are appended to `findings`.
    """
    from vomstudio.io.models.registration_file import registration_path
    from vomstudio.studio.placing.registering import (
        add_reference_error,
        create_registration,
        reference_findings,
    )

    if not placement.known.all and model.to_world != IDENTITY:
        # Undetermined parameters keep their values of the file frame, which is not the World
        # frame.
        if model.registration is not None:
            file = registration_path(model.path).name
            findings.append(Finding("registration.incomplete", file=file))
        model = replace(model, placement=UNDECLARED_FRAME)
    reference = "" if reference_fit is None else reference_fit.name
    record = create_registration(placement, evidence.pairs, model, crs, reference, read_north)
    if reference_fit is None or reference_fit.reference is None:
        return record
    record = add_reference_error(
        record, reference_fit.reference, scale_fitted=reference_fit.scale_fitted
    )
    findings += reference_findings(record)
    return record


def _unused_marks_error(
    failure: GeometryError, unused_findings: Sequence[Finding], evidence: Evidence
) -> GeometryError:
    """Return the error of a registration that failed because of unused marks."""
    finding = cause_finding(failure)
    if evidence.has_too_few_points:
        finding = Finding("registration.few-marked-points")
    marks = " ".join(map(str, unused_findings))
    return GeometryError(
        Finding("registration.marks-unused", marks=marks, reason=finding, reason_code=finding.code),
        file=failure.file,
        field=failure.field,
    )


def _pairs_file(options: Observations) -> str | None:
    """Return the table of points to which errors of the registration refer, or None."""
    return options.pairs or options.gcp


def _bars_as_checks(evidence: Evidence, placement: ModelPlacement) -> list[tuple[str, float]]:
    """Return the names of check scale bars, and the errors of their lengths in metres."""
    pairs = evidence.pairs
    if pairs is None:
        return []
    positions = dict(zip(pairs.labels, pairs.model, strict=True))
    return [
        (
            f"{bar.first} - {bar.second}",
            float(placement.scale * np.linalg.norm(positions[bar.second] - positions[bar.first]))
            - bar.length_m,
        )
        for bar in evidence.bars
        if bar.check
    ]


def _fit_to_reference(
    options: Observations,
    evidence: Evidence,
    loaded_model: LoadedModel | None,
    crs: str | None,
    start: _Start,
    progress: Progress,
) -> ReferenceFit | None:
    """Fit the model to the reference, starting with the placement by other observations.

    Returns None if the options contain no reference. Raises UsageError if there is no model.
    """
    if options.reference is None:
        return None
    from vomstudio.studio.placing.reference_fitting import InitialPlacement, fit_model

    if loaded_model is None:
        raise UsageError(Finding("option.needs-model", option="--reference"), field="MODEL")
    # One or two points support the fit, but give no initial placement.
    is_determined = not (evidence.is_empty or evidence.has_too_few_points)
    previous_placement = _solve(evidence, loaded_model, start) if is_determined else None
    initial = None
    if start.is_in_project and start.record is not None:
        frame = start.record.frame
        initial = InitialPlacement(
            start.record.to_world, frame.crs, frame.has_metres, start.scale_error
        )
    return fit_model(
        loaded_model,
        options.reference,
        previous_placement=previous_placement,
        crs=crs,
        stable_text=options.stable,
        initial=initial,
        progress=progress,
    )


def _solve(evidence: Evidence, loaded_model: LoadedModel | None, start: _Start) -> ModelPlacement:
    """Solve for the placement. Undetermined parameters keep their initial values."""
    from vomstudio.registration.evidence import register

    extent = None if loaded_model is None else _model_bounds(loaded_model)
    # Cameras and a reference determine the orientation, and are in the file frame.
    is_in_file_frame = evidence.views or evidence.centres or evidence.reference is not None
    if is_in_file_frame or np.array_equal(start.to_world, np.eye(4)):
        return register(evidence, extent)
    if start.is_in_project and (placement := register(evidence, extent)).known.all:
        # A determined placement does not depend on the start.
        return placement
    return solve_placement(evidence, extent, start.to_world)


def _model_bounds(loaded_model: LoadedModel) -> FloatArray:
    from vomstudio.registration.surface_points import sample_points

    return sample_points(loaded_model.data)


def _known_up_direction(loaded_model: LoadedModel, options: RegisterOptions) -> FloatArray | None:
    """Return the up direction (3,) defined by the options or the file of a model, or None.

    Raises UsageError if `--up` is given for a format that defines it.
    """
    from vomstudio.io.models.frames import file_frame

    if options.up is not None and loaded_model.turned_about is not None:
        raise UsageError(Finding("frame.up-by-format"), field="--up")
    if options.up is not None:
        return np.array([0.0, 1.0, 0.0] if options.up == "y" else [0.0, 0.0, 1.0])
    is_surveyed = loaded_model.path.suffix.casefold() in SURVEY_FORMATS
    has_up = is_surveyed or file_frame(loaded_model.path, loaded_model.crs).has_up
    return np.array([0.0, 0.0, 1.0]) if has_up else None


def _relocation_findings(
    placement: ModelPlacement, loaded_model: LoadedModel | None, crs: str | None
) -> list[Finding]:
    """Return a finding if a model is moved far from the coordinates in its file."""
    from vomstudio.registration.coordinate_checks import relocation_findings

    if loaded_model is None or loaded_model.crs is None or not placement.known.position:
        return []
    if crs is not None and crs != loaded_model.crs:
        return []
    extent = _model_bounds(loaded_model)
    return relocation_findings(extent, placement(extent), loaded_model.crs)


def _collect_evidence(
    options: Observations,
    crs: str | None,
    loaded_model: LoadedModel | None,
    findings: list[Finding],
    unused_findings: list[Finding],
    pairs: Pairs | None,
) -> tuple[Evidence, str | None, NorthReference | None]:
    """Return the observations, the World CRS and the north reference of azimuths.

    The CRS is None if unknown, and the north reference if there are no azimuths. Messages are
    appended to `findings`; those about unused points and marks also to `unused_findings`. Raises
    UsageError, InputError, GeometryError.
    """
    from vomstudio.io.control import observation_tables as tables
    from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
    from vomstudio.io.gis.crs import metric_crs
    from vomstudio.registration.camera_positions import positions_in_metres
    from vomstudio.registration.coordinate_checks import check_area
    from vomstudio.registration.north import convert_to_grid_north, default_north_sigma_deg
    from vomstudio.registration.surface_points import known_resolution
    from vomstudio.studio.placing.marked_points import marked_pairs

    evidence = Evidence(without=tuple(options.without), robust=options.robust)
    evidence.pairs = pairs
    evidence.click_sigma_m = options.click_sigma_m
    if loaded_model is not None:
        evidence.resolution = known_resolution(loaded_model.data)
    if options.north_sigma_deg is not None:
        evidence.north_sigma_deg = evidence.compass_sigma_deg = options.north_sigma_deg
        evidence.is_compass_sigma_stated = True
    else:
        evidence.compass_sigma_deg = default_north_sigma_deg(options.north)
    photo_sources = (options.cameras, options.attitudes, options.horizon, options.gcp)
    if any(item is not None for item in photo_sources):
        cameras = _own_cameras(options, loaded_model)
        evidence.views, evidence.centres = cameras.views, cameras.centres
        findings += cameras.warnings
    target = None if options.to_crs is None else metric_crs(options.to_crs, "--to-crs")
    if options.pairs is not None:
        frame = FrameOptions(crs=options.crs, to_crs=target) if target else DEFAULT_FRAME
        evidence.pairs = tables.read_pairs(options.pairs, None if target else crs, frame)
        crs = crs or evidence.pairs.crs
    if options.gcp is not None:
        marks, gcp = None if options.marks is None else Path(options.marks), Path(options.gcp)
        evidence.pairs, crs = marked_pairs(
            gcp, marks, evidence, crs, unused_findings, to_crs=target
        )
        findings += unused_findings
    crs = target or crs
    if options.scale_bars is not None:
        evidence.bars = tables.read_scale_bars(options.scale_bars)
    if options.horizon is not None:
        evidence.level = tables.read_level_lines(options.horizon)
    if options.orientations is not None:
        evidence.compass = tables.read_compass(options.orientations, options.azimuth)
    position = None
    if evidence.pairs is not None:
        findings += check_area(evidence.pairs.world, crs)
    if options.cameras is not None:
        positions = _positions(options.cameras, cameras)
        evidence.positions, crs, position = positions_in_metres(positions, crs, findings)
        findings += check_area(
            evidence.positions.coordinates, crs, is_converted=position is not None
        )
    north = _north(options, evidence, crs, position)
    if options.attitudes is not None:
        table = _attitudes(options.attitudes, options.north, cameras)
        findings += table.notes
        if table.photos:
            evidence.attitudes = convert_to_grid_north(table, north, findings)
    evidence.lengths = [_segment(text, "--scale") for text in options.scale]
    evidence.level_lines = [_known_direction(text, "--level") for text in options.level]
    evidence.plumb_lines = [_known_direction(text, "--plumb") for text in options.plumb]
    evidence.azimuths = [_segment(text, "--bearing") for text in options.bearing]
    for line in evidence.azimuths:
        if not -360.0 <= line.value <= 360.0:
            raise UsageError(
                Finding("option.out-of-range", value=line.value, minimum=-360, maximum=360),
                field="--bearing",
            )
    read_north = _rotate_to_grid_north(options, evidence, north, findings)
    for line in evidence.lengths:
        if not line.value > 0:
            raise UsageError(Finding("number.not-positive", value=line.value), field="--scale")
    if evidence.is_empty and options.reference is None:
        for finding in findings:
            if isinstance(finding, Finding) and finding.code == "photo.angles-not-measured":
                raise UsageError(finding, field="--attitudes")
        raise UsageError(Finding("registration.no-observations"))
    return evidence, crs, read_north


def _own_cameras(options: Observations, loaded_model: LoadedModel | None) -> ModelCameras:
    """Read the cameras in the frame of the model. Raises UsageError, InputError."""
    from vomstudio.io.photos.cameras_file import FILE_NAME
    from vomstudio.io.photos.own_cameras.reading import find_camera_file, read_camera_file

    if options.model_cameras is not None:
        path = Path(options.model_cameras)
    else:
        if loaded_model is None:
            raise UsageError(
                Finding("option.needs-cameras"),
                field="MODEL",
            )
        path = find_camera_file(loaded_model.path) or loaded_model.path.with_name(FILE_NAME)
    return read_camera_file(path, None if loaded_model is None else loaded_model.data.bounds)


def _positions(source: str | Path, cameras: ModelCameras) -> Positions:
    """Read the positions of photos from a table or from the photos."""
    from vomstudio.io.control.observation_tables import read_positions
    from vomstudio.registration.photo_evidence import read_photo_positions

    if source == BESIDE or Path(source).is_dir():
        return read_photo_positions(_find_photos(source, cameras, "--cameras"))
    return read_positions(source)


def _attitudes(source: str | Path, north: str, cameras: ModelCameras) -> AttitudeTable:
    """Read the attitudes of photos from a table or from the photos."""
    from vomstudio.io.control.attitude_tables import read_attitudes
    from vomstudio.registration.photo_evidence import read_photo_attitudes

    if source == BESIDE or Path(source).is_dir():
        return read_photo_attitudes(_find_photos(source, cameras, "--attitudes"), cameras.views)
    return read_attitudes(source, north)


def _north(
    options: Observations,
    evidence: Evidence,
    crs: str | None,
    position: tuple[float, float] | None,
) -> NorthInputs:
    """Return the CRS, location, date and declination for the correction to grid north."""
    from vomstudio.registration.north import NorthInputs, centre_longitude_latitude, parse_day

    positions = [] if evidence.pairs is None else [evidence.pairs.world]
    positions += [] if evidence.positions is None else [evidence.positions.coordinates]
    if position is None and crs is not None and positions:
        position = centre_longitude_latitude(crs, np.concatenate(positions))
    day = None if options.date is None else parse_day(options.date)
    return NorthInputs(crs, position, day, options.declination_deg)


def _rotate_to_grid_north(
    options: Observations, evidence: Evidence, north: NorthInputs, findings: list[Finding]
) -> NorthReference | None:
    """Convert azimuths and compass readings to grid north.

    Returns their north reference, or None if the observations contain no azimuths.
    """
    if not (evidence.azimuths or evidence.compass):
        return None
    correction = north.require_correction(options.north, "--north")
    if correction.finding is not None:
        findings.append(correction.finding)
        evidence.azimuths = [
            line._replace(value=(line.value + correction.deg) % 360.0) for line in evidence.azimuths
        ]
        evidence.compass_turn_deg = correction.deg
    return correction.read_north(evidence.compass_sigma_deg)


def _find_photos(source: str | Path, cameras: ModelCameras, option: str) -> dict[str, Path]:
    """Find the photos of the cameras, in the given folder or beside the model.

    Raises UsageError if no photo is found.
    """
    from vomstudio.io.photos.own_cameras.photos import find_camera_photos

    photos = find_camera_photos(cameras, None if source == BESIDE else Path(source))
    if not photos:
        raise UsageError(
            Finding("photo.none-of-cameras", name=next(iter(cameras.centres))),
            field=option,
        )
    return photos


def _segment(text: str, option: str) -> Segment:
    from vomstudio.registration.compass_evidence import Segment

    cells = _numbers(text)
    if len(cells) not in (7, 8):
        raise UsageError(
            Finding("line.not-seven-numbers", text=text[:60]),
            field=option,
        )
    x1, y1, z1, x2, y2, z2, value, *sigma = cells
    if sigma and not sigma[0] > 0:
        raise UsageError(Finding("number.not-positive", value=sigma[0]), field=option)
    _require_error(sigma, option)
    return Segment((x1, y1, z1), (x2, y2, z2), value, sigma[0] if sigma else None)


def _require_error(sigma: Sequence[float], option: str) -> None:
    """Raise UsageError for an implausible error; `sigma` has at most one value."""
    for value in sigma:
        if (problem := check_error(value)) is not None:
            raise UsageError(problem, field=option)


def _numbers(text: str) -> list[float]:
    """Parse comma-separated finite numbers; return an empty list for any other text."""
    try:
        cells = [float(cell) for cell in text.split(",")]
    except ValueError:
        return []
    return cells if all(map(math.isfinite, cells)) else []


def _known_direction(text: str, option: str) -> KnownDirection:
    cells = _numbers(text)
    if len(cells) not in (6, 7):
        raise UsageError(
            Finding("line.not-six-numbers", text=text[:60]),
            field=option,
        )
    x1, y1, z1, x2, y2, z2, *sigma = cells
    if sigma and not sigma[0] > 0.0:
        raise UsageError(Finding("number.not-positive", value=sigma[0]), field=option)
    if sigma and sigma[0] > 45.0:
        raise UsageError(
            Finding("option.out-of-range", value=sigma[0], minimum=0, maximum=45), field=option
        )
    _require_error(sigma, option)
    return KnownDirection((x1, y1, z1), (x2, y2, z2), sigma[0] if sigma else None)
