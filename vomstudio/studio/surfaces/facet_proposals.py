"""Facets of an open model as proposals: found in the background, judged like patches that were
painted, and part of the project only where somebody accepts them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray, Int32Array
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import tr
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.geology.profiles import Thresholds
from vomstudio.geometry.field_style import FieldStyle
from vomstudio.geometry.patches import runs_of
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
    limits_of,
)
from vomstudio.studio.background import Background
from vomstudio.studio.display import Display
from vomstudio.studio.editing import Editing
from vomstudio.studio.jobs.surface_tasks import FIND_FACETS, FacetsOrder, FoundFacets, Sight
from vomstudio.studio.models import Models
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs
from vomstudio.studio.surfaces.model_jobs import ProposalQueue

PART_POINTS = 60_000
"""Points of the part that is looked at while thresholds are tried: a second's work."""

PAINTED = {
    "label": "facet label",
    "dip direction": "facet dip direction [°]",
    "error": "facet 95 % error [°]",
    "exposure": "exposure",
}
"""Names of the fields by which proposals are painted."""
SHARES = {
    "planar": "planar sliding [%]",
    "wedge": "wedge sliding [%]",
    "flexural_toppling": "flexural toppling [%]",
    "direct_toppling": "direct toppling [%]",
}
"""Names of the fields by which they are painted as slopes."""
_NAMES = (*PAINTED.values(), *SHARES.values())
_LEAST_RANGE = 1.0
"""Percent: where nothing is critical the colours tell it too."""


@dataclass(frozen=True, eq=False)
class Proposals:
    """What was found on a model. patches : without names or type, the largest facet first;
    measured : their figures; label, covers : (points,) int32 of the model; exposed_m2 : of each
    patch; model, judged_by : as they were then; whole : all of the model was looked at"""

    model_id: str
    to_world: object
    model: Model
    judged_by: Thresholds
    options: FacetOptions
    told: FoundFacets
    patches: tuple[Patch, ...]
    measured: tuple[Measurement, ...]
    label: Int32Array
    covers: Int32Array
    exposed_m2: FloatArray
    whole: bool

    def share(self, rows: Collection[int]) -> float | None:
        """Of the exposed rock, what lies in these facets."""
        if not self.told.exposed_m2 > 0.0:
            return None
        return float(self.exposed_m2[sorted(rows)].sum()) / self.told.exposed_m2

    def exposed_area_of(self, row: int) -> float:
        """m2, of a facet of points, which have no area of their own."""
        return float(self.exposed_m2[row])

    @property
    def provenance(self) -> str:
        """By which they were found, for the notes of what is accepted."""
        of = self.options
        said = [tr("angle {angle:g}°", angle=of.used_angle_deg)]
        said.append(tr("distance {distance:.3g} m", distance=self.told.reach_m))
        said.append(tr("at least {count} points", count=self.told.min_points))
        if of.min_area_m2:
            said.append(tr("at least {area:g} m²", area=of.min_area_m2))
        if of.min_coplanarity is not None:
            said.append(tr("coplanarity at least {value:g}", value=of.min_coplanarity))
        return tr(
            "Facet that the program proposed ({limits}) and that was accepted.",
            limits=", ".join(said),
        )


