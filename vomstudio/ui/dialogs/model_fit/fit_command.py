"""Command line of the fit of one model to another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.options import option_words
from vomstudio.core.words import tr
from vomstudio.project.records import Model
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.dialogs.model_fit.picking_view import PickingView
from vomstudio.ui.dialogs.model_fit.point_pairs import PointPairs
from vomstudio.ui.dialogs.model_fit.stable_part import StablePartBox
from vomstudio.ui.widgets.copied_command import (
    CommandArguments,
    CopyCommandButton,
    copy_command,
    copy_with_file,
)
from vomstudio.ui.widgets.other_model_box import OtherModel

_INITIAL_SIGMA_M = 10.0


class FitCopyButton(CopyCommandButton):
    """Button that copies the fit as a command. `reference_view` shows the reference."""

    def __init__(
        self,
        studio: Studio,
        stable_part_box: StablePartBox,
        points: PointPairs,
        find_model: Callable[[], Model | None],
        reference_view: PickingView,
    ) -> None:
        super().__init__(
            self._copy_command,
            tr("the command for this fit; it also fits the scale if the file has no unit"),
        )
        self._studio, self._stable_part_box, self._points = studio, stable_part_box, points
        self._find_model, self._reference_view = find_model, reference_view

    def refresh(self, pending_finding: Finding | None) -> None:
        """Enable the button unless the fit is pending or no command can reproduce it."""
        self.set_enabled(
            pending_finding
            or command_problem(self._studio, self._reference_view.model, self._stable_part_box)
        )

    def _copy_command(self) -> None:
        model, reference = self._find_model(), self._reference_view.model
        if model is not None and reference is not None:
            copy_fit(
                self,
                self._studio,
                model=model,
                reference=reference,
                stable_part_box=self._stable_part_box,
                points=self._points,
            )


def command_problem(
    studio: Studio, reference: OtherModel | None, stable_part_box: StablePartBox
) -> Finding | None:
    """Return why no command can reproduce the fit, or None if a command can."""
    if reference is None:
        return Finding("action.no-other-model")
    record = studio.records.get(reference.id)
    if isinstance(record, Model) and record.registration is not None:
        return Finding("action.other-model-placed")
    return stable_part_box.mask_problem()


def copy_fit(
    parent: QWidget,
    studio: Studio,
    model: Model,
    reference: OtherModel,
    stable_part_box: StablePartBox,
    points: PointPairs,
) -> None:
    """Copy the command of the fit to the clipboard.

    If points were clicked, they are first written to a file that the user selects.
    """
    from vomstudio.io.control.writing import write_pairs

    path = studio.project.find_model(model)
    if path is None:
        return
    crs = reference.to_placed_model(studio.project.cache).crs
    mask = stable_part_box.mask_file()

    def build_command(pairs: Path | None) -> CommandArguments:
        options = RegisterOptions(
            reference=str(reference.path),
            pairs=None if pairs is None else str(pairs),
            stable=None if mask is None else str(mask),
            crs=crs or None,
        )
        return ["register", path, *option_words(options)]

    if points.pairs:
        pairs = points.to_pairs()
        # The points only initialise the fit; a large error keeps their weight below that of the
        # surfaces.
        pairs = replace(pairs, sigma=np.full_like(pairs.world, _INITIAL_SIGMA_M))
        write = partial(write_pairs, pairs=pairs)
        copy_with_file(parent, studio, "pairs.csv", write, build_command)
    else:
        copy_command(studio, build_command(None))
