"""`vomstudio project`: operations on a project without a window."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common.arguments import (
    Parser,
    Run,
    Subparsers,
    add_command,
    add_output,
    add_shared_options,
    progress_reporter,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.output import Output
from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.studio.project_options import (
    ACTION_OPTIONS,
    PROPOSALS,
    AcceptOptions,
    CompactOptions,
    FeatureValues,
    ModelChoice,
    PickOptions,
    PlacementOptions,
)

if TYPE_CHECKING:
    from vomstudio.project.records import Feature
    from vomstudio.studio.headless_project import HeadlessProject
    from vomstudio.studio.project_summary import ProjectSummary


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``project`` command."""
    parser = add_command(
        subparsers, "project", _run, help_=tr("Inspect, edit, verify and repair a project")
    )
    parser.add_argument("project", metavar="PROJECT", help=tr("the folder NAME.vom"))
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    def add_action(name: str, action: Run, help_: str) -> Parser:
        # Options shared by all commands may precede or follow the action.
        action_parser: Parser = actions.add_parser(
            name, help=help_, description=f"{help_}.", argument_default=argparse.SUPPRESS
        )
        add_shared_options(action_parser)
        action_parser.set_defaults(act=action)
        return action_parser

    add_action("create", _create, tr("Create an empty project"))
    add_action("list", _list, tr("List the contents of the project"))
    model_parser = add_action("add-model", _add_model, tr("Add a model to the project"))
    model_parser.add_argument(
        "file", metavar="FILE", help=tr("model or cloud in any supported format")
    )
    add_frame(model_parser)
    register_parser = add_action(
        "register",
        _register,
        tr(
            "Register a model using points, cameras, compass readings, known lines or another model"
        ),
    )
    register_parser.add_argument(
        "pairs",
        metavar="PAIRS",
        nargs="?",
        default=argparse.SUPPRESS,
        help=tr("table: label, model_x, model_y, model_z, x, y, z[, use, sigma_x, …]"),
    )
    picks_parser = add_action(
        "add-picks",
        _add_picks,
        tr("Add traces, lines or patches from a table of World points"),
    )
    picks_parser.add_argument("table", metavar="TABLE", help=tr("text table with x, y, z"))
    import_parser = add_action(
        "import", _import, tr("Add traces, planes, stations and areas from a file")
    )
    import_parser.add_argument(
        "file",
        metavar="FILE",
        help=tr("layers (gpkg, geojson, shp, dxf, kml), a table, or an export of another program"),
    )
    accept_parser = add_action(
        "accept", _accept, tr("Find facets or traces on a model and add them to the project")
    )
    proposals = accept_parser.add_subparsers(dest="proposals", metavar="PROPOSALS", required=True)
    for name, item in PROPOSALS.items():
        text = tr(
            "find {proposals} and add them to the project (options as in vomstudio {command})",
            proposals=name,
            command=item.command,
        )
        search_parser = proposals.add_parser(
            name,
            help=text,
            description=f"{text[:1].upper()}{text[1:]}.",
            argument_default=argparse.SUPPRESS,
        )
        add_shared_options(search_parser)
        add_options(search_parser, AcceptOptions)
        add_options(search_parser, item.options)
    set_parser = add_action("set", _set, tr("Change type, set, domain or name of features"))
    set_parser.add_argument("ids", metavar="ID", nargs="+", help=tr("ids or names of features"))
    delete_parser = add_action("delete", _delete, tr("Delete features"))
    delete_parser.add_argument("ids", metavar="ID", nargs="+", help=tr("ids or names of features"))
    fit_parser = add_action("fit", _fit, tr("Fit the features and assess their quality"))
    fit_parser.add_argument(
        "ids",
        metavar="ID",
        nargs="*",
        default=[],
        help=tr("ids or names of features (default: all)"),
    )
    add_action(
        "coverage", _report_coverage, tr("Report how much of each face with a grid was inspected")
    )
    report_parser = add_action(
        "report", _write_report, tr("Write a report with all results of the project")
    )
    add_output(report_parser, tr("HTML file"), is_required=True)
    report_parser.set_defaults(force=False)
    profile_parser = add_action(
        "profile", _set_profile, tr("Assess all features again with another verdict profile")
    )
    profile_parser.add_argument(
        "name",
        metavar="NAME",
        choices=["error", "textbook"],
        help=tr(
            "error: assess planes by their 95 %% error; textbook: by the shape of their points"
        ),
    )
    add_action(
        "update",
        _update,
        tr("Recompute the resolution and outcrop face of features measured with earlier versions"),
    )
    add_action("undo", _undo, tr("Undo the last step"))
    add_action("redo", _redo, tr("Redo the step that was undone last"))
    add_action(
        "verify", _verify, tr("Verify every row of the journal and every file of the project")
    )
    add_action(
        "repair",
        _repair,
        tr("Write a new journal without the damaged rows, and keep the old journal"),
    )
    add_action("compact", _compact, tr("Remove journal rows and files that are no longer used"))
    for action, options in ACTION_OPTIONS.items():
        if action != "accept":
            add_options(actions.choices[action], options)


