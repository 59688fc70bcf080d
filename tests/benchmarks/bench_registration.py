"""How often the true rotation lies within the stated 95 % of registrations of each kind.

    python -m tests.benchmarks.bench_registration [RUNS [WORDS [SEED]]]

With WORDS, only the kinds whose names contain them. Every run draws errors anew around a model
of 30 m whose true place is known. Printed are, per kind, the share of runs in which the true turn
about up, east and north lies within what is stated for each, and in which a plane is off by at most
the half-angle that the registration gives it (`registration_error_deg`, the larger one of an
ellipse, so that more than 95 % are wanted); the median of the stated worst error; and how often the
axis named the weakest is within 20 degrees of that of the true covariance, where that exceeds the
second by a factor of 2.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from vomstudio.geology.orientation import Line
from vomstudio.geology.view_attitudes import camera_rotations, error_axes
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.rotation_errors import errors_95_deg
from vomstudio.io.control.attitude_tables import attitude_table
from vomstudio.registration.attitude_evidence import MOUNT_SIGMA_DEG, match_attitudes
from vomstudio.registration.observations import Attitudes, Directions, ObservationKind, Points
from vomstudio.registration.placing import place
from vomstudio.registration.similarity import rotation_covariance

Array = npt.NDArray[np.float64]
_SCALE, _SHIFT = 2.5, np.array([398_000.0, 4_980_000.0, 320.0])
_SIZE_M = 30.0


@dataclass(frozen=True)
class Case:
    """draw : observations of a true rotation; weak : (3, 3) the true covariance, or None"""

    name: str
    draw: Callable[[np.random.Generator, Array], list[ObservationKind]]
    weak: Callable[[], Array] | None = None


def _spread(rng: np.random.Generator, n: int, shape: tuple[float, float, float]) -> Array:
    return rng.uniform(-0.5, 0.5, (n, 3)) * np.array(shape) * _SIZE_M


def _to_world(model: Array, turn: Array) -> Array:
    return _SCALE * model @ turn.T + _SHIFT


def _points(
    n: int,
    sigma: tuple[float, float, float],
    stated: bool,
    shape: tuple[float, float, float] = (1.0, 0.4, 0.5),
    name: str = "points",
) -> Callable[[np.random.Generator, Array], list[ObservationKind]]:
    def draw(rng: np.random.Generator, turn: Array) -> list[ObservationKind]:
        model = _spread(np.random.default_rng(n), n, shape)
        world = _to_world(model, turn) + rng.normal(size=(n, 3)) * sigma
        told = np.tile(np.array(sigma) if stated else np.full(3, np.nan), (n, 1))
        return [Points([str(i) for i in range(n)], model, world, told, name)]

    return draw


def _weak_of(n: int, sigma: tuple[float, float, float], shape: tuple[float, float, float]) -> Array:
    model = _spread(np.random.default_rng(n), n, shape)
    return rotation_covariance(_SCALE * model @ _TURN.T, np.array(sigma))


def _compass(
    n: int, deg: float, north_deg: float = 0.0, stated_deg: float | None = None
) -> Callable[[np.random.Generator, Array], list[ObservationKind]]:
    """north_deg : one sigma of what all are off alike; stated_deg : what is stated of it, None for
    the same"""

    def draw(rng: np.random.Generator, turn: Array) -> list[ObservationKind]:
        model = Rotation.random(n, random_state=n).as_matrix()[:, :, 0]
        world = model @ turn.T
        wrong = rng.normal(size=world.shape) * np.radians(deg)
        world = world + wrong - (wrong * world).sum(axis=1)[:, None] * world
        world /= np.linalg.norm(world, axis=1, keepdims=True)
        north = Rotation.from_euler("z", rng.normal() * north_deg, degrees=True).as_matrix()
        world = world @ north.T
        sigma = np.full((n, 2), np.radians(deg))
        doubt = float(np.radians(north_deg if stated_deg is None else stated_deg))
        return [Directions([str(i) for i in range(n)], model, world, sigma, north_sigma=doubt)]

    return draw


@dataclass(frozen=True)
class FewPlanes:
    """Readings of which one may be wrong: all of them, those that are right, and its label, None
    where all are right"""

    kind: Directions
    rest: Directions
    wrong: str | None


def few_planes(
    rng: np.random.Generator,
    n: int,
    added_deg: float | None,
    *,
    stated: bool = True,
    deg: float = 3.0,
) -> FewPlanes:
    """Planes of any dip direction that dip by 25 to 85 degrees, read to 3 degrees; to the dip
    direction of one of them `added_deg` is added."""
    azimuth, dip = rng.uniform(0.0, 360.0, n), rng.uniform(25.0, 85.0, n)
    model = _normals(azimuth, dip) @ _TURN
    across = deg / np.sin(np.radians(dip))
    read = azimuth + rng.normal(size=n) * across
    wrong = int(rng.integers(n))
    if added_deg is not None:
        read[wrong] += added_deg
    world = _normals(read, dip + rng.normal(size=n) * deg)
    sigma = np.full((n, 2), np.radians(deg) if stated else np.nan)
    labels = [f"C{i}" for i in range(n)]
    rest = [i for i in range(n) if added_deg is None or i != wrong]
    return FewPlanes(
        Directions(labels, model, world, sigma),
        Directions([labels[i] for i in rest], model[rest], world[rest], sigma[rest]),
        None if added_deg is None else labels[wrong],
    )


def _normals(azimuth: Array, dip: Array) -> Array:
    a, d = np.radians(azimuth), np.radians(dip)
    return np.column_stack([np.sin(d) * np.sin(a), np.sin(d) * np.cos(a), np.cos(d)])


@dataclass(frozen=True)
class Named:
    """Shares of runs in which the wrong reading, another one, and the wrong one as the likeliest
    (named or not) came out"""

    right: float
    wrong: float
    first: float


_ADDED = {"strike": (90.0, -90.0), "opposite": (180.0,), "digit": (-40.0, -30.0, 30.0, 40.0)}


def named_shares(n: int, mistake: str | None, runs: int, *, stated: bool) -> Named:
    rng = np.random.default_rng(n)
    right = wrong = first = 0
    for _ in range(runs):
        added = None if mistake is None else float(rng.choice(_ADDED[mistake]))
        drawn = few_planes(rng, n, added, stated=stated)
        found = place([drawn.kind])
        named = [blunder.label for blunder in found.blunders]
        right += drawn.wrong is not None and named == [drawn.wrong]
        wrong += bool(named) and named != [drawn.wrong]
        first += bool(found.without) and found.without[0].label == drawn.wrong
    return Named(right / runs, wrong / runs, first / runs)


def _gimbal(
    n: int, north_deg: float
) -> Callable[[np.random.Generator, Array], list[ObservationKind]]:
    def draw(rng: np.random.Generator, turn: Array) -> list[ObservationKind]:
        fixed = np.random.default_rng(n)
        angles = np.column_stack(
            [fixed.uniform(0, 360, n), fixed.uniform(-50, 10, n), fixed.uniform(-3, 3, n)]
        )
        true = camera_rotations(angles)
        sigma = np.array([2.0, 0.5, 0.5])
        read = angles + rng.normal(size=angles.shape) * sigma
        read[:, 0] += rng.normal() * north_deg
        world, axes = camera_rotations(read), error_axes(read)
        model = turn.T @ true
        labels = [str(i) for i in range(n)]
        told = np.radians(np.tile(sigma, (n, 1)))
        return [Attitudes(labels, model, world, axes, told, np.radians(north_deg))]

    return draw


def _phones(
    n: int, north_deg: float
) -> Callable[[np.random.Generator, Array], list[ObservationKind]]:
    """The vertical by accelerometers, off by 0.7 deg in each photo and by 1 deg against the camera
    in all, the azimuth by compasses, off by 5 deg each and by what they have in common; no accuracy
    stated."""

    def draw(rng: np.random.Generator, turn: Array) -> list[ObservationKind]:
        fixed = np.random.default_rng(n)
        angles = np.column_stack(
            [fixed.uniform(0, 360, n), fixed.uniform(-30, 10, n), fixed.uniform(-5, 5, n)]
        )
        true = camera_rotations(angles)
        trembling = Rotation.from_rotvec(np.radians(0.7) * rng.normal(size=(n, 3))).as_matrix()
        mount = Rotation.from_rotvec(np.radians(MOUNT_SIGMA_DEG) * rng.normal(size=3)).as_matrix()
        down = -(trembling @ true @ mount)[:, 2, :]
        read = angles[:, 0] + 5.0 * rng.normal(size=n) + north_deg * rng.normal()
        names = tuple(str(i) for i in range(n))
        told = np.column_stack([read, np.full((n, 2), np.nan)])
        table = attitude_table(names, told, is_doubted=True, down=down)
        lens = Intrinsics.pinhole(4, 3, 3.0, 2.0, 1.5)
        views = [View(i, lens, t.T @ turn, np.zeros(3)) for i, t in zip(names, true, strict=True)]
        return list(match_attitudes(table, range(n), views, north_deg, []).kinds)

    return draw


_TURN = Rotation.from_euler("zyx", [130.0, 12.0, -7.0], degrees=True).as_matrix()
_CM = (0.01, 0.01, 0.01)
_FLAT, _LINE = (1.0, 0.4, 0.5), (1.0, 0.05, 0.05)

CASES = (
    *(Case(f"{n} points, 1 cm stated", _points(n, _CM, True)) for n in (3, 4, 6, 12)),
    *(Case(f"{n} points, 1 cm not stated", _points(n, _CM, False)) for n in (3, 4, 5, 8, 12)),
    *(
        Case(f"{n} points, heights twice as bad, not stated", _points(n, (0.01, 0.01, 0.02), False))
        for n in (4, 8)
    ),
    Case(
        "8 points nearly on a line, 1 cm stated",
        _points(8, _CM, True, _LINE),
        lambda: _weak_of(8, _CM, _LINE),
    ),
    Case(
        "30 cameras along a line, GPS of 1.5 and 3 m, not stated",
        _points(30, (1.5, 1.5, 3.0), False, (1.0, 0.15, 0.1), "cameras"),
        lambda: _weak_of(30, (1.5, 1.5, 3.0), (1.0, 0.15, 0.1)),
    ),
    Case("20 gimbal angles, yaw 2, pitch and roll 0.5 deg", _gimbal(20, 0.0)),
    Case("20 gimbal angles, north wrong by 10 deg (1 sigma)", _gimbal(20, 10.0)),
    Case("10 phones, vertical 0.7, compass 5 deg and 10 for all alike", _phones(10, 10.0)),
    Case("40 phones, vertical 0.7, compass 5 deg and 10 for all alike", _phones(40, 10.0)),
    Case("6 compass planes of 2 deg", _compass(6, 2.0)),
    Case("15 compass planes of 3 deg", _compass(15, 3.0)),
    Case("8 compass planes of 2 deg, all off by 5 deg (1 sigma)", _compass(8, 2.0, 5.0)),
    Case("15 compass planes of 3 deg, all off by 2 deg (1 sigma)", _compass(15, 3.0, 2.0)),
)
OFFSETS = (
    Case("6 compass planes of 3 deg, no common offset, none stated", _compass(6, 3.0)),
    Case("6 compass planes of 3 deg, offset 2 deg, stated", _compass(6, 3.0, 2.0)),
    Case("6 compass planes of 3 deg, offset 2 deg, none stated", _compass(6, 3.0, 2.0, 0.0)),
    Case("6 compass planes of 3 deg, no offset, 2 deg stated", _compass(6, 3.0, 0.0, 2.0)),
)
"""Compass alone: the common offset of its readings, and what is stated of it (1 sigma)."""


@dataclass(frozen=True)
class Outcome:
    """Shares of runs; axes : None where there is no weak axis to be named"""

    up: float
    east: float
    north: float
    planes: float
    median_deg: float
    axes: float | None


def outcome(case: Case, runs: int, seed: int = 1) -> Outcome:
    rng = np.random.default_rng(seed)
    inside = np.zeros(4)
    worst = []
    named = 0
    true_axis = None if case.weak is None else np.linalg.eigh(case.weak())[1][:, -1]
    for _ in range(runs):
        found = place(case.draw(rng, _TURN))
        turned = np.array(found.matrix)[:3, :3] / found.scale @ _TURN.T
        east, north, up = np.abs(np.degrees(Rotation.from_matrix(turned).as_rotvec()))
        limits = found.rotation_error_95_deg
        normal = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()[0]
        seen = turned @ normal
        told = errors_95_deg(np.array(found.covariance)[:3, :3], seen)[0]
        off = np.degrees(np.arctan2(np.linalg.norm(np.cross(seen, normal)), seen @ normal))
        assert limits.about_up is not None
        assert limits.about_east is not None
        assert limits.about_north is not None
        inside += [
            up <= limits.about_up,
            east <= limits.about_east,
            north <= limits.about_north,
            off <= told,
        ]
        worst.append(limits.weakest.error_deg or 0.0)
        if true_axis is not None:
            line = Line(limits.weakest.trend_deg, limits.weakest.plunge_deg).vector()
            named += abs(float(np.dot(line, true_axis))) > np.cos(np.radians(20.0))
    return Outcome(
        *(float(v) for v in inside / runs),
        float(np.median(worst)),
        None if true_axis is None else named / runs,
    )


def main(runs: int, words: str = "", seed: int = 1) -> None:
    """words : of the cases that are run, "" for all"""
    print(f"{'kind':52s}  up     east   north  planes  median 95 %  weak axis named")
    for case in (*CASES, *OFFSETS):
        if words not in case.name:
            continue
        found = outcome(case, runs, seed)
        axes = "" if found.axes is None else f"{100 * found.axes:.1f} %"
        shares = "  ".join(
            f"{100 * v:5.1f}" for v in (found.up, found.east, found.north, found.planes)
        )
        print(f"{case.name:52s}  {shares}  {found.median_deg:8.3f} deg  {axes}", flush=True)
    if words:
        return
    print("\none wrong reading of a few planes       named  another  likeliest")
    for n in (4, 6, 8):
        for stated in (True, False):
            for mistake in (None, *_ADDED):
                told = named_shares(n, mistake, runs // 10, stated=stated)
                kind = f"{n}, {'stated' if stated else 'not stated'}, {mistake or 'none wrong'}"
                print(
                    f"{kind:38s}  {100 * told.right:5.1f}  {100 * told.wrong:5.1f}  "
                    f"{100 * told.first:5.1f}",
                    flush=True,
                )


if __name__ == "__main__":
    main(
        int(sys.argv[1]) if len(sys.argv) > 1 else 1000,
        sys.argv[2] if len(sys.argv) > 2 else "",
        int(sys.argv[3]) if len(sys.argv) > 3 else 1,
    )
