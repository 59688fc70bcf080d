"""Measurement of one feature, and the inputs that a kind needs to compute it."""

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
from vomstudio.geology.common_rotation_errors import ConfidenceRegion
from vomstudio.geology.intersections import UncertainPlane, uncertain_plane
from vomstudio.geology.notation import format_attitude
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.profiles import Thresholds
from vomstudio.geology.quality import Kind as JudgedAs
from vomstudio.geology.quality import (
    Verdict,
    governing_half_angles,
    is_local,
    resolution_tilt_deg,
    total_error_deg,
)
from vomstudio.geometry import transform
from vomstudio.geometry.lines import FittedLine
from vomstudio.geometry.planes import FittedPlane
from vomstudio.geometry.rotation_errors import errors_95_deg
from vomstudio.project.records import SURROUNDINGS_RULE, Model, PickedFeature, Record, get

Records = Mapping[str, Record]
_NO_POINTS: FloatArray = np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class Measurement:
    """Results of measuring one feature, in World coordinates.

    Fields that do not apply to the feature or cannot be computed are set to None.

    Attributes
    ----------
    points : (n, 3) float64
        Vertices; the centre of a patch or the position of a reading (n = 1); for an intersection,
        the ends of a line as long as the planes.
    resolution_m, outcrop_normal
        Values copied from the feature.
    uses_current_rule : bool
        Whether these two values were measured with the current rule. If False, the errors derived
        from the plane stay as the project has reported them until the user updates the measurement.
    fit, line_fit
        Fit of a trace or patch, and fit of a lineation. If the fit failed, `problem` contains the
        reason.
    plane, line
        Orientation from any source.
    max_confidence95_deg, min_confidence95_deg : float or None
        Semi-axes of the joint 95 % region.
    confidence_axis : (3,) float64 or None
        Direction of the larger semi-axis of a line.
    rake_deg, off_plane_deg : float or None
        Rake of a lineation in its plane, and angle between the lineation and the plane.
    slip_rake_deg : float or None
        Directed rake, as in `geology.orientation.slip_from_rake`.
    on_plane : Plane or None
        Plane of a lineation to which rake and angle refer.
    angle_deg : float or None
        Angle between the planes of an intersection.
    area_m2 : float or None
        Area of the faces of a patch.
    dimension : mapping of str to float or None
        Lengths and areas by name, in m or m².
    text : str
        Text for a feature that has no numerical value.
    metric : bool
        Whether lengths are in metres. If False, the scale of the model is unknown and lengths are
        in file units.
    kind : str
        Name of the feature's kind.
    verdict_kind : str
        Kind of plane to which the verdict applies.
    registration_error_deg : float or None
        95 % half-angle by which the registration of the model may tilt the plane or line; None if
        the model is not registered or its error is unknown.
    stretch_error_deg : float or None
        95 % half-angle of the plane of a trace due to its doubtful stretches; None if it has no
        such stretches.
    bend_deg : float or None
        Bend of a face from edge to edge, if the face bends as a whole.
    total : ConfidenceRegion or None
        Joint 95 % region of a line, including the error of the registration if known; None if the
        region of the line is unknown.
    """

    points: FloatArray
    resolution_m: float | None
    outcrop_normal: FloatArray | None
    fit: FittedPlane | None
    verdict: Verdict | None
    problem: Finding | None
    plane: Plane | None = None
    line: Line | None = None
    line_fit: FittedLine | None = None
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
    text: str = ""
    uses_current_rule: bool = True
    metric: bool = True
    kind: str = ""
    verdict_kind: JudgedAs = "trace"
    registration_error_deg: float | None = None
    stretch_error_deg: float | None = None
    bend_deg: float | None = None
    total: ConfidenceRegion | None = None

    @cached_property
    def total95_deg(self) -> float | None:
        """95 % error of the plane or line used in verdicts, or None if unknown.

        It includes the error of the registration if known.
        """
        if self.fit is None:
            return self.max_confidence95_deg if self.total is None else self.total.largest_deg
        if self.fit.error is not None:
            return None
        return total_error_deg(
            self.fit,
            self.resolution_m,
            self.verdict_kind,
            self.registration_error_deg,
            self.outcrop_normal,
            self.stretch_error_deg,
        )

    @property
    def attitude_scale(self) -> Literal["local", "regional"] | None:
        """Scale of a fitted plane, "local" or "regional"; None if no plane is fitted."""
        if self.fit is None or self.fit.error is not None:
            return None
        return "local" if is_local(self.fit, self.bend_deg, self.total95_deg) else "regional"

    def attitude(self, notation: str = "dipdir/dip", *, omit_hand_rule: bool = False) -> str:
        """Return the plane or line with its 95 % error as text, or "–" if it has neither."""
        attitude = self.plane if self.plane is not None else self.line
        if attitude is None:
            return "–"
        return format_attitude(attitude, self.total95_deg, notation, omit_hand_rule=omit_hand_rule)

    def slip_vector(self) -> FloatArray | None:
        """Return the unit vector (3,) of the hanging wall's movement, or None if unknown."""
        if self.on_plane is None or self.slip_rake_deg is None:
            return None
        return orientation.slip_from_rake(self.on_plane, self.slip_rake_deg).vector()