def _run(args: argparse.Namespace, out: Output) -> None:
    try:
        args.act(args, out)
    except DocumentError as error:
        # Errors of a journal do not contain its folder.
        error.file = error.file or args.project
        raise


# --- queries ----------------------------------------------------------------------------------
def _list(args: argparse.Namespace, out: Output) -> None:
    summary = _summary(args)
    out.result(summary.to_dict())
    out.warn(summary.problems)
    out.text(_result_text(summary))


def _create(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.studio.headless_project import HeadlessProject

    with HeadlessProject.create(Path(args.project)) as project:
        out.warn(project.warnings)
    _report(args, out, {"created": args.project}, tr("created: {project}", project=args.project))


def _set(args: argparse.Namespace, out: Output) -> None:
    values = parse_options(args, FeatureValues)
    with _edit_project(args, out) as project:
        changed_features = project.set_values(args.ids, values)
    text = tr_n(
        "{count} feature was changed.", "{count} features were changed.", len(changed_features)
    )
    _report(args, out, {"changed": _id_and_name_rows(changed_features)}, text)


def _delete(args: argparse.Namespace, out: Output) -> None:
    with _edit_project(args, out) as project:
        deleted_features = project.delete(args.ids)
    text = tr_n(
        "{count} feature was deleted.", "{count} features were deleted.", len(deleted_features)
    )
    _report(args, out, {"deleted": _id_and_name_rows(deleted_features)}, text)


def _id_and_name_rows(features: Sequence[Feature]) -> list[dict[str, str]]:
    return [{"id": feature.id, "name": feature.name} for feature in features]


def _fit(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.studio.project_summary import table_orientations

    orientations = table_orientations(Path(args.project), args.ids)
    result = {
        "planes": [row for row in orientations.rows if row["element"] == "plane"],
        "lines": [row for row in orientations.rows if row["element"] == "line"],
        "skipped": list(orientations.skipped),
    }
    out.result({**_summary(args).to_dict(), **result})
    out.warn(
        [
            Finding("feature.left-out", feature=item["name"], reason=item["reason"])
            for item in orientations.skipped
        ]
    )
    lines = [_row_text(row) for row in orientations.rows]
    if any(row.get("quality") for row in orientations.rows):
        lines.append(orientations.limits.description)
    out.text("\n".join(lines) or tr("no features"))


def _report_coverage(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.products.fractures.summary import coverage_rows
    from vomstudio.studio.surfaces.grid_coverage import grid_shares

    with _edit_project(args, out, includes_save=False) as project:
        shares, findings = grid_shares(project)
    grids = [item.to_dict() for item in shares]
    out.result({**_summary(args).to_dict(), "grids": grids})
    out.warn(findings)
    lines = [line for g in shares for line in (g.name, *coverage_rows(g.coverage), "")]
    out.text("\n".join(lines).strip() or tr("no face has a grid"))


def _write_report(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.products.report.project import report_project

    report = report_project(
        Path(args.project), Path(args.output), force=args.force, progress=progress_reporter(args)
    )
    out.warn(
        [
            Finding("feature.left-out", feature=item["name"], reason=item["reason"])
            for item in report.skipped
        ]
    )
    text = tr(
        "{file}: {planes}, {lines}",
        file=args.output,
        planes=tr_n("{count} plane", "{count} planes", report.planes),
        lines=tr_n("{count} line", "{count} lines", report.lines),
    )
    _report(args, out, report.to_dict(), text)


def _verify(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.project.verify import verify

    verification = verify(Path(args.project))
    result = {
        "sound": verification.sound,
        "problems": list(verification.problems),
        "assets": verification.assets,
    }
    out.result({**_summary(args).to_dict(), **result})
    out.warn(verification.problems)
    # An invalid project is a failure for scripts as well.
    out.has_failed = not verification.sound
    text = (
        tr("intact")
        if verification.sound
        else tr_n("{count} problem", "{count} problems", len(verification.problems))
    )
    out.text(
        tr(
            "{project}: {steps}, {files}, {verdict}",
            project=args.project,
            steps=tr_n("{count} step", "{count} steps", verification.steps),
            files=tr_n("{count} file", "{count} files", verification.assets),
            verdict=text,
        )
    )


# --- changes ----------------------------------------------------------------------------------
def _add_model(args: argparse.Namespace, out: Output) -> None:
    with _edit_project(args, out) as project:
        added_model = project.add_model(Path(args.file), frame_options(args))
    out.warn(added_model.warnings)
    summary = {
        "model": added_model.model.id,
        "added": added_model.is_new,
        "warnings": list(added_model.warnings),
    }
    _report(args, out, summary, f"{added_model.model.name}: {added_model.model.frame.name()}")


def _register(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.cli.register import placement_text
    from vomstudio.studio.placing.registering import set_rotation_finding

    options = parse_options(args, PlacementOptions)
    with _edit_project(args, out) as project:
        model = project.find_model(options.model)
        registration_result = project.register(model, options)
    placement = registration_result.result.placed
    out.warn(placement.warnings)
    result = {
        "model": model.id,
        "turned_deg": registration_result.turned_deg,
        "sets_turned_deg": registration_result.sets_turned_deg,
        **registration_result.result.to_dict(),
    }
    turn_text = tr(
        "{model} was registered and rotated by {turn:.2f} degrees.",
        model=model.name,
        turn=registration_result.turned_deg,
    )
    sets_text = str(set_rotation_finding(registration_result.sets_turned_deg) or "")
    _report(
        args,
        out,
        result,
        "\n".join(filter(None, [placement_text(placement), turn_text, sets_text])),
    )


def _add_picks(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.io.gate.point_tables import read_points
    from vomstudio.io.gate.points import ModelFrame
    from vomstudio.io.gis.crs import world_crs
    from vomstudio.studio.headless_project import Picks

    options = parse_options(args, PickOptions)
    with _edit_project(args, out) as project:
        model, feature_type = project.find_model(options.model), project.find_type(options.type)
        world = world_crs(model.frame.crs, model.frame.unit_m)
        groups = read_points(args.table, options.by, model=ModelFrame(world)).groups
        names = groups.ids if options.by is not None else ("",)
        ends = zip(groups.offsets, groups.offsets[1:], strict=False)
        picks = [
            Picks(name, groups.points[start:stop], domain=options.domain or "")
            for name, (start, stop) in zip(names, ends, strict=True)
        ]
        added_picks = project.add_picks(
            picks, model, feature_type, options.set or "", options.shape
        )
    text = tr_n(
        "{count} feature on {model}",
        "{count} features on {model}",
        len(added_picks.features),
        model=model.name,
    )
    warnings = [*groups.warnings, *added_picks.warnings]
    _report_added(args, out, added_picks.features, added_picks.skipped, warnings, text)


def _import(args: argparse.Namespace, out: Output) -> None:
    with _edit_project(args, out) as project:
        model = project.find_model(parse_options(args, ModelChoice).model)
        import_result = project.import_features(Path(args.file), model)
    text = tr_n(
        "{count} feature on {model}",
        "{count} features on {model}",
        len(import_result.features),
        model=model.name,
    )
    _report_added(
        args,
        out,
        import_result.features,
        import_result.skipped,
        import_result.warnings,
        text,
    )


def _accept(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.studio.surfaces.headless_proposals import accept_proposals

    options = parse_options(args, AcceptOptions)
    search = parse_options(args, PROPOSALS[args.proposals].options)
    with _edit_project(args, out) as project:
        acceptance = accept_proposals(project, search, options, progress_reporter(args))
    out.warn(acceptance.warnings)
    text = tr_n(
        "{count} of {proposed} proposals was added.",
        "{count} of {proposed} proposals were added.",
        len(acceptance.features),
        proposed=acceptance.proposed,
    )
    result = {
        "added": _id_and_name_rows(acceptance.features),
        "proposed": acceptance.proposed,
        "warnings": list(acceptance.warnings),
    }
    _report(args, out, result, text)


def _set_profile(args: argparse.Namespace, out: Output) -> None:
    with _edit_project(args, out) as project:
        project.judge_by(args.name)
    _report(args, out, {"profile": args.name}, tr("profile: {profile}", profile=args.name))


def _update(args: argparse.Namespace, out: Output) -> None:
    with _edit_project(args, out) as project:
        updated_count, findings = project.update_surroundings()
    out.warn(findings)
    text = tr_n("updated: {count} feature", "updated: {count} features", updated_count)
    _report(args, out, {"updated": updated_count}, text)


def _undo(args: argparse.Namespace, out: Output) -> None:
    with _edit_project(args, out) as project:
        label = project.undo()
    _report(args, out, {"undone": label}, tr("undone: {step}", step=label))


def _redo(args: argparse.Namespace, out: Output) -> None:
    with _edit_project(args, out) as project:
        label = project.redo()
    _report(args, out, {"redone": label}, tr("redone: {step}", step=label))


def _repair(args: argparse.Namespace, out: Output) -> None:
    with _edit_project(args, out) as project:
        repair_result = project.project.repair()
    out.warn(repair_result.loss_findings)
    summary = {"kept": str(repair_result.backup), "lost": list(repair_result.loss_findings)}
    _report(
        args,
        out,
        summary,
        tr("repaired; the damaged journal is kept as {file}", file=repair_result.backup),
    )


def _compact(args: argparse.Namespace, out: Output) -> None:
    dry_run = parse_options(args, CompactOptions).dry_run
    with _edit_project(args, out, includes_save=not dry_run) as project:
        if not dry_run and project.session.dirty:
            project.session.save()
        plan = project.project.compaction()
        if not (dry_run or plan.is_empty):
            project.project.compact()
    summary = {
        "compacted": not (dry_run or plan.is_empty),
        "rows": plan.rows,
        "of_rows": plan.total_rows,
        "assets": list(plan.assets),
        "asset_bytes": plan.asset_bytes,
        "stages": list(plan.stages),
        "stage_bytes": plan.stage_bytes,
    }
    counts = {
        "rows": plan.rows,
        "all_rows": plan.total_rows,
        "files": tr_n("{count} file", "{count} files", len(plan.assets)),
        "stages": tr_n(
            "{count} earlier stage of reconstructions ({size:.1f} MB)",
            "{count} earlier stages of reconstructions ({size:.1f} MB)",
            len(plan.stages),
            size=plan.stage_bytes / 1e6,
        ),
    }
    text = (
        tr("would be removed: {rows} of {all_rows} rows, {files}, {stages}", **counts)
        if dry_run
        else tr("removed: {rows} of {all_rows} rows, {files}, {stages}", **counts)
    )
    _report(args, out, summary, text)


@contextmanager
def _edit_project(
    args: argparse.Namespace, out: Output, *, includes_save: bool = True
) -> Iterator[HeadlessProject]:
    """Yield the open project and, if `includes_save`, save it and its layers afterwards."""
    from vomstudio.studio.headless_project import HeadlessProject

    with HeadlessProject.open(Path(args.project), progress_reporter(args)) as project:
        out.warn(project.warnings)
        if project.is_recovered and includes_save:
            out.warn([Finding("project.recovered-and-saved")])
        yield project
        if includes_save:
            out.warn(project.save())


def _report(args: argparse.Namespace, out: Output, result: dict[str, Any], text: str) -> None:
    out.result({**_summary(args).to_dict(), **result})
    out.text(text)


def _report_added(
    args: argparse.Namespace,
    out: Output,
    features: Sequence[Feature],
    skipped_pairs: Sequence[tuple[str, Finding]],
    warnings: Sequence[Finding],
    text: str,
) -> None:
    skipped_findings = [
        Finding("feature.left-out", feature=name, reason=item) for name, item in skipped_pairs
    ]
    out.warn([*warnings, *skipped_findings])
    summary = {
        "added": _id_and_name_rows(features),
        "skipped": [{"id": name, "reason": reason} for name, reason in skipped_pairs],
        "warnings": list(warnings),
    }
    _report(args, out, summary, text)


# --- text -------------------------------------------------------------------------------------
def _summary(args: argparse.Namespace) -> ProjectSummary:
    from vomstudio.studio.project_summary import summarise

    return summarise(Path(args.project))


def _result_text(summary: ProjectSummary) -> str:
    def counts(numbers: dict[str, int]) -> str:
        return ", ".join(f"{name} {count}" for name, count in numbers.items())

    history = summary.history
    features = tr_n("{count} feature", "{count} features", summary.features)
    lines = [
        tr(
            "{project}: journal of schema {schema}, intact"
            if summary.sound
            else "{project}: journal of schema {schema}, damaged",
            project=summary.project,
            schema=summary.schema,
        ),
        *(
            tr_n(
                "model {model}: {kind}, {frame}, {count} feature",
                "model {model}: {kind}, {frame}, {count} features",
                m.features,
                model=m.name,
                kind=m.kind,
                frame=m.frame,
            )
            for m in summary.models
        ),
        f"{features}: {counts(summary.kinds)}" if summary.kinds else features,
    ]
    lines += [tr("types: {counts}", counts=counts(summary.types))] if summary.types else []
    lines += [tr("sets: {counts}", counts=counts(summary.sets))] if summary.sets else []
    lines += [tr("steps to undo: {undo}, to redo: {redo}", undo=history.undo, redo=history.redo)]
    lines += [tr("There are unsaved changes.")] if summary.unsaved else []
    lines += [tr("There is an unfinished feature.")] if summary.draft else []
    return "\n".join(lines)


def _row_text(row: dict[str, Any]) -> str:
    from vomstudio.cli.common import text_tables

    if row["element"] == "line":
        has_orientation, format_row = row.get("plunge_deg") is not None, text_tables.line_with_error
    else:
        has_orientation, format_row = row.get("dip_deg") is not None, text_tables.plane_with_error
    orientation_text = format_row(row) if has_orientation else "–"
    quality = f", {row['quality']}" if row.get("quality") else ""
    return f"{row['name']} ({row['kind']}): {orientation_text}{quality}"
