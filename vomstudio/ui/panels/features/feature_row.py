"""Row of a feature and its figures for table, tree and filter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from vomstudio.core.words import to_translate
from vomstudio.project import catalogue
from vomstudio.project.figures import Figure, Subject
from vomstudio.project.kinds import KINDS, kind_of
from vomstudio.project.kinds.lithology import LITHOLOGY
from vomstudio.project.kinds.station import NUMBER, PHOTO
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature
from vomstudio.ui.base.number_formatting import orientation_text
from vomstudio.ui.base.studio import Studio

CLASS = Figure(
    "class",
    to_translate("Class"),
    to_translate(
        "Trace, patch, lineation, reading, intersection, contact, lithology, station, sample, or "
        "the kind of a dimension"
    ),
    lambda s: kind_of(s.feature).noun(s.feature),
    "text",
    words=("kind", "class"),
)
# Shown for planes only; files also contain them for lines.
_PLANE_FIGURES = (catalogue.N_POINTS, catalogue.EXTENT, catalogue.RMS)
# Figures of single kinds that a filter searches too.
_SEARCHED_FIGURES = (LITHOLOGY, NUMBER, PHOTO)
_KIND_FIGURES = {kind.name: {figure.name: figure for figure in kind.figures} for kind in KINDS}


@dataclass(frozen=True, eq=False)
class Row(Subject):
    """Feature with its measurement; `notation` is used to format its orientation."""

    notation: str = ""

    @property
    def class_name(self) -> str:
        """Return the name of the feature's kind, such as trace."""
        return kind_of(self.feature).noun(self.feature)

    @property
    def has_orientation(self) -> bool:
        """Return whether features of this kind have an orientation."""
        return bool(kind_of(self.feature).orientations)

    @property
    def set_name(self) -> str:
        """Return the name of its set, empty without one."""
        return str(getattr(self.feature, "set_name", ""))

    @property
    def overturned(self) -> bool | None:
        """Return whether it is overturned; None if its kind cannot be."""
        value = getattr(self.feature, "overturned", None)
        return None if value is None else bool(value)

    @property
    def azimuth(self) -> float | None:
        """Return the dip direction of a plane or the trend of a line, in degrees."""
        if self.measured.plane is not None:
            return self.measured.plane.dip_direction_deg
        return None if self.measured.line is None else self.measured.line.trend_deg

    @property
    def quality(self) -> str | None:
        """Return the verdict: good, doubtful or poor; None without one."""
        return self.measured.verdict.quality if self.measured.verdict else None

    @property
    def reasons(self) -> str:
        """Return the reasons of the verdict."""
        return str(catalogue.REASONS.value(self) or "")

    @cached_property
    def search_text(self) -> str:
        """Return all texts in lower case, for filter words without a column."""
        return "\n".join(
            (
                self.feature.name,
                self.type.name if self.type else "",
                self.set_name,
                self.class_name,
                self.quality or "",
                self.reasons,
                self.feature.notes,
                "overturned" if self.overturned else "",
                orientation_text(self.measured, self.notation),
                *(
                    figure.text(self)
                    for figure in _SEARCHED_FIGURES
                    if self._find_figure(figure) is not None
                ),
            )
        ).casefold()

    def _find_figure(self, figure: Figure) -> Figure | None:
        """Return the kind's own version of a figure, None if it has none of that name."""
        if figure is CLASS:
            return figure
        kind_figure = _KIND_FIGURES[kind_of(self.feature).name].get(figure.name)
        return None if figure in _PLANE_FIGURES and self.measured.fit is None else kind_figure

    def value(self, figure: Figure) -> Any:
        """Return the value of a figure, None if the feature does not have it."""
        kind_figure = self._find_figure(figure)
        return None if kind_figure is None else kind_figure.value(self)

    def text(self, figure: Figure) -> str:
        """Format a figure; the text is empty if the feature's kind does not have it."""
        kind_figure = self._find_figure(figure)
        if kind_figure is None:
            return figure.words_for(None) if self.has_orientation else ""
        return kind_figure.text(self)


def create_row(studio: Studio, feature: Feature, measurement: Measurement) -> Row:
    """Create the row of a feature of the project."""
    subject = studio.subject(feature, measurement)
    return Row(
        feature=feature,
        measured=measurement,
        records=subject.records,
        nearest=subject.nearest,
        notation=studio.settings.notation,
    )
