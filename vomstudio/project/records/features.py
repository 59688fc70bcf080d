"""Common fields of features that are measured on a model or in the field.

Each kind of feature is a frozen dataclass in `project/kinds`. These classes declare the
fields that several kinds share, so that code can use them without depending on a kind. The
fields have no values here, because each kind defines the order of its own fields.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, dataclass, replace
from typing import Any, ClassVar, Literal, Self, TypeVar

from vomstudio.geometry.matrices import Point

R = TypeVar("R")

SURROUNDINGS_RULE = 1
"""Version of the rule that measures resolution and attitude of the surface around a pick
(`studio/tools/local_surface.py`). Features store the version with which they were measured, or 0
for all earlier versions."""


class Feature:
    """Feature measured on a model or in the field."""

    id: str
    name: str
    notes: str
    # Every kind is a dataclass, as required by `dataclasses.replace`.
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def replace_fields(self, **changes: Any) -> Self:
        """Return a copy of the feature with some fields replaced."""
        if not changes.keys() <= self.__dataclass_fields__.keys():
            return replace(self, **changes)
        # As `replace`, which takes ten times as long, for kinds that have no `__post_init__`.
        values = self.__dict__
        feature = object.__new__(type(self))
        feature.__dict__.update(
            {name: values[name] for name in self.__dataclass_fields__}, **changes
        )
        return feature


class TypedFeature(Feature):
    """Feature with one of the project's feature types, optionally in a set.

    `domain` is the part of the structure that contains the feature, regardless of its type (hanging
    wall, footwall, dip domain), or "" if no domain is assigned.
    """

    type_id: str
    set_name: str
    domain: str


class ModelFeature(Feature):
    """Feature whose coordinates are in the file frame of a model."""

    model_id: str
    model_hash: str


class RepeatableFeature(ModelFeature):
    """Feature that may be picked again while the first pick is hidden.

    `repeat_of` is the ID of the feature that it repeats, or None if it is not a repeat.
    `interpreter` is the person who picked it, or None if unknown.
    """

    repeat_of: str | None
    interpreter: str | None


class SurfaceFeature(ModelFeature):
    """Feature whose plane is judged using the surrounding surface.

    `resolution` is the resolution of the model around the feature in file units, or None if
    unknown. `rule` is the version of the rule with which it was measured, or 0 for an earlier
    version.
    """

    resolution: float | None
    rule: int


class PickedFeature(ModelFeature):
    """Feature defined by clicks. `vertices` are in order, in the file frame of the model."""

    vertices: tuple[Point, ...]


class LoggedFeature(PickedFeature):
    """Line that may have a log of beds.

    `beds` contains (boundary at which the bed begins, lithology, notes). A boundary is the ID of
    the trace there, or "#" followed by the 0-based number of a point of the line.
    """

    beds: tuple[tuple[str, str, str], ...]


class PaintedFeature(ModelFeature):
    """Part of the surface of a model.

    Attributes
    ----------
    element : str
        Type of the elements, faces or points.
    runs : tuple of tuple of int
        Runs of consecutive IDs of faces or points of the model, as (first, count), sorted.
    n, mean : int, Point
        Number of the points, and their centre in the file frame.
    outline : tuple of Point
        Ring of points around the part, as seen along its normal.
    """

    element: Literal["face", "point"]
    runs: tuple[tuple[int, int], ...]
    n: int
    mean: Point
    outline: tuple[Point, ...]


@dataclass(frozen=True)
class Group:
    """Group of planes that are used together: a feature, or all features of a type and set."""

    feature_id: str = ""
    type_id: str = ""
    set_name: str = ""


def get(records: Mapping[str, Any], id_: str | None, cls: type[R]) -> R | None:
    """Return the record with an ID if it is an instance of a class, or None."""
    record = records.get(id_) if id_ is not None else None
    return record if isinstance(record, cls) else None


def get_feature(records: Mapping[str, Any], id_: str | None) -> Feature | None:
    """Return the feature with an ID, or None if no feature has this ID."""
    return get(records, id_, Feature)
