"""A model placed by pairs of points, or by whatever else is known of its place."""

from __future__ import annotations

from collections.abc import Sequence, Sized
from pathlib import Path
from typing import Any, Literal

import numpy as np

from vomstudio.api.checking import (
    is_path,
    items_of,
    numbers,
    path_of,
    path_text,
    points,
    refuse_other_lengths,
    refuse_rows,
    requires_type,
    warn,
    words_of,
    wrong_shape,
)
from vomstudio.api.declared_options import arguments_named, options_from_arguments
from vomstudio.api.reporting import Reported, told
from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.options import given_options
from vomstudio.core.progress import CancelToken
from vomstudio.geometry.coordinate_limits import why_no_error
from vomstudio.registration.placing import register_points
from vomstudio.registration.register_options import BESIDE, RegisterOptions
from vomstudio.registration.results import Placed
from vomstudio.studio.placing.register_order import register_model


def register(
    model_points: Any,
    world_points: Any = None,
    *,
    sigma_m: Any = None,
    click_sigma_m: float | None = None,
    check: Any = None,
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
    scale_bars: str | Path | None = None,
    scale: Any = (),
    bearing: Any = (),
    level: Any = (),
    plumb: Any = (),
    reference: str | Path | None = None,
    stable: str | Path | None = None,
    north: Literal["grid", "true", "magnetic"] = "grid",
    date: str | None = None,
    declination_deg: float | None = None,
    north_sigma_deg: float | None = None,
    crs: str | None = None,
    without: Sequence[str] | str = (),
    progress: Reported = None,
    cancel: CancelToken | None = None,
) -> Placed:
    """The similarity (scale, rotation, shift; never a mirror) from a model to World by points that
    are known in both, or, of the file of a model, by whatever is known of its place.

    Parameters
    ----------
    model_points : (n, 3) in the model's own frame and unit; or the path of a model, which is
        registered by the observations below, as by the command ``register``; "-" for the placement
        alone
    world_points : (n, 3) the same points in World, metres
    sigma_m : (n, 3) one-sigma errors of ``world_points``, metres; None takes them as equal and
        estimates them from the residuals
    click_sigma_m : one-sigma error of each coordinate of ``model_points``, metres, which counts
        beside ``sigma_m``; None for half the resolution of the model of a path, and for 0 of
        arrays
    check : (n,) True for points that judge the result and take no part in it
    keep_scale : the scale of the model is right as it is: it is only turned and shifted
    robust : leave out what cannot be right beside the others, and name it
    cameras, attitudes : tables, ``geo.txt``, or a folder of photos; True for the photos beside the
        model. ``model_cameras`` : the model's own cameras; None for those beside it
    pairs, gcp, marks, horizon, orientations, scale_bars : paths of tables
    scale, bearing : rows of seven numbers: two places on the model (model frame), and the metres
        between them or the azimuth from the first to the second, degrees; an eighth is its
        one-sigma error. ``level``, ``plumb`` : rows of six: two places at one height, or one above
        the other; a seventh is the one-sigma error of the line, degrees
    reference, stable : the model to which it is fitted, and the part of that which has not moved
    north : reference of azimuths for which a table does not state it; ``date`` (YYYY-MM-DD),
        ``declination_deg``, ``north_sigma_deg`` : of compass readings
    crs : projected CRS of the registered model, "EPSG:n"
    without : labels of points, readings, photos or lines that are left out
    progress : called with (stage, steps done, all steps or None), or a Progress
    cancel : a vs.CancelToken that stops the work

    Returns
    -------
    Placed with the names of the command: ``matrix`` ((4, 4) float64, model to World), ``scale``,
    ``control`` and ``check`` (``label``, ``dx``, ``dy``, ``dz``: fitted less given, ``error_m``),
    ``rms_control_m``, ``rms_check_m``, ``rotation_error_deg`` (one sigma ``about_up``,
    ``about_east``, ``about_north``), ``rotation_error_95_deg`` (the same three and the ``weakest``
    axis), ``scale_error_95``, ``worth_adding`` (where one more point would help most), ``known``,
    ``blunders`` (points too far off to be chance), ``click_sigma_m`` (metres), ``mark_scatter_px``
    (of marks in photos), ``north_sigma_deg`` (common offset of compass readings, one sigma; None
    without any) and ``warnings``. Called with (n, 3)
    model points it gives them in World.

    Raises
    ------
    vs.errors.InputError for arrays of other shapes, or points that are no pairs;
    vs.errors.GeometryError for fewer than three control points, or control points on one line, and
    for what cannot place a model; vs.errors.UsageError where nothing is given to place it by.

    Source: Umeyama (1991), IEEE PAMI 13, 376; covariance of linear least squares; variances of
    groups by Rao's MINQUE; wrong points by deletion residuals (Cook & Weisberg 1982).

    Examples
    --------
    A model in centimetres, turned by a quarter about the vertical:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> model = np.array([[0, 0, 0], [900, 0, 0], [0, 800, 100], [300, 200, 700], [500, 600, 50]])
    >>> world = model[:, [1, 0, 2]] * [-0.01, 0.01, 0.01] + [500, 100, 20]
    >>> found = vs.register(model, world, check=[False, False, False, False, True])
    >>> round(found.scale, 6), round(found.rms_check_m, 6)
    (0.01, 0.0)

    A model of a file by the positions of its cameras would be
    ``vs.register("cliff.obj", cameras="geo.txt", crs="EPSG:32633")``.
    """
    report = told(progress, cancel)
    options = options_from_arguments(
        RegisterOptions,
        pairs=path_text(pairs, "pairs"),
        gcp=path_text(gcp, "gcp"),
        marks=path_text(marks, "marks"),
        model_cameras=path_text(model_cameras, "model_cameras"),
        cameras=_beside(cameras, "cameras"),
        attitudes=_beside(attitudes, "attitudes"),
        horizon=path_text(horizon, "horizon"),
        orientations=path_text(orientations, "orientations"),
        scale_bars=path_text(scale_bars, "scale_bars"),
        scale=_rows(scale, "scale", (7, 8)),
        bearing=_rows(bearing, "bearing", (7, 8)),
        level=_rows(level, "level", (6, 7)),
        plumb=_rows(plumb, "plumb", (6, 7)),
        reference=path_text(reference, "reference"),
        stable=path_text(stable, "stable"),
        north=north,
        date=words_of(date, "date"),
        declination_deg=declination_deg,
        north_sigma_deg=north_sigma_deg,
        click_sigma_m=click_sigma_m,
        crs=words_of(crs, "crs"),
        without=tuple(str(words_of(each, "without")) for each in items_of(without, "without")),
        robust=robust,
        keep_scale=keep_scale,
    )
    observations = given_options(options).keys() - {"click_sigma_m", "robust", "keep_scale"}
    if is_path(model_points) and (world_points is None or observations):
        arrays = {"world_points": world_points, "sigma_m": sigma_m, "check": check}
        for name, value in arrays.items():
            if value is not None:
                raise requires_type(name, "model_points", "numpy.ndarray")
        path = str(path_of(model_points, "model_points"))
        with arguments_named(RegisterOptions):
            placement = register_model(path, options, report).placed
    else:
        for name in observations:
            raise requires_type(name, "model_points", "str, pathlib.Path")
        placement = register_points(
            *_pairs(model_points, world_points, sigma_m, check),
            click_sigma_m=options.click_sigma_m,
            scale=1.0 if options.keep_scale else None,
            robust=options.robust,
        )
    warn(placement.warnings)
    return placement


