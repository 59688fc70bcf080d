"""Observations for the registration of a model, from tables and photos."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.bowing import Bowing
from vomstudio.geometry import transform
from vomstudio.geometry.cameras import View
from vomstudio.geometry.coordinate_limits import check_coordinates
from vomstudio.geometry.triangulation import triangulate
from vomstudio.io.control.attitude_tables import AttitudeTable
from vomstudio.io.control.observation_tables import (
    CompassTable,
    LevelTable,
    Pairs,
    Positions,
    ScaleBar,
)
from vomstudio.registration.attitude_evidence import (
    NORTH_SIGMA_DEG,
    AttitudeEvidence,
    AttitudeResidual,
    bowing_from_tilts,
    compare_attitudes,
    match_attitudes,
)
from vomstudio.registration.blunders import exclude_labels
from vomstudio.registration.camera_positions import select_consistent_cameras
from vomstudio.registration.compass_evidence import (
    Segment,
    azimuth_lines,
    compass_directions,
    compass_findings,
    has_only_compass_evidence,
)
from vomstudio.registration.coordinate_checks import (
    point_findings,
    position_noise_findings,
    require_on_model,
    scale_unit_findings,
    view_direction_findings,
)
from vomstudio.registration.length_evidence import fixed_scale, length_findings, length_observations
from vomstudio.registration.level_evidence import (
    KnownDirection,
    level_line_findings,
    level_line_observations,
    photo_upright_prior,
    plumb_line_observations,
    vertical_findings,
)
from vomstudio.registration.marks.mark_checks import create_photo_finder
from vomstudio.registration.marks.mark_errors import (
    Marks,
    disagreeing_marks_finding,
    mark_error_px,
    mark_scatter_findings,
    max_mark_distance_px,
    position_covariance,
)
from vomstudio.registration.marks.wrong_marks import do_rays_intersect, find_consistent_marks
from vomstudio.registration.observations import (
    Lengths,
    LevelLines,
    ObservationKind,
    Points,
)
from vomstudio.registration.placing import place, place_robustly, prepend_warnings
from vomstudio.registration.results import ModelPlacement, PointResidual
from vomstudio.registration.similarity import Similarity
from vomstudio.registration.similarity_observation import SimilarityObservation
from vomstudio.registration.warnings import bowing_findings

PhotoMark = tuple[str, str, float, float]
# Maximum rotation error; covers 93 % of simulated placements by cameras along a line.
_MAX_TURN_ERROR_DEG = 40.0


@dataclass
class Evidence:
    """All observations of the position of a model.

    Attributes
    ----------
    views : mapping
        Cameras of the model, in the frame of the model.
    centres : mapping
        Positions of the cameras, including cameras for which only the position is known.
    """

    views: Mapping[str, View] = field(default_factory=dict)
    centres: Mapping[str, FloatArray] = field(default_factory=dict)
    pairs: Pairs | None = None
    click_sigma_m: float | None = None
    """Error of each coordinate of a click on the model, metres. If None, it is derived from
    `resolution`."""
    resolution: float | None = None
    """Effective resolution of the model in its unit, or None if unknown."""
    mark_scatter_px: float | None = None
    """Error of a mark in one direction, or None if there are no marks."""
    bars: Sequence[ScaleBar] = ()
    positions: Positions | None = None
    """Measured camera positions, metres."""
    attitudes: AttitudeTable | None = None
    """Measured camera attitudes; yaws are relative to grid north."""
    north_sigma_deg: float = NORTH_SIGMA_DEG
    """One-sigma compass error common to all photos."""
    level: LevelTable | None = None
    """Level lines in photos."""
    level_lines: Sequence[KnownDirection] = ()
    """Level lines on the model."""
    plumb_lines: Sequence[KnownDirection] = ()
    """Plumb lines on the model."""
    photo_up: FloatArray | None = None
    """Up direction (3,) derived from the photos, in the frame of the model; None if unknown."""
    compass: CompassTable | None = None
    compass_turn_deg: float = 0.0
    """Correction that is added to all azimuths of `compass`."""
    compass_sigma_deg: float = 0.0
    """One-sigma error common to all azimuths of `compass` and `azimuths`."""
    is_compass_sigma_stated: bool = False
    """Whether `compass_sigma_deg` was stated by the user; otherwise it is a default."""
    lengths: Sequence[Segment] = ()
    """Pairs of end points on the model, and the distance between them in metres."""
    azimuths: Sequence[Segment] = ()
    """Lines between two points on the model, and their azimuths in degrees."""
    marks: Sequence[PhotoMark] = ()
    """Marks of control points in photos: label, photo, x, y."""
    reference: SimilarityObservation | None = None
    """Result of fitting the model to a reference model."""
    without: Sequence[str] = ()
    """Labels of excluded observations."""
    scale: float | None = None
    """Metres per unit of the model, if the scale is fixed."""
    scale_error: float | None = None
    """Relative one-sigma error of the fixed scale, or None if unknown."""
    robust: bool = False
    """Whether to exclude outliers."""
    crs: str | None = None
    """CRS of the World frame, if known."""
    up: FloatArray | None = None
    """Up direction (3,) in the frame of the model, if known."""

    @property
    def is_empty(self) -> bool:
        """Whether no observations are given."""
        observations = (self.pairs, self.positions, self.attitudes, self.level, self.compass)
        return all(observation is None for observation in (*observations, self.reference)) and not (
            self.lengths or self.azimuths or self.level_lines or self.plumb_lines
        )

    @property
    def has_too_few_points(self) -> bool:
        """Whether there are only points, and too few of them to place a model."""
        other_evidence = (self.positions, self.attitudes, self.level, self.compass)
        if self.pairs is None or any(item is not None for item in other_evidence):
            return False
        if self.bars or self.lengths or self.azimuths or self.level_lines or self.plumb_lines:
            return False
        return int((~self.pairs.check).sum()) < 3


def register(evidence: Evidence, extent: FloatArray | None = None) -> ModelPlacement:
    """Register a model by all observations.

    Parameters
    ----------
    evidence : Evidence
    extent : (n, 3) array, optional
        Points distributed over the model.

    Raises
    ------
    UsageError
        If an observation refers to a missing point or camera.
    InputError
        If a value is invalid, such as a camera position or a line outside its photo.
    GeometryError
        If the observations do not determine the position of the model.
    """
    findings: list[Finding] = []
    suspicious_findings: list[Finding] = []
    kinds: list[ObservationKind] = []
    check = None
    if evidence.pairs is not None:
        control, check = _pairs(evidence)
        findings += evidence.pairs.notes
        require_on_model(evidence.pairs.model, extent)
        kinds.append(control)
        all_pairs = evidence.pairs
        suspicious_findings += point_findings(
            control, all_pairs.labels, all_pairs.world, all_pairs.model, evidence.crs
        )
        findings += suspicious_findings
    click_error_m, click_error = _click_errors(evidence)
    kinds += length_observations(
        evidence.bars,
        evidence.lengths,
        evidence.pairs,
        click_error_m=click_error_m,
        click_error=click_error,
    )
    if evidence.positions is not None:
        kinds.append(_cameras(evidence, findings, suspicious_findings))
    attitudes = None
    if evidence.attitudes is not None:
        attitudes = _attitudes(evidence, evidence.attitudes, findings)
        kinds += attitudes.kinds
    if evidence.level is not None:
        kinds.append(_level(evidence, evidence.level, extent, findings))
    if evidence.level_lines:
        kinds.append(level_line_observations(evidence.level_lines))
    if evidence.plumb_lines:
        kinds.append(plumb_line_observations(evidence.plumb_lines))
    if evidence.photo_up is not None and (evidence.level_lines or evidence.plumb_lines):
        kinds.append(photo_upright_prior(evidence.photo_up))
    compass_sigma_deg = evidence.compass_sigma_deg
    if evidence.compass is not None:
        kinds += compass_directions(evidence.compass, evidence.compass_turn_deg, compass_sigma_deg)
    if evidence.azimuths:
        kinds.append(azimuth_lines(evidence.azimuths, compass_sigma_deg))
    if evidence.reference is not None:
        kinds.append(evidence.reference)
    if evidence.without:
        kinds, check = exclude_labels(kinds, check, evidence.without)
        findings.append(Finding("registration.without", labels=list(evidence.without)))
    if evidence.compass is not None:
        findings += compass_findings(evidence.compass, kinds)
    if evidence.scale is not None:
        kinds += fixed_scale(evidence.scale, kinds, extent, evidence.scale_error)
    try:
        placement = (place_robustly if evidence.robust else place)(
            kinds, check, extent, up=evidence.up, is_doubted=bool(suspicious_findings)
        )
    except GeometryError as error:
        # Report the suspicious values: they are the cause of the degenerate geometry.
        if suspicious_findings:
            raise GeometryError(suspicious_findings[0]) from error
        error.message = " ".join([*map(str, findings), error.message])
        raise
    findings += vertical_findings(kinds, np.array(placement.matrix)[:3, :3] / placement.scale)
    if evidence.compass is not None or evidence.azimuths:
        placement = replace(placement, north_sigma_deg=compass_sigma_deg)
        if has_only_compass_evidence(kinds) and not evidence.is_compass_sigma_stated:
            findings.append(
                Finding("registration.compass-alone", north_sigma_deg=compass_sigma_deg)
            )
    findings += scale_unit_findings(placement.scale, placement.scale_error_95)
    excluded_labels = {*evidence.without, *(blunder.label for blunder in placement.blunders)}
    findings += length_findings(evidence.bars, evidence.lengths, evidence.pairs, excluded_labels)
    findings += _camera_findings(evidence, kinds, placement)
    if evidence.positions is not None and _is_only_kind(kinds):
        _refuse_uncertain_rotation(placement, suspicious_findings)
    if attitudes is not None:
        findings += bowing_findings(
            _bowing_from_tilts(evidence, placement, extent), is_photo_model=True
        )
    placement = _add_control_errors(_add_pixel_residuals(placement, evidence), evidence)
    return prepend_warnings(placement, findings)


def _add_pixel_residuals(placement: ModelPlacement, evidence: Evidence) -> ModelPlacement:
    """Add the RMS residual of each control point in the photos, in pixels."""
    if not evidence.marks or evidence.pairs is None:
        return placement
    positions = transform.apply(transform.invert(placement.matrix), evidence.pairs.world)
    position_by_label = dict(zip(evidence.pairs.labels, positions, strict=True))
    squares: dict[str, list[float]] = {}
    for label, photo, x, y in evidence.marks:
        view = _view(evidence, photo, "--marks")
        if view is not None and label in position_by_label:
            misclosure = view.project(position_by_label[label])[0] - [x, y]
            squares.setdefault(label, []).append(float(misclosure @ misclosure))

    def add_rms(points: Sequence[PointResidual]) -> tuple[PointResidual, ...]:
        return tuple(
            replace(point, pixels=float(np.sqrt(np.mean(squares[point.label]))))
            if point.label in squares and np.isfinite(squares[point.label]).all()
            else point
            for point in points
        )

    return replace(placement, control=add_rms(placement.control), check=add_rms(placement.check))


# --- points -----------------------------------------------------------------------
def _pairs(evidence: Evidence) -> tuple[Points, Points]:
    pairs = evidence.pairs
    assert pairs is not None
    is_clicked = pairs.is_clicked
    click_error_m, click_error = _click_errors(evidence)
    sigma_m = np.where(is_clicked, click_error_m, 0.0)
    covariance = np.tile(click_error**2 * np.eye(3), (len(is_clicked), 1, 1))
    if pairs.covariance is not None:
        covariance[~is_clicked] = pairs.covariance[~is_clicked]

    def points_of(mask: BoolArray) -> Points:
        rows = np.flatnonzero(mask)
        labels = [pairs.labels[i] for i in rows]
        return Points(
            labels,
            pairs.model[rows],
            pairs.world[rows],
            pairs.sigma[rows],
            click_error_m=sigma_m[rows] if sigma_m.any() else None,
            covariance=covariance[rows] if covariance.any() else None,
        )

    return points_of(~pairs.check), points_of(pairs.check)


def _click_errors(evidence: Evidence) -> tuple[float, float]:
    """Return the errors of a click in metres and in the unit of the model.

    The first is the given error. If no error is given, the second follows from the resolution. The
    other one is 0.
    """
    if evidence.click_sigma_m is not None:
        return evidence.click_sigma_m, 0.0
    return 0.0, 0.5 * (evidence.resolution or 0.0)


def _add_control_errors(placement: ModelPlacement, evidence: Evidence) -> ModelPlacement:
    """Add the errors of clicks and marks that were used, and findings about them."""
    placement = replace(placement, mark_scatter_px=evidence.mark_scatter_px)
    findings = mark_scatter_findings(evidence.mark_scatter_px or 0.0)
    pairs = evidence.pairs
    if pairs is not None and pairs.is_clicked.any():
        click_error_m = evidence.click_sigma_m
        if click_error_m is None:
            click_error_m = 0.5 * placement.scale * (evidence.resolution or 0.0)
            is_stated = np.isfinite(pairs.sigma[pairs.is_clicked]).all()
            if evidence.resolution is None and is_stated:
                findings.append(Finding("control.click-error-unknown"))
        placement = replace(placement, click_sigma_m=click_error_m)
    return prepend_warnings(placement, findings)


# --- cameras ----------------------------------------------------------------------------------
def _create_camera_finder(
    evidence: Evidence, known_cameras: Mapping[str, Any], field_: str
) -> Callable[[str], str | None]:
    """Return a function that finds the camera of a photo by its name, or returns None.

    Raises UsageError if no cameras are known.
    """
    if not known_cameras:
        raise UsageError(
            Finding("cameras.no-poses") if evidence.centres else Finding("cameras.missing"),
            field=field_,
        )
    return create_photo_finder(list(known_cameras))


def _view(evidence: Evidence, photo: str, field_: str) -> View | None:
    """Return the view of a photo by its name, with or without folder and suffix.

    Returns None if the photo has no view. Raises UsageError if no cameras are known.
    """
    name = _create_camera_finder(evidence, evidence.views, field_)(photo)
    return None if name is None else evidence.views[name]


def _match_photos(
    evidence: Evidence,
    known_cameras: Mapping[str, Any],
    photos: Sequence[str],
    field_: str,
    findings: list[Finding],
) -> tuple[list[int], list[str]]:
    """Return the rows of photos that match cameras of the model, and the camera names.

    Raises UsageError if no photo matches.
    """
    rows, names = [], []
    unknown_photos = []
    find = _create_camera_finder(evidence, known_cameras, field_)
    for row, photo in enumerate(photos):
        name = find(photo)
        if name is None:
            unknown_photos.append(photo)
        else:
            rows.append(row)
            names.append(name)
    if not rows:
        raise UsageError(
            Finding(
                "cameras.none-known",
                photos=len(photos),
                first=photos[0],
                known=next(iter(known_cameras)),
            ),
            field=field_,
        )
    if unknown_photos:
        findings.append(
            Finding("cameras.unknown-photos", count=len(unknown_photos), photos=unknown_photos)
        )
    return rows, names


def _cameras(
    evidence: Evidence, findings: list[Finding], suspicious_findings: list[Finding]
) -> Points:
    """Return the camera positions that are consistent with the model.

    Findings are appended to `findings`, and those about suspicious positions to
    `suspicious_findings`.
    """
    positions = evidence.positions
    assert positions is not None
    findings += positions.notes
    centres = {name: view.centre for name, view in evidence.views.items()} | dict(evidence.centres)
    rows, names = _match_photos(evidence, centres, positions.photos, "--cameras", findings)
    world = positions.coordinates[rows].copy()
    for row, position in enumerate(world.tolist()):
        if (problem := check_coordinates((position[0], position[1], position[2]))) is not None:
            raise InputError(problem, field=positions.photos[rows[row]])
    labels = [positions.photos[row] for row in rows]
    model = np.array([centres[name] for name in names])
    sigma = positions.sigma[rows]
    has_only_cameras = (
        evidence.pairs is None and evidence.attitudes is None and evidence.compass is None
    )
    cameras, camera_findings, exclusions = select_consistent_cameras(
        labels, model, world, sigma, is_alone=has_only_cameras, crs=evidence.crs
    )
    suspicious_findings += camera_findings
    findings += [*camera_findings, *exclusions]
    return cameras


def _camera_findings(
    evidence: Evidence, kinds: Sequence[ObservationKind], placement: ModelPlacement
) -> list[Finding]:
    """Return findings about view directions and position residuals after registration."""
    findings: list[Finding] = []
    if placement.known.vertical and evidence.views:
        rotation = np.array(placement.matrix)[:3, :3] / placement.scale
        forward = np.array([view.rotation[2] for view in evidence.views.values()]) @ rotation.T
        findings += view_direction_findings(forward)
    for kind in kinds:
        if isinstance(kind, Points) and kind.name == "cameras" and _is_only_kind(kinds):
            findings += position_noise_findings(kind.world, placement(kind.model))
    return findings


def _is_only_kind(kinds: Sequence[ObservationKind]) -> bool:
    """Return whether a single kind of observation (lengths aside) determines the placement."""
    return sum(not isinstance(kind, Lengths) for kind in kinds) == 1


def _refuse_uncertain_rotation(
    placement: ModelPlacement, suspicious_findings: Sequence[Finding]
) -> None:
    worst_error_deg = placement.rotation_error_95_deg.weakest.error_deg
    if worst_error_deg is None or worst_error_deg > _MAX_TURN_ERROR_DEG:
        reason = Finding("cameras.unsure", limit_deg=_MAX_TURN_ERROR_DEG)
        raise GeometryError(suspicious_findings[0] if suspicious_findings else reason)


def triangulate_marks(
    evidence: Evidence, marks: Sequence[PhotoMark], findings: list[Finding] | None = None
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Triangulate the points that are marked in at least two photos.

    The scatter of the marks is stored in `evidence`.

    Parameters
    ----------
    evidence : Evidence
    marks : sequence of (label, photo, x, y)
    findings : list of Finding, optional
        List to which findings about excluded marks and points are appended.

    Returns
    -------
    dict of str to (3,) array and (3, 3) array
        Points on the model and their covariances, by label.

    Raises
    ------
    UsageError
        If no cameras are known.
    GeometryError
        If the marks scatter too much to show the same points.
    """
    collected_findings = [] if findings is None else findings
    views_by_label: dict[str, tuple[list[View], list[tuple[float, float]]]] = {}
    mark_counts: Counter[str] = Counter()
    for label, photo, x, y in marks:
        view = _view(evidence, photo, "--marks")
        if view is None:
            continue
        mark_counts[label] += 1
        lens = view.intrinsics
        if not (0 <= x <= lens.width and 0 <= y <= lens.height):
            collected_findings.append(
                Finding(
                    "control.mark-outside",
                    label=label,
                    x=x,
                    y=y,
                    photo=photo,
                    width=lens.width,
                    height=lens.height,
                )
            )
            continue
        views, pixels = views_by_label.setdefault(label, ([], []))
        views.append(view)
        pixels.append((x, y))
    points = {
        label: Marks(views, np.array(pixels, np.float64))
        for label, (views, pixels) in views_by_label.items()
    }
    mark_px = mark_error_px(list(points.values()))
    evidence.mark_scatter_px = mark_px if points else None
    triangulated_points, contradictory_labels = {}, []
    for label, point in points.items():
        rows, wrong_marks = find_consistent_marks(label, point, max_mark_distance_px(mark_px))
        collected_findings += [mark.finding for mark in wrong_marks]
        consistent_marks = point.select(rows)
        if len(rows) < 2:
            continue
        if not do_rays_intersect(consistent_marks, max_mark_distance_px(mark_px)):
            contradictory_labels.append(label)
            continue
        place = triangulate(*consistent_marks)
        triangulated_points[label] = place, position_covariance(consistent_marks, place, mark_px)
    if contradictory_labels:
        collected_findings.append(disagreeing_marks_finding(contradictory_labels))
    # Points that are marked only once are reported when the labels are compared.
    labels_with_few_marks = [
        label
        for label in mark_counts
        if mark_counts[label] > 1
        and label not in triangulated_points
        and label not in contradictory_labels
    ]
    if labels_with_few_marks:
        collected_findings.append(Finding("control.few-marks", labels=labels_with_few_marks))
    return triangulated_points


