"""Tables of what is known of a model's place: pairs of points, scale bars, camera positions,
attitudes of cameras, level lines in photos, and compass readings of what the model shows.

Headers are found by what they say, in any order; one that begins with `#` counts too, as Metashape
writes it. Without a header the columns stand in the order in which they are named here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError, UsageError
from vomstudio.geometry.places import why_no_coordinate
from vomstudio.io.control.control_files import read_control
from vomstudio.io.control.registry import choose_format
from vomstudio.io.text.orientation_reading import OrientationTable, orientations_of
from vomstudio.io.text.rows import shortened
from vomstudio.io.text.tables import TextTable, plain, read_table
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

_LABEL = ("label", "name", "point", "point id", "id", "marker", "#label", "# label")
_PHOTO = ("photo", "image", "file", "filename", "file name", "name", "label", "camera")
_WORLD = (
    ("x", "east", "easting", "e", "world x", "lon", "longitude"),
    ("y", "north", "northing", "n", "world y", "lat", "latitude"),
    ("z", "up", "height", "elevation", "altitude", "alt", "h", "world z"),
)
_MODEL = (
    ("model x", "local x", "xm", "mx"),
    ("model y", "local y", "ym", "my"),
    ("model z", "local z", "zm", "mz"),
)
_SIGMA = (
    ("sigma x", "accuracy x", "error x", "sx", "sigma east", "sigma e"),
    ("sigma y", "accuracy y", "error y", "sy", "sigma north", "sigma n"),
    ("sigma z", "accuracy z", "error z", "sz", "sigma up", "sigma h"),
)
_SIGMA_ALL = ("sigma", "accuracy", "sigma m", "accuracy m")
_PAIRS = ("label", "model_x", "model_y", "model_z", "x", "y", "z")
_CONTROL = {"", "control", "yes", "true", "1", "gcp"}
_CHECK = {"check", "no", "false", "0"}


@dataclass(frozen=True, eq=False)
class Pairs:
    """n points of the model with their coordinates.

    model, world : (n, 3); sigma : (n, 3) metres, NaN where not stated; check : (n,) they judge only
    """

    labels: tuple[str, ...]
    model: Array
    world: Array
    sigma: Array
    check: npt.NDArray[np.bool_]

    def with_more(self, other: Pairs) -> Pairs:
        """These and others. Raises UsageError where a label is in both."""
        for label in set(self.labels) & set(other.labels):
            raise UsageError(
                tr("The point {label} is given twice. Leave one of them out.", label=label)
            )
        return Pairs(
            (*self.labels, *other.labels),
            np.concatenate([self.model, other.model]),
            np.concatenate([self.world, other.world]),
            np.concatenate([self.sigma, other.sigma]),
            np.concatenate([self.check, other.check]),
        )


@dataclass(frozen=True)
class ScaleBar:
    """Between two points of the pairs; sigma_m : None where not stated; check : it judges only"""

    first: str
    second: str
    length_m: float
    sigma_m: float | None = None
    check: bool = False


@dataclass(frozen=True, eq=False)
class Positions:
    """Where photos were taken. places : (n, 3) as written; degrees : they are longitude and
    latitude; sigma : (n, 3) metres, NaN where not stated"""

    photos: tuple[str, ...]
    places: Array
    degrees: bool
    sigma: Array


@dataclass(frozen=True, eq=False)
class AttitudeTable:
    """How cameras were held. angles, sigma : (n, 3) degrees of yaw, pitch and roll; NaN where not
    given; yaw : azimuth of the view, clockwise; pitch : 0 level, -90 straight down; roll : 0 with
    the image's long side level, clockwise as the photographer tilts the camera
    magnetic : yaw was read from a compass
    """

    photos: tuple[str, ...]
    angles: Array
    sigma: Array
    magnetic: bool


@dataclass(frozen=True, eq=False)
class LevelTable:
    """Lines that are level in photos. ends : (n, 2, 2) pixels"""

    photos: tuple[str, ...]
    ends: Array


@dataclass(frozen=True, eq=False)
class CompassTable:
    """Planes and lines of the model that were read by compass.

    read : what was read; model : (n, 3) unit vectors in the model's frame, normals of planes
    sigma : (n,) degrees, NaN where not stated
    """

    read: OrientationTable
    model: Array
    sigma: Array


def read_pairs(path: str | Path) -> Pairs:
    """`label, model_x, model_y, model_z, x, y, z[, use][, sigma_x, sigma_y, sigma_z]`. Raises
    InputError with file, line and column."""
    table = _Table(path, _PAIRS)
    labels = table.words(_LABEL, "label")
    table.require_once(labels)
    model = table.columns(_MODEL, ("model_x", "model_y", "model_z"))
    world = table.columns(_WORLD, ("x", "y", "z"))
    table.require_places(world)
    uses = table.uses()
    return Pairs(labels, model, world, table.sigma(), uses)


def read_points(path: str | Path) -> Pairs:
    """Points with coordinates from any file of ground control; `model` is NaN where the file does
    not say where on the model they are. Raises InputError with file, line and column."""
    path = Path(path)
    if not choose_format(path).certain and _tells_places(path):
        return read_pairs(path)
    points = read_control(path)
    sigma = [np.nan if p.sigma_m is None else p.sigma_m for p in points]
    return Pairs(
        tuple(p.label for p in points),
        np.full((len(points), 3), np.nan),
        np.array([p.position for p in points], np.float64).reshape(-1, 3),
        np.repeat(np.array(sigma, np.float64)[:, None], 3, axis=1),
        np.array([p.check for p in points], bool),
    )


def _tells_places(path: Path) -> bool:
    try:
        return _Table(path, _PAIRS).has(_MODEL[0])
    except InputError:
        return False


def read_scale_bars(path: str | Path) -> list[ScaleBar]:
    """`from, to, length_m[, sigma_m][, use]`. Raises InputError."""
    table = _Table(path, ("from", "to", "length_m"))
    first = table.words(("from", "first", "start", "label 1", "point 1"), "from")
    second = table.words(("to", "second", "end", "label 2", "point 2"), "to")
    (lengths,) = table.columns((("length", "length m", "distance", "distance m"),), ("length_m",)).T
    for row in np.flatnonzero(~(lengths > 0)):
        raise table.at(int(row), tr("A length must be positive. Correct it."), "length_m")
    sigma = table.positive(("sigma", "sigma m", "accuracy", "accuracy m", "error"), "sigma_m")
    return [
        ScaleBar(a, b, float(length), None if np.isnan(s) else float(s), bool(check))
        for a, b, length, s, check in zip(first, second, lengths, sigma, table.uses(), strict=True)
    ]


def read_positions(path: str | Path) -> Positions:
    """`photo, x, y, z[, sigma_x, sigma_y, sigma_z]`, or longitude, latitude and altitude as the
    header says. Raises InputError."""
    table = _Table(path, ("photo", "x", "y", "z"))
    photos = table.words(_PHOTO, "photo")
    table.require_once(photos)
    places = table.columns(_WORLD, ("x", "y", "z"))
    degrees = table.has(("lon", "longitude")) and table.has(("lat", "latitude"))
    if not degrees:
        table.require_places(places)
    return Positions(photos, places, degrees, table.sigma())


def read_attitudes(path: str | Path) -> AttitudeTable:
    """`photo, yaw, pitch, roll[, sigma_yaw, sigma_pitch, sigma_roll][, north]`. Raises
    InputError."""
    table = _Table(path, ("photo", "yaw", "pitch", "roll"))
    photos = table.words(_PHOTO, "photo")
    table.require_once(photos)
    names = ("yaw", "pitch", "roll")
    angles = table.columns((("yaw", "heading"), ("pitch",), ("roll",)), names)
    for column, limit in ((1, 90.0), (2, 180.0)):
        for row in np.flatnonzero(np.abs(angles[:, column]) > limit):
            said = tr("{name} is between -{limit:g} and {limit:g} degrees. Correct it.",
                      name=names[column], limit=limit)  # fmt: skip
            raise table.at(int(row), said, names[column])
    sigma = np.column_stack(
        [table.positive((f"sigma {n}", f"accuracy {n}", f"error {n}"), f"sigma_{n}") for n in names]
    )
    magnetic = False
    if table.has(("north",)):
        for number, word in enumerate(table.words(("north",), "north", empty=True)):
            if word.casefold() not in ("", "true", "grid", "magnetic"):
                raise table.at(
                    number,
                    tr("'{word}' is no north. Write true or magnetic.", word=shortened(word)),
                    "north",
                )
            magnetic |= word.casefold() == "magnetic"
    return AttitudeTable(photos, angles, sigma, magnetic)


def read_level_lines(path: str | Path) -> LevelTable:
    """`photo, x1, y1, x2, y2`, pixels of two ends of a line that is level. Raises InputError."""
    table = _Table(path, ("photo", "x1", "y1", "x2", "y2"))
    photos = table.words(_PHOTO, "photo")
    names = ("x1", "y1", "x2", "y2")
    ends = table.columns(tuple((n,) for n in names), names).reshape(-1, 2, 2)
    for row in np.flatnonzero(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) < 1.0):
        raise table.at(int(row), tr("Both ends of the line are at one place. Correct it."), "x2")
    return LevelTable(photos, ends)


def read_compass(path: str | Path) -> CompassTable:
    """An orientation table with the same planes and lines in the model's frame, as unit vectors
    `model_x, model_y, model_z` (normals of planes), and `sigma_deg` where wanted. Raises
    InputError and UsageError."""
    table = _Table(path, ())
    if not all(table.has(names) for names in _MODEL):
        raise InputError(
            tr(
                "The table has no columns model_x, model_y and model_z. They hold the normal of "
                "each plane, or the direction of each line, in the frame of the model."
            ),
            file=table.path,
            line=table.table.header_line,
        )
    read = orientations_of(table.table)
    vectors = table.columns(_MODEL, ("model_x", "model_y", "model_z"))[read.kept]
    length = np.linalg.norm(vectors, axis=1)
    for place in np.flatnonzero(~(length > 0)):
        raise table.at(
            int(read.kept[place]), tr("The direction has no length. Correct it."), "model_x"
        )
    sigma = table.positive(("sigma", "sigma deg", "accuracy", "accuracy deg"), "sigma_deg")
    return CompassTable(read, vectors / length[:, None], sigma[read.kept])


class _Table:
    """A text table whose columns have several names."""

    def __init__(self, path: str | Path, order: Sequence[str]) -> None:
        """order : of the columns where there is no header"""
        table = read_table(path, named=True)
        if table.names is None:
            table = _with_header(table, order)
        if not len(table):
            raise InputError(
                tr("There is nothing below the header. Add rows."),
                file=table.path,
                line=table.header_line,
            )
        self.table, self.path = table, table.path
        self._plain = [plain(name) for name in table.names or ()]

    def _find(self, names: Sequence[str]) -> int | None:
        for name in names:
            found = [i for i, each in enumerate(self._plain) if each == plain(name)]
            if found:
                return found[0]
        return None

    def has(self, names: Sequence[str]) -> bool:
        return self._find(names) is not None

    def _column(self, names: Sequence[str], called: str) -> int:
        found = self._find(names)
        if found is None:
            raise InputError(
                tr(
                    "There is no column '{called}'. The columns are {columns}.",
                    called=called,
                    columns=shortened(", ".join(self.table.names or ()), 120),
                ),
                file=self.path,
                line=self.table.header_line,
                field=called,
            )
        return found

    def words(self, names: Sequence[str], called: str, *, empty: bool = False) -> tuple[str, ...]:
        found = tuple(self.table.labels(self._column(names, called)))
        if not empty:
            for row, word in enumerate(found):
                if not word:
                    raise self.at(row, tr("The cell is empty. Fill it in."), called)
        return found

    def columns(self, names: Sequence[Sequence[str]], called: Sequence[str]) -> Array:
        """(n, columns) finite numbers."""
        which = [self._column(some, word) for some, word in zip(names, called, strict=True)]
        values = np.asarray(self.table.numbers(which), np.float64)
        for row, column in np.argwhere(~np.isfinite(values)):
            raise self.at(
                int(row), tr("The value is missing or not a number."), called[int(column)]
            )
        return values

    def positive(self, names: Sequence[str], called: str) -> Array:
        """(n,) positive numbers, NaN where the cell is empty or there is no column."""
        which = self._find(names)
        if which is None:
            return np.full(len(self.table), np.nan)
        values = np.asarray(self.table.numbers([which])[:, 0], np.float64)
        for row in np.flatnonzero(values <= 0):
            raise self.at(int(row), tr("An accuracy must be positive. Correct it."), called)
        return values

    def sigma(self) -> Array:
        """(n, 3) metres."""
        if any(self.has(names) for names in _SIGMA):
            called = ("sigma_x", "sigma_y", "sigma_z")
            return np.column_stack(
                [self.positive(n, c) for n, c in zip(_SIGMA, called, strict=True)]
            )
        return np.repeat(self.positive(_SIGMA_ALL, "sigma")[:, None], 3, axis=1)

    def uses(self) -> npt.NDArray[np.bool_]:
        """(n,) whether it judges only."""
        which = self._find(("use", "role", "type"))
        if which is None:
            return np.zeros(len(self.table), bool)
        words = [cell.casefold() for cell in self.table.cells(which)]
        for row, word in enumerate(words):
            if word not in _CONTROL | _CHECK:
                raise self.at(
                    row, tr("'{use}' is neither control nor check.", use=shortened(word)), "use"
                )
        return np.array([word in _CHECK for word in words], bool)

    def require_once(self, labels: Sequence[str]) -> None:
        seen: dict[str, int] = {}
        for row, label in enumerate(labels):
            first = seen.setdefault(label, row)
            if first != row:
                raise self.at(
                    row,
                    tr(
                        "The label '{name}' is also in line {line}. Give each point its own label.",
                        name=shortened(label),
                        line=int(self.table.line_numbers[first]),
                    ),
                    "label",
                )

    def require_places(self, places: Array) -> None:
        for row, place in enumerate(places.tolist()):
            if (said := why_no_coordinate((place[0], place[1], place[2]))) is not None:
                raise self.at(row, said, "x")

    def at(self, row: int, said: str, called: str) -> InputError:
        return InputError(
            said, file=self.path, line=int(self.table.line_numbers[row]), field=called
        )


def _with_header(table: TextTable, order: Sequence[str]) -> TextTable:
    """The last comment, where it names as many columns as there are; else our own order."""
    for comment in reversed(table.comments):
        cells = [c.strip() for c in comment.replace(";", ",").replace("\t", ",").split(",")]
        if len(cells) == 1:
            cells = comment.split()
        if len(cells) == table.width and any(cell.isalpha() for cell in cells):
            return replace(table, names=tuple(cells))
    if not order or table.width < len(order):
        raise InputError(
            tr(
                "The table has no header. Name its columns in the first line: {names}.",
                names=", ".join(order) if order else "dip_direction, dip, model_x, …",
            ),
            file=table.path,
            line=1,
        )
    more = [f"column {i + 1}" for i in range(len(order), table.width)]
    return replace(table, names=(*order, *more))
