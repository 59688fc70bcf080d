"""From tables and photos to observations of a model's place."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding, Message
from vomstudio.errors import GeometryError, InputError, UsageError
from vomstudio.geology.bowing import Bowing
from vomstudio.geometry import transform
from vomstudio.geometry.cameras import View
from vomstudio.geometry.places import why_no_coordinate
from vomstudio.geometry.triangulation import triangulate
from vomstudio.io.control.attitude_tables import AttitudeTable
from vomstudio.io.control.observation_tables import (
    CompassTable,
    LevelTable,
    Pairs,
    Positions,
    ScaleBar,
)
from vomstudio.registration.attitude_evidence import (
    NORTH_DOUBT_DEG,
    AttitudeMiss,
    Held,
    bowing_by_tilts,
    held,
    misses,
)
from vomstudio.registration.blunders import left_out
from vomstudio.registration.camera_positions import cameras_that_fit
from vomstudio.registration.combined import Combined
from vomstudio.registration.compass_checks import said_of_lone_compass
from vomstudio.registration.compass_evidence import (
    Segment,
    azimuth_lines,
    compass_directions,
    said_of_compass,
)
from vomstudio.registration.coordinate_checks import (
    doubts_about_points,
    require_on_model,
    said_of_feet,
    said_of_noise,
    said_of_views,
)
from vomstudio.registration.length_evidence import kept_scale, lengths_of, said_of_lengths
from vomstudio.registration.level_evidence import LevelLine, level_lines_of, said_of_level_lines
from vomstudio.registration.marks.mark_checks import finder
from vomstudio.registration.marks.wrong_marks import agreeing
from vomstudio.registration.observations import (
    Lengths,
    LevelLines,
    Observed,
    Points,
)
from vomstudio.registration.placing import place, place_robustly, with_warnings
from vomstudio.registration.remarks import said_of_bowing
from vomstudio.registration.results import Placed, PointResidual
from vomstudio.registration.similarity import Similarity
from vomstudio.words import tr, tr_n

Array = npt.NDArray[np.float64]
Marked = tuple[str, str, float, float]
# Up to which 93 % of simulated placements by cameras along a line lie within their stated error.
_UNSURE_DEG = 40.0


@dataclass
class Evidence:
    """Everything that is given; `views` are of the model's cameras, in its own frame, and `centres`
    where these stand, also those of which no more is known."""

    views: Mapping[str, View] = field(default_factory=dict)
    centres: Mapping[str, Array] = field(default_factory=dict)
    pairs: Pairs | None = None
    bars: Sequence[ScaleBar] = ()
    positions: Positions | None = None
    """In metres."""
    attitudes: AttitudeTable | None = None
    """Yaws from the north of the map."""
    north_doubt_deg: float = NORTH_DOUBT_DEG
    """One sigma of what a compass is off for all photos alike."""
    level: LevelTable | None = None
    """In photos."""
    level_lines: Sequence[LevelLine] = ()
    """On the model."""
    compass: CompassTable | None = None
    compass_turn_deg: float = 0.0
    """Added to all azimuths of `compass`."""
    compass_doubt_deg: float = 0.0
    """One sigma of what all azimuths, of `compass` and `azimuths`, may be off alike."""
    lengths: Sequence[Segment] = ()
    """Two ends on the model, and the metres between them."""
    azimuths: Sequence[Segment] = ()
    """From one point on the model to another, and the azimuth of that line, degrees."""
    marks: Sequence[Marked] = ()
    """Of control points in photos: label, photo, x, y."""
    reference: Combined | None = None
    """The model as it was fitted to another one."""
    without: Sequence[str] = ()
    """Labels of what is left out."""
    scale: float | None = None
    """Metres per unit of the model, where that is known beforehand and kept."""
    scale_error: float | None = None
    """Of the kept scale, one sigma, as a share of it; None if it is not known."""
    robust: bool = False
    """Whether what cannot be right beside the others is left out."""
    crs: str | None = None
    """Of World, where it is known."""
    up: Array | None = None
    """(3,) What points up in the model's own frame, where that is known."""

    @property
    def empty(self) -> bool:
        """Nothing was given."""
        given = (self.pairs, self.positions, self.attitudes, self.level, self.compass)
        return all(one is None for one in (*given, self.reference)) and not (
            self.lengths or self.azimuths or self.level_lines
        )

    @property
    def too_few_alone(self) -> bool:
        """Whether there are points and nothing else, and fewer than place a model."""
        others = (self.positions, self.attitudes, self.level, self.compass)
        if self.pairs is None or any(one is not None for one in others):
            return False
        if self.bars or self.lengths or self.azimuths or self.level_lines:
            return False
        return int((~self.pairs.check).sum()) < 3


