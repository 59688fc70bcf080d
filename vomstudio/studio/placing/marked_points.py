"""Control points that are marked in photos of a model, as point pairs."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.io.gate.frame_options import FrameOptions
from vomstudio.io.gate.points import points_to_world
from vomstudio.registration.evidence import Evidence


def marked_pairs(
    control: Path,
    marks_file: Path | None,
    evidence: Evidence,
    crs: str | None,
    findings: list[Finding],
    *,
    to_crs: str | None = None,
) -> tuple[Pairs, str | None]:
    """Triangulate control points from their marks in photos, and add them to the pairs.

    The points are converted to `to_crs` if it is given. Returns the pairs and their CRS (None if
    unknown). Messages about unused points are appended to `findings`.

    Raises
    ------
    UsageError, InputError, GeometryError
        For example, if the marks are not in pixels of the photos.
    """
    from vomstudio.io.control.control_files import (
        agreed_crs,
        marks_path,
        read_control,
        read_marks,
    )
    from vomstudio.registration.evidence import triangulate_marks
    from vomstudio.registration.marks.mark_checks import (
        name_findings,
        require_photo_pixels,
    )

    points = read_control(control)
    crs = agreed_crs(control, crs)
    if to_crs is not None:
        world = points_to_world(
            np.array([p.position for p in points], np.float64).reshape(-1, 3),
            file=control,
            options=FrameOptions(crs=crs, to_crs=to_crs),
        )
        crs = world.crs
        findings += world.findings
        locations = world.points.tolist()
        points = [
            replace(p, position=(x, y, z)) for p, (x, y, z) in zip(points, locations, strict=True)
        ]
    path = marks_file or marks_path(control)
    marks = read_marks(path)
    evidence.marks = [(m.label, m.photo, m.x, m.y) for m in marks]
    positions = {p.label: p.position for p in points}
    if evidence.views:
        try:
            require_photo_pixels(evidence.marks, evidence.views, positions)
        except GeometryError as failure:
            failure.file = str(path)
            raise
        findings += name_findings(list(positions), evidence.marks, evidence.views)
    used_marks = [mark for mark in evidence.marks if mark[0] in positions]
    places_by_label = triangulate_marks(evidence, used_marks, findings)
    triangulated_points = [p for p in points if p.label in places_by_label]
    sigma = [[p.sigma_m or math.nan] * 3 for p in triangulated_points]
    pairs = Pairs(
        tuple(p.label for p in triangulated_points),
        np.array([places_by_label[p.label][0] for p in triangulated_points]).reshape(-1, 3),
        np.array([p.position for p in triangulated_points], np.float64).reshape(-1, 3),
        np.array(sigma, np.float64).reshape(-1, 3),
        np.array([p.check for p in triangulated_points], bool),
        covariance=np.array([places_by_label[p.label][1] for p in triangulated_points]).reshape(
            -1, 3, 3
        ),
    )
    if evidence.pairs is not None:
        pairs = evidence.pairs.combine_pairs(pairs)
    return pairs, crs
