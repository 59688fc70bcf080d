"""Region of the next reconstruction: its proposal, and the clipping box that shows it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.files.regular import read_json
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.boxes import ClipBox
from vomstudio.io.models.reconstruction_file import RESULT
from vomstudio.project.reconstructions import RECONSTRUCTIONS
from vomstudio.project.records import Model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey


class RegionChoice:
    """Converter between the region of a reconstruction and the clipping box of the outcrop.

    A region is in the frame of the reconstruction. The clipping box is in the World frame, in which
    the model may have been registered since.

    Attributes
    ----------
    display_changed : Signal
        Emits "clip" or "box" when the clipping box changes, like `Display.changed`.
    """

    def __init__(self, studio: Studio, survey: PhotoSurvey) -> None:
        self._studio, self._survey = studio, survey
        self.display_changed = studio.display.changed

    def proposal(self) -> tuple[float, ...] | None:
        """Return the box around the rock of the last reconstruction, or None if unavailable."""
        from vomstudio.photogrammetry.base.region import Region

        folder = self._survey.alignment_folder()
        if folder is None:
            return None
        try:
            values = tuple(map(float, read_json(folder / RESULT)["proposed_region"]))
            Region.of(values)
        except (OSError, ValueError, TypeError, KeyError, UsageError):
            return None
        return values

    def proposal_problem(self) -> Finding | None:
        """Return why no region can be proposed, or None if one can be proposed."""
        if self.proposal() is None:
            return Finding("reconstruct.not-yet", results=tr("tie points"))
        return None

    def clip_box_problem(self) -> Finding | None:
        """Return why the clipping box cannot be used, or None if it can be used."""
        if self._studio.display.effective_clip is None:
            return Finding("action.no-clipping-box")
        return None

    def clipped_region(self) -> tuple[float, ...] | None:
        """Return the clipping box as a region, or None if it is off."""
        box = self._studio.display.effective_clip
        if box is None:
            return None
        corners = transform.apply(transform.invert(self._to_world()), box.corners())
        low, high = corners.min(axis=0), corners.max(axis=0)
        # The box cannot be dragged more precisely than 0.01 % of its size.
        digits = max(0, 4 - int(np.floor(np.log10(max(float((high - low).max()), 1e-9)))))
        return tuple(round(float(value), digits) for value in (*low, *high))

    def show(self, region: tuple[float, ...]) -> None:
        """Show a region as the clipping box of the outcrop.

        Parameters
        ----------
        region : (6,) tuple of float
            Minimum and maximum corner in the frame of the reconstruction.
        """
        ends = np.reshape(region, (2, 3))
        corners = ClipBox.from_points(ends).corners()
        self._studio.display.set_clip(
            ClipBox.from_points(transform.apply(self._to_world(), corners)), True
        )

    def _to_world(self) -> FloatArray:
        """Return the World transform (4, 4) of the model reconstructed from these photos.

        It is the identity if there is no model.
        """
        out = self._survey.output_folder()
        for model in self._studio.session.of(Model):
            if out is not None and Path(model.path).parts[:-1] == (RECONSTRUCTIONS, out.name):
                return transform.matrix(model.to_world)
        return np.eye(4)
