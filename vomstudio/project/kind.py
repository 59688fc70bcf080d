"""Declaration of a kind of feature, which keeps other code independent of kinds.

Each kind is defined by one module in `project/kinds`. `get_kind` returns the kind of a feature; its
capabilities are read from its fields and never from the class of a record.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import to_translate as _
from vomstudio.project.figures import Figure, Subject
from vomstudio.project.measurement import Measurement, MeasurementContext, Records
from vomstudio.project.records import (
    DEFAULT_TYPES,
    Feature,
    FeatureType,
    PaintedFeature,
    Record,
    TypedFeature,
    get,
)

Evidence = Literal["", "picked", "read", "derived"]
"""Source of an orientation. Picks of a type are pooled (mean planes, fold axes), compass readings
are compared with them, and derived orientations are used for neither."""


BED_TYPE = "bedding"
NON_BED_TYPES = frozenset(each.id for each in DEFAULT_TYPES) - {BED_TYPE}
"""Ids of the predefined types whose features are not beds."""


Lookup = Callable[[str], Measurement | None]
"""Function that returns the measurement of another feature by its ID."""


@dataclass(frozen=True)
class Attribute:
    """Field of a record that the user may change.

    Attributes
    ----------
    field : str
        Name of the field.
    title : str
        Label next to the input.
    form : str
        Input form of the value. "lines" is text of several lines; "plane" is the ID of a feature;
        "word" is one of the choices or another word that was read from a file.
    choices : tuple of tuple of str
        Allowed values and their labels.
    text : str
        Label next to a flag.
    applies : callable
        Function that returns whether the attribute currently applies to a feature.
    """

    field: str
    title: str
    form: Literal["text", "lines", "type", "flag", "choice", "word", "plane"] = "text"
    choices: tuple[tuple[str, str], ...] = ()
    text: str = ""
    applies: Callable[[Any], bool] = lambda feature: True


NAME = Attribute("name", _("Name"))
TYPE = Attribute("type_id", _("Type"), "type")
SET = Attribute("set_name", _("Set"))
DOMAIN = Attribute("domain", _("Domain"))


def may_be_overturned(feature: Any) -> bool:
    """Return whether a feature may be an overturned bed.

    Faults, joints and the other predefined types have no younging direction; types that the user
    has added may be beds.

    Parameters
    ----------
    feature : Feature
        Feature with the field `overturned`.

    Returns
    -------
    bool
    """
    return feature.type_id not in NON_BED_TYPES or bool(feature.overturned)


OVERTURNED = Attribute(
    "overturned", _("Bed"), "flag", text=_("overturned"), applies=may_be_overturned
)
STATION = Attribute("station", _("Station"))
NOTES = Attribute("notes", _("Notes"), "lines")


@dataclass(frozen=True, eq=False)
class Sketch:
    """3-D drawing of a feature in the World frame.

    Attributes
    ----------
    line : (n, 3) float64
        Points that are connected in order; a single point for a feature that only has a position.
    anchor : (3,) float64
        Position of the label.
    sign : (3,) float64 or None
        Position of the orientation symbol, or None if no symbol is drawn.
    faces : PaintedFeature or None
        Part of a model that is painted instead of the line while the model is open.
    label : str or None
        Text next to the name, replacing the orientation.
    """

    line: FloatArray
    anchor: FloatArray
    sign: FloatArray | None = None
    faces: PaintedFeature | None = None
    label: str | None = None


@dataclass(frozen=True)
class NetAppearance:
    """Style of a kind on the stereonet.

    The kind forms its own sets, with `suffix` appended to their names, and uses `marker` instead of
    the marker of the feature type (unless `marker` is empty).
    """

    suffix: str = ""
    marker: str = ""


@dataclass(frozen=True, eq=False)
class GisLayer:
    """Layer of a kind in GIS and CAD files.

    Attributes
    ----------
    shape : callable
        Function that returns the points (n, 3) of a subject in the World frame, or None if it has
        no points; the first point of a ring is not repeated.
    figures : tuple of Figure
        Attributes of the layer; counts are stored as integers.
    sparse : bool
        Whether to omit figures that are empty for all features.
    by : str
        Name of the figure that determines the colours, if the layer contains it.
    main : bool
        Whether this is the main layer of a project. It is written even if it is empty, and its
        drawing layers are named by the feature types alone.
    """

    name: str
    geometry: Literal["point", "line", "ring"]
    shape: Callable[[Subject], FloatArray | None]
    figures: tuple[Figure, ...]
    sparse: bool = False
    main: bool = False
    by: str = "kind"


@dataclass(frozen=True)
class KindGroup:
    """Group for listing, showing and hiding features of a kind that has no feature types."""

    id: str
    title: str
    icon: str


def _no_lines(*_: Any) -> list[Any]:
    return []


def _no_headline(measurement: Measurement) -> str | None:
    return None


def _measured_points(subject: Subject) -> FloatArray:
    return subject.measured.points


@dataclass(frozen=True, eq=False)
class Kind:
    """Kind of feature.

    Attributes
    ----------
    name, order
        Name on disk; position among the kinds in lists and files.
    record, parts
        Class of the records; classes of the fields that are records themselves.
    title, icon, class_name
        Title and icon; function for the class name of a feature if it varies within the kind.
    measure
        Function that measures all new features of the kind in one batch.
    figures
        Figures of the kind.
    remarks, about
        Functions that return comments on the source, for the notes in files and for the window.
    words, headline
        Functions that return further lines of the fit panel, and its text in place of an
        orientation.
    orientations, evidence, plane
        Possible orientations; their source; for kinds that may have planes, a function that returns
        whether a feature has one.
    dependency_ids
        Function that returns the IDs of the features that a feature refers to, including deleted
        ones.
    dependencies
        Function that returns the features on which a feature depends; their measurements are passed
        to `measure`.
    has_dynamic_dependencies
        Whether any edit may change the dependencies.
    attributes, tool
        Attributes that the user may change; tool that creates and continues a feature.
    sketch
        Function that creates the 3-D drawing, given access to other measurements, or returns None
        if the position is unknown.
    net, layer
        Style on the stereonet; layer in files.
    group, color, tint
        Group of a kind without feature types; colour as #rrggbb, or "" for the colour of the
        feature type; function for the colour of a single feature instead of that of the kind, which
        may return "".
    prefix
        Word whose first letter begins the names of features without a type.
    places
        Function that returns the points (n, 3) in the World frame from which distances to other
        positions are measured.
    filled
        Whether the outline encloses a part of the surface that is also painted.
    listed, drawing_label
        Whether features are listed in the table of the window although they have no orientation;
        their label on a drawing in that case.
    """

    name: str
    order: int
    record: type[Feature]
    title: str
    icon: str
    measure: Callable[[MeasurementContext, Sequence[Any]], list[Measurement]]
    figures: tuple[Figure, ...]
    attributes: tuple[Attribute, ...]
    sketch: Callable[[Subject, Lookup], Sketch | None]
    parts: Mapping[str, type] = field(default_factory=dict)
    class_name: Callable[[Any], str] | None = None
    remarks: Callable[[Subject], list[str]] = _no_lines
    about: Callable[[Subject], list[str]] = _no_lines
    words: Callable[[Measurement], list[str]] = _no_lines
    headline: Callable[[Measurement], str | None] = _no_headline
    orientations: tuple[Literal["plane", "line"], ...] = ()
    evidence: Evidence = ""
    plane: Callable[[Any], bool] | None = None
    dependency_ids: Callable[[Any], Sequence[str]] = _no_lines
    dependencies: Callable[[Records, Any], Sequence[Feature]] = _no_lines
    has_dynamic_dependencies: bool = False
    tool: str = ""
    net: NetAppearance | None = None
    layer: GisLayer | None = None
    group: KindGroup | None = None
    color: str = ""
    tint: Callable[[Any], str] = lambda feature: ""
    prefix: Callable[[Any], str] = lambda feature: ""
    places: Callable[[Subject], FloatArray] = _measured_points
    listed: bool = False
    filled: bool = False
    drawing_label: Callable[[Any], str] = lambda feature: str(feature.name)

    @property
    def has_feature_type(self) -> bool:
        """Whether the features have one of the project's feature types."""
        return issubclass(self.record, TypedFeature)

    @property
    def type_geometry(self) -> Literal["plane", "line"] | None:
        """Geometry of the feature types that suit the features, or None if both geometries do."""
        if len(self.orientations) > 1:
            return None
        return "line" if self.orientations == ("line",) else "plane"

    @property
    def depends_on_features(self) -> bool:
        """Whether an edit of another feature may change features of this kind."""
        return self.has_dynamic_dependencies or self.dependency_ids is not _no_lines

    def noun(self, feature: Any) -> str:
        """Return the name of the class of a feature as a single word."""
        return self.name if self.class_name is None else self.class_name(feature)


