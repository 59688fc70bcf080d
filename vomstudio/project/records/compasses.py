"""North reference of the readings on a model."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.geometry.registrations import NorthKind


@dataclass(frozen=True)
class Compass:
    """Compass of a model. One instrument measures all planes, lines and azimuths on the model.

    Attributes
    ----------
    north : str
        North reference of the azimuths.
    day : str
        Day of the readings, such as 2024-05-12, or "" if not stated.
    place : tuple of float or None
        Longitude and latitude (WGS 84, degrees) of the readings. If None, those of the model are
        used.
    declination_deg : float or None
        Stated declination of magnetic north, east positive. If None, a geomagnetic field model is
        used.
    doubt_deg : float or None
        Common error of all azimuths as a standard deviation. If None, the default is used.
    """

    id: str
    model_id: str
    north: NorthKind = "grid"
    day: str = ""
    place: tuple[float, float] | None = None
    declination_deg: float | None = None
    doubt_deg: float | None = None

    @property
    def name(self) -> str:
        """Constant name, required because every record has one."""
        return "compass"


def compass_id(model_id: str) -> str:
    """Return the ID of the compass of a model."""
    return f"compass-{model_id}"
