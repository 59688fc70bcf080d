"""Measure the beds of both sample outcrops by two clicks each and the path between them.

    python -m tests.benchmarks.bench_followed_beds [--model outcrop] [--cost auto] [--seeds 1]
        [--beds 99] [--folded]

The true beds are the picks of `resources/outcrop` (8 beds) and `resources/sample` (18 beds). The
two clicks are 100, 75 and 50 % of the picks apart, at a random place, with an error of 5 mm (one
sigma) in each coordinate.

Printed for each cost: the planes called good, doubtful and poor; how many of all and of the good
ones have the true plane within the total error (target: 93 %); and medians of the true error, the
stated error, and the distance of the path from the bed (its median and its 90 % quantile).

`--folded` follows contacts of `resources/outcrop` across the hinges of the fold. Printed are the
distance of the path from the bed, and the departure of the bed from the best plane through both
clicks.
"""

from __future__ import annotations

import argparse
import csv
import importlib
import sys
import time
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from tests.sample_maker import PACKAGING
from vomstudio.core.errors import GeometryError
from vomstudio.core.paths import resource
from vomstudio.extraction.best_cost import AUTO, follow_best
from vomstudio.extraction.followed_trace import index_vertices
from vomstudio.extraction.following import Follower, Path
from vomstudio.extraction.path_jumps import find_jumps
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.doubtful_stretches import fit_remaining_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geology.quality import judge, total_error_deg
from vomstudio.geometry.planes import fit_plane
from vomstudio.geometry.surface import VertexSurface
from vomstudio.studio.world_models import read_in_world

Floats = npt.NDArray[np.float64]
SEPARATIONS = (1.0, 0.75, 0.5)
CLICK_ERROR_M = 0.005
FOLDED_SPANS_M = ((0.5, 5.5), (3.5, 8.5), (6.5, 11.5), (2.0, 9.0))
FOLDED_BEDS = ("B01", "B02", "B05", "B06", "B08")


class Outcrop:
    """Sample with its surface, its picks (n, 3) by bed, and the true normals of the beds."""

    def __init__(self, folder: str) -> None:
        rows = {name: _rows(folder, name) for name in ("picks.csv", "truth.csv")}
        self.normals = {
            next(iter(row.values())): Plane(
                float(row["dip_direction_deg"]), float(row["dip_deg"])
            ).normal()
            for row in rows["truth.csv"]
            if row.get("kind", "bedding") == "bedding" and row["dip_deg"]
        }
        points: dict[str, list[list[float]]] = {name: [] for name in self.normals}
        for row in rows["picks.csv"]:
            if (name := next(iter(row.values()))) in points:
                points[name].append([float(row[axis]) for axis in "xyz"])
        self.picks = {name: np.array(bed) for name, bed in points.items() if bed}
        self.data: Any = read_in_world(resource(folder, f"{folder}.obj")).data
        self.surface = SurfaceGraph(self.data)
        self.vertices: VertexSurface = index_vertices(self.surface)

    def follow(self, clicks: Floats, cost: str) -> Path:
        if cost != AUTO:
            return Follower(self.surface, cost).follow(clicks)
        near = self.vertices
        return follow_best(self.surface, clicks, near.local_resolution, near.outcrop_normal)[0]


def _rows(folder: str, name: str) -> list[dict[str, str]]:
    with resource(folder, name).open(newline="") as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))


def print_beds(outcrop: Outcrop, name: str, cost: str, seeds: int, beds: int) -> None:
    """Print the figures of all beds, seeds and separations."""
    begun = time.process_time()
    figures: list[tuple[float, float, float, float]] = []
    verdicts: list[str] = []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        for bed, picks in list(outcrop.picks.items())[:beds]:
            for separation in SEPARATIONS:
                count = round(separation * (len(picks) - 1))
                first = int(rng.integers(0, len(picks) - count))
                part = picks[first : first + count + 1]
                clicks = part[[0, -1]] + CLICK_ERROR_M * rng.standard_normal((2, 3))
                try:
                    path = outcrop.follow(clicks, cost)
                    error, stated, quality = _measured(outcrop, path, outcrop.normals[bed])
                except GeometryError:
                    error, stated, quality = 90.0, 90.0, "poor"
                off = _distances(path.points, part)
                figures.append((error, stated, np.median(off), np.percentile(off, 90)))
                verdicts.append(quality)
    error, stated, middle, far = np.array(figures).T
    is_good = np.array(verdicts) == "good"
    inside = error <= stated
    print(
        f"{name:8}{cost:10}{len(error):5d} clicked twice: good {is_good.mean():4.0%} doubtful"
        f" {np.mean(np.array(verdicts) == 'doubtful'):4.0%} poor"
        f" {np.mean(np.array(verdicts) == 'poor'):4.0%}; inside {inside.mean():4.0%}, of the good"
        f" {inside[is_good].sum()}/{is_good.sum()}; error {np.median(error):5.2f}, stated"
        f" {np.median(stated):5.2f} deg; from the bed {1e3 * np.median(middle):4.0f},"
        f" {1e3 * np.median(far):4.0f} mm; {time.process_time() - begun:.1f} s (CPU)",
        flush=True,
    )


