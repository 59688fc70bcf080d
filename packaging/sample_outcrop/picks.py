"""What a careful geologist would have digitised on the sample outcrop, with the truth of each pick.

A pick is a polyline on the surface of the rock. Its points leave the true plane for two reasons,
both known: the structure itself is uneven (BED_SD and BED_LENGTH, or on joints ROUGHNESS_SD and
ROUGHNESS_LENGTH, of relief.py: Gaussian, covariance sd^2 exp(-distance / length)), and the hand
that picks errs by PICK_SD in every direction, each point on its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import geology
from .geology import Array
from .relief import LOWEST, ROUGHNESS_SD, STOREY_BLEND, WIDTH, Cliff, crossing

PICK_SD = 0.003
SPACING = 0.09  # between picked points, m, about
LONGEST, SHORTEST = 6.0, 3.6  # of a trace, m
KEPT = 0.45  # of the points of a bed, at least, must be found on the rock
TALLEST_STEP = 1.7  # a facet lower than this is not measured, m
BEDS_PER_DOMAIN = 4
HANGING, FOOT = 2, 3  # of DOMAINS, on the two sides of the fault
JOINTS_PER_SET = 3
DOMAINS = (
    "1 west limb",
    "2 crest",
    "3 middle limb hanging wall",
    "3 middle limb footwall",
    "4 east limb",
)


@dataclass(frozen=True)
class Pick:
    """name, kind (bedding, fault, joint), set, true normal (3,), points (n, 3) from ORIGIN;
    `horizon` names the bed of a bedding trace, the same on both sides of the fault."""

    name: str
    kind: str
    set_name: str
    normal: Array
    points: Array
    horizon: str = ""


@dataclass(frozen=True)
class Course:
    """Where a pick will run: s and h (n,) on the cliff without unevenness, and what it follows."""

    kind: str
    set_name: str
    normal: Array
    s: Array
    h: Array
    bed: float | None = None
    wall: int = 0


def courses(cliff: Cliff) -> list[Course]:
    """The places worth picking on a cliff: the longest traces and largest facets of each set."""
    return [*_bedding(cliff), *_fault(cliff), *_joints(cliff)]


def draw(cliff: Cliff, chosen: list[Course], rng: np.random.Generator) -> list[Pick]:
    """Digitise the courses. The cliff's own unevenness is used, so that the points lie on it."""
    picks = []
    count: dict[str, int] = {}
    for course, (s, h) in zip(chosen, _onto(cliff, chosen), strict=True):
        points = geology.place(s, h, cliff.bare(s, h))
        points = points + rng.normal(scale=PICK_SD, size=points.shape)
        if course.kind == "bedding" and len(points) < KEPT * len(course.s):
            continue  # much of it runs along edges, where the surface is not sharp
        prefix = course.set_name + "-" if course.kind == "joint" else course.kind[0].upper()
        count[prefix] = count.get(prefix, 0) + 1
        name = f"{prefix}{count[prefix]:02d}"
        horizon = ""
        if course.bed is not None:
            horizon = f"H{int(np.abs(cliff.beds.boundaries - course.bed).argmin()):02d}"
        picks.append(Pick(name, course.kind, course.set_name, course.normal, points, horizon))
    return picks


def _onto(cliff: Cliff, chosen: list[Course]) -> list[tuple[Array, Array]]:
    """s and h of every course, moved to where the uneven bed or wall meets the rock."""
    places = [(course.s, course.h) for course in chosen]
    for kind, wall in (("bedding", 0), ("fault", 0), ("fault", 1)):
        rows = [i for i, c in enumerate(chosen) if (c.kind, c.wall) == (kind, wall)]
        if not rows:
            continue
        counts = [len(chosen[i].s) for i in rows]
        s = np.concatenate([chosen[i].s for i in rows])
        h = np.concatenate([chosen[i].h for i in rows])
        beds = np.repeat([chosen[i].bed or 0.0 for i in rows], counts)
        # Waves are counted along the normal of the bed, levels along q.
        tilts = np.repeat([float(chosen[i].normal @ geology.RISING) for i in rows], counts)

        def distance(
            s: Array,
            h: Array,
            kind: str = kind,
            wall: int = wall,
            b: Array = beds,
            t: Array = tilts,
        ) -> Array:
            points = geology.place(s, h, cliff.bare(s, h))
            if kind == "bedding":
                return geology.level(points) + cliff.bed_waves(points) / t - b
            side = (-1.0, 1.0)[wall] * geology.FAULT_HALF_WIDTH
            return geology.from_fault(points) + cliff.wall_waves[wall](points) - side

        step = 0.004
        for _ in range(6):
            here = distance(s, h)
            if kind == "bedding":
                h = h - _newton(here, (distance(s, h + step) - here) / step)
            else:
                s = s - _newton(here, (distance(s + step, h) - here) / step)
        sound = np.abs(distance(s, h)) < 0.003
        cuts = np.cumsum(counts)[:-1]
        for i, a, b, ok in zip(
            rows, np.split(s, cuts), np.split(h, cuts), np.split(sound, cuts), strict=True
        ):
            places[i] = (a[ok], b[ok])
    return places


