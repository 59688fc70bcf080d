"""Log along a line of a project on disk, with the beds stored in its record."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.beds.log_options import LogOptions
from vomstudio.geology.orientation import Plane
from vomstudio.products.section.line_log import LogQuestion, words_along
from vomstudio.project.exports.export import thresholds_of
from vomstudio.project.journal.database import read_replay
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import FeatureType, Logged, Record, get
from vomstudio.project.registration_errors import model_of
from vomstudio.project.repeated_features import first_picks


def read_log_question(
    folder: Path,
    line: str,
    *,
    of: str,
    type_name: str,
    bed: Plane | None,
    options: LogOptions,
    reach_m: float | None,
) -> LogQuestion:
    """Read the input of a log from a project folder.

    Parameters
    ----------
    folder : Path
    line : str
        Name or id of a trace, contact line or polyline.
    of, bed, options, reach_m
        As in `LogQuestion`.
    type_name : str
        Feature type of the traces that are used as boundaries.

    Returns
    -------
    LogQuestion

    Raises
    ------
    InputError
    """
    replay = read_replay(folder)
    records = replay.records
    line_points = _line(records, line, folder)
    traces = first_picks(_traces(records, type_name, folder), records)
    measurements = Measurements(thresholds_of(replay.settings)).of(
        records, [line_points.id, *(t.id for t in traces if t.id != line_points.id)]
    )
    model = model_of(records, line_points)
    return LogQuestion(
        line_points.id,
        measurements[line_points.id],
        of,
        {t.id: measurements[t.id] for t in traces},
        {t.id: t.name or t.id for t in traces},
        bed,
        options,
        reach_m,
        words_along(line_points),
        model is None or model.frame.has_metres,
        frozenset(t.id for t in traces if t.overturned),
    )


def _line(records: Mapping[str, Record], name: str, folder: Path) -> Logged:
    lines = [r for r in records.values() if isinstance(r, Logged) and len(r.vertices) > 1]
    matches = [r for r in lines if r.id == name] or [r for r in lines if r.name == name]
    if len(matches) == 1:
        return matches[0]
    described_names = [r.name for r in lines if r.beds]
    raise InputError(
        Finding("log.ambiguous-line", name=name)
        if matches
        else Finding("log.no-line", name=name, names=described_names or None),
        file=folder,
        field="--line",
    )


def _traces(records: Mapping[str, Record], name: str, folder: Path) -> list[Trace]:
    types = [r for r in records.values() if isinstance(r, FeatureType)]
    type_ids = {t.id for t in types if name.casefold() in (t.id.casefold(), t.name.casefold())}
    if not type_ids:
        names = [t.name for t in types]
        raise InputError(
            Finding("log.no-type", name=name, names=names), file=folder, field="--type"
        )
    traces = (get(records, id_, Trace) for id_ in records)
    return [trace for trace in traces if trace is not None and trace.type_id in type_ids]
