"""A model placed by what a person names of its place: files, lengths, azimuths, level lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.findings import Finding, Message
from vomstudio.document.records import IDENTITY, UNDECLARED, Model, ReadNorth, Registration
from vomstudio.document.records.compasses import NorthKind
from vomstudio.document.registration_frames import change_file_frame
from vomstudio.errors import GeometryError, UsageError
from vomstudio.geometry import transform
from vomstudio.geometry.places import why_no_error
from vomstudio.progress import Progress
from vomstudio.registration.evidence import Evidence
from vomstudio.registration.level_evidence import LevelLine
from vomstudio.words import tr

if TYPE_CHECKING:
    import numpy.typing as npt

    from vomstudio.io.control.attitude_tables import AttitudeTable
    from vomstudio.io.control.observation_tables import Positions
    from vomstudio.io.models.reader import LoadedModel
    from vomstudio.io.photos.own_cameras.result import OwnCameras
    from vomstudio.registration.attitude_evidence import AttitudeMiss
    from vomstudio.registration.compass_evidence import Segment
    from vomstudio.registration.north import North
    from vomstudio.registration.results import Placed
    from vomstudio.workspace.placing.reference_fitting import ReferenceFit

BESIDE = "beside the model"
"""In place of a file of cameras or attitudes: the photos, where they are found."""
# Formats of surveys, whose z is a height even where they name no system.
_SURVEYED = (".las", ".laz", ".tif", ".tiff")


@dataclass(frozen=True)
class RegisterOrder:
    """By the names of the options of `register`; what is not given is None or empty. model : the
    path, or "-" for the placement alone; scale, azimuth, level : texts as the options take them"""

    model: str
    pairs: str | Path | None = None
    gcp: str | Path | None = None
    marks: str | Path | None = None
    model_cameras: str | Path | None = None
    cameras: str | Path | None = None
    attitudes: str | Path | None = None
    horizon: str | Path | None = None
    orientations: str | Path | None = None
    scale_bars: str | Path | None = None
    scale: Sequence[str] = ()
    azimuth: Sequence[str] = ()
    level: Sequence[str] = ()
    reference: str | Path | None = None
    stable: str | Path | None = None
    north: str = "grid"
    date: str | None = None
    declination: str | None = None
    north_sigma: str | None = None
    crs: str | None = None
    without: Sequence[str] = ()
    robust: bool = False
    keep_scale: bool = False


@dataclass(frozen=True, eq=False)
class Registered:
    """placed : with all warnings; attitudes : of the photos that were given; loaded : the model,
    None for the placement alone; crs : of World; fitted : to the reference; registration : as a
    project records it, with the matrix from the file of the model; None for the placement alone"""

    placed: Placed
    attitudes: Sequence[AttitudeMiss]
    loaded: LoadedModel | None
    crs: str | None
    fitted: ReferenceFit | None
    registration: Registration | None = None

    @property
    def registration_in_world(self) -> Registration | None:
        """The registration of the model once it is written in World: its matrix is the identity,
        the errors of its place are those of `registration`."""
        if self.registration is None:
            return None
        return change_file_frame(self.registration, self.registration.matrix)

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON, with the names of the command."""
        from dataclasses import asdict

        told = self.placed.as_dict()
        if self.fitted is not None:
            told["reference"] = self.fitted.as_dict()
        if self.attitudes:
            told["attitudes"] = [asdict(photo) for photo in self.attitudes]
        return told


