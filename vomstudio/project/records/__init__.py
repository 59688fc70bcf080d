"""Records of a project: frozen, plain data in the frame of the measured file.

Features contain float64 coordinates in the file frame of their model. World coordinates and fits
are computed from feature and model and never stored, so declaring or changing a frame is a single
edit of one Model that moves all its features. The record of each kind of feature is in
`project/kinds`.
"""

from __future__ import annotations

from vomstudio.geometry.registrations import Registration
from vomstudio.project.records.compasses import Compass, compass_id
from vomstudio.project.records.face_grids import FaceGrid
from vomstudio.project.records.feature_types import DEFAULT_TYPES, FeatureType
from vomstudio.project.records.features import (
    SURROUNDINGS_RULE,
    Feature,
    Group,
    LoggedFeature,
    ModelFeature,
    PaintedFeature,
    PickedFeature,
    RepeatableFeature,
    SurfaceFeature,
    TypedFeature,
    get,
    get_feature,
)
from vomstudio.project.records.models import Model
from vomstudio.project.records.photos import (
    Asset,
    ImageMark,
    MarkedPoint,
    Mask,
    PhotoSet,
    ReconstructionRecord,
)
from vomstudio.project.records.profiles import PROFILE_ID, VerdictProfile, get_limits

PhotoRecord = PhotoSet | Mask | MarkedPoint | ImageMark | ReconstructionRecord | Registration
"""Records on which photo models depend."""
Record = Model | FeatureType | VerdictProfile | FaceGrid | Compass | PhotoRecord | Feature

__all__ = [
    "DEFAULT_TYPES",
    "PROFILE_ID",
    "SURROUNDINGS_RULE",
    "Asset",
    "Compass",
    "FaceGrid",
    "Feature",
    "FeatureType",
    "Group",
    "ImageMark",
    "LoggedFeature",
    "MarkedPoint",
    "Mask",
    "Model",
    "ModelFeature",
    "PaintedFeature",
    "PhotoRecord",
    "PhotoSet",
    "PickedFeature",
    "ReconstructionRecord",
    "Record",
    "RepeatableFeature",
    "SurfaceFeature",
    "TypedFeature",
    "VerdictProfile",
    "compass_id",
    "get",
    "get_feature",
    "get_limits",
]
