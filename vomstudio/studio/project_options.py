"""Options of the `vomstudio project` actions, shared by the command line and Python."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import (
    Options,
    declarations,
    given_options,
    option,
)
from vomstudio.core.words import to_translate
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.registration.register_options import Observations


@dataclass(frozen=True, kw_only=True)
class ModelChoice(Options):
    """Option that selects the model of an action."""

    model: str | None = option(
        None,
        metavar="MODEL",
        help=to_translate("name or id of the model"),
        automatic_text=to_translate("the only model"),
    )


@dataclass(frozen=True, kw_only=True)
class PlacementOptions(Observations, ModelChoice):
    """Options for the registration of a model of a project."""


@dataclass(frozen=True, kw_only=True)
class PickOptions(ModelChoice):
    """Options of points that are added to a project as features."""

    type: str = option(metavar="TYPE", help=to_translate("feature type, such as bedding"))
    shape: Literal["trace", "line", "patch"] = option(
        "trace",
        help=to_translate(
            "what the points define: a trace, a line (a lineation or contact line, depending on the"
            " type), or the outline of a patch"
        ),
    )
    by: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate("name or number of the column with the names of the features"),
        automatic_text=to_translate("one feature"),
    )
    set: str | None = option(None, metavar="SET", help=to_translate("set of the features"))
    domain: str | None = option(
        None,
        metavar="DOMAIN",
        help=to_translate("domain of the features, such as the hanging wall of a fault"),
    )


@dataclass(frozen=True, kw_only=True)
class AcceptOptions(ModelChoice):
    """Options of proposals that are added to a project."""

    type: str = option(metavar="TYPE", help=to_translate("feature type, such as joint"))
    set: str | None = option(None, metavar="SET", help=to_translate("set of the features"))
    quality: Literal["good", "doubtful"] | None = option(
        None,
        choices=("good", "doubtful"),
        help=to_translate("add only features of at least this quality"),
    )


@dataclass(frozen=True)
class FeatureValues(Options):
    """New values for features; None keeps the present value.

    Raises
    ------
    UsageError
        If no value is given.
    """

    type: str | None = option(
        None, metavar="TYPE", help=to_translate("feature type, such as bedding")
    )
    set: str | None = option(None, metavar="SET", help=to_translate("set; empty to remove it"))
    domain: str | None = option(
        None, metavar="DOMAIN", help=to_translate("domain; empty to remove it")
    )
    name: str | None = option(None, metavar="NAME", help=to_translate("name of a single feature"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not given_options(self):
            flags = [item.flag for item in declarations(type(self))]
            raise UsageError(Finding("option.none-given", options=flags), field=flags[0])


@dataclass(frozen=True)
class CompactOptions(Options):
    """Options for compacting the journal of a project."""

    dry_run: bool = option(False, help=to_translate("report removable data without deleting them"))


@dataclass(frozen=True)
class ProposalSearch:
    """Command that proposes features, and its options."""

    command: str
    options: type[FacetOptions] | type[ProposalOptions]


PROPOSALS = {
    "facets": ProposalSearch("facets", FacetOptions),
    "traces": ProposalSearch("trace --propose", ProposalOptions),
}
"""Searches whose proposals can be added to a project."""

ACTION_OPTIONS: dict[str, type] = {
    "register": PlacementOptions,
    "add-picks": PickOptions,
    "import": ModelChoice,
    "accept": AcceptOptions,
    "set": FeatureValues,
    "compact": CompactOptions,
}
"""Options class of each `vomstudio project` action, keyed by the name of the action."""
