"""Extensions of output files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from vomstudio.core.errors import UsageError
from vomstudio.core.files.atomic import check_target
from vomstudio.core.findings import Finding

_OTHER_FORMAT_EXTENSIONS = frozenset(
    (".xlsx", ".xls", ".ods", ".gpkg", ".shp", ".geojson", ".json", ".kml", ".dxf", ".tif", ".tiff")
    + (".png", ".jpg", ".jpeg", ".svg", ".pdf", ".html", ".obj", ".ply", ".glb", ".las", ".laz")
)
"""Extensions of formats other than text tables."""


def check_extension(
    path: str | Path, extensions: Iterable[str], field: str | None = "--output"
) -> str:
    """Return the extension of an output file in lower case.

    Raises
    ------
    UsageError
        If the extension is not one of `extensions`.
    """
    suffix = Path(path).suffix.lower()
    formats = tuple(extensions)
    if suffix not in formats:
        cause = Finding("output.unknown-format", suffix=suffix, formats=formats)
        raise UsageError(cause, file=path, field=field)
    return suffix


def check_table_target(
    path: str | Path,
    *,
    force: bool = False,
    inputs: Iterable[str | Path] = (),
    field: str = "--output",
) -> None:
    """Check that a text table can be written to a path, as `check_target` does.

    Raises
    ------
    UsageError
        If the extension is that of another format, such as .xlsx.
    TargetError
        As for `check_target`.
    """
    check_target(path, force=force, inputs=inputs)
    suffix = Path(path).suffix.lower()
    if suffix in _OTHER_FORMAT_EXTENSIONS:
        cause = Finding("output.unknown-format", suffix=suffix, formats=(".csv", ".txt"))
        raise UsageError(cause, file=path, field=field)
