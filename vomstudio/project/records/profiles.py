"""Thresholds with which the planes and lines of a project are judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vomstudio.geology.profiles import Thresholds

PROFILE_ID = "verdict-profile"
"""ID of the profile; a project without a profile uses the thresholds of the program or user."""


@dataclass(frozen=True)
class VerdictProfile:
    """Thresholds with the name under which they are printed.

    Verdicts are derived from the profile and never stored, so selecting another profile is a single
    edit that judges all features again.
    """

    id: str
    limits: Thresholds

    @property
    def name(self) -> str:
        """Name of the profile."""
        return self.limits.profile


def get_limits(records: Mapping[str, Any], default: Thresholds) -> Thresholds:
    """Return the thresholds of the project's profile, or `default` if it has none."""
    profile = records.get(PROFILE_ID)
    return profile.limits if isinstance(profile, VerdictProfile) else default
