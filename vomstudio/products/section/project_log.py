"""Log along a line of a project on disk, with the beds stored in its record."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.beds.log_options import LogOptions
from vomstudio.geology.orientation import Plane
from vomstudio.products.section.line_log import LogRequest, read_rock_descriptions
from vomstudio.project.exports.export import get_thresholds
from vomstudio.project.journal.database import read_replay
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import FeatureType, LoggedFeature, Record, get
from vomstudio.project.registration_errors import get_model
from vomstudio.project.repeated_features import first_picks


def read_log_request(
    folder: Path,
    line: str,
    *,
    of: str,
    type_name: str,
    bed: Plane | None,
    options: LogOptions,
    reach_m: float | None,
) -> LogRequest:
    """Read the input of a log from a project folder.

    Parameters
    ----------
    folder : Path
    line : str
        Name or id of a trace, contact line or polyline.
    of, bed, options, reach_m
        As in `LogRequest`.
    type_name : str
        Feature type of the traces that are used as boundaries.

    Returns
    -------
    LogRequest

    Raises
    ------
    InputError
        If the folder is not a project, or if the line or the type is unknown or ambiguous.
    """
    replay = read_replay(folder)
    records = replay.records
    line_record = _line(records, line, folder)
    traces = first_picks(_traces(records, type_name, folder), records)
    measurements = Measurements(get_thresholds(replay.settings)).of(
        records, [line_record.id, *(trace.id for trace in traces if trace.id != line_record.id)]
    )
    model = get_model(records, line_record)
    return LogRequest(
        line_record.id,
        measurements[line_record.id],
        of,
        {trace.id: measurements[trace.id] for trace in traces},
        {trace.id: trace.name or trace.id for trace in traces},
        bed,
        options,
        reach_m,
        read_rock_descriptions(line_record),
        model is None or model.frame.has_metres,
        frozenset(trace.id for trace in traces if trace.overturned),
    )


def _line(records: Mapping[str, Record], name: str, folder: Path) -> LoggedFeature:
    lines = [
        record
        for record in records.values()
        if isinstance(record, LoggedFeature) and len(record.vertices) > 1
    ]
    matches = [line for line in lines if line.id == name] or [
        line for line in lines if line.name == name
    ]
    if len(matches) == 1:
        return matches[0]
    described_names = [line.name for line in lines if line.beds]
    raise InputError(
        Finding("log.ambiguous-line", name=name)
        if matches
        else Finding("log.no-line", name=name, names=described_names or None),
        file=folder,
        field="--line",
    )


def _traces(records: Mapping[str, Record], name: str, folder: Path) -> list[Trace]:
    types = [record for record in records.values() if isinstance(record, FeatureType)]
    type_ids = {
        type_.id
        for type_ in types
        if name.casefold() in (type_.id.casefold(), type_.name.casefold())
    }
    if not type_ids:
        names = [type_.name for type_ in types]
        raise InputError(
            Finding("log.no-type", name=name, names=names), file=folder, field="--type"
        )
    traces = (get(records, id_, Trace) for id_ in records)
    return [trace for trace in traces if trace is not None and trace.type_id in type_ids]