class FacetProposals(ProposalQueue[Proposals]):
    """Facets that are proposed on a model.

    Attributes
    ----------
    open, accepted : set of int
        Indices of the proposals that are undecided, and of those that were accepted.
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
        foresee: Callable[[list[tuple[Feature, Measurement]], Thresholds], None],
    ) -> None:
        super().__init__(projects, jobs, background)
        self._models, self._editing, self._foresee = models, editing, foresee
        self._display, self._mode_before = display, ""
        self._thresholds = thresholds
        self.open: set[int] = set()
        self.accepted: set[int] = set()
        # Index of each accepted proposal by the id of its patch.
        self._kept: dict[str, int] = {}

    # --- finding -----------------------------------------------------------------------------
    def find(self, model_id: str, options: FacetOptions, sight: Sight | None) -> None:
        """Look for facets; what is being looked for is given up. sight : for a part alone"""
        self._cancel()
        model = self._model(model_id)
        if model is None:
            return
        standing, record = model
        name = "part" if sight is not None else "whole"
        out = standing.cache / "facets" / f"{model_id}-{name}.npz"

        def judge(result: FoundFacets) -> None:
            # Thousands of facets take too long for the main thread.
            records, thresholds = dict(self._projects.records), self._thresholds()
            whole = sight is None
            self._read(
                lambda: _proposals(record, options, result, whole, records, thresholds),
                self._show_proposals,
            )

        self._submit(
            FIND_FACETS,
            FacetsOrder(standing, options, sight, out),
            tr("Facets of {model}", model=record.name),
            judge,
            quiet=sight is not None,
        )

    def _show_proposals(self, proposals: Proposals) -> None:
        self.proposals, self.accepted = proposals, set()
        self.open = set(range(len(proposals.patches)))
        self._kept = {}
        self._report()

    # --- on the outcrop ----------------------------------------------------------------------
    def paint(self, by: str, palette: str | None = None) -> None:
        """Colour the outcrop by a key of PAINTED; what is decided upon or in no facet is grey.
        Once all is decided the outcrop is as it was."""
        proposals = self.proposals
        opened = None if proposals is None else self._models.open.get(proposals.model_id)
        if proposals is None or opened is None:
            return
        if not self.open and by != "exposure":
            self.unpaint()
            return
        values = np.full(len(proposals.patches) + 1, np.nan, np.float32)
        for row in self.open:
            values[row] = _value(by, row, proposals.measured[row])
        # The last value is that of the label -1.
        painted = values[proposals.label]
        if by == "exposure":
            painted = np.where(proposals.covers < 0, np.nan, proposals.covers).astype(np.float32)
        self._show_painted(proposals.model_id, painted, FieldStyle(PAINTED[by], palette=palette))

    def paint_shares(self, mode: str, shares: Mapping[int, float]) -> None:
        """Colour the outcrop by the share, 0 to 1, of each facet by its index; mode : a
        key of SHARES. Other facets, and what is in none, are grey."""
        proposals = self.proposals
        if proposals is None or proposals.model_id not in self._models.open:
            return
        values = np.full(len(proposals.patches) + 1, np.nan, np.float32)
        for row, share in shares.items():
            values[row] = 100.0 * share
        known = values[np.isfinite(values)]
        most = max(float(known.max(initial=0.0)), _LEAST_RANGE)
        style = FieldStyle(SHARES[mode], low=0.0, high=most)
        self._show_painted(proposals.model_id, values[proposals.label], style)

    def unpaint(self) -> None:
        """The outcrop as it was; what was found stays."""
        if self.proposals is not None:
            self._as_before(self.proposals.model_id)

    def _show_painted(self, model_id: str, painted: Float32Array, style: FieldStyle) -> None:
        self._unpaint(model_id)
        opened = self._models.open[model_id]
        if opened.give_fields({style.name: painted}):
            if not self._mode_before:
                self._mode_before = self._display.mode
            self._display.show_field(model_id, style)

    def _unpaint(self, model_id: str) -> None:
        style, opened = self._display.styles.get(model_id), self._models.open.get(model_id)
        if style is not None and style.name in _NAMES:
            self._display.show_no_field(model_id)
        if opened is not None:
            opened.drop_fields(_NAMES)

    def _as_before(self, model_id: str) -> None:
        """The outcrop as it was before facets were painted on it."""
        style, mode = self._display.styles.get(model_id), self._mode_before
        painted = style is not None and style.name in _NAMES
        self._unpaint(model_id)
        self._mode_before = ""
        if painted and mode and self._display.mode == "field":
            self._display.set_mode(mode)

    # --- deciding ----------------------------------------------------------------------------
    def accept(self, rows: Sequence[int], type_id: str, set_name: str = "") -> list[str]:
        """Make these proposals patches of the project, as one edit; their ids, none where that was
        refused."""
        proposals = self.proposals
        chosen = [row for row in rows if row in self.open]
        if proposals is None or not chosen:
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
            for row in chosen
        ]
        # Its own edit is no reason to forget the others.
        self.open -= set(chosen)
        measured = [proposals.measured[row] for row in chosen]

        def added(records: Mapping[str, Record], features: Sequence[Patch]) -> Edit:
            edit = edits.add_features(records, features)
            if records.get(proposals.model_id) is proposals.model:
                # Hundreds need not be measured once more while the window waits.
                named = [f for f in edit.after.values() if isinstance(f, Feature)]
                self._foresee(list(zip(named, measured, strict=True)), proposals.judged_by)
            return edit

        if not self._editing.attempt(added, patches):
            self.open |= set(chosen)
            return []
        self.accepted |= set(chosen)
        self._kept |= {patch.id: row for patch, row in zip(patches, chosen, strict=True)}
        self.changed.emit()
        return [patch.id for patch in patches]

    def reject(self, rows: Collection[int]) -> None:
        """Leave these out; nothing is changed in the project."""
        self.open -= set(rows)
        self.changed.emit()

    def _forget(self) -> None:
        self.unpaint()
        self.open, self.accepted, self._kept = set(), set(), {}

    def _update_open(self, edit: Edit) -> None:
        """Reopen facets whose patch an edit removed, and close those whose patch it restored."""
        if self._kept.keys().isdisjoint(edit.after):
            return
        gone = {
            self._kept[id_]
            for id_, record in edit.after.items()
            if id_ in self._kept and record is None
        }
        back = {
            self._kept[id_]
            for id_, record in edit.after.items()
            if id_ in self._kept and record is not None
        }
        if gone <= self.open and back <= self.accepted:
            return
        self.open = (self.open | gone) - back
        self.accepted = (self.accepted | back) - gone
        self.changed.emit()


def _proposals(
    model: Model,
    options: FacetOptions,
    told: FoundFacets,
    whole: bool,
    records: dict[str, Any],
    thresholds: Thresholds,
) -> Proposals:
    """In a thread. Raises OSError, ValueError or KeyError where the file is not what it was."""
    with open_arrays(told.out) as arrays:
        of = {name: arrays[name] for name in arrays.files}
    kinds = [r for r in records.values() if isinstance(r, FeatureType)]
    type_id = kinds[0].id if kinds else ""
    patches = []
    for i in range(told.count):
        rows = of["rows"][of["row_cuts"][i] : of["row_cuts"][i + 1]]
        ring = of["outline"][of["outline_cuts"][i] : of["outline_cuts"][i + 1]]
        patches.append(
            Patch(
                f"facet-{i}",
                "",
                type_id,
                model.id,
                model.content_hash,
                "face" if told.element == "face" else "point",
                runs_of(rows),
                int(of["n"][i]),
                _triple(of["mean"][i]),
                (
                    _triple(of["scatter"][i][0]),
                    _triple(of["scatter"][i][1]),
                    _triple(of["scatter"][i][2]),
                ),
                float(of["n_effective"][i]),
                tuple(_triple(p) for p in ring),
                float(of["area"][i]) if told.element == "face" else None,
                float(of["resolution"][i]),
                rule=SURROUNDINGS_RULE,
                level_gap=float(of["level_gap"][i]) or None,
                bent=bool(of["bent"][i]),
                bend_deg=float(of["bend_deg"][i]) or None,
            )
        )
    measured = measure_all(records, patches, thresholds)
    return Proposals(
        model.id,
        model.to_world,
        model,
        limits_of(records, thresholds),
        options,
        told,
        tuple(patches),
        tuple(measured),
        of["label"],
        of["covers"],
        of["exposed_m2"],
        whole,
    )


def _value(by: str, row: int, measured: Measurement) -> float:
    if by == "label":
        return row + 1.0
    if by == "dip direction":
        return np.nan if measured.plane is None else measured.plane.dip_direction_deg
    error = measured.total95_deg
    return 90.0 if error is None else error


def _triple(x: FloatArray) -> tuple[float, float, float]:
    return float(x[0]), float(x[1]), float(x[2])