def register(evidence: Evidence, extent: Array | None = None) -> Placed:
    """The registration by all that is given.

    extent : (n, 3) points of the model that show how far it reaches
    Raises UsageError where something refers to what is not there, GeometryError where the model
    cannot be placed by it.
    """
    said: list[Message] = []
    doubts: list[Message] = []
    kinds: list[Observed] = []
    check = None
    if evidence.pairs is not None:
        control, check = _pairs(evidence.pairs)
        said += evidence.pairs.notes
        require_on_model(evidence.pairs.model, extent)
        kinds.append(control)
        every = evidence.pairs
        doubts += doubts_about_points(control, every.labels, every.world, every.model, evidence.crs)
        said += doubts
    kinds += lengths_of(evidence.bars, evidence.lengths, evidence.pairs)
    if evidence.positions is not None:
        kinds.append(_cameras(evidence, said, doubts))
    attitudes = None
    if evidence.attitudes is not None:
        attitudes = _attitudes(evidence, evidence.attitudes, said)
        kinds += attitudes.kinds
    if evidence.level is not None:
        kinds.append(_level(evidence, evidence.level, extent, said))
    if evidence.level_lines:
        kinds.append(level_lines_of(evidence.level_lines))
    doubt = evidence.compass_doubt_deg
    if evidence.compass is not None:
        read = compass_directions(evidence.compass, evidence.compass_turn_deg, doubt)
        kinds += read
    if evidence.azimuths:
        kinds.append(azimuth_lines(evidence.azimuths, doubt))
    if evidence.reference is not None:
        kinds.append(evidence.reference)
    if evidence.without:
        kinds, check = left_out(kinds, check, evidence.without)
        said.append(tr("Left out as asked: {names}.", names=", ".join(evidence.without)))
    if evidence.compass is not None:
        said += said_of_compass(evidence.compass, kinds)
    if evidence.scale is not None:
        kinds += kept_scale(evidence.scale, kinds, extent, evidence.scale_error)
    try:
        placed = (place_robustly if evidence.robust else place)(
            kinds, check, extent, up=evidence.up, doubted=bool(doubts)
        )
    except GeometryError as error:
        # What looks wrong with the values is the cause: where points lie follows from it.
        causes = [each for each in doubts if isinstance(each, Finding)]
        if causes:
            raise GeometryError.of_finding(causes[0]) from error
        texts = [each for each in said if not isinstance(each, Finding)]
        texts += [] if doubts else [str(error)]
        raise GeometryError(" ".join(texts)) from error
    if evidence.compass is not None and len(kinds) == len(read) and not doubt:
        said += said_of_lone_compass()
    said += said_of_feet(placed.scale, placed.scale_error_95)
    apart = {*evidence.without, *(blunder.label for blunder in placed.blunders)}
    said += said_of_lengths(evidence.bars, evidence.lengths, evidence.pairs, apart)
    said += _said_of_cameras(evidence, kinds, placed)
    if evidence.positions is not None and _alone(kinds):
        _refuse_unsure(placed, doubts)
    if attitudes is not None:
        said += said_of_bowing(_bowing_by_tilts(evidence, placed, extent), photos=True)
    return with_warnings(_with_pixels(placed, evidence), said)


def _with_pixels(placed: Placed, evidence: Evidence) -> Placed:
    """With how far from its marks each control point is seen, in pixels (RMS)."""
    if not evidence.marks or evidence.pairs is None:
        return placed
    places = transform.apply(transform.invert(placed.matrix), evidence.pairs.world)
    known = dict(zip(evidence.pairs.labels, places, strict=True))
    squares: dict[str, list[float]] = {}
    for label, photo, x, y in evidence.marks:
        view = _view(evidence, photo, "--marks")
        if view is not None and label in known:
            miss = view.project(known[label])[0] - [x, y]
            squares.setdefault(label, []).append(float(miss @ miss))

    def told(points: Sequence[PointResidual]) -> tuple[PointResidual, ...]:
        return tuple(
            replace(p, pixels=float(np.sqrt(np.mean(squares[p.label]))))
            if p.label in squares and np.isfinite(squares[p.label]).all()
            else p
            for p in points
        )

    return replace(placed, control=told(placed.control), check=told(placed.check))


