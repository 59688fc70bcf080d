"""Planes fitted to points."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np

from vomstudio.api.checking import (
    attitude_of,
    coordinate_names,
    items_of,
    numbers,
    points,
    positive,
    requires_type,
    warn,
    wrong_type,
)
from vomstudio.api.declared_options import options_from_arguments
from vomstudio.api.tables import dataframe_crs, frame
from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import html_table
from vomstudio.core.results import Result
from vomstudio.core.words import tr
from vomstudio.geology.beds.parallel import ParallelBeds, parallel_beds
from vomstudio.geology.notation import format_attitude
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.profiles import PROFILES
from vomstudio.io.gate.points import points_to_world
from vomstudio.io.text.group_columns import COLUMNS, Words, group_words
from vomstudio.project.tables.fit_options import FitOptions
from vomstudio.project.tables.fitted_planes import FittedPlanes, fitted_planes

Method = Literal["pca", "regression"]
Axis = Literal["auto", "x", "y", "z"]
Profile = Literal["error", "textbook"]


@dataclass(frozen=True, repr=False)
class OrientationFigures(Result):
    """The columns of the orientation table, None where a figure is undefined or does not apply."""

    id: Any
    name: str | None
    kind: str | None
    element: str | None
    set: str | None
    dip_direction_deg: float | None
    dip_deg: float | None
    strike_rhr_deg: float | None
    pole_trend_deg: float | None
    pole_plunge_deg: float | None
    trend_deg: float | None
    plunge_deg: float | None
    rake_deg: float | None
    slip_rake_deg: float | None
    slip_sense: str | None
    slip_confidence: str | None
    on_plane: str | None
    on_plane_dip_direction_deg: float | None
    on_plane_dip_deg: float | None
    overturned: bool | None
    undefined: bool
    x: float | None
    y: float | None
    z: float | None
    normal_x: float | None
    normal_y: float | None
    normal_z: float | None
    n_points: int | None
    extent_m: float | None
    area_m2: float | None
    rms_m: float | None
    lambda1: float | None
    lambda2: float | None
    lambda3: float | None
    coplanarity: float | None
    collinearity: float | None
    M: float | None
    K: float | None
    max_angular_error_deg: float | None
    min_angular_error_deg: float | None
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    error_rake_deg: float | None
    dip_error_deg: float | None
    dip_direction_error_deg: float | None
    registration_error_deg: float | None
    total95_deg: float | None
    normal_cov_ee: float | None
    normal_cov_en: float | None
    normal_cov_eu: float | None
    normal_cov_nn: float | None
    normal_cov_nu: float | None
    normal_cov_uu: float | None
    resolution_m: float | None
    extent_over_resolution: float | None
    bend_deg: float | None
    attitude_scale: str | None
    quality: str | None
    quality_reason: str | None
    reason_codes: str | None
    quality_notes: str | None
    profile: str | None
    method: str | None
    model: str | None
    frame: str | None
    notes: str | None

    @property
    def centroid(self) -> FloatArray | None:
        """(3,) centre of the points; None for what has no place."""
        if self.x is None or self.y is None or self.z is None:
            return None
        return np.array([self.x, self.y, self.z])

    def _repr_html_(self) -> str:
        return html_table(type(self).__name__, self.to_dict())


@dataclass(frozen=True, repr=False)
class PlaneFit(OrientationFigures):
    """One plane and how well it is known; attributes are the columns of the orientation table.

    Angles in degrees, lengths in metres, coordinates in the frame of the points (World: x East, y
    North, z Up). None where a figure is undefined or does not apply, as those of lines do.

    dip_direction_deg, dip_deg, strike_rhr_deg, pole_trend_deg, pole_plunge_deg : the attitude
    undefined : the plane is horizontal: no dip direction, no strike, no trend of the pole
    x, y, z : centre of the points; normal_x, normal_y, normal_z : upward unit normal
    n_points, extent_m, area_m2, rms_m : how many points, their length, area and scatter
    lambda1, lambda2, lambda3, coplanarity, collinearity, M, K : shape of the points
    max_angular_error_deg, min_angular_error_deg : hyperbolic error (Quinn & Ehlmann 2019)
    max_confidence95_deg, min_confidence95_deg, error_rake_deg : joint 95 % region of the normal
    dip_error_deg, dip_direction_error_deg : the same along and across the dip
    registration_error_deg, total95_deg : of the model's rotation, and together with the fit's
    normal_cov_ee, ... normal_cov_uu : covariance of the normal (east, north, up), radians squared
    resolution_m, extent_over_resolution : of the model
    bend_deg : of a face that bends as a whole, from edge to edge; attitude_scale : "local" or
    "regional", whether the plane is the attitude of this place alone
    quality, quality_reason, reason_codes, quality_notes : good, doubtful or poor, why, the codes of
        these reasons with spaces between, and what lowers no verdict
    profile : by whose limits the verdict was given; method : "pca" or "regression"
    id, name, kind, set, overturned, model, frame, notes : of a feature of a project
    element : "plane"

    Source of the figures: `vs.fit_plane`.

    >>> import vomstudio as vs
    >>> flat = vs.fit_plane([[0, 0, 1], [4, 0, 1], [0, 4, 1], [3, 3, 1]])
    >>> flat.undefined, flat.dip_direction_deg, flat.dip_deg, flat.normal.tolist()
    (True, None, 0.0, [0.0, 0.0, 1.0])
    """

    dip_deg: float
    pole_plunge_deg: float
    normal_x: float
    normal_y: float
    normal_z: float

    @property
    def normal(self) -> FloatArray:
        """(3,) upward unit normal."""
        return np.array([self.normal_x, self.normal_y, self.normal_z])

    @property
    def normal_covariance(self) -> FloatArray | None:
        """(3, 3) covariance of the normal, radians squared; None if its error is not known."""
        ee, en, eu = self.normal_cov_ee, self.normal_cov_en, self.normal_cov_eu
        nn, nu, uu = self.normal_cov_nn, self.normal_cov_nu, self.normal_cov_uu
        if ee is None:
            return None
        return np.array([[ee, en, eu], [en, nn, nu], [eu, nu, uu]], np.float64)

    def __repr__(self) -> str:
        plane = Plane(self.dip_direction_deg or 0.0, self.dip_deg)
        name = f"{self.name}: " if self.name else ""
        return f"PlaneFit({name}{format_attitude(plane, self.total95_deg)}, {self.quality})"


@dataclass(frozen=True, repr=False)
class LineFit(OrientationFigures):
    """One line (lineation, fold axis); attributes are the columns of the orientation table, None
    where a figure is undefined or does not apply, as those of planes do.

    trend_deg, plunge_deg : degrees, plunge downward; undefined : vertical, without a trend
    rake_deg : in the plane that bears it, 0 to 180 from the right-hand-rule strike; slip_rake_deg :
        of the movement of the hanging wall, -180 to 180, positive where reverse (Aki & Richards);
        None where the sense of slip is not known or does not tell the direction
    slip_sense, slip_confidence : as noted
    on_plane, on_plane_dip_direction_deg, on_plane_dip_deg : the plane that bears it
    element : "line"
    The others as in `PlaneFit`. `vs.Project.fit` gives one of a feature that is a line.

    >>> from dataclasses import fields
    >>> import vomstudio as vs
    >>> [field.name for field in fields(vs.LineFit)][10:12]
    ['trend_deg', 'plunge_deg']
    """

    plunge_deg: float

    def __repr__(self) -> str:
        line = Line(self.trend_deg or 0.0, self.plunge_deg)
        name = f"{self.name}: " if self.name else ""
        return f"LineFit({name}{format_attitude(line, self.total95_deg)})"


_AZIMUTHS = ("dip_direction_deg", "strike_rhr_deg", "pole_trend_deg", "trend_deg")
"""Of what is horizontal or vertical a table has them by convention, with the flag `undefined`."""


def plane_of_row(row: Mapping[str, Any]) -> PlaneFit:
    return PlaneFit(**_figures(row))


def line_of_row(row: Mapping[str, Any]) -> LineFit:
    return LineFit(**_figures(row))


def _figures(row: Mapping[str, Any]) -> dict[str, Any]:
    found = {field.name: row[field.name] for field in fields(OrientationFigures)}
    return found | dict.fromkeys(_AZIMUTHS) if row["undefined"] else found


def fit_plane(
    points: Any,
    *,
    method: Method = "pca",
    axis: Axis = "auto",
    resolution_m: float | None = None,
    profile: Profile = "error",
) -> PlaneFit:
    """The plane through points, its errors, and whether it is worth keeping.

    Parameters
    ----------
    points : (n, 3) x, y, z in metres, n >= 3, in the order in which they follow the trace; or a
        DataFrame with columns x, y, z
    method : "pca" minimises distances from the plane (moment of inertia), "regression" those along
        one coordinate
    axis : that coordinate; "auto" takes the one nearest the normal
    resolution_m : of the model that the points were picked on: with it the extent is judged, too
    profile : how the verdict is given: "error", by what the plane may be off

    Returns
    -------
    PlaneFit

    Raises
    ------
    vs.errors.InputError for an array of another shape, text, or coordinates that are not finite;
    vs.errors.GeometryError for fewer than three points, or points that are identical or on a line.

    Source: Tavani, Corradetti, Mercuri & Seers, "Virtual outcrop models of geological structures",
    section 4.1, equations 19 to 21; hyperbolic error after Quinn & Ehlmann (2019).

    Examples
    --------
    Points on the plane that dips by 45 degrees to the east:

    >>> import vomstudio as vs
    >>> points = [[0, 0, 0], [0, 5, 0], [3, 1, -3], [4, 4, -4.01], [2, 3, -2], [1, 4, -1]]
    >>> bed = vs.fit_plane(points)
    >>> round(bed.dip_direction_deg), round(bed.dip_deg)
    (90, 45)
    >>> bed.quality
    'good'
    """
    array = _points(points)
    alone = _Groups([None], array, np.array([0, len(array)]))
    options = options_from_arguments(FitOptions, method=method, axis=axis, profile=profile)
    done = _fitted(alone, options, resolution_m)
    if not done.rows:
        raise GeometryError(done.skipped[0]["reason"])
    return plane_of_row(done.rows[0])


def fit_planes(
    groups: Any,
    *,
    by: Any = None,
    method: Method = "pca",
    axis: Axis = "auto",
    resolution_m: float | None = None,
    profile: Profile = "error",
) -> Any:
    """Planes through many groups of points at once.

    Parameters
    ----------
    groups : ``{id: points}``, each (n, 3) as in `fit_plane`, or a DataFrame with columns x, y, z
    by : of a DataFrame, the column whose values tell the planes apart
    method, axis, resolution_m, profile : as in `fit_plane`

    Returns
    -------
    DataFrame, one row a plane, with the columns of the orientation table in degrees and metres, in
    the order of the groups. Groups without a plane are left out: ``.attrs["skipped"]`` lists
    ``{"id", "reason"}``, and a Python warning says so. Rows of a DataFrame whose coordinates are
    not finite are left out likewise.

    Raises
    ------
    vs.errors.InputError as `fit_plane`, and for a column that is not there;
    vs.errors.GeometryError where no group has a plane.

    Examples
    --------
    >>> import pandas
    >>> import vomstudio as vs
    >>> picks = pandas.read_csv(vs.sample("picks.csv"), comment="#")
    >>> planes = vs.fit_planes(picks, by="pick")
    >>> planes[["id", "dip_direction_deg", "dip_deg", "quality"]].round(1).head(1).values.tolist()
    [['B01', 315.2, 38.2, 'good']]
    """
    given = groups_of(groups, by)
    options = options_from_arguments(FitOptions, method=method, axis=axis, profile=profile)
    done = _fitted(given, options, resolution_m)
    if not done.rows:
        first = done.skipped[0]
        raise GeometryError(
            Finding("plane.none-fitted", count=len(done.skipped), reason=first["reason"]),
            field=str(first["id"]),
        )
    messages = [*given.messages]
    messages += [
        Finding("feature.left-out", feature=str(item["id"]), reason=item["reason"])
        for item in done.skipped
    ]
    if given.dropped:
        messages.append(Finding("array.rows-left-out", count=given.dropped))
    warn(messages)
    made = frame(done.rows)
    made.attrs["skipped"] = done.skipped
    made.attrs["warnings"] = messages
    return made


def fit_parallel(
    groups: Any, *, by: Any = None, same: Sequence[tuple[Any, Any]] = ()
) -> ParallelBeds:
    """Parallel planes through several traces together, and whether two of them are of one bed.

    Parameters
    ----------
    groups, by : as in `fit_planes`, the points of each in the order of its trace
    same : pairs of ids to be held against lying in one plane; none for each with the next upwards

    Returns
    -------
    ParallelBeds: ``dip_direction_deg``, ``dip_deg``, ``max_confidence95_deg``,
    ``min_confidence95_deg`` (joint, None where no trace has over three points), ``p_parallel``,
    ``beds`` upwards along the normal (``id``, ``n``, ``distance_m``, ``error95_m``, ``rms_m``) and
    ``same`` (``first``, ``second``, ``distance_m``, ``error95_m``, ``p``).

    Raises
    ------
    vs.errors.InputError as `fit_planes`; vs.errors.UsageError for a pair that is not among the
    groups; vs.errors.GeometryError for fewer than two groups, or straight ones that run one way.

    The normal is that of the scatter of all points about the middles of their own traces (Quinn &
    Ehlmann 2019, Earth and Space Science 6). Distances are held against each other by Student's t.

    Examples
    --------
    >>> import pandas
    >>> import vomstudio as vs
    >>> picks = pandas.read_csv(vs.sample("picks.csv"), comment="#")
    >>> limb = picks[picks["pick"].isin(["B01", "B03"])]
    >>> found = vs.fit_parallel(limb, by="pick")
    >>> len(found.beds), found.p_parallel > 0.05, found.max_confidence95_deg < 1
    (2, True, True)
    """
    given = groups_of(groups, by)
    names = [str(name) for name in given.ids]
    pairs = [_pair(each, names) for each in items_of(same, "same")]
    found = parallel_beds(names, given.points, given.offsets, pairs=pairs)
    warn([*given.messages, *found.warnings])
    return found


def _pair(value: Any, names: list[str]) -> tuple[str, str]:
    pair = [value] if isinstance(value, str) else [str(id) for id in items_of(value, "same")]
    if len(pair) != 2 or not set(pair) <= set(names):
        finding = Finding("trace.not-a-pair", value=pair, first=names[0], second=names[-1])
        raise UsageError(finding, field="same")
    return pair[0], pair[1]


def _points(given: Any) -> FloatArray:
    return points(given)


@dataclass(frozen=True, eq=False)
class _Groups:
    """Groups of points.

    offsets : first row of each group in `points`, and the end; dropped : number of rows without
    coordinates or group; words : attributes of the groups; messages : messages about the points
    """

    ids: list[Any]
    points: FloatArray
    offsets: IntArray
    dropped: int = 0
    words: Words[Any] = field(default_factory=dict)
    messages: Sequence[Finding] = ()


def _fitted(groups: _Groups, options: FitOptions, resolution_m: float | None) -> FittedPlanes:
    resolution_m = positive(resolution_m, "resolution_m")
    return fitted_planes(
        groups.ids,
        groups.points,
        groups.offsets,
        method=options.method,
        axis=options.axis,
        resolution_m=resolution_m,
        thresholds=PROFILES[options.profile],
        metadata=groups.words,
    )


def groups_of(given: Any, by: Any) -> _Groups:
    if isinstance(given, Mapping):
        if by is not None:
            raise requires_type("by", "groups", "pandas.DataFrame")
        if not given:
            raise InputError(Finding("argument.empty"), field="groups")
        arrays = [points(each, f"points of {name}") for name, each in given.items()]
        offsets = np.concatenate([[0], np.cumsum([len(a) for a in arrays])])
        return _Groups(list(given), np.concatenate(arrays), offsets.astype(np.int64))
    if not (hasattr(given, "columns") and hasattr(given, "groupby")):
        raise wrong_type(given, "{id: points}, pandas.DataFrame", "groups")
    columns = list(given.columns)
    if by is None:
        raise UsageError(Finding("option.missing"), field="by")
    if not isinstance(by, Hashable):
        raise wrong_type(by, "str", "by")
    if by not in columns:
        raise UsageError(Finding("table.unknown-column", column=by, columns=columns), field="by")
    placed = points_to_world(
        numbers(given[coordinate_names(columns, "groups")], "groups"),
        file=Path("groups"),
        comments=(f"CRS: {dataframe_crs(given) or 'local'}",),
    )
    array = placed.points
    names = given[by]
    keep = np.isfinite(array).all(axis=1) & ~np.asarray(names.isna(), bool)
    if not keep.any():
        raise InputError(
            Finding("table.no-valid-rows", count=len(given), needed=tr("coordinates")),
            field="groups",
        )
    codes, ids = names[keep].factorize()
    counts = np.bincount(codes, minlength=len(ids))
    order = np.argsort(codes, kind="stable")
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    attributes = {
        c: given[c].fillna("").astype(str).tolist() for c in COLUMNS if c != by and c in columns
    }
    words, word_messages = group_words(attributes, names.tolist(), keep.tolist())
    findings: list[Finding] = [*placed.findings, *word_messages]
    return _Groups(list(ids), array[keep][order], offsets, int((~keep).sum()), words, findings)


def plane_text(given: Any) -> str | None:
    """Return a plane as "DD/D", given so, as two angles or as a PlaneFit. Raises InputError."""
    if given is None or isinstance(given, str):
        return given
    plane = attitude_of(given, "plane")
    return f"{plane.dip_direction_deg!r}/{plane.dip_deg!r}"