def register_model(asked: RegisterOrder, progress: Progress) -> Registered:
    """Raises UsageError, InputError or GeometryError."""
    from vomstudio.io.gis.crs import metric_crs
    from vomstudio.registration.evidence import attitude_misses

    crs = None if asked.crs is None else metric_crs(asked.crs, "--crs")
    loaded = None
    if asked.model != "-":
        from vomstudio.io.models.opening import read_model

        loaded = read_model(Path(asked.model), progress)
    said, unused = list[Message](), list[Message]()
    model = None if loaded is None else _as_model(loaded, said)
    evidence, crs, read_north = _evidence(asked, crs, loaded, said, unused)
    if model is not None and evidence.scale is not None and model.registration is not None:
        evidence.scale = transform.scale_of(model.registration.matrix)
        evidence.scale_error = model.registration.scale_error
    evidence.up, evidence.crs = None if loaded is None else _up(loaded), crs
    fitted = _fitted(asked, evidence, loaded, crs, progress)
    if fitted is not None:
        crs = fitted.crs
        evidence.reference = fitted.fitted.observation
        said += fitted.warnings
    try:
        found = _solved(evidence, loaded)
    except GeometryError as failure:
        if failure.file is None and failure.field is None:
            failure.file = _pairs_file(asked)
        if unused:
            raise _by_unused(failure, unused, evidence) from failure
        raise
    registration = None
    if model is not None:
        registration = _registration(found, evidence, model, crs, fitted, read_north, said)
    warnings = [*said, *_said_of_move(found, loaded, crs), *found.warnings]
    for name, error in _bars_as_checks(evidence, found):
        warnings.append(
            tr("The scale bar {name} judges: the placed model shows it {error:.3g} m too long.",
               name=name, error=error)
            if error > 0
            else tr("The scale bar {name} judges: the placed model shows it {error:.3g} m too "
                    "short.", name=name, error=-error)
        )  # fmt: skip
    placed = replace(found, warnings=tuple(warnings))
    misses = attitude_misses(evidence, found)
    return Registered(placed, misses, loaded, crs, fitted, registration)


def _as_model(loaded: LoadedModel, said: list[Message]) -> Model:
    """Return the record of the model as it stands before. said : gets what is wrong with the
    registration beside it"""
    from vomstudio.io.models.frames import frame_of_file, registration_beside

    path = loaded.path
    found = registration_beside(path, loaded.content_hash, loaded.crs)
    said += found.findings
    placement = found.registration or frame_of_file(path, loaded.crs)
    return Model("", path.stem, str(path), loaded.kind, loaded.content_hash, placement)


def _registration(
    placed: Placed,
    evidence: Evidence,
    model: Model,
    crs: str | None,
    fitted: ReferenceFit | None,
    read_north: ReadNorth | None,
    said: list[Message],
) -> Registration:
    """Return the record that the window makes of the same placement."""
    from vomstudio.io.models.registration_file import registration_path
    from vomstudio.workspace.placing.registering import (
        reference_findings,
        registration_of,
        with_error_of,
    )

    if not placed.known.all and model.to_world != IDENTITY:
        # What is left free stays as the file has it, and that is not World.
        if model.registration is not None:
            file = registration_path(model.path).name
            said.append(Finding("registration.incomplete", file=file))
        model = replace(model, placement=UNDECLARED)
    reference = "" if fitted is None else fitted.name
    record = registration_of(placed, evidence.pairs, model, crs, reference, read_north)
    if fitted is None or fitted.reference is None:
        return record
    record = with_error_of(record, fitted.reference, scale_fitted=fitted.scale)
    said += reference_findings(record)
    return record


def _by_unused(
    failure: GeometryError, unused: Sequence[Message], evidence: Evidence
) -> GeometryError:
    """A failure that follows from marks that were not used: these are its cause."""
    why = failure.message
    if evidence.too_few_alone:
        why = tr("Three points at least are needed, each marked in two photos or more.")
    return GeometryError(" ".join(map(str, [*unused, why])), file=failure.file, field=failure.field)


def _pairs_file(asked: RegisterOrder) -> str | None:
    """The table of points, whose fault it is where a model cannot be placed."""
    given = asked.pairs or asked.gcp
    return None if given is None else str(given)


def _bars_as_checks(evidence: Evidence, placed: Placed) -> list[tuple[str, float]]:
    """Scale bars that judge: their names, and how much too long the placed model shows them."""
    pairs = evidence.pairs
    if pairs is None:
        return []
    places = dict(zip(pairs.labels, pairs.model, strict=True))
    return [
        (
            f"{bar.first} - {bar.second}",
            float(placed.scale * np.linalg.norm(places[bar.second] - places[bar.first]))
            - bar.length_m,
        )
        for bar in evidence.bars
        if bar.check
    ]


