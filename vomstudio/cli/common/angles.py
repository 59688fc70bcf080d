"""Angles that are typed as the words of options."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.errors import InputError, UsageError

if TYPE_CHECKING:
    from vomstudio.geology.orientation import Plane


def plane_of(text: str, field: str) -> Plane:
    """Of dip direction/dip. Raises UsageError."""
    from vomstudio.geology.notation import parse_plane

    try:
        return parse_plane(text, "dipdir/dip")
    except InputError as error:
        raise UsageError(error.message, field=field) from error
