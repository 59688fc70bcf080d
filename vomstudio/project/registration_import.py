"""Registrations that are read from files and join a project."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from vomstudio.core.identifiers import new_id
from vomstudio.geometry.registration_frames import is_same_registration
from vomstudio.geometry.registrations import Registration
from vomstudio.project.records import Record


def registration_in_project(
    records: Mapping[str, Record], registration: Registration
) -> Registration:
    """Return the record under which a registration read from a file joins a project.

    A registration that the project contains already is returned itself, so that the models that
    it places keep turning together; otherwise one with an id that the project does not use.
    """
    for record in records.values():
        if isinstance(record, Registration) and is_same_registration(record, registration):
            return record
    if registration.id in records:
        return replace(registration, id=new_id("registration"))
    return registration
