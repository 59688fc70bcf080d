"""Which part of the outcrop facets are tried on."""

from __future__ import annotations

import numpy as np

from vomstudio.studio.jobs.surface_tasks import Viewpoint
from vomstudio.studio.surfaces.facet_proposals import PART_POINTS
from vomstudio.ui.base.studio import Studio


def part_in_view(studio: Studio) -> Viewpoint | None:
    """What is in the middle of the view, as it was when it came to rest; None before that."""
    camera = studio.project.journal.view("camera")
    try:
        eye = np.array(camera["position"], np.float64)
        ahead = np.cross(np.array(camera["up"], np.float64), np.array(camera["right"], np.float64))
        toward = eye + ahead * float(camera["distance"])
    except (KeyError, TypeError, ValueError):
        return None
    if not np.isfinite([*eye, *toward]).all():
        return None
    return Viewpoint(_triple(eye), _triple(toward), PART_POINTS)


def _triple(x: np.ndarray) -> tuple[float, float, float]:
    return float(x[0]), float(x[1]), float(x[2])
