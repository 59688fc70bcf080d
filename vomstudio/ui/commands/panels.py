"""The commands that bring a panel of Analyse, or of Views and export, forward."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds import kind_of
from vomstudio.project.records import Picked, Typed
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import why_no_model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks, WorkspaceSwitcher


def commands(studio: Studio, workspaces: WorkspaceSwitcher, docks: Docks) -> list[Command]:
    def no_model() -> Finding | None:
        return why_no_model(studio)

    def no_lines() -> Finding | None:
        if any(kind_of(f).layer is not None for f in studio.session.of(Picked)):
            return None
        return Finding("traces.none")

    def no_planes() -> Finding | None:
        if any(kind_of(f).net is not None for f in studio.session.of(Typed)):
            return None
        return Finding("planes.none")

    def bring(workspace: str, dock: str) -> Callable[[], None]:
        def show() -> None:
            workspaces.switch(workspace)
            docks.bring_forward(dock)

        return show

    def propose_sets() -> None:
        count("sets")()
        studio.sets_wanted.emit()

    make = partial(bring, "views")
    count = partial(bring, "analyse")
    return [
        Command(
            "propose_sets",
            tr("Propose &sets…"),
            propose_sets,
            "scatter-plot-outline",
            (),
            tr("Sort planes into sets, see them on the net, and accept or reject the proposal."),
            no_planes,
        ),
        Command(
            "elevation_model",
            tr("&Elevation model…"),
            make("elevation"),
            "image-filter-hdr",
            (),
            tr("Heights over a horizontal, vertical or slanting plane, as GeoTIFF."),
            no_model,
        ),
        Command(
            "section",
            tr("Se&ction…"),
            make("section"),
            "box-cutter",
            (),
            tr("Cut the model along a plane or a line, with the features beside it."),
            no_model,
        ),
        Command(
            "count_fractures",
            tr("F&ractures…"),
            count("fractures"),
            "grid",
            (),
            tr(
                "Number, length, nodes and spacing of traces along a line, in a circle or in a "
                "window."
            ),
            no_lines,
        ),
        Command(
            "looked_at",
            tr("What was &looked at…"),
            count("looked_at"),
            "grid",
            (),
            tr("Lay a grid over the face and mark its cells as done, empty or unmeasurable."),
            no_model,
        ),
        Command(
            "repeats",
            tr("Picks a&gain…"),
            count("repeats"),
            "replay",
            (),
            tr(
                "Offer some picks for a second time, unseen, and compare the spread with the "
                "stated errors."
            ),
            no_lines,
        ),
        Command(
            "fault_displacement",
            tr("Fault &displacement…"),
            count("displacement"),
            "arrow-split-horizontal",
            (),
            tr("Net slip, throw and heave from cut-off traces on both sides of a fault."),
            no_lines,
        ),
        Command(
            "three_points",
            tr("T&hree points…"),
            bring("interpret", "three_points"),
            "vector-triangle",
            (),
            tr("The plane through three points or more, clicked or typed, with its error."),
        ),
        Command(
            "bed_log",
            tr("&Log along a line…"),
            make("bed_log"),
            "layers-triple-outline",
            (),
            tr("Boundaries of beds along a line, and the true thickness between them."),
            no_model,
        ),
    ]
