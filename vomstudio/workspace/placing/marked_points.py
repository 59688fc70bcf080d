"""Control points that are marked in photos of a model, as pairs of places."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from vomstudio.core.findings import Message
from vomstudio.errors import GeometryError
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.registration.evidence import Evidence
from vomstudio.words import tr

_NAMED = 12


def marked_pairs(
    control: Path, marks_file: Path | None, evidence: Evidence, crs: str | None, said: list[Message]
) -> tuple[Pairs, str | None]:
    """Control points with the places on the model that their marks in the photos show, beside the
    pairs that are there; and the CRS of both. said : gets what of them was not used

    Raises UsageError, InputError, and GeometryError for marks that are counted otherwise than the
    pixels of the photos.
    """
    from vomstudio.io.control.control_files import (
        agreed_crs,
        marks_beside,
        read_control,
        read_marks,
    )
    from vomstudio.registration.evidence import marked_places
    from vomstudio.registration.marks.mark_checks import (
        photos_of,
        require_pixels_of_photos,
        said_of_names,
    )

    points = read_control(control)
    crs = agreed_crs(control, crs)
    path = marks_file or marks_beside(control)
    marks = read_marks(path)
    evidence.marks = [(m.label, m.photo, m.x, m.y) for m in marks]
    known = {p.label: p.position for p in points}
    if evidence.views:
        try:
            require_pixels_of_photos(evidence.marks, evidence.views, known)
        except GeometryError as failure:
            failure.file = str(path)
            raise
        said += said_of_names(list(known), evidence.marks, evidence.views)
    used = [mark for mark in evidence.marks if mark[0] in known]
    places = marked_places(evidence, used, said)
    seen = [p for p in points if p.label in places]
    photos = photos_of(list(known), used, evidence.views)
    # Fewer than two marks were said.
    lost = [label for label in known if label not in places and len(photos[label]) > 1]
    if lost:
        said.append(
            tr("Points with fewer than two right marks in photos of the model were not used: "
               "{names}.", names=", ".join(lost[:_NAMED]))
        )  # fmt: skip
    sigma = [[p.sigma_m or math.nan] * 3 for p in seen]
    found = Pairs(
        tuple(p.label for p in seen),
        np.array([places[p.label] for p in seen]).reshape(-1, 3),
        np.array([p.position for p in seen], np.float64).reshape(-1, 3),
        np.array(sigma, np.float64).reshape(-1, 3),
        np.array([p.check for p in seen], bool),
    )
    if evidence.pairs is not None:
        found = evidence.pairs.with_more(found)
    return found, crs
