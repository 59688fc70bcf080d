"""Figures of a fold axis as plain numbers."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.findings import Finding
from vomstudio.geology.populations.distributions import LineAttitude


@dataclass(frozen=True)
class BetaFigures:
    """Fold axis with the semi-axes of its joint 95 % region, degrees. See `FoldAxis`.

    The attributes that start with `total95` include the registration.
    """

    trend_deg: float
    plunge_deg: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    confidence_direction_deg: float | None
    confidence_axis: LineAttitude | None
    registration_error_deg: float | None
    total95_deg: float | None
    total95_min_deg: float | None
    total95_axis: LineAttitude | None


@dataclass(frozen=True)
class PlaneAttitude:
    """Plane given by dip direction, dip and right-hand-rule strike, degrees."""

    dip_direction_deg: float
    dip_deg: float
    strike_rhr_deg: float


@dataclass(frozen=True)
class LimbFigures:
    """Limbs of a fold.

    Attributes
    ----------
    planes : (PlaneAttitude, PlaneAttitude)
        Mean planes of the limbs.
    n : (int, int)
        Number of planes in each limb.
    interlimb_angle_deg, interlimb_error95_deg : float
        Angle between the limbs on the inner side of the fold, with its 95 % error, degrees.
    axial_plane, axial_plane_error95_deg
        Bisecting plane, with the larger half-angle of its joint 95 % region, degrees.
    overturned : (bool, bool)
        Whether each limb is overturned; False if the planes have no such flags.
    """

    planes: tuple[PlaneAttitude, PlaneAttitude]
    n: tuple[int, int]
    interlimb_angle_deg: float
    axial_plane: PlaneAttitude
    interlimb_error95_deg: float
    axial_plane_error95_deg: float
    overturned: tuple[bool, bool]


@dataclass(frozen=True)
class InfluentialPlane:
    """Plane whose omission rotates beta most.

    Attributes
    ----------
    index : int
        Index among the planes used, from 0.
    id : str or None
    turn_deg, trend_deg, plunge_deg : float
        Rotation of beta caused by the omission, and beta without this plane, degrees.
    """

    index: int
    id: str | None
    turn_deg: float
    trend_deg: float
    plunge_deg: float


@dataclass(frozen=True)
class OutlyingPlane:
    """Outlying plane excluded from the verdict: its index among the planes used, and its id.

    Indices start at 0.
    """

    index: int
    id: str | None = None


@dataclass(frozen=True)
class SmallCircleFigures:
    """Small circle: axis, angle between axis and poles, and RMS angle, degrees."""

    trend_deg: float
    plunge_deg: float
    half_angle_deg: float
    rms_deg: float


@dataclass(frozen=True)
class ConeFigures:
    """Best-fit cone of the poles.

    Attributes
    ----------
    half_angle_deg : float
        Angle between the axis and the poles, degrees; 90 for a cylinder.
    half_width95_deg : float or None
        Half-width of the 95 % interval of this angle, degrees; None if the poles do not determine
        it.
    p : float
        p-value of the cylinder tested against the cone.
    by_nearer_ends : SmallCircleFigures or None
        Closer circle if either end of a pole may be used; None if no such circle is closer.
    """

    trend_deg: float
    plunge_deg: float
    half_angle_deg: float
    half_width95_deg: float | None
    rms_deg: float
    p: float
    by_nearer_ends: SmallCircleFigures | None


@dataclass(frozen=True)
class PairIntersection:
    """Intersection line of the mean planes of two sets.

    Attributes
    ----------
    angle_deg : float
        Angle between the planes, degrees.
    max_confidence95_deg, min_confidence95_deg : float or None
        Semi-axes of the joint 95 % region of the line, degrees; None if a set has only one plane.
    """

    sets: tuple[str, str]
    trend_deg: float
    plunge_deg: float
    angle_deg: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None


@dataclass(frozen=True)
class AxisFigures:
    """Figures of a fold axis. See `FoldAxis`.

    90 % of the poles lie within `within90_deg` of the great circle.
    """

    beta: BetaFigures
    pi_plane: PlaneAttitude
    eigenvalues: tuple[float, float, float]
    rms_deg: float
    within90_deg: float
    arc_deg: float
    cone: ConeFigures | None
    limbs: LimbFigures | None
    leave_one_out: InfluentialPlane | None
    strays: tuple[OutlyingPlane, ...]
    pairs: tuple[PairIntersection, ...]
    valid: str
    verdict: str
    reasons: tuple[Finding, ...]
