"""What a registration has found, with the names of the command line."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN, OPTIONAL
from vomstudio.geometry.coordinate_limits import FARTHEST_M
from vomstudio.geometry.registrations import ObservationGroup
from vomstudio.registration.blunders import Blunder, Without


@dataclass(frozen=True)
class PointResidual:
    """dx, dy, dz, error_m : fitted less given, World, and its length; pixels : how far from its
    marks in photos it is seen (RMS), None without marks"""

    label: str
    dx: float
    dy: float
    dz: float
    error_m: float
    pixels: float | None = None


@dataclass(frozen=True)
class RotationError:
    """Of the rotation, one sigma each, degrees; None where nothing determines it."""

    about_up: float | None
    about_east: float | None
    about_north: float | None


@dataclass(frozen=True)
class WeakestAxis:
    """The axis about which the model is held worst, and its 95 % error, degrees."""

    trend_deg: float
    plunge_deg: float
    error_deg: float | None


@dataclass(frozen=True)
class RotationError95:
    """The same three at 95 %, each by itself, and the worst axis of all."""

    about_up: float | None
    about_east: float | None
    about_north: float | None
    weakest: WeakestAxis


@dataclass(frozen=True)
class WorthAdding:
    """Where, in World, one more control point lessens the worst error of the rotation most: that
    error (95 %, degrees) before and after."""

    x: float
    y: float
    z: float
    error_before_deg: float
    error_after_deg: float


@dataclass(frozen=True)
class Known:
    """What the registration has fixed."""

    north: bool = True
    vertical: bool = True
    scale: bool = True
    position: bool = True

    @property
    def all(self) -> bool:
        return self.north and self.vertical and self.scale and self.position


@dataclass(frozen=True, repr=False, eq=False)
class Placed(PrintableResult):
    """A similarity from the model to World, and what it leaves over.

    matrix : (4, 4), acts on column vectors of the model; scale : metres per unit of the model
    control : points that entered the fit; check : points that did not
    rms_control_m, rms_check_m : of the residuals' lengths, None without such points
    rotation_error_deg, rotation_error_95_deg, scale_error_95 (a share of the scale) : from the
        errors given, else from the residuals (Student's t with the degrees of freedom that these
        leave)
    covariance : (7, 7) of turns about east, north and up (rad), a relative change of scale and a
        shift (m), about `centre` (World); one sigma of a normal distribution with the same 95 %
    without : the placement without each of a few directions that do not agree, the most suspicious
        first
    reach_m, normal : from the middle of the model to its edge, and of its mean plane (World), None
        where only the points are known
    observations : the inputs of the adjustment, by kind
    north_sigma_deg : common offset of all azimuths and compass readings by which it was computed,
        one sigma; None without any
    click_sigma_m : error of each coordinate of a click on the model, one sigma, metres, beside the
        stated accuracies of the points; None if no point was clicked
    mark_scatter_px : error of a mark in a photo in one direction, one sigma; None without marks
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
    worth_adding: WorthAdding | None
    known: Known
    blunders: tuple[Blunder, ...]
    warnings: tuple[Finding, ...]
    covariance: tuple[tuple[float, ...], ...] = field(metadata=HIDDEN)
    centre: tuple[float, float, float] = field(metadata=HIDDEN)
    reach_m: float | None = field(default=None, metadata=HIDDEN)
    normal: tuple[float, float, float] | None = field(default=None, metadata=HIDDEN)
    without: tuple[Without, ...] = field(default=(), metadata=OPTIONAL)
    observations: tuple[ObservationGroup, ...] = field(default=(), metadata=HIDDEN)
    north_sigma_deg: float | None = None
    click_sigma_m: float | None = None
    mark_scatter_px: float | None = None

    def __call__(self, points: npt.ArrayLike) -> FloatArray:
        """(n, 3) World of model points (n, 3), or (3,) of one. Raises InputError."""
        m = self.matrix
        try:
            places = np.asarray(points, np.float64)
        except (TypeError, ValueError, OverflowError):
            places = np.empty(0)
        if not places.ndim or places.shape[-1] != 3 or not (np.abs(places) <= FARTHEST_M).all():
            raise InputError(
                Finding("points.invalid"),
                field="points",
            )
        return np.asarray(places @ m[:3, :3].T + m[:3, 3])
