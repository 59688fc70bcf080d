"""Registration of a model by points or other observations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Sized
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np

from vomstudio.api.checking import (
    is_path,
    numbers,
    optional_text,
    path_text,
    require_equal_lengths,
    require_valid_rows,
    requires_type_error,
    to_list,
    to_path,
    warn,
    wrong_shape_error,
)
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.point_arguments import points
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.options import given_options
from vomstudio.core.progress import CancelToken
from vomstudio.geometry.coordinate_limits import check_error
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.registration.placing import register_points
from vomstudio.registration.register_options import BESIDE, Observations, RegisterOptions
from vomstudio.registration.results import ModelPlacement
from vomstudio.studio.placing.register_order import register_model

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vomstudio.api.argument_types import PointsArgument, VerticesArgument


def register(
    model_points: PointsArgument,
    world_points: VerticesArgument | None = None,
    *,
    sigma_m: ArrayLike | None = None,
    click_sigma_m: float | None = None,
    check: ArrayLike | None = None,
    keep_scale: bool = False,
    robust: bool = False,
    pairs: str | Path | None = None,
    gcp: str | Path | None = None,
    marks: str | Path | None = None,
    model_cameras: str | Path | None = None,
    cameras: str | Path | bool | None = None,
    attitudes: str | Path | bool | None = None,
    horizon: str | Path | None = None,
    orientations: str | Path | None = None,
    azimuth: Literal["strike", "dipdir"] | None = None,
    scale_bars: str | Path | None = None,
    scale: ArrayLike = (),
    bearing: ArrayLike = (),
    level: ArrayLike = (),
    plumb: ArrayLike = (),
    reference: str | Path | None = None,
    stable: str | Path | None = None,
    north: Literal["grid", "true", "magnetic"] = "grid",
    date: str | None = None,
    declination_deg: float | None = None,
    north_sigma_deg: float | None = None,
    crs: str | None = None,
    to_crs: str | None = None,
    up: Literal["y", "z"] | None = None,
    unit: str | None = None,
    without: Sequence[str] | str = (),
    progress: ProgressArgument = None,
    cancel: CancelToken | None = None,
) -> ModelPlacement:
    """Register a model to the World frame by points or other observations.

    The registration is a similarity (scale, rotation and translation, without reflection).

    Parameters
    ----------
    model_points : (n, 3) array or path
        Points in the frame and unit of the model; or the path of a model, which is
        registered by the observations below in the same way as by the command ``register``;
        "-" returns only the placement.
    world_points : (n, 3) array, optional
        The same points in the World frame, metres.
    sigma_m : (n, 3) array, optional
        One-sigma errors of ``world_points``, metres; by default equal errors,
        estimated from the residuals.
    click_sigma_m : float, optional
        One-sigma error of each coordinate of ``model_points``, metres, in addition to
        ``sigma_m``; by default half the resolution of a model file, 0 for arrays.
    check : (n,) bool, optional
        Mask of the check points, which do not affect the result.
    keep_scale : bool, optional
        Whether the scale of the model is fixed, so that only the rotation and the
        translation are estimated.
    robust : bool, optional
        Whether to exclude and report outliers.
    cameras, attitudes : str or Path or bool, optional
        Tables, ``geo.txt``, or a folder of photos; True selects the photos next to the
        model.
    model_cameras : str or Path, optional
        File of the cameras of the model; by default the file next to the model.
    pairs, gcp, marks, horizon, orientations, scale_bars : str or Path, optional
        Paths of tables.
    azimuth : {"strike", "dipdir"}, optional
        Meaning of a column named ``azimuth`` in the table of orientations.
    scale, bearing : rows of numbers, optional
        Rows of seven numbers: two points on the model (model frame), and the distance between
        them in metres or the azimuth from the first to the second in degrees. An optional
        eighth number is the one-sigma error.
    level, plumb : rows of numbers, optional
        Rows of six numbers: two points at the same height, or one vertically above the
        other. An optional seventh number is the one-sigma error of the line, degrees.
    reference, stable : str or Path, optional
        Reference model to which the model is fitted, and the stable part of the reference.
    north : {"grid", "true", "magnetic"}, optional
        North reference of azimuths for which the table does not state it.
    date : str, optional
        Day (YYYY-MM-DD) or year of the compass readings, for the magnetic declination.
    declination_deg : float, optional
        Magnetic declination, degrees east of true north; overrides the value for ``date``.
    north_sigma_deg : float, optional
        One-sigma error common to all compass readings, degrees.
    crs : str, optional
        Projected CRS of the registered model, "EPSG:n".
    to_crs : str, optional
        Projected CRS to which the observed positions are converted; ``crs`` is then their own.
    up, unit : str, optional
        Axis of the model's file that points up, and its unit, which fixes the scale.
    without : sequence of str or str, optional
        Labels of excluded points, readings, photos or lines.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).
    cancel : vs.CancelToken, optional
        Token that stops the computation.

    Returns
    -------
    ModelPlacement
        ``matrix`` ((4, 4) float64, model to World), ``scale``, ``control`` and ``check``
        (``label``, ``dx``, ``dy``, ``dz``: fitted less given, ``error_m``),
        ``rms_control_m``, ``rms_check_m``, ``rotation_error_deg`` (one sigma ``about_up``,
        ``about_east``, ``about_north``), ``rotation_error_95_deg`` (the same three and the
        ``weakest`` axis), ``scale_error_95``, ``worth_adding`` (where an additional point
        would help most), ``known`` (determined
        parameters), ``blunders`` (outliers), ``click_sigma_m`` (metres),
        ``mark_scatter_px`` (of marks in photos), ``north_sigma_deg`` (common offset of
        compass readings, one sigma; None if unused) and ``warnings``. Called with (n, 3)
        model points, the result returns them in the World frame.

    Raises
    ------
    vs.errors.InputError
        If the arrays have other shapes, or points are not paired.
    vs.errors.GeometryError
        If there are fewer than three control points, the control points are collinear, or
        the observations do not determine the placement.
    vs.errors.UsageError
        If no observations are given.

    Notes
    -----
    The similarity follows Umeyama (1991), IEEE PAMI 13, 376, with the covariance of linear least
    squares. The variances of groups are estimated by Rao's MINQUE, and wrong points are detected
    by deletion residuals (Cook & Weisberg 1982).

    Examples
    --------
    A model in centimetres, rotated by a quarter turn about the vertical:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> model = np.array([[0, 0, 0], [900, 0, 0], [0, 800, 100], [300, 200, 700], [500, 600, 50]])
    >>> world = model[:, [1, 0, 2]] * [-0.01, 0.01, 0.01] + [500, 100, 20]
    >>> placement = vs.register(model, world, check=[False, False, False, False, True])
    >>> round(placement.scale, 6), round(placement.rms_check_m, 6)
    (0.01, 0.0)

    A model file is registered by the positions of its cameras with
    ``vs.register("cliff.obj", cameras="geo.txt", crs="EPSG:32633")``.
    """
    report = to_progress(progress, cancel)
    options = observations_from_arguments(RegisterOptions, locals())
    observations = given_options(options).keys() - {"click_sigma_m", "robust", "keep_scale"}
    if is_path(model_points) and (world_points is None or observations):
        arrays = {"world_points": world_points, "sigma_m": sigma_m, "check": check}
        for name, value in arrays.items():
            if value is not None:
                raise requires_type_error(name, "model_points", "numpy.ndarray")
        path = str(to_path(model_points, "model_points"))
        with name_arguments_in_errors(RegisterOptions):
            placement = register_model(path, options, report).placed
    else:
        for name in observations:
            raise requires_type_error(name, "model_points", "str, pathlib.Path")
        placement = register_points(
            *_pairs(model_points, world_points, sigma_m, check),
            click_sigma_m=options.click_sigma_m,
            scale=1.0 if options.keep_scale else None,
            is_robust=options.robust,
        )
    warn(placement.warnings)
    return placement


_PATH_ARGUMENTS = (
    "pairs",
    "gcp",
    "marks",
    "model_cameras",
    "horizon",
    "orientations",
    "scale_bars",
    "reference",
    "stable",
)
_PATH_OR_FLAG_ARGUMENTS = ("cameras", "attitudes")
_TEXT_ARGUMENTS = ("date", "crs", "to_crs")
_ROW_LENGTHS = {"scale": (7, 8), "bearing": (7, 8), "level": (6, 7), "plumb": (6, 7)}

ObservationsType = TypeVar("ObservationsType", bound=Observations)


def observations_from_arguments(
    options: type[ObservationsType], arguments: Mapping[str, Any], **converted: Any
) -> ObservationsType:
    """Create the options of a registration from the arguments of a call.

    Parameters
    ----------
    options : type
    arguments : mapping of str to object
        Arguments of the calling function (its ``locals()``).
    **converted
        Values that replace arguments.

    Raises
    ------
    InputError, UsageError
        If a value is not allowed; the error names the argument.
    """
    option_values: dict[str, object] = {
        name: path_text(arguments[name], name) for name in _PATH_ARGUMENTS
    }
    option_values |= {
        name: _path_or_flag(arguments[name], name) for name in _PATH_OR_FLAG_ARGUMENTS
    }
    option_values |= {name: optional_text(arguments[name], name) for name in _TEXT_ARGUMENTS}
    option_values |= {
        n: _to_row_texts(arguments[n], n, lengths) for n, lengths in _ROW_LENGTHS.items()
    }
    labels = to_list(arguments["without"], "without")
    option_values["without"] = tuple(str(optional_text(label, "without")) for label in labels)
    return options_from_arguments(options, arguments, **option_values, **converted)


def pairs_from_arguments(model_points: Any, world_points: Any, sigma_m: Any, check: Any) -> Pairs:
    """Create the pairs of a registration from arrays, with numbers as labels.

    Raises
    ------
    InputError
        If an array has another shape.
    """
    model, world, sigma, is_check = _pairs(model_points, world_points, sigma_m, check)
    count = len(model)
    return Pairs(
        tuple(str(number) for number in range(1, count + 1)),
        model,
        world,
        np.full((count, 3), np.nan) if sigma is None else sigma,
        np.zeros(count, bool) if is_check is None else is_check,
    )


def _pairs(
    model_points: Any, world_points: Any, sigma_m: Any, check: Any
) -> tuple[FloatArray, FloatArray, FloatArray | None, BoolArray | None]:
    for name, value in (("model_points", model_points), ("world_points", world_points)):
        if value is None:
            raise InputError(Finding("option.missing"), field=name)
    model, world = points(model_points, "model_points"), points(world_points, "world_points")
    require_equal_lengths(model, world, ("model_points", "world_points"))
    sigma = None if sigma_m is None else _to_sigma(sigma_m, len(model))
    is_check = None if check is None else _to_mask(check, len(model))
    return model, world, sigma, is_check


def _path_or_flag(value: Any, name: str) -> str | None:
    """Return the path of a file or folder, `BESIDE` for True, or None. Raises InputError."""
    if isinstance(value, bool | np.bool_):
        return BESIDE if value else None
    return path_text(value, name)


def _to_row_texts(value: Any, name: str, lengths: tuple[int, ...]) -> tuple[str, ...]:
    """Format rows of numbers for the options of the command. Raises InputError if invalid."""
    if value is None or (isinstance(value, Sized) and len(value) == 0):
        return ()
    array = numbers(value, name) if _is_single_row(value) else None
    rows = to_list(value, name) if array is None else [array]
    texts = []
    for row in rows:
        values = numbers(row, name).ravel()
        if len(values) not in lengths:
            raise InputError(
                Finding("file.number-count", count=len(values), needed=lengths), field=name
            )
        texts.append(",".join(repr(float(v)) for v in values))
    return tuple(texts)


def _is_single_row(value: Any) -> bool:
    """Return whether an input is a single row; NumPy cannot convert rows of different lengths."""
    try:
        return np.ndim(value) < 2
    except ValueError:
        return False


def _to_sigma(sigma: Any, n: int) -> Any:
    array = numbers(sigma, "sigma_m")
    if array.shape != (n, 3):
        raise wrong_shape_error(array, f"({n}, 3)", "sigma_m")
    is_invalid = np.asarray(~((array > 0) & np.isfinite(array)).all(axis=1))
    require_valid_rows(is_invalid, "sigma_m", "array.not-positive")
    for value in (float(array.min()), float(array.max())) if array.size else ():
        _require_error(value, "sigma_m")
    return array


def _require_error(value: float, name: str) -> None:
    """Raise InputError if a one-sigma error is implausible."""
    if (problem := check_error(value)) is not None:
        raise InputError(problem, field=name)


def _to_mask(flags: Any, n: int) -> Any:
    try:
        array = np.asarray(flags)
    except ValueError:  # Rows of different lengths.
        array = np.empty(0)
    if array.shape != (n,) or array.dtype != bool:
        raise InputError(Finding("array.not-flags", count=n), field="check")
    return array