_KINDS: dict[type[Any], Kind] = {}


def register(kind: Kind) -> None:
    """Register a kind. Called by `project/kinds` for each of its modules."""
    _KINDS[kind.record] = kind


def get_kind(feature: Feature) -> Kind:
    """Return the kind of a feature."""
    return _KINDS[type(feature)]


def get_color(feature: Feature, records: Records) -> str:
    """Return the colour of a feature as "#rrggbb", or "" if its feature type was removed."""
    kind = get_kind(feature)
    type_ = get(records, getattr(feature, "type_id", None), FeatureType)
    return kind.tint(feature) or kind.color or ("" if type_ is None else type_.color)


def has_plane(record: Record | None) -> bool:
    """Return whether a record is a feature with a plane."""
    plane = get_kind(record).plane if isinstance(record, Feature) else None
    return plane is not None and plane(record)


def may_have_plane(record: Record | None) -> bool:
    """Return whether a record is a feature of a kind that can have planes."""
    return isinstance(record, Feature) and get_kind(record).plane is not None


def select_plane_features(records: Records, ids: Sequence[str]) -> list[Feature]:
    """Return the features with these ids that may have a plane."""
    return [
        record
        for id_ in ids
        if isinstance(record := records.get(id_), Feature) and may_have_plane(record)
    ]


