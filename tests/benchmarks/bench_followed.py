"""How often the stated 95 % of a followed trace holds the true plane, and how wide it is.

    python -m tests.benchmarks.bench_followed [--traces 150] [--seed 0] [--jumps [COST]]

Outcrops of 3 x 3 m with relief at several scales, as clouds at random and as meshes over a grid,
of points 15 to 40 mm apart with noise of up to a third of that; a bed of 1 to 3 spacings that is
darker than its surroundings, in grey that scatters by up to half of the contrast, cuts them as a
plane of any attitude whose place wanders by up to 10 mm with a correlation of 5 to 10 cm. The same
on flat faces, which the bed cuts at 30 degrees or more: any plane through its line may be true.
Three way-points, clicked within a spacing of the bed. Auto is the best of all costs.

Printed for each population: how often the joint region of `max_confidence95_deg` and
`min_confidence95_deg`, which knows nothing of the model, and how often the total error holds the
truth (wanted: at least 93 %), how many are good, how many of these are more than 5 degrees off, the
median stated and true error, how many have a band of planes, and how often that holds the truth.

`--jumps`: whether a path that hops to a parallel seam is noticed. The same outcrops where one or
two seams 5 to 30 cm beside the bed are as dark, all with one to three gaps of 10 to 50 cm; and
single beds. Printed: how many have a doubtful stretch, and how many one within 4 cm of the bed; how
often the total error holds the truth, without the search for such stretches and with it, of all, of
those called good and of those that state at most 15 degrees (and how many these are).
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.errors import GeometryError
from vomstudio.extraction.best_cost import AUTO, follow_best
from vomstudio.extraction.followed_trace import index_vertices
from vomstudio.extraction.following import Follower, Path
from vomstudio.extraction.path_jumps import find_jumps
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.doubtful_stretches import RemainingTrace, fit_remaining_plane
from vomstudio.geology.plane_bands import find_plane_band
from vomstudio.geology.quality import judge, total_error_deg
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.planes import FittedPlane, fit_plane

Floats = npt.NDArray[np.float64]
SIZE = 3.0


@dataclass(frozen=True)
class Outcrop:
    """data : a mesh or cloud with colours; normal : of the bed; way_points (3, 3); spacing"""

    data: Mesh | PointCloud
    normal: Floats
    way_points: Floats
    spacing: float


def waves(rng: np.random.Generator, xy: Floats, lengths: Floats, heights: Floats) -> Floats:
    """(n,) sum of waves of these lengths and standard deviations, in random directions."""
    total = np.zeros(len(xy))
    for length, height in zip(lengths, heights, strict=True):
        angle, phase = rng.uniform(0.0, 2.0 * np.pi, 2)
        k = 2.0 * np.pi / length * np.array([np.cos(angle), np.sin(angle)])
        total += np.sqrt(2.0) * height * np.sin(xy @ k + phase)
    return total


def seams(rng: np.random.Generator, off: Floats, along: Floats, half: float) -> Floats:
    """(n,) distance from the middle of the nearest seam that is to be seen: the bed itself and one
    or two parallels 5 to 30 cm beside it with unmarked rock between them, each with one to three
    gaps of 10 to 50 cm."""
    count = rng.integers(1, 3)
    apart = rng.uniform(max(0.05, 4.0 * half), 0.3, count)
    sides = rng.permutation([-1.0, 1.0])[:count]
    nearest = np.full(len(off), np.inf)
    for offset in [0.0, *(sides * apart)]:
        distance = np.abs(off - offset)
        for _ in range(rng.integers(1, 4)):
            start = rng.uniform(along.min(), along.max())
            distance[(along > start) & (along < start + rng.uniform(0.1, 0.5))] = np.inf
        np.minimum(nearest, distance, out=nearest)
    return np.minimum(nearest, 100.0 * half)


def outcrop(
    rng: np.random.Generator, *, mesh: bool, flat: bool = False, parallel: bool = False
) -> Outcrop | None:
    """None where the bed does not cross it for a metre, or lies along a flat face.

    parallel : there are other seams beside the bed, and all have gaps
    """
    spacing = float(rng.uniform(0.015, 0.04))
    count = round(SIZE / spacing)
    y, x = np.mgrid[0:count, 0:count] * spacing
    xy = np.stack([x.ravel(), y.ravel()], axis=1)
    if not mesh:
        xy = rng.uniform(0.0, SIZE, xy.shape)
    lengths = 10 ** rng.uniform(-0.6, 0.6, 14)
    relief = waves(rng, xy, lengths, 0.05 * lengths * rng.uniform(0.3, 1.0)) * (not flat)
    noise = rng.uniform(0.0, 0.33) * spacing
    points = np.column_stack([xy, relief + noise * rng.standard_normal(len(xy))])
    normal = rng.standard_normal(3)
    normal[2] *= 0.5
    normal /= np.linalg.norm(normal)
    if flat and abs(normal[2]) > np.cos(np.radians(30.0)):
        return None
    middle = np.array([SIZE / 2, SIZE / 2, 0.0])
    middle[2] = relief[np.argmin(((xy - middle[:2]) ** 2).sum(axis=1))]
    # The bed's place wanders over the outcrop: many short waves are as good as a Gaussian field.
    wander = rng.uniform(0.0, 0.01)
    short = rng.uniform(0.25, 0.5, 30)
    off = (points - middle) @ normal + waves(rng, xy, short, np.full(30, wander / np.sqrt(30)))
    half = rng.uniform(0.5, 1.5) * spacing
    contrast = 90.0
    beside = np.abs(off)
    if parallel:
        strike = np.cross(normal, [0.0, 0.0, 1.0])
        beside = seams(rng, off, points @ (strike / np.linalg.norm(strike)), half)
    grey = 150.0 - contrast / (1.0 + np.exp(np.clip((beside - half) / (0.2 * half), -30, 30)))
    grey += rng.uniform(0.0, 0.5) * contrast * rng.standard_normal(len(grey))
    colours = np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[:, None], 3, axis=1)
    on = np.flatnonzero((np.abs(off) < spacing) & (beside < 3.0 * spacing))
    if len(on) < 30:
        return None
    along = np.linalg.svd(points[on] - points[on].mean(axis=0), full_matrices=False)[2][0]
    t = (points[on] - points[on].mean(axis=0)) @ along
    if np.ptp(t) < 1.0:
        return None
    chosen = [on[np.argmin(np.abs(t - np.quantile(t, q)))] for q in (0.03, 0.5, 0.97)]
    if not mesh:
        return Outcrop(PointCloud(points, colors=colours), normal, points[chosen], spacing)
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([a, a + 1, a + count], axis=1),
            np.stack([a + 1, a + count + 1, a + count], axis=1),
        ]
    )
    made = Mesh(points, faces.astype(np.int32), colors=colours)
    return Outcrop(made, normal, points[chosen], spacing)


def holds(fit: FittedPlane, normal: Floats) -> bool:
    """Whether the true normal is inside the joint region."""
    if fit.max_confidence95_deg is None or fit.min_confidence95_deg is None:
        return False
    own = fit.axes @ (normal if normal @ fit.normal > 0 else -normal)
    largest, smallest = np.radians([fit.max_confidence95_deg, fit.min_confidence95_deg])
    if largest >= np.pi / 2:
        return True
    second, first = own[1] / own[2] / np.tan(largest), own[0] / own[2] / np.tan(smallest)
    return bool(second**2 + first**2 <= 1.0)


@dataclass(frozen=True)
class Followed:
    """The fit of a followed trace, the face (3,) around it, its path, what of it is outside of
    doubtful stretches, its true error, and the resolution of the model."""

    fit: FittedPlane
    face: Floats | None
    path: Path
    rest: RemainingTrace | None
    error_deg: float
    resolution: float

    @property
    def total_deg(self) -> float:
        return self.judged(plain=False)[0]

    def judged(self, *, plain: bool) -> tuple[float, bool]:
        """Stated error and whether it is good; plain : without regard to doubtful stretches."""
        rest = None if plain else self.rest
        stretch = None if rest is None else rest.error95_deg(self.fit, self.resolution, self.face)
        total = total_error_deg(
            self.fit, self.resolution, outcrop_normal=self.face, stretch_error_deg=stretch
        )
        verdict = judge(
            self.fit,
            resolution_m=self.resolution,
            outcrop_normal=self.face,
            surface_findings=() if rest is None else rest.findings(),
            stretch_error_deg=stretch,
        )
        return 90.0 if total is None else total, verdict.quality == "good"

    def strays(self, made: Outcrop) -> bool:
        """Whether the bed is in fact not where all doubtful stretches are."""
        off = np.abs((self.path.points - made.way_points.mean(axis=0)) @ made.normal)
        assert self.rest is not None
        return all(np.median(off[s.start : s.end + 1]) > 0.04 for s in self.rest.stretches)


def measured(made: Outcrop, cost: str) -> Followed | None:
    """The plane of a followed trace; None if there is none."""
    try:
        surface = SurfaceGraph(made.data)
        near = index_vertices(surface)
        if cost == AUTO:
            spacing, face_near = made.spacing, near.outcrop_normal
            path = follow_best(surface, made.way_points, lambda _: spacing, face_near)[0]
        else:
            path = Follower(surface, cost).follow(made.way_points)
        fit = fit_plane(path.points)
    except GeometryError:
        return None
    face = near.outcrop_normal(path.points)
    cosine = min(abs(float(fit.normal @ made.normal)), 1.0)
    error = float(np.degrees(np.arccos(cosine)))
    rest = fit_remaining_plane(
        path.points, find_jumps(path.points, path.costs, path.way_point_rows, made.spacing)
    )
    return Followed(fit, face, path, rest, error, made.spacing)


def jumps(count: int, seed: int, *, mesh: bool, cost: str, parallel: bool) -> dict[str, float]:
    """Figures of `count` simulated traces with and without the search for doubtful stretches."""
    rng = np.random.default_rng(seed)
    rows: list[list[float]] = []
    while len(rows) < count:
        made = outcrop(rng, mesh=mesh, parallel=parallel)
        found = None if made is None else measured(made, cost)
        if made is None or found is None:
            continue
        marked = found.rest is not None
        wrongly = marked and not found.strays(made)
        before, after = found.judged(plain=True), found.judged(plain=False)
        rows.append([found.error_deg, marked, wrongly, *before, *after])
    error, marks, wrong, *told = np.array(rows, np.float64).T
    result = {"marked": float(marks.mean()), "false": float(wrong.mean())}
    for name, total, good in (("before", *told[:2]), ("after", *told[2:])):
        for who, chosen in (("all", total > -1), ("good", good > 0), ("to15", total <= 15.0)):
            held = (error <= total)[chosen]
            result[f"{name}_{who}_n"] = len(held)
            result[f"{name}_{who}"] = float(held.mean()) if len(held) else 1.0
    return result


def population(
    count: int, seed: int, *, mesh: bool, cost: str, flat: bool = False
) -> dict[str, float]:
    """Figures of `count` simulated traces."""
    rng = np.random.default_rng(seed)
    joint, total, stated, true, good, band = [], [], [], [], [], []
    while len(true) < count:
        made = outcrop(rng, mesh=mesh, flat=flat)
        found = None if made is None else measured(made, cost)
        if made is None or found is None:
            continue
        fit, face = found.fit, found.face
        joint.append(holds(fit, made.normal))
        total.append(found.error_deg <= found.total_deg)
        stated.append(found.total_deg)
        true.append(found.error_deg)
        straight = find_plane_band(fit, resolution_m=made.spacing, outcrop_normal=face)
        if straight is not None:
            band.append(bool(straight.contains(made.normal)[0]))
        good.append(found.judged(plain=False)[1])
    return {
        "joint": float(np.mean(joint)),
        "total": float(np.mean(total)),
        "banded": len(band) / count,
        "band": float(np.mean(band)) if band else 1.0,
        "good": float(np.mean(good)),
        "stated_deg": float(np.median(stated)),
        "true_deg": float(np.median(true)),
        "good_but_off": float(np.mean(np.array(true)[np.array(good)] > 5.0)) if any(good) else 0.0,
    }


def print_jumps(count: int, seed: int, cost: str) -> None:
    print(f"{'':24}{'marked':>8}{'false':>8}{'all':>16}{'good':>22}{'15 deg':>26}")
    for parallel in (True, False):
        for mesh in (False, True):
            found = jumps(count, seed, mesh=mesh, cost=cost, parallel=parallel)
            name = f"{'parallel' if parallel else 'single'} {'mesh' if mesh else 'cloud'}"
            line = f"{name + ', ' + cost:24}{found['marked']:8.1%}{found['false']:8.1%}"
            for who in ("all", "good", "to15"):
                for when in ("before", "after"):
                    held, n = found[f"{when}_{who}"], found[f"{when}_{who}_n"]
                    line += f"{held:8.1%} ({n:d})"
            print(line, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--traces", type=int, default=150)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jumps", metavar="COST", nargs="?", const="dark")
    args = parser.parse_args()
    if args.jumps:
        print_jumps(args.traces, args.seed, args.jumps)
        return
    print(
        f"{'':22}{'joint':>8}{'total':>8}{'good':>8}{'off':>8}{'stated':>9}{'true':>8}"
        f"{'banded':>8}{'band':>8}"
    )
    for mesh, flat in ((False, False), (True, False), (False, True), (True, True)):
        for cost in ("colour", "dark", AUTO):
            found = population(args.traces, args.seed, mesh=mesh, cost=cost, flat=flat)
            name = f"{'flat ' * flat}{'mesh' if mesh else 'cloud'}, {cost}"
            print(
                f"{name:22}{found['joint']:8.1%}{found['total']:8.1%}{found['good']:8.1%}"
                f"{found['good_but_off']:8.1%}{found['stated_deg']:9.2f}{found['true_deg']:8.2f}"
                f"{found['banded']:8.0%}{found['band']:8.1%}",
                flush=True,
            )


if __name__ == "__main__":
    main()