# --- points -----------------------------------------------------------------------
def _pairs(pairs: Pairs) -> tuple[Points, Points]:
    def those(which: npt.NDArray[np.bool_]) -> Points:
        rows = np.flatnonzero(which)
        labels = [pairs.labels[i] for i in rows]
        return Points(labels, pairs.model[rows], pairs.world[rows], pairs.sigma[rows])

    return those(~pairs.check), those(pairs.check)


# --- cameras ----------------------------------------------------------------------------------
def _own(evidence: Evidence, known: Mapping[str, Any], field_: str) -> Callable[[str], str | None]:
    """What finds the name of a camera of the model by that of a photo. Raises UsageError where
    nothing is known of them."""
    if not known:
        raise UsageError(
            tr(
                "The file of the model's cameras holds their centres alone, without how they were "
                "turned. Give a file with poses, such as cameras.json, Metashape XML or COLMAP."
            )
            if evidence.centres
            else tr(
                "The cameras of the model are not known. Put its cameras.json beside the model, "
                "as a reconstruction here writes it, or name the file of another program with "
                "--model-cameras."
            ),
            field=field_,
        )
    return finder(list(known))


def _view(evidence: Evidence, photo: str, field_: str) -> View | None:
    """By its name in the folder, or the last part of it, with or without ending."""
    name = _own(evidence, evidence.views, field_)(photo)
    return None if name is None else evidence.views[name]


def _found(
    evidence: Evidence,
    known: Mapping[str, Any],
    photos: Sequence[str],
    field_: str,
    said: list[Message],
) -> tuple[list[int], list[str]]:
    """Rows of photos that are cameras of the model, and their names there."""
    rows, names = [], []
    unknown = []
    find = _own(evidence, known, field_)
    for row, photo in enumerate(photos):
        name = find(photo)
        if name is None:
            unknown.append(photo)
        else:
            rows.append(row)
            names.append(name)
    if not rows:
        raise UsageError(
            tr_n(
                "The {count} photo of the table is not among the cameras of the model "
                "({first}). They are called {known}, …. Check the names.",
                "None of the {count} photos of the table is among the cameras of the model "
                "({first}, …). They are called {known}, …. Check the names.",
                len(photos),
                first=photos[0],
                known=next(iter(known)),
            ),
            field=field_,
        )
    if unknown:
        said.append(
            tr_n(
                "{count} photo of the table is not among the cameras of the model and was left "
                "out: {names}.",
                "{count} photos of the table are not among the cameras of the model and were left "
                "out: {names}.",
                len(unknown),
                names=", ".join(unknown[:8]),
            )
        )
    return rows, names


def _cameras(evidence: Evidence, said: list[Message], doubts: list[Message]) -> Points:
    """said : gets all that is to be known of them, doubts : that which looks wrong"""
    positions = evidence.positions
    assert positions is not None
    said += positions.notes
    own = {name: view.centre for name, view in evidence.views.items()} | dict(evidence.centres)
    rows, names = _found(evidence, own, positions.photos, "--cameras", said)
    world = positions.places[rows].copy()
    for row, there in enumerate(world.tolist()):
        if (why := why_no_coordinate((there[0], there[1], there[2]))) is not None:
            raise InputError(f"{positions.photos[rows[row]]}: {why}")
    labels = [positions.photos[row] for row in rows]
    model = np.array([own[name] for name in names])
    sigma = positions.sigma[rows]
    alone = evidence.pairs is None and evidence.attitudes is None and evidence.compass is None
    found, wrong, gone = cameras_that_fit(
        labels, model, world, sigma, alone=alone, crs=evidence.crs
    )
    doubts += wrong
    said += [*wrong, *gone]
    return found


def _said_of_cameras(
    evidence: Evidence, kinds: Sequence[Observed], placed: Placed
) -> list[Message]:
    """Where the cameras look after the registration, and how far they are from what was given."""
    said: list[Message] = []
    if placed.known.vertical and evidence.views:
        rotation = np.array(placed.matrix)[:3, :3] / placed.scale
        forward = np.array([view.rotation[2] for view in evidence.views.values()]) @ rotation.T
        said += said_of_views(forward)
    for kind in kinds:
        if isinstance(kind, Points) and kind.name == "cameras" and _alone(kinds):
            said += said_of_noise(kind.world, placed(kind.model))
    return said


