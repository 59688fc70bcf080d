"""Given positions of cameras in the coordinate reference system of a model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError, InputError, UsageError
from vomstudio.geometry.places import why_not_on_earth
from vomstudio.io.control.observation_tables import Positions
from vomstudio.registration.similarity import fit_robustly
from vomstudio.words import tr

Array = npt.NDArray[np.float64]
ToGrid = Callable[[float, float], tuple[float, float] | None]

_FOOT_M = 0.3048
# Another reading of the numbers is proposed where it fits so much better, and these do not fit.
_BETTER = 0.3
_FITS = 0.01
_FEWEST = 5


def in_metres(
    positions: Positions, crs: str | None, said: list[str]
) -> tuple[Positions, str | None, tuple[float, float] | None]:
    """The positions in metres, the CRS of the model, and a longitude and latitude among them where
    they are known. Those without a height are left out, and those whose height is above something
    else than that of most.

    crs : "EPSG:n" or WKT of the model, None to take that of the file
    said : gets what was assumed of them
    Raises InputError or UsageError.
    """
    positions, crs, to_grid = _source(positions, crs)
    positions = _with_heights(positions, said)
    if to_grid is None:
        return positions, crs, None
    places = positions.places.copy()
    degrees = _as_degrees(positions, to_grid[1])
    _refuse_exchanged(positions, degrees, crs)
    for row, (longitude, latitude) in enumerate(degrees.tolist()):
        there = to_grid[0](longitude, latitude)
        if there is None:
            raise InputError(
                tr(
                    "{photo} is outside of what the coordinate reference system covers.",
                    photo=positions.photos[row],
                ),
                file=positions.file,
            )
        places[row, :2] = there
    middle = np.median(degrees, axis=0)
    said.append(_said_of_heights(positions, float(middle[0]), float(middle[1])))
    moved = replace(positions, places=places, degrees=False, crs=crs)
    return moved, crs, (float(middle[0]), float(middle[1]))


def _source(
    positions: Positions, crs: str | None
) -> tuple[Positions, str | None, tuple[ToGrid, ToGrid | None] | None]:
    """With what turns longitude and latitude into the CRS of the model, and what turns the file's
    x and y into longitude and latitude (None: they are that)."""
    from pyproj import CRS, Transformer
    from pyproj.exceptions import CRSError

    from vomstudio.io.gis.crs import from_degrees, parse_crs, utm_zone

    own = None
    if positions.crs is not None:
        try:
            own = CRS.from_user_input(positions.crs)
        except CRSError as error:
            raise _unknown(positions) from error
        own = own.sub_crs_list[0] if own.is_compound else own
        if own.is_geographic:
            positions = replace(positions, degrees=True)
        elif crs is None:
            code, unit = parse_crs(own.to_wkt())
            if unit != 1.0:
                raise InputError(
                    tr(
                        "{crs} is not in metres. Say with --crs in which coordinate reference "
                        "system in metres the model is placed.",
                        crs=own.name,
                    ),
                    file=positions.file,
                    line=positions.line,
                )
            crs = code
    if positions.degrees:
        if crs is None:
            first = positions.places[0]
            zone = ""
            if why_not_on_earth(float(first[0]), float(first[1])) is None:
                zone = utm_zone(float(first[0]), float(first[1]))
            raise UsageError(
                tr(
                    "The positions are in degrees. Say with --crs into which projected coordinate "
                    "reference system the model is placed, such as {zone}.",
                    zone=zone or "EPSG:32633",
                ),
                field="--crs",
            )
        base = "EPSG:4326" if own is None else own.to_wkt()
        return positions, crs, (from_degrees(crs, base), None)
    if own is None or crs is None:
        return positions, crs, None
    to_degrees = Transformer.from_crs(own, "EPSG:4326", always_xy=True)

    def back(x: float, y: float) -> tuple[float, float] | None:
        longitude, latitude = to_degrees.transform(x, y)[:2]
        good = np.isfinite([longitude, latitude]).all()
        return (float(longitude), float(latitude)) if good else None

    return positions, crs, (from_degrees(crs), back)


def _unknown(positions: Positions) -> InputError:
    return InputError(
        tr(
            "The projection '{text}' is unknown. Write a code such as EPSG:32633.",
            text=(positions.crs or "")[:60],
        ),
        file=positions.file,
        line=positions.line,
    )


def _as_degrees(positions: Positions, back: ToGrid | None) -> Array:
    """(n, 2) longitude and latitude. Raises InputError for those that are none."""
    found = positions.places[:, :2].copy()
    for row, (x, y) in enumerate(positions.places[:, :2].tolist()):
        there = (x, y) if back is None else back(x, y)
        why = tr("it is outside of the system") if there is None else why_not_on_earth(*there)
        if there is None or why is not None:
            exchanged = back is None and why_not_on_earth(y, x) is None
            raise InputError(
                tr(
                    "{photo}: longitude {x:g} and latitude {y:g} look exchanged. Exchange the "
                    "columns.",
                    photo=positions.photos[row],
                    x=x,
                    y=y,
                )
                if exchanged
                else f"{positions.photos[row]}: {why}",
                file=positions.file,
            )
        found[row] = there
    return found


def _refuse_exchanged(positions: Positions, degrees: Array, crs: str | None) -> None:
    """Raises InputError where longitude and latitude lie outside the area of the CRS, and would lie
    within it if they were exchanged."""
    from pyproj import CRS

    area = CRS.from_user_input(crs).area_of_use if crs is not None else None
    if area is None:
        return
    west, south, east, north = area.bounds

    def inside(longitude: Array, latitude: Array) -> bool:
        around = (longitude - west) % 360.0 <= (east - west) % 360.0
        return bool((around & (latitude >= south) & (latitude <= north)).mean() > 0.5)

    if not inside(*degrees.T) and inside(degrees[:, 1], degrees[:, 0]):
        raise InputError(
            tr(
                "The positions ({x:.4f}, {y:.4f}, …) lie outside the area of the coordinate "
                "reference system, and within it with longitude and latitude exchanged. Exchange "
                "the columns.",
                x=float(degrees[0, 0]),
                y=float(degrees[0, 1]),
            ),
            file=positions.file,
        )


# --- heights ----------------------------------------------------------------------------------
def _with_heights(positions: Positions, said: list[str]) -> Positions:
    keep = np.isfinite(positions.places[:, 2])
    if not keep.any():
        raise InputError(
            tr("None of the camera positions has a height, without which they level nothing."),
            file=positions.file,
        )
    if not keep.all():
        said.append(
            tr(
                "{count} camera positions without a height were left out: {names}.",
                count=int((~keep).sum()),
                names=_some(positions.photos, ~keep),
            )
        )
    above = np.array([_above(word) for word in positions.heights])
    if len(above):
        usual = Counter(above[keep].tolist()).most_common(1)[0][0]
        other = keep & (above != usual)
        if other.any():
            said.append(
                tr(
                    "{count} photos give their height above something else than the others "
                    "({usual}) and were left out, since the two differ by up to 100 m: {names}.",
                    count=int(other.sum()),
                    usual=_called(usual),
                    names=_some(positions.photos, other),
                )
            )
            keep &= ~other
    if keep.all():
        return positions
    rows = np.flatnonzero(keep)
    return replace(
        positions,
        photos=tuple(positions.photos[i] for i in rows),
        places=positions.places[rows],
        sigma=positions.sigma[rows],
        heights=tuple(positions.heights[i] for i in rows) if positions.heights else (),
    )


def _above(word: str) -> str:
    return "sea level" if word == "below sea level" else word


def _called(word: str) -> str:
    return {
        "ellipsoid": tr("above the ellipsoid"),
        "sea level": tr("above the sea"),
    }.get(word, tr("not stated above what"))


def _some(photos: Sequence[str], which: npt.NDArray[np.bool_]) -> str:
    return ", ".join(np.array(photos)[which][:8])


def _said_of_heights(positions: Positions, longitude: float, latitude: float) -> str:
    """What the heights are above, and what was assumed."""
    from vomstudio.io.gis.heights import geoid_height_m

    geoid = geoid_height_m(longitude, latitude)
    words = _above(positions.heights[0]) if positions.heights else ""
    if geoid is None:
        between = tr(
            "no geoid model is installed by which the difference, up to 100 m, could be told: "
            "check one height against a map"
        )
    else:
        between = tr("the sea is {height:+.1f} m from the ellipsoid here", height=geoid)
    if words == "ellipsoid":
        return tr(
            "The heights of the cameras are above the ellipsoid, as the photos say, and were taken "
            "so, not converted to heights above the sea; {between}.",
            between=between,
        )
    if words == "sea level":
        return tr(
            "The heights of the cameras were taken as above the sea, as the photos say; many "
            "receivers write that of heights above the ellipsoid; {between}.",
            between=between,
        )
    return tr(
        "The heights of the cameras were taken as they are written, above the ellipsoid or the "
        "sea; {between}.",
        between=between,
    )


# --- what the numbers look like ---------------------------------------------------------------
def doubts_about(model: Array, world: Array) -> list[str]:
    """What given positions (n, 3) look like that do not fit the cameras of the model (n, 3), where
    they fit if they are read in another way."""
    if len(model) < _FEWEST:
        return []
    given = _miss(model, world)
    if given is None or given < _FITS:
        return []
    found: list[tuple[float, str]] = []
    for changed, said in (
        (
            world[:, [1, 0, 2]],
            tr("x and y of the camera positions look exchanged. Exchange the columns."),
        ),
        (
            world * [1.0, 1.0, _FOOT_M],
            tr(
                "The heights of the camera positions look like feet beside x and y in metres. "
                "Multiply them by 0.3048."
            ),
        ),
        (
            world * [_FOOT_M, _FOOT_M, 1.0],
            tr(
                "x and y of the camera positions look like feet beside heights in metres. "
                "Multiply them by 0.3048."
            ),
        ),
        (
            world * [1.0, 1.0, -1.0],
            tr("The heights of the camera positions look like depths. Change their sign."),
        ),
    ):
        miss = _miss(model, changed)
        if miss is not None and miss < _BETTER * given:
            found.append((miss, said))
    return [min(found)[1]] if found else []


def _miss(model: Array, world: Array) -> float | None:
    """The median miss of a similarity, as a share of how far the points reach."""
    local = world - world.mean(axis=0)
    try:
        fit, _ = fit_robustly(model, local)
    except GeometryError:
        return None
    size = float(np.sqrt((local**2).sum(axis=1).mean()))
    return float(np.median(np.linalg.norm(fit(model) - local, axis=1))) / max(size, 1e-300)
