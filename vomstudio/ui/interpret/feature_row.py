"""One feature with its figures, as table, tree and filter look at it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from vomstudio.document.comparison import NearestPick
from vomstudio.document.measurements import Measurement
from vomstudio.document.records import Dimension, Feature, FeatureType, Reading
from vomstudio.ui.common.studio import Studio


@dataclass(frozen=True, eq=False)
class Row:
    """kind : None for a dimension. notation : in which its orientation is written."""

    feature: Feature
    kind: FeatureType | None
    measured: Measurement
    notation: str
    nearest: Callable[[], NearestPick | None] = lambda: None
    """Of a compass reading: asked for when shown, since it rests on the other rows."""

    @property
    def type_name(self) -> str:
        return self.kind.name if self.kind else ""

    @property
    def class_name(self) -> str:
        """trace, patch, lineation, reading, intersection; the kind of a dimension."""
        if isinstance(self.feature, Dimension):
            return self.feature.kind
        return type(self.feature).__name__.lower()

    @property
    def set_name(self) -> str:
        return str(getattr(self.feature, "set_name", ""))

    @property
    def overturned(self) -> bool | None:
        """None where it cannot be."""
        value = getattr(self.feature, "overturned", None)
        return None if value is None else bool(value)

    @property
    def azimuth(self) -> float | None:
        """Dip direction of a plane, trend of a line."""
        if self.measured.plane is not None:
            return self.measured.plane.dip_direction_deg
        return None if self.measured.line is None else self.measured.line.trend_deg

    @property
    def dip(self) -> float | None:
        return None if self.measured.plane is None else self.measured.plane.dip_deg

    @property
    def dip_direction(self) -> float | None:
        return None if self.measured.plane is None else self.measured.plane.dip_direction_deg

    @property
    def strike(self) -> float | None:
        return None if self.measured.plane is None else self.measured.plane.strike_rhr_deg

    @property
    def trend(self) -> float | None:
        return None if self.measured.line is None else self.measured.line.trend_deg

    @property
    def plunge(self) -> float | None:
        return None if self.measured.line is None else self.measured.line.plunge_deg

    @property
    def rake(self) -> float | None:
        slip = self.measured.slip_rake_deg
        return self.measured.rake_deg if slip is None else slip

    def fit(self, name: str) -> Any:
        return None if self.measured.fit is None else getattr(self.measured.fit, name)

    @property
    def quality(self) -> str | None:
        return self.measured.verdict.quality if self.measured.verdict else None

    @property
    def reasons(self) -> str:
        if self.measured.verdict is None:
            return self.measured.problem or ""
        return "; ".join(self.measured.verdict.reasons)

    @property
    def to_pick(self) -> float | None:
        found = self.nearest()
        return None if found is None else found.angle_deg

    @property
    def ratio(self) -> float | None:
        extent, resolution = self.fit("extent"), self.measured.resolution_m
        return extent / resolution if extent and resolution else None


def row_of(studio: Studio, feature: Feature, measured: Measurement) -> Row:
    kind = studio.records.get(getattr(feature, "type_id", ""))
    return Row(
        feature,
        kind if isinstance(kind, FeatureType) else None,
        measured,
        studio.settings.notation,
        partial(studio.nearest_pick, feature.id) if isinstance(feature, Reading) else lambda: None,
    )
