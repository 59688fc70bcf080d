"""North reference of azimuths on a model, and their correction to grid north."""

from __future__ import annotations

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry import transform
from vomstudio.geometry.registrations import NorthReference
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.project.records import Compass, Model
from vomstudio.registration.north import (
    NorthInputs,
    centre_longitude_latitude,
    default_north_sigma_deg,
    parse_day,
)
from vomstudio.registration.register_options import RegisterOptions

TOLERANCE_DEG = 1e-9
GRID_NORTH = NorthReference("grid")
"""North reference used if none is stated."""


def resolve_north(compass: Compass, known_north: NorthInputs) -> tuple[NorthReference, str]:
    """Return the correction of compass azimuths to grid north, and its summary.

    Raises
    ------
    UsageError, InputError
        If the declination is not known.
    """
    correction = known_north.require_correction(compass.north)
    sigma_deg = compass.doubt_deg
    sigma_deg = default_north_sigma_deg(compass.north) if sigma_deg is None else sigma_deg
    return correction.read_north(sigma_deg), correction.summary


def north_inputs(
    compass: Compass,
    model: Model,
    bounds: FloatArray | None,
    pairs: Pairs,
    crs: str | None,
) -> NorthInputs:
    """Return the location and date of compass readings on a model.

    Parameters
    ----------
    compass : Compass
    model : Model
    bounds : (2, 3) float64 or None
        Bounds of the model in its file frame.
    pairs : Pairs
        Points on the model and their World coordinates.
    crs : str or None
        CRS of the points.

    Raises
    ------
    UsageError
        If the date is not valid.
    """
    file_crs = model.frame.crs if model.frame.kind == "crs" else None
    place = compass.place
    if place is None and crs is not None and len(pairs.labels):
        place = centre_longitude_latitude(crs, pairs.world)
    if place is None and file_crs is not None and bounds is not None:
        place = centre_longitude_latitude(file_crs, transform.apply(model.to_world, bounds))
    day = parse_day(compass.day) if compass.day else None
    return NorthInputs(crs or file_crs, place, day, compass.declination_deg)


def to_register_options(
    compass: Compass | None, used_north: NorthReference, pairs: Pairs, crs: str | None
) -> RegisterOptions | None:
    """Return the options of `register` with the same azimuth correction.

    Returns None if the command cannot compute the same correction. In this case, corrected azimuths
    are passed to it. Their common error is always stated.
    """
    if compass is None or compass.north == "grid":
        return RegisterOptions(north_sigma_deg=used_north.doubt_deg or None)
    place = (
        centre_longitude_latitude(crs, pairs.world)
        if crs is not None and len(pairs.labels)
        else None
    )
    day = parse_day(compass.day) if compass.day else None
    equivalent_turn = NorthInputs(crs, place, day, compass.declination_deg).correction(
        compass.north
    )
    if equivalent_turn is None or abs(equivalent_turn.deg - used_north.turned_deg) > TOLERANCE_DEG:
        return None
    declination_deg = compass.declination_deg
    return RegisterOptions(
        north=compass.north,
        declination_deg=declination_deg,
        date=(compass.day or None) if declination_deg is None else None,
        north_sigma_deg=used_north.doubt_deg,
    )
