"""The records of a project: frozen, plain, and in the frame of the file they were measured on.

Features hold float64 coordinates in their model's own file frame. World coordinates and fits follow
from (feature, model) and are never stored, so declaring or changing a frame is one edit of one
Model and moves everything with it.
"""

from __future__ import annotations

from vomstudio.document.records.basics import IDENTITY, Matrix, Point
from vomstudio.document.records.features import (
    FEATURES,
    ON_A_MODEL,
    TYPED,
    Dimension,
    DimensionKind,
    Feature,
    Group,
    Intersection,
    Lineation,
    Patch,
    Reading,
    SlipSense,
    Trace,
    Typed,
)
from vomstudio.document.records.frames import UNDECLARED, Frame, FrameKind, UpAxis
from vomstudio.document.records.models import Model
from vomstudio.document.records.photos import (
    Asset,
    ImageMark,
    MarkedPoint,
    Mask,
    PhotoSet,
    Reconstruction,
)
from vomstudio.document.records.registrations import Registration
from vomstudio.document.records.types import DEFAULT_TYPES, FeatureType

Resting = PhotoSet | Mask | MarkedPoint | ImageMark | Reconstruction | Registration
"""What models rest on."""
Record = Model | FeatureType | Resting | Feature

__all__ = [
    "DEFAULT_TYPES",
    "FEATURES",
    "IDENTITY",
    "ON_A_MODEL",
    "TYPED",
    "UNDECLARED",
    "Asset",
    "Dimension",
    "DimensionKind",
    "Feature",
    "FeatureType",
    "Frame",
    "FrameKind",
    "Group",
    "ImageMark",
    "Intersection",
    "Lineation",
    "MarkedPoint",
    "Mask",
    "Matrix",
    "Model",
    "Patch",
    "PhotoSet",
    "Point",
    "Reading",
    "Reconstruction",
    "Record",
    "Registration",
    "Resting",
    "SlipSense",
    "Trace",
    "Typed",
    "UpAxis",
]
