"""A model placed by pairs of points, or by whatever else is known of its place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Sized
from pathlib import Path
from typing import Any, TypedDict, Unpack

import numpy as np
import numpy.typing as npt

from vomstudio.api.checking import (
    is_path,
    items_of,
    numbers,
    one_of,
    path_of,
    points,
    refuse_rows,
    single_number,
    warn,
    words_of,
)
from vomstudio.api.reporting import Reported, told
from vomstudio.errors import InputError
from vomstudio.geometry.places import why_no_error
from vomstudio.progress import CancelToken
from vomstudio.registration.placing import register_points
from vomstudio.registration.results import Placed
from vomstudio.words import tr
from vomstudio.workspace.placing.register_order import BESIDE, RegisterOrder, register_model

Array = npt.NDArray[np.float64]


class Known(TypedDict, total=False):
    """What is known of the place of a model in a file, by the names of the command's options.

    cameras, attitudes : tables, ``geo.txt``, or a folder of photos; True for the photos where they
        are found. ``model_cameras`` : the model's own cameras, None for those beside it
    pairs, gcp, marks, horizon, orientations, scale_bars : tables
    scale, bearing : rows of seven numbers: two places on the model (model frame), and the metres
        between them or the azimuth from the first to the second, degrees; an eighth states the
        error of that, one sigma. level, plumb : rows of six: two places at one height, or one above
        the other; a seventh states the error of the line, degrees, one sigma
    reference, stable : the model that it is fitted to, and what of that has not moved
    north : "grid", "true" or "magnetic", where a table does not say; ``date`` (YYYY-MM-DD),
        ``declination_deg``, ``north_sigma_deg`` : of compass readings
    crs : the projected CRS, "EPSG:n", in which it is placed
    without : labels of points, readings, photos or lines that are left out
    progress : called with (stage, steps done, all steps or None), or a Progress
    cancel : a vs.CancelToken that stops the work
    """

    cameras: str | Path | bool | None
    attitudes: str | Path | bool | None
    pairs: str | Path | None
    gcp: str | Path | None
    marks: str | Path | None
    model_cameras: str | Path | None
    horizon: str | Path | None
    orientations: str | Path | None
    scale_bars: str | Path | None
    scale: Any
    bearing: Any
    level: Any
    plumb: Any
    reference: str | Path | None
    stable: str | Path | None
    north: str
    date: str | None
    declination_deg: float | None
    north_sigma_deg: float | None
    crs: str | None
    without: Sequence[str] | str
    progress: Reported
    cancel: CancelToken | None


def register(
    model_points: Any,
    world_points: Any = None,
    *,
    sigma_m: Any = None,
    click_sigma_m: float | None = None,
    check: Any = None,
    keep_scale: bool = False,
    robust: bool = False,
    **known: Unpack[Known],
) -> Placed:
    """The similarity (scale, rotation, shift; never a mirror) from a model to World by points that
    are known in both, or, of the file of a model, by whatever is known of its place.

    Parameters
    ----------
    model_points : (n, 3) in the model's own frame and unit; or the path of a model, which is then
        placed by what the other names give, as by the command ``register``, whose options they are
    world_points : (n, 3) the same points in World, metres
    sigma_m : (n, 3) one-sigma errors of ``world_points``, metres; None takes them as equal and
        estimates them from the residuals
    click_sigma_m : one-sigma error of each coordinate of ``model_points``, metres, which counts
        beside ``sigma_m``; None for half the resolution of the model of a path, and for 0 of
        arrays
    check : (n,) True for points that judge the result and take no part in it
    keep_scale : the scale of the model is right as it is: it is only turned and shifted
    robust : leave out what cannot be right beside the others, and name it
    known : of the path of a model, see ``Known``

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
    for name, value in (("keep_scale", keep_scale), ("robust", robust)):
        if not isinstance(value, bool | np.bool_):
            raise InputError(tr("True or False is needed."), field=name)
    click_m = single_number(click_sigma_m, "click_sigma_m")
    if click_m:
        _require_error(click_m, "click_sigma_m")
    if is_path(model_points) and (world_points is None or known):
        _refuse(
            {"world_points": world_points, "sigma_m": sigma_m, "check": check},
            tr("Arrays of points belong to an array of model points. Give a table: pairs."),
        )
        path = path_of(model_points, "model_points")
        found = _by_file(path, known, click_m, keep_scale=bool(keep_scale), robust=bool(robust))
    else:
        _refuse(known, tr("This belongs to the path of a model. Give that in place of points."))
        pairs = _pairs(model_points, world_points, sigma_m, check)
        scale = 1.0 if keep_scale else None
        found = register_points(*pairs, click_sigma_m=click_m, scale=scale, robust=bool(robust))
    warn(found.warnings)
    return found


