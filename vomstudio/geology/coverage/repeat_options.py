"""Options of repeated picks, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class RepeatOptions(Options):
    """Columns that identify repeated picks of a structure and the interpreters."""

    by: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate("column with the same value for picks of the same structure"),
        automatic_text=to_translate("repeat_of, the id of the repeated pick"),
    )
    interpreter: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate("column with the name of the interpreter"),
        automatic_text=to_translate("interpreter, if present"),
    )
