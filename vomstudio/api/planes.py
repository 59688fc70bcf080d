"""Fits of planes to points."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vomstudio.api.checking import (
    coordinate_names,
    numbers,
    require_positive,
    requires_type_error,
    to_list,
    to_plane,
    warn,
    wrong_type_error,
)
from vomstudio.api.declared_options import options_from_arguments
from vomstudio.api.point_arguments import points
from vomstudio.api.tables import dataframe_crs, frame
from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import html_table
from vomstudio.core.results import HIDDEN_IN_JSON, Result
from vomstudio.core.words import tr
from vomstudio.geology.beds.parallel import ParallelBeds, parallel_beds
from vomstudio.geology.notation import format_attitude
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.profiles import PROFILES_BY_NAME
from vomstudio.io.gate.points import points_to_world
from vomstudio.io.text.group_columns import GROUP_COLUMNS, Words, group_words
from vomstudio.project.tables.fit_options import FitOptions
from vomstudio.project.tables.fitted_planes import FittedPlanes, fitted_planes

if TYPE_CHECKING:
    import pandas

    from vomstudio.api.argument_types import GroupsArgument, PointsArgument

Method = Literal["pca", "regression"]
Axis = Literal["auto", "x", "y", "z"]
Profile = Literal["error", "textbook"]


@dataclass(frozen=True, repr=False)
class OrientationFigures(Result):
    """Columns of the orientation table; None means undefined or not applicable."""

    id: Hashable
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
    warnings: tuple[Finding, ...] = field(default=(), metadata=HIDDEN_IN_JSON)

    @property
    def centroid(self) -> FloatArray | None:
        """Centroid (3,) of the points, or None if the position is unknown."""
        if self.x is None or self.y is None or self.z is None:
            return None
        return np.array([self.x, self.y, self.z])

    def _repr_html_(self) -> str:
        return html_table(type(self).__name__, self.to_dict())


@dataclass(frozen=True, repr=False)
class PlaneFit(OrientationFigures):
    """Plane and its errors; the attributes are the columns of the orientation table.

    Angles are in degrees, lengths in metres, and coordinates in the frame of the points (World
    frame: x East, y North, z Up). None means undefined or not applicable.

    Attributes
    ----------
    dip_direction_deg, dip_deg, strike_rhr_deg, pole_trend_deg, pole_plunge_deg
        Attitude of the plane.
    undefined
        Whether the plane is horizontal and therefore has no dip direction, strike or trend
        of the pole.
    x, y, z
        Centroid of the points.
    normal_x, normal_y, normal_z
        Upward unit normal.
    n_points, extent_m, area_m2, rms_m
        Number of points, and their extent, area and scatter.
    lambda1, lambda2, lambda3, coplanarity, collinearity, M, K
        Eigenvalues and indices that describe the shape of the point set.
    max_angular_error_deg, min_angular_error_deg
        Hyperbolic error (Quinn & Ehlmann 2019).
    max_confidence95_deg, min_confidence95_deg, error_rake_deg
        Joint 95 % region of the normal.
    dip_error_deg, dip_direction_error_deg
        Errors of the dip and the dip direction from the same region.
    registration_error_deg, total95_deg
        Error of the rotation of the model, and its combination with the error of the fit.
    normal_cov_ee to normal_cov_uu
        Covariance of the normal (east, north, up), radians squared.
    resolution_m, extent_over_resolution
        Resolution of the model, and the extent as a multiple of the resolution.
    bend_deg
        Bend of the whole face, from edge to edge.
    attitude_scale
        "local" or "regional": whether the plane represents only the local attitude.
    quality, quality_reason, reason_codes, quality_notes
        Verdict (good, doubtful or poor), its reasons, the codes of the reasons separated by
        spaces, and notes that do not affect the verdict.
    profile
        Profile used for the verdict.
    method
        "pca" or "regression".
    id, name, kind, set, overturned, model, frame, notes
        Attributes of a feature of a project.
    element
        "plane".
    warnings
        Reasons and notes of the verdict as findings with ``code``, ``message`` and ``values``.

    Notes
    -----
    The sources of the figures are listed in `vs.fit_plane`.

    Examples
    --------
    >>> import vomstudio as vs
    >>> flat = vs.fit_plane([[0, 0, 1], [4, 0, 1], [0, 4, 1], [3, 3, 1]])
    >>> flat.undefined, flat.dip_direction_deg, flat.dip_deg, flat.normal.tolist()
    (True, None, 0.0, [0.0, 0.0, 1.0])
    >>> [warning.code for warning in flat.warnings]
    ['plane.too-few-points']
    """

    dip_deg: float
    pole_plunge_deg: float
    normal_x: float
    normal_y: float
    normal_z: float

    @property
    def normal(self) -> FloatArray:
        """Upward unit normal (3,)."""
        return np.array([self.normal_x, self.normal_y, self.normal_z])

    @property
    def normal_covariance(self) -> FloatArray | None:
        """Covariance (3, 3) of the normal, radians squared, or None if its error is unknown."""
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
    """Lineation or fold axis; the attributes are the columns of the orientation table.

    None means undefined or not applicable.

    Attributes
    ----------
    trend_deg, plunge_deg
        Trend and plunge, degrees; the plunge is positive downwards.
    undefined
        Whether the line is vertical and therefore has no trend.
    rake_deg
        Rake in the plane of the line, 0 to 180 from the right-hand-rule strike.
    slip_rake_deg
        Rake of the movement of the hanging wall, -180 to 180, positive if reverse (Aki &
        Richards); None if the sense of slip is unknown or does not determine the direction.
    slip_sense, slip_confidence
        Sense of slip and its confidence, as recorded.
    on_plane, on_plane_dip_direction_deg, on_plane_dip_deg
        Plane that contains the line.
    element
        "line".

    Notes
    -----
    The other attributes are as in `PlaneFit`; see `vs.Project.fit`.

    Examples
    --------
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


