"""Lines and planes of a model of which something is known, as observations of its place."""

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
from vomstudio.registration.results import Known, Placed
from vomstudio.registration.similarity import jacobian
from vomstudio.studio.placing.known_planes import OnModel, miss_deg


@dataclass(frozen=True)
class LineMiss:
    """How far a line of a placed model is from what is known of it. off : placed less known,
    degrees, metres of a length; of what was read by compass the angle between the two"""

    id: str
    off: float


def usable(lines: Sequence[KnownLine]) -> list[KnownLine]:
    """Those with two ends that place a model: something is known of them, and they do not only
    judge."""
    return [line for line in lines if line.is_complete and not line.check and not line.is_read]


def evidence_of(
    pairs: Pairs,
    lines: Sequence[KnownLine],
    compass: CompassTable | None = None,
    turned_deg: float = 0.0,
) -> Evidence:
    """In the frame of the model's file. turned_deg : added to all azimuths"""
    found = Evidence(pairs=pairs if len(pairs.labels) else None)
    found.compass, found.compass_turn_deg = compass, turned_deg
    ends = [(line, line.vertices[0], line.vertices[-1]) for line in usable(lines)]
    found.level_lines, found.plumb_lines = (
        [KnownDirection(a, b, line.sigma, line.name) for line, a, b in ends if line.kind == kind]
        for kind in ("level", "plumb")
    )
    found.azimuths, found.lengths = (
        [
            Segment(a, b, line.value + added, line.sigma, line.name)
            for line, a, b in ends
            if line.kind == kind and line.value is not None
        ]
        for kind, added in (("azimuth", turned_deg), ("length", 0.0))
    )
    return found


def placed_by_known(
    pairs: Pairs,
    lines: Sequence[KnownLine],
    model: Model,
    extent: FloatArray | None,
    north_doubt_deg: float = 0.0,
    compass: CompassTable | None = None,
    turned_deg: float = 0.0,
    *,
    north_sigma_stated: bool = False,
    photo_up: FloatArray | None = None,
    keep_scale: bool = False,
    click_sigma_m: float | None = None,
    resolution: float | None = None,
) -> Placed:
    """The placement of a model's file by points, lines and planes on it. What these leave free
    stays as the model stands now, and so does its scale where that is kept.

    extent : (n, 3) points all over the model, in its file's frame; north_doubt_deg : one sigma of
        what all azimuths may be off alike; turned_deg : added to all azimuths; north_sigma_stated :
        whether that error is not a default; photo_up : (3,) as of `Evidence`
    click_sigma_m : error of a click on the model, metres, None for half the `resolution` of the
        model, which is in the unit of its file
    Raises GeometryError, UsageError.
    """
    evidence = evidence_of(pairs, lines, compass, turned_deg)
    evidence.compass_doubt_deg = north_doubt_deg
    evidence.compass_doubt_stated = north_sigma_stated
    evidence.photo_up = photo_up
    evidence.click_sigma_m, evidence.resolution = click_sigma_m, resolution
    evidence.up = up_of(model)
    if keep_scale:
        evidence.scale = transform.scale_of(transform.matrix(model.to_world))
        registration = model.registration
        evidence.scale_error = None if registration is None else registration.scale_error
    placed = register(evidence, extent)
    if placed.known.all:
        return placed
    # By the file alone a model that was turned before would fall back.
    stands = transform.matrix(model.to_world)
    evidence = _moved(evidence, stands)
    placed = register(evidence, None if extent is None else transform.apply(stands, extent))
    scale = placed.scale * transform.scale_of(stands)
    return replace(placed, matrix=placed.matrix @ stands, scale=scale)


def up_of(model: Model) -> FloatArray | None:
    """(3,) What points up in the frame of a model's file, as it stands; None where nobody knows."""
    if not model.frame.has_up:
        return None
    stands = transform.matrix(model.to_world)
    return np.asarray(stands[2, :3] / transform.scale_of(stands), np.float64)


def photo_up(path: Path) -> FloatArray | None:
    """(3,) What was up as photos were held, in the file of a model that was made of them here.

    None if it was made otherwise, or registered. Such a model is turned so that z is up as they
    were held (`photogrammetry.georeferencing.local_frame`).
    """
    return np.array([0.0, 0.0, 1.0]) if has_known_scale(path) is False else None


