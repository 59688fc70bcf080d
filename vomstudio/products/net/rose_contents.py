"""Contents of rose diagrams and histograms, from a table or from the sets of a net."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.roses import (
    HISTOGRAM_ANGLES,
    LINE_ANGLES,
    AngleHistogram,
    Rose,
    column_weights,
    count_histogram,
    count_rose,
    select_angles,
    table_angles,
)
from vomstudio.io.text.repeated_rows import repeats_note
from vomstudio.products.net.contents import NetSet
from vomstudio.products.net.table_net import group_rows


@dataclass(frozen=True, eq=False)
class CountedFeatures:
    """Features that are counted in one rose, for picking.

    Parameters
    ----------
    ids : tuple of str
    angles_deg : (n,) array
        Counted angles; NaN for features without an angle.
    color : str
        #rrggbb.
    """

    ids: tuple[str, ...]
    angles_deg: FloatArray
    color: str


@dataclass(frozen=True, eq=False)
class RoseContents:
    """Contents of a figure of rose diagrams.

    Parameters
    ----------
    of : str
        Angle that is counted, one of `roses.ROSE_ANGLES` or `roses.HISTOGRAM_ANGLES`.
    roses : mapping of str to Rose or AngleHistogram
        Roses or histograms by the name of their set.
    weight : str or None
        Name of the weights; None if features are counted without weights.
    is_area_scaled : bool
        Whether the area of a petal is proportional to its share. Otherwise its length is.
    empty : tuple of str
        Names of sets without any row that has both an angle and a weight.
    counted_sets : mapping of str to CountedFeatures
        Counted features by the name of their set, if known.
    title, notes
        Title of the figure, and notes that are shown above the caption.
    colors : mapping of str to str
        Colours, by set, that differ from the defaults.
    north : bool
        Whether azimuths are from north; False in a local frame.
    """

    of: str
    roses: Mapping[str, Rose | AngleHistogram]
    weight: str | None = None
    is_area_scaled: bool = True
    empty: tuple[str, ...] = ()
    counted_sets: Mapping[str, CountedFeatures] = field(default_factory=dict)
    title: str = ""
    notes: tuple[str, ...] = ()
    colors: Mapping[str, str] = field(default_factory=dict)
    north: bool = True

    @property
    def bin_deg(self) -> float:
        return next(iter(self.roses.values())).bin_deg


def roses_from_table(
    table: OrientationRows,
    of: str,
    by: str | None = None,
    *,
    bin_deg: float = 10.0,
    weight: str | None = None,
    is_area_scaled: bool = True,
) -> RoseContents:
    """Compute a rose for each set of a table whose features have the requested angle.

    Parameters
    ----------
    table : OrientationRows
    of : str
        Angle to count, one of `roses.ROSE_ANGLES` or `roses.HISTOGRAM_ANGLES`.
    by, weight : str or None
        Names or numbers of the columns of sets and weights. By default, sets are taken from
        `set` or, if missing, from `kind`; otherwise all rows form one set.
    bin_deg : float
    is_area_scaled : bool

    Raises
    ------
    UsageError
        If a column is missing or not numeric.
    """
    angles = table_angles(table, of)
    weights = None if weight is None else column_weights(table, weight)
    is_suitable = table.is_plane != (of in LINE_ANGLES)
    roses, empty_sets = {}, []
    for name, members in group_rows(table, by).items():
        rows = np.array([i for i in members if is_suitable[i]], dtype=np.intp)
        if len(rows):
            set_weights = None if weights is None else weights[rows]
            rose = _count_angles(of, angles[rows], bin_deg, set_weights)
            if rose.total > 0:
                roses[name] = rose
            else:
                empty_sets.append(name)
    notes = repeats_note(table.repeats)
    return RoseContents(of, roses, weight, is_area_scaled, tuple(empty_sets), notes=notes)


def roses_from_sets(
    sets: Iterable[NetSet],
    of: str,
    *,
    bin_deg: float = 10.0,
    weights: Mapping[str, float | None] | None = None,
    weight: str | None = None,
    is_area_scaled: bool = True,
) -> RoseContents:
    """Compute a rose for each set of a net whose features have the requested angle.

    Parameters
    ----------
    sets : iterable of NetSet
    of : str
        Angle to count, one of `roses.ROSE_ANGLES` or `roses.HISTOGRAM_ANGLES`.
    bin_deg : float
    weights : mapping, optional
        Weight of each feature by id; None for a feature without a weight.
    weight : str, optional
        Name of the weights.
    is_area_scaled : bool
    """
    required_kind = "line" if of in LINE_ANGLES else "plane"
    roses, counted_sets, empty_sets = {}, {}, []
    for set_ in sets:
        if set_.kind != required_kind or not len(set_):
            continue
        angles = select_angles(set_.azimuth_deg, set_.angle_deg, of)
        w = None
        if weights is not None:
            set_weights = [weights.get(id_) for id_ in set_.ids]
            w = np.array([np.nan if item is None else item for item in set_weights])
        rose = _count_angles(of, angles, bin_deg, w)
        if rose.total > 0:
            roses[set_.name] = rose
            counted_sets[set_.name] = CountedFeatures(set_.ids, angles, set_.color)
        else:
            empty_sets.append(set_.name)
    return RoseContents(of, roses, weight, is_area_scaled, tuple(empty_sets), counted_sets)


def _count_angles(
    of: str, angles: FloatArray, bin_deg: float, weights: npt.ArrayLike | None
) -> Rose | AngleHistogram:
    if of in HISTOGRAM_ANGLES:
        return count_histogram(angles, bin_deg=bin_deg, weights=weights)
    return count_rose(angles, is_axial=of == "strike", bin_deg=bin_deg, weights=weights)


def check_roses(contents: RoseContents, path: Path | None) -> None:
    """Require at least one rose.

    Raises
    ------
    GeometryError
        If no row has both an angle and a weight.
    """
    if contents.roses:
        return
    raise GeometryError(
        Finding("rose.no-lines" if contents.of in LINE_ANGLES else "rose.no-planes"),
        file=path,
        field="--of",
    )
