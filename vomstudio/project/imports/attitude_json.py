"""Annotations in attitude files of PRo3D (`PRo3D.Base.Annotation.AttitudeExport`)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_json
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.io.gate.stated_crs import table_crs
from vomstudio.project.imports.listed_rows import ListedRow, ReadingReport

_ARRAY_START = re.compile(rb"(?:\xef\xbb\xbf)?\s*\[\s*\{")
_NORMAL_INDEX = 2
"""Position of the normal in the axes of an annotation."""


def is_attitude_json(head: bytes) -> bool:
    """Return whether a file is a list of annotations.

    Parameters
    ----------
    head : bytes
        First bytes of the file.
    """
    return _ARRAY_START.match(head) is not None


def attitude_rows(path: Path, report: ReadingReport) -> Iterator[ListedRow]:
    """Yield the annotations of a file as traces with their stated planes.

    Raises
    ------
    InputError
        If the file is not JSON.
    """
    try:
        content = read_json(path)
    except (OSError, ValueError) as error:
        finding = Finding("file.damaged", format="JSON", reason=error)
        raise InputError(finding, file=path) from error
    frame, findings = table_crs(path, ())
    report.findings += findings
    for number, item in enumerate(content, 1):
        if not isinstance(item, dict):
            continue
        name = item.get("name")
        values = {"name": name if isinstance(name, str) else "", "id": str(item.get("uid", ""))}
        centre = _vectors([item.get("center")])
        offsets = _vectors(item.get("centered_array"))
        if centre is None or offsets is None:
            label = values["name"] or values["id"] or str(number)
            report.skipped.append((label, Finding("import.no-points")))
            continue
        yield ListedRow(
            "traces", centre + offsets, values, frame, plane=_plane(item), notes="PRo3D"
        )


def _plane(item: dict[str, Any]) -> Plane | None:
    axes = _vectors(item.get("axes"))
    if axes is None or len(axes) <= _NORMAL_INDEX or not axes[_NORMAL_INDEX].any():
        return None
    return Plane.from_normal(axes[_NORMAL_INDEX])


def _vectors(rows: Any) -> FloatArray | None:
    """Return vectors (n, 3) of finite numbers, or None for other content."""
    try:
        vectors = np.asarray(rows, np.float64)
    except (TypeError, ValueError, OverflowError):
        return None
    is_valid = vectors.ndim == 2 and vectors.shape[1] == 3 and bool(np.isfinite(vectors).all())
    return vectors if is_valid else None