_AZIMUTH_COLUMNS = ("dip_direction_deg", "strike_rhr_deg", "pole_trend_deg", "trend_deg")
"""Azimuths; if the flag `undefined` is set, their values are conventional and meaningless."""


def to_plane_fit(row: Mapping[str, Any], warnings: Sequence[Finding] = ()) -> PlaneFit:
    """Convert a row of the orientation table to a plane fit.

    Parameters
    ----------
    row : mapping
    warnings : sequence of Finding, optional
        Reasons and notes of the verdict.

    Returns
    -------
    PlaneFit
    """
    return PlaneFit(**_public_figures(row), warnings=tuple(warnings))


def to_line_fit(row: Mapping[str, Any], warnings: Sequence[Finding] = ()) -> LineFit:
    """Convert a row of the orientation table to a line fit.

    Parameters
    ----------
    row : mapping
    warnings : sequence of Finding, optional
        Reasons and notes of the verdict.

    Returns
    -------
    LineFit
    """
    return LineFit(**_public_figures(row), warnings=tuple(warnings))


def _public_figures(row: Mapping[str, Any]) -> dict[str, Any]:
    columns = (column.name for column in fields(OrientationFigures) if column.name != "warnings")
    values = {name: row[name] for name in columns}
    return values | dict.fromkeys(_AZIMUTH_COLUMNS) if row["undefined"] else values


