"""Known lines and planes on a model as observations for its placement."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry import transform
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.registrations import Registration
from vomstudio.io.control.observation_tables import CompassTable, Pairs
from vomstudio.io.gis.crs import world_crs
from vomstudio.io.photos.cameras_file import has_known_scale
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.records import Model
from vomstudio.registration.compass_evidence import Segment
from vomstudio.registration.evidence import Evidence, register
from vomstudio.registration.level_evidence import KnownDirection
from vomstudio.registration.results import DeterminedParameters, ModelPlacement
from vomstudio.registration.similarity import jacobian
from vomstudio.studio.placing.known_planes import ModelDirection, residual_deg


@dataclass(frozen=True)
class LineResidual:
    """Residual of a known line on a placed model.

    `deviation` is the placed minus the known value, in degrees, or in metres for a length. For a
    compass reading, it is the angle between the two directions.
    """

    id: str
    deviation: float


def placement_lines(lines: Sequence[KnownLine]) -> list[KnownLine]:
    """Return the complete lines, except compass readings and lines used only as checks."""
    return [line for line in lines if line.is_complete and not line.check and not line.is_read]


def build_evidence(
    pairs: Pairs,
    lines: Sequence[KnownLine],
    compass: CompassTable | None = None,
    turned_deg: float = 0.0,
) -> Evidence:
    """Build the observations in the file frame of the model.

    Parameters
    ----------
    pairs : Pairs
        Points on the model and their World coordinates.
    lines : sequence of KnownLine
    compass : CompassTable, optional
    turned_deg : float
        Correction that is added to all azimuths, degrees.
    """
    line_evidence = Evidence(pairs=pairs if len(pairs.labels) else None)
    line_evidence.compass, line_evidence.compass_turn_deg = compass, turned_deg
    ends = [(line, line.vertices[0], line.vertices[-1]) for line in placement_lines(lines)]
    line_evidence.level_lines, line_evidence.plumb_lines = (
        [
            KnownDirection(a, b, line.sigma, line.name)
            for line, a, b in ends
            if line.kind == line_kind
        ]
        for line_kind in ("level", "plumb")
    )
    line_evidence.azimuths, line_evidence.lengths = (
        [
            Segment(a, b, line.value + correction, line.sigma, line.name)
            for line, a, b in ends
            if line.kind == line_kind and line.value is not None
        ]
        for line_kind, correction in (("azimuth", turned_deg), ("length", 0.0))
    )
    return line_evidence


def place_by_known_lines(
    pairs: Pairs,
    lines: Sequence[KnownLine],
    model: Model,
    extent: FloatArray | None,
    north_doubt_deg: float = 0.0,
    compass: CompassTable | None = None,
    turned_deg: float = 0.0,
    *,
    is_north_sigma_stated: bool = False,
    photo_up: FloatArray | None = None,
    keep_scale: bool = False,
    click_sigma_m: float | None = None,
    resolution: float | None = None,
) -> ModelPlacement:
    """Compute the placement of a model from points, lines and planes on it.

    Undetermined parameters keep their values in the present placement, as does the scale if
    `keep_scale`.

    Parameters
    ----------
    pairs : Pairs
        Points on the model and their World coordinates.
    lines : sequence of KnownLine
    model : Model
    extent : (n, 3) float64 or None
        Sample of the model's points in the file frame.
    north_doubt_deg : float
        Standard deviation of the common error of all azimuths, degrees.
    compass : CompassTable, optional
    turned_deg : float
        Correction that is added to all azimuths, degrees.
    is_north_sigma_stated : bool
        Whether `north_doubt_deg` was stated and is not a default.
    photo_up : (3,) float64, optional
        See `Evidence`.
    keep_scale : bool, optional
        Whether the scale of the model is fixed.
    click_sigma_m : float, optional
        Standard deviation of a click on the model, metres; by default half the resolution.
    resolution : float, optional
        Resolution of the model in the unit of its file.

    Raises
    ------
    GeometryError, UsageError
    """
    evidence = build_evidence(pairs, lines, compass, turned_deg)
    evidence.compass_sigma_deg = north_doubt_deg
    evidence.is_compass_sigma_stated = is_north_sigma_stated
    evidence.photo_up = photo_up
    evidence.click_sigma_m, evidence.resolution = click_sigma_m, resolution
    evidence.up = up_direction(model)
    if keep_scale:
        evidence.scale = transform.scale_factor(transform.matrix(model.to_world))
        registration = model.registration
        evidence.scale_error = None if registration is None else registration.scale_error
    placement = register(evidence, extent)
    if placement.known.all:
        return placement
    # If only the file were used, a model that was rotated before would return to its original
    # orientation.
    return solve_placement(evidence, extent, transform.matrix(model.to_world))


def solve_placement(
    evidence: Evidence, extent: FloatArray | None, to_world: FloatArray
) -> ModelPlacement:
    """Compute a placement whose undetermined parameters are those of a previous placement.

    Parameters
    ----------
    evidence : Evidence
        Observations in the file frame, without photos.
    extent : (n, 3) float64 or None
        Sample of the model's points in the file frame.
    to_world : (4, 4) float64
        Previous placement, from the file frame to the World frame.

    Returns
    -------
    ModelPlacement

    Raises
    ------
    GeometryError
    """
    evidence = _transform_evidence(evidence, to_world)
    placement = register(evidence, None if extent is None else transform.apply(to_world, extent))
    scale = placement.scale * transform.scale_factor(to_world)
    return replace(placement, matrix=placement.matrix @ to_world, scale=scale)


def up_direction(model: Model) -> FloatArray | None:
    """Return the up direction (3,) in the file frame of a model, or None if unknown."""
    if not model.frame.has_up:
        return None
    to_world = transform.matrix(model.to_world)
    return np.asarray(to_world[2, :3] / transform.scale_factor(to_world), np.float64)


def photo_up(path: Path) -> FloatArray | None:
    """Return the mean up direction (3,) of the photos in the file frame of a photo model.

    Returns None if the model was made by another program or has been registered. The z axis of a
    photo model that is not registered is aligned with the mean up direction of the photos
    (`photogrammetry.georeferencing.local_frame`).
    """
    return np.array([0.0, 0.0, 1.0]) if has_known_scale(path) is False else None


def _transform_evidence(evidence: Evidence, change_matrix: FloatArray) -> Evidence:
    """Transform the observations on a model by a 4 x 4 similarity matrix."""

    def transform_point(place: Point) -> Point:
        x, y, z = transform.apply(change_matrix, [place])[0].tolist()
        return x, y, z

    pairs = evidence.pairs
    if pairs is not None:
        pairs = replace(pairs, model=transform.apply(change_matrix, pairs.model))
    compass = evidence.compass
    if compass is not None:
        rotation = change_matrix[:3, :3] / transform.scale_factor(change_matrix)
        compass = replace(compass, model=compass.model @ rotation.T)
    return replace(
        evidence,
        pairs=pairs,
        compass=compass,
        scale=None
        if evidence.scale is None
        else evidence.scale / transform.scale_factor(change_matrix),
        resolution=None
        if evidence.resolution is None
        else evidence.resolution * transform.scale_factor(change_matrix),
        up=None
        if evidence.up is None
        else change_matrix[:3, :3] @ evidence.up / transform.scale_factor(change_matrix),
        photo_up=None if evidence.photo_up is None else change_matrix[:3, :3] @ evidence.photo_up,
        level_lines=[_transform_direction(line, transform_point) for line in evidence.level_lines],
        plumb_lines=[_transform_direction(line, transform_point) for line in evidence.plumb_lines],
        azimuths=[_transform_segment(line, transform_point) for line in evidence.azimuths],
        lengths=[_transform_segment(line, transform_point) for line in evidence.lengths],
    )


def _transform_direction(
    line: KnownDirection, transform_point: Callable[[Point], Point]
) -> KnownDirection:
    return replace(line, first=transform_point(line.first), second=transform_point(line.second))


def _transform_segment(line: Segment, transform_point: Callable[[Point], Point]) -> Segment:
    return line._replace(first=transform_point(line.first), second=transform_point(line.second))


def line_residuals(
    lines: Sequence[KnownLine],
    placement: ModelPlacement,
    directions: Mapping[str, ModelDirection] = MappingProxyType({}),
    turned_deg: float = 0.0,
) -> list[LineResidual]:
    """Return the residuals of known lines and planes, including those used as checks.

    Parameters
    ----------
    lines : sequence of KnownLine
    placement : ModelPlacement
    directions : mapping of str to ModelDirection
        Directions of the compass readings on the model, keyed by reading id.
    turned_deg : float
        Correction that is added to all azimuths, degrees.
    """
    line_evidence = []
    for line in lines:
        if not line.is_complete:
            continue
        if line.is_read:
            if line.id in directions:
                distance = residual_deg(line, directions[line.id], placement, turned_deg)
                line_evidence.append(LineResidual(line.id, distance))
            continue
        ends = placement(np.array([line.vertices[0], line.vertices[-1]], np.float64))
        segments = ends[1] - ends[0]
        length = float(np.linalg.norm(segments))
        if not length > 0:
            continue
        if line.kind == "level":
            distance = float(np.degrees(np.arcsin(np.clip(segments[2] / length, -1.0, 1.0))))
        elif line.kind == "plumb":
            distance = float(np.degrees(np.arctan2(np.hypot(*segments[:2]), abs(segments[2]))))
        elif line.kind == "azimuth":
            azimuth = np.degrees(np.arctan2(segments[0], segments[1]))
            known_azimuth_deg = (line.value or 0.0) + turned_deg
            distance = float((azimuth - known_azimuth_deg + 180.0) % 360.0 - 180.0)
        else:
            distance = length - (line.value or 0.0)
        line_evidence.append(LineResidual(line.id, distance))
    return line_evidence


def known_after_placement(placement: ModelPlacement, model: Model) -> DeterminedParameters:
    """Return the parameters that are known after a placement, including earlier ones."""
    frame, known_parts = model.frame, placement.known
    has_vertical = known_parts.vertical or frame.has_up
    return DeterminedParameters(
        north=has_vertical and (known_parts.north or frame.has_north),
        vertical=has_vertical,
        scale=known_parts.scale or frame.has_metres,
        position=known_parts.position or frame.kind == "crs",
    )


def frame_after_placement(placement: ModelPlacement, model: Model, crs: str | None) -> Frame:
    """Return the frame after a placement; points without a `crs` are in a local frame."""
    if placement.known.all:
        return Frame("local") if crs is None else Frame("crs", crs=crs)
    known_parts = known_after_placement(placement, model)
    if known_parts.north and known_parts.scale:
        kept_crs = world_crs(model.frame.crs, model.frame.unit_m)
        return Frame("local") if kept_crs is None else Frame("crs", crs=kept_crs)
    if known_parts.north:
        return Frame("oriented")
    return Frame("scaled" if known_parts.scale else "undeclared", level=known_parts.vertical)


def placement_covariance(
    placement: ModelPlacement, previous_registration: Registration | None
) -> FloatArray:
    """Return the covariance (7, 7) of a placement.

    Undetermined parameters have the covariance of the previous registration, because it still
    defines them.
    """
    total = np.array(placement.covariance, np.float64)
    known_parts = placement.known
    if known_parts.all or previous_registration is None:
        return total
    previous_covariance = np.zeros((7, 7))
    shape = previous_registration.shape_covariance()
    if shape is not None:
        previous_covariance[:4, :4] = shape
    if previous_registration.covariance is not None and previous_registration.centre is not None:
        # A rotation or scale about the centre also shifts other points.
        shift_jacobian = np.eye(7)
        shift_jacobian[4:] = jacobian(np.subtract(placement.centre, previous_registration.centre))
        previous_covariance = (
            shift_jacobian
            @ np.array(previous_registration.covariance, np.float64)
            @ shift_jacobian.T
        )
    is_free = [not known_parts.vertical] * 2 + [not known_parts.north, not known_parts.scale]
    is_kept = np.array(is_free + [not known_parts.position] * 3, np.float64)
    return np.asarray(total + previous_covariance * np.outer(is_kept, is_kept))