def _attitudes(
    evidence: Evidence, table: AttitudeTable, findings: list[Finding]
) -> AttitudeEvidence:
    rows, names = _match_photos(evidence, evidence.views, table.photos, "--attitudes", findings)
    views = [evidence.views[name] for name in names]
    return match_attitudes(table, rows, views, evidence.north_sigma_deg, findings)


def _bowing_from_tilts(
    evidence: Evidence, placement: ModelPlacement, extent: FloatArray | None
) -> Bowing | None:
    table = evidence.attitudes
    if table is None or not placement.known.scale:
        return None
    rows, names = _match_photos(evidence, evidence.views, table.photos, "--attitudes", [])
    matrix = np.array(placement.matrix)
    fit = Similarity(placement.scale, matrix[:3, :3] / placement.scale, matrix[:3, 3])
    return bowing_from_tilts(table, rows, [evidence.views[name] for name in names], fit, extent)


def attitude_residuals(evidence: Evidence, placement: ModelPlacement) -> list[AttitudeResidual]:
    """Compare each photo attitude with the attitude in the placed model.

    Parameters
    ----------
    evidence : Evidence
    placement : ModelPlacement

    Returns
    -------
    list of AttitudeResidual
    """
    table = evidence.attitudes
    if table is None:
        return []
    rows, names = _match_photos(evidence, evidence.views, table.photos, "--attitudes", [])
    rotation = np.array(placement.matrix)[:3, :3] / placement.scale
    return compare_attitudes(table, rows, [evidence.views[name] for name in names], rotation)


def _level(
    evidence: Evidence, table: LevelTable, extent: FloatArray | None, findings: list[Finding]
) -> LevelLines:
    rows, names = _match_photos(evidence, evidence.views, table.photos, "--horizon", [])
    views = [evidence.views[name] for name in names]
    findings += level_line_findings(
        [table.photos[row] for row in rows], views, table.ends[rows], extent
    )
    directions = []
    for row, view in zip(rows, views, strict=True):
        rays = view.intrinsics.rays(table.ends[row])
        directions.append((rays[1] - rays[0]) @ view.rotation)
    model = np.array(directions)
    model /= np.linalg.norm(model, axis=1, keepdims=True)
    return LevelLines([table.photos[row] for row in rows], model, np.full(len(model), np.nan))
