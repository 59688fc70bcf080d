"""What features have in common: what is measured on a model, or in the field.

Each kind of feature is a frozen dataclass of its own in `project/kinds`; these classes say which
fields several of them share, so that they can be asked for without naming a kind. They hold nothing
themselves: the order of a kind's fields is its own.
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
    # Every kind is a dataclass, which is what `dataclasses` asks for.
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def but(self, **changes: Any) -> Self:
        """The same with other values in some fields."""
        return replace(self, **changes)


class Typed(Feature):
    """A feature of one of the project's feature types, in a set of it or in none ("").

    domain: part of the structure that it lies in, of all types alike (hanging wall, footwall, dip
    domain), "" for none.
    """

    type_id: str
    set_name: str
    domain: str


class OnAModel(Feature):
    """A feature whose coordinates are in the file frame of a model."""

    model_id: str
    model_hash: str


class Repeatable(OnAModel):
    """A feature that may have been picked a second time, without sight of the first.

    repeat_of: the id of the feature that it repeats; interpreter: who picked it. None where that is
    not so, or not said.
    """

    repeat_of: str | None
    interpreter: str | None


class Surrounded(OnAModel):
    """A feature with a plane that is judged by the surface around it.

    resolution: of the model there, file units, None where unknown. rule: by which it was measured,
    0 for an earlier one.
    """

    resolution: float | None
    rule: int


class Picked(OnAModel):
    """A feature made of clicks. vertices: in order, model file frame."""

    vertices: tuple[Point, ...]


class Logged(Picked):
    """A line along which a log of beds may run.

    beds: what was said of them, as (boundary at which the bed begins, lithology, notes); a boundary
    is the id of the trace there, or "#" and the number of the line's own point, from 0.
    """

    beds: tuple[tuple[str, str, str], ...]


class Painted(OnAModel):
    """A piece of the model's own surface.

    element: what the ids name. runs: the sorted ids of the model's faces or points, as (first,
    count). n, mean: number and centre of their points in the file frame. outline: ring of points
    around it, as seen along its normal.
    """

    element: Literal["face", "point"]
    runs: tuple[tuple[int, int], ...]
    n: int
    mean: Point
    outline: tuple[Point, ...]


@dataclass(frozen=True)
class Group:
    """Planes meant together: the feature `feature_id`, else all of a type and, where `set_name` is
    not empty, of that set."""

    feature_id: str = ""
    type_id: str = ""
    set_name: str = ""


def get(records: Mapping[str, Any], id_: str | None, cls: type[R]) -> R | None:
    """The record of an id where it is one of a class; else None."""
    record = records.get(id_) if id_ is not None else None
    return record if isinstance(record, cls) else None


def get_feature(records: Mapping[str, Any], id_: str | None) -> Feature | None:
    """The feature of an id; None where there is no such record, or it is no feature."""
    return get(records, id_, Feature)
