"""Row of a feature and its figures, for the table, the tree and the filter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from vomstudio.core.words import to_translate
from vomstudio.project import catalogue
from vomstudio.project.figures import Figure, Subject
from vomstudio.project.kind import may_be_overturned
from vomstudio.project.kinds import KINDS, get_kind
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
        "the kind of dimension"
    ),
    lambda s: get_kind(s.feature).noun(s.feature),
    "text",
    words=("kind", "class"),
)
# Shown for planes only, although files contain them for lines, too.
_PLANE_FIGURES = (catalogue.N_POINTS, catalogue.EXTENT, catalogue.RMS)
# Figures that only some kinds have, which a filter also searches.
_SEARCHED_FIGURES = (LITHOLOGY, NUMBER, PHOTO, catalogue.STATION)
_KIND_FIGURES = {kind.name: {figure.name: figure for figure in kind.figures} for kind in KINDS}


@dataclass(frozen=True, eq=False)
class Row(Subject):
    """Feature with its measurement; `notation` is used to format its orientation."""

    notation: str = ""

    @property
    def class_name(self) -> str:
        """Name of the feature's kind, such as trace."""
        return get_kind(self.feature).noun(self.feature)

    @property
    def has_orientation(self) -> bool:
        """Whether features of this kind have an orientation."""
        return bool(get_kind(self.feature).orientations)

    @property
    def set_name(self) -> str:
        """Name of the feature's set; empty if it is not in a set."""
        return str(getattr(self.feature, "set_name", ""))

    @property
    def overturned(self) -> bool | None:
        """Whether the feature is overturned, or None if this is unknown or impossible."""
        if not hasattr(self.feature, "overturned") or not may_be_overturned(self.feature):
            return None
        value = self.feature.overturned
        return None if value is None else bool(value)

    @property
    def azimuth(self) -> float | None:
        """Dip direction of a plane or trend of a line, in degrees; None if it is unknown."""
        if self.measured.plane is not None:
            return self.measured.plane.dip_direction_deg
        return None if self.measured.line is None else self.measured.line.trend_deg

    @property
    def quality(self) -> str | None:
        """Verdict (good, doubtful or poor), or None if the feature has not been judged."""
        return self.measured.verdict.quality if self.measured.verdict else None

    @property
    def reasons(self) -> str:
        """Reasons for the verdict."""
        return str(catalogue.REASONS.value(self) or "")

    @cached_property
    def search_text(self) -> str:
        """Lower-case texts of the feature that are searched for the words of a filter."""
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
        """Return the version of a figure for the feature's kind, or None if it does not apply."""
        if figure in (CLASS, catalogue.DOMAIN):
            return figure
        kind_figure = _KIND_FIGURES[get_kind(self.feature).name].get(figure.name)
        return None if figure in _PLANE_FIGURES and self.measured.fit is None else kind_figure

    def value(self, figure: Figure) -> Any:
        """Return the value of a figure, or None if the feature does not have it."""
        kind_figure = self._find_figure(figure)
        return None if kind_figure is None else kind_figure.value(self)

    def text(self, figure: Figure) -> str:
        """Format a figure as text.

        A figure that does not apply to the feature is formatted as an undefined value, or as an
        empty text if features of this kind have no orientation.
        """
        kind_figure = self._find_figure(figure)
        if kind_figure is None:
            return figure.value_text(None) if self.has_orientation else ""
        return kind_figure.text(self)


def has_figure(kind_name: str, figure: Figure) -> bool:
    """Return whether features of a kind may have a figure.

    Parameters
    ----------
    kind_name : str
    figure : Figure
        Column of the table.
    """
    return figure.name in _KIND_FIGURES[kind_name] or figure in (CLASS, catalogue.DOMAIN)


def create_row(studio: Studio, feature: Feature, measurement: Measurement) -> Row:
    """Create the row for a feature of the project."""
    subject = studio.subject(feature, measurement)
    return Row(
        feature=feature,
        measured=measurement,
        records=subject.records,
        nearest=subject.nearest,
        notation=studio.settings.notation,
    )
