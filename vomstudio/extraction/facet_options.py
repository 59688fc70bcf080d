"""Options of the facet search, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import MAX_LENGTH_M, MIN_LENGTH_M, Options, check_exclusive, option
from vomstudio.core.words import to_translate

DEFAULT_ANGLE_DEG = 20.0
DEFAULT_MIN_POINTS = 50
DSE_ANGLE_DEG = 30.0
DSE_MIN_POINTS = 100
MAX_POINTS = 2**31 - 1


@dataclass(frozen=True)
class FacetOptions(Options):
    """Thresholds of the facet search; None selects a value automatically.

    Raises
    ------
    UsageError
        If a value is outside its bounds, or if a distance is combined with the preset ``dse``.
    """

    angle_deg: float | None = option(
        None,
        minimum=1.0,
        maximum=89.0,
        label=to_translate("Angle"),
        help=to_translate("maximum angle between the normals of a point and its facet"),
        tip=to_translate("Maximum angle between the normals of a point and its facet"),
        automatic_text=to_translate("20, or 30 with --preset dse"),
        decimals=0,
    )
    max_distance_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Distance"),
        help=to_translate("maximum distance from the facet's plane, m"),
        tip=to_translate("Maximum distance from the facet's plane"),
        automatic_text=to_translate("local spacing, or three times the local noise if larger"),
    )
    min_points: int | None = option(
        None,
        minimum=3,
        maximum=MAX_POINTS,
        label=to_translate("Points"),
        help=to_translate("minimum number of points in a facet"),
        tip=to_translate("Minimum number of points in a facet"),
        automatic_text=to_translate("50; on a mesh, 1 % of its area; 100 with --preset dse"),
    )
    min_area_m2: float | None = option(
        None,
        minimum=0.0,
        label=to_translate("Area"),
        help=to_translate("minimum area of a facet, m²"),
        tip=to_translate("Minimum area of a facet"),
        automatic_text=to_translate("any area"),
    )
    min_coplanarity: float | None = option(
        None,
        minimum=0.0,
        label=to_translate("Coplanarity"),
        help=to_translate("minimum coplanarity (1 / smallest normalised eigenvalue)"),
        tip=to_translate("Minimum coplanarity (1 / smallest normalised eigenvalue)"),
        automatic_text=to_translate("from the verdict profile"),
        decimals=0,
    )
    propose_sets: bool = option(
        False, help=to_translate("propose sets among the planes of the facets")
    )
    preset: Literal["dse"] | None = option(
        None,
        help=to_translate(
            "dse: find sets from the point normals, then the planes of each set, as the"
            " Discontinuity Set Extractor does; --angle is then the half-angle of the cone about"
            " the pole of a set"
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_exclusive(self, "max_distance_m", "preset")

    @property
    def used_angle_deg(self) -> float:
        """Effective angle in degrees: the given angle, or the default of the preset."""
        default = DEFAULT_ANGLE_DEG if self.preset is None else DSE_ANGLE_DEG
        return default if self.angle_deg is None else self.angle_deg

    @property
    def used_min_points(self) -> int:
        """Effective minimum number of points: the given number, or the default of the preset."""
        default = DEFAULT_MIN_POINTS if self.preset is None else DSE_MIN_POINTS
        return default if self.min_points is None else self.min_points