@dataclass(frozen=True, eq=False)
class NearestPick:
    """Pick of the same type with which a reading is compared.

    Attributes
    ----------
    angle_deg : float
        Axial angle between the two planes or lines, 0 to 90.
    distance_m : float or None
        Distance between the reading and the nearest point of the pick; None if the reading has no
        position, in which case the pick is the one with the smallest angle.
    """

    pick_id: str
    name: str
    angle_deg: float
    distance_m: float | None


@dataclass(frozen=True, eq=False)
class MeasurementContext:
    """Inputs of a measurement. `known` contains measurements of dependencies by feature ID."""

    records: Records
    thresholds: Thresholds
    known: Mapping[str, Measurement]

    def model(self, model_id: str) -> Model | None:
        return get(self.records, model_id, Model)

    def plane(self, feature_id: str) -> UncertainPlane | None:
        """Return the plane of a feature with its error for verdicts, or None if it has no plane."""
        measurement = self.known.get(feature_id)
        return None if measurement is None else plane_with_error(measurement)


def empty_measurement(
    points: FloatArray,
    resolution_m: float | None,
    problem: Finding | None,
    *,
    kind: str,
    metric: bool = True,
) -> Measurement:
    """Return the measurement of a feature that has a position but no numerical value."""
    return Measurement(points, resolution_m, None, None, None, problem, kind=kind, metric=metric)


def fit_fields(fit: FittedPlane | None, plane: Plane | None = None) -> dict[str, Any]:
    """Return the fields of a measurement that a fitted plane determines.

    `plane` is its attitude if it is already known.
    """
    if fit is None:
        return {}
    return {
        "plane": plane or Plane.from_normal(fit.normal),
        "max_confidence95_deg": fit.max_confidence95_deg,
        "min_confidence95_deg": fit.min_confidence95_deg,
    }


def plane_with_error(measurement: Measurement) -> UncertainPlane | None:
    """Return the plane with its error for verdicts, or None if there is no plane."""
    fit, plane = measurement.fit, measurement.plane
    if plane is None:
        return None
    if fit is None or fit.error_rake_deg is None:
        return UncertainPlane(plane.normal(), None)
    tilt = orientation.line_from_rake(plane, fit.error_rake_deg).vector()
    resolution = measurement.resolution_m if measurement.uses_current_rule else None
    major_deg, minor_deg = governing_half_angles(
        fit,
        measurement.verdict_kind,
        resolution,
        measurement.outcrop_normal,
        measurement.stretch_error_deg,
    )
    degrees_of_freedom = 1.0 if fit.n_effective is None else max(fit.n_effective - 3.0, 1.0)
    roughness = 0.0 if fit.rms is None else fit.rms * float(np.sqrt(fit.n / max(fit.n - 3.0, 1.0)))
    return replace(
        uncertain_plane(plane.normal(), tilt, major_deg, minor_deg, degrees_of_freedom),
        roughness=roughness,
    )


# --- from the file frame to World ------------------------------------------------------------
def world_points(feature: PickedFeature, model: Model | None) -> FloatArray:
    """Return the vertices (n, 3) in the World frame, or in the file frame if `model` is None."""
    return world_lines([feature], [model])[0]


def world_lines(
    features: Sequence[PickedFeature], models: Sequence[Model | None]
) -> list[FloatArray]:
    """Return `world_points` of many features, transformed in one batch per model."""
    rows: dict[int, list[int]] = {}
    for i, model in enumerate(models):
        rows.setdefault(id(model), []).append(i)
    result: list[FloatArray] = [_NO_POINTS] * len(features)
    for indices in rows.values():
        lines = [features[i].vertices for i in indices]
        coordinates = chain.from_iterable(chain.from_iterable(lines))
        flat_coordinates = np.fromiter(coordinates, np.float64, 3 * sum(map(len, lines)))
        world = transform.apply(
            matrix_to_world(models[indices[0]]), flat_coordinates.reshape(-1, 3)
        )
        start = 0
        for i, line in zip(indices, lines, strict=True):
            result[i] = world[start : start + len(line)]
            start += len(line)
    return result


