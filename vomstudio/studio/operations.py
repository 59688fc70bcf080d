"""Table of the program's operations.

A new operation needs an options class beside its computation, and an entry in this table.
Parsers, forms, copied commands, the option tables of the documentation and the checks of the
Python interface are derived from it.
"""

from __future__ import annotations

from vomstudio.core.operations import Interface, Operation
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.measurable_options import MeasurableOptions, MeasurableTarget
from vomstudio.extraction.trace_options import (
    DrawnTraceOptions,
    FollowOptions,
    ProposalOptions,
    TraceSource,
)
from vomstudio.geology.beds.log_options import LogLine, LogOptions
from vomstudio.geology.coverage.repeat_options import RepeatOptions
from vomstudio.geology.faults.displacement_options import DisplacementOptions, ThreePointOptions
from vomstudio.geology.fold_options import FoldOptions
from vomstudio.geology.fractures.fracture_options import FractureOptions
from vomstudio.geology.populations.statistics_options import StatisticsOptions
from vomstudio.geology.rose_options import RoseOptions
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.geology.slope_options import SlopeFaces, SlopeOptions
from vomstudio.photogrammetry.survey.survey_options import (
    CheckOptions,
    CheckScene,
    PlanOptions,
    VideoFrameOptions,
)
from vomstudio.products.elevation.dem_options import DemFiles, DemOptions
from vomstudio.products.net.figure_options import (
    RoseFigure,
    SetColors,
    StereonetFigure,
    StereonetOptions,
)
from vomstudio.products.ortho.ortho_options import OrthoDrawing, OrthoOptions
from vomstudio.products.sample.demo_options import DemoOptions
from vomstudio.products.section.extend_options import ExtendOptions
from vomstudio.products.section.section_options import SectionFeatures, SectionOptions
from vomstudio.products.surface.surface_options import SurfaceOptions
from vomstudio.project.exports.export_options import ExportFormat
from vomstudio.project.tables.fit_options import FitOptions, FitTogether
from vomstudio.registration.distances.compare_options import CompareOptions
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions

_MODEL_COMMAND_REASONS: dict[Interface, str] = {
    "project method": "the function takes a model of a project",
    "project command": "`--project` of the command places the model",
}

_FILE_COMMAND_REASONS: dict[Interface, str] = {
    "project method": "the command reads files, not a project",
    "project command": "the command reads files, not a project",
}

_TABLE_COMMAND_REASONS: dict[Interface, str] = {
    "project method": "the function takes the planes of a project",
    "project command": "the command reads an exported table",
}

_PHOTO_COMMAND_REASONS: dict[Interface, str] = {
    "project method": "a project needs no photos before the reconstruction",
    "project command": "the command reads photos, not a project",
}

