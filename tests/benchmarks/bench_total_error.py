"""How often the true attitude of a bed lies within the stated total error, from picks to table.

    python -m tests.benchmarks.bench_total_error [RUNS]

A model of 30 m is placed by observations of each kind with errors drawn anew; a bed of known
attitude is picked on it with errors of the picks drawn anew, as large as those of the registration
or a few times smaller; the trace and the registration become records of a project, and the true
plane is held against what the table of the project says (`total95_deg`, the larger half-angle, so
that more than 95 % are wanted) and against the ellipse that the net draws.
"""

from __future__ import annotations

import sys

import numpy as np
import numpy.typing as npt

from tests.benchmarks.bench_registration import _TURN, CASES, Case
from vomstudio.geology.orientation import Plane, line_from_rake
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.rotation_errors import enlarged_semi_axes
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Model
from vomstudio.project.tables.project_table import project_table
from vomstudio.registration.placing import place

Array = npt.NDArray[np.float64]
_VERTICES, _LENGTH_M, _RELIEF_M = 30, 8.0, 2.0
_SHARES = (1.0, 0.3)
"""Of the registration's error, what the picks' is about."""


def trace_on(plane: Plane, scale: float, error_m: float, rng: np.random.Generator) -> Array:
    """(n, 3) picks in the model's own frame of a bed in World."""
    along, down = np.asarray(plane.strike_vector()), np.asarray(plane.dip_vector())
    t = np.linspace(-0.5, 0.5, _VERTICES)
    relief = rng.uniform(-0.5, 0.5, _VERTICES)
    world = _LENGTH_M * t[:, None] * along + _RELIEF_M * relief[:, None] * down
    world = world + rng.normal(size=(_VERTICES, 3)) * error_m
    return np.asarray(world @ _TURN / scale)


def shares(case: Case, part: float, runs: int, seed: int = 1) -> tuple[float, float, float]:
    """Shares of the runs within the ellipse and within the half-angle, and the median of the
    latter, degrees."""
    rng = np.random.default_rng(seed)
    inside = np.zeros(2)
    stated = []
    for _ in range(runs):
        placed = place(case.draw(rng, _TURN))
        rows = tuple(tuple(row) for row in np.asarray(placed.covariance).tolist())
        matrix = tuple(tuple(row) for row in np.asarray(placed.matrix).tolist())
        record = Registration(
            "r1", "r1", "points", Frame("local"), matrix, covariance=rows, centre=placed.centre
        )
        model = Model("m1", "m1", "m1.ply", "mesh", "hash", record)
        plane = Plane(float(rng.uniform(0.0, 360.0)), float(rng.uniform(10.0, 85.0)))
        worst = np.sqrt(np.linalg.eigvalsh(np.array(rows)[:3, :3])[-1])
        error_m = part * worst * _RELIEF_M * 0.29 * np.sqrt(_VERTICES)
        picks = trace_on(plane, placed.scale, error_m, rng)
        trace = Trace("t1", "t1", "bedding", "m1", "hash", tuple(map(tuple, picks.tolist())))
        records = {"m1": model, "t1": trace}
        measurements = Measurements()
        (row,) = project_table(records, measurements).rows
        measured = measurements.of(records, ["t1"])["t1"]
        fit, total = measured.fit, measured.total95_deg
        assert fit is not None
        assert total is not None
        assert measured.plane is not None
        assert fit.error_rake_deg is not None
        largest, smallest = enlarged_semi_axes(
            fit.max_confidence95_deg or 0.0, fit.min_confidence95_deg or 0.0, total
        )
        seen, true = np.asarray(measured.plane.normal()), np.asarray(plane.normal())
        true = true if seen @ true >= 0 else -true
        off = np.degrees(np.arctan2(np.linalg.norm(np.cross(seen, true)), seen @ true))
        first = line_from_rake(measured.plane, fit.error_rake_deg).vector()
        second = np.cross(seen, first)
        x, y = np.degrees([true @ first, true @ second])
        inside += [
            (x / largest) ** 2 + (y / smallest) ** 2 <= 1.0,
            off <= row["total95_deg"],
        ]
        stated.append(row["total95_deg"])
    return float(inside[0] / runs), float(inside[1] / runs), float(np.median(stated))


def main(runs: int) -> None:
    print(f"{'placed by':58s}  picks  ellipse  half-angle  median total 95 %")
    for case in CASES:
        for part in _SHARES:
            ellipse, angle, median = shares(case, part, runs)
            print(
                f"{case.name:58s}  {part:5.1f}  {100 * ellipse:7.1f}  {100 * angle:10.1f}"
                f"  {median:8.3f} deg",
                flush=True,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