@dataclass(frozen=True, eq=False)
class ToWorld:
    """Transformation from the file frame of a model to the World frame.

    Attributes
    ----------
    rows : (4, 4) float64
    scale : float
        Factor from lengths in the file to lengths in the World frame.
    rotation : (3, 3) float64 or None
        Covariance of the registration's rotation in radians squared; None if unknown.
    """

    rows: FloatArray
    scale: float
    metric: bool
    rotation: FloatArray | None = None

    @classmethod
    def from_model(cls, model: Model | None) -> ToWorld:
        """Return the transformation of a model, or the identity if the model was removed."""
        rows = matrix_to_world(model)
        registration = None if model is None else model.registration
        rotation = None if registration is None else registration.rotation_covariance()
        return cls(rows, transform.scale_factor(rows), is_metric(model), rotation)

    @cached_property
    def turn(self) -> FloatArray:
        """Rotation matrix (3, 3), which transforms directions as row vectors to World."""
        rotation: FloatArray = (self.rows[:3, :3] / self.scale).T
        return rotation

    def tilt_deg(self, direction: npt.ArrayLike | None) -> float | None:
        """Return the 95 % half-angle by which the registration may tilt a direction (3,).

        Returns None if the direction or the error of the rotation is unknown.
        """
        if self.rotation is None or direction is None:
            return None
        return self.tilts_deg(np.asarray(direction, np.float64)[None])[0]

    def tilts_deg(self, directions: FloatArray) -> list[float]:
        """Return `tilt_deg` of directions (n, 3), or 0 if the rotation error is unknown."""
        if self.rotation is None:
            return [0.0] * len(directions)
        return [float(angle) for angle in errors_95_deg(self.rotation, directions)]


def matrix_to_world(model: Model | None) -> FloatArray:
    """Return the matrix (4, 4) from the file frame to World; for None, the identity."""
    return np.eye(4) if model is None else transform.matrix(model.to_world)


def length_in_metres(length: float | None, rows: FloatArray) -> float | None:
    """Convert a length in file units to metres; None remains None."""
    return None if length is None else length * transform.scale_factor(rows)


def is_metric(model: Model | None) -> bool:
    """Return whether the lengths of a model are in metres; True if `model` is None."""
    return model is None or model.frame.has_metres


def note_earlier_rule(verdict: Verdict, rule: int, *, is_measured: bool) -> Verdict:
    """Return the verdict, with a note if its inputs were measured with an earlier rule."""
    if rule >= SURROUNDINGS_RULE or not is_measured:
        return verdict
    note = Finding("plane.earlier-rule")
    return Verdict(verdict.quality, verdict.reasons, (*verdict.notes, note), verdict.limits)


def common_error_deg(fit95_deg: float | None, measured: Iterable[Measurement]) -> float | None:
    """Return the total 95 % error of a plane fitted to several features together.

    Parameters
    ----------
    fit95_deg : float or None
        Error of the common fit.
    measured : iterable of Measurement
        Measurements of the features. The feature with the best resolution limits the tilt due to
        resolution; the registration tilts all features together.

    Returns
    -------
    float or None
        Error in degrees, at most 90, or None if the error of the fit is unknown.
    """
    if fit95_deg is None:
        return None
    measurements = list(measured)
    tilts = [
        resolution_tilt_deg(measurement.fit, measurement.resolution_m, measurement.verdict_kind)
        or 0.0
        for measurement in measurements
        if measurement.fit is not None
    ]
    registration_deg = max(
        (measurement.registration_error_deg or 0.0 for measurement in measurements), default=0.0
    )
    return min(math.hypot(max(fit95_deg, min(tilts, default=0.0)), registration_deg), 90.0)


UNIFORM_SIGMA = 1.0 / math.sqrt(12.0)
"""Standard deviation of a uniform distribution of width 1."""


def pick_scatter_m(measurements: Iterable[Measurement]) -> float:
    """Return the probable standard deviation of a point picked on these features, in metres.

    This is the larger of the largest scatter about one of their planes and the error due to the
    resolution of their models, uniform within half the resolution to either side. It is 0 if both
    are unknown.
    """
    scatters = [0.0]
    for item in measurements:
        scatters.append((item.resolution_m or 0.0) * UNIFORM_SIGMA)
        scatters.append((item.fit.rms or 0.0) if item.fit is not None else 0.0)
    return max(scatters)
