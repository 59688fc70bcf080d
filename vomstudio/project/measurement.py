"""What one feature says once it is measured, and what a kind has at hand to measure it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology import orientation
from vomstudio.geology.common_rotation_errors import Region
from vomstudio.geology.intersections import UncertainPlane, uncertain_plane
from vomstudio.geology.notation import format_attitude
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.profiles import Thresholds
from vomstudio.geology.quality import Kind as JudgedAs
from vomstudio.geology.quality import (
    Verdict,
    is_local,
    resolution_tilt_deg,
    total_error_deg,
    wider_of,
)
from vomstudio.geometry import transform
from vomstudio.geometry.lines import LineFit
from vomstudio.geometry.planes import PlaneFit
from vomstudio.geometry.rotation_errors import errors_95_deg
from vomstudio.project.records import SURROUNDINGS_RULE, Model, Picked, Record, get

Records = Mapping[str, Record]
_NO_POINTS: FloatArray = np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class Measurement:
    """What a feature says, in World; None where a figure does not apply or cannot be had.

    points : (n, 3) float64 its vertices; the centre of a patch, the place of a reading (n = 1); of
        an intersection the ends of a line as long as its planes
    resolution_m, outcrop_normal : the feature's own
    by_this_rule : False where these two were measured by an earlier rule. What follows from the
        plane then has the error that the project has stated so far, until its user updates them
    fit : of a trace or patch; line_fit : of a lineation. Where there is none `problem` says why
    plane, line : the orientation, whatever it comes from
    max/min_confidence95_deg : semi-axes of its joint 95 % region, confidence_axis (3,) the
        direction of the larger one where it is a line
    rake_deg : of a lineation in its plane, off_plane_deg : its angle from that plane,
    slip_rake_deg : directed, as in geology.orientation.slip_from_rake
    on_plane : of a lineation, the plane in which these two are counted
    angle_deg : between the planes of an intersection
    area_m2 : of a patch's faces
    dimension : lengths and areas by name, in m or m2
    said : of what is no measurement, what it is in words
    metric : False where the model's scale is not known: lengths are then in units of its file
    kind : the name of the feature's kind
    judged_as : what kind of plane the verdict is on
    registration_error_deg : 95 % half-angle by which the model's registration can tilt it; None
        where the model was not registered, or its error is not known
    stretch_error_deg : 95 % half-angle of a trace's plane in view of its doubtful stretches; None
        where it has none
    bend_deg : of a face that bends as a whole, from edge to edge
    total : joint 95 % region of a line, together with the registration as far as that is known;
        None where its own is not
    """

    points: FloatArray
    resolution_m: float | None
    outcrop_normal: FloatArray | None
    fit: PlaneFit | None
    verdict: Verdict | None
    problem: Finding | None
    plane: Plane | None = None
    line: Line | None = None
    line_fit: LineFit | None = None
    max_confidence95_deg: float | None = None
    min_confidence95_deg: float | None = None
    confidence_axis: FloatArray | None = None
    rake_deg: float | None = None
    slip_rake_deg: float | None = None
    off_plane_deg: float | None = None
    on_plane: Plane | None = None
    angle_deg: float | None = None
    area_m2: float | None = None
    dimension: Mapping[str, float] | None = None
    said: str = ""
    by_this_rule: bool = True
    metric: bool = True
    kind: str = ""
    judged_as: JudgedAs = "trace"
    registration_error_deg: float | None = None
    stretch_error_deg: float | None = None
    bend_deg: float | None = None
    total: Region | None = None

    @cached_property
    def total95_deg(self) -> float | None:
        """The 95 % error by which the plane or line is judged, with the registration as far as that
        is known; None where there is none."""
        if self.fit is None:
            return self.max_confidence95_deg if self.total is None else self.total.largest_deg
        if self.fit.error is not None:
            return None
        return total_error_deg(
            self.fit,
            self.resolution_m,
            self.judged_as,
            self.registration_error_deg,
            self.outcrop_normal,
            self.stretch_error_deg,
        )

    @property
    def attitude_scale(self) -> Literal["local", "regional"] | None:
        """Whether a fitted plane is the attitude of this place alone; None without one."""
        if self.fit is None or self.fit.error is not None:
            return None
        return "local" if is_local(self.fit, self.bend_deg, self.total95_deg) else "regional"

    def attitude(self, notation: str = "dipdir/dip", *, bare: bool = False) -> str:
        """Return the plane or line with its 95 % error as text; "–" without either."""
        attitude = self.plane if self.plane is not None else self.line
        if attitude is None:
            return "–"
        return format_attitude(attitude, self.total95_deg, notation, bare=bare)

    def slip_vector(self) -> FloatArray | None:
        """(3,) unit vector along which the hanging wall moves; None where that is not known."""
        if self.on_plane is None or self.slip_rake_deg is None:
            return None
        return orientation.slip_from_rake(self.on_plane, self.slip_rake_deg).vector()


@dataclass(frozen=True, eq=False)
class NearestPick:
    """The pick of a reading's type to which it is compared.

    angle_deg: between the two planes or lines, axial, 0 to 90. distance_m: from the reading's
    place to the nearest point of the pick; None where the reading has no place: then the pick is
    the one with the smallest angle.
    """

    pick_id: str
    name: str
    angle_deg: float
    distance_m: float | None


@dataclass(frozen=True, eq=False)
class Measuring:
    """What features are measured with. known: the measurements of what they rest on, by id."""

    records: Records
    thresholds: Thresholds
    known: Mapping[str, Measurement]

    def model(self, model_id: str) -> Model | None:
        return get(self.records, model_id, Model)

    def plane(self, feature_id: str) -> UncertainPlane | None:
        """The plane of a feature with the error it is judged by; None where it has none."""
        measured = self.known.get(feature_id)
        return None if measured is None else as_uncertain(measured)


def nothing_measured(
    points: FloatArray,
    resolution_m: float | None,
    problem: Finding | None,
    *,
    kind: str,
    metric: bool = True,
) -> Measurement:
    """Of a feature that has a place but no figure."""
    return Measurement(points, resolution_m, None, None, None, problem, kind=kind, metric=metric)


def of_fit(fit: PlaneFit | None, plane: Plane | None = None) -> dict[str, Any]:
    """The fields of a measurement that a fitted plane gives; `plane` is its attitude where that is
    known already."""
    if fit is None:
        return {}
    return {
        "plane": plane or Plane.from_normal(fit.normal),
        "max_confidence95_deg": fit.max_confidence95_deg,
        "min_confidence95_deg": fit.min_confidence95_deg,
    }


def as_uncertain(measured: Measurement) -> UncertainPlane | None:
    """The plane with the error it is judged by; None where there is no plane."""
    fit, plane = measured.fit, measured.plane
    if plane is None:
        return None
    if fit is None or fit.error_rake_deg is None:
        return UncertainPlane(plane.normal(), None)
    tilt = orientation.line_from_rake(plane, fit.error_rake_deg).vector()
    resolution = measured.resolution_m if measured.by_this_rule else None
    largest, smallest = wider_of(
        fit,
        measured.judged_as,
        resolution,
        measured.outcrop_normal,
        measured.stretch_error_deg,
    )
    free = 1.0 if fit.n_effective is None else max(fit.n_effective - 3.0, 1.0)
    rough = 0.0 if fit.rms is None else fit.rms * float(np.sqrt(fit.n / max(fit.n - 3.0, 1.0)))
    return replace(uncertain_plane(plane.normal(), tilt, largest, smallest, free), roughness=rough)


# --- from the file frame to World ------------------------------------------------------------
def world_points(feature: Picked, model: Model | None) -> FloatArray:
    """(n, 3) vertices in World; in the file frame where the model is gone."""
    return world_lines([feature], [model])[0]


def world_lines(features: Sequence[Picked], models: Sequence[Model | None]) -> list[FloatArray]:
    """`world_points` of many features, those of one model together."""
    rows: dict[int, list[int]] = {}
    for i, model in enumerate(models):
        rows.setdefault(id(model), []).append(i)
    result: list[FloatArray] = [_NO_POINTS] * len(features)
    for own in rows.values():
        chosen = [features[i].vertices for i in own]
        numbers = chain.from_iterable(chain.from_iterable(chosen))
        flat = np.fromiter(numbers, np.float64, 3 * sum(map(len, chosen)))
        turned = transform.apply(rows_of(models[own[0]]), flat.reshape(-1, 3))
        start = 0
        for i, line in zip(own, chosen, strict=True):
            result[i] = turned[start : start + len(line)]
            start += len(line)
    return result


@dataclass(frozen=True, eq=False)
class ToWorld:
    """From the file frame of a model to World. rows : (4, 4); scale : lengths grow by it"""

    rows: FloatArray
    scale: float
    metric: bool
    rotation: FloatArray | None = None
    """(3, 3) covariance of the registration's rotation, radians squared, where it is known."""

    @classmethod
    def of(cls, model: Model | None) -> ToWorld:
        """That of a model; nothing changes where the model is gone."""
        rows = rows_of(model)
        registration = None if model is None else model.registration
        rotation = None if registration is None else registration.rotation_covariance()
        return cls(rows, transform.scale_of(rows), is_metric(model), rotation)

    @cached_property
    def turn(self) -> FloatArray:
        """(3, 3); a direction as a row times it is the direction in World."""
        turned: FloatArray = (self.rows[:3, :3] / self.scale).T
        return turned

    def tilt_deg(self, direction: npt.ArrayLike | None) -> float | None:
        """95 % half-angle by which the registration can tilt a normal or line (3,) in World."""
        if self.rotation is None or direction is None:
            return None
        return self.tilts_deg(np.asarray(direction, np.float64)[None])[0]

    def tilts_deg(self, directions: FloatArray) -> list[float]:
        """The same of directions (n, 3); 0 where nothing is known of the rotation."""
        if self.rotation is None:
            return [0.0] * len(directions)
        return [float(angle) for angle in errors_95_deg(self.rotation, directions)]


