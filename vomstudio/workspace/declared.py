"""How a model stands in World, as a command or a script declares it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vomstudio.document.records import Frame, UpAxis
from vomstudio.errors import InputError, UsageError
from vomstudio.geometry.units import METRES
from vomstudio.workspace.models import frame_of


@dataclass(frozen=True)
class Declared:
    """crs : such as EPSG:32633; up : the file's axis that points up; unit : a name of METRES. None
    of what the file says itself, or what is usual."""

    crs: str | None = None
    up: UpAxis | None = None
    unit: str | None = None


@dataclass(frozen=True)
class Placed:
    frame: Frame
    warnings: tuple[str, ...] = ()


def placed(path: Path, file_crs: str | None, turned: bool, declared: Declared) -> Placed:
    """The frame of a model's file. turned : its format is Y-up by itself and its reader has turned
    it. A file that says nothing is taken as local, in metres, Z up. Raises UsageError."""
    up: UpAxis = declared.up or "z"
    if turned:
        if declared.up == "z":
            raise UsageError(
                "this format is Y-up by itself and is turned when it is read; write the model in "
                "another format first: vomstudio convert --up z.",
                field="--up",
            )
        up = "z"
    if declared.crs is not None:
        return _in_crs(declared.crs, file_crs, up, declared.unit)
    metres = 1.0 if declared.unit is None else METRES[declared.unit]
    own = frame_of(path, file_crs)
    if own.crs is not None:
        return Placed(Frame(own.kind, own.crs, _unit_of(own.crs, declared.unit), up))
    if own.kind != "undeclared":
        return Placed(Frame(own.kind, own.crs, metres, up))
    if declared == Declared():
        said = (
            f"{path.name} does not say how it stands in World: it is taken as local, in metres, "
            "with z up and y to the north (--crs, --up and --unit say otherwise)"
        )
        return Placed(Frame("local"), (said,))
    return Placed(Frame("local", None, metres, up))


def _unit_of(crs: str, unit: str | None) -> float:
    """Metres per unit of a CRS that a file names. Raises UsageError for another unit."""
    from vomstudio.io.gis.crs import parse_crs

    try:
        code, metres = parse_crs(crs)
    except InputError:  # no projected one: it is taken as it was
        return 1.0 if unit is None else METRES[unit]
    _require_unit(code, metres, unit)
    return metres


def _require_unit(code: str, metres: float, unit: str | None) -> None:
    if unit is not None and METRES[unit] != metres:
        raise UsageError(
            f"the unit of {code} is {metres:g} m, not {unit}; leave one of them out.",
            field="--unit",
        )


def _in_crs(crs: str, file_crs: str | None, up: UpAxis, unit: str | None) -> Placed:
    from vomstudio.io.gis.crs import parse_crs

    code, metres = parse_crs(crs)
    _require_unit(code, metres, unit)
    warnings: tuple[str, ...] = ()
    if file_crs not in (None, code):
        warnings = (f"the file itself names {file_crs}; {code} was given and is taken",)
    return Placed(Frame("crs", code, metres, up), warnings)
