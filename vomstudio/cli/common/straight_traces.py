"""What `fit` and `trace` say of straight traces: the band of planes, and what picks one out."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Parser, add_azimuth
from vomstudio.errors import GeometryError, UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.geology.band_figures import BandFigures
    from vomstudio.geology.plane_bands import PlaneBand, SetPrior


def add_sets(parser: Parser) -> None:
    parser.add_argument(
        "--sets-table",
        metavar="TABLE",
        help=tr("orientation table with sets, against which a straight trace is held"),
    )
    add_azimuth(parser)


def read_sets(args: argparse.Namespace) -> list[SetPrior]:
    """Raises InputError, GeometryError, UsageError."""
    from vomstudio.geology.band_figures import table_priors
    from vomstudio.io.text.orientation_reading import read_orientations

    return (
        []
        if args.sets_table is None
        else table_priors(read_orientations(args.sets_table, args.azimuth))
    )


def bands_told(
    bands: Mapping[Any, PlaneBand], priors: Sequence[SetPrior]
) -> dict[Any, BandFigures]:
    from vomstudio.geology.band_figures import band_figures

    return {name: band_figures(band, priors) for name, band in bands.items()}


def crossings(
    asked: Sequence[str], ids: Sequence[Any], bands: Mapping[Any, PlaneBand]
) -> list[dict[str, Any]]:
    """The planes of pairs of straight traces. Raises UsageError."""
    from vomstudio.geology.plane_bands import crossing_plane

    found = []
    for words in asked:
        names = [name.strip() for name in words.split(",")]
        if len(names) != 2 or any(name not in ids for name in names):
            raise UsageError(
                tr(
                    "--crossing takes the names of two traces, such as {first},{second}; "
                    "“{asked}” is none.",
                    first=ids[0],
                    second=ids[-1],
                    asked=words,
                ),
                field="--crossing",
            )
        for name in names:
            if name not in bands:
                raise UsageError(
                    tr(
                        "The trace {name} is not straight: it has a plane of its own, or none.",
                        name=name,
                    ),
                    field="--crossing",
                )
        try:
            plane = crossing_plane(bands[names[0]], bands[names[1]])
        except GeometryError as error:
            raise UsageError(str(error), field="--crossing") from error
        found.append({"first": names[0], "second": names[1], **asdict(plane)})
    return found


def crossing_in_words(found: Mapping[str, Any]) -> str:
    return tr(
        "{first} and {second} cross at {angle:.0f} deg. If they are of one plane, it is {plane} "
        "(dip direction/dip, 95 %; {smallest:.2f} deg at least).",
        first=found["first"],
        second=found["second"],
        angle=found["crossing_deg"],
        plane=text_tables.measured_plane(found, "max_confidence95_deg"),
        smallest=found["min_confidence95_deg"],
    )


def band_in_words(found: BandFigures) -> list[str]:
    from vomstudio.geology.band_figures import in_words

    likely = found.likely
    plane = (
        None if likely is None else text_tables.measured_plane(vars(likely), "max_confidence95_deg")
    )
    return in_words(found, _angles(found.trend_deg, found.plunge_deg), plane)


def _angles(azimuth: float, inclination: float) -> str:
    return f"{text_tables.azimuth(azimuth, 1)}/{text_tables.inclination(inclination, 1)}"
