"""How often registrations by control points hold: clicks, marks in photos, drifting receivers.

    python -m tests.benchmarks.bench_control [RUNS]

Every run draws a rotation, a scale, points and their errors anew. Printed are, per row, the shares
of runs in which the truth lies within the stated 95 % (rotation about east, north and up, scale,
shift east, north and up of the centre), the share of runs without a blunder in which a point is
flagged, and that of runs with one blunder in which it and no other point is flagged.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from tests.photogrammetry.georeferencing.test_georeference import scene_of
from tests.photogrammetry.made_photos import around, face
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.cameras import View
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.control import place_by_control
from vomstudio.registration.adjustment import Adjustment, adjust
from vomstudio.registration.blunders import find_blunders
from vomstudio.registration.evidence import Evidence, register, triangulate_marks
from vomstudio.registration.observations import Points
from vomstudio.registration.similarity import Similarity, fit_similarity
from vomstudio.registration.similarity_observation import difference

Array = npt.NDArray[np.float64]
FACE = face(30)
_Z95 = 1.959963984540054

WALL, TERRACE, QUARRY = (45.0, 8.0, 24.0), (130.0, 85.0, 9.0), (22.0, 18.0, 15.0)
"""Extents of the points, metres; the registrations of the documentation are 75 x 30 x 37 m."""


@dataclass(frozen=True)
class Case:
    """Points with errors, metres, one sigma, of each coordinate.

    survey_m : (east, north, up); stated : whether it is in the table
    click_error_m : true error of the click; given_m : as stated, None for half of `resolution_m`
    drift : correlation of the errors of neighbours in the table
    blunder_m : size of the mistake in runs with one, 0 for no such runs
    """

    name: str
    count: int
    shape: tuple[float, float, float]
    survey_m: tuple[float, float, float] = (0.01, 0.01, 0.01)
    stated: bool = True
    click_error_m: float = 0.0
    given_m: float | None = None
    resolution_m: float | None = None
    drift: float = 0.0
    blunder_m: float = 0.5


def _spread(case: Case, rng: np.random.Generator) -> Array:
    """Points (n, 3) as somebody places them: not nearly on a line."""
    while True:
        exact = np.asarray(rng.uniform(-0.5, 0.5, (case.count, 3)) * case.shape)
        sizes = np.linalg.svd(exact - exact.mean(axis=0), compute_uv=False)
        if sizes[1] > 0.15 * sizes[0]:
            return exact


def draw_run(case: Case, rng: np.random.Generator, *, blunder: bool) -> Run:
    """Draw a model and the errors of its points."""
    scale = float(rng.uniform(0.5, 3.0))
    truth = Similarity(
        scale,
        Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix(),
        np.array([398_000.0, 4_980_000.0, 320.0]),
    )
    exact = _spread(case, rng)
    errors = rng.normal(size=exact.shape)
    for row in range(1, case.count):
        errors[row] = case.drift * errors[row - 1] + np.sqrt(1.0 - case.drift**2) * errors[row]
    wrong = None
    world = exact + truth.translation + errors * case.survey_m
    if blunder:
        wrong = int(rng.integers(case.count))
        away = rng.normal(size=3)
        world[wrong] += case.blunder_m * away / np.linalg.norm(away)
    clicked = exact + rng.normal(size=exact.shape) * case.click_error_m
    model = truth.inverse(clicked + truth.translation)
    sigma = np.tile(case.survey_m if case.stated else (np.nan,) * 3, (case.count, 1))
    labels = [f"P{row}" for row in range(case.count)]
    click_error_m = None if case.given_m is None else np.full(case.count, case.given_m)
    covariance = None
    if case.resolution_m is not None:
        half = 0.5 * case.resolution_m / scale
        covariance = np.tile(half**2 * np.eye(3), (case.count, 1, 1))
    control = Points(
        labels, model, world, sigma, click_error_m=click_error_m, covariance=covariance
    )
    return Run(control, truth, None if wrong is None else labels[wrong])


@dataclass(frozen=True, eq=False)
class Run:
    """Control points, true similarity, and label of the point that is wrong."""

    control: Points
    truth: Similarity
    wrong: str | None

    def adjusted(self) -> tuple[Adjustment, list[str]]:
        """The adjustment, and the labels of points that are flagged."""
        model = self.control.model
        centre = model.mean(axis=0, keepdims=True)
        size = float(np.sqrt(((model - centre) ** 2).sum(axis=1).mean()))
        found = adjust([self.control], centre, size)
        flagged = find_blunders([self.control], found, centre, size)
        return found, [blunder.label for blunder in flagged]


@dataclass
class Shares:
    """Counts of runs: inside the stated 95 % (7,), flagged without and detected with a blunder."""

    inside: Array = field(default_factory=lambda: np.zeros(7))
    runs: int = 0
    flagged: int = 0
    detected: int = 0
    refused: int = 0

    def row(self, name: str, runs: int, *, blunders: bool = True) -> str:
        shares = "  ".join(f"{100 * v / max(self.runs, 1):5.1f}" for v in self.inside)
        names = f"{100 * self.flagged / runs:5.1f}" if blunders else "     "
        names += f"  {100 * self.detected / runs:5.1f}" if blunders else ""
        refused = f"  refused {100 * self.refused / runs:.1f}" if self.refused else ""
        return f"{name:64s}  {shares}  {names}{refused}"


def is_inside(found: Similarity, truth: Similarity, covariance: Array, centre: Array) -> Array:
    """Return which of the seven parameters (7,) lie within the stated 95 %."""
    off = np.abs(difference(found, truth, centre))
    return np.asarray(off <= _Z95 * np.sqrt(np.diag(covariance)))


def points(case: Case, runs: int, seed: int) -> Shares:
    rng = np.random.default_rng(seed)
    shares = Shares()
    for _ in range(runs):
        run = draw_run(case, rng, blunder=False)
        found, flagged = run.adjusted()
        shares.runs += 1
        shares.inside += is_inside(found.fit, run.truth, found.covariance, found.centre)
        shares.flagged += bool(flagged)
        if case.blunder_m:
            run = draw_run(case, rng, blunder=True)
            shares.detected += run.adjusted()[1] == [run.wrong]
    return shares


@dataclass(frozen=True)
class MarkCase:
    """Points marked in photos with an error of `mark_px`; one in `wrong_every` marks is wrong."""

    name: str
    count: int
    mark_px: float
    photos: int
    survey_m: float = 0.01
    stated: bool = True
    wrong_every: int = 0


def marks_of(case: MarkCase, views: list[View], rng: np.random.Generator) -> tuple[Array, list]:
    """Return the exact points (n, 3) in the frame of the views, and their marks."""
    exact, marks = [], []
    while len(exact) < case.count:
        place = rng.uniform([-4.5, -0.6, 0.0], [4.5, 0.6, 4.5])
        seen = [v for v in views if v.contains(v.project(place))[0]]
        if len(seen) < case.photos:
            continue
        label = f"P{len(exact)}"
        exact.append(place)
        for number in rng.choice(len(seen), case.photos, replace=False):
            pixel = seen[number].project(place)[0] + rng.normal(0, case.mark_px, 2)
            if case.wrong_every and rng.integers(case.wrong_every) == 0:
                pixel = pixel + rng.uniform(300.0, 900.0) * np.sign(rng.normal(size=2))
            marks.append(Mark(label, seen[number].name, float(pixel[0]), float(pixel[1])))
    return np.array(exact), marks


def marked(case: MarkCase, runs: int, seed: int, *, reconstruct: bool) -> Shares:
    rng = np.random.default_rng(seed)
    views = around()
    scene = scene_of(views, FACE)
    shares = Shares()
    for _ in range(runs):
        truth = Similarity(
            1.0,
            Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix(),
            np.array([400_000.0, 5_000_000.0, 300.0]),
        )
        exact, marks = marks_of(case, views, rng)
        world = truth(exact) + rng.normal(size=exact.shape) * case.survey_m
        sigma = case.survey_m if case.stated else None
        try:
            found, covariance, centre = (by_reconstruct if reconstruct else by_register)(
                scene, views, world, sigma, marks
            )
        except GeometryError:
            shares.refused += 1
            continue
        shares.runs += 1
        shares.inside += is_inside(found, truth, covariance, centre)
    return shares


def by_register(
    scene: SparseScene, views: list[View], world: Array, sigma: float | None, marks: list[Mark]
) -> tuple[Similarity, Array, Array]:
    evidence = Evidence(views={view.name: view for view in views})
    places = triangulate_marks(evidence, [(m.label, m.photo, m.x, m.y) for m in marks])
    rows = [row for row in range(len(world)) if f"P{row}" in places]
    evidence.pairs = Pairs(
        tuple(f"P{row}" for row in rows),
        np.array([places[f"P{row}"][0] for row in rows]),
        world[rows],
        np.full((len(rows), 3), np.nan if sigma is None else sigma),
        np.zeros(len(rows), bool),
        covariance=np.array([places[f"P{row}"][1] for row in rows]),
    )
    placed = register(evidence)
    matrix = np.array(placed.matrix)
    found = Similarity(placed.scale, matrix[:3, :3] / placed.scale, matrix[:3, 3])
    return found, np.array(placed.covariance), np.array(placed.centre)


def by_reconstruct(
    scene: SparseScene, views: list[View], world: Array, sigma: float | None, marks: list[Mark]
) -> tuple[Similarity, Array, Array]:
    control = [
        ControlPoint(f"P{row}", tuple(place), sigma)  # type: ignore[arg-type]
        for row, place in enumerate(world.tolist())
    ]
    placed, report = place_by_control(scene, control, marks, includes_adjustment=False)
    found = fit_similarity(FACE, placed.points + placed.origin)
    return found, report.covariance, np.array(report.centre)


_SURVEYS = ((12, "terrace", TERRACE), (30, "wall", WALL))
GNSS = (0.02, 0.02, 0.03)
CASES = (
    *(
        Case(
            f"{n} points on a {name}, survey 1 cm, click 4 cm: given",
            n,
            shape,
            click_error_m=0.04,
            given_m=0.04,
        )
        for n, name, shape in (
            (3, "wall", WALL),
            (4, "wall", WALL),
            (6, "wall", WALL),
            (12, "wall", WALL),
            (4, "terrace", TERRACE),
            (6, "terrace", TERRACE),
        )
    ),
    *(
        Case(
            f"{n} points in a quarry, survey 1 cm, click 4 cm: half of 8 cm",
            n,
            QUARRY,
            click_error_m=0.04,
            resolution_m=0.08,
        )
        for n in (3, 6, 20)
    ),
    Case(
        "6 points on a wall, survey 2, 2, 4 cm, click 1 cm: given",
        6,
        WALL,
        (0.02, 0.02, 0.04),
        click_error_m=0.01,
        given_m=0.01,
    ),
    Case(
        "6 points on a wall, survey 1 cm, click 4 cm: taken as exact",
        6,
        WALL,
        click_error_m=0.04,
        given_m=0.0,
    ),
    Case(
        "3 points on a wall, survey 1 cm, click 4 cm: taken as exact",
        3,
        WALL,
        click_error_m=0.04,
        given_m=0.0,
    ),
    Case(
        "6 points on a wall, not stated, click 4 cm",
        6,
        WALL,
        stated=False,
        click_error_m=0.04,
        given_m=0.04,
    ),
    *(
        Case(
            f"{n} points on a {name} by GNSS of 2, 2, 3 cm {'' if stated else 'not '}stated, "
            f"correlation {drift}",
            n,
            shape,
            GNSS,
            stated,
            click_error_m=0.005,
            given_m=0.005,
            drift=drift,
            blunder_m=0.0,
        )
        for n, name, shape in _SURVEYS
        for stated in (True, False)
        for drift in (0.0, 0.8, 0.95)
    ),
)

MARK_CASES = (
    *(
        MarkCase(f"{n} points marked in {k} photos to {px:g} px, survey 1 cm stated", n, px, k)
        for n, k, px in ((4, 4, 15.0), (8, 3, 5.0))
    ),
    MarkCase(
        "5 points marked in 5 photos to 10 px, one mark in 12 wrong", 5, 10.0, 5, wrong_every=12
    ),
    MarkCase("6 points marked in 4 photos to 10 px, survey not stated", 6, 10.0, 4, stated=False),
)


def main(runs: int, seed: int = 20) -> None:
    heads = "turn E    N      up  scale      E      N     up  flagged  found"
    print(f"{'control':64s}  {heads}")
    for number, case in enumerate(CASES):
        print(points(case, runs, seed + number).row(case.name, runs), flush=True)
    for number, case in enumerate(MARK_CASES):
        for reconstruct in (False, True):
            command = "reconstruct" if reconstruct else "register"
            shares = marked(case, runs, seed + number, reconstruct=reconstruct)
            print(shares.row(f"{command}: {case.name}", runs, blunders=False), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
