"""Straight traces in `fit` and `trace`: possible planes, and combination with sets."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Parser
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

if TYPE_CHECKING:
    from vomstudio.geology.band_figures import BandFigures
    from vomstudio.geology.plane_bands import PlaneBand, SetPrior


def add_set_options(parser: Parser) -> None:
    """Add the options for known sets."""
    parser.add_argument(
        "--sets-table",
        metavar="TABLE",
        help=tr("orientation table with sets to compare with a straight trace"),
    )
    add_table_options(parser)


def read_sets(args: argparse.Namespace) -> list[SetPrior]:
    """Read the sets of planes. Raises InputError, GeometryError, UsageError."""
    from vomstudio.geology.band_figures import table_priors

    return [] if args.sets_table is None else table_priors(read_table_picks(args, args.sets_table))


def figures_by_trace(
    bands: Mapping[Any, PlaneBand], priors: Sequence[SetPrior]
) -> dict[Any, BandFigures]:
    """Describe the possible planes of each straight trace, keyed by the name of the trace."""
    from vomstudio.geology.band_figures import describe_band

    return {name: describe_band(band, priors) for name, band in bands.items()}


def crossings(
    requests: Sequence[str], ids: Sequence[Any], bands: Mapping[Any, PlaneBand]
) -> list[dict[str, Any]]:
    """Return the planes through pairs of straight traces. Raises UsageError, GeometryError."""
    from vomstudio.geology.plane_bands import crossing_plane

    planes = []
    for text in requests:
        first_name, second_name = trace_pair(text, ids, "--crossing")
        for name in (first_name, second_name):
            if name not in bands:
                raise UsageError(Finding("trace.not-straight", trace=name), field="--crossing")
        try:
            plane = crossing_plane(bands[first_name], bands[second_name])
        except GeometryError as error:
            error.field = "--crossing"
            raise
        planes.append({"first": first_name, "second": second_name, **asdict(plane)})
    return planes


def trace_pair(text: str, ids: Sequence[Any], option: str) -> tuple[str, str]:
    """Parse the names of two traces, such as "B01,B03". Raises UsageError."""
    names = [name.strip() for name in text.split(",")]
    if len(names) != 2 or any(name not in ids for name in names):
        finding = Finding("trace.not-a-pair", value=text, first=ids[0], second=ids[-1])
        raise UsageError(finding, field=option)
    return names[0], names[1]


def crossing_text(crossing: Mapping[str, Any]) -> str:
    """Describe the plane that contains two crossing traces."""
    return tr(
        "{first} and {second} cross at {angle:.0f} deg. If they belong to one plane, it is"
        " {plane} (dip direction/dip ± maximum 95 % error; minimum {smallest:.2f} deg).",
        first=crossing["first"],
        second=crossing["second"],
        angle=crossing["crossing_deg"],
        plane=text_tables.plane_with_error(crossing, "max_confidence95_deg"),
        smallest=crossing["min_confidence95_deg"],
    )


def band_lines(band: BandFigures) -> list[str]:
    """Describe the possible planes of a straight trace."""
    from vomstudio.geology.band_figures import band_findings

    likely_plane = band.likely_set
    plane = (
        None
        if likely_plane is None
        else text_tables.plane_with_error(vars(likely_plane), "max_confidence95_deg")
    )
    line = _format_angles(band.trend_deg, band.plunge_deg)
    return [item.message for item in band_findings(band, line, plane)]


def _format_angles(azimuth: float, inclination: float) -> str:
    return f"{text_tables.azimuth(azimuth, 1)}/{text_tables.inclination(inclination, 1)}"
