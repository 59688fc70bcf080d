"""`vomstudio slope`: kinematic analysis of a rock slope."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    add_output,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.cli.common.output import Output
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.slope_options import SlopeFaces, SlopeOptions

if TYPE_CHECKING:
    from vomstudio.geology.fractures.facet_slopes import FacetSlopes
    from vomstudio.geology.table_slopes import FailureMode, TableSlope

MAX_SHOWN_FACETS = 20


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``slope`` command."""
    parser = add_command(
        subparsers,
        "slope",
        run,
        help_=tr("Analyse the kinematics of a rock slope: sliding and toppling"),
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes, or a project"))
    add_options(parser, SlopeFaces)
    add_output(parser, tr("output table with the critical share of each facet"))
    add_options(parser, SlopeOptions)
    add_table_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio slope``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, GeometryError, TargetError
    """
    faces = parse_options(args, SlopeFaces)
    if faces.facets is not None:
        _run_facets(args, out)
        return
    if args.output is not None:
        raise UsageError(
            Finding("option.requires", option="--output", other="--facets"), field="--output"
        )
    _run_face(args, out)


def _run_face(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.core.files.atomic import atomic_write, check_target
    from vomstudio.geology.table_slopes import slope_face, table_slope
    from vomstudio.products.net.figure import picture_format

    face = slope_face(args.face, parse_options(args, SlopeOptions))
    if args.plot is not None:
        format_ = picture_format(args.plot, "--plot")
        check_target(args.plot, force=args.force, inputs=[args.table])
    progress = report_reading(args, args.table)
    table = read_table_picks(args, args.table)
    slope = table_slope(table, face, progress)
    if args.plot is not None:
        progress.stage(tr("Drawing the stereonets"))
        from vomstudio.products.net.slope_figure import write_slope_figure

        with atomic_write(args.plot, args.force) as temporary:
            write_slope_figure(temporary, table, face, slope, format=format_)
    out.result({**slope.to_dict(), "image": args.plot})
    out.note(tr("read {convention}", convention=slope.convention))
    out.warn(slope.warnings)
    out.text(_result_text(slope))


def _run_facets(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.cli.common.labelled_models import write_labelled_model
    from vomstudio.core.files.atomic import check_target
    from vomstudio.core.files.extensions import check_table_target
    from vomstudio.geology.fractures.facet_slopes import facet_slopes
    from vomstudio.io.models.writing import choose_writer
    from vomstudio.products.surface.slope_facets import (
        read_facet_labels,
        read_facet_slopes,
        slope_fields,
        write_facet_slopes,
    )
    from vomstudio.studio.world_models import read_in_world

    options = parse_options(args, SlopeOptions)
    inputs = [path for path in (args.table, args.facets, args.labelled_model) if path is not None]
    if args.paint is not None:
        choose_writer(Path(args.paint))
        check_target(args.paint, force=args.force, inputs=inputs)
    if args.output is not None:
        check_table_target(args.output, force=args.force, inputs=inputs)
    progress = report_reading(args, args.table)
    table = read_table_picks(args, args.table)
    report_reading(args, args.facets)
    facets = read_table_picks(args, args.facets)
    model = None if args.labelled_model is None else read_in_world(args.labelled_model, progress)
    faces = read_facet_slopes(facets, None if model is None else model.data)
    slopes = facet_slopes(table, faces, options, progress)
    warnings = list(slopes.warnings)
    if args.output is not None:
        write_facet_slopes(args.output, slopes, force=args.force)
    if args.paint is not None and model is not None:
        warnings += write_labelled_model(
            args, model, slope_fields(slopes, read_facet_labels(model.data)), args.paint
        )
    out.result(
        {**slopes.to_dict(), "table": args.output, "model": args.paint, "warnings": warnings}
    )
    out.note(tr("read {convention}", convention=slopes.convention))
    out.warn(warnings)
    out.text(_facets_text(slopes))


def _facets_text(slopes: FacetSlopes) -> str:
    """Describe the facets, starting with the most critical one."""
    heading = tr(
        "{count} facets as slopes, {n} planes, friction {friction:g} deg, lateral limit "
        "{lateral:g} deg",
        count=len(slopes.facets),
        n=slopes.n,
        friction=slopes.friction_deg,
        lateral=slopes.lateral_deg,
    )
    modes = ("planar", "wedge", "flexural_toppling", "direct_toppling")
    shares = [[getattr(f, mode).share or 0.0 for mode in modes] for f in slopes.facets]
    worst_facets = sorted(range(len(shares)), key=lambda i: -max(shares[i]))[:MAX_SHOWN_FACETS]
    rows = [
        [
            slopes.facets[i].id,
            text_tables.azimuth(slopes.facets[i].face.dip_direction_deg, 0),
            text_tables.inclination(slopes.facets[i].face.dip_deg, 0),
            *(text_tables.number(100.0 * share, 1) for share in shares[i]),
        ]
        for i in worst_facets
    ]
    headers = [
        tr("facet"),
        tr("dip dir"),
        tr("dip"),
        tr("planar"),
        tr("wedge"),
        tr("flexural"),
        tr("direct"),
    ]
    lines = [
        heading,
        text_tables.table(headers, ["", tr("deg"), tr("deg"), "%", "%", "%", "%"], rows),
    ]
    if len(shares) > MAX_SHOWN_FACETS:
        lines.append(tr("more facets in the table: {count}", count=len(shares) - MAX_SHOWN_FACETS))
    return "\n".join(lines)


def _result_text(slope: TableSlope) -> str:
    face = slope.face
    heading = tr(
        "face {face} (dip direction/dip), friction {friction:g} deg, lateral limit {lateral:g} deg",
        face=f"{text_tables.azimuth(face.dip_direction_deg, 0)}/"
        f"{text_tables.inclination(face.dip_deg, 0)}",
        friction=slope.friction_deg,
        lateral=slope.lateral_deg,
    )
    rows = [
        _mode_cells(tr("planar sliding"), tr("planes"), slope.planar),
        _mode_cells(tr("wedge sliding"), tr("intersections"), slope.wedge),
        _mode_cells(tr("flexural toppling"), tr("planes"), slope.flexural_toppling),
        _mode_cells(tr("direct toppling"), tr("intersections"), slope.direct_toppling),
        _mode_cells("  " + tr("base planes"), tr("planes"), slope.direct_toppling.bases),
    ]
    headers = [tr("mode"), tr("of"), tr("critical"), tr("all"), tr("share"), tr("with errors")]
    return heading + "\n" + text_tables.table(headers, ["", "", "", "", "%", "%"], rows)


def _mode_cells(name: str, elements: str, mode: FailureMode) -> list[str]:
    share, expected_share = (
        None if value is None else 100.0 * value for value in (mode.share, mode.probability)
    )
    return [
        name,
        elements,
        str(mode.critical),
        str(mode.of),
        text_tables.number(share, 1),
        text_tables.number(expected_share, 1),
    ]
