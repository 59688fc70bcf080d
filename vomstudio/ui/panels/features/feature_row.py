"""One feature with its figures, as table, tree and filter look at it."""

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
# Shown for planes only, although files have them for lines too.
_OF_PLANES = (catalogue.N_POINTS, catalogue.EXTENT, catalogue.RMS)
# Words of kinds of their own, which a filter finds too.
_TOLD = (LITHOLOGY, NUMBER, PHOTO)
_OWN = {kind.name: {figure.name: figure for figure in kind.figures} for kind in KINDS}


@dataclass(frozen=True, eq=False)
class Row(Subject):
    """A feature with its measurement. notation : in which its orientation is written."""

    notation: str = ""

    @property
    def class_name(self) -> str:
        """Name of the feature's kind, such as trace."""
        return kind_of(self.feature).noun(self.feature)

    @property
    def oriented(self) -> bool:
        """It is of a kind that has an orientation."""
        return bool(kind_of(self.feature).orientations)

    @property
    def set_name(self) -> str:
        """Name of its set; empty where it has none."""
        return str(getattr(self.feature, "set_name", ""))

    @property
    def overturned(self) -> bool | None:
        """None where a feature of this kind cannot be overturned."""
        value = getattr(self.feature, "overturned", None)
        return None if value is None else bool(value)

    @property
    def azimuth(self) -> float | None:
        """Dip direction of a plane, trend of a line."""
        if self.measured.plane is not None:
            return self.measured.plane.dip_direction_deg
        return None if self.measured.line is None else self.measured.line.trend_deg

    @property
    def quality(self) -> str | None:
        """The verdict: good, doubtful or poor; None where nothing is judged."""
        return self.measured.verdict.quality if self.measured.verdict else None

    @property
    def reasons(self) -> str:
        """The reasons of the verdict."""
        return str(catalogue.REASONS.value(self) or "")

    @cached_property
    def everything(self) -> str:
        """All its texts, in small letters, for words of a filter that name no column."""
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
                *(figure.text(self) for figure in _TOLD if self._own(figure) is not None),
            )
        ).casefold()

    def _own(self, figure: Figure) -> Figure | None:
        """The figure as the feature's kind has it; None where it has none of that name."""
        if figure is CLASS:
            return figure
        own = _OWN[kind_of(self.feature).name].get(figure.name)
        return None if figure in _OF_PLANES and self.measured.fit is None else own

    def value(self, figure: Figure) -> Any:
        """A figure as a value; None where the feature does not have it."""
        own = self._own(figure)
        return None if own is None else own.value(self)

    def text(self, figure: Figure) -> str:
        """A figure as text; empty where a feature of this kind cannot have it."""
        own = self._own(figure)
        if own is None:
            return figure.words_for(None) if self.oriented else ""
        return own.text(self)


def row_of(studio: Studio, feature: Feature, measured: Measurement) -> Row:
    """The row of a feature of the project."""
    subject = studio.subject(feature, measured)
    return Row(feature, measured, subject.records, subject.nearest, studio.settings.notation)
