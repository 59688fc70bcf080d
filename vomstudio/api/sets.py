"""Statistics, folds, slope stability and fault slip of sets of orientations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from vomstudio.api.checking import (
    column_name,
    is_path,
    name_argument_in_errors,
    optional_text,
    to_list,
    to_path,
    to_plane,
    warn,
)
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.tables import Azimuth, check_azimuth, to_orientation_table, to_text_table
from vomstudio.geology.coverage.repeat_options import RepeatOptions
from vomstudio.geology.coverage.table_repeats import TableRepeats, table_repeats
from vomstudio.geology.faults.table_slip import TableSlip, table_slip
from vomstudio.geology.fold_options import FoldOptions
from vomstudio.geology.populations.statistics_options import StatisticsOptions
from vomstudio.geology.populations.table_statistics import TableStatistics, table_statistics
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geology.table_folds import TableFold, table_fold
from vomstudio.geology.table_slopes import TableSlope, slope_face, table_slope
from vomstudio.io.gate.orientation_files import read_slips
from vomstudio.io.text.slip_reading import extract_slips

if TYPE_CHECKING:
    from vomstudio.api.argument_types import OrientationsArgument, TableArgument


def stats(
    table: OrientationsArgument,
    *,
    by: str | None = None,
    directed: bool = False,
    weights: Literal["error"] | None = None,
    azimuth: Azimuth | None = None,
) -> TableStatistics:
    """Compute the statistics of sets of planes or lines.

    Parameters
    ----------
    table : DataFrame, path, or (dip direction, dip)
        DataFrame of orientations (with any of the usual columns), path of a file, or a pair
        of arrays (dip direction, dip), (n,) each, degrees.
    by : str, optional
        Name or number of the column that groups the rows. If None, all rows form a single
        set ``all``.
    directed : bool, optional
        Whether lines have a direction and are not flipped; plunges may be negative.
    weights : {"error"}, optional
        "error" weights each orientation by its own 95 % error (``total95_deg``, otherwise
        ``max_confidence95_deg``) and the natural scatter of its set.
    azimuth : {"strike", "dipdir"}, optional
        Meaning of a column named only ``azimuth``: "strike" or "dipdir".

    Returns
    -------
    TableStatistics
        ``n`` and ``sets``, which maps names to SetStatistics with ``n``, ``of``, ``axial``,
        ``fisher`` (``trend_deg``, ``plunge_deg``, ``kappa``, ``alpha95_deg``, ``R``; None
        with ``fisher_reason`` if the set is not a cluster), ``tensor`` (``eigenvalues``,
        ``axes``), ``woodcock`` (``K``, ``C``), ``vollmer`` (``P``, ``G``, ``R``),
        ``bingham`` (``k1``, ``k2``, ``confidence95`` of the three axes, ``fit_p``),
        ``kent`` (for elongated clusters), each None with a reason if it is undefined,
        ``uniformity`` (``test``, ``statistic``, ``p``) and ``weights``. ``fit_p`` is the
        p-value of the goodness of fit.

    Raises
    ------
    vs.errors.InputError
        If an angle is invalid, the arrays have different lengths, or the table contains no
        orientations.
    vs.errors.UsageError
        If a column is missing.

    Notes
    -----
    Axial data are described by the orientation tensor (Woodcock 1977; Vollmer 1990). Clusters
    are described by Fisher statistics (1953) after flipping the data into the hemisphere of the
    first axis of the tensor. The Bingham (1974) and Kent (1982) distributions are fitted by
    maximum likelihood. Goodness of fit is assessed by the smooth test (Boulerice & Ducharme
    1997), uniformity by the test of Bingham or Rayleigh (Mardia & Jupp 2000).

    Examples
    --------
    >>> import vomstudio as vs
    >>> statistics = vs.stats(([90, 100, 95, 92], [40, 42, 38, 41]))
    >>> mean = statistics.sets["all"].fisher
    >>> round(mean.trend_deg), round(mean.plunge_deg)
    (274, 50)
    """
    options = options_from_arguments(StatisticsOptions, locals(), by=column_name(by))
    rows = to_orientation_table(table, azimuth)
    with name_arguments_in_errors(StatisticsOptions):
        result = table_statistics(rows, options)
    warn(result.warnings[len(rows.warnings) :])
    return result


def fold(
    table: OrientationsArgument,
    *,
    kind: str | None = None,
    sets: Sequence[str] | None = None,
    by: str | None = None,
    waviness_deg: float | None = None,
    quality: Literal["good", "doubtful"] | None = None,
    only_set: str | None = None,
    azimuth: Azimuth | None = None,
) -> TableFold:
    """Compute the pi-plane and fold axis, and assess whether one view direction is valid.

    Parameters
    ----------
    table : DataFrame, path, or (dip direction, dip)
        See `stats`; lines in the table are omitted.
    azimuth : {"strike", "dipdir"}, optional
        See `stats`.
    kind : str, optional
        Kind of the planes that are used; by default bedding, if the table contains kinds.
    sets : sequence of str, optional
        Two or three sets whose common axis is computed from their means.
    by : str, optional
        Column that names the domains, such as hanging wall and footwall. An axis is computed
        for each domain, and a test shows whether one axis is valid for all.
    waviness_deg : float, optional
        Standard deviation of the poles of a cylindrical fold. If None, the limits of Ramsay
        & Huber (1987) apply: nine tenths of the poles within 10 degrees.
    quality : {"good", "doubtful"}, optional
        Worst verdict (column ``quality``) of the planes that are used. If None, all planes
        are used.
    only_set : str, optional
        Set of the planes that are used.

    Returns
    -------
    TableFold
        ``n``, ``used``, ``not_good`` (number among the planes used; None if unjudged),
        ``left_out``, ``beta`` (``trend_deg``, ``plunge_deg``, semi-axes of the joint 95 % region),
        ``pi_plane``, ``eigenvalues``, ``rms_deg``, ``within90_deg``, ``arc_deg``, ``cone``
        (the best small circle), ``limbs`` (mean planes, interlimb angle and axial plane
        with errors), ``leave_one_out`` (the plane with the largest influence on beta),
        ``pairs`` (intersections of two sets), ``domains`` and ``one_axis``, ``valid`` (yes,
        conditional or no), ``verdict`` (cylindrical, conical, homoclinal, two axes,
        scattered or undetermined; for sets, common axis or two axes) and ``reasons``.

    Raises
    ------
    vs.errors.GeometryError
        If the planes have no axis.
    vs.errors.UsageError
        If the kind or a set does not exist.
    vs.errors.InputError
        Under the conditions of `stats`.

    Notes
    -----
    Beta is the eigenvector of the smallest eigenvalue of the orientation tensor of the poles
    (textbook 4.2, fig. 31). Its confidence region follows Anderson (1963), and the cones follow
    Gray, Geiser & Geiser (1980).

    Examples
    --------
    Beds that all contain the line 090/20 are folded about it:

    >>> import vomstudio as vs
    >>> beta = vs.fold(([90, 30, 150, 10, 170], [20, 36.05, 36.05, 64.49, 64.49])).beta
    >>> round(beta.trend_deg, 1), round(beta.plunge_deg, 1)
    (90.0, 20.0)
    """
    rows = to_orientation_table(table, azimuth)
    options = options_from_arguments(
        FoldOptions,
        locals(),
        sets=None if sets is None else ",".join(map(str, to_list(sets, "sets"))),
        by=column_name(by),
    )
    with name_arguments_in_errors(FoldOptions):
        result = table_fold(rows, options)
    warn(result.warnings[len(rows.warnings) :])
    return result


def slope(
    table: OrientationsArgument,
    face: str | tuple[float, float],
    *,
    friction_deg: float,
    lateral_deg: float = 20.0,
    limits: Literal["curved", "straight"] = "curved",
    azimuth: Azimuth | None = None,
) -> TableSlope:
    """Analyse the kinematic stability of a rock slope cut by planes.

    Parameters
    ----------
    table : DataFrame, path, or (dip direction, dip)
        See `stats`; lines in the table are omitted.
    azimuth : {"strike", "dipdir"}, optional
        See `stats`.
    face : str or (float, float)
        Dip direction and dip of the slope, degrees: ``(135, 70)`` or ``"135/70"``.
    friction_deg : float
        Friction angle of the planes, degrees.
    lateral_deg : float, optional
        Maximum lateral angle of planes, and of the intersections of direct toppling, from the
        dip direction of the slope or its opposite, degrees; 90 means no limit. Wedges are not
        limited.
    limits : {"curved", "straight"}, optional
        Lateral limits of planes: "curved" (small circles about the strike of the slope) or
        "straight" (limits of the dip direction). For direct toppling, the trend is limited.

    Returns
    -------
    TableSlope
        ``planar``, ``wedge``, ``flexural_toppling`` and ``direct_toppling``, each with
        ``critical``, ``of`` (number of planes or, for wedges and direct toppling, of the
        intersections of all pairs), ``share`` = critical / of (None if ``of`` is 0),
        ``probability`` (expected share with the error of each plane from the orientation
        table, simulated with a fixed seed; None if the planes have no errors) and
        ``secondary``; ``ids`` of the critical planes, and ``direct_toppling.bases``, planes
        on which blocks can topple.

    Raises
    ------
    vs.errors.UsageError
        If the face is horizontal or an angle is invalid.
    vs.errors.GeometryError
        If the table contains no planes.
    vs.errors.InputError
        Under the conditions of `stats`.

    Notes
    -----
    Planar sliding and wedges follow Markland (Wyllie & Mah 2004), flexural toppling follows
    Goodman (1980), and direct toppling follows Hudson & Harrison (1997).

    Examples
    --------
    A plane that daylights in the slope and is steeper than the friction angle slides. It forms a
    wedge with a second plane that strikes across the slope:

    >>> import vomstudio as vs
    >>> result = vs.slope(([100, 170], [45, 70]), (100, 70), friction_deg=30)
    >>> result.planar.critical, result.planar.of, result.wedge.critical, result.wedge.of
    (1, 2, 1, 1)
    """
    options = options_from_arguments(SlopeOptions, locals())
    with name_argument_in_errors("face", "--face"):
        slope = slope_face(to_plane(face, "face"), options)
    rows = to_orientation_table(table, azimuth)
    result = table_slope(rows, slope)
    warn(result.warnings[len(rows.warnings) :])
    return result


def repeats(
    table: OrientationsArgument,
    *,
    by: str | None = None,
    interpreter: str | None = None,
    azimuth: Azimuth | None = None,
) -> TableRepeats:
    """Compare the repeatability of picks with their stated errors.

    Parameters
    ----------
    table : DataFrame, path, or (dip direction, dip)
        See `stats`; may also be the folder of a project. Planes are compared with planes,
        and lines with lines.
    azimuth : {"strike", "dipdir"}, optional
        See `stats`.
    by : str, optional
        Column that groups picks of the same structure; by default ``repeat_of``, the id of
        the repeated pick.
    interpreter : str, optional
        Column that names the interpreter; by default ``interpreter``, if present.

    Returns
    -------
    TableRepeats
        ``n``, ``structures`` and ``repeats``; ``spread`` (``sigma_deg`` of one pick along
        one axis, ``error95_deg``, half-angle that contains 95 % of picks, each with its 95
        % interval), ``stated95_deg`` of the same picks; ``test`` (``chi_square``, ``p``,
        the ``factor`` by which the stated errors would have to be multiplied, ``within95``
        of ``n``), ``stated_errors_hold`` (yes, no or undetermined) with ``reasons``;
        ``interpreters`` and ``between`` (the F test of whether they differ); ``pairs`` and
        ``left_out``. Undefined values are returned as None.

    Raises
    ------
    vs.errors.UsageError
        If a column is missing.
    vs.errors.InputError
        Under the conditions of `stats`.

    Notes
    -----
    Picks with an error of sigma along each axis differ from their repeats by sqrt(2) sigma
    (Dahlberg 1940). The intervals follow from the chi-square distribution. Errors of the model
    and its registration are common to both picks and are therefore not detected.

    Examples
    --------
    >>> import pandas
    >>> import vomstudio as vs
    >>> picks = pandas.DataFrame({"dip_direction": [90, 90, 200, 200], "dip": [40, 43, 60, 58],
    ...                           "bed": ["A", "A", "B", "B"]})
    >>> result = vs.repeats(picks, by="bed")
    >>> result.repeats, round(result.spread.sigma_deg, 2), result.stated_errors_hold
    (2, 1.27, 'undetermined')
    """
    rows = to_orientation_table(table, azimuth, repeats=True)
    options = options_from_arguments(
        RepeatOptions, by=column_name(by), interpreter=optional_text(interpreter, "interpreter")
    )
    return table_repeats(rows, options.by, options.interpreter)


def slip(table: TableArgument, *, azimuth: Azimuth | None = None) -> TableSlip:
    """Compute the P and T axes of faults with known slip, and their common strain axes.

    Parameters
    ----------
    table : DataFrame or path
        DataFrame, or the path of a file, with strike (right-hand rule) or dip direction and
        dip of the faults, trend and plunge or rake of the striae, and the sense of slip; or
        the columns of this program's lines on planes; or those of FaultKin, Win-Tensor,
        T-TECTO or OpenStereo.
    azimuth : {"strike", "dipdir"}, optional
        Meaning of a column named ``fault_azimuth`` or ``fazi``, or of the first column if there
        is no header.

    Returns
    -------
    TableSlip
        ``n``; ``kinematic_axes`` with ``shortening``, ``intermediate`` and ``extension``
        (each ``trend_deg``, ``plunge_deg``, ``value`` from -1 to 1, ``confidence95_deg`` by
        resampling); ``right_dihedra`` with ``compression`` and ``extension`` (each
        ``trend_deg``, ``plunge_deg``, ``share`` of the faults that allow it); ``faults``,
        each with ``P``, ``T`` and ``slip``; ``dropped_lines``, ``warnings``.

    Raises
    ------
    vs.errors.InputError
        If the table does not have these columns, an angle is invalid, or a sense of slip is
        unknown.

    Notes
    -----
    Kinematic axes follow Marrett & Allmendinger (1990), and right dihedra follow Angelier &
    Mechler (1977).

    Examples
    --------
    A normal fault that dips 45 degrees shortens the rock vertically and extends it across strike:

    >>> import pandas
    >>> import vomstudio as vs
    >>> fault = {"strike": [0], "dip": [45], "rake": [90], "sense": ["N"]}
    >>> axes = vs.slip(pandas.DataFrame(fault)).kinematic_axes
    >>> round(axes.shortening.plunge_deg), round(axes.extension.trend_deg)
    (90, 90)
    """
    azimuth = check_azimuth(azimuth)
    rows = (
        read_slips(to_path(table, "table"), azimuth)
        if is_path(table)
        else extract_slips(to_text_table(table), azimuth)
    )
    result = table_slip(rows)
    warn(result.warnings)
    return result
