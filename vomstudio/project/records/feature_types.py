"""Types of features, with their meaning and display style."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class FeatureType:
    """Type of feature, such as bedding, fault or joint.

    `color` is #rrggbb, `symbol` is a marker name, and `geometry` states whether the features are
    planes or lines (a plane may still be drawn as its pole).
    """

    id: str
    name: str
    color: str
    symbol: str = "circle"
    geometry: Literal["plane", "line"] = "plane"


# Okabe-Ito (2008), a palette that colour-blind readers can distinguish.
DEFAULT_TYPES: tuple[FeatureType, ...] = (
    FeatureType("bedding", "Bedding", "#0072b2", "circle"),
    FeatureType("fault", "Fault", "#d55e00", "square"),
    FeatureType("joint", "Joint", "#009e73", "triangle"),
    FeatureType("vein", "Vein", "#cc79a7", "diamond"),
    FeatureType("foliation", "Foliation", "#56b4e9", "pentagon"),
    FeatureType("contact", "Contact", "#e69f00", "star"),
    FeatureType("fold_axis", "Fold axis", "#999999", "circle", "line"),
    FeatureType("lineation", "Lineation", "#f0e442", "square", "line"),
)
