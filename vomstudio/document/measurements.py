"""World coordinates and judged fits of the features, each worked out once per revision."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.document.records import Model, Record, Trace
from vomstudio.errors import GeometryError
from vomstudio.geology.quality import Thresholds, Verdict, judge
from vomstudio.geometry import transform
from vomstudio.geometry.planes import PlaneFit, fit_planes


@dataclass(frozen=True, eq=False)
class Measurement:
    """What a trace says, in World.

    points : (n, 3) float64. resolution_m and outcrop_normal are the trace's own, in World.
    fit and verdict are None where no plane can be fitted, and `problem` says why.
    """

    points: npt.NDArray[np.float64]
    resolution_m: float | None
    outcrop_normal: npt.NDArray[np.float64] | None
    fit: PlaneFit | None
    verdict: Verdict | None
    problem: str | None


class Measurements:
    """Measurements of a document's traces, kept as long as trace and model stay what they are."""

    def __init__(self, thresholds: Thresholds | None = None) -> None:
        self._thresholds = thresholds or Thresholds()
        self._kept: dict[str, tuple[Trace, Model | None, Measurement]] = {}

    def of(self, records: Mapping[str, Record], ids: Iterable[str]) -> dict[str, Measurement]:
        """The measurements of those `ids` that are traces; new ones are fitted in one batch."""
        traces = [r for i in ids if isinstance(r := records.get(i), Trace)]
        models = [_model(records, trace) for trace in traces]
        new = [
            (trace, model)
            for trace, model in zip(traces, models, strict=True)
            if (kept := self._kept.get(trace.id)) is None
            or kept[0] is not trace
            or kept[1] is not model
        ]
        for (trace, model), measurement in zip(new, measure(new, self._thresholds), strict=True):
            self._kept[trace.id] = (trace, model, measurement)
        return {trace.id: self._kept[trace.id][2] for trace in traces}

    def forget_all_but(self, records: Mapping[str, Record]) -> None:
        for id_ in [i for i in self._kept if i not in records]:
            del self._kept[id_]


def measure(
    traces: list[tuple[Trace, Model | None]], thresholds: Thresholds | None = None
) -> list[Measurement]:
    """Fit and judge traces in World, all in one batch."""
    if not traces:
        return []
    thresholds = thresholds or Thresholds()
    points = [world_points(trace, model) for trace, model in traces]
    offsets = np.concatenate([[0], np.cumsum([len(p) for p in points])])
    fits: list[tuple[PlaneFit | None, str | None]] = [(None, None)] * len(traces)
    for method in ("pca", "regression"):
        chosen = [i for i, (trace, _) in enumerate(traces) if trace.method == method]
        if not chosen:
            continue
        batch = fit_planes(
            np.concatenate([points[i] for i in chosen]),
            np.concatenate([[0], np.cumsum([len(points[i]) for i in chosen])]),
            method=method,
        )
        for row, i in enumerate(chosen):
            problem = batch.error[row]
            fits[i] = (None, problem) if problem else (batch[row], None)
    result = []
    for (trace, model), (fit, problem), i in zip(
        traces, fits, range(len(offsets) - 1), strict=True
    ):
        rows = _rows(model)
        resolution = (
            None if trace.resolution is None else trace.resolution * transform.scale_of(rows)
        )
        face = (
            None
            if trace.outcrop_normal is None
            else transform.rotate(rows, [trace.outcrop_normal])[0]
        )
        verdict = (
            None
            if fit is None
            else judge(fit, resolution_m=resolution, outcrop_normal=face, thresholds=thresholds)
        )
        result.append(Measurement(points[i], resolution, face, fit, verdict, problem))
    return result


def measure_one(
    trace: Trace, model: Model | None, thresholds: Thresholds | None = None
) -> Measurement:
    """A batch of one; raises GeometryError where no plane can be fitted."""
    measurement = measure([(trace, model)], thresholds)[0]
    if measurement.problem is not None:
        raise GeometryError(measurement.problem, field=trace.name or None)
    return measurement


def world_points(trace: Trace, model: Model | None) -> npt.NDArray[np.float64]:
    """(n, 3) vertices of a trace in World; in the file frame where its model is gone."""
    return transform.apply(_rows(model), np.asarray(trace.vertices, dtype=np.float64))


def _model(records: Mapping[str, Record], trace: Trace) -> Model | None:
    model = records.get(trace.model_id)
    return model if isinstance(model, Model) else None


def _rows(model: Model | None) -> npt.NDArray[np.float64]:
    return np.eye(4) if model is None else transform.matrix(model.to_world)
