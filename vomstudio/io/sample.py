"""The embedded sample outcrop: its model, the picks that come with it, and their truth."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.geology.orientation import Line, Plane
from vomstudio.paths import resource

FOLDER = "sample"


@dataclass(frozen=True, eq=False)
class SamplePicks:
    """Digitised picks: pick i has names[i], kinds[i] (bedding, fault, joint), sets[i], horizons[i]
    ("" where it is on no named bed) and points[offsets[i]:offsets[i + 1]], World, m."""

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    sets: tuple[str, ...]
    horizons: tuple[str, ...]
    points: npt.NDArray[np.float64]
    offsets: npt.NDArray[np.int64]

    def of(self, i: int) -> npt.NDArray[np.float64]:
        return self.points[self.offsets[i] : self.offsets[i + 1]]


@dataclass(frozen=True)
class SampleTruth:
    """By the name of their pick the planes; fold axis, bedding/fault intersection, slip."""

    planes: dict[str, Plane]
    axis: Line
    intersection: Line
    displacement_m: float


def sample_model() -> Path:
    """The sample's OBJ file."""
    return resource(FOLDER, "sample.obj")


def read_picks(path: Path | None = None) -> SamplePicks:
    """Raises InputError where the file is damaged."""
    path = path or resource(FOLDER, "picks.csv")
    rows = _rows(path)
    try:
        names = [row["pick"] for row in rows]
        starts = [i for i, name in enumerate(names) if i == 0 or name != names[i - 1]]
        return SamplePicks(
            tuple(names[i] for i in starts),
            tuple(rows[i]["kind"] for i in starts),
            tuple(rows[i]["set"] for i in starts),
            tuple(rows[i]["horizon"] for i in starts),
            np.array([[float(row[axis]) for axis in "xyz"] for row in rows]),
            np.array([*starts, len(rows)], dtype=np.int64),
        )
    except (KeyError, ValueError, TypeError) as error:
        raise InputError("the picks of the sample are damaged; install again", file=path) from error


def read_truth(path: Path | None = None) -> SampleTruth:
    """Raises InputError where the file is damaged."""
    path = path or resource(FOLDER, "truth.csv")
    try:
        rows = {row["name"]: row for row in _rows(path)}

        def line(name: str) -> Line:
            return Line(float(rows[name]["trend_deg"]), float(rows[name]["plunge_deg"]))

        return SampleTruth(
            {
                name: Plane(float(row["dip_direction_deg"]), float(row["dip_deg"]))
                for name, row in rows.items()
                if row["dip_deg"]
            },
            line("fold axis"),
            line("bedding and fault"),
            float(rows["displacement"]["length_m"]),
        )
    except (KeyError, ValueError, TypeError) as error:
        raise InputError("the truth of the sample is damaged; install again", file=path) from error


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))