def fit_plane(
    points: PointsArgument,
    *,
    method: Method = "pca",
    axis: Axis = "auto",
    resolution_m: float | None = None,
    profile: Profile = "error",
) -> PlaneFit:
    """Fit a plane to points, and compute its errors and a verdict.

    Parameters
    ----------
    points : (n, 3) array, DataFrame, Mesh, PointCloud, PyVista data set or path
        Coordinates x, y, z in metres, n >= 3, in the order in which the points follow the
        trace; a DataFrame with columns x, y, z; or a model or its file, with its vertices.
    method : {"pca", "regression"}, optional
        "pca" minimises the distances from the plane (moment of inertia), "regression" the
        residuals along one coordinate.
    axis : {"auto", "x", "y", "z"}, optional
        Coordinate of the regression; "auto" selects the axis nearest to the normal.
    resolution_m : float, optional
        Resolution of the model on which the points were picked. If given, the verdict also
        considers the extent.
    profile : {"error", "textbook"}, optional
        Profile of the verdict; "error" uses the error of the plane.

    Returns
    -------
    PlaneFit

    Raises
    ------
    vs.errors.InputError
        If the array has another shape or contains text or non-finite coordinates.
    vs.errors.GeometryError
        If there are fewer than three points, or the points are identical or collinear.

    Notes
    -----
    Source: Tavani, Corradetti, Mercuri & Seers, "Virtual outcrop models of geological
    structures", section 4.1, equations 19 to 21. The hyperbolic error follows Quinn & Ehlmann
    (2019).

    Examples
    --------
    Points on a plane that dips 45 degrees to the east:

    >>> import vomstudio as vs
    >>> points = [[0, 0, 0], [0, 5, 0], [3, 1, -3], [4, 4, -4.01], [2, 3, -2], [1, 4, -1]]
    >>> bed = vs.fit_plane(points)
    >>> round(bed.dip_direction_deg), round(bed.dip_deg)
    (90, 45)
    >>> bed.quality
    'good'
    """
    array = _to_points(points)
    single_group = _Groups([None], array, np.array([0, len(array)]))
    options = options_from_arguments(FitOptions, method=method, axis=axis, profile=profile)
    fitted_groups = _fit_groups(single_group, options, resolution_m)
    if not fitted_groups.rows:
        raise GeometryError(fitted_groups.skipped[0]["reason"])
    return to_plane_fit(fitted_groups.rows[0], fitted_groups.warnings[0])


def fit_planes(
    groups: GroupsArgument,
    *,
    by: Hashable | None = None,
    method: Method = "pca",
    axis: Axis = "auto",
    resolution_m: float | None = None,
    profile: Profile = "error",
) -> pandas.DataFrame:
    """Fit planes to many groups of points at once.

    Parameters
    ----------
    groups : dict of id to (n, 3) array, or DataFrame
        ``{id: points}`` with points (n, 3) as in `fit_plane`, or a DataFrame with columns
        x, y, z.
    by : str, optional
        Column of the DataFrame that groups the points.
    method, axis, resolution_m, profile
        See `fit_plane`.

    Returns
    -------
    DataFrame
        One row per plane, with the columns of the orientation table in degrees and metres,
        in the order of the groups. Groups to which no plane can be fitted are omitted:
        ``.attrs["skipped"]`` lists them as ``{"id", "reason"}``, and a Python warning is
        issued. Rows of a DataFrame with non-finite coordinates are also omitted.

    Raises
    ------
    vs.errors.InputError
        Under the conditions of `fit_plane`, and if a column of coordinates is missing.
    vs.errors.UsageError
        If `by` is missing for a DataFrame, is not one of its columns, or is given for a dict.
    vs.errors.GeometryError
        If no plane can be fitted to any group.

    Examples
    --------
    >>> import pandas
    >>> import vomstudio as vs
    >>> picks = pandas.read_csv(vs.sample("picks.csv"), comment="#")
    >>> planes = vs.fit_planes(picks, by="pick")
    >>> planes[["id", "dip_direction_deg", "dip_deg", "quality"]].round(1).head(1).values.tolist()
    [['B01', 315.2, 38.2, 'good']]
    """
    point_groups = to_groups(groups, by)
    options = options_from_arguments(FitOptions, method=method, axis=axis, profile=profile)
    fitted_groups = _fit_groups(point_groups, options, resolution_m)
    if not fitted_groups.rows:
        first_skipped = fitted_groups.skipped[0]
        raise GeometryError(
            Finding(
                "plane.none-fitted",
                count=len(fitted_groups.skipped),
                reason=first_skipped["reason"],
            ),
            field=str(first_skipped["id"]),
        )
    findings = [*point_groups.messages]
    findings += [
        Finding("feature.left-out", feature=str(item["id"]), reason=item["reason"])
        for item in fitted_groups.skipped
    ]
    if point_groups.dropped:
        findings.append(Finding("array.rows-left-out", count=point_groups.dropped))
    warn(findings)
    dataframe = frame(fitted_groups.rows)
    dataframe.attrs["skipped"] = fitted_groups.skipped
    dataframe.attrs["warnings"] = findings
    return dataframe


