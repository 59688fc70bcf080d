"""Arguments `crs`, `up`, `unit` and `to_crs` of Python functions."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

from vomstudio.api.checking import check_choice, optional_text
from vomstudio.core.errors import VomError
from vomstudio.core.options import declarations
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.io.gate.frame_options import FrameOptions

UpAxis = Literal["y", "z"]
_ARGUMENT_NAMES = {declaration.flag: declaration.name for declaration in declarations(FrameOptions)}


def frame_options(
    crs: str | None, up: UpAxis | None, unit: str | None, to_crs: str | None
) -> FrameOptions:
    """Create the frame options from the arguments of a call.

    Raises
    ------
    InputError, UsageError
        If a value is not among the choices; the error names the argument.
    """
    if up is not None:
        check_choice(up, ("y", "z"), "up")
    if unit is not None:
        check_choice(unit, METRES_PER_UNIT, "unit")
    return FrameOptions(
        crs=optional_text(crs, "crs"), up=up, unit=unit, to_crs=optional_text(to_crs, "to_crs")
    )


@contextmanager
def name_frame_arguments_in_errors() -> Iterator[None]:
    """Replace the names of options in errors about the frame by the names of arguments."""
    try:
        yield
    except VomError as error:
        error.field = _ARGUMENT_NAMES.get(error.field or "", error.field)
        raise
