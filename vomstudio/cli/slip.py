"""`vomstudio slip`: kinematic axes of faults with known slip."""

from __future__ import annotations

import argparse
from pathlib import Path

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, report_reading
from vomstudio.cli.common.declared_options import parse_options
from vomstudio.cli.common.orientation_tables import add_table_options
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr, tr_n
from vomstudio.io.text.table_options import TableOptions


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``slip`` command."""
    parser = add_command(
        subparsers,
        "slip",
        run,
        help_=tr("Compute P and T axes, kinematic axes and right dihedra of faults"),
    )
    parser.add_argument(
        "table",
        metavar="TABLE",
        help=tr(
            "table of faults with striae and slip sense: from this program, FaultKin, Win-Tensor"
            " or T-TECTO"
        ),
    )
    parser.add_argument(
        "--plot", metavar="FILE", help=tr("also draw the nets (.svg, .pdf or .png)")
    )
    parser.add_argument("--force", action="store_true", help=tr("replace an existing FILE"))
    add_table_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio slip``.

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
    from vomstudio.core.files.atomic import atomic_write, check_target
    from vomstudio.geology.faults.table_slip import table_slip
    from vomstudio.io.gate.orientation_files import read_slips
    from vomstudio.io.text.column_mapping import parse_columns
    from vomstudio.products.net.figure import picture_format

    if args.plot is not None:
        format_ = picture_format(args.plot, "--plot")
        check_target(args.plot, force=args.force, inputs=[args.table])
    progress = report_reading(args, args.table)
    options = parse_options(args, TableOptions)
    table = read_slips(
        Path(args.table),
        options.azimuth,
        columns=parse_columns(options.columns),
        layer=options.layer,
    )
    progress.stage(tr("Computing kinematic axes"))
    slip_result = table_slip(table)
    if args.plot is not None:
        progress.stage(tr("Drawing the stereonets"))
        from vomstudio.products.net.slip_figure import write_slip_figure

        with atomic_write(args.plot, args.force) as temporary:
            write_slip_figure(temporary, table, slip_result, format=format_)
    result = {**slip_result.to_dict(), "image": args.plot}
    out.result(result)
    out.warn(slip_result.warnings)
    axes, dihedra = result["kinematic_axes"], result["right_dihedra"]
    rows = [
        [
            name,
            text_tables.line(axes[key]),
            text_tables.number(axes[key]["value"], 2),
            text_tables.number(axes[key]["confidence95_deg"], 1),
        ]
        for name, key in (
            (tr("shortening"), "shortening"),
            (tr("intermediate"), "intermediate"),
            (tr("extension"), "extension"),
        )
    ]
    headers = [tr("kinematic axis"), tr("trend/plunge"), tr("value"), tr("95 % cone")]
    dihedra_rows = [
        [name, text_tables.line(dihedra[key]), text_tables.number(100.0 * dihedra[key]["share"], 0)]
        for name, key in ((tr("compression"), "compression"), (tr("extension"), "extension"))
    ]
    out.text(tr_n("{count} fault", "{count} faults", slip_result.n))
    out.text(text_tables.table(headers, ["", "deg", "", "deg"], rows))
    headers = [tr("right dihedra"), tr("trend/plunge"), tr("share of faults")]
    out.text(text_tables.table(headers, ["", "deg", "%"], dihedra_rows))