def _pairs(
    model_points: Any, world_points: Any, sigma_m: Any, check: Any
) -> tuple[Array, Array, Array | None, npt.NDArray[np.bool_] | None]:
    if world_points is None:
        raise InputError(tr("Give the same points in World."), field="world_points")
    model, world = points(model_points, "model_points"), points(world_points, "world_points")
    if len(model) != len(world):
        raise InputError(
            tr(
                "{count} points of the model and {world} of World do not form pairs.",
                count=len(model),
                world=len(world),
            ),
            field="world_points",
        )
    sigma = None if sigma_m is None else _sigma(sigma_m, len(model))
    judges = None if check is None else _flags(check, len(model))
    return model, world, sigma, judges


_BESIDE = ("cameras", "attitudes")
_FILES = (
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
_TEXTS = ("date", "crs")
_LINES = {"scale": (7, 8), "bearing": (7, 8), "level": (6, 7), "plumb": (6, 7)}
"""Numbers of a row, without and with its error."""


def _by_file(
    model: Path, known: Known, click_m: float | None, *, keep_scale: bool, robust: bool
) -> Placed:
    given: dict[str, Any] = dict(known)
    progress = told(given.pop("progress", None), given.pop("cancel", None))
    north = given.pop("north", "grid")
    one_of(north, ("grid", "true", "magnetic"), "north")
    angles = [single_number(given.pop(f"{name}_deg", None), f"{name}_deg")
              for name in ("declination", "north_sigma")]  # fmt: skip
    lines = {name: _rows(given.pop(name, ()), name, lengths) for name, lengths in _LINES.items()}
    labels = [words_of(each, "without") for each in items_of(given.pop("without", ()), "without")]
    texts = {name: _beside(given.pop(name, None), name) for name in _BESIDE}
    texts |= {name: _file(given.pop(name, None), name) for name in _FILES}
    texts |= {name: words_of(given.pop(name, None), name) for name in _TEXTS}
    for name in given:
        raise InputError(tr("Nothing of this name is known."), field=name)
    declination, north_sigma = (None if angle is None else str(angle) for angle in angles)
    values: dict[str, Any] = {**texts, **lines, "declination": declination, "without": labels}
    values |= {"keep_scale": keep_scale, "robust": robust}
    values["click_sigma"] = None if click_m is None else repr(click_m)
    order = RegisterOrder(str(model), north=north, north_sigma=north_sigma, **values)
    return register_model(order, progress).placed


def _refuse(given: Mapping[str, Any], message: str) -> None:
    for name, value in given.items():
        if value is not None:
            raise InputError(message, field=name)


def _beside(value: Any, name: str) -> str | None:
    """A file or folder, or True for what lies beside. Raises InputError."""
    if isinstance(value, bool | np.bool_):
        return BESIDE if value else None
    return _file(value, name)


def _file(value: Any, name: str) -> str | None:
    return None if value is None else str(path_of(value, name))


def _rows(given: Any, name: str, lengths: tuple[int, ...]) -> list[str]:
    """Rows of numbers as the options of the command take them."""
    if given is None or (isinstance(given, Sized) and len(given) == 0):
        return []
    array = numbers(given, name) if _is_flat(given) else None
    rows = items_of(given, name) if array is None else [array]
    found = []
    for row in rows:
        values = numbers(row, name).ravel()
        if len(values) not in lengths:
            raise InputError(
                tr(
                    "Rows of {wanted} numbers are needed, and one has {count}.",
                    wanted=" or ".join(map(str, lengths)),
                    count=len(values),
                ),
                field=name,
            )
        found.append(",".join(repr(float(v)) for v in values))
    return found


def _is_flat(given: Any) -> bool:
    """One row, not several: of rows of different lengths NumPy makes no array."""
    try:
        return np.ndim(given) < 2
    except ValueError:
        return False


def _sigma(given: Any, n: int) -> Any:
    array = numbers(given, "sigma_m")
    if array.shape != (n, 3):
        raise InputError(
            tr(
                "One standard error per coordinate is needed, as an array ({count}, 3). This "
                "one has the shape {shape}.",
                count=n,
                shape=array.shape,
            ),
            field="sigma_m",
        )
    bad = np.asarray(~((array > 0) & np.isfinite(array)).all(axis=1))
    refuse_rows(bad, "no positive errors", "sigma_m")
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
        raise InputError(
            tr("True or False for each of the {n} points is needed, an array ({n},) of bool.", n=n),
            field="check",
        )
    return array
