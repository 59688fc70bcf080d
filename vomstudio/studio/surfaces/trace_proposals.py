"""Traces of an open model as proposals.

Traces are computed in the background and assessed like picked traces. They are added to the
project only when they are accepted.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.signals import Signal
from vomstudio.core.words import tr
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.geology.profiles import Thresholds
from vomstudio.geometry import transform
from vomstudio.geometry.matrices import Point
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds import get_kind
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement import Measurement
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import SURROUNDINGS_RULE, FeatureType, Model, PickedFeature, Record
from vomstudio.studio.background import Background
from vomstudio.studio.editing import Editing
from vomstudio.studio.jobs.proposal_tasks import PROPOSE_TRACES, TracesRequest, TracesResult
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs
from vomstudio.studio.surfaces.model_jobs import ProposalQueue
from vomstudio.studio.tools.tool_context import Tool
from vomstudio.studio.tools.trace import TraceTool

T = TypeVar("T")

SAME_LINE_RESOLUTIONS = 3.0
"""Maximum distance between two lines that represent the same trace, in multiples of the resolution
of the model."""
MAX_OFFSET_RESOLUTIONS = 2.0
MAX_WAY_POINTS, MAX_VERTICES = 12, 60
"""Maximum number of way-points, which the user can drag, and of vertices if the line cannot be
followed between way-points."""


@dataclass(frozen=True, eq=False)
class ProposedLine:
    """Proposed trace with its measurement.

    Parameters
    ----------
    trace : Trace
        Trace without a name.
    points : (n, 3) float64
        Points in the World frame.
    measured : Measurement
    evidence, doubt : float
        See `extraction.proposals.traces.TraceProposal`.
    """

    trace: Trace
    points: FloatArray
    measured: Measurement
    length_m: float
    evidence: float
    doubt: float


@dataclass(frozen=True, eq=False)
class ProposedLines:
    """Proposed traces of a model, in order of decreasing reliability.

    `known` is the number of omitted lines, which follow a trace of the project or were rejected.
    """

    model_id: str
    to_world: object
    options: ProposalOptions
    result: TracesResult
    lines: tuple[ProposedLine, ...]
    known: int

    def provenance(self, code: str) -> str:
        """Describe the search for the notes of a trace that was accepted or edited."""
        length_m = self.result.least_length_m
        return Finding(code, cost=self.options.used_cost, length_m=length_m).message


class Tools(Protocol):
    """Protocol of the tools that are used for proposals."""

    changed: Signal[()]

    @property
    def active(self) -> Tool | None: ...

    def of(self, record_type: type[T]) -> T: ...

    def activate(self, name: str) -> None: ...

    def hint(self, message: Finding) -> None: ...


class TraceProposals(ProposalQueue[ProposedLines]):
    """Traces proposed on a model. `changed` is also emitted when `open_rows` changes."""

    def __init__(
        self,
        projects: Projects,
        editing: Editing,
        tools: Tools,
        jobs: Jobs,
        thresholds: Callable[[], Thresholds],
        background: Background,
    ) -> None:
        super().__init__(projects, jobs, background)
        self._editing, self._tools, self._thresholds = editing, tools, thresholds
        self._trace_ids: dict[int, str] = {}
        self._rejected_rows: set[int] = set()
        # Rejected lines in the file frames, kept until the program ends.
        self._rejected_lines: dict[str, list[FloatArray]] = {}
        self._previous_open_rows: frozenset[int] = frozenset()
        tools.changed.connect(self._update_measurement)

    @property
    def open_rows(self) -> frozenset[int]:
        """Indices of the undecided proposals.

        A proposal is decided while the trace tool or the project contains its trace.
        """
        if self.proposals is None:
            return frozenset()
        tool, records = self._tools.of(TraceTool), self._projects.records
        tool_id = None if tool.trace is None else tool.trace.id
        decided = {i for i, id_ in self._trace_ids.items() if id_ in records or id_ == tool_id}
        return frozenset(range(len(self.proposals.lines))) - decided - self._rejected_rows

    def count_rejected(self, model_id: str) -> int:
        """Return the number of rejected lines on a model, which are not proposed again."""
        return len(self._rejected_lines.get(model_id, ()))

    # --- search -------------------------------------------------------------------------------
    def find(self, model_id: str, options: ProposalOptions) -> None:
        """Search for lines, cancelling a running search."""
        self._cancel()
        model = self._model(model_id)
        if model is None:
            return
        placed_model, record = model
        known_lines = self._known_lines(model_id)

        def handle_result(result: TracesResult) -> None:
            records, thresholds = dict(self._projects.records), self._thresholds()
            self._read_in_background(
                lambda: assess_lines(record, options, result, known_lines, records, thresholds),
                self._show_lines,
            )

        order = TracesRequest(
            placed_model,
            # Lines that are already traces are ignored.
            replace(options, max_lines=options.max_lines + len(known_lines)),
            placed_model.cache / "proposed_traces" / f"{model_id}.npz",
        )
        self._submit(
            PROPOSE_TRACES, order, tr("Traces of {model}", model=record.name), handle_result
        )

    def _known_lines(self, model_id: str) -> list[FloatArray]:
        """Return lines that need not be proposed again, in the file frame of the model."""
        return [
            *known_lines(self._projects.records, model_id),
            *self._rejected_lines.get(model_id, ()),
        ]

    def _show_lines(self, proposals: ProposedLines) -> None:
        self.proposals, self._trace_ids, self._rejected_rows = proposals, {}, set()
        self._report()

    # --- decisions ----------------------------------------------------------------------------
    def accept(self, rows: Sequence[int], type_id: str, set_name: str = "") -> list[str]:
        """Add proposals to the project in one edit, and return the ids of the traces.

        The list is empty if the edit was rejected.
        """
        proposals, open_indices = self.proposals, self.open_rows
        accepted_rows = [row for row in rows if row in open_indices]
        if proposals is None or not accepted_rows:
            return []
        note = proposals.provenance("trace.accepted")
        traces = {
            row: replace(
                proposals.lines[row].trace,
                id=new_id("trace"),
                type_id=type_id,
                set_name=set_name,
                notes=note,
            )
            for row in accepted_rows
        }
        previous_ids = dict(self._trace_ids)
        # The edit must not trigger the listeners of this object.
        self._trace_ids.update({row: trace.id for row, trace in traces.items()})
        if not self._editing.attempt(edits.add_features, list(traces.values())):
            self._trace_ids = previous_ids
            return []
        self._notify_change()
        return [trace.id for trace in traces.values()]

    def edit(self, row: int) -> bool:
        """Open a proposal in the trace tool as a path through a few way-points.

        Returns False if the proposal is already decided, if another feature is open, or if the tool
        rejects the line.
        """
        proposals = self.proposals
        model = None if proposals is None else self._projects.records.get(proposals.model_id)
        if proposals is None or row not in self.open_rows or not isinstance(model, Model):
            return False
        tool = self._tools.of(TraceTool)
        self._tools.activate(tool.name)
        if self._tools.active is not tool or tool.is_open:
            self._tools.hint(Finding("feature.open"))
            return False
        line = proposals.lines[row]
        note = proposals.provenance("trace.edited")
        # The trace tool cannot follow the edges of a network.
        cost: str | None = proposals.options.used_cost
        maximum = MAX_WAY_POINTS
        if proposals.options.onnx_model is not None:
            cost, maximum = None, MAX_VERTICES
        trace_id = tool.begin_followed_trace(
            model, _select_way_points(line.trace, maximum), cost, note
        )
        if trace_id is not None:
            self._trace_ids[row] = trace_id
        self._notify_change()
        return trace_id is not None

    def reject(self, rows: Collection[int]) -> None:
        """Reject lines, which are not proposed again; the project does not change."""
        proposals = self.proposals
        if proposals is None:
            return
        for row in sorted(self.open_rows & set(rows)):
            line = np.asarray(proposals.lines[row].trace.vertices, np.float64)
            self._rejected_lines.setdefault(proposals.model_id, []).append(line)
            self._rejected_rows.add(row)
        self._notify_change()

    def restore_rejected(self, model_id: str) -> None:
        """Allow the rejected lines of a model to be proposed again."""
        self._rejected_lines.pop(model_id, None)
        if self.proposals is not None and self.proposals.model_id == model_id:
            self._rejected_rows.clear()
        self._notify_change()

    def _forget(self) -> None:
        """Clear the decisions; rejected lines are still not proposed again."""
        self._trace_ids, self._rejected_rows = {}, set()

    def _update_open(self, edit: Edit) -> None:
        self._update_measurement()

    def _update_measurement(self) -> None:
        if self._previous_open_rows != self.open_rows:
            self._notify_change()

    def _report(self, *findings: Finding) -> None:
        self.findings = findings
        self._notify_change()

    def _notify_change(self) -> None:
        self._previous_open_rows = self.open_rows
        self.changed.emit()


def _select_way_points(trace: Trace, maximum: int) -> tuple[Point, ...]:
    """Return up to `maximum` way-points of a proposed line for the trace tool."""
    from vomstudio.extraction.proposals.known_lines import simplify_line

    line = np.asarray(trace.vertices, np.float64)
    length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    offset = MAX_OFFSET_RESOLUTIONS * (trace.resolution or 0.01 * length)
    return tuple(trace.vertices[row] for row in simplify_line(line, offset, maximum).tolist())


def known_lines(records: Mapping[str, Record], model_id: str) -> list[FloatArray]:
    """Return the traces of a model in its file frame, which need not be proposed again.

    Parameters
    ----------
    records : mapping of str to Record
    model_id : str

    Returns
    -------
    list of ndarray of float
    """
    picked_features = [
        r for r in records.values() if isinstance(r, PickedFeature) and r.model_id == model_id
    ]
    traces = [feature for feature in picked_features if get_kind(feature).name == "trace"]
    return [np.asarray(trace.vertices, np.float64).reshape(-1, 3) for trace in traces]


def assess_lines(
    model: Model,
    options: ProposalOptions,
    result: TracesResult,
    known_arrays: list[FloatArray],
    records: dict[str, Any],
    thresholds: Thresholds,
) -> ProposedLines:
    """Read and assess traces. Runs in a worker thread.

    Raises
    ------
    OSError, ValueError, KeyError
        If the file of the traces has changed.
    """
    from vomstudio.extraction.proposals.known_lines import match_known_lines

    with open_arrays(result.out) as arrays:
        array_by_name = {name: arrays[name] for name in arrays.files}
    lines = [
        array_by_name["places"][a:b]
        for a, b in zip(array_by_name["cuts"][:-1], array_by_name["cuts"][1:], strict=True)
    ]
    spacing = array_by_name["resolution"][np.isfinite(array_by_name["resolution"])]
    lengths = array_by_name["length_m"] / transform.scale_factor(model.to_world)
    median = float(np.median(spacing)) if len(spacing) else 0.01 * float(lengths.max(initial=1.0))
    is_known = match_known_lines(lines, known_arrays, SAME_LINE_RESOLUTIONS * median)
    kinds = [r for r in records.values() if isinstance(r, FeatureType)]
    traces = list[Trace]()
    rows = list[int]()
    for row in range(result.count):
        if is_known[row] or len(rows) == options.max_lines:
            continue
        resolution, normal = (
            float(array_by_name["resolution"][row]),
            array_by_name["outcrop_normal"][row],
        )
        traces.append(
            Trace(
                f"proposal-{row}",
                "",
                kinds[0].id if kinds else "",
                model.id,
                model.content_hash,
                tuple(_to_tuple(p) for p in lines[row]),
                resolution=resolution if np.isfinite(resolution) else None,
                outcrop_normal=_to_tuple(normal) if np.isfinite(normal).all() else None,
                rule=SURROUNDINGS_RULE,
                axis="auto",
            )
        )
        rows.append(row)
    measurements = measure_all(records, traces, thresholds)
    proposed_lines = [
        ProposedLine(
            trace,
            transform.apply(model.to_world, lines[row]),
            figures,
            float(array_by_name["length_m"][row]),
            float(array_by_name["evidence"][row]),
            float(array_by_name["doubt"][row]),
        )
        for row, trace, figures in zip(rows, traces, measurements, strict=True)
    ]
    return ProposedLines(
        model.id, model.to_world, options, result, tuple(proposed_lines), sum(is_known)
    )


def _to_tuple(x: FloatArray) -> Point:
    return float(x[0]), float(x[1]), float(x[2])
