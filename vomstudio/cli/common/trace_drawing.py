"""`vomstudio trace --from-ortho`: lines drawn on an orthophoto come back to the surface."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common.arguments import Parser, progress_of
from vomstudio.cli.common.frames_of_models import add_frame, add_project, frame_options
from vomstudio.cli.common.lengths import named_by_unit
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Finding, Message
from vomstudio.errors import InputError, UsageError
from vomstudio.words import tr, tr_n

if TYPE_CHECKING:
    from vomstudio.document.kinds.trace import Trace
    from vomstudio.document.records import FeatureType
    from vomstudio.products.ortho.drawing_back import BackLine, Brought, Sidecar
    from vomstudio.workspace.headless_project import HeadlessProject


OPTIONS = ("sidecar", "step", "into", "type", "on", "set", "update")
"""That are for drawings alone."""


def add_options(parser: Parser) -> None:
    parser.add_argument(
        "--from-ortho",
        metavar="DRAWING",
        help=tr("lines drawn on an orthophoto: GeoPackage, GeoJSON, shapefile, SVG or DXF"),
    )
    parser.add_argument(
        "--sidecar", metavar="FILE", help=tr("the NAME.json that was written beside the orthophoto")
    )
    parser.add_argument(
        "--step",
        type=float,
        metavar="M",
        help=tr("also points between the vertices, so many metres apart at most"),
    )
    parser.add_argument(
        "--into", metavar="PROJECT", help=tr("also add them to this project, as one step")
    )
    parser.add_argument(
        "--type",
        help=tr(
            "feature type of the lines in the project (default: the one that the layer of each is "
            "named after)"
        ),
    )
    parser.add_argument("--on", metavar="NAME", help=tr("the project's model that they lie on"))
    parser.add_argument("--set", default="", help=tr("the set that they belong to"))
    parser.add_argument(
        "--update",
        action="store_true",
        help=tr("change traces of the project that were edited in the drawing"),
    )
    add_frame(parser)
    add_project(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Raises UsageError, InputError, GeometryError or TargetError."""
    from vomstudio.files.atomic import check_target
    from vomstudio.products.ortho import drawing_back
    from vomstudio.tables.line_table import write_line_table
    from vomstudio.workspace.world_models import read_in_world

    if args.sidecar is None:
        raise UsageError(
            tr("Give the sidecar of the picture that was drawn on: --sidecar NAME.json."),
            field="--sidecar",
        )
    if args.step is not None and not 0 < args.step < math.inf:
        raise UsageError(tr("A distance is a length in metres."), field="--step")
    if args.into is None and args.type is not None:
        raise UsageError(_type_wanted(), field="--into")
    check_target(args.output, force=args.force, inputs=[args.model, args.from_ortho, args.sidecar])
    sidecar = drawing_back.read_sidecar(args.sidecar)
    lines, said = drawing_back.read_drawing(args.from_ortho, sidecar, progress_of(args))
    model = read_in_world(args.model, progress_of(args), frame_options(args), args.project)
    try:
        brought = drawing_back.bring_back(lines, sidecar, model.data, args.step)
    except InputError as error:
        raise error.of_file(args.from_ortho) from error
    warnings = [*model.warnings, *said, *brought.warnings]
    if sidecar.content_hash not in (None, model.loaded.content_hash):
        warnings.append(
            tr(
                "The orthophoto was made of another file than {model}, or of it before it changed.",
                model=Path(args.model).name,
            )
        )
    result: dict[str, Any] = {**drawing_back.facts_of(brought, args.output)}
    if args.into is not None:
        added = _add(args, brought, sidecar)
        result |= {"added": added.new, "updated": added.updated, "unchanged": added.unchanged}
        warnings += added.warnings
    write_line_table(
        args.output,
        [(line.name, line.points) for line in brought.lines],
        crs=model.crs,
        north_known=model.placed,
        source=Path(args.from_ortho).name,
        force=args.force,
    )
    result["warnings"] = warnings
    out.result(named_by_unit(result, metric=model.in_metres))
    out.warn(warnings)
    out.text(
        tr_n(
            "{count} line of {points} points on the surface: {table}",
            "{count} lines of {points} points on the surface: {table}",
            result["lines"],
            points=result["points"],
            table=args.output,
        )
    )


