"""Comparisons stored in a project: distances of a model from a benchmark.

They are files next to the journal and not records: if a file is lost, the comparison has to be
repeated.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.regular import is_regular_file, read_json
from vomstudio.core.findings import Finding
from vomstudio.project.records import Model

Rows = tuple[tuple[float, ...], ...]

FOLDER = "comparisons"
"""Name of the folder inside the project folder."""
_REQUIRED_FIGURES = ("n", "beyond", "mean_m", "median_m", "mad_m", "rms_m")
_OPTIONAL_FIGURES = ("std_m", "lod95_m", "significant_share")
_DIRECTION = ("trend_deg", "plunge_deg")
_MATRICES = ("to_world", "benchmark_to_world")


@dataclass(frozen=True)
class StoredComparison:
    """Comparison of a model with a benchmark.

    Attributes
    ----------
    model_id, model_name, content_hash, to_world
        Model and its placement at the time of the comparison.
    benchmark, benchmark_path, benchmark_to_world
        Benchmark and its placement.
    radius_m : float or None
        Radius of M3C2, or None for nearest distances.
    figures : mapping
        Results as printed by the `compare` command.
    made, version : str
        UTC time of the comparison, and version of the program.
    fields : Path
        File of the distances: arrays for all points by the names of the model's fields.
    """

    model_id: str
    model_name: str
    content_hash: str
    to_world: Rows
    benchmark: str
    benchmark_path: str
    benchmark_to_world: Rows
    radius_m: float | None
    figures: Mapping[str, Any]
    made: str
    version: str
    fields: Path

    def is_current(self, model: Model) -> bool:
        """Return whether the model has the content and placement that were compared."""
        is_same_file = model.content_hash == self.content_hash
        return is_same_file and np.allclose(model.to_world, self.to_world, rtol=0.0, atol=1e-9)

    def replaces(self, other_comparison: StoredComparison) -> bool:
        """Return whether this comparison has the same two models and method as another one."""
        return (self.model_id, self.benchmark_path, self.radius_m) == (
            other_comparison.model_id,
            other_comparison.benchmark_path,
            other_comparison.radius_m,
        )


def distances_file(folder: Path, name: str) -> Path:
    """Return the file for the distances of a new comparison in a project folder."""
    return folder / FOLDER / f"{name}.npz"


def now() -> str:
    """Return the current time in UTC as ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def store_comparison(comparison: StoredComparison) -> None:
    """Write the description of a comparison whose distances have already been written.

    Earlier comparisons of the same models with the same method are deleted. Raises TargetError.
    """
    values = {name: value for name, value in vars(comparison).items() if name != "fields"}
    text = json.dumps({**values, "figures": dict(comparison.figures)}, indent=1, allow_nan=False)
    write_bytes(comparison.fields.with_suffix(".json"), text.encode(), force=True)
    for other_comparison in _read_comparisons(comparison.fields.parent):
        if other_comparison.fields != comparison.fields and other_comparison.replaces(comparison):
            for path in (other_comparison.fields, other_comparison.fields.with_suffix(".json")):
                with suppress(OSError):
                    path.unlink()


def stored_comparisons(folder: Path, model_id: str) -> list[StoredComparison]:
    """Return the readable comparisons of a model, newest first."""
    comparisons = [
        comparison
        for comparison in _read_comparisons(folder / FOLDER)
        if comparison.model_id == model_id
    ]
    return sorted(comparisons, key=lambda comparison: comparison.made, reverse=True)


def _read_comparisons(folder: Path) -> list[StoredComparison]:
    comparisons = []
    for path in sorted(folder.glob("*.json")):
        fields = path.with_suffix(".npz")
        with suppress(InputError, OSError, ValueError, TypeError, KeyError, OverflowError):
            values = read_json(path)
            if is_regular_file(fields) and _is_valid(values):
                comparisons.append(
                    StoredComparison(**{**values, **_matrices(values)}, fields=fields)
                )
    return comparisons


def _is_valid(values: Mapping[str, Any]) -> bool:
    """Return whether values from an untrusted project have the types of a comparison.

    Raises KeyError if a value is missing.
    """
    figures, radius = values["figures"], values["radius_m"]
    text_fields = [item for item in values if item not in (*_MATRICES, "figures", "radius_m")]
    return (
        all(isinstance(values[name], str) for name in text_fields)
        and isinstance(figures, dict)
        and isinstance(figures["warnings"], list)
        and all(_is_finding(item) for item in figures["warnings"])
        and all(_is_number(figures[name]) for name in _REQUIRED_FIGURES)
        and all(figures[name] is None or _is_number(figures[name]) for name in _OPTIONAL_FIGURES)
        and _is_direction_or_none(figures["positive_toward"])
        and (radius is None or _is_number(radius))
        and all(np.shape(values[name]) == (4, 4) for name in _MATRICES)
    )


def _is_direction_or_none(value: object) -> bool:
    is_direction = isinstance(value, dict) and all(_is_number(value[name]) for name in _DIRECTION)
    return value is None or is_direction


def _is_finding(value: object) -> bool:
    return isinstance(value, dict) and bool(Finding.from_dict(value).message)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _matrices(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: tuple(tuple(float(v) for v in row) for row in values[name]) for name in _MATRICES}