def is_picked_plane(record: Record | None) -> bool:
    """Return whether a record is a plane that was picked on a model."""
    return (
        isinstance(record, Feature)
        and (kind := get_kind(record)).plane is not None
        and kind.evidence == "picked"
    )


def visibility_group(feature: Feature) -> str:
    """Return the ID of the group with which a feature is hidden: its type or its kind."""
    if isinstance(feature, TypedFeature):
        return feature.type_id
    group = get_kind(feature).group
    return "" if group is None else group.id


def group_and_set(record: Record) -> tuple[str, str, bool] | None:
    """Return the group of a feature, its set, and whether it is a picked plane.

    The set is "" if there is none. Returns None for records that are not features.
    """
    if not isinstance(record, Feature):
        return None
    return visibility_group(record), str(getattr(record, "set_name", "")), is_picked_plane(record)


# --- drawing ---------------------------------------------------------------------------------
def midpoint(line: FloatArray) -> FloatArray:
    """Return the point (3,) halfway along a polyline."""
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    distances = np.concatenate([[0.0], np.cumsum(lengths)])
    return np.array([np.interp(0.5 * distances[-1], distances, line[:, i]) for i in range(3)])


def centre(measurement: Measurement) -> FloatArray:
    """Return the centre (3,) of the fitted plane, or of the points if no plane is fitted."""
    middle = (
        measurement.points.mean(axis=0) if measurement.fit is None else measurement.fit.centroid
    )
    return np.asarray(middle, float)


def get_line(subject: Subject) -> FloatArray | None:
    """Return the points of a subject, or None if they do not form a line."""
    points = subject.measured.points
    return points if len(points) > 1 else None


def always_true(feature: Any) -> bool:
    """Return True for every feature."""
    return True


def plane_ids(feature: Any) -> tuple[str, ...]:
    """Return the ID in the field `plane_id` of a feature as a tuple; empty if not set."""
    return (feature.plane_id,) if feature.plane_id else ()


def plane_dependencies(records: Records, feature: Any) -> list[Feature]:
    """Return the planes on which a feature depends."""
    return select_plane_features(records, plane_ids(feature))
