"""Facets of an open model as proposals.

Facets are computed in the background and assessed like painted patches. They are added to the
project only when they are accepted.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray, Int32Array
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.identifiers import new_id
from vomstudio.core.options import option_texts
from vomstudio.core.words import tr
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.geology.profiles import Thresholds
from vomstudio.geometry.field_style import FieldStyle
from vomstudio.geometry.patches import ids_to_runs
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.measurement import Measurement
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import (
    SURROUNDINGS_RULE,
    Feature,
    FeatureType,
    Model,
    Record,
    get_limits,
)
from vomstudio.studio.background import Background
from vomstudio.studio.display import Display
from vomstudio.studio.editing import Editing
from vomstudio.studio.jobs.surface_tasks import FIND_FACETS, FacetsRequest, FacetsResult, Viewpoint
from vomstudio.studio.models import Models
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs
from vomstudio.studio.surfaces.model_jobs import ProposalQueue

TESTED_POINT_COUNT = 60_000
"""Number of points of the visible part on which thresholds are tested, which takes less than a
second."""

PAINTED_FIELDS = {
    "label": "facet label",
    "dip direction": "facet dip direction [°]",
    "error": "facet 95 % error [°]",
    "exposure": "exposure",
}
"""Names of the fields by which proposals are coloured."""
SHARES = {
    "planar": "planar sliding [%]",
    "wedge": "wedge sliding [%]",
    "flexural_toppling": "flexural toppling [%]",
    "direct_toppling": "direct toppling [%]",
}
"""Names of the fields by which proposals are coloured as slopes."""
_NAMES = (*PAINTED_FIELDS.values(), *SHARES.values())
MIN_RANGE_PERCENT = 1.0
"""Minimum colour range in percent, which makes the absence of critical facets visible."""


@dataclass(frozen=True, eq=False)
class Proposals:
    """Proposed facets of a model.

    Parameters
    ----------
    model : Model
    thresholds : Thresholds
        Thresholds at the time of the assessment.
    patches : tuple of Patch
        Patches without names and with a provisional type, the largest first.
    measured : tuple of Measurement
        Measurements of the patches.
    label, covers : (points,) int32
        Facet and cover class (see `extraction.exposure.Exposure`) of each point of the model,
        or -1.
    exposed_m2 : (facets,) float64
        Exposed area of each patch.
    is_whole_model : bool
        Whether the whole model was searched.
    """

    model_id: str
    to_world: object
    model: Model
    thresholds: Thresholds
    options: FacetOptions
    result: FacetsResult
    patches: tuple[Patch, ...]
    measured: tuple[Measurement, ...]
    label: Int32Array
    covers: Int32Array
    exposed_m2: FloatArray
    is_whole_model: bool

    def share(self, rows: Collection[int]) -> float | None:
        """Return the share of some facets in the exposed rock area, or None if it is unknown."""
        if not self.result.exposed_m2 > 0.0:
            return None
        return float(self.exposed_m2[sorted(rows)].sum()) / self.result.exposed_m2

    def get_exposed_area(self, row: int) -> float:
        """Return the exposed area of a facet, m2."""
        return float(self.exposed_m2[row])

    @property
    def provenance(self) -> str:
        """Description of the search for the notes of accepted facets."""
        limits = option_texts(
            self.options,
            angle_deg=self.options.used_angle_deg,
            max_distance_m=self.result.reach_m,
            min_points=self.result.min_points,
        )
        return tr("Proposed facet ({limits}), accepted.", limits=", ".join(limits))


class FacetProposals(ProposalQueue[Proposals]):
    """Facets that are proposed on a model.

    Attributes
    ----------
    open_rows, accepted : set of int
        Indices of the undecided proposals and of the accepted ones.
    """

    def __init__(
        self,
        projects: Projects,
        models: Models,
        editing: Editing,
        display: Display,
        jobs: Jobs,
        thresholds: Callable[[], Thresholds],
        background: Background,
        store_expected_measurements: Callable[
            [list[tuple[Feature, Measurement]], Thresholds], None
        ],
    ) -> None:
        super().__init__(projects, jobs, background)
        self._models, self._editing, self._store_expected_measurements = (
            models,
            editing,
            store_expected_measurements,
        )
        self._display, self._previous_mode = display, ""
        self._thresholds = thresholds
        self.open_rows: set[int] = set()
        self.accepted: set[int] = set()
        # Row of each accepted proposal, keyed by the id of its patch.
        self._accepted_rows: dict[str, int] = {}

    # --- search -------------------------------------------------------------------------------
    def find(self, model_id: str, options: FacetOptions, viewpoint: Viewpoint | None) -> None:
        """Search for facets, cancelling any search in progress.

        `viewpoint` restricts the search to a view; if None, the whole model is searched.
        """
        self._cancel()
        model = self._model(model_id)
        if model is None:
            return
        placed_model, record = model
        name = "part" if viewpoint is not None else "whole"
        out = placed_model.cache / "facets" / f"{model_id}-{name}.npz"

        def handle_result(result: FacetsResult) -> None:
            # Processing thousands of facets takes too long for the main thread.
            records, thresholds = dict(self._projects.records), self._thresholds()
            is_whole_model = viewpoint is None
            self._read_in_background(
                lambda: assess_facets(record, options, result, is_whole_model, records, thresholds),
                self._show_proposals,
            )

        self._submit(
            FIND_FACETS,
            FacetsRequest(placed_model, options, viewpoint, out),
            tr("Facets of {model}", model=record.name),
            handle_result,
            is_quiet=viewpoint is not None,
        )

    def _show_proposals(self, proposals: Proposals) -> None:
        self.proposals, self.accepted = proposals, set()
        self.open_rows = set(range(len(proposals.patches)))
        self._accepted_rows = {}
        self._report()

    # --- colours on the outcrop ---------------------------------------------------------------
    def paint(self, mode: str, palette: str | None = None) -> None:
        """Colour the facets on the outcrop by a key of `PAINTED_FIELDS`; other points are grey.

        Except in the mode "exposure", decided facets are grey as well, and the original colours are
        restored once all facets have been decided.
        """
        proposals = self.proposals
        open_model = None if proposals is None else self._models.open_models.get(proposals.model_id)
        if proposals is None or open_model is None:
            return
        if not self.open_rows and mode != "exposure":
            self.unpaint()
            return
        values = np.full(len(proposals.patches) + 1, np.nan, np.float32)
        for row in self.open_rows:
            values[row] = _value(mode, row, proposals.measured[row])
        # The last value is that of the label -1.
        painted_values = values[proposals.label]
        if mode == "exposure":
            painted_values = np.where(proposals.covers < 0, np.nan, proposals.covers).astype(
                np.float32
            )
        self._show_painted(
            proposals.model_id, painted_values, FieldStyle(PAINTED_FIELDS[mode], palette=palette)
        )

    def paint_shares(self, mode: str, shares: Mapping[int, float]) -> None:
        """Colour the facets on the outcrop by a share of each facet; other points are grey.

        Parameters
        ----------
        mode : str
            A key of SHARES.
        shares : mapping of int to float
            Share of each facet (0 to 1), keyed by its index.
        """
        proposals = self.proposals
        if proposals is None or proposals.model_id not in self._models.open_models:
            return
        values = np.full(len(proposals.patches) + 1, np.nan, np.float32)
        for row, share in shares.items():
            values[row] = 100.0 * share
        finite_shares = values[np.isfinite(values)]
        maximum = max(float(finite_shares.max(initial=0.0)), MIN_RANGE_PERCENT)
        style = FieldStyle(SHARES[mode], low=0.0, high=maximum)
        self._show_painted(proposals.model_id, values[proposals.label], style)

    def unpaint(self) -> None:
        """Restore the colours of the outcrop; the proposals remain."""
        if self.proposals is not None:
            self._restore_colours(self.proposals.model_id)

    def _show_painted(
        self, model_id: str, painted_numbers: Float32Array, style: FieldStyle
    ) -> None:
        self._unpaint(model_id)
        open_model = self._models.open_models[model_id]
        if open_model.add_fields({style.name: painted_numbers}):
            if not self._previous_mode:
                self._previous_mode = self._display.mode
            self._display.show_field(model_id, style)

    def _unpaint(self, model_id: str) -> None:
        style, open_model = (
            self._display.styles.get(model_id),
            self._models.open_models.get(model_id),
        )
        if style is not None and style.name in _NAMES:
            self._display.hide_field(model_id)
        if open_model is not None:
            open_model.remove_fields(_NAMES)

    def _restore_colours(self, model_id: str) -> None:
        """Restore the colours that were shown before the facets were painted."""
        style, mode = self._display.styles.get(model_id), self._previous_mode
        is_painted = style is not None and style.name in _NAMES
        self._unpaint(model_id)
        self._previous_mode = ""
        if is_painted and mode and self._display.mode == "field":
            self._display.set_mode(mode)

    # --- decisions ----------------------------------------------------------------------------
    def accept(self, rows: Sequence[int], type_id: str, set_name: str = "") -> list[str]:
        """Add proposals to the project in one edit, and return the ids of the patches.

        The list is empty if the edit was rejected.
        """
        proposals = self.proposals
        open_indices = [row for row in rows if row in self.open_rows]
        if proposals is None or not open_indices:
            return []
        note = proposals.provenance
        patches = [
            replace(
                proposals.patches[row],
                id=new_id("patch"),
                type_id=type_id,
                set_name=set_name,
                notes=note,
            )
            for row in open_indices
        ]
        # The edit must not discard the other proposals.
        self.open_rows -= set(open_indices)
        measurements = [proposals.measured[row] for row in open_indices]

        def create_edit(records: Mapping[str, Record], features: Sequence[Patch]) -> Edit:
            edit = edits.add_features(records, features)
            if records.get(proposals.model_id) is proposals.model:
                # Avoids measuring hundreds of patches again while the window waits.
                new_features = [f for f in edit.after.values() if isinstance(f, Feature)]
                self._store_expected_measurements(
                    list(zip(new_features, measurements, strict=True)), proposals.thresholds
                )
            return edit

        if not self._editing.attempt(create_edit, patches):
            self.open_rows |= set(open_indices)
            return []
        self.accepted |= set(open_indices)
        self._accepted_rows |= {
            patch.id: row for patch, row in zip(patches, open_indices, strict=True)
        }
        self.changed.emit()
        return [patch.id for patch in patches]

    def reject(self, rows: Collection[int]) -> None:
        """Reject proposals; the project does not change."""
        self.open_rows -= set(rows)
        self.changed.emit()

    def _forget(self) -> None:
        self.unpaint()
        self.open_rows, self.accepted, self._accepted_rows = set(), set(), {}

    def _update_open(self, edit: Edit) -> None:
        """Reopen facets whose patch an edit removed, and close those whose patch it restored."""
        if self._accepted_rows.keys().isdisjoint(edit.after):
            return
        removed_rows = {
            self._accepted_rows[id_]
            for id_, record in edit.after.items()
            if id_ in self._accepted_rows and record is None
        }
        restored = {
            self._accepted_rows[id_]
            for id_, record in edit.after.items()
            if id_ in self._accepted_rows and record is not None
        }
        if removed_rows <= self.open_rows and restored <= self.accepted:
            return
        self.open_rows = (self.open_rows | removed_rows) - restored
        self.accepted = (self.accepted | restored) - removed_rows
        self.changed.emit()


def assess_facets(
    model: Model,
    options: FacetOptions,
    result: FacetsResult,
    is_whole: bool,
    records: dict[str, Any],
    thresholds: Thresholds,
) -> Proposals:
    """Read and assess facets. Runs in a worker thread.

    Raises
    ------
    OSError, ValueError, KeyError
        If the file of the facets has changed.
    """
    with open_arrays(result.out) as arrays:
        array_by_name = {name: arrays[name] for name in arrays.files}
    kinds = [r for r in records.values() if isinstance(r, FeatureType)]
    type_id = kinds[0].id if kinds else ""
    patches = []
    for i in range(result.count):
        rows = array_by_name["rows"][
            array_by_name["row_cuts"][i] : array_by_name["row_cuts"][i + 1]
        ]
        ring = array_by_name["outline"][
            array_by_name["outline_cuts"][i] : array_by_name["outline_cuts"][i + 1]
        ]
        patches.append(
            Patch(
                f"facet-{i}",
                "",
                type_id,
                model.id,
                model.content_hash,
                "face" if result.element == "face" else "point",
                ids_to_runs(rows),
                int(array_by_name["n"][i]),
                _to_tuple(array_by_name["mean"][i]),
                (
                    _to_tuple(array_by_name["scatter"][i][0]),
                    _to_tuple(array_by_name["scatter"][i][1]),
                    _to_tuple(array_by_name["scatter"][i][2]),
                ),
                float(array_by_name["n_effective"][i]),
                tuple(_to_tuple(p) for p in ring),
                float(array_by_name["area"][i]) if result.element == "face" else None,
                float(array_by_name["resolution"][i]),
                rule=SURROUNDINGS_RULE,
                level_gap=float(array_by_name["level_gap"][i]) or None,
                bent=bool(array_by_name["bent"][i]),
                bend_deg=float(array_by_name["bend_deg"][i]) or None,
            )
        )
    measurements = measure_all(records, patches, thresholds)
    return Proposals(
        model.id,
        model.to_world,
        model,
        get_limits(records, thresholds),
        options,
        result,
        tuple(patches),
        tuple(measurements),
        array_by_name["label"],
        array_by_name["covers"],
        array_by_name["exposed_m2"],
        is_whole,
    )


def _value(mode: str, row: int, measurement: Measurement) -> float:
    if mode == "label":
        return row + 1.0
    if mode == "dip direction":
        return np.nan if measurement.plane is None else measurement.plane.dip_direction_deg
    error = measurement.total95_deg
    return 90.0 if error is None else error


def _to_tuple(x: FloatArray) -> tuple[float, float, float]:
    return float(x[0]), float(x[1]), float(x[2])
