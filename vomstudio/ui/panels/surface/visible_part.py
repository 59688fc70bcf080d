"""Visible part of the outcrop, used for trial searches for facets."""

from __future__ import annotations

import numpy as np

from vomstudio.studio.jobs.surface_tasks import Viewpoint
from vomstudio.studio.surfaces.facet_proposals import TESTED_POINT_COUNT
from vomstudio.ui.base.studio import Studio


def find_visible_part(studio: Studio) -> Viewpoint | None:
    """Return the viewpoint of the saved view, or None if the stored camera is not valid."""
    camera = studio.project.journal.view("camera")
    try:
        eye = np.array(camera["position"], np.float64)
        direction = np.cross(
            np.array(camera["up"], np.float64), np.array(camera["right"], np.float64)
        )
        target = eye + direction * float(camera["distance"])
    except (KeyError, TypeError, ValueError):
        return None
    if not np.isfinite([*eye, *target]).all():
        return None
    return Viewpoint(_to_tuple(eye), _to_tuple(target), TESTED_POINT_COUNT)


def _to_tuple(vector: np.ndarray) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