OPERATIONS: tuple[Operation, ...] = (
    Operation(
        "plan",
        (PlanOptions,),
        function="plan",
        window="dialogs.planner.planner_dialog.PlannerDialog",
        missing=_PHOTO_COMMAND_REASONS,
    ),
    Operation(
        "check",
        (CheckOptions,),
        command_options=(CheckScene,),
        function="check",
        window="panels.photos.photos_panel.PhotosPanel",
        missing=_PHOTO_COMMAND_REASONS,
    ),
    Operation(
        "frames",
        command_options=(VideoFrameOptions,),
        window="dialogs.video_dialog.VideoDialog",
        missing=_PHOTO_COMMAND_REASONS
        | {"function": "`vs.check` and `vs.reconstruct` take the folder"},
    ),
    Operation(
        "facets",
        (FacetOptions,),
        function="facets",
        window="panels.surface.facets_panel.FacetsPanel",
        method="accept_facets",
        action="accept",
    ),
    Operation(
        "dem",
        (DemOptions,),
        command_options=(DemFiles,),
        function="dem",
        window="panels.sections.elevation_panel.ElevationPanel",
        missing=_MODEL_COMMAND_REASONS,
    ),
    Operation(
        "section",
        (SectionOptions,),
        command_options=(SectionFeatures,),
        function="section",
        window="panels.sections.section_panel.SectionPanel",
        missing=_MODEL_COMMAND_REASONS,
    ),
    Operation(
        "reconstruct",
        (ReconstructOptions,),
        function="reconstruct",
        window="dialogs.reconstruct_dialog.ReconstructDialog",
        missing={
            "project method": "`Project.add_model` takes the model",
            "project command": "`add-model` takes the model",
        },
    ),
    Operation(
        "register",
        (RegisterOptions,),
        function="register",
        window="panels.tools.control.ControlPanel",
        method="register",
        action="register",
    ),
    Operation(
        "compare",
        (CompareOptions,),
        function="compare",
        window="panels.comparison.compare_panel.ComparePanel",
        missing=_MODEL_COMMAND_REASONS,
    ),
    Operation(
        "measurable",
        (MeasurableOptions,),
        command_options=(MeasurableTarget,),
        function="measurable",
        window="panels.surface.fields_panel.FieldsPanel",
        missing=_MODEL_COMMAND_REASONS,
    ),
    Operation(
        "sets",
        (SetOptions,),
        function="sets",
        window="panels.sets.sets_panel.SetsPanel",
        missing={
            "project method": "`vs.sets` takes the planes of a project",
            "project command": "`set` writes the sets of features",
        },
    ),
    Operation(
        "repeats",
        (RepeatOptions,),
        function="repeats",
        window="panels.repeatability_panel.RepeatsPanel",
        missing={
            "project method": "`vs.repeats` takes the folder of a project",
            "project command": "`repeats` reads a project",
        },
    ),
    Operation(
        "slip",
        function="slip",
        missing=_TABLE_COMMAND_REASONS | {"window": "the net shows the axes of each fault"},
    ),
    Operation(
        "fractures",
        (FractureOptions,),
        function="fractures",
        window="panels.fractures.fractures_panel.FracturesPanel",
        missing={
            "project method": "`vs.fractures` takes the traces of a project",
            "project command": "`fractures` reads the exported traces",
        },
    ),
    Operation(
        "fit",
        (FitOptions,),
        command_options=(FitTogether,),
        function="fit_planes",
        method="fit",
        action="fit",
        missing={"window": "planes are fitted while they are picked"},
    ),
    Operation(
        "stats",
        (StatisticsOptions,),
        function="stats",
        window="panels.statistics.statistics_panel.StatisticsPanel",
        missing={
            "project method": "`vs.stats` takes the planes of a project",
            "project command": "`stats` reads a project",
        },
    ),
    Operation(
        "fold",
        (FoldOptions,),
        function="fold",
        window="widgets.fold_box.FoldBox",
        missing={
            "project method": "`vs.fold` takes the planes of a project",
            "project command": "`fold` reads a project",
        },
    ),
    Operation(
        "slope",
        (SlopeOptions,),
        command_options=(SlopeFaces,),
        function="slope",
        window="panels.slopes.slopes_panel.SlopesPanel",
        missing={
            "project method": "`vs.slope` takes the planes of a project",
            "project command": "`slope` reads a project",
        },
    ),
    Operation(
        "threepoint",
        (ThreePointOptions,),
        function="threepoint",
        window="panels.three_points_panel.ThreePointsPanel",
        missing={
            "project method": "`vs.threepoint` takes points of a project",
            "project command": "`threepoint` reads a table of points",
        },
    ),
    Operation(
        "displacement",
        (DisplacementOptions,),
        function="displacement",
        window="panels.displacement_panel.DisplacementPanel",
        missing={
            "project method": "`vs.displacement` takes cut-offs of a project",
            "project command": "`displacement` reads a table of cut-offs",
        },
    ),
    Operation(
        "log",
        (LogOptions,),
        command_options=(LogLine,),
        function="log",
        window="panels.logs.log_panel.BedLogPanel",
        missing={
            "project method": "`vs.log` takes boundaries of a project",
            "project command": "`log` reads a project",
        },
    ),
    Operation(
        "extend",
        (ExtendOptions,),
        function="extend",
        window="dialogs.extended_plane_dialog.ExtendDialog",
        missing=_MODEL_COMMAND_REASONS
        | {"project command": "the command extends planes of tables"},
    ),
    Operation(
        "surface",
        (SurfaceOptions,),
        function="surface",
        window="dialogs.surface_dialog.SurfaceDialog",
        missing=_MODEL_COMMAND_REASONS
        | {"project command": "the command reads the patch as a model"},
    ),
    Operation(
        "trace",
        (FollowOptions,),
        command_options=(TraceSource, DrawnTraceOptions),
        function="follow",
        window="widgets.follow_box.FollowBox",
        missing=_MODEL_COMMAND_REASONS
        | {"project command": "`trace --into` adds drawn lines to a project"},
    ),
    Operation(
        "propose traces",
        (ProposalOptions,),
        function="propose_traces",
        command="trace",
        window="panels.surface.traces_panel.TracesPanel",
        method="accept_traces",
        action="accept",
    ),
    Operation(
        "stereonet",
        (StereonetOptions, StereonetFigure),
        command_options=(SetColors,),
        function="stereonet",
        window="panels.net.stereonet_panel.StereonetPanel",
        missing=_TABLE_COMMAND_REASONS | {"project command": "`stereonet` reads a project"},
    ),
    Operation(
        "rose",
        (RoseOptions,),
        command_options=(RoseFigure, SetColors),
        function="rose",
        window="panels.net.stereonet_panel.StereonetPanel",
        missing=_TABLE_COMMAND_REASONS | {"project command": "`rose` reads a project"},
    ),
    Operation(
        "info",
        missing=_FILE_COMMAND_REASONS
        | {
            "function": "`vs.read` returns what the file contains",
            "window": "the outline shows what a model contains",
        },
    ),
    Operation(
        "convert",
        window="commands.project_files.Files",
        missing=_FILE_COMMAND_REASONS | {"function": "`vs.read` and `.save` of a model"},
    ),
    Operation(
        "export",
        command_options=(ExportFormat,),
        window="commands.project_files.Files",
        method="export",
        missing={
            "function": "`Project.export` is a method",
            "project command": "`export` reads a project",
        },
    ),
    Operation(
        "report",
        command="project",
        method="report",
        action="report",
        missing={
            "function": "`Project.report` is a method",
            "window": "the panels show all figures",
        },
    ),
    Operation(
        "demo",
        command_options=(DemoOptions,),
        missing=_FILE_COMMAND_REASONS
        | {"function": "`vs.sample` returns the files", "window": "*Open sample outcrop*"},
    ),
    Operation(
        "ortho",
        (OrthoOptions,),
        command_options=(OrthoDrawing,),
        function="orthophoto",
        window="dialogs.orthophoto_dialog.OrthoDialog",
        missing=_MODEL_COMMAND_REASONS,
    ),
)
