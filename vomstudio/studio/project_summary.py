"""Summary of a project's contents; the project may be open in a window."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.results import Result
from vomstudio.geology.profiles import Thresholds
from vomstudio.project.exports.export import get_thresholds
from vomstudio.project.journal.database import read_replay, read_schema_and_replay
from vomstudio.project.kinds import get_kind
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, FeatureType, Model, Record, TypedFeature
from vomstudio.project.tables.orientation_table import Row
from vomstudio.project.tables.project_table import project_table


@dataclass(frozen=True)
class ModelSummary:
    """Summary of a model; `features` is the number of features on it."""

    id: str
    name: str
    path: str
    kind: str
    frame: str
    crs: str | None
    features: int


@dataclass(frozen=True)
class HistorySummary:
    """Number of steps that can be undone and redone, and the labels of the next steps."""

    undo: int
    redo: int
    undo_label: str | None
    redo_label: str | None


@dataclass(frozen=True)
class ProjectSummary(Result):
    """Summary of a project.

    Parameters
    ----------
    features : int
        Number of features of all kinds.
    kinds, types, sets : dict of str to int
        Number of features of each kind, feature type and set.
    sound : bool
        Whether every row of the journal is valid; otherwise `problems` contains the errors.
    unsaved : bool
        Whether there are changes since the last save.
    draft : bool
        Whether there is an unfinished feature.
    """

    project: str
    schema: int
    sound: bool
    problems: tuple[Finding, ...]
    models: tuple[ModelSummary, ...]
    features: int
    kinds: dict[str, int]
    types: dict[str, int]
    sets: dict[str, int]
    history: HistorySummary
    unsaved: bool
    draft: bool


def summarise(folder: Path) -> ProjectSummary:
    """Summarise a project. Raises InputError if it is not a project or is too new."""
    schema, replay = read_schema_and_replay(folder)
    records = replay.records
    features = [r for r in records.values() if isinstance(r, Feature)]
    typed_features = [f for f in features if isinstance(f, TypedFeature)]
    names = {r.id: r.name for r in records.values() if isinstance(r, FeatureType)}
    return ProjectSummary(
        project=str(folder),
        schema=schema,
        sound=not replay.problems,
        problems=tuple(replay.problems),
        models=summarise_models(records),
        features=len(features),
        kinds=dict(Counter(get_kind(f).name for f in features)),
        types=dict(Counter(names.get(f.type_id, f.type_id) for f in typed_features)),
        sets=dict(Counter(f.set_name for f in typed_features if f.set_name)),
        history=HistorySummary(
            max(len(replay.done) - 1, 0),
            len(replay.undone),
            replay.done[-1][1].label if len(replay.done) > 1 else None,
            replay.undone[-1][1].label if replay.undone else None,
        ),
        unsaved=replay.top != replay.saved_top,
        draft=replay.draft is not None,
    )


def summarise_models(records: Mapping[str, Record]) -> tuple[ModelSummary, ...]:
    """Describe the models of a project, in the order in which they were added."""
    features_by_model = Counter(
        getattr(f, "model_id", None) for f in records.values() if isinstance(f, Feature)
    )
    return tuple(
        ModelSummary(
            m.id, m.name, m.path, m.kind, m.frame.name(), m.frame.crs, features_by_model[m.id]
        )
        for m in records.values()
        if isinstance(m, Model)
    )


@dataclass(frozen=True)
class ProjectOrientations:
    """Orientation table of a project.

    Parameters
    ----------
    rows : tuple of Row
    skipped : tuple of dict
        Id, name and reason of each feature without an orientation.
    limits : Thresholds
        Thresholds of the verdicts.
    """

    rows: tuple[Row, ...]
    skipped: tuple[dict[str, Any], ...]
    limits: Thresholds


def table_orientations(folder: Path, names: Sequence[str] = ()) -> ProjectOrientations:
    """Return the orientations of features as shown in the table of the window.

    Parameters
    ----------
    folder : Path
        Folder of the project.
    names : sequence of str
        Ids or names, by default all features.

    Raises
    ------
    InputError
        If no feature has one of the names.
    """
    replay = read_replay(folder)
    return fitted_records(
        replay.records, Measurements(get_thresholds(replay.settings)), folder, names
    )


def fitted_records(
    records: Mapping[str, Record],
    measurements: Measurements,
    folder: Path,
    names: Sequence[str] = (),
) -> ProjectOrientations:
    """Return the orientations of features in an open project. Raises InputError."""
    ids = matching_ids(records.values(), names, folder) if names else None
    table = project_table(records, measurements)
    rows = [row for row in table.rows if ids is None or row["id"] in ids]
    skipped = [item for item in table.skipped if ids is None or item["id"] in ids]
    # Stations, contact lines and rock areas have no orientation, so the table omits them.
    missing_ids = (ids or set()) - {item["id"] for item in (*rows, *skipped)}
    for record in records.values():
        if isinstance(record, Feature) and record.id in missing_ids:
            reason = Finding("feature.without-plane")
            skipped.append({"id": record.id, "name": record.name, "reason": reason})
    return ProjectOrientations(tuple(rows), tuple(skipped), table.limits)


def matching_ids(records: Iterable[Record], names: Sequence[str], folder: Path) -> set[str]:
    """Return the ids of the features with these ids or names.

    Raises
    ------
    InputError
        If no feature matches one of the names.
    """
    features = [r for r in records if isinstance(r, Feature)]
    ids: set[str] = set()
    for name in names:
        named_features = [f for f in features if name in (f.id, f.name)]
        # Control points and known lines may have the same names as interpreted features.
        interpreted_features = [
            f for f in named_features if isinstance(f, TypedFeature) or get_kind(f).listed
        ]
        matches = {f.id for f in interpreted_features or named_features}
        if not matches:
            raise InputError(
                Finding("record.missing", id=name, kind="feature"),
                file=folder,
            )
        ids |= matches
    return ids
