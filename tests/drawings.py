"""Reading of drawings in one call, as commands do it in two steps."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from vomstudio.core.progress import Progress
from vomstudio.io.gate.drawn_layers import (
    DrawnLayer,
    extract_area,
    extract_lines,
    read_raw_areas,
    read_raw_lines,
)


def read_lines(
    path: str | Path,
    layer: str | None = None,
    columns: Iterable[str] = (),
    progress: Progress | None = None,
) -> DrawnLayer:
    """Read the lines of a file, heights dropped."""
    return extract_lines(read_raw_lines(path, layer, columns, progress))


def read_area(
    path: str | Path, layer: str | None = None, progress: Progress | None = None
) -> tuple[Any, DrawnLayer]:
    """Read all polygons of a file as one shapely area, and their layer."""
    return extract_area(read_raw_areas(path, layer, progress))
