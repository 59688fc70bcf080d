"""The frame of a model, as a command or a script declares it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vomstudio.document.records import Frame, UpAxis
from vomstudio.errors import InputError, UsageError
from vomstudio.geometry.units import METRES
from vomstudio.words import tr
from vomstudio.workspace.models import frame_of


@dataclass(frozen=True)
class DeclaredFrame:
    """crs : such as EPSG:32633; up : the file's axis that points up; unit : a name of METRES. None
    stands for what the file itself states, else for the default."""

    crs: str | None = None
    up: UpAxis | None = None
    unit: str | None = None


@dataclass(frozen=True)
class FrameWithWarnings:
    """A frame, and what the user must know of how it was found."""

    frame: Frame
    warnings: tuple[str, ...] = ()


def declared_frame(
    path: Path, file_crs: str | None, turned: bool, declared: DeclaredFrame
) -> FrameWithWarnings:
    """The frame of a model's file. turned : its format is Y-up by definition and its reader has
    rotated it. A file that states nothing is taken as local, in metres, Z up. Raises UsageError."""
    up: UpAxis = declared.up or "z"
    if turned:
        if declared.up == "z":
            raise UsageError(
                tr(
                    "This format is Y-up by definition and is rotated to Z-up when it is read. To "
                    "declare another up axis, first write the model in another format with "
                    "vomstudio convert --up z."
                ),
                field="--up",
            )
        up = "z"
    if declared.crs is not None:
        return _in_crs(declared.crs, file_crs, up, declared.unit)
    metres = 1.0 if declared.unit is None else METRES[declared.unit]
    own = frame_of(path, file_crs)
    if own.crs is not None:
        return FrameWithWarnings(Frame(own.kind, own.crs, _unit_of(own.crs, declared.unit), up))
    if own.kind != "undeclared":
        return FrameWithWarnings(Frame(own.kind, own.crs, metres, up))
    if declared == DeclaredFrame():
        warning = tr(
            "{file} states no frame. It is taken as local, in metres, z up and y north; --crs, "
            "--up and --unit declare another frame.",
            file=path.name,
        )
        return FrameWithWarnings(Frame("local"), (warning,))
    return FrameWithWarnings(Frame("local", None, metres, up))


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
            tr(
                "The unit of {crs} is {metres:g} m, not {unit}. Leave out --crs or --unit.",
                crs=code,
                metres=metres,
                unit=unit,
            ),
            field="--unit",
        )


def _in_crs(crs: str, file_crs: str | None, up: UpAxis, unit: str | None) -> FrameWithWarnings:
    from vomstudio.io.gis.crs import typed_crs

    code, metres = typed_crs(crs)
    _require_unit(code, metres, unit)
    warnings: tuple[str, ...] = ()
    if file_crs not in (None, code):
        warnings = (
            tr(
                "The file states {file_crs}; {crs} was given and is used.",
                file_crs=file_crs,
                crs=code,
            ),
        )
    return FrameWithWarnings(Frame("crs", code, metres, up), warnings)
