"""North reference of the readings on a model."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.geometry.registrations import NorthKind


@dataclass(frozen=True)
class Compass:
    """Compass of a model. One instrument measures all its planes, lines and azimuths.

    Attributes
    ----------
    north : str
        North reference of its azimuths.
    day : str
        Day of the readings, as 2024-05-12, "" if not stated.
    place : tuple of float or None
        Longitude and latitude (WGS 84, degrees) of the readings; None for those of the model.
    declination_deg : float or None
        Stated declination of magnetic north, east positive; None for that of a geomagnetic field
        model.
    doubt_deg : float or None
        Common error of all azimuths, one sigma; None for the default.
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
        """Constant name, since every record has one."""
        return "compass"


def compass_id(model_id: str) -> str:
    """Return the id of the compass of a model."""
    return f"compass-{model_id}"
