"""Tables of observations that determine the placement of a model.

The observations are pairs of points, scale bars, camera positions, level lines in photos, and
compass readings of parts of the model. Columns are identified by their header, in any order; a
header that begins with `#`, as in Metashape, is valid. Without a header, the columns must have the
order given here.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import lines_to_vectors, planes_to_poles
from vomstudio.io.control.control_files import read_control
from vomstudio.io.control.geo_file import is_geo, read_geo
from vomstudio.io.control.registry import choose_format
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.points import ModelFrame, points_to_world
from vomstudio.io.gate.stated_crs import table_crs
from vomstudio.io.text.named_columns import LABEL_NAMES, PHOTO_NAMES, WORLD, NamedTable
from vomstudio.io.text.orientation_columns import Azimuth
from vomstudio.io.text.orientation_reading import extract_orientations
from vomstudio.io.text.rows import shorten

_MODEL_COLUMNS = (
    ("model x", "local x", "xm", "mx"),
    ("model y", "local y", "ym", "my"),
    ("model z", "local z", "zm", "mz"),
)
_PAIR_COLUMNS = ("label", "model_x", "model_y", "model_z", "x", "y", "z")


@dataclass(frozen=True, eq=False)
class Pairs:
    """Points of the model (n) with their World coordinates.

    Attributes
    ----------
    model, world : (n, 3) float64
    sigma : (n, 3) float64
        Standard deviations in metres; NaN if not stated.
    check : (n,) bool
        Whether each point is a check point, which is not used for the registration.
    notes : tuple of Finding
        Findings from reading the tables.
    crs : str or None
        CRS of the World frame, or None for local coordinates.
    covariance : (n, 3, 3) float64 or None
        Covariances of `model`, NaN for clicked points; None if all points were clicked.
    """

    labels: tuple[str, ...]
    model: FloatArray
    world: FloatArray
    sigma: FloatArray
    check: BoolArray
    notes: tuple[Finding, ...] = ()
    crs: str | None = None
    covariance: FloatArray | None = None

    @property
    def is_clicked(self) -> BoolArray:
        """Whether each point (n,) was clicked on the model instead of marked in photos."""
        if self.covariance is None:
            return np.ones(len(self.labels), bool)
        return np.asarray(~np.isfinite(self.covariance).all(axis=(1, 2)))

    def combine_pairs(self, other_pairs: Pairs) -> Pairs:
        """Return these pairs followed by others. Raises UsageError if both contain a label."""
        for label in set(self.labels) & set(other_pairs.labels):
            raise UsageError(Finding("control.repeated-point", label=label))
        return Pairs(
            (*self.labels, *other_pairs.labels),
            np.concatenate([self.model, other_pairs.model]),
            np.concatenate([self.world, other_pairs.world]),
            np.concatenate([self.sigma, other_pairs.sigma]),
            np.concatenate([self.check, other_pairs.check]),
            (*self.notes, *other_pairs.notes),
            self.crs or other_pairs.crs,
            _joined_covariance(self, other_pairs),
        )


def _joined_covariance(*tables: Pairs) -> FloatArray | None:
    """Return the covariances of the positions in all tables, or None if all were clicked."""
    if all(table.covariance is None for table in tables):
        return None
    missing_covariances = (np.full((len(table.labels), 3, 3), np.nan) for table in tables)
    return np.concatenate(
        [
            missing_covariance if table.covariance is None else table.covariance
            for table, missing_covariance in zip(tables, missing_covariances, strict=True)
        ]
    )


@dataclass(frozen=True)
class ScaleBar:
    """Distance between two points of the pairs.

    `sigma_m` is None if not stated; `file` and `line` are None if the bar was not read from a file.
    `check` marks a bar that is not used for the registration.
    """

    first: str
    second: str
    length_m: float
    sigma_m: float | None = None
    check: bool = False
    file: Path | None = None
    line: int | None = None


@dataclass(frozen=True, eq=False)
class Positions:
    """Camera positions of photos.

    Attributes
    ----------
    coordinates : (n, 3) float64
        Coordinates as written; NaN for a missing height.
    is_in_degrees : bool
        Whether x and y are longitude and latitude.
    sigma : (n, 3) float64
        Standard deviations in metres; NaN if not stated.
    crs, line
        CRS of x and y, and the line in which the file states it; None if not stated.
    heights : tuple of str
        Reference of each height: "ellipsoid", "sea level", "below sea level", or "" if not stated;
        empty if no height has a reference.
    notes : tuple of Finding
        Findings about the table or about the metadata of the photos.
    """

    photos: tuple[str, ...]
    coordinates: FloatArray
    is_in_degrees: bool
    sigma: FloatArray
    crs: str | None = None
    heights: tuple[str, ...] = ()
    file: Path | None = None
    line: int | None = None
    notes: tuple[Finding, ...] = ()


@dataclass(frozen=True, eq=False)
class LevelTable:
    """Level lines in photos. `ends` (n, 2, 2) contains the pixel coordinates of their ends."""

    photos: tuple[str, ...]
    ends: FloatArray


@dataclass(frozen=True, eq=False)
class CompassTable:
    """Planes and lines of the model (n) that were measured with a compass.

    Attributes
    ----------
    is_plane : (n,) bool
        Whether each reading is a plane; False for lines.
    azimuth_deg, inclination_deg : (n,) float64
        Values as read: dip direction and dip of planes, trend and plunge of lines.
    model : (n, 3) float64
        Unit vectors in the frame of the model; for planes, the normals.
    sigma : (n,) float64
        Standard deviations in degrees; NaN if not stated.
    """

    labels: tuple[str, ...]
    is_plane: BoolArray
    azimuth_deg: FloatArray
    inclination_deg: FloatArray
    model: FloatArray
    sigma: FloatArray

    def vectors(self) -> FloatArray:
        """Return unit vectors (n, 3) of the readings: downward poles of planes, and lines."""
        poles = planes_to_poles(self.azimuth_deg, self.inclination_deg)
        lines = lines_to_vectors(self.azimuth_deg, self.inclination_deg)
        return np.where(self.is_plane[:, None], poles, lines)


def read_pairs(
    path: str | Path, crs: str | None = None, options: FrameOptions = DEFAULT_FRAME
) -> Pairs:
    """Read pairs of points on the model and in the World frame.

    The columns are `label, model_x, model_y, model_z, x, y, z[, use][, sigma_x, sigma_y,
    sigma_z]`.

    Parameters
    ----------
    path : str or Path
    crs : str, optional
        CRS in which the model is placed; World coordinates in another CRS are converted.
    options : FrameOptions
        CRS of the World coordinates, and the CRS to which they are converted.

    Raises
    ------
    InputError
        If the table is not valid (states file, line and column), or if the World coordinates are
        not metric (`vomstudio.io.gate.points.points_to_world`).
    """
    table = NamedTable(path, _PAIR_COLUMNS)
    labels = table.words(LABEL_NAMES, "label")
    table.require_unique(labels)
    model = table.columns(_MODEL_COLUMNS, ("model_x", "model_y", "model_z"))
    world = table.columns(WORLD, ("x", "y", "z"))
    table.require_coordinates(world)
    world_points = points_to_world(
        world,
        file=table.path,
        comments=table.table.comments,
        options=options,
        model=None if crs is None else ModelFrame(crs),
    )
    return Pairs(
        labels,
        model,
        world_points.points,
        table.sigma(),
        table.is_check_point(),
        (*table.notes, *world_points.findings),
        world_points.crs,
    )


def read_points(path: str | Path) -> Pairs:
    """Read points with coordinates from a ground control file of any format.

    `model` is NaN if the file does not state positions on the model. Raises InputError with file,
    line and column.
    """
    path = Path(path)
    if not choose_format(path).is_certain and _has_model_positions(path):
        return read_pairs(path)
    points = read_control(path)
    sigma = [np.nan if point.sigma_m is None else point.sigma_m for point in points]
    return Pairs(
        tuple(point.label for point in points),
        np.full((len(points), 3), np.nan),
        np.array([point.position for point in points], np.float64).reshape(-1, 3),
        np.repeat(np.array(sigma, np.float64)[:, None], 3, axis=1),
        np.array([point.check for point in points], bool),
    )


def _has_model_positions(path: Path) -> bool:
    try:
        return NamedTable(path, _PAIR_COLUMNS).has(_MODEL_COLUMNS[0])
    except InputError:
        return False


def read_scale_bars(path: str | Path) -> list[ScaleBar]:
    """Read a table `from, to, length_m[, sigma_m][, use]`. Raises InputError."""
    table = NamedTable(path, ("from", "to", "length_m"))
    first_labels = table.words(("from", "first", "start", "label 1", "point 1"), "from")
    second_labels = table.words(("to", "second", "end", "label 2", "point 2"), "to")
    (lengths,) = table.columns((("length", "length m", "distance", "distance m"),), ("length_m",)).T
    for row in np.flatnonzero(~(lengths > 0)):
        raise table.cell_error(int(row), Finding("table.not-positive"), "length_m")
    for bar, (first_label, second_label) in enumerate(
        zip(first_labels, second_labels, strict=True)
    ):
        if first_label == second_label:
            raise table.cell_error(
                bar,
                Finding("control.bar-of-one-point", label=shorten(first_label)),
                "to",
            )
    sigma = table.positive_numbers(
        ("sigma", "sigma m", "accuracy", "accuracy m", "error"), "sigma_m"
    )
    return [
        ScaleBar(
            first_label,
            second_label,
            float(length),
            None if np.isnan(sigma) else float(sigma),
            bool(check),
            table.path,
            int(line),
        )
        for first_label, second_label, length, sigma, check, line in zip(
            first_labels,
            second_labels,
            lengths,
            sigma,
            table.is_check_point(),
            table.table.line_numbers,
            strict=True,
        )
    ]


def read_positions(path: str | Path) -> Positions:
    """Read a table `photo, x, y, z[, sigma_x, sigma_y, sigma_z]` or a `geo.txt` file.

    Longitude, latitude and altitude are recognised from the header. Raises InputError.
    """
    path = Path(path)
    if is_geo(path):
        geo = read_geo(path)
        sigma = geo.sigma[:, [0, 0, 1]]
        return Positions(
            geo.photos, geo.coordinates, False, sigma, geo.crs, file=path, line=geo.line
        )
    table = NamedTable(path, ("photo", "x", "y", "z"))
    photos = table.words(PHOTO_NAMES, "photo")
    table.require_unique(photos)
    positions = table.columns(WORLD, ("x", "y", "z"))
    is_in_degrees = table.has(("lon", "longitude", "x longitude"))
    if not is_in_degrees:
        table.require_coordinates(positions)
    stated_crs, findings = table_crs(path, table.table.comments)
    return Positions(
        photos,
        positions,
        is_in_degrees,
        table.sigma(),
        stated_crs.text,
        file=path,
        notes=(*table.notes, *findings),
    )


def read_level_lines(path: str | Path) -> LevelTable:
    """Read a table `photo, x1, y1, x2, y2` with the pixels of the ends. Raises InputError."""
    table = NamedTable(path, ("photo", "x1", "y1", "x2", "y2"))
    photos = table.words(PHOTO_NAMES, "photo")
    names = ("x1", "y1", "x2", "y2")
    ends = table.columns(tuple((name,) for name in names), names).reshape(-1, 2, 2)
    for row in np.flatnonzero(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) < 1.0):
        raise table.cell_error(int(row), Finding("control.line-without-length"), "x2")
    return LevelTable(photos, ends)


def read_compass(path: str | Path, azimuth: Azimuth | None = None) -> CompassTable:
    """Read compass readings and the directions of the same features in the model frame.

    The table is an orientation table with additional columns: the vectors `model_x, model_y,
    model_z` (normals for planes) and, optionally, the standard deviations `sigma_deg`. `azimuth`
    is the meaning of a column named azimuth. Raises InputError and UsageError.
    """
    table = NamedTable(path, ())
    if not all(table.has(names) for names in _MODEL_COLUMNS):
        raise InputError(
            Finding("control.no-model-direction"), file=table.path, line=table.table.header_line
        )
    orientations = extract_orientations(table.table, azimuth)
    vectors = table.columns(_MODEL_COLUMNS, ("model_x", "model_y", "model_z"))[
        orientations.row_indices
    ]
    length = np.linalg.norm(vectors, axis=1)
    for index in np.flatnonzero(~(length > 0)):
        raise table.cell_error(
            int(orientations.row_indices[index]),
            Finding("control.no-model-direction"),
            "model_x",
        )
    sigma = table.positive_numbers(("sigma", "sigma deg", "accuracy", "accuracy deg"), "sigma_deg")
    for row in np.flatnonzero(sigma > 90.0):
        raise table.cell_error(
            int(row),
            Finding("angle.out-of-range", value=sigma[row], minimum=0.0, maximum=90.0),
            "sigma_deg",
        )
    labels = orientations.ids
    if not table.has(("id",)) and table.has(LABEL_NAMES):
        names = table.words(LABEL_NAMES, "label", allow_empty=True)
        labels = tuple(
            names[row] or label for row, label in zip(orientations.row_indices, labels, strict=True)
        )
    return CompassTable(
        labels,
        orientations.is_plane,
        np.where(orientations.is_plane, orientations.dip_direction_deg, orientations.trend_deg),
        np.where(orientations.is_plane, orientations.dip_deg, orientations.plunge_deg),
        vectors / length[:, None],
        sigma[orientations.row_indices],
    )
