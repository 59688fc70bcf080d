"""Reading of the picks of a project or table, including repeated picks."""

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


def read_repeated_picks(path: Path, azimuth: Azimuth | None = None) -> OrientationTable:
    """Read the picks from a table or a project folder, which may be open in a window.

    Raises the same errors as `read_orientations`.
    """
    if not is_project(path):
        return read_orientations(path, azimuth, repeats=True)
    replay = read_replay(path)
    refuse_empty(replay.records, path)
    features = [r for r in replay.records.values() if isinstance(r, Feature)]
    measurements = Measurements(thresholds_of(replay.settings)).of(
        replay.records, [f.id for f in features]
    )
    return feature_table(replay.records, features, measurements, repeats=True)