def _fitted(
    asked: RegisterOrder,
    evidence: Evidence,
    loaded: LoadedModel | None,
    crs: str | None,
    progress: Progress,
) -> ReferenceFit | None:
    """By the reference, from where all else that is given would have the model."""
    if asked.reference is None:
        if asked.stable is not None:
            raise UsageError(
                tr("A mask needs the reference that it belongs to: give --reference too."),
                field="--stable",
            )
        return None
    from vomstudio.workspace.placing.reference_fitting import fit_model

    if loaded is None:
        raise UsageError(
            tr("A reference can place a model that is there. Name it in place of -."), field="MODEL"
        )
    # One point or two help the surfaces, but do not say where these begin.
    known = not (evidence.empty or evidence.too_few_alone)
    near = _solved(evidence, loaded) if known else None
    return fit_model(
        loaded, asked.reference, near=near, crs=crs, stable=asked.stable, progress=progress
    )


def _solved(evidence: Evidence, loaded: LoadedModel | None) -> Placed:
    from vomstudio.registration.evidence import register

    return register(evidence, None if loaded is None else _extent(loaded))


def _extent(loaded: LoadedModel) -> npt.NDArray[np.float64]:
    from vomstudio.registration.surface_points import some_points

    return some_points(loaded.data)


def _up(loaded: LoadedModel) -> npt.NDArray[np.float64] | None:
    """(3,) What is up in the model, where its file says so, or its format is for surveys alone."""
    from vomstudio.io.models.frames import frame_of_file

    surveyed = loaded.path.suffix.casefold() in _SURVEYED
    known = surveyed or frame_of_file(loaded.path, loaded.crs).has_up
    return np.array([0.0, 0.0, 1.0]) if known else None


def _said_of_move(found: Placed, loaded: LoadedModel | None, crs: str | None) -> list[Message]:
    """How far a model is put from where its own file says that it is."""
    from vomstudio.registration.coordinate_checks import said_of_move

    if loaded is None or loaded.crs is None or not found.known.position:
        return []
    if crs is not None and crs != loaded.crs:
        return []
    extent = _extent(loaded)
    return said_of_move(extent, found(extent), loaded.crs)