def _newton(value: Array, slope: Array) -> Array:
    slope = np.where(np.abs(slope) < 0.2, np.copysign(0.2, slope), slope)
    return np.asarray(np.clip(value / slope, -0.05, 0.05))


def _bedding(cliff: Cliff) -> list[Course]:
    s = np.arange(0.5, WIDTH - 0.5, 0.05)
    found: list[list[Course]] = [[] for _ in DOMAINS]
    lines = []
    boundaries = cliff.beds.boundaries
    for bed in boundaries[(boundaries > -6.5) & (boundaries < 15)]:
        low, high = np.full(s.shape, LOWEST), np.full(s.shape, 12.0)

        def value(h: Array, bed: float = float(bed)) -> Array:
            return geology.level(geology.place(s, h, cliff.base(s) - 0.8)) - bed

        # First where it would be on a smooth wall, then on the blocks.
        about = crossing(value, low, high, 24)
        known = np.isfinite(about)
        if not known.any():
            continue
        a = np.where(known, about, 0.0)

        def exact(h: Array, bed: float = float(bed)) -> Array:
            return geology.level(geology.place(s, h, cliff.bare(s, h))) - bed

        h = crossing(exact, a - 0.6, a + 0.6, 12)
        lines.append((float(bed), np.where(known, h, np.nan)))
    for bed, h in lines:
        ok = np.isfinite(h)
        filled = np.where(ok, h, 0.0)
        points = geology.place(s, filled, cliff.bare(s, filled))
        ok &= (h > 0.3) & (h < 11.4) & (cliff.surface(s, filled)[1] < -0.12)
        wall = geology.from_fault(points)
        panel = geology.panel_of(points)
        domain = np.select(
            [panel == 0, panel == 1, (panel == 2) & (wall < 0), panel == 2, panel == 3],
            [0, 1, 2, 3, 4],
            -1,
        )
        domain[(np.abs(wall) < 0.45) | ~ok] = -1
        # Keep off the hinges by more than the unevenness of bed and hand.
        shrunk = domain.copy()
        shrunk[1:][domain[1:] != domain[:-1]] = -1
        shrunk[:-1][domain[1:] != domain[:-1]] = -1
        for d in range(len(DOMAINS)):
            rows = _longest_run(shrunk == d, h)
            if rows is None:
                continue
            rows = _at_most(points, rows, LONGEST)
            length = float(np.ptp(points[rows] @ geology.ALONG))
            extent = float(np.linalg.norm(points[rows[-1]] - points[rows[0]]))
            if max(length, extent) < SHORTEST:
                continue
            at_s, at_h = _resampled(s[rows], h[rows], points[rows])
            normal = geology.bed_normal((0, 1, 2, 2, 3)[d])
            found[d].append(Course("bedding", DOMAINS[d], normal, at_s, at_h, bed))
    bends = [{course.bed: _bend(cliff, course) for course in group} for group in found]
    # On both sides of the fault the same beds, which then tell how far it moved.
    for bed in set(bends[HANGING]) & set(bends[FOOT]):
        least = min(bends[HANGING][bed], bends[FOOT][bed])
        bends[HANGING][bed] = bends[FOOT][bed] = 10.0 + least
    chosen = []
    for group, bend in zip(found, bends, strict=True):
        # Those that bend most, but no two on neighbouring beds.
        taken: list[Course] = []
        for course in sorted(group, key=lambda c: -bend[c.bed]):
            if all(abs(course.bed - other.bed) > 0.3 for other in taken):  # type: ignore[operator]
                taken.append(course)
        chosen += taken[:BEDS_PER_DOMAIN]
    return chosen


def _bend(cliff: Cliff, course: Course) -> float:
    """How far the course strays from a straight line, m."""
    points = geology.place(course.s, course.h, cliff.bare(course.s, course.h))
    return float(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1])