def fit_parallel(
    groups: GroupsArgument,
    *,
    by: Hashable | None = None,
    same: Sequence[tuple[Hashable, Hashable]] = (),
) -> ParallelBeds:
    """Fit parallel planes to several traces and test which traces belong to the same bed.

    Parameters
    ----------
    groups : dict of id to (n, 3) array, or DataFrame
        See `fit_planes`; the points of each group must be in order along the trace.
    by : str, optional
        See `fit_planes`.
    same : sequence of (hashable, hashable), optional
        Pairs of ids of traces that are tested for a common plane. By default, each trace is
        tested with the next trace above it.

    Returns
    -------
    ParallelBeds
        ``dip_direction_deg``, ``dip_deg``, ``max_confidence95_deg``,
        ``min_confidence95_deg`` (joint; None if no trace has more than three points),
        ``p_parallel``, ``beds`` in order upwards along the normal (``id``, ``n``,
        ``distance_m``, ``error95_m``, ``rms_m``), and ``same`` (``first``, ``second``,
        ``distance_m``, ``error95_m``, ``p``).

    Raises
    ------
    vs.errors.InputError
        Under the conditions of `fit_planes`.
    vs.errors.UsageError
        Under the conditions of `fit_planes`, and if a pair contains an id that is not among the
        groups.
    vs.errors.GeometryError
        If there are fewer than two groups, or the traces are straight with the same
        direction.

    Notes
    -----
    The normal is computed from the scatter of all points about the centroids of their traces
    (Quinn & Ehlmann 2019, Earth and Space Science 6). Distances are tested with Student's t
    test.

    Examples
    --------
    >>> import pandas
    >>> import vomstudio as vs
    >>> picks = pandas.read_csv(vs.sample("picks.csv"), comment="#")
    >>> limb = picks[picks["pick"].isin(["B01", "B03"])]
    >>> fit = vs.fit_parallel(limb, by="pick")
    >>> len(fit.beds), fit.p_parallel > 0.05, fit.max_confidence95_deg < 1
    (2, True, True)
    """
    point_groups = to_groups(groups, by)
    names = [str(name) for name in point_groups.ids]
    pairs = [_to_pair(item, names) for item in to_list(same, "same")]
    beds = parallel_beds(names, point_groups.points, point_groups.offsets, pairs=pairs)
    warn([*point_groups.messages, *beds.warnings])
    return beds


def _to_pair(value: Any, names: list[str]) -> tuple[str, str]:
    pair = [value] if isinstance(value, str) else [str(id) for id in to_list(value, "same")]
    if len(pair) != 2 or not set(pair) <= set(names):
        finding = Finding("trace.not-a-pair", value=pair, first=names[0], second=names[-1])
        raise UsageError(finding, field="same")
    return pair[0], pair[1]


def _to_points(value: Any) -> FloatArray:
    return points(value)


