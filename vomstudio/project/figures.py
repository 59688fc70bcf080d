"""What a figure is: one thing that can be said of a feature, under one name everywhere.

CSV files, the window's table, the filter, the panels, GIS layers and the command line are
projections of figures; the kinds in `project/kinds` list which ones they have.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import floor, isfinite, log10
from typing import Any, Literal

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.notation import degrees as degrees
from vomstudio.geometry.units import area_text, length_text
from vomstudio.project.measurement import Measurement, NearestPick
from vomstudio.project.records import FeatureType, Model, OnAModel, Record, Typed, get
from vomstudio.project.registration_errors import normal_covariance

Unit = Literal["", "deg", "m", "m2"]
Form = Literal[
    "text", "flag", "azimuth", "angle", "error", "length", "area", "index", "ratio", "count"
]
"""How a figure is written. azimuth: goes round, 0 to 360. angle: any other. error: an angle with
two digits that mean something. index: three significant digits. ratio: two."""


@dataclass(frozen=True, eq=False)
class Subject:
    """A feature with what its figures are read from.

    feature: None for a fit that belongs to no document. nearest: asked for when shown, since it
    rests on other features.
    """

    feature: Any
    measured: Measurement
    records: Mapping[str, Record] = field(default_factory=dict)
    nearest: Callable[[], NearestPick | None] = lambda: None

    @cached_property
    def normal_covariance(self) -> FloatArray | None:
        """As `registration_errors.normal_covariance`; six columns are read from it."""
        return normal_covariance(self.measured, self.model)

    @property
    def type(self) -> FeatureType | None:
        feature = self.feature
        return (
            get(self.records, feature.type_id, FeatureType) if isinstance(feature, Typed) else None
        )

    @property
    def model(self) -> Model | None:
        feature = self.feature
        return get(self.records, feature.model_id, Model) if isinstance(feature, OnAModel) else None


@dataclass(frozen=True, eq=False)
class Figure:
    """name: in files. title: over a column. explanation: in one sentence. value: of a subject, None
    where it has none; may be infinite. short: where a name may have ten letters only. words: by
    which a filter knows it too, the usual one first. attribute: the field of the record that is
    changed where the figure is typed over. shown: in words, where these are not its value's.
    """

    name: str
    title: str
    explanation: str
    value: Callable[[Subject], Any]
    form: Form = "index"
    unit: Unit = ""
    short: str = ""
    words: tuple[str, ...] = ()
    attribute: str = ""
    shown: Callable[[Subject], str] | None = None

    def text(self, subject: Subject) -> str:
        """The figure in words, as the window shows it."""
        if self.shown is not None:
            return self.shown(subject)
        return self.words_for(self.value(subject), metric=subject.measured.metric)

    def words_for(self, value: Any, *, metric: bool = True) -> str:
        """A value of this figure in words; `metric` is False for lengths of unknown scale."""
        match self.form:
            case "text":
                return "" if value is None else str(value)
            case "flag":
                return "yes" if value else ""
            case "length":
                return length_text(value, metric=metric)
            case "area":
                return area_text(value, metric=metric)
            case "count":
                return "–" if value is None else str(value)
            case "index" | "ratio":
                return number(value, 3 if self.form == "index" else 2)
            case _:
                return degrees(value)


def text_figure(
    name: str, title: str, explanation: str, value: Callable[[Subject], Any], **more: Any
) -> Figure:
    return Figure(name, title, explanation, value, "text", **more)


def figure_in_degrees(
    name: str,
    title: str,
    explanation: str,
    value: Callable[[Subject], Any],
    form: Form = "error",
    **more: Any,
) -> Figure:
    return Figure(name, title, explanation, value, form, "deg", **more)


def figure_in_metres(
    name: str, title: str, explanation: str, value: Callable[[Subject], Any], **more: Any
) -> Figure:
    return Figure(name, title, explanation, value, "length", "m", **more)


def number(value: float | None, digits: int = 3) -> str:
    """A ratio or an index, to so many significant digits."""
    if value is None:
        return "–"
    if not isfinite(value):
        return "∞"
    if value == 0 or abs(value) >= 1e6:
        return f"{value:.{digits}g}"
    # 0.0999 has its first digit one place higher once it is rounded.
    first = floor(log10(abs(float(f"{value:.{digits - 1}e}"))))
    decimals = max(0, digits - 1 - first)
    return f"{value:.{decimals}f}"
