"""Threshold profiles for the verdicts on planes and lines.

This module is separate from the verdicts, which require NumPy, because a project selects its
profile before anything is measured.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from vomstudio.core.words import tr


@dataclass(frozen=True)
class Thresholds:
    """Thresholds of a verdict.

    The textbook (section 4.1) gives only two limits, in section 4.1.3.

    Attributes
    ----------
    good_confidence95_deg, poor_confidence95_deg : float
        Maximum error of a good plane, and error above which a plane is poor (own choice): two
        geologists who measure the same bed with a compass differ by about 5 degrees; beyond 15
        degrees, a plane is of little value for a structural analysis.
    good_M, good_K : float
        Lower limit of M = ln(l1 / l3) and upper limit of K = ln(l1 / l2) / ln(l2 / l3), as quoted
        in later work and in published plane-fitting programs after O. Fernandez (2005), Obtaining a
        best fitting plane through 3D georeferenced data, J. Struct. Geol. 27, 855-858 (the paper
        itself was not available).
    extent_over_resolution : float
        Minimum ratio of the extent of a feature to the point spacing of the model, two orders of
        magnitude (textbook 4.1.3).
    least_extent_over_resolution : float
        Lower limit of the same ratio; below it, errors are not reliable.
    surface_effect_deg : float
        Angle between plane and outcrop face within which a trace may follow the face (own
        choice).
    profile : str
        Name of this profile, printed with every verdict.
    by : {"error", "shape"}
        Criterion of the verdict: the total error, or the coplanarity, collinearity (eqs. 20 and 21)
        and relative extent of the textbook as hard limits.
    least_coplanarity, most_collinearity : float
        Limits of coplanarity and collinearity (own choice): the values for M = 4 and K = 0.8.
    """

    good_confidence95_deg: float = 5.0
    poor_confidence95_deg: float = 15.0
    good_M: float = 4.0  # noqa: N815 - the name the literature uses
    good_K: float = 0.8  # noqa: N815
    extent_over_resolution: float = 100.0
    least_extent_over_resolution: float = 10.0
    surface_effect_deg: float = 10.0
    profile: str = "error"
    by: Literal["error", "shape"] = "error"
    least_coplanarity: float = 65.0
    most_collinearity: float = 6.0

    def __post_init__(self) -> None:
        """Validate the thresholds, or raise TypeError."""
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type == "float" and (
                isinstance(value, bool) or not isinstance(value, int | float)
            ):
                raise TypeError(f"{field.name} is not a number")
        if self.by not in ("error", "shape") or not isinstance(self.profile, str):
            raise TypeError("by or profile is unknown")

    @property
    def description(self) -> str:
        """Description of the profile and its limits, printed together with verdicts."""
        if self.by == "shape":
            return tr(
                "Verdicts by the profile “{profile}”: good if coplanarity is at least"
                " {coplanarity:g}, collinearity at most {collinearity:g} and extent at least"
                " {extent:g} times the model's resolution; doubtful if one of these fails, or a"
                " trace with little relief lies within {face:g}° of the outcrop face; poor if"
                " more fail.",
                profile=self.profile,
                coplanarity=self.least_coplanarity,
                collinearity=self.most_collinearity,
                extent=self.extent_over_resolution,
                face=self.surface_effect_deg,
            )
        return tr(
            "Verdicts by the profile “{profile}”: good up to a total 95 % error of {good:g}°,"
            " poor above {poor:g}°, doubtful in between. Also doubtful: fewer than 6 independent"
            " points, roughness with a wavelength as long as the trace, an extent under {extent:g}"
            " times the model's resolution, or little relief within {face:g}° of the outcrop face.",
            profile=self.profile,
            good=self.good_confidence95_deg,
            poor=self.poor_confidence95_deg,
            extent=self.least_extent_over_resolution,
            face=self.surface_effect_deg,
        )


DEFAULT_THRESHOLDS = Thresholds()
TEXTBOOK_THRESHOLDS = Thresholds(profile="textbook", by="shape")
PROFILES_BY_NAME = {
    profile.profile: profile for profile in (DEFAULT_THRESHOLDS, TEXTBOOK_THRESHOLDS)
}
"""Built-in profiles by name."""
