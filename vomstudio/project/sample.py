"""Sample outcrop included in the program: model, picks and photos with their true values."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_small_text
from vomstudio.core.findings import Finding
from vomstudio.core.paths import resource
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.cameras import CAMERA_MODELS, Intrinsics, View
from vomstudio.io.photos.cameras_file import Cameras

FOLDER = "sample"


@dataclass(frozen=True, eq=False)
class SamplePicks:
    """Digitised picks.

    Pick i has the name names[i], the kind kinds[i] (bedding, fault, joint), the set sets[i], the
    horizon horizons[i] ("" if it is not a named bed) and the points points[offsets[i]:offsets[i +
    1]] in the World frame, metres.
    """

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    sets: tuple[str, ...]
    horizons: tuple[str, ...]
    points: FloatArray
    offsets: IntArray

    def of(self, i: int) -> FloatArray:
        return self.points[self.offsets[i] : self.offsets[i + 1]]


@dataclass(frozen=True)
class SampleTruth:
    """True values: planes of picks, fold axis, bedding-fault intersection, and displacement."""

    planes: dict[str, Plane]
    axis: Line
    intersection: Line
    displacement_m: float


def sample_model() -> Path:
    """Return the path of the OBJ file of the sample."""
    return resource(FOLDER, "sample.obj")


def sample_photos() -> Path:
    """Return the folder that contains the photos of the sample."""
    return resource(FOLDER, "photos")


def sample_control() -> Path:
    """Return the path of the control points: CSV with label,x,y,z,sigma,use."""
    return resource(FOLDER, "control.csv")


def sample_marks() -> Path:
    """Return the path of the control point marks: CSV with label,photo,x,y in COLMAP pixels."""
    return resource(FOLDER, "marks.csv")


def read_true_cameras(path: Path | None = None) -> Cameras:
    """Return the photos with the lens and poses with which they were rendered.

    Raises InputError if the file is damaged.
    """
    path = path or resource(FOLDER, "cameras_truth.csv")
    try:
        rows = _rows(path)
        centres = np.array([[float(row[axis]) for axis in "xyz"] for row in rows])
        origin = np.floor(centres.min(axis=0))
        views = []
        for row, centre in zip(rows, centres - origin, strict=True):
            matrix = [[float(row[f"r{i}{j}"]) for j in (1, 2, 3)] for i in (1, 2, 3)]
            lens = Intrinsics(
                "OPENCV",
                int(row["width"]),
                int(row["height"]),
                tuple(float(row[name]) for name in CAMERA_MODELS["OPENCV"]),
            )
            rotation = np.array(matrix)
            views.append(View(row["name"], lens, rotation, -rotation @ centre))
        x, y, z = (int(value) for value in origin)
        return Cameras(tuple(views), sample_photos(), (x, y, z), "EPSG:32633", True)
    except (KeyError, ValueError, TypeError) as error:
        raise InputError(Finding("sample.damaged"), file=path) from error


def read_picks(path: Path | None = None) -> SamplePicks:
    """Return the digitised picks. Raises InputError if the file is damaged."""
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
        raise InputError(Finding("sample.damaged"), file=path) from error


def read_truth(path: Path | None = None) -> SampleTruth:
    """Return the true values. Raises InputError if the file is damaged."""
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
        raise InputError(Finding("sample.damaged"), file=path) from error


def _rows(path: Path) -> list[dict[str, str]]:
    lines = read_small_text(path).splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))
