"""What a kind of feature says of itself, so that nothing else need know which kinds there are.

A kind is one module of `project/kinds`. It is asked for with `kind_of`; what it can do is read off
its fields, never off the class of a record.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import to_translate as _
from vomstudio.project.figures import Figure, Subject
from vomstudio.project.measurement import Measurement, Measuring, Records
from vomstudio.project.records import Feature, FeatureType, Painted, Record, Typed, get

Evidence = Literal["", "picked", "read", "derived"]
"""Where an orientation comes from. Picks of a type are pooled (mean planes, fold axes), what was
read with a compass is compared with them, and what is derived from them is neither."""


Lookup = Callable[[str], Measurement | None]
"""The measurement of another feature by its id."""


@dataclass(frozen=True)
class Attribute:
    """A field of a record that the user may change.

    field: its name. title: beside it. form: how it is put in; a plane is the id of a feature, a
    word one of the choices, or another that came from a file. choices: value and words. text:
    beside a flag. applies: whether a feature has it at present.
    """

    field: str
    title: str
    form: Literal["text", "type", "flag", "choice", "word", "plane"] = "text"
    choices: tuple[tuple[str, str], ...] = ()
    text: str = ""
    applies: Callable[[Any], bool] = lambda feature: True


NAME = Attribute("name", _("Name"))
TYPE = Attribute("type_id", _("Type"), "type")
SET = Attribute("set_name", _("Set"))
DOMAIN = Attribute("domain", _("Domain"))
OVERTURNED = Attribute("overturned", _("Bed"), "flag", text=_("overturned"))
NOTES = Attribute("notes", _("Notes"))


@dataclass(frozen=True, eq=False)
class Sketch:
    """How a feature is drawn in 3-D, in World.

    line : (n, 3) points joined in order; one point where it only has a place
    anchor : (3,) where it is named
    sign : (3,) where the symbol of its attitude stands, None for none
    faces : the piece of a model that is painted instead of the line while the model is open
    label : in place of its orientation beside the name
    """

    line: FloatArray
    anchor: FloatArray
    sign: FloatArray | None = None
    faces: Painted | None = None
    label: str | None = None


@dataclass(frozen=True)
class NetLook:
    """How a kind stands on the net: in sets of its own with these words after their name, and this
    marker in place of the type's ("" for the type's)."""

    suffix: str = ""
    marker: str = ""


@dataclass(frozen=True, eq=False)
class GisLayer:
    """The layer of a kind in GIS and CAD files.

    shape : (n, 3) World of a subject, None where it has none; of a ring the first point is not
        repeated
    figures : its attributes; counts are whole numbers here
    sparse : figures that no feature has are left out
    by : the figure by whose words features have their colours, where there is such a figure
    main : of what a project is mostly made of. It is there even where it is empty, and in a drawing
        it has the names of the feature types for itself
    """

    name: str
    geometry: Literal["point", "line", "ring"]
    shape: Callable[[Subject], FloatArray | None]
    figures: tuple[Figure, ...]
    sparse: bool = False
    main: bool = False
    by: str = "kind"


@dataclass(frozen=True)
class OwnGroup:
    """Where features are listed, shown and hidden together that have no feature type."""

    id: str
    title: str
    icon: str


def _nothing(*_: Any) -> list[Any]:
    return []


def _no_text(measured: Measurement) -> str | None:
    return None


def _own_points(subject: Subject) -> FloatArray:
    return subject.measured.points


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of feature.

    name : on disk; order : among the kinds, in lists and files
    record : its class; parts : classes of its fields that are records themselves
    title, icon : in words and as a sign; class_name : what a feature is called, where that differs
        from feature to feature
    measure : all features of the kind that are new, in one batch
    figures : which it has
    remarks, about : where it comes from, in the notes of files and in the window
    words, headline : what the fit panel says besides, and in place of an orientation
    orientations : which it may have; evidence : where they come from; plane : of a kind that may
        have planes, whether a feature has one
    names : the ids of the features that another is told to rest on, gone ones among them
    below : the features that it rests on; its measurement is given theirs
    regroups : what it rests on may change with any edit
    attributes : what may be changed; tool : with which it is made and continued
    sketch : in 3-D, with a look at what else is measured; None where it has no place
    net, layer : on the net, in files
    group : of a kind without feature type; color : #rrggbb, "" for its type's; tint : of one
        feature in place of the kind's colour, "" for that
    prefix : the word with whose first letter an untyped feature is named
    places : (n, 3) World, by which its distance from another place is told
    filled : its outline encloses a part of the surface, which is painted too
    listed : it stands in the window's table although it has no orientation; written : what is
        then written beside it on a drawing
    """

    name: str
    order: int
    record: type[Feature]
    title: str
    icon: str
    measure: Callable[[Measuring, Sequence[Any]], list[Measurement]]
    figures: tuple[Figure, ...]
    attributes: tuple[Attribute, ...]
    sketch: Callable[[Subject, Lookup], Sketch | None]
    parts: Mapping[str, type] = field(default_factory=dict)
    class_name: Callable[[Any], str] | None = None
    remarks: Callable[[Subject], list[str]] = _nothing
    about: Callable[[Subject], list[str]] = _nothing
    words: Callable[[Measurement], list[str]] = _nothing
    headline: Callable[[Measurement], str | None] = _no_text
    orientations: tuple[Literal["plane", "line"], ...] = ()
    evidence: Evidence = ""
    plane: Callable[[Any], bool] | None = None
    names: Callable[[Any], Sequence[str]] = _nothing
    below: Callable[[Records, Any], Sequence[Feature]] = _nothing
    regroups: bool = False
    tool: str = ""
    net: NetLook | None = None
    layer: GisLayer | None = None
    group: OwnGroup | None = None
    color: str = ""
    tint: Callable[[Any], str] = lambda feature: ""
    prefix: Callable[[Any], str] = lambda feature: ""
    places: Callable[[Subject], FloatArray] = _own_points
    listed: bool = False
    filled: bool = False
    written: Callable[[Any], str] = lambda feature: str(feature.name)

    @property
    def typed(self) -> bool:
        """Its features have one of the project's feature types."""
        return issubclass(self.record, Typed)

    @property
    def rests_on_features(self) -> bool:
        """Its features may look different after an edit of another feature."""
        return self.regroups or self.names is not _nothing

    def called(self, feature: Any) -> str:
        """What one of its features is, in a word."""
        return self.name if self.class_name is None else self.class_name(feature)