def _evidence(
    asked: RegisterOrder,
    crs: str | None,
    loaded: LoadedModel | None,
    said: list[Message],
    unused: list[Message],
) -> tuple[Evidence, str | None, ReadNorth | None]:
    """And the CRS, and how azimuths were counted. said : gets what was noticed; unused : which
    control points and marks were not used, and why"""
    from vomstudio.io.control import observation_tables as tables
    from vomstudio.registration.camera_positions import in_metres
    from vomstudio.registration.coordinate_checks import check_area
    from vomstudio.registration.north import DECLINATION_DOUBT_DEG, on_grid
    from vomstudio.workspace.placing.marked_points import marked_pairs

    evidence = Evidence(without=tuple(asked.without), robust=asked.robust)
    evidence.scale = 1.0 if asked.keep_scale else None
    if asked.north_sigma is not None:
        doubt = _angle(asked.north_sigma, "--north-sigma", zero=True)
        evidence.north_doubt_deg = evidence.compass_doubt_deg = doubt
    elif asked.north == "magnetic":
        evidence.compass_doubt_deg = DECLINATION_DOUBT_DEG
    if asked.marks is not None and asked.gcp is None:
        raise UsageError(tr("Marks need their points: give --gcp too."), field="--marks")
    seen = (asked.cameras, asked.attitudes, asked.horizon, asked.gcp)
    if any(each is not None for each in seen):
        own = _own_cameras(asked, loaded)
        evidence.views, evidence.centres = own.views, own.centres
        said += own.warnings
    if asked.pairs is not None:
        evidence.pairs = tables.read_pairs(asked.pairs, crs)
        crs = crs or evidence.pairs.crs
    if asked.gcp is not None:
        marks = None if asked.marks is None else Path(asked.marks)
        evidence.pairs, crs = marked_pairs(Path(asked.gcp), marks, evidence, crs, unused)
        said += unused
    if asked.scale_bars is not None:
        evidence.bars = tables.read_scale_bars(asked.scale_bars)
    if asked.horizon is not None:
        evidence.level = tables.read_level_lines(asked.horizon)
    if asked.orientations is not None:
        evidence.compass = tables.read_compass(asked.orientations)
    place = None
    if evidence.pairs is not None:
        said += check_area(evidence.pairs.world, crs)
    if asked.cameras is not None:
        positions = _positions(asked.cameras, own)
        said += positions.findings
        evidence.positions, crs, place = in_metres(positions, crs, said)
        said += check_area(evidence.positions.places, crs, converted=place is not None)
    north = _north(asked, evidence, crs, place)
    if asked.attitudes is not None:
        table = _held(asked.attitudes, asked.north, own)
        said += table.notes
        if table.photos:
            evidence.attitudes = on_grid(table, north, said)
    evidence.lengths = [_segment(text, "--scale") for text in asked.scale]
    evidence.level_lines = [_level_line(text) for text in asked.level]
    evidence.azimuths = [_segment(text, "--azimuth") for text in asked.azimuth]
    for line in evidence.azimuths:
        if not -360.0 <= line.value <= 360.0:
            raise UsageError(
                tr("{value:g} is no azimuth in degrees. Correct it.", value=line.value),
                field="--azimuth",
            )
    read_north = _turn_to_grid(asked, evidence, north, said)
    for line in evidence.lengths:
        if not line.value > 0:
            raise UsageError(tr("A length must be positive. Correct it."), field="--scale")
    if evidence.empty and asked.reference is None:
        for finding in said:
            if isinstance(finding, Finding) and finding.code == "photo.angles-not-measured":
                raise UsageError.of_finding(finding, field="--attitudes")
        raise UsageError(
            tr(
                "Nothing was given to place the model by. Give --pairs, --gcp, --cameras, "
                "--attitudes, --horizon, --level, --orientations, --scale, --azimuth or "
                "--reference."
            )
        )
    return evidence, crs, read_north


def _own_cameras(asked: RegisterOrder, loaded: LoadedModel | None) -> OwnCameras:
    """The cameras in the model's own frame."""
    from vomstudio.io.photos.cameras_file import FILE_NAME
    from vomstudio.io.photos.own_cameras.reading import find_own_cameras, read_own_cameras

    path = asked.model_cameras
    if path is None:
        if asked.model == "-":
            raise UsageError(
                tr(
                    "Photos can place a model that is there. Name it in place of -, or its cameras "
                    "with --model-cameras."
                ),
                field="MODEL",
            )
        path = find_own_cameras(asked.model) or Path(asked.model).with_name(FILE_NAME)
    return read_own_cameras(path, None if loaded is None else loaded.data.bounds)


def _positions(given: str | Path, own: OwnCameras) -> Positions:
    """Where the photos were taken: by a table, or by themselves."""
    from vomstudio.io.control.observation_tables import read_positions
    from vomstudio.registration.photo_evidence import positions_in

    if given == BESIDE or Path(given).is_dir():
        return positions_in(_photos(given, own, "--cameras"))
    return read_positions(given)


def _held(given: str | Path, north: str, own: OwnCameras) -> AttitudeTable:
    """How the photos were held: by a table, or by themselves."""
    from vomstudio.io.control.attitude_tables import read_attitudes
    from vomstudio.registration.photo_evidence import attitudes_in

    if given == BESIDE or Path(given).is_dir():
        return attitudes_in(_photos(given, own, "--attitudes"), own.views)
    return read_attitudes(given, north)


def _north(
    asked: RegisterOrder,
    evidence: Evidence,
    crs: str | None,
    place: tuple[float, float] | None,
) -> North:
    """What is known of north, and of where and when the readings were made."""
    from vomstudio.registration.north import North, parse_day, place_of

    known = [] if evidence.pairs is None else [evidence.pairs.world]
    known += [] if evidence.positions is None else [evidence.positions.places]
    if place is None and crs is not None and known:
        place = place_of(crs, np.concatenate(known))
    declination = None
    if asked.declination is not None:
        declination = _angle(asked.declination, "--declination", signed=True)
    day = None if asked.date is None else parse_day(asked.date)
    return North(crs, place, day, declination)