def _longest_run(inside: npt.NDArray[np.bool_], h: Array) -> npt.NDArray[np.int64] | None:
    """Rows of the longest unbroken run; a jump in h breaks it."""
    breaks = ~inside
    jump = np.abs(np.diff(h, prepend=h[:1])) > 0.45
    group = np.cumsum(breaks | jump)
    rows = np.flatnonzero(inside)
    if not len(rows):
        return None
    names, counts = np.unique(group[rows], return_counts=True)
    return rows[group[rows] == names[counts.argmax()]]


def _at_most(points: Array, rows: npt.NDArray[np.int64], longest: float) -> npt.NDArray[np.int64]:
    """The middle part of a run that is too long."""
    away = np.abs((points[rows] - points[rows].mean(axis=0)) @ geology.ALONG)
    return rows[away <= longest / 2]


def _resampled(s: Array, h: Array, points: Array) -> tuple[Array, Array]:
    """Places about SPACING apart along the line."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], max(12, int(along[-1] / SPACING)))
    return np.interp(at, along, s), np.interp(at, along, h)


def _fault(cliff: Cliff) -> list[Course]:
    h = np.arange(1.0, 11.4, 0.05)
    found = []
    for wall in (0, 1):
        side = (-1.0, 1.0)[wall] * geology.FAULT_HALF_WIDTH

        def value(s: Array, side: float = side) -> Array:
            return geology.from_fault(geology.place(s, h, cliff.bare(s, h))) - side

        s = crossing(value, np.full(h.shape, 12.0), np.full(h.shape, 24.0), 160)
        ok = np.isfinite(s)
        filled = np.where(ok, s, 18.0)
        ok &= cliff.surface(filled, h)[1] < -0.1
        points = geology.place(filled, h, cliff.bare(filled, h))
        rows = np.flatnonzero(ok)
        for part in np.array_split(rows, 2):
            at_s, at_h = _resampled(filled[part], h[part], points[part])
            found.append(Course("fault", "fault", geology.FAULT_NORMAL, at_s, at_h, wall=wall))
    return found


def _joints(cliff: Cliff) -> list[Course]:
    s, h = np.meshgrid(np.arange(0.5, WIDTH - 0.5, 0.06), np.arange(0.4, 11.4, 0.14))
    outs = cliff.storey_outs(s, h)
    rock = cliff.bare(s, h)
    talus = cliff.surface(s, h)[1] > -0.1
    points = geology.place(s, h, rock)
    height = geology.level(points)
    # Hard beds only, where nothing but roughness parts the face from its joint.
    sound = (np.abs(geology.from_fault(points)) > 1.1) & ~talus & (cliff.hollow(height) < 5e-4)
    sound &= cliff.niche(points, height) == 0.0
    sound &= cliff.niche(points + 0.05 * geology.OUT, height) == 0.0
    sound &= np.abs(height[..., None] - cliff.storeys).min(axis=-1) > STOREY_BLEND + 0.03
    storeys = np.searchsorted(cliff.storeys, height)
    chosen: list[Course] = []
    for name in geology.JOINTS:
        found: list[Course] = []
        for storey, blocks in enumerate(cliff.blocks):
            for block in blocks:
                a, b, c = block.planes[name]
                plane = a + b * s + c * h
                ideal = np.abs(plane - outs[storey]) < 1e-9
                clean = ideal & sound & (storeys == storey)
                # Whatever else has changed the face; roughness never gets so far.
                clean &= np.abs(rock - plane) < 6 * ROUGHNESS_SD
                # A margin to the facet's edges.
                clean[:, 1:-1] &= ideal[:, :-2] & ideal[:, 2:]
                if clean.sum() < 30:
                    continue
                at = np.flatnonzero(clean.any(axis=1))
                if np.ptp(h[at, 0]) < TALLEST_STEP:
                    continue
                ps, ph = [], []
                for i, row in enumerate(at):
                    across = np.flatnonzero(clean[row])
                    across = across[:: max(1, len(across) // 2)]
                    ordered = across if i % 2 == 0 else across[::-1]
                    ps.append(s[row, ordered])
                    ph.append(h[row, ordered])
                at_s, at_h = np.concatenate(ps), np.concatenate(ph)
                step = max(1, len(at_s) // 70)
                normal = geology.plane_normal(*geology.JOINTS[name])
                found.append(Course("joint", name, normal, at_s[::step], at_h[::step]))
        found.sort(key=lambda c: -float(np.ptp(c.h) * (0.3 + np.ptp(c.s))))
        chosen += found[:JOINTS_PER_SET]
    return chosen
