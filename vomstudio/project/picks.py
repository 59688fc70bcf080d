"""Reading of planes and lines from a table or from a project."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from vomstudio.io.gate.orientation_files import NO_COLUMNS, read_orientations
from vomstudio.io.text.orientation_columns import Azimuth
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.project.paths import is_project


def read_picks(
    path: str | Path,
    azimuth: Azimuth | None = None,
    *,
    columns: Mapping[str, str] = NO_COLUMNS,
    layer: str | None = None,
    repeats: bool = False,
    azimuth_only: bool = False,
) -> OrientationTable:
    """Read the planes and lines of a table or of a project, which may be open in a window.

    Parameters
    ----------
    path : str or Path
        Table, point layer, workbook or project folder.
    azimuth, columns, layer, repeats, azimuth_only
        As for `read_orientations`.

    Returns
    -------
    OrientationTable

    Raises
    ------
    InputError, UsageError
        As `read_orientations`, or if the project has no features.
    """
    path = Path(path)
    if not is_project(path):
        return read_orientations(
            path,
            azimuth,
            columns=columns,
            layer=layer,
            repeats=repeats,
            azimuth_only=azimuth_only,
        )
    # Tables are read without the libraries of projects.
    from vomstudio.project.exports.export import get_thresholds, refuse_empty
    from vomstudio.project.exports.feature_table import feature_table
    from vomstudio.project.journal.database import read_replay
    from vomstudio.project.measurement_cache import Measurements
    from vomstudio.project.records import Feature

    replay = read_replay(path)
    refuse_empty(replay.records, path)
    features = [record for record in replay.records.values() if isinstance(record, Feature)]
    measurements = Measurements(get_thresholds(replay.settings)).of(
        replay.records, [feature.id for feature in features]
    )
    return feature_table(replay.records, features, measurements, repeats=repeats)
