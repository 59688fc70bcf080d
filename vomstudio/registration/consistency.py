"""Consistency checks of control points with camera positions, and of north and scale.

Control points and cameras each determine a rotation and a scale, whose differences are compared
with their errors. They differ if one of the two is in another coordinate system, or if the lens
parameters are wrong: an error of 5 % in the focal length moves the cameras by 5 % of their
distance, while the scene still fits its points. The error common to all compass azimuths is
estimated together with the placement, without a prior.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.registration.adjustment import Adjustment, adjust
from vomstudio.registration.observations import (
    COMPASS,
    YAW,
    Attitudes,
    Azimuths,
    Directions,
    FixedScale,
    ObservationKind,
    Points,
)
from vomstudio.registration.similarity import is_nearly_collinear
from vomstudio.registration.similarity_observation import SimilarityObservation

_MIN_OBSERVATIONS = 4
# Significance of contradictions.
_SIGNIFICANCE = 0.001
# Prior of an unknown angle, maximum error of a determined angle, and minimum reported angle.
_FREE_NORTH_SIGMA_RAD = np.radians(60.0)
_MAX_NORTH_ERROR_DEG = 20.0
_MIN_NORTH_TURN_DEG = 0.5
# Tolerance from a quarter turn within which a yaw refers to another side of the camera.
_QUARTER_TOLERANCE_DEG = 10.0
_STEP_DEG = 10.0
_NORTH_KINDS = Points | Attitudes | SimilarityObservation | Directions | Azimuths
_MAX_ITERATIONS = 6
# Logarithm of a ratio of scales up to which steps of the adjustment converge.
_MAX_LOG_SCALE = 0.4


@dataclass(frozen=True)
class ScaleContradiction:
    """Significant difference between a fixed scale and the scale from all other observations.

    Attributes
    ----------
    times : float
        Ratio of the scale from the other observations to the fixed scale.
    error : float
        Relative one-sigma error of `times`.
    """

    times: float
    error: float

    @property
    def finding(self) -> Finding:
        """Finding that describes the contradiction."""
        return Finding(
            "registration.scale-contradicted", times=self.times, error95_percent=196.0 * self.error
        )


def check_fixed_scale(
    kinds: Sequence[ObservationKind], centre: FloatArray, size: float
) -> tuple[ScaleContradiction | None, list[ObservationKind]]:
    """Compare a fixed scale with the scale from the other observations.

    Parameters
    ----------
    kinds : sequence of ObservationKind
    centre, size
        See `adjust`.

    Returns
    -------
    ScaleContradiction or None
    kinds : list of ObservationKind
        Observations. If the scales contradict each other or differ greatly, the points are scaled
        about their mean to the fixed scale. The best rotation does not depend on the scale, whereas
        misfits due to a wrong scale would bias it.
    """
    from scipy.stats import norm

    other_kinds = [kind for kind in kinds if not isinstance(kind, FixedScale)]
    fixed_scale = next((kind for kind in kinds if isinstance(kind, FixedScale)), None)
    if fixed_scale is None or not other_kinds:
        return None, list(kinds)
    free_fit = adjust(other_kinds, centre, size)
    if np.abs(free_fit.null_space[3]).sum() > 0:
        return None, list(kinds)
    metres = float(fixed_scale.length[0] / np.linalg.norm(fixed_scale.second - fixed_scale.first))
    times, error = free_fit.fit.scale / metres, float(np.sqrt(free_fit.covariance[3, 3]))
    contradiction = None
    if abs(np.log(times)) >= float(norm.isf(_SIGNIFICANCE / 2.0)) * error:
        contradiction = ScaleContradiction(times, error)
    elif abs(np.log(times)) < _MAX_LOG_SCALE:
        return None, list(kinds)
    point_sets = [kind.world for kind in kinds if isinstance(kind, Points)]
    midpoint = np.concatenate(point_sets).mean(axis=0) if point_sets else np.zeros(3)
    return contradiction, [
        replace(kind, world=midpoint + (kind.world - midpoint) / times, sigma=kind.sigma / times)
        if isinstance(kind, Points)
        else kind
        for kind in kinds
    ]


def disagreement_findings(
    kinds: Sequence[ObservationKind], centre: FloatArray, size: float
) -> list[Finding]:
    """Return findings if points and cameras contradict each other.

    Parameters
    ----------
    kinds : sequence of ObservationKind
    centre, size
        See `adjust`.

    Returns
    -------
    list of Finding
    """
    from scipy.spatial.transform import Rotation
    from scipy.stats import chi2

    single_fits = [
        adjust([kind], centre, size)
        for kind in kinds
        if isinstance(kind, Points)
        and len(kind.labels) >= _MIN_OBSERVATIONS
        and not is_nearly_collinear(kind.model)
        and not is_nearly_collinear(kind.world)
    ]
    if len(single_fits) != 2 or any(item.null_space.shape[1] for item in single_fits):
        return []
    first_fit, second_fit = (item.fit for item in single_fits)
    rotation = Rotation.from_matrix(first_fit.rotation @ second_fit.rotation.T).as_rotvec()
    log_scale_ratio = float(np.log(first_fit.scale / second_fit.scale))
    offset = np.array([*rotation, log_scale_ratio])
    errors = _rotation_scale_covariance(single_fits[0]) + _rotation_scale_covariance(single_fits[1])
    if float(chi2.sf(offset @ np.linalg.solve(errors, offset), 4)) > _SIGNIFICANCE:
        return []
    return [
        Finding(
            "registration.points-and-cameras",
            turn_deg=float(np.degrees(np.linalg.norm(rotation))),
            scale_percent=100.0 * float(np.expm1(log_scale_ratio)),
        )
    ]


def _rotation_scale_covariance(result: Adjustment) -> FloatArray:
    return result.covariance[:4, :4]


@dataclass(frozen=True, eq=False)
class NorthError:
    """Error common to all azimuths that refer to the same north, degrees.

    Attributes
    ----------
    name : str
        Name of the north.
    turn_deg : float
        Angle by which the azimuths are too large.
    error95_deg : float
        95 % error of `turn_deg`.
    has_directions : bool
        Whether planes and lines refer to this north, and not only azimuths.
    """

    name: str
    turn_deg: float
    error95_deg: float
    has_directions: bool

    @property
    def finding(self) -> Finding:
        """Finding that describes the north error."""
        nearest_quarter = min(
            (90.0, 180.0, -90.0, -180.0), key=lambda quarter: abs(self.turn_deg - quarter)
        )
        values: dict[str, object] = {
            "kind": self.name,
            "readings": tr("compass readings") if self.name == COMPASS else tr("yaws"),
            "turn_deg": self.turn_deg,
            "error95_deg": self.error95_deg,
        }
        if abs(self.turn_deg - nearest_quarter) < _QUARTER_TOLERANCE_DEG:
            return Finding(
                "registration.north-quarter-turn", correction_deg=-nearest_quarter, **values
            )
        return Finding("registration.north-turned", **values)


def estimate_north_errors(
    kinds: Sequence[ObservationKind], centre: FloatArray, size: float
) -> tuple[list[NorthError], list[ObservationKind]]:
    """Estimate the common error of compass azimuths and the common error of yaws.

    A north is corrected if other observations determine its error and the error is significant.

    Returns
    -------
    norths : list of NorthError
    kinds : list of ObservationKind
        Observations with corrected azimuths and without priors of the corrected norths. These give
        the best placement and are used to assess single readings.
    """
    north_turns, corrected_kinds = [], list(kinds)
    for name in (COMPASS, YAW):
        estimate = _estimate_north_error(corrected_kinds, centre, size, name)
        if estimate is not None:
            rotation, corrected_kinds = estimate
            north_turns.append(rotation)
    return north_turns, corrected_kinds


def _estimate_north_error(
    kinds: Sequence[ObservationKind], centre: FloatArray, size: float, name: str
) -> tuple[NorthError, list[ObservationKind]] | None:
    from scipy.stats import norm

    reading_kinds = Attitudes if name == YAW else Directions | Azimuths
    other_kinds = [kind for kind in kinds if not isinstance(kind, reading_kinds)]
    if len(other_kinds) == len(kinds) or not any(
        isinstance(kind, _NORTH_KINDS) for kind in other_kinds
    ):
        return None
    try:
        turn_deg = _initial_turn_deg(kinds, other_kinds, centre, size, name)
    except GeometryError:
        return None
    freed_kinds = [_free_north(kind, turn_deg, name) for kind in kinds]
    for _ in range(_MAX_ITERATIONS):
        try:
            result = adjust(freed_kinds, centre, size)
        except GeometryError:
            return None
        index = result.rows.shared_names.index(name)
        # Rows rotate the model counterclockwise, whereas readings increase clockwise.
        step = -float(np.degrees(result.common_errors[index]))
        turn_deg += step
        error = float(np.degrees(np.sqrt(result.common_covariance[index, index])))
        if error > _MAX_NORTH_ERROR_DEG:
            return None
        freed_kinds = [_free_north(kind, turn_deg, name) for kind in kinds]
        if abs(step) < 0.01:
            break
    turn_deg = float((turn_deg + 180.0) % 360.0 - 180.0)
    if abs(turn_deg) < max(_MIN_NORTH_TURN_DEG, float(norm.isf(_SIGNIFICANCE / 2.0)) * error):
        return None
    has_directions = any(isinstance(kind, Directions) for kind in kinds)
    return NorthError(name, turn_deg, 1.959963984540054 * error, has_directions), freed_kinds


def _initial_turn_deg(
    kinds: Sequence[ObservationKind],
    other_kinds: Sequence[ObservationKind],
    centre: FloatArray,
    size: float,
    name: str,
) -> float:
    """Return an initial estimate of a north error, in degrees, from the other observations.

    Small steps from a distant start would converge to a wrong solution. Returns 0 if the other
    observations do not determine the rotation.
    """
    remaining_fit = adjust(other_kinds, centre, size)
    if np.abs(remaining_fit.null_space[:3]).sum() > 0:
        return 0.0
    readings = [kind for kind in kinds if not any(kind is other_kind for other_kind in other_kinds)]
    trial_turns = np.arange(0.0, 360.0, _STEP_DEG)
    residuals = [
        np.median(
            np.abs(
                np.concatenate(
                    [
                        _free_north(kind, trial_turn, name)
                        .rows(remaining_fit.fit, remaining_fit.centre)
                        .residuals
                        for kind in readings
                    ]
                )
            )
        )
        for trial_turn in trial_turns
    ]
    return float(trial_turns[int(np.argmin(residuals))])


def _free_north(kind: ObservationKind, turned_deg: float, name: str) -> ObservationKind:
    """Correct the azimuths of a kind of readings, and widen the prior of their north."""
    turn_rad = np.radians(turned_deg)
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    inverse_rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    if name == YAW:
        if isinstance(kind, Attitudes):
            return replace(
                kind,
                world=inverse_rotation @ kind.world,
                axes=inverse_rotation @ kind.axes,
                north_sigma=_FREE_NORTH_SIGMA_RAD,
            )
        return kind
    if isinstance(kind, Azimuths):
        return replace(kind, azimuth=kind.azimuth - turn_rad, north_sigma=_FREE_NORTH_SIGMA_RAD)
    if isinstance(kind, Directions):
        return replace(
            kind, world=kind.world @ inverse_rotation.T, north_sigma=_FREE_NORTH_SIGMA_RAD
        )
    return kind