@dataclass(frozen=True, eq=False)
class _Groups:
    """Groups of points.

    Parameters
    ----------
    offsets : int array
        First row of each group in `points`, and the end of the last group.
    dropped : int
        Number of rows without coordinates or without a group.
    words : Words
        Attributes of the groups.
    messages : sequence of Finding
        Messages about the points.
    """

    ids: list[Any]
    points: FloatArray
    offsets: IntArray
    dropped: int = 0
    words: Words[Any] = field(default_factory=dict)
    messages: Sequence[Finding] = ()


def _fit_groups(groups: _Groups, options: FitOptions, resolution_m: float | None) -> FittedPlanes:
    resolution_m = require_positive(resolution_m, "resolution_m")
    return fitted_planes(
        groups.ids,
        groups.points,
        groups.offsets,
        method=options.method,
        axis=options.axis,
        resolution_m=resolution_m,
        thresholds=PROFILES_BY_NAME[options.profile],
        metadata=groups.words,
    )


def to_groups(value: Any, by: Any) -> _Groups:
    """Convert groups of points, or a DataFrame with a grouping column, to one array.

    Parameters
    ----------
    value : mapping or DataFrame
    by : object
        Column of the DataFrame that contains the names of the groups.

    Returns
    -------
    _Groups

    Raises
    ------
    InputError
        If the value has another type or is empty, or no row is valid.
    UsageError
        If `by` is missing, is unknown or does not apply.
    """
    if isinstance(value, Mapping):
        if by is not None:
            raise requires_type_error("by", "groups", "pandas.DataFrame")
        if not value:
            raise InputError(Finding("argument.empty"), field="groups")
        arrays = [points(item, f"points of {name}") for name, item in value.items()]
        offsets = np.concatenate([[0], np.cumsum([len(a) for a in arrays])])
        return _Groups(list(value), np.concatenate(arrays), offsets.astype(np.int64))
    if not (hasattr(value, "columns") and hasattr(value, "groupby")):
        raise wrong_type_error(value, "{id: points}, pandas.DataFrame", "groups")
    columns = list(value.columns)
    if by is None:
        raise UsageError(Finding("option.missing"), field="by")
    if not isinstance(by, Hashable):
        raise wrong_type_error(by, "str", "by")
    if by not in columns:
        raise UsageError(Finding("table.unknown-column", column=by, columns=columns), field="by")
    placed_points = points_to_world(
        numbers(value[coordinate_names(columns, "groups")], "groups"),
        file=Path("groups"),
        comments=(f"CRS: {dataframe_crs(value) or 'local'}",),
    )
    array = placed_points.points
    names = value[by]
    is_valid = np.isfinite(array).all(axis=1) & ~np.asarray(names.isna(), bool)
    if not is_valid.any():
        raise InputError(
            Finding("table.no-valid-rows", count=len(value), needed=tr("coordinates")),
            field="groups",
        )
    codes, ids = names[is_valid].factorize()
    counts = np.bincount(codes, minlength=len(ids))
    order = np.argsort(codes, kind="stable")
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    attributes = {
        c: value[c].fillna("").astype(str).tolist()
        for c in GROUP_COLUMNS
        if c != by and c in columns
    }
    attributes_by_group, attribute_findings = group_words(
        attributes, names.tolist(), is_valid.tolist()
    )
    findings: list[Finding] = [*placed_points.findings, *attribute_findings]
    return _Groups(
        list(ids),
        array[is_valid][order],
        offsets,
        int((~is_valid).sum()),
        attributes_by_group,
        findings,
    )


def plane_text(value: Any) -> str | None:
    """Format a plane as "DD/D" (dip direction/dip). Text and None are returned unchanged.

    Parameters
    ----------
    value : object
        Text, two angles, a PlaneFit, or None.

    Returns
    -------
    str or None

    Raises
    ------
    InputError
        If the value is neither text nor a valid plane.
    """
    if value is None or isinstance(value, str):
        return value
    plane = to_plane(value, "plane")
    return f"{plane.dip_direction_deg!r}/{plane.dip_deg!r}"
