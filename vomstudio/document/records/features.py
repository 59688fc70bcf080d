"""The features: what is measured on a model, or in the field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.document.records.basics import Point


@dataclass(frozen=True)
class Trace:
    """A digitised line where a surface meets the outcrop.

    vertices: in order, model file frame. resolution: mean spacing of the model's vertices or points
    around the pick, in file units, None where unknown. outcrop_normal: unit normal of the outcrop
    face around the trace, file frame, None where unknown.
    """

    id: str
    name: str
    type_id: str
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    resolution: float | None = None
    outcrop_normal: Point | None = None
    set_name: str = ""
    overturned: bool = False
    notes: str = ""
    method: Literal["pca", "regression"] = "pca"


@dataclass(frozen=True)
class Patch:
    """A piece of the outcrop face chosen as one surface: a joint, an exposed bed.

    element: what the ids name. runs: the sorted ids of the model's faces or points, as (first,
    count). n, mean, scatter, n_effective: moments of their points in the file frame
    (geometry/patches.py), so that the plane survives a missing model. outline: ring of points of
    the patch, as seen along its normal. area: of the faces, in file units squared, None for points.
    Other fields as in Trace.
    """

    id: str
    name: str
    type_id: str
    model_id: str
    model_hash: str
    element: Literal["face", "point"]
    runs: tuple[tuple[int, int], ...]
    n: int
    mean: Point
    scatter: tuple[Point, Point, Point]
    n_effective: float
    outline: tuple[Point, ...] = ()
    area: float | None = None
    resolution: float | None = None
    set_name: str = ""
    overturned: bool = False
    notes: str = ""


SlipSense = Literal["", "normal", "reverse", "sinistral", "dextral"]


@dataclass(frozen=True)
class Lineation:
    """A line on the outcrop: a striation, a hinge, a mineral lineation; two vertices or more.

    plane_id: the feature on whose plane it lies, "" for none: its direction is then projected onto
    that plane and has a rake. slip: how the hanging wall moved along it. Other fields as in Trace.
    """

    id: str
    name: str
    type_id: str
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    resolution: float | None = None
    plane_id: str = ""
    slip: SlipSense = ""
    set_name: str = ""
    notes: str = ""


@dataclass(frozen=True)
class Reading:
    """An orientation measured in the field with a compass, relative to grid north.

    A plane's azimuth_deg and inclination_deg are dip direction and dip, a line's are trend and
    plunge. turned_deg: what was added to the azimuth as it was read (declination less convergence).
    position: World, None where it was not noted. source: the file it came from.
    """

    id: str
    name: str
    type_id: str
    geometry: Literal["plane", "line"]
    azimuth_deg: float
    inclination_deg: float
    turned_deg: float = 0.0
    position: Point | None = None
    source: str = ""
    set_name: str = ""
    overturned: bool = False
    notes: str = ""


DimensionKind = Literal["distance", "polyline", "area", "thickness"]


@dataclass(frozen=True)
class Dimension:
    """A length, an area, or a distance at right angles to the plane of the feature `plane_id`."""

    id: str
    name: str
    kind: DimensionKind
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    plane_id: str = ""
    notes: str = ""


@dataclass(frozen=True)
class Group:
    """Planes meant together: the feature `feature_id`, else all of a type and, where `set_name` is
    not empty, of that set."""

    feature_id: str = ""
    type_id: str = ""
    set_name: str = ""


@dataclass(frozen=True)
class Intersection:
    """Where the (mean) planes of two groups meet."""

    id: str
    name: str
    type_id: str
    first: Group
    second: Group
    set_name: str = ""
    notes: str = ""


Feature = Trace | Patch | Lineation | Reading | Dimension | Intersection
Typed = Trace | Patch | Lineation | Reading | Intersection

FEATURES = (Trace, Patch, Lineation, Reading, Dimension, Intersection)
TYPED = (Trace, Patch, Lineation, Reading, Intersection)
ON_A_MODEL = (Trace, Patch, Lineation, Dimension)