def _turn_to_grid(
    asked: RegisterOrder, evidence: Evidence, north: North, said: list[Message]
) -> ReadNorth | None:
    """Count azimuths and compass readings from the north of the map. Returns how they were read,
    None if there are none."""
    from vomstudio.registration.north import turn_of

    if not (evidence.azimuths or evidence.compass):
        return None
    doubt = evidence.compass_doubt_deg
    if asked.north == "grid":
        return ReadNorth("grid", doubt_deg=doubt)
    turned = turn_of(asked.north, north, "--north")
    said.append(turned.in_words())
    evidence.azimuths = [
        line._replace(value=(line.value + turned.deg) % 360.0) for line in evidence.azimuths
    ]
    evidence.compass_turn_deg = turned.deg
    word: NorthKind = "true" if asked.north == "true" else "magnetic"
    return ReadNorth(
        word, turned.deg, turned.declination_deg, turned.stated, asked.date or "", doubt
    )


def _angle(text: str, option: str, *, signed: bool = False, zero: bool = False) -> float:
    try:
        value = float(text.strip().rstrip("°").replace(",", "."))
    except ValueError:
        value = math.nan
    if not (abs(value) <= 180.0 and (signed or value > 0 or (zero and value == 0))):
        raise UsageError(
            tr("'{text}' is no angle in degrees that is possible here.", text=text[:40]),
            field=option,
        )
    if option == "--north-sigma" and value:
        _require_error([value], option)
    return value


def _photos(given: str | Path, own: OwnCameras, option: str) -> dict[str, Path]:
    """The photos of the model's cameras, in the folder that is given or where they are found."""
    from vomstudio.io.photos.own_cameras.photos import find_photos_of

    photos = find_photos_of(own, None if given == BESIDE else Path(given))
    if not photos:
        raise UsageError(
            tr(
                "No photo of the model's cameras ({name}, …) was found. Name the folder of the "
                "photos, or a table.",
                name=next(iter(own.centres)),
            ),
            field=option,
        )
    return photos


def _segment(text: str, option: str) -> Segment:
    from vomstudio.registration.compass_evidence import Segment

    cells = _numbers(text)
    if len(cells) not in (7, 8):
        raise UsageError(
            tr(
                "'{text}' is not seven numbers with commas between them, x1,y1,z1,x2,y2,z2,value, "
                "and where wanted the error of the value (one sigma).",
                text=text[:60],
            ),
            field=option,
        )
    x1, y1, z1, x2, y2, z2, value, *sigma = cells
    if sigma and not sigma[0] > 0:
        raise UsageError(tr("An error must be positive. Correct it."), field=option)
    _require_error(sigma, option)
    return Segment((x1, y1, z1), (x2, y2, z2), value, sigma[0] if sigma else None)


def _require_error(sigma: Sequence[float], option: str) -> None:
    """Raises UsageError for an error that nothing has. sigma : one at most"""
    for value in sigma:
        if (said := why_no_error(value)) is not None:
            raise UsageError(said, field=option)


def _numbers(text: str) -> list[float]:
    """Finite ones between commas; none where something else is among them."""
    try:
        cells = [float(cell) for cell in text.split(",")]
    except ValueError:
        return []
    return cells if all(map(math.isfinite, cells)) else []


def _level_line(text: str) -> LevelLine:
    cells = _numbers(text)
    if len(cells) not in (6, 7):
        raise UsageError(
            tr(
                "'{text}' is not six numbers with commas between them, x1,y1,z1,x2,y2,z2, and "
                "where wanted the error of the line in degrees.",
                text=text[:60],
            ),
            field="--level",
        )
    x1, y1, z1, x2, y2, z2, *sigma = cells
    if sigma and not 0.0 < sigma[0] <= 45.0:
        raise UsageError(
            tr("The error of a level line must lie between 0 and 45 degrees."), field="--level"
        )
    _require_error(sigma, "--level")
    return LevelLine((x1, y1, z1), (x2, y2, z2), sigma[0] if sigma else None)