def _measured(outcrop: Outcrop, path: Path, normal: Floats) -> tuple[float, float, str]:
    """Return the true error, the stated error (degrees) and the verdict."""
    fit, near = fit_plane(path.points), outcrop.vertices
    face, resolution = near.outcrop_normal(path.points), near.local_resolution(path.points)
    rest = fit_remaining_plane(
        path.points, find_jumps(path.points, path.costs, path.way_point_rows, resolution or 0.0)
    )
    stretch = None if rest is None else rest.error95_deg(fit, resolution, face)
    total = total_error_deg(fit, resolution, outcrop_normal=face, stretch_error_deg=stretch)
    verdict = judge(
        fit,
        resolution_m=resolution,
        outcrop_normal=face,
        surface_findings=() if rest is None else rest.findings(),
        stretch_error_deg=stretch,
    )
    error = float(np.degrees(np.arccos(min(abs(float(fit.normal @ normal)), 1.0))))
    return error, 90.0 if total is None else total, verdict.quality


def _distances(points: Floats, picks: Floats) -> Floats:
    """Return the distances (n,) of points from the line through the picks, m."""
    rows = np.arange(len(picks))
    fine = np.linspace(0, len(picks) - 1, 20 * len(picks))
    line = np.stack([np.interp(fine, rows, column) for column in picks.T], axis=1)
    return np.asarray(cKDTree(line).query(points)[0])


def print_folded(outcrop: Outcrop, cost: str) -> None:
    """Print how far paths are from contacts that are bent by the fold."""
    if str(PACKAGING) not in sys.path:
        sys.path.insert(0, str(PACKAGING))
    made = importlib.import_module("make_small_outcrop")
    vertices = np.asarray(outcrop.data.vertices) - made.ORIGIN
    levels = made.height_in_pile(vertices)
    faces = np.asarray(outcrop.data.faces)
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]]), axis=1), axis=0)
    rows: list[tuple[float, float, float]] = []
    for bed in FOLDED_BEDS:
        level = float(np.median(made.height_in_pile(outcrop.picks[bed] - made.ORIGIN)))
        one, other = levels[edges[:, 0]] - level, levels[edges[:, 1]] - level
        cut = one * other < 0
        share = (one / (one - other))[cut][:, None]
        contact = vertices[edges[cut, 0]] * (1 - share) + vertices[edges[cut, 1]] * share
        contact = contact[np.argsort(contact @ made.ALONG)]
        place = contact @ made.ALONG
        for span in FOLDED_SPANS_M:
            a, b = (int(np.argmin(np.abs(place - end))) for end in span)
            if max(abs(place[a] - span[0]), abs(place[b] - span[1])) > 0.2:
                continue
            path = outcrop.follow(contact[[a, b]] + made.ORIGIN, cost)
            off = np.abs(made.height_in_pile(path.points - made.ORIGIN) - level)
            part = contact[a : b + 1] - contact[a]
            along = part[-1] / np.linalg.norm(part[-1])
            across = part - (part @ along)[:, None] * along
            normal = np.linalg.eigh(across.T @ across)[1][:, 1]
            rows.append((np.median(off), np.percentile(off, 90), np.abs(across @ normal).max()))
    middle, far, departure = 1e3 * np.array(rows).T
    print(
        f"folded  {cost:10}{len(rows):5d} paths: from the bed {np.median(middle):4.0f},"
        f" {np.median(far):4.0f} mm; within 60 mm {np.mean(far < 60.0):4.0%}; departure of the beds"
        f" from a plane {np.median(departure):.0f} mm",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", choices=("outcrop", "sample"), action="append")
    parser.add_argument("--cost", action="append")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--beds", type=int, default=99)
    parser.add_argument("--folded", action="store_true")
    args = parser.parse_args()
    costs = args.cost or ["colour", "dark", "gradient", AUTO]
    for name in ["outcrop"] if args.folded else args.model or ["outcrop", "sample"]:
        outcrop = Outcrop(name)
        for cost in costs:
            if args.folded:
                print_folded(outcrop, cost)
            else:
                print_beds(outcrop, name, cost, args.seeds, args.beds)


if __name__ == "__main__":
    main()
