"""By which limits the planes and lines of a project are judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vomstudio.geology.profiles import Thresholds

PROFILE_ID = "verdict-profile"
"""A project has one at most; without it, the limits of the program or user hold."""


@dataclass(frozen=True)
class VerdictProfile:
    """limits : with the name under which they are printed. What a verdict says follows from it and
    is never stored, so that choosing another is one edit that judges everything anew."""

    id: str
    limits: Thresholds

    @property
    def name(self) -> str:
        """Of the profile."""
        return self.limits.profile


def limits_of(records: Mapping[str, Any], otherwise: Thresholds) -> Thresholds:
    """Those of the project's profile, else `otherwise`."""
    profile = records.get(PROFILE_ID)
    return profile.limits if isinstance(profile, VerdictProfile) else otherwise
