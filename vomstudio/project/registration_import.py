"""Import of registrations from files into a project."""

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
    """Return the record with which a registration from a file is added to a project.

    If the project already contains the registration, that record is returned, so that the models it
    places continue to rotate together. Otherwise the registration is returned with an ID that the
    project does not use.
    """
    for record in records.values():
        if isinstance(record, Registration) and is_same_registration(record, registration):
            return record
    if registration.id in records:
        return replace(registration, id=new_id("registration"))
    return registration