def _type_wanted() -> str:
    return tr("A project needs the type of its features: --into PROJECT --type TYPE.")


def _types(
    args: argparse.Namespace, lines: Sequence[BackLine], desk: HeadlessProject
) -> list[FeatureType]:
    """Return the feature type of each line. Raises UsageError."""
    from vomstudio.document.records import FeatureType
    from vomstudio.workspace.drawn_traces import type_of_layer

    if args.type is not None:
        return [desk.find_type(args.type)] * len(lines)
    types = desk.session.of(FeatureType)
    found = [
        type_of_layer(line.words.kind, types) or type_of_layer(line.layer, types) for line in lines
    ]
    kinds = [kind for kind in found if kind is not None]
    if len(kinds) < len(found):
        others = dict.fromkeys(
            line.layer for line, kind in zip(lines, found, strict=True) if kind is None
        )
        layers = ", ".join(layer or "0" for layer in list(others)[:5])
        raise UsageError(
            tr(
                "{sentence} Layers that are called as a feature type of the project is say it "
                "themselves; these are not: {layers}.",
                sentence=_type_wanted(),
                layers=layers,
            ),
            field="--type",
        )
    return kinds


@dataclass(frozen=True)
class _Added:
    """Traces of the project by what a drawing did to them, as objects of ``--json``."""

    new: list[dict[str, str]]
    updated: list[dict[str, str]]
    unchanged: list[dict[str, str]]
    warnings: list[Message]


def _add(args: argparse.Namespace, brought: Brought, sidecar: Sidecar) -> _Added:
    """Add the new lines to the project, and update edited traces if that is requested."""
    from vomstudio.io.settings import read_settings
    from vomstudio.workspace.drawn_traces import why_not_updated
    from vomstudio.workspace.headless_project import AddedPicks, HeadlessProject, Picks
    from vomstudio.workspace.layer_export import written_layers
    from vomstudio.workspace.redrawn import compare_brought

    settings, problems = read_settings()
    with HeadlessProject.opened(Path(args.into), settings, progress_of(args)) as desk:
        model = desk.find_model(args.on)
        comparisons = compare_brought(brought.lines, sidecar, desk.session.records)
        new = [
            line
            for line, comparison in zip(brought.lines, comparisons, strict=True)
            if comparison.trace is None
        ]
        added = AddedPicks((), (), ())
        if new:
            kinds = _types(args, new, desk)
            picks = [
                Picks(line.name, line.points, kind, set=line.words.set)
                for line, kind in zip(new, kinds, strict=True)
            ]
            added = desk.add_picks(picks, model, kinds[0], args.set)
        edited, skipped = [], list(added.skipped)
        for line, comparison in zip(brought.lines, comparisons, strict=True):
            if comparison.state != "edited" or comparison.trace is None:
                continue
            reason = why_not_updated(comparison, model, desk.session.records)
            if reason is None:
                edited.append((comparison.trace, line.points))
            else:
                skipped.append((line.name, reason))
        if edited and args.update:
            desk.update_traces(edited, model, Path(args.from_ortho).name)
        desk.save()
        folder, has_features = desk.project.folder, bool(desk.session.features())
    unchanged = [each.trace for each in comparisons if each.state == "unchanged" and each.trace]
    messages: list[Message] = [*problems, *added.warnings]
    if unchanged:
        messages.append(Finding("drawing.traces-unchanged", count=len(unchanged)))
    if edited and not args.update:
        names = ", ".join(trace.name for trace, _ in edited[:5])
        messages.append(Finding("drawing.traces-edited", count=len(edited), names=names))
    messages += [
        tr("{feature} was left out: {reason}", feature=name, reason=reason)
        for name, reason in skipped
    ]
    messages += written_layers(folder, has_features)
    updated = [trace for trace, _ in edited] if args.update else []
    return _Added(_listed(added.traces), _listed(updated), _listed(unchanged), messages)


def _listed(traces: Sequence[Trace]) -> list[dict[str, str]]:
    return [{"id": trace.id, "name": trace.name} for trace in traces]
