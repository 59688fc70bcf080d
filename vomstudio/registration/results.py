"""Results of a registration."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON, OPTIONAL_IN_JSON
from vomstudio.geometry.coordinate_limits import MAX_COORDINATE_M
from vomstudio.geometry.registrations import ObservationGroup
from vomstudio.registration.blunders import Blunder, LeaveOneOut


@dataclass(frozen=True)
class PointResidual:
    """Residual (fitted minus given) of a point in the World frame, metres.

    Attributes
    ----------
    error_m : float
        Length of the residual.
    pixels : float or None
        RMS distance from the marks of the point in photos, or None if missing.
    """

    label: str
    dx: float
    dy: float
    dz: float
    error_m: float
    pixels: float | None = None


@dataclass(frozen=True)
class RotationError:
    """One-sigma errors of the rotation, degrees; None if undetermined."""

    about_up: float | None
    about_east: float | None
    about_north: float | None


@dataclass(frozen=True)
class WeakestAxis:
    """Axis about which the rotation is least certain, and its 95 % error, degrees."""

    trend_deg: float
    plunge_deg: float
    error_deg: float | None


@dataclass(frozen=True)
class RotationError95:
    """95 % errors of the rotation, degrees, and the weakest axis."""

    about_up: float | None
    about_east: float | None
    about_north: float | None
    weakest: WeakestAxis


@dataclass(frozen=True)
class AdditionalPoint:
    """World position of one more control point that would reduce the rotation error most.

    `error_before_deg` and `error_after_deg` are the 95 % errors about the weakest axis.
    """

    x: float
    y: float
    z: float
    error_before_deg: float
    error_after_deg: float


@dataclass(frozen=True)
class DeterminedParameters:
    """Parameters that the registration has determined."""

    north: bool = True
    vertical: bool = True
    scale: bool = True
    position: bool = True

    @property
    def all(self) -> bool:
        return self.north and self.vertical and self.scale and self.position


@dataclass(frozen=True, repr=False, eq=False)
class ModelPlacement(PrintableResult):
    """Registration of a model, with its residuals and errors.

    Attributes
    ----------
    matrix : (4, 4) array
        Transforms column vectors from the model to the World frame.
    scale : float
        Metres per unit of the model.
    control, check : tuple of PointResidual
        Residuals of the points used in the fit, and of the check points.
    rms_control_m, rms_check_m : float or None
        RMS length of the residuals, or None if there are no such points.
    rotation_error_deg, rotation_error_95_deg, scale_error_95
        Errors of the rotation and relative error of the scale, computed from stated errors or
        otherwise from the residuals (Student's t).
    covariance : (7, 7) tuple
        Covariance of a rotation about east, north and up (rad), a relative change of scale and a
        translation (m), about `centre` (World frame), as one sigma of a normal distribution with
        the same 95 % limit.
    without : tuple of LeaveOneOut
        Placements without each of a few directions that disagree, most suspicious first.
    reach_m, normal
        Distance from the centre of the model to its edge, and normal of its mean plane in the World
        frame; None if only points are known.
    observations : tuple of ObservationGroup
        Inputs of the adjustment, by kind.
    north_sigma_deg : float or None
        One-sigma error common to all azimuths and compass readings in the adjustment, or None
        if missing.
    click_sigma_m : float or None
        One-sigma error of each coordinate of a click on the model, metres, in addition to the
        stated accuracies of the points; None if no point was clicked.
    mark_scatter_px : float or None
        One-sigma error of a mark in a photo in one direction, or None if there are no marks.
    """

    matrix: FloatArray
    scale: float
    control: tuple[PointResidual, ...]
    check: tuple[PointResidual, ...]
    rms_control_m: float | None
    rms_check_m: float | None
    rotation_error_deg: RotationError
    rotation_error_95_deg: RotationError95
    scale_error_95: float | None
    worth_adding: AdditionalPoint | None
    known: DeterminedParameters
    blunders: tuple[Blunder, ...]
    warnings: tuple[Finding, ...]
    covariance: tuple[tuple[float, ...], ...] = field(metadata=HIDDEN_IN_JSON)
    centre: tuple[float, float, float] = field(metadata=HIDDEN_IN_JSON)
    reach_m: float | None = field(default=None, metadata=HIDDEN_IN_JSON)
    normal: tuple[float, float, float] | None = field(default=None, metadata=HIDDEN_IN_JSON)
    without: tuple[LeaveOneOut, ...] = field(default=(), metadata=OPTIONAL_IN_JSON)
    observations: tuple[ObservationGroup, ...] = field(default=(), metadata=HIDDEN_IN_JSON)
    north_sigma_deg: float | None = None
    click_sigma_m: float | None = None
    mark_scatter_px: float | None = None

    def __call__(self, points: npt.ArrayLike) -> FloatArray:
        """Transform model points (n, 3) or (3,) to the World frame.

        Raises InputError if they have another shape or invalid coordinates.
        """
        matrix = self.matrix
        try:
            positions = np.asarray(points, np.float64)
        except (TypeError, ValueError, OverflowError):
            positions = np.empty(0)
        if (
            not positions.ndim
            or positions.shape[-1] != 3
            or not (np.abs(positions) <= MAX_COORDINATE_M).all()
        ):
            raise InputError(
                Finding("points.invalid"),
                field="points",
            )
        return np.asarray(positions @ matrix[:3, :3].T + matrix[:3, 3])
