"""Display style of a field of a model, as stored in a project."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from vomstudio.core.results import Result
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

ELEVATION = "elevation"
"""Name of the field of World heights, which is available for every model."""
DEFAULT_PERCENTILES = (2.0, 98.0)

PaletteKind = Literal["sequential", "diverging", "cyclic", "categories"]

PALETTES: dict[PaletteKind, tuple[str, ...]] = {
    "sequential": ("viridis", "cividis", "magma", "gray"),
    "diverging": ("RdBu_r", "PuOr_r"),
    "cyclic": ("twilight", "hsv"),
}
"""Names of matplotlib's colour maps, the default first."""


@dataclass(frozen=True)
class FieldStyle(Result):
    """Display style of a field of one model.

    Attributes
    ----------
    low, high : float or None
        Limits entered by the user. If None, the percentile is used.
    percentiles : (float, float)
        Percentiles of the limits, 0 to 100.
    palette : str or None
        Name in PALETTES. If None, the default palette of the kind is used.
    """

    name: str
    low: float | None = None
    high: float | None = None
    percentiles: tuple[float, float] = DEFAULT_PERCENTILES
    palette: str | None = None

    @classmethod
    def from_dict(cls, values: Any) -> FieldStyle:
        """Read a style from a dictionary.

        Raises
        ------
        ValueError
            If the values are not a valid style.
        """
        try:
            ends = [None if values[k] is None else float(values[k]) for k in ("low", "high")]
            low_percentile, high_percentile = (float(v) for v in values["percentiles"])
            palette = values["palette"]
            if palette is not None and palette not in sum(PALETTES.values(), ()):
                raise ValueError(f"palette {palette!r}")
            return cls(
                str(values["name"]), ends[0], ends[1], (low_percentile, high_percentile), palette
            )
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"not the style of a field: {values!r}") from error


def field_names(data: Mesh | PointCloud) -> tuple[str, ...]:
    """Return the fields of a model that can be displayed: ELEVATION and all numeric fields.

    Parameters
    ----------
    data : Mesh or PointCloud

    Returns
    -------
    tuple of str
    """
    count = len(data.vertices) if isinstance(data, Mesh) else len(data.points)
    names = [
        name
        for name, values in data.fields.items()
        if values.shape == (count,) and values.dtype.kind in "biuf"
    ]
    return (ELEVATION, *names)