_KINDS: dict[type[Any], Kind] = {}


def register(kind: Kind) -> None:
    """Called by `project/kinds` for each kind it finds."""
    _KINDS[kind.record] = kind


def kind_of(feature: Feature) -> Kind:
    return _KINDS[type(feature)]


def color_of(feature: Feature, records: Records) -> str:
    """The colour of a feature, "#rrggbb"; "" where its feature type is gone."""
    kind = kind_of(feature)
    type_ = get(records, getattr(feature, "type_id", None), FeatureType)
    return kind.tint(feature) or kind.color or ("" if type_ is None else type_.color)


def has_plane(record: Record | None) -> bool:
    """A feature that is a plane, or has one."""
    plane = kind_of(record).plane if isinstance(record, Feature) else None
    return plane is not None and plane(record)


def may_have_plane(record: Record | None) -> bool:
    """A feature of a kind of which there are planes."""
    return isinstance(record, Feature) and kind_of(record).plane is not None


def planes_among(records: Records, ids: Sequence[str]) -> list[Feature]:
    """The features of these ids that may have a plane."""
    return [r for id_ in ids if isinstance(r := records.get(id_), Feature) and may_have_plane(r)]


def is_picked_plane(record: Record | None) -> bool:
    """A plane picked on a model, which stands for its feature type."""
    return (
        isinstance(record, Feature)
        and (kind := kind_of(record)).plane is not None
        and kind.evidence == "picked"
    )


def group_of(feature: Feature) -> str:
    """The id that hides a feature together with its like: its type's, or that of its kind."""
    if isinstance(feature, Typed):
        return feature.type_id
    group = kind_of(feature).group
    return "" if group is None else group.id


def group_and_set(record: Record) -> tuple[str, str, bool] | None:
    """The group of a feature, its set ("" for none), and whether it is a picked plane."""
    if not isinstance(record, Feature):
        return None
    return group_of(record), str(getattr(record, "set_name", "")), is_picked_plane(record)


# --- drawing ---------------------------------------------------------------------------------
def half_way(line: FloatArray) -> FloatArray:
    """(3,) in the middle of a line, as one walks along it."""
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    return np.array([np.interp(0.5 * along[-1], along, line[:, i]) for i in range(3)])


def centre(measured: Measurement) -> FloatArray:
    """(3,) of the fitted plane, else of the points."""
    middle = measured.points.mean(axis=0) if measured.fit is None else measured.fit.centroid
    return np.asarray(middle, float)


def line_of(subject: Subject) -> FloatArray | None:
    """The points, where they make a line."""
    points = subject.measured.points
    return points if len(points) > 1 else None


def always(feature: Any) -> bool:
    return True


def plane_named(feature: Any) -> tuple[str, ...]:
    """Of a feature with the field `plane_id`."""
    return (feature.plane_id,) if feature.plane_id else ()


def plane_below(records: Records, feature: Any) -> list[Feature]:
    return planes_among(records, plane_named(feature))