def _pairs(
    model_points: Any, world_points: Any, sigma_m: Any, check: Any
) -> tuple[FloatArray, FloatArray, FloatArray | None, BoolArray | None]:
    if world_points is None:
        raise InputError(Finding("option.missing"), field="world_points")
    model, world = points(model_points, "model_points"), points(world_points, "world_points")
    refuse_other_lengths(model, world, ("model_points", "world_points"))
    sigma = None if sigma_m is None else _sigma(sigma_m, len(model))
    judges = None if check is None else _flags(check, len(model))
    return model, world, sigma, judges


def _beside(value: Any, name: str) -> str | None:
    """Return the path of a file or folder, and `BESIDE` for True. Raises InputError."""
    if isinstance(value, bool | np.bool_):
        return BESIDE if value else None
    return path_text(value, name)


def _rows(value: Any, name: str, lengths: tuple[int, ...]) -> tuple[str, ...]:
    """Return rows of numbers as the options of the command take them. Raises InputError."""
    if value is None or (isinstance(value, Sized) and len(value) == 0):
        return ()
    array = numbers(value, name) if _is_flat(value) else None
    rows = items_of(value, name) if array is None else [array]
    texts = []
    for row in rows:
        values = numbers(row, name).ravel()
        if len(values) not in lengths:
            raise InputError(
                Finding("file.number-count", count=len(values), needed=lengths), field=name
            )
        texts.append(",".join(repr(float(v)) for v in values))
    return tuple(texts)


def _is_flat(given: Any) -> bool:
    """One row, not several: of rows of different lengths NumPy makes no array."""
    try:
        return np.ndim(given) < 2
    except ValueError:
        return False


def _sigma(given: Any, n: int) -> Any:
    array = numbers(given, "sigma_m")
    if array.shape != (n, 3):
        raise wrong_shape(array, f"({n}, 3)", "sigma_m")
    bad = np.asarray(~((array > 0) & np.isfinite(array)).all(axis=1))
    refuse_rows(bad, "sigma_m", "array.not-positive")
    for value in (float(array.min()), float(array.max())) if array.size else ():
        _require_error(value, "sigma_m")
    return array


def _require_error(value: float, name: str) -> None:
    """Raise InputError for an error, one sigma, that is not plausible."""
    if (problem := why_no_error(value)) is not None:
        raise InputError(problem, field=name)


def _flags(given: Any, n: int) -> Any:
    try:
        array = np.asarray(given)
    except ValueError:  # Rows of different lengths.
        array = np.empty(0)
    if array.shape != (n,) or array.dtype != bool:
        raise InputError(Finding("array.not-flags", count=n), field="check")
    return array
