"""Values of features that a command changes, declared once."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.findings import Finding
from vomstudio.core.options import declarations, given_options, option
from vomstudio.errors import UsageError
from vomstudio.words import to_translate


@dataclass(frozen=True)
class FeatureValues:
    """New values of features; None keeps a value.

    Raises
    ------
    UsageError
        If no value is given.
    """

    type: str | None = option(
        None, metavar="TYPE", help=to_translate("feature type, such as bedding")
    )
    set: str | None = option(
        None, metavar="SET", help=to_translate("set; an empty text removes it")
    )
    domain: str | None = option(
        None, metavar="DOMAIN", help=to_translate("domain; an empty text removes it")
    )
    name: str | None = option(None, metavar="NAME", help=to_translate("name of a single feature"))

    def __post_init__(self) -> None:
        if not given_options(self):
            flags = [each.flag for each in declarations(type(self))]
            raise UsageError(Finding("option.none-given", options=flags), field=flags[0])
