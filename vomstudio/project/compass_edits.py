"""Edits of the north reference of compass readings on a model."""

from __future__ import annotations

from collections.abc import Mapping

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.project.edit import Edit, change
from vomstudio.project.records import Compass, Model, Record, compass_id, get


def get_compass(records: Mapping[str, Record], model_id: str) -> Compass | None:
    """Return the compass of a model, or None if it has not been declared."""
    return get(records, compass_id(model_id), Compass)


def set_compass(records: Mapping[str, Record], compass: Compass) -> Edit:
    """Set the north reference of a model's azimuths, and its error. Raises DocumentError."""
    model = get(records, compass.model_id, Model)
    if model is None or compass.id != compass_id(model.id):
        raise DocumentError(Finding("record.missing", kind="model", id=compass.model_id))
    return change(records, f"Set the north of readings on {model.name}", {compass.id: compass})
