"""The figures of a fold axis, as plain numbers."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.findings import Finding
from vomstudio.geology.populations.distributions import LineFigures


@dataclass(frozen=True)
class BetaFigures:
    """A fold axis with the semi-axes of its joint 95 % region, degrees; as in `FoldAxis`. total95:
    with the registration."""

    trend_deg: float
    plunge_deg: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    confidence_direction_deg: float | None
    confidence_axis: LineFigures | None
    registration_error_deg: float | None
    total95_deg: float | None
    total95_min_deg: float | None
    total95_axis: LineFigures | None


@dataclass(frozen=True)
class PlaneFigures:
    """A plane by dip direction and dip, and by its right-hand-rule strike, degrees."""

    dip_direction_deg: float
    dip_deg: float
    strike_rhr_deg: float


@dataclass(frozen=True)
class LimbFigures:
    """Two limbs: their mean planes, how many planes each has, the angle between them on the side of
    the hinge with its 95 % error, and the plane that halves it with the larger half-angle of its
    joint 95 % region. overturned: whether each limb is; without flags neither is taken as such."""

    planes: tuple[PlaneFigures, PlaneFigures]
    n: tuple[int, int]
    interlimb_angle_deg: float
    axial_plane: PlaneFigures
    interlimb_error95_deg: float
    axial_plane_error95_deg: float
    overturned: tuple[bool, bool]


@dataclass(frozen=True)
class LeaveOneOut:
    """The plane without which beta would turn most: its place among those used (from 0), its id
    where it has one, by how much beta turns, and where to."""

    index: int
    id: str | None
    turn_deg: float
    trend_deg: float
    plunge_deg: float


@dataclass(frozen=True)
class Stray:
    """A plane that the verdict is not about: its place among those used (from 0), and its id where
    it has one."""

    index: int
    id: str | None = None


@dataclass(frozen=True)
class SmallCircleFigures:
    """A small circle: its axis, the angle between axis and poles, and the RMS."""

    trend_deg: float
    plunge_deg: float
    half_angle_deg: float
    rms_deg: float


@dataclass(frozen=True)
class ConeFigures:
    """The best cone: its axis, the angle between axis and poles (90 is a cylinder) with its 95 %
    half-width (None where the poles do not tell), RMS, and the chance of so much better a fit than
    the cylinder's where that is true. by_nearer_ends: the closer circle that is found if each pole
    may be used by either end, None if no circle is closer."""

    trend_deg: float
    plunge_deg: float
    half_angle_deg: float
    half_width95_deg: float | None
    rms_deg: float
    p: float
    by_nearer_ends: SmallCircleFigures | None


@dataclass(frozen=True)
class PairFigures:
    """Where the mean planes of two sets meet, the angle between them, and the semi-axes of the
    joint 95 % region of the line, None where a set has one plane."""

    sets: tuple[str, str]
    trend_deg: float
    plunge_deg: float
    angle_deg: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None


@dataclass(frozen=True)
class AxisFigures:
    """What is said of a fold axis, as in `FoldAxis`. within90_deg: nine tenths of the poles lie
    closer to the great circle"""

    beta: BetaFigures
    pi_plane: PlaneFigures
    eigenvalues: tuple[float, float, float]
    rms_deg: float
    within90_deg: float
    arc_deg: float
    cone: ConeFigures | None
    limbs: LimbFigures | None
    leave_one_out: LeaveOneOut | None
    strays: tuple[Stray, ...]
    pairs: tuple[PairFigures, ...]
    valid: str
    verdict: str
    reasons: tuple[Finding, ...]
