"""Which field of a model is shown as colours, and how: what a project keeps of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from vomstudio.core.results import Result
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

ELEVATION = "elevation"
"""The height in World, which every model has."""
PERCENTILES = (2.0, 98.0)

Kind = Literal["sequential", "diverging", "cyclic", "categories"]

PALETTES: dict[Kind, tuple[str, ...]] = {
    "sequential": ("viridis", "cividis", "magma", "gray"),
    "diverging": ("RdBu_r", "PuOr_r"),
    "cyclic": ("twilight", "hsv"),
}
"""Names of matplotlib's maps, the default first."""


@dataclass(frozen=True)
class FieldStyle(Result):
    """How a field of one model is to be shown.

    low, high : the range that was typed; None takes the percentile
    percentiles : lowest and highest, 0..100
    palette : a name of PALETTES; None is the kind's own
    """

    name: str
    low: float | None = None
    high: float | None = None
    percentiles: tuple[float, float] = PERCENTILES
    palette: str | None = None

    @classmethod
    def from_dict(cls, values: Any) -> FieldStyle:
        """Raises ValueError where it is none."""
        try:
            ends = [None if values[k] is None else float(values[k]) for k in ("low", "high")]
            first, last = (float(v) for v in values["percentiles"])
            palette = values["palette"]
            if palette is not None and palette not in sum(PALETTES.values(), ()):
                raise ValueError(f"palette {palette!r}")
            return cls(str(values["name"]), ends[0], ends[1], (first, last), palette)
        except (KeyError, TypeError) as error:
            raise ValueError(f"not the style of a field: {values!r}") from error


def field_names(data: Mesh | PointCloud) -> tuple[str, ...]:
    """What can be shown of a model: ELEVATION and its own numeric fields."""
    count = len(data.vertices) if isinstance(data, Mesh) else len(data.points)
    own = [
        name
        for name, values in data.fields.items()
        if values.shape == (count,) and values.dtype.kind in "biuf"
    ]
    return (ELEVATION, *own)
