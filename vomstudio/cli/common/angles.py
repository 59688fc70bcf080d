"""Angles that are typed as the words of options."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.errors import UsageError, VomError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.geology.orientation import Plane


def pair_of(text: str, field: str) -> tuple[float, float]:
    """Of "120/45". Raises UsageError."""
    one, _, two = text.partition("/")
    try:
        return float(one), float(two)
    except ValueError as error:
        raise UsageError(
            tr("“{text}” is no pair of angles; write it like 120/45.", text=text), field=field
        ) from error


def plane_of(text: str, field: str) -> Plane:
    """Of dip direction/dip. Raises UsageError."""
    from vomstudio.geology.orientation import Plane

    direction, dip = pair_of(text, field)
    try:
        return Plane(direction, dip)
    except VomError as error:
        raise UsageError(error.message, field=field) from error
