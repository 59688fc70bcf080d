"""What azimuths that were read on a model are counted from."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.geometry.registrations import NorthKind


@dataclass(frozen=True)
class Compass:
    """One instrument reads all planes, lines and azimuths of a model: one for each model, at most.

    north: what its azimuths are counted from. day: when they were read, as 2024-05-12, "" where not
    stated. place: longitude and latitude (WGS 84, degrees) where they were read, None for that of
    the model. declination_deg: of magnetic north, east positive, as it was stated; None for that of
    a model of the Earth's field at day and place. doubt_deg: what all azimuths may be off alike,
    one sigma, None for what is usual.
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
        """Of every record there is one."""
        return "compass"


def compass_id(model_id: str) -> str:
    """Of the compass of a model."""
    return f"compass-{model_id}"
