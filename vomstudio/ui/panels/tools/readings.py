"""What was read by compass on a model: as the model shows it, and counted from which north."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vomstudio.geometry.registrations import ReadNorth
from vomstudio.project.compass_edits import compass_of
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.records import Compass, Model
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.registration.north import North
    from vomstudio.studio.placing.known_planes import ModelDirection


@dataclass(frozen=True, eq=False)
class Readings:
    """compass : what was said of it, None for nothing; seen : by the ids of the readings"""

    compass: Compass | None
    seen: Mapping[str, ModelDirection]

    @classmethod
    def none(cls) -> Readings:
        return cls(None, {})

    @classmethod
    def of(cls, studio: Studio, model: Model | None, lines: Sequence[KnownLine]) -> Readings:
        """Those of a model as it stands in the project."""
        if model is None:
            return cls.none()
        compass = compass_of(studio.records, model.id)
        there = {line.feature_id for line in lines if line.is_read} & set(studio.records)
        if not there:
            return cls(compass, {})
        from vomstudio.studio.placing.known_planes import measure_directions

        return cls(compass, measure_directions(lines, studio.measured(there), model))

    def counted(self, known: Callable[[Compass], North]) -> tuple[ReadNorth, str]:
        """How azimuths are counted, and a sentence on that. Raises UsageError, InputError where
        that is not known."""
        from vomstudio.studio.placing.read_north import GRID_NORTH, resolve_north

        return (
            (GRID_NORTH, "")
            if self.compass is None
            else resolve_north(self.compass, known(self.compass))
        )

    def same_as(self, other: Readings) -> bool:
        """Whether nothing has changed that places a model."""
        return self.compass == other.compass and _figures(self) == _figures(other)


def known_north(
    studio: Studio, compass: Compass, model: Model, points: Sequence[ControlPoint], crs: str | None
) -> North:
    """What is known of place and day of readings on a model. crs : of the points. Raises
    UsageError."""
    from vomstudio.studio.placing.read_north import north_inputs
    from vomstudio.studio.placing.registering import control_pairs

    opened = studio.models.get(model.id)
    bounds = None if opened is None else opened.data.bounds
    return north_inputs(compass, model, bounds, control_pairs(points), crs)


def counted(lines: Sequence[KnownLine]) -> bool:
    """Whether azimuths are among what is known."""
    return any(line.is_read or line.kind == "azimuth" for line in lines)


def used_north(used: ReadNorth, lines: Sequence[KnownLine]) -> ReadNorth | None:
    """How azimuths were counted that place a model; None where none does."""
    return (
        used if counted([line for line in lines if line.is_complete and not line.check]) else None
    )


def _figures(readings: Readings) -> dict[str, tuple[tuple[float, ...], float | None]]:
    return {
        id_: (tuple(each.direction.tolist()), each.sigma_deg) for id_, each in readings.seen.items()
    }
