"""Options of tables of orientations, declared once for all commands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class TableOptions(Options):
    """Columns and layer of a table of orientations.

    Raises
    ------
    UsageError
        If a value is not one of the choices.
    """

    azimuth: Literal["strike", "dipdir"] | None = option(
        None,
        help=to_translate(
            "meaning of a column called azimuth, or of the first column if there is no header"
        ),
    )
    columns: str | None = option(
        None,
        metavar="NAME=MEANING,...",
        help=to_translate(
            "meaning of columns by name, or by number without a header, such as"
            " azi=dip_direction,inc=dip"
        ),
    )
    layer: str | None = option(
        None,
        metavar="NAME",
        help=to_translate("layer of a GIS file, or sheet of a workbook, that contains the table"),
    )


NO_TABLE_OPTIONS = TableOptions()
"""No options; the table states the meaning of its columns."""
