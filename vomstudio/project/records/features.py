"""Common fields of features that are measured on a model or in the field.

Each kind of feature is a frozen dataclass in `project/kinds`. These classes declare the fields that
several kinds share, so that code can use them without naming a kind. They contain no values: each
kind defines the order of its fields.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, dataclass, replace
from typing import Any, ClassVar, Literal, Self, TypeVar

from vomstudio.geometry.matrices import Point

R = TypeVar("R")

SURROUNDINGS_RULE = 1
"""Version of the rule that measures resolution and attitude of the surface around a pick
(`studio/tools/local_surface.py`). Features store the version that they were measured with, 0 for
all earlier ones."""


class Feature:
    """Anything measured."""

    id: str
    name: str
    notes: str
    # Every kind is a dataclass, as `dataclasses.replace` requires.
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def but(self, **changes: Any) -> Self:
        """Return a copy with other values in some fields."""
        return replace(self, **changes)


class Typed(Feature):
    """A feature of one of the project's feature types, in a set or in none ("").

    `domain` is the part of the structure that contains it, for all types (hanging wall, footwall,
    dip domain), "" for none.
    """

    type_id: str
    set_name: str
    domain: str


class OnAModel(Feature):
    """A feature whose coordinates are in the file frame of a model."""

    model_id: str
    model_hash: str


class Repeatable(OnAModel):
    """A feature that may have been picked a second time, without seeing the first pick.

    `repeat_of` is the id of the feature that it repeats, `interpreter` who picked it; None if it
    is not a repeat or the interpreter is unknown.
    """

    repeat_of: str | None
    interpreter: str | None


class Surrounded(OnAModel):
    """A feature whose plane is judged by the surface around it.

    `resolution` is that of the model there, file units, None if unknown. `rule` is the rule by
    which it was measured, 0 for an earlier one.
    """

    resolution: float | None
    rule: int


class Picked(OnAModel):
    """A feature made of clicks. vertices: in order, model file frame."""

    vertices: tuple[Point, ...]


class Logged(Picked):
    """A line that may have a log of beds.

    `beds` contains (boundary at which the bed begins, lithology, notes). A boundary is the id of
    the trace there, or "#" and the number of the line's point, from 0.
    """

    beds: tuple[tuple[str, str, str], ...]


class Painted(OnAModel):
    """A piece of the model's surface.

    Attributes
    ----------
    element : str
        Type of the ids.
    runs : tuple of tuple of int
        Sorted ids of the model's faces or points, as (first, count).
    n, mean : int, Point
        Number and centre of their points in the file frame.
    outline : tuple of Point
        Ring of points around it, as seen along its normal.
    """

    element: Literal["face", "point"]
    runs: tuple[tuple[int, int], ...]
    n: int
    mean: Point
    outline: tuple[Point, ...]


@dataclass(frozen=True)
class Group:
    """Planes used together: a single feature, or all of a type and optionally of a set."""

    feature_id: str = ""
    type_id: str = ""
    set_name: str = ""


def get(records: Mapping[str, Any], id_: str | None, cls: type[R]) -> R | None:
    """Return the record of an id if it is an instance of a class, else None."""
    record = records.get(id_) if id_ is not None else None
    return record if isinstance(record, cls) else None


def get_feature(records: Mapping[str, Any], id_: str | None) -> Feature | None:
    """Return the feature of an id; None if there is no such record, or it is not a feature."""
    return get(records, id_, Feature)