def _alone(kinds: Sequence[Observed]) -> bool:
    """Whether one kind of observation places the model: lengths turn and shift nothing."""
    return sum(not isinstance(kind, Lengths) for kind in kinds) == 1


def _refuse_unsure(placed: Placed, doubts: Sequence[Message]) -> None:
    worst = placed.rotation_error_95_deg.weakest.error_deg
    if worst is None or worst > _UNSURE_DEG:
        unsure = tr(
            "The positions of the cameras are as wrong as they are far apart: the model could "
            "be turned by more than {limit:.0f} degrees. Add control points, or a compass "
            "reading and a length.",
            limit=_UNSURE_DEG,
        )
        raise GeometryError(" ".join(map(str, doubts or [unsure])))


def marked_places(
    evidence: Evidence, marks: Sequence[Marked], said: list[Message] | None = None
) -> dict[str, Array]:
    """(3,) on the model of every label that is marked in two photos of it or more.

    marks : label, photo, x, y; said : gets what is wrong with marks that are left out
    Raises UsageError where no cameras are known.
    """
    told = [] if said is None else said
    seen: dict[str, tuple[list[View], list[tuple[float, float]]]] = {}
    for label, photo, x, y in marks:
        view = _view(evidence, photo, "--marks")
        if view is None:
            continue
        lens = view.intrinsics
        if not (0 <= x <= lens.width and 0 <= y <= lens.height):
            told.append(
                tr(
                    "The mark of {label} at x {x:.0f}, y {y:.0f} is outside of {photo}, which has "
                    "{width} x {height} pixels, and was left out. Correct it.",
                    label=label,
                    x=x,
                    y=y,
                    photo=photo,
                    width=lens.width,
                    height=lens.height,
                )
            )
            continue
        views, pixels = seen.setdefault(label, ([], []))
        views.append(view)
        pixels.append((x, y))
    found = {}
    for label, (views, pixels) in seen.items():
        places = np.array(pixels, np.float64)
        rows, wrong = agreeing(label, views, places)
        told += [mark.in_words() for mark in wrong]
        found[label] = triangulate([views[int(row)] for row in rows], places[rows])
    return {label: place_ for label, place_ in found.items() if np.isfinite(place_).all()}


def _attitudes(evidence: Evidence, table: AttitudeTable, said: list[Message]) -> Held:
    rows, names = _found(evidence, evidence.views, table.photos, "--attitudes", said)
    views = [evidence.views[name] for name in names]
    return held(table, rows, views, evidence.north_doubt_deg, said)


def _bowing_by_tilts(evidence: Evidence, placed: Placed, extent: Array | None) -> Bowing | None:
    table = evidence.attitudes
    if table is None or not placed.known.scale:
        return None
    rows, names = _found(evidence, evidence.views, table.photos, "--attitudes", [])
    matrix = np.array(placed.matrix)
    fit = Similarity(placed.scale, matrix[:3, :3] / placed.scale, matrix[:3, 3])
    return bowing_by_tilts(table, rows, [evidence.views[name] for name in names], fit, extent)


def attitude_misses(evidence: Evidence, placed: Placed) -> list[AttitudeMiss]:
    """How far each photo's attitude is from that in the placed model."""
    table = evidence.attitudes
    if table is None:
        return []
    rows, names = _found(evidence, evidence.views, table.photos, "--attitudes", [])
    rotation = np.array(placed.matrix)[:3, :3] / placed.scale
    return misses(table, rows, [evidence.views[name] for name in names], rotation)


def _level(
    evidence: Evidence, table: LevelTable, extent: Array | None, said: list[Message]
) -> LevelLines:
    rows, names = _found(evidence, evidence.views, table.photos, "--horizon", [])
    views = [evidence.views[name] for name in names]
    said += said_of_level_lines([table.photos[r] for r in rows], views, table.ends[rows], extent)
    directions = []
    for row, view in zip(rows, views, strict=True):
        flat = view.intrinsics.rays(table.ends[row])
        directions.append((flat[1] - flat[0]) @ view.rotation)
    model = np.array(directions)
    model /= np.linalg.norm(model, axis=1, keepdims=True)
    return LevelLines([table.photos[r] for r in rows], model, np.full(len(model), np.nan))
