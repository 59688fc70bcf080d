"""The picks of a project or a table with those that repeat others."""

from __future__ import annotations

from pathlib import Path

from vomstudio.io.text.orientation_columns import Azimuth
from vomstudio.io.text.orientation_reading import OrientationTable, read_orientations
from vomstudio.project.exports.export import refuse_empty, thresholds_of
from vomstudio.project.exports.feature_table import feature_table
from vomstudio.project.folder import is_project
from vomstudio.project.journal.database import read_replay
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature


def read_picks_again(path: Path, azimuth: Azimuth | None = None) -> OrientationTable:
    """Of the project in a folder, which may be open in a window, else of a table. Raises as
    `read_orientations`."""
    if not is_project(path):
        return read_orientations(path, azimuth, repeats=True)
    kept = read_replay(path)
    refuse_empty(kept.records, path)
    features = [r for r in kept.records.values() if isinstance(r, Feature)]
    measured = Measurements(thresholds_of(kept.settings)).of(kept.records, [f.id for f in features])
    return feature_table(kept.records, features, measured, repeats=True)
