"""What coordinates look like that cannot be what they are said to be: exchanged columns or labels,
degrees, feet, another zone, a model in another frame. Each finding is a sentence with a proposal;
nothing is changed."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding, Message
from vomstudio.errors import GeometryError, InputError
from vomstudio.io.gate.metric import check_metric
from vomstudio.registration.doubts.apart import (
    degrees_among_metres,
    fit_as_they_are,
    said_of_degrees_among,
    said_of_two_places,
    two_places,
    where_the_model_is,
)
from vomstudio.registration.doubts.area import BEYOND_DEG, degrees_beyond, inside_area
from vomstudio.registration.doubts.heights import said_of_no_heights, said_of_one_height
from vomstudio.registration.doubts.labels import said_of_like_labels, said_of_one_place
from vomstudio.registration.doubts.mirrors import fits_as_mirror
from vomstudio.registration.doubts.mixed import said_of_mixed
from vomstudio.registration.doubts.orders import said_of_order
from vomstudio.registration.listed_names import listed
from vomstudio.registration.observations import Points
from vomstudio.registration.similarity import fit_robustly, fit_similarity
from vomstudio.words import to_translate, tr, tr_n

Array = npt.NDArray[np.float64]

_FOOT_M = 0.3048
_UNITS = (
    (1000.0, to_translate("millimetres")),
    (100.0, to_translate("centimetres")),
    (1.0 / _FOOT_M, to_translate("feet")),
    (0.001, to_translate("kilometres")),
)
# Another reading of the numbers is proposed where it fits so much better, and these do not fit.
_BETTER = 0.3
_STEEP = 5.0
_FITS = 0.01
_FEWEST = 5
# A point so many times as far from the middle as is usual is in another place altogether.
_FAR = 30.0
# Labels of more points are not exchanged in trial.
_MOST = 60
_MUCH_BETTER = 0.1
# A scale this near to that between feet and metres, where it is known as well as that.
_SAME_SCALE = 0.005
# Numbers of a neighbouring zone are wrong by less, degrees.
_NEXT_ZONES_DEG = 15.0
_MAX_KM = 20_000.0
# A registration only refines how a file has a model in its own system.
_TURNED_DEG = 20.0
# Times the model's reach: further off nobody puts control points of it.
_OFF = 10.0


def doubts_about_points(
    control: Points,
    labels: Sequence[str],
    world: Array,
    model: Array | None = None,
    crs: str | None = None,
) -> list[Message]:
    """What the coordinates of points look like that are something else than they are taken for.

    labels, world, model : of all of them (n, 3), those that only judge among them; crs : of World
    """
    alike: list[Message] = [*said_of_like_labels(labels), *said_of_one_place(labels, world)]
    if degrees := said_of_degrees(world):
        return [*alike, *degrees]
    every = control.model if model is None else model
    if missing := said_of_no_heights(labels, every, world):
        return [*alike, *missing]
    if apart := said_of_apart(labels, every, world, crs)[0]:
        return [*alike, *apart]
    if level := said_of_one_height(control.model, control.world):
        return [*alike, *level]
    if fits_as_mirror(control.model, control.world):
        # It is said of where they are placed; of columns of a mirror image any reading may fit.
        return alike
    those = (control.labels, control.model, control.world)
    readings: Sequence[Message] = said_of_mixed(*those) or said_of_readings(
        *those[1:], mirrors=False
    )
    readings = readings or said_of_exchanged_labels(*those) or said_of_order(*those)
    return [*alike, *readings]


# --- single ones ------------------------------------------------------------------------------
def far_from_others(world: Array) -> npt.NDArray[np.bool_]:
    """(n,) which of the points (n, 3) are in another place than most are, by far."""
    if len(world) < 4:
        return np.zeros(len(world), bool)
    away = np.linalg.norm(world - np.median(world, axis=0), axis=1)
    usual = float(np.median(away))
    return np.asarray(away > _FAR * usual) if usual > 0 else np.zeros(len(world), bool)


def said_of_apart(
    labels: Sequence[str], model: Array, world: Array, crs: str | None
) -> tuple[list[Message], npt.NDArray[np.bool_]]:
    """Of points that are in another place than those that are right, and which these are (n,), as
    far as that can be told.

    model, world : (n, 3); crs : of World, whose area tells which are right
    """
    degrees = degrees_among_metres(model, world)
    if degrees.any():
        return said_of_degrees_among(labels, degrees), degrees
    far = far_from_others(world)
    if far.any() and fit_as_they_are(model, world):
        return [], far & False
    here = ~far if far.any() else two_places(model, world)
    if here is None:
        return [], far
    right = where_the_model_is(model, world, here, inside_area(world, crs))
    if right is None:
        return [*said_of_two_places(labels, world, here)], np.zeros(len(world), bool)
    return said_of_far(labels, world, ~right), ~right


def said_of_far(labels: Sequence[str], world: Array, far: npt.NDArray[np.bool_]) -> list[Message]:
    """Of points that are in another place than the others, with what may have been meant."""
    if not far.any():
        return []
    middle = np.median(world[~far], axis=0)
    reach = float(np.linalg.norm(world[~far] - middle, axis=1).max())
    near = _FAR * max(reach, 1.0)
    exchanged: list[int] = []
    lost: list[int] = []
    scaled: dict[str, list[int]] = {}
    for row in np.flatnonzero(far):
        # About the origin of a local table whatever is divided comes near.
        mapped = np.linalg.norm(middle) > near
        units = [
            unit
            for unit in _UNITS
            if mapped and np.linalg.norm(world[row] / unit[0] - middle) <= near
        ]
        if np.linalg.norm(world[row, [1, 0, 2]] - middle) <= near:
            exchanged.append(int(row))
        elif units:
            scaled.setdefault(units[0][1], []).append(int(row))
        else:
            lost.append(int(row))
    metres = {tr(unit): 1.0 / times for times, unit in _UNITS}
    findings: list[Message] = [
        other_unit(listed([labels[row] for row in rows]), tr(unit), metres[tr(unit)])
        for unit, rows in scaled.items()
    ]
    if exchanged:
        names = [labels[row] for row in exchanged]
        findings.append(Finding("control.swapped-columns", labels=names))
    if lost:
        distance = float(np.linalg.norm(world[lost] - middle, axis=1).min())
        findings.append(
            Finding(
                "control.far-away",
                labels=[labels[row] for row in lost],
                distance_m=distance,
                extent_m=reach,
            )
        )
    return findings


def said_of_exchanged_labels(labels: Sequence[str], model: Array, world: Array) -> list[Message]:
    """Of two points that fit the others if their labels are exchanged."""
    if not _FEWEST <= len(labels) <= _MOST:
        return []
    given = _rms(model, world)
    if given is None or given < _FITS * _reach(world):
        return []
    best: tuple[float, int, int] | None = None
    for i, k in combinations(range(len(labels)), 2):
        order = np.arange(len(labels))
        order[[i, k]] = k, i
        miss = _rms(model, world[order])
        if miss is not None and (best is None or miss < best[0]):
            best = miss, i, k
    if best is None or best[0] > _MUCH_BETTER * given:
        return []
    # Leaving one out explains it as well where one alone is wrong.
    for alone in best[1:]:
        rest = np.arange(len(labels)) != alone
        miss = _rms(model[rest], world[rest])
        if miss is not None and miss < 2.0 * best[0]:
            return []
    return [
        tr(
            "{first} and {second} look exchanged: the points would fit within {after:.2g} m "
            "instead of {before:.2g} m. Exchange these labels.",
            first=labels[best[1]],
            second=labels[best[2]],
            after=best[0],
            before=given,
        )
    ]


# --- all of them ------------------------------------------------------------------------------
def said_of_degrees(world: Array, *, apart_m: float = 0.0) -> list[Message]:
    """Of x and y that are degrees. apart_m : as metres they are not nearer to each other"""
    if len(world) < 3:
        return []
    reach = np.ptp(world, axis=0)
    across = float(max(reach[:2]))
    for x, y, exchanged in ((0, 1, False), (1, 0, True)):
        inside = (np.abs(world[:, x]) <= 180).all() and (np.abs(world[:, y]) <= 90).all()
        if inside and (0.0 < across < apart_m or (across < 1.0 and reach[2] > 100 * across)):
            return [
                Finding(
                    "frame.maybe-degrees",
                    span=across,
                    height=float(reach[2]),
                    latitude_first=exchanged,
                )
            ]
    return []


def said_of_readings(model: Array, world: Array, *, mirrors: bool = True) -> list[Message]:
    """What given coordinates (n, 3) look like that do not fit places of the model (n, 3), where
    they fit if they are read in another way. mirrors : whether exchanged axes are among these"""
    if len(model) < _FEWEST:
        return []
    given = _miss(model, world)
    if given is None or given < (_FITS if not _is_steep(world) else 0.1 * _FITS):
        return []
    heights, feet = tr("heights"), tr("feet")
    readings = [
        (world * [1.0, 1.0, _FOOT_M], other_unit(heights, feet, _FOOT_M)),
        (world * [_FOOT_M, _FOOT_M, 1.0], other_unit("x, y", feet, _FOOT_M)),
    ]
    readings += [
        (world * [1.0, 1.0, 1.0 / times], other_unit(heights, tr(unit), 1.0 / times))
        for times, unit in _UNITS[:2]
        if _is_steep(world)
    ]
    if mirrors:
        # One mirror image fits as another does, so that the residuals cannot tell which it is.
        readings.append((world[:, [1, 0, 2]], Finding("control.swapped-columns", labels=())))
    found = [
        (miss, said)
        for changed, said in readings
        if (miss := _miss(model, changed)) is not None and miss < _BETTER * given
    ]
    return [min(found, key=lambda each: each[0])[1]] if found else []


def other_unit(axes: str, unit: str, factor: float) -> Finding:
    """Return the finding about coordinates that seem to be in another unit.

    Parameters
    ----------
    axes : str
        Which coordinates, in words.
    unit : str
        The unit, in words.
    factor : float
        Metres per unit.
    """
    return Finding("control.other-unit", axes=axes, unit=unit, factor=factor)


def _is_steep(world: Array) -> bool:
    """Whether points (n, 3) reach up by much more than to the side. Smaller heights fit flat ground
    better anyhow, so that other units are looked for among such points alone."""
    return float(np.ptp(world[:, 2])) > _STEEP * float(np.linalg.norm(np.ptp(world[:, :2], axis=0)))


def said_of_feet(scale: float, scale_error_95: float | None) -> list[Message]:
    """Of a model that grows or shrinks as from metres to feet.

    scale : metres per unit of the model; scale_error_95 : a share of it
    """
    if scale_error_95 is None or scale_error_95 > 4 * _SAME_SCALE:
        return []
    near = max(_SAME_SCALE, scale_error_95)
    for times, unit in _UNITS:
        if abs(scale / times - 1.0) < near:
            return [
                Finding("control.scale-of-unit", scale=scale, unit=tr(unit), factor=1.0 / times)
            ]
    return []


def check_area(world: Array, crs: str | None, *, converted: bool = False) -> list[Message]:
    """Check that a projected CRS is metric where control points or cameras are.

    Parameters
    ----------
    world : (n, 3) float
        Coordinates in `crs`.
    crs : str or None
        Projected CRS in metres.
    converted : bool
        Whether they were converted from longitude and latitude, so that their unit is right.

    Returns
    -------
    list of Message
        ``frame.outside-area`` for a place outside the area of use; ``control.other-unit`` if it
        would be inside in feet or kilometres.

    Raises
    ------
    InputError
        With ``control.other-unit`` or as `vomstudio.io.gate.metric.check_metric` if the CRS is not
        metric there.
    """
    if crs is None or not len(world):
        return []
    x, y = np.median(world, axis=0)[:2].tolist()
    hint = None if converted else _unit_of_another_place(x, y, crs)
    try:
        findings = check_metric(crs, np.array([[x, y], [x, y]]), field="--crs")
    except InputError as error:
        if hint is None or error.code == "frame.swapped-axes":
            raise
        raise InputError.of_finding(hint, field="--crs") from error
    return [*([] if hint is None else [hint]), *findings]


def _unit_of_another_place(x: float, y: float, crs: str) -> Finding | None:
    """Return the unit in which a place outside the area of a CRS would lie inside it."""
    beyond = degrees_beyond(crs)
    if beyond is None or (distance_deg := beyond(x, y)[0]) <= BEYOND_DEG:
        return None
    if beyond(y, x)[0] == 0.0:
        return None
    units = (
        (1000.0, tr("kilometres"), max(abs(x), abs(y)) < _MAX_KM),
        (_FOOT_M, tr("feet"), distance_deg > _NEXT_ZONES_DEG),
    )
    for factor, unit, is_plausible in units:
        if is_plausible and beyond(x * factor, y * factor)[0] == 0.0:
            return other_unit("x, y", unit, factor)
    return None


# --- the model --------------------------------------------------------------------------------
def require_on_model(model: Array, extent: Array | None) -> None:
    """Raises GeometryError where places on the model (n, 3) are none, since the table is in another
    frame than the model: with an offset taken off, or from another file.

    extent : (m, 3) points all over the model
    """
    if extent is None or not len(extent) or not len(model):
        return
    low, high = extent.min(axis=0), extent.max(axis=0)
    reach = float(np.linalg.norm(high - low))
    off = np.maximum(np.maximum(low - model, model - high), 0.0)
    if reach > 0 and float(np.median(np.linalg.norm(off, axis=1))) > _OFF * reach:
        here, there = np.median(model, axis=0), (low + high) / 2
        raise GeometryError(
            tr(
                "The places on the model ({x:,.2f}, {y:,.2f}, {z:,.2f}, …) are far off the model, "
                "whose middle is at {mx:,.2f}, {my:,.2f}, {mz:,.2f}. They are of another frame: "
                "an offset may have been taken off. Give them as the model's file has them.",
                x=float(here[0]),
                y=float(here[1]),
                z=float(here[2]),
                mx=float(there[0]),
                my=float(there[1]),
                mz=float(there[2]),
            )
        )


def said_of_move(extent: Array, placed: Array, crs: str) -> list[Message]:
    """Of a model whose file says where it is, and that is put in quite another place, or turned.

    extent, placed : (n, 3) points of it before and after; crs : of both
    """
    from vomstudio.io.gis.crs import crs_name

    if not len(extent):
        return []
    moved = float(np.linalg.norm(placed.mean(axis=0) - extent.mean(axis=0)))
    reach = float(np.linalg.norm(np.ptp(extent, axis=0)))
    if moved <= max(_OFF * reach, 1000.0):
        turn = _turn_deg(extent, placed)
        return [] if turn <= _TURNED_DEG else [
            tr(
                "The registration turns the model by {turn:.0f}° from how its file has it in "
                "{crs}. If the file is right, columns or labels of what was given are exchanged.",
                turn=turn,
                crs=crs_name(crs),
            )
        ]  # fmt: skip
    return [
        tr(
            "The registration moves the model {km:,.1f} km away from where its file says that it "
            "is in {crs}. If the file is right, the coordinates given are of another zone or "
            "system, in another unit, or exchanged.",
            km=moved / 1000.0,
            crs=crs_name(crs),
        )
    ]


def _turn_deg(before: Array, after: Array) -> float:
    """By how much points (n, 3) are turned; 0 where they do not tell."""
    try:
        fit = fit_similarity(before - before.mean(axis=0), after - after.mean(axis=0))
    except GeometryError:
        return 0.0
    return float(np.degrees(np.arccos(np.clip((np.trace(fit.rotation) - 1.0) / 2.0, -1.0, 1.0))))


def said_of_views(forward: Array) -> list[Message]:
    """Of cameras that look up to the sky after the registration.

    forward : (n, 3) unit vectors in World, where they look
    """
    # Roofs of caves and overhangs are looked up at by some photos, seldom by nearly all.
    if len(forward) < 3 or float(np.median(forward[:, 2])) < 0.7:
        return []
    return [
        tr_n(
            "{count} camera looks up to the sky after this registration, so that the model is "
            "upside down unless it is a roof: x and y may be exchanged, the points a mirror "
            "image, or lines that are called level upright.",
            "The {count} cameras look up to the sky after this registration, so that the model is "
            "upside down unless it is a roof: x and y may be exchanged, the points a mirror "
            "image, or lines that are called level upright.",
            len(forward),
        )
    ]


def said_of_noise(world: Array, placed: Array) -> list[Message]:
    """Of positions that are as wrong as they are far apart.

    world, placed : (n, 3) where they are said to be, and where the registration puts them
    """
    miss = float(np.sqrt(((placed - world) ** 2).sum(axis=1).mean())) if len(world) else 0.0
    apart = _reach(placed) if len(world) else 0.0
    if not miss > 0.5 * apart > 0:
        return []
    return [
        tr(
            "The positions of the cameras miss by {miss:.3g} m (RMS), where the cameras stand "
            "{apart:.3g} m (RMS) from their middle: they hardly tell how the model is turned. Add "
            "control points, or a compass reading and a length.",
            miss=miss,
            apart=apart,
        )
    ]


# --- in common --------------------------------------------------------------------------------
def _reach(points: Array) -> float:
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))


def _rms(model: Array, world: Array) -> float | None:
    local = world - world.mean(axis=0)
    try:
        fit = fit_similarity(model, local)
    except GeometryError:
        return None
    return float(np.sqrt(((fit(model) - local) ** 2).sum(axis=1).mean()))


def _miss(model: Array, world: Array) -> float | None:
    """The median miss of a similarity, as a share of how far the points reach."""
    local = world - world.mean(axis=0)
    try:
        fit, _ = fit_robustly(model, local)
    except GeometryError:
        return None
    miss = float(np.median(np.linalg.norm(fit(model) - local, axis=1)))
    return miss / max(_reach(local), 1e-300)
