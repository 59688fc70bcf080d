"""Comparisons that a project keeps: the distances of a model's points from a benchmark, with what
they were found by, in files beside the journal. The records know nothing of them: a file that is
lost is a comparison that is made again."""

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
from vomstudio.core.files.regular import is_regular, read_json
from vomstudio.project.records import Model

Rows = tuple[tuple[float, ...], ...]

FOLDER = "comparisons"
"""In the project's folder."""
_KNOWN = ("n", "beyond", "mean_m", "median_m", "mad_m", "rms_m")
_PERHAPS = ("std_m", "lod95_m", "significant_share")
_SIDE = ("trend_deg", "plunge_deg")
_MATRICES = ("to_world", "benchmark_to_world")


@dataclass(frozen=True)
class KeptComparison:
    """model_id, model_name, content_hash, to_world : of the model, as it stood then
    benchmark, benchmark_path, benchmark_to_world : what it was held against
    radius_m : of M3C2, None for nearest distances
    figures : as the command `compare` prints them
    made : when, UTC; version : of this program
    fields : the file of the distances, arrays of all points by the names of the model's fields
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

    def stands(self, model: Model) -> bool:
        """Whether the model is still the one that was compared, where it was then."""
        same_file = model.content_hash == self.content_hash
        return same_file and np.allclose(model.to_world, self.to_world, rtol=0.0, atol=1e-9)

    def of_the_same(self, other: KeptComparison) -> bool:
        """Whether one takes the place of the other: of the same two models in the same way."""
        return (self.model_id, self.benchmark_path, self.radius_m) == (
            other.model_id,
            other.benchmark_path,
            other.radius_m,
        )


def file_for(folder: Path, name: str) -> Path:
    """Where the distances of a new comparison go. folder : of the project"""
    return folder / FOLDER / f"{name}.npz"


def now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def keep(kept: KeptComparison) -> None:
    """Write what the distances, whose file is there, were found by; an earlier comparison of the
    same models in the same way is taken away. Raises TargetError."""
    values = {name: value for name, value in vars(kept).items() if name != "fields"}
    text = json.dumps({**values, "figures": dict(kept.figures)}, indent=1, allow_nan=False)
    write_bytes(kept.fields.with_suffix(".json"), text.encode(), force=True)
    for other in _read_all(kept.fields.parent):
        if other.fields != kept.fields and other.of_the_same(kept):
            for path in (other.fields, other.fields.with_suffix(".json")):
                with suppress(OSError):
                    path.unlink()


def kept_of(folder: Path, model_id: str) -> list[KeptComparison]:
    """Those of a model, the newest first; what cannot be read is left out."""
    found = [kept for kept in _read_all(folder / FOLDER) if kept.model_id == model_id]
    return sorted(found, key=lambda kept: kept.made, reverse=True)


def _read_all(folder: Path) -> list[KeptComparison]:
    found = []
    for path in sorted(folder.glob("*.json")):
        fields = path.with_suffix(".npz")
        with suppress(InputError, OSError, ValueError, TypeError, KeyError, OverflowError):
            told = read_json(path)
            if is_regular(fields) and _is_sound(told):
                found.append(KeptComparison(**{**told, **_matrices(told)}, fields=fields))
    return found


def _is_sound(told: Mapping[str, Any]) -> bool:
    """Whether what a project of somebody else says is of the kinds that a comparison has. Raises
    KeyError where something is missing."""
    figures, radius = told["figures"], told["radius_m"]
    words = [each for each in told if each not in (*_MATRICES, "figures", "radius_m")]
    return (
        all(isinstance(told[name], str) for name in words)
        and isinstance(figures, dict)
        and isinstance(figures["warnings"], list)
        and all(_is_number(figures[name]) for name in _KNOWN)
        and all(figures[name] is None or _is_number(figures[name]) for name in _PERHAPS)
        and _is_side(figures["positive_toward"])
        and (radius is None or _is_number(radius))
        and all(np.shape(told[name]) == (4, 4) for name in _MATRICES)
    )


def _is_side(told: object) -> bool:
    known = isinstance(told, dict) and all(_is_number(told[name]) for name in _SIDE)
    return told is None or known


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _matrices(told: Mapping[str, Any]) -> dict[str, Any]:
    return {name: tuple(tuple(float(v) for v in row) for row in told[name]) for name in _MATRICES}
