"""Compass readings on a model, with their directions and their north reference."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vomstudio.geometry.registrations import NorthReference
from vomstudio.project.compass_edits import get_compass
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.records import Compass, Model
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.registration.north import NorthInputs
    from vomstudio.studio.placing.known_planes import ModelDirection


@dataclass(frozen=True, eq=False)
class Readings:
    """Compass readings on a model.

    Attributes
    ----------
    compass : Compass or None
        North reference of the readings, or None for the default.
    directions : mapping
        Directions in model coordinates, by reading id.
    """

    compass: Compass | None
    directions: Mapping[str, ModelDirection]

    @classmethod
    def empty(cls) -> Readings:
        return cls(None, {})

    @classmethod
    def create(cls, studio: Studio, model: Model | None, lines: Sequence[KnownLine]) -> Readings:
        """Collect the readings on a model of the project."""
        if model is None:
            return cls.empty()
        compass = get_compass(studio.records, model.id)
        feature_ids = {line.feature_id for line in lines if line.is_read} & set(studio.records)
        if not feature_ids:
            return cls(compass, {})
        from vomstudio.studio.placing.known_planes import measure_directions

        return cls(compass, measure_directions(lines, studio.measured(feature_ids), model))

    def resolve_north(
        self, find_inputs: Callable[[Compass], NorthInputs]
    ) -> tuple[NorthReference, str]:
        """Return the north reference of the azimuths and a sentence that describes it.

        The sentence is empty for the default, grid north.

        Raises
        ------
        UsageError, InputError
            If the reference cannot be determined.
        """
        from vomstudio.studio.placing.read_north import GRID_NORTH, resolve_north

        return (
            (GRID_NORTH, "")
            if self.compass is None
            else resolve_north(self.compass, find_inputs(self.compass))
        )

    def is_equivalent(self, other: Readings) -> bool:
        """Return whether both objects give the same placement."""
        return self.compass == other.compass and _direction_values(self) == _direction_values(other)


def find_north_inputs(
    studio: Studio, compass: Compass, model: Model, points: Sequence[ControlPoint], crs: str | None
) -> NorthInputs:
    """Return the location and date of the readings on a model.

    Parameters
    ----------
    crs : str or None
        CRS of the points.

    Raises
    ------
    UsageError
        If the location or the date is not valid.
    """
    from vomstudio.studio.placing.read_north import north_inputs
    from vomstudio.studio.placing.registering import control_pairs

    open_model = studio.models.get(model.id)
    bounds = None if open_model is None else open_model.data.bounds
    return north_inputs(
        compass=compass, model=model, bounds=bounds, pairs=control_pairs(points), crs=crs
    )


def has_azimuths(lines: Sequence[KnownLine]) -> bool:
    """Return whether any of the lines is a compass reading or has a known azimuth."""
    return any(line.is_read or line.kind == "azimuth" for line in lines)


def placement_north(
    read_north: NorthReference, lines: Sequence[KnownLine]
) -> NorthReference | None:
    """Return the north reference if azimuths determine the placement, otherwise None."""
    return (
        read_north
        if has_azimuths([line for line in lines if line.is_complete and not line.check])
        else None
    )


def _direction_values(readings: Readings) -> dict[str, tuple[tuple[float, ...], float | None]]:
    return {
        id_: (tuple(direction.direction.tolist()), direction.sigma_deg)
        for id_, direction in readings.directions.items()
    }
