"""Options of followed, proposed and drawn traces, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import (
    MAX_LENGTH_M,
    MIN_LENGTH_M,
    Options,
    check_alternatives,
    check_requires,
    option,
)
from vomstudio.core.words import to_translate

ONNX_COST = "onnx"
"""Cost derived from the edges that a network detects."""
COST_TITLES = {
    "auto": to_translate("automatic"),
    "colour": to_translate("same colour"),
    "dark": to_translate("dark line"),
    "light": to_translate("light line"),
    "gradient": to_translate("brightness edge"),
    "curvature": to_translate("surface edge"),
    ONNX_COST: to_translate("network edges"),
}
"""Titles of the costs other than fields."""


def _cost_option(*suggestions: str) -> Any:
    return option(
        None,
        metavar="COST",
        label=to_translate("Follow"),
        help=to_translate(
            "property to follow: colour (of way-points), dark, light, gradient (brightness"
            " edges), curvature (surface edges), onnx (network edges), field name (low values),"
            " or auto (best plane)"
        ),
        tip=to_translate("Property that distinguishes the line from its surroundings"),
        automatic_text=to_translate("colour; gradient with --propose"),
        suggestions=suggestions,
        titles=tuple(COST_TITLES[cost] for cost in suggestions),
        empty_text="",
    )


@dataclass(frozen=True)
class TraceSource(Options):
    """Source of the lines: way-points, a drawing or automatic proposals.

    Raises
    ------
    UsageError
        If not exactly one source is given.
    """

    through: str | None = option(
        None,
        metavar="POINTS",
        help=to_translate(
            "follow a contact through two or more ordered way-points: a text table with x, y, z"
            " in World, or with column, row of a photo"
        ),
    )
    from_ortho: str | None = option(
        None,
        metavar="DRAWING",
        help=to_translate(
            "lines drawn on an orthophoto: GeoPackage, GeoJSON, shapefile, SVG or DXF"
        ),
    )
    propose: bool = option(
        False,
        help=to_translate(
            "list lines that stand out from the noise of the surface, the most certain first"
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_alternatives(self, "through", "from_ortho", "propose")


@dataclass(frozen=True)
class CostOptions(Options):
    """Cost for following or proposing lines.

    Raises
    ------
    UsageError
        If a network is given without the cost ``onnx``, or this cost without a network.
    """

    cost: str | None = _cost_option(*COST_TITLES)
    onnx_model: str | None = option(
        None,
        metavar="FILE",
        help=to_translate(
            "with --cost onnx: a network that returns the edge probability of each pixel"
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.onnx_model is not None and self.cost != ONNX_COST:
            raise UsageError(Finding("edges.network-unused"), field="--onnx-model")
        if self.onnx_model is None and self.cost == ONNX_COST:
            raise UsageError(
                Finding("edges.no-network", option="--onnx-model"), field="--onnx-model"
            )


@dataclass(frozen=True)
class FollowOptions(CostOptions):
    """Cost and photo for following a trace between way-points.

    Raises
    ------
    UsageError
        See `CostOptions`; also if cameras are given without a photo.
    """

    cost: str | None = _cost_option("auto", "colour", "dark", "light", "gradient", "curvature")
    photo: str | None = option(
        None, metavar="PHOTO", help=to_translate("follow the contact in this photo of the model")
    )
    cameras: str | None = option(
        None,
        metavar="FILE",
        help=to_translate(
            "camera poses and lenses in the frame of the model file, from any program listed in"
            " docs/photos.md"
        ),
        automatic_text=to_translate("next to the model"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_requires(self, "cameras", "photo")

    @property
    def used_cost(self) -> str:
        """Effective cost: the given cost, or "colour"."""
        return self.cost or "colour"


@dataclass(frozen=True)
class ProposalOptions(CostOptions):
    """Thresholds of proposed traces.

    Raises
    ------
    UsageError
        See `CostOptions`; also if a value is outside its bounds, or if the cost requires
        way-points.
    """

    cost: str | None = _cost_option("dark", "light", "gradient", "curvature", ONNX_COST)
    min_length_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Length"),
        help=to_translate("minimum length of a proposed line, m"),
        tip=to_translate("Minimum length of a line"),
        automatic_text=to_translate("20 times the model resolution"),
    )
    max_lines: int = option(
        50,
        minimum=1,
        label=to_translate("Maximum"),
        help=to_translate("maximum number of proposed lines"),
        tip=to_translate("Maximum number of lines (strongest first)"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.cost in ("colour", "auto"):
            raise UsageError(Finding("cost.needs-way-points", cost=self.cost), field="--cost")

    @property
    def used_cost(self) -> str:
        """Effective cost: the given cost, or "gradient"."""
        return self.cost or "gradient"


@dataclass(frozen=True)
class DrawnTraceOptions(Options):
    """Options of traces drawn on an orthophoto, and the project to which they are added.

    Raises
    ------
    UsageError
        If the step is outside its bounds, or if project options are given without a project.
    """

    sidecar: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("NAME.json written with the orthophoto"),
    )
    step_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        help=to_translate("maximum distance between points along a line, m"),
        automatic_text=to_translate("the vertices only"),
    )
    into: str | None = option(
        None,
        metavar="PROJECT",
        help=to_translate("also add the lines to this project as traces, in one step"),
    )
    type: str | None = option(
        None,
        metavar="TYPE",
        help=to_translate("feature type of the lines in the project"),
        automatic_text=to_translate("the name of each layer"),
    )
    on: str | None = option(
        None,
        metavar="NAME",
        help=to_translate("project model on which the lines were drawn"),
        automatic_text=to_translate("the only model"),
    )
    set: str | None = option(
        None,
        metavar="SET",
        help=to_translate("set of the lines"),
        automatic_text=to_translate("from the column “set”"),
    )
    update: bool = option(
        False,
        help=to_translate("update project traces that were edited in the drawing"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("type", "on", "set", "update"):
            check_requires(self, name, "into")
