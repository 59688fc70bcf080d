"""North reference of the azimuths on a model, and their correction to grid north."""

from __future__ import annotations

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry import transform
from vomstudio.geometry.registrations import ReadNorth
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.project.records import Compass, Model
from vomstudio.registration.north import (
    North,
    default_north_sigma_deg,
    parse_day,
    place_of,
)
from vomstudio.registration.register_options import RegisterOptions

_SAME_DEG = 1e-9
AS_READ = ReadNorth("grid")
"""Where nothing was said."""


def north_of(compass: Compass, known: North) -> tuple[ReadNorth, str]:
    """Return how azimuths by a compass are turned to grid north, and a summary of that.

    Raises
    ------
    UsageError, InputError
        If the declination is not known.
    """
    correction = known.required_correction(compass.north)
    doubt = compass.doubt_deg
    doubt = default_north_sigma_deg(compass.north) if doubt is None else doubt
    return correction.read_north(doubt), correction.summary


def known_of(
    compass: Compass,
    model: Model,
    bounds: FloatArray | None,
    pairs: Pairs,
    crs: str | None,
) -> North:
    """What is known of place and day of a compass's readings on a model.

    bounds : (2, 3) of the model in its file's frame, None where they are not known; crs : of the
    points. Raises UsageError for what is no day.
    """
    own = model.frame.crs if model.frame.kind == "crs" else None
    place = compass.place
    if place is None and crs is not None and len(pairs.labels):
        place = place_of(crs, pairs.world)
    if place is None and own is not None and bounds is not None:
        place = place_of(own, transform.apply(model.to_world, bounds))
    day = parse_day(compass.day) if compass.day else None
    return North(crs or own, place, day, compass.declination_deg)


def as_the_command(
    compass: Compass | None, used: ReadNorth, pairs: Pairs, crs: str | None
) -> RegisterOptions | None:
    """Return the options of `register` that turn azimuths in the same way.

    None if it cannot, because it does not know the place of the readings: azimuths are then given
    as turned. Their common offset is always stated.
    """
    if compass is None or compass.north == "grid":
        return RegisterOptions(north_sigma_deg=used.doubt_deg or None)
    place = place_of(crs, pairs.world) if crs is not None and len(pairs.labels) else None
    day = parse_day(compass.day) if compass.day else None
    same = North(crs, place, day, compass.declination_deg).correction(compass.north)
    if same is None or abs(same.deg - used.turned_deg) > _SAME_DEG:
        return None
    declination_deg = compass.declination_deg
    return RegisterOptions(
        north=compass.north,
        declination_deg=declination_deg,
        date=(compass.day or None) if declination_deg is None else None,
        north_sigma_deg=used.doubt_deg,
    )
