"""Features of a project in the same orientation table that commands read from exports.

Results computed from the project and from the exported table are therefore identical.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vomstudio.core.words import tr
from vomstudio.io.text.orientation_reading import OrientationTable, extract_orientations
from vomstudio.io.text.tables import table_from_cells
from vomstudio.project.figures import Subject
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, Record
from vomstudio.project.tables.orientation_table import COLUMNS
from vomstudio.project.tables.project_table import EXTRA_COLUMNS, feature_rows
from vomstudio.project.tables.registration_comments import find_registrations, registration_lines


def feature_table(
    records: Mapping[str, Record],
    features: Sequence[Feature],
    measurements: Mapping[str, Measurement],
    *,
    repeats: bool = False,
) -> OrientationTable:
    """Return the table of features with their errors and those of their registrations.

    If `repeats` is set, features that repeat another one are included. Raises InputError if no
    feature has an orientation.
    """
    subjects = [Subject(feature, measurements[feature.id], records) for feature in features]
    rows = [row for row in feature_rows(subjects) if row is not None]
    names = (*COLUMNS, *EXTRA_COLUMNS)
    cells = [[_cell(row.get(name)) for name in names] for row in rows]
    comments = registration_lines(find_registrations(records, features))
    return extract_orientations(
        table_from_cells(names, cells, tr("the project"), comments), repeats=repeats
    )


def _cell(value: Any) -> str:
    """Return a value as it is written to a file, with all digits."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)
