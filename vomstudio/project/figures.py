"""Definition of a figure: a property of a feature that has the same name everywhere.

CSV files, the table of the window, the filter, the panels, GIS layers and the command line use
the same definitions; each kind in `project/kinds` lists its figures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import floor, isfinite, log10
from typing import Any, Literal

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.notation import format_error_deg as degrees
from vomstudio.geometry.units import area_text, length_text
from vomstudio.project.measurement import Measurement, NearestPick
from vomstudio.project.records import FeatureType, Model, ModelFeature, Record, TypedFeature, get
from vomstudio.project.registration_errors import normal_covariance, normal_covariances

Unit = Literal["", "deg", "m", "m2"]
Form = Literal[
    "text", "flag", "azimuth", "angle", "error", "length", "area", "index", "ratio", "count"
]
"""Format of a figure. azimuth: periodic angle, 0 to 360. angle: any other angle. error: angle
with two significant digits. index: three significant digits. ratio: two significant digits."""


@dataclass(frozen=True, eq=False)
class Subject:
    """Feature with the data from which its figures are computed.

    A fit that does not belong to a project has no `feature`. `nearest` is called only when needed
    because it depends on other features.
    """

    feature: Any
    measured: Measurement
    records: Mapping[str, Record] = field(default_factory=dict)
    nearest: Callable[[], NearestPick | None] = lambda: None

    @cached_property
    def normal_covariance(self) -> FloatArray | None:
        """Covariance from `registration_errors.normal_covariance`, cached for six columns.

        It is None if the covariance is unknown.
        """
        return normal_covariance(self.measured, self.model)

    @property
    def type(self) -> FeatureType | None:
        feature = self.feature
        return (
            get(self.records, feature.type_id, FeatureType)
            if isinstance(feature, TypedFeature)
            else None
        )

    @property
    def model(self) -> Model | None:
        feature = self.feature
        return (
            get(self.records, feature.model_id, Model)
            if isinstance(feature, ModelFeature)
            else None
        )


def cache_normal_covariances(subjects: Sequence[Subject]) -> None:
    """Compute the covariances of many subjects together, which is many times faster.

    Parameters
    ----------
    subjects : sequence of Subject
        Subjects whose cached covariances are set.
    """
    covariances = normal_covariances(
        [subject.measured for subject in subjects], [subject.model for subject in subjects]
    )
    for subject, covariance in zip(subjects, covariances, strict=True):
        vars(subject)["normal_covariance"] = covariance


@dataclass(frozen=True, eq=False)
class Figure:
    """Property of features.

    Attributes
    ----------
    name, title, explanation : str
        Name in files, title of a column, and one-sentence description.
    value : callable
        Function that returns the value for a subject, or None if it has none. The value may be
        infinite.
    short : str
        Name with at most ten characters.
    words : tuple of str
        Names in a filter, with the usual one first.
    attribute : str
        Field of the record that changes when the user edits the figure.
    format_text : callable or None
        Function that returns the displayed text if it cannot be derived from the value.
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
    format_text: Callable[[Subject], str] | None = None

    def text(self, subject: Subject) -> str:
        """Return the figure as text for the window."""
        if self.format_text is not None:
            return self.format_text(subject)
        return self.value_text(self.value(subject), is_metric=subject.measured.metric)

    def value_text(self, value: Any, *, is_metric: bool = True) -> str:
        """Return a value of this figure as text; `is_metric` is False if the scale is unknown."""
        match self.form:
            case "text":
                return "" if value is None else str(value)
            case "flag":
                return "yes" if value else ""
            case "length":
                return length_text(value, is_metric=is_metric)
            case "area":
                return area_text(value, is_metric=is_metric)
            case "count":
                return "–" if value is None else str(value)
            case "index" | "ratio":
                return number(value, 3 if self.form == "index" else 2)
            case _:
                return degrees(value)


def text_figure(
    name: str, title: str, explanation: str, value: Callable[[Subject], Any], **options: Any
) -> Figure:
    """Create a figure whose value is text."""
    return Figure(name, title, explanation, value, "text", **options)


def figure_in_degrees(
    name: str,
    title: str,
    explanation: str,
    value: Callable[[Subject], Any],
    form: Form = "error",
    **options: Any,
) -> Figure:
    """Create a figure in degrees."""
    return Figure(name, title, explanation, value, form, "deg", **options)


def figure_in_metres(
    name: str, title: str, explanation: str, value: Callable[[Subject], Any], **options: Any
) -> Figure:
    """Create a figure in metres."""
    return Figure(name, title, explanation, value, "length", "m", **options)


def number(value: float | None, digits: int = 3) -> str:
    """Return a ratio or index as text with significant digits; a dash for None."""
    if value is None:
        return "–"
    if not isfinite(value):
        return "∞"
    if value == 0 or abs(value) >= 1e6:
        return f"{value:.{digits}g}"
    # 0.0999 is rounded to a number whose first digit is one decimal place higher.
    exponent = floor(log10(abs(float(f"{value:.{digits - 1}e}"))))
    decimals = max(0, digits - 1 - exponent)
    return f"{value:.{decimals}f}"
