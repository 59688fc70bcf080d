"""Control points of `vomstudio register` that are marked in photos."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.registration.evidence import Evidence


def marked_pairs(
    control: Path, marks_file: Path | None, evidence: Evidence, crs: str | None, said: list[str]
) -> tuple[Any, str | None]:
    """Control points with the places on the model that their marks in the photos show."""
    import numpy as np

    from vomstudio.io.control.control_files import (
        agreed_crs,
        marks_beside,
        read_control,
        read_marks,
    )
    from vomstudio.io.control.observation_tables import Pairs
    from vomstudio.registration.evidence import marked_places

    points = read_control(control)
    crs = agreed_crs(control, crs)
    marks = read_marks(marks_file or marks_beside(control))
    evidence.marks = [(m.label, m.photo, m.x, m.y) for m in marks]
    places = marked_places(evidence, evidence.marks, said)
    seen = [p for p in points if p.label in places]
    if unseen := [p.label for p in points if p.label not in places]:
        said.append(
            tr("Points with fewer than two right marks in photos of the model were not used: "
               "{names}.", names=", ".join(unseen[:12]))
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
