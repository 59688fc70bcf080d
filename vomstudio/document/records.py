"""The records of a project: frozen, plain, and in the frame of the file they were measured on.

Features hold float64 coordinates in their model's own file frame. World coordinates and fits follow
from (feature, model) and are never stored, so declaring or changing a frame is one edit of one
Model and moves everything with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Point = tuple[float, float, float]
Matrix = tuple[tuple[float, float, float, float], ...]

IDENTITY: Matrix = (
    (1.0, 0.0, 0.0, 0.0),
    (0.0, 1.0, 0.0, 0.0),
    (0.0, 0.0, 1.0, 0.0),
    (0.0, 0.0, 0.0, 1.0),
)

FrameKind = Literal["crs", "local", "scaled", "undeclared"]
UpAxis = Literal["z", "y"]


@dataclass(frozen=True)
class Frame:
    """What is known of a model's frame.

    kind: "crs" (World is the projected CRS `crs`), "local" (metres, up and north are known, the
    place is not), "scaled" (metres are known, up and north are not) or "undeclared" (no north, no
    up, no metre: angles are shown as local frame, lengths in units).
    unit_m: metres per unit of the file. up_axis: the file's axis that points up; with "y" the file
    is taken as x East, y Up, z South (glTF).
    """

    kind: FrameKind = "undeclared"
    crs: str | None = None
    unit_m: float = 1.0
    up_axis: UpAxis = "z"

    @property
    def has_north(self) -> bool:
        return self.kind in ("crs", "local")

    @property
    def has_metres(self) -> bool:
        return self.kind != "undeclared"

    def to_world(self) -> Matrix:
        """4x4 similarity from the file frame to World (x East, y North, z Up, metres)."""
        s = float(self.unit_m)
        if self.up_axis == "y":
            return (
                (s, 0.0, 0.0, 0.0),
                (0.0, 0.0, -s, 0.0),
                (0.0, s, 0.0, 0.0),
                (0.0, 0.0, 0.0, 1.0),
            )
        return (
            (s, 0.0, 0.0, 0.0),
            (0.0, s, 0.0, 0.0),
            (0.0, 0.0, s, 0.0),
            (0.0, 0.0, 0.0, 1.0),
        )

    def name(self) -> str:
        """In a few words, for badges and table headers."""
        if self.kind == "crs":
            return f"{self.crs}, grid north"
        if self.kind == "local":
            return "local, north known"
        if self.kind == "scaled":
            return "local frame in metres: not registered"
        return "local frame: not registered"


@dataclass(frozen=True)
class Model:
    """A model of the outcrop. `path` is relative to the project folder where it lies inside it or
    beside it on the same drive, else absolute; `content_hash` is the SHA-256 of the file."""

    id: str
    name: str
    path: str
    kind: Literal["mesh", "cloud"]
    content_hash: str
    frame: Frame = Frame()
    to_world: Matrix = IDENTITY


@dataclass(frozen=True)
class FeatureType:
    """What is measured: bedding, fault, joint ... `color` is #rrggbb, `symbol` a marker name,
    `geometry` what its features are by nature (a plane may all the same be drawn as its pole)."""

    id: str
    name: str
    color: str
    symbol: str = "circle"
    geometry: Literal["plane", "line"] = "plane"


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
Record = Model | FeatureType | Feature

FEATURES = (Trace, Patch, Lineation, Reading, Dimension, Intersection)
TYPED = (Trace, Patch, Lineation, Reading, Intersection)
ON_A_MODEL = (Trace, Patch, Lineation, Dimension)

# Okabe-Ito (2008), a set that colour-blind readers can tell apart.
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