def _moved(evidence: Evidence, by: FloatArray) -> Evidence:
    """The same of a model that stands as a 4 x 4 similarity puts it."""

    def there(place: Point) -> Point:
        x, y, z = transform.apply(by, [place])[0].tolist()
        return x, y, z

    pairs = evidence.pairs
    if pairs is not None:
        pairs = replace(pairs, model=transform.apply(by, pairs.model))
    compass = evidence.compass
    if compass is not None:
        turn = by[:3, :3] / transform.scale_of(by)
        compass = replace(compass, model=compass.model @ turn.T)
    return replace(
        evidence,
        pairs=pairs,
        compass=compass,
        scale=None if evidence.scale is None else evidence.scale / transform.scale_of(by),
        resolution=None
        if evidence.resolution is None
        else evidence.resolution * transform.scale_of(by),
        up=None if evidence.up is None else by[:3, :3] @ evidence.up / transform.scale_of(by),
        photo_up=None if evidence.photo_up is None else by[:3, :3] @ evidence.photo_up,
        level_lines=[_direction_there(line, there) for line in evidence.level_lines],
        plumb_lines=[_direction_there(line, there) for line in evidence.plumb_lines],
        azimuths=[_there(line, there) for line in evidence.azimuths],
        lengths=[_there(line, there) for line in evidence.lengths],
    )


def _direction_there(line: KnownDirection, there: Callable[[Point], Point]) -> KnownDirection:
    return replace(line, first=there(line.first), second=there(line.second))


def _there(line: Segment, there: Callable[[Point], Point]) -> Segment:
    return line._replace(first=there(line.first), second=there(line.second))


def line_misses(
    lines: Sequence[KnownLine],
    placed: Placed,
    seen: Mapping[str, OnModel] = MappingProxyType({}),
    turned_deg: float = 0.0,
) -> list[LineMiss]:
    """Of the lines and planes of which something is known, those that judge among them.

    seen : what was read by compass, by id; turned_deg : added to all azimuths
    """
    found = []
    for line in lines:
        if not line.is_complete:
            continue
        if line.is_read:
            if line.id in seen:
                off = miss_deg(line, seen[line.id], placed, turned_deg)
                found.append(LineMiss(line.id, off))
            continue
        ends = placed(np.array([line.vertices[0], line.vertices[-1]], np.float64))
        along = ends[1] - ends[0]
        length = float(np.linalg.norm(along))
        if not length > 0:
            continue
        if line.kind == "level":
            off = float(np.degrees(np.arcsin(np.clip(along[2] / length, -1.0, 1.0))))
        elif line.kind == "plumb":
            off = float(np.degrees(np.arctan2(np.hypot(*along[:2]), abs(along[2]))))
        elif line.kind == "azimuth":
            azimuth = np.degrees(np.arctan2(along[0], along[1]))
            known = (line.value or 0.0) + turned_deg
            off = float((azimuth - known + 180.0) % 360.0 - 180.0)
        else:
            off = length - (line.value or 0.0)
        found.append(LineMiss(line.id, off))
    return found


def known_after(placed: Placed, model: Model) -> Known:
    """What is known of a model after a placement: what that gives, and what was known before."""
    frame, known = model.frame, placed.known
    vertical = known.vertical or frame.has_up
    return Known(
        north=vertical and (known.north or frame.has_north),
        vertical=vertical,
        scale=known.scale or frame.has_metres,
        position=known.position or frame.kind == "crs",
    )


def frame_after(placed: Placed, model: Model, crs: str | None) -> Frame:
    """What is known of World then. crs : of the points, None for local metres"""
    if placed.known.all:
        return Frame("local") if crs is None else Frame("crs", crs=crs)
    known = known_after(placed, model)
    if known.north and known.scale:
        stays = world_crs(model.frame.crs, model.frame.unit_m)
        return Frame("local") if stays is None else Frame("crs", crs=stays)
    if known.north:
        return Frame("oriented")
    return Frame("scaled" if known.scale else "undeclared", level=known.vertical)


def covariance_after(placed: Placed, before: Registration | None) -> FloatArray:
    """(7, 7) of the placement; of what it leaves free that of the registration before, which stays
    in force there."""
    total = np.array(placed.covariance, np.float64)
    known = placed.known
    if known.all or before is None:
        return total
    earlier = np.zeros((7, 7))
    shape = before.shape_covariance()
    if shape is not None:
        earlier[:4, :4] = shape
    if before.covariance is not None and before.centre is not None:
        # What turns and grows about its centre also shifts what lies elsewhere.
        moves = np.eye(7)
        moves[4:] = jacobian(np.subtract(placed.centre, before.centre))
        earlier = moves @ np.array(before.covariance, np.float64) @ moves.T
    free = [not known.vertical] * 2 + [not known.north, not known.scale]
    keep = np.array(free + [not known.position] * 3, np.float64)
    return np.asarray(total + earlier * np.outer(keep, keep))
