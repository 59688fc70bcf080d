"""The operations of the program.

A new operation gets an options class beside its computation and an entry here; parsers, forms,
copied commands, option tables of the documentation and the checks of the Python interface follow.
"""

from __future__ import annotations

from vomstudio.core.operations import Door, Operation
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.measurable_options import MeasurableOptions, MeasurableTarget
from vomstudio.products.elevation.dem_options import DemFiles, DemOptions
from vomstudio.products.section.section_options import SectionFeatures, SectionOptions
from vomstudio.registration.distances.compare_options import CompareOptions

_OF_MODELS: dict[Door, str] = {
    "project method": "the function takes a model of a project",
    "project command": "`--project` of the command places the model",
}

OPERATIONS: tuple[Operation, ...] = (
    Operation(
        "facets",
        (FacetOptions,),
        function="facets",
        window="surface.facets_panel.FacetsPanel",
        missing={
            "project method": "`vs.facets` takes a model of a project",
            "project command": "`facets --project` places the model; `accept` adds the facets",
        },
    ),
    Operation(
        "dem",
        (DemOptions,),
        command_options=(DemFiles,),
        function="dem",
        window="sections.elevation_panel.ElevationPanel",
        missing=_OF_MODELS,
    ),
    Operation(
        "section",
        (SectionOptions,),
        command_options=(SectionFeatures,),
        function="section",
        window="sections.section_panel.SectionPanel",
        missing=_OF_MODELS,
    ),
    Operation(
        "compare",
        (CompareOptions,),
        function="compare",
        window="registration.compare_panel.ComparePanel",
        missing=_OF_MODELS,
    ),
    Operation(
        "measurable",
        (MeasurableOptions,),
        command_options=(MeasurableTarget,),
        function="measurable",
        window="surface.fields_panel.FieldsPanel",
        missing=_OF_MODELS,
    ),
)
