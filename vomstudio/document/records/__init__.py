"""The records of a project: frozen, plain, and in the frame of the file they were measured on.

Features hold float64 coordinates in their model's own file frame. World coordinates and fits follow
from (feature, model) and are never stored, so declaring or changing a frame is one edit of one
Model and moves everything with it. The record of each kind of feature is in `document/kinds`.
"""

from __future__ import annotations

from vomstudio.document.records.compasses import Compass, compass_id
from vomstudio.document.records.face_grids import FaceGrid
from vomstudio.document.records.feature_types import DEFAULT_TYPES, FeatureType
from vomstudio.document.records.features import (
    SURROUNDINGS_RULE,
    Feature,
    Group,
    Logged,
    OnAModel,
    Painted,
    Picked,
    Repeatable,
    Surrounded,
    Typed,
    get,
    get_feature,
)
from vomstudio.document.records.models import Model
from vomstudio.document.records.photos import (
    Asset,
    ImageMark,
    MarkedPoint,
    Mask,
    PhotoSet,
    Reconstruction,
)
from vomstudio.document.records.profiles import PROFILE_ID, VerdictProfile, limits_of
from vomstudio.geometry.frames import UNDECLARED, Frame, FrameKind, UpAxis
from vomstudio.geometry.matrices import IDENTITY, Matrix, Point
from vomstudio.geometry.registrations import (
    NorthKind,
    ObservationGroup,
    ReadNorth,
    Registration,
    RegistrationPoint,
)

Resting = PhotoSet | Mask | MarkedPoint | ImageMark | Reconstruction | Registration
"""What models rest on."""
Record = Model | FeatureType | VerdictProfile | FaceGrid | Compass | Resting | Feature

__all__ = [
    "DEFAULT_TYPES",
    "IDENTITY",
    "PROFILE_ID",
    "SURROUNDINGS_RULE",
    "UNDECLARED",
    "Asset",
    "Compass",
    "FaceGrid",
    "Feature",
    "FeatureType",
    "Frame",
    "FrameKind",
    "Group",
    "ImageMark",
    "Logged",
    "MarkedPoint",
    "Mask",
    "Matrix",
    "Model",
    "NorthKind",
    "ObservationGroup",
    "OnAModel",
    "Painted",
    "PhotoSet",
    "Picked",
    "Point",
    "ReadNorth",
    "Reconstruction",
    "Record",
    "Registration",
    "RegistrationPoint",
    "Repeatable",
    "Resting",
    "Surrounded",
    "Typed",
    "UpAxis",
    "VerdictProfile",
    "compass_id",
    "get",
    "get_feature",
    "limits_of",
]