def rows_of(model: Model | None) -> FloatArray:
    """(4, 4) from the file frame to World; the identity where the model is gone."""
    return np.eye(4) if model is None else transform.matrix(model.to_world)


def in_world(length: float | None, rows: FloatArray) -> float | None:
    """A length of the file in metres."""
    return None if length is None else length * transform.scale_of(rows)


def is_metric(model: Model | None) -> bool:
    return model is None or model.frame.has_metres


def told_of_rule(verdict: Verdict, rule: int, *, measured: bool) -> Verdict:
    """The verdict, with a note where what it rests on was measured by an earlier rule."""
    if rule >= SURROUNDINGS_RULE or not measured:
        return verdict
    note = Finding("plane.earlier-rule")
    return Verdict(verdict.quality, verdict.reasons, (*verdict.notes, note), verdict.limits)


def common_error_deg(fit95_deg: float | None, measured: Iterable[Measurement]) -> float | None:
    """Return the total 95 % error of a plane that was fitted to several features together.

    Parameters
    ----------
    fit95_deg : float or None
        Error of the common fit.
    measured : iterable of Measurement
        Of the features: the best resolved one limits what the resolution can tilt, and their
        registration turns all of them alike.

    Returns
    -------
    float or None
        Degrees, at most 90; None if that of the fit is not known.
    """
    if fit95_deg is None:
        return None
    each = list(measured)
    tilts = [
        resolution_tilt_deg(m.fit, m.resolution_m, m.judged_as) or 0.0
        for m in each
        if m.fit is not None
    ]
    turned = max((m.registration_error_deg or 0.0 for m in each), default=0.0)
    return min(math.hypot(max(fit95_deg, min(tilts, default=0.0)), turned), 90.0)


_OF_ANY_PLACE = 1.0 / math.sqrt(12.0)
"""Standard deviation of what lies anywhere within a length of 1."""


def scatter_of(measured: Iterable[Measurement]) -> float:
    """The likely standard deviation of a point picked on these features, metres: the largest
    scatter about a plane of theirs, or what the resolution of their models leaves, which is up to
    half of it to either side; 0 where nothing is known."""
    known = [0.0]
    for each in measured:
        known.append((each.resolution_m or 0.0) * _OF_ANY_PLACE)
        known.append((each.fit.rms or 0.0) if each.fit is not None else 0.0)
    return max(known)
