"""The planes among which sets are proposed, and what is proposed of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.project.kinds import kind_of
from vomstudio.project.records import FeatureType, Model, Typed
from vomstudio.project.registration_errors import model_of, models_of, turns_of
from vomstudio.project.repeated_features import first_picks
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray
    from vomstudio.geology.common_rotation_errors import Turns
    from vomstudio.geology.sets.proposals import ProposedSet, SetProposal
    from vomstudio.ui.panels.net.feature_sets import Groups

LEAST_PLANES = 3

Choice = tuple[str, str]
"""Which planes: "selection" or "picked" and "", or "type" and its id."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """n planes that may be put in sets. poles (n, 3), World; places (n, 3) in metres, NaN where
    unknown; turns : how the poles turn with the registrations of their models; taken : names of
    sets that stay; replacing : planes that have a set already are among them
    """

    ids: tuple[str, ...]
    poles: FloatArray
    places: FloatArray
    turns: Turns
    taken: frozenset[str]
    remarks: tuple[Finding, ...]
    replacing: bool


@dataclass(frozen=True, eq=False)
class Proposed:
    """What was found among candidates. names : of the sets, in their order; cones_deg :
    half-angles of their means with 95 %, with the registration where its error is known"""

    of: Candidates
    found: SetProposal
    names: tuple[str, ...]
    cones_deg: tuple[float | None, ...]

    @property
    def sets(self) -> tuple[ProposedSet, ...]:
        return self.found.sets

    def groups(self, names: Sequence[str]) -> Groups:
        """The ids of each set under these names, in the order of the sets, then those in none.
        Sets without a name are among the latter."""
        row = {one.name: k for k, one in enumerate(self.found.sets) if names[k].strip()}
        members: list[list[str]] = [[] for _ in range(len(names) + 1)]
        for id_, name in zip(self.of.ids, self.found.assignment, strict=True):
            members[row.get(name, len(names))].append(id_)
        titles = [*(name.strip() for name in names), ""]
        return tuple((t, tuple(ids)) for t, ids in zip(titles, members, strict=True))

    def assignment(self, names: Sequence[str]) -> dict[str, str]:
        """The set of each plane by its id; those in none only where they may lose one."""
        return {
            id_: name
            for name, ids in self.groups(names)
            for id_ in ids
            if name or self.of.replacing
        }


def with_set(studio: Studio, choice: Choice) -> list[Typed]:
    """The features of a choice that may have a plane and a set."""
    of, type_id = choice
    if of == "selection":
        chosen = [studio.records.get(i) for i in studio.selection.ids]
        found = [f for f in chosen if isinstance(f, Typed)]
    else:
        found = list(studio.session.of(Typed))
    if of == "type":
        found = [f for f in found if f.type_id == type_id]
    elif of == "picked":
        found = [f for f in found if kind_of(f).evidence == "picked"]
    found = first_picks(found, studio.records)
    return [f for f in found if "plane" in kind_of(f).orientations and _has_set(f)]


def _has_set(feature: Typed) -> bool:
    return any(a.field == "set_name" for a in kind_of(feature).attributes)


def candidates(studio: Studio, choice: Choice, *, replacing: bool) -> Candidates:
    """Return the planes of a choice among which sets can be proposed.

    Parameters
    ----------
    studio : Studio
    choice : Choice
    replacing : bool
        Include planes that already have a set.

    Raises
    ------
    GeometryError
        For fewer than three planes.
    """
    features = with_set(studio, choice)
    measured = studio.measured(f.id for f in features)
    planes = [f for f in features if measured[f.id].plane is not None]
    had = [f for f in planes if f.set_name]
    chosen = planes if replacing else [f for f in planes if not f.set_name]
    if len(chosen) < LEAST_PLANES:
        code = "sets.too-few-planes" if replacing or not had else "sets.too-few-without-set"
        raise GeometryError(Finding(code, count=len(chosen), minimum=LEAST_PLANES))
    remarks = []
    if had:
        code = "sets.replaced" if replacing else "sets.left-out"
        remarks.append(Finding(code, count=len(had)))
    types = {f.type_id for f in chosen}
    if len(types) > 1:
        names = [k.name for k in studio.session.of(FeatureType) if k.id in types]
        remarks.append(Finding("sets.types-pooled", types=names))
    places, findings = _places(studio, chosen)
    remarks += findings
    own = {f.id for f in chosen}
    taken = {f.set_name for f in studio.session.of(Typed) if f.set_name and f.id not in own}
    poles = -np.array([p.normal() for f in chosen if (p := measured[f.id].plane) is not None])
    ids = tuple(f.id for f in chosen)
    turns = turns_of(models_of(studio.records, chosen))
    return Candidates(ids, poles, places, turns, frozenset(taken), tuple(remarks), replacing)


def _places(studio: Studio, features: Sequence[Typed]) -> tuple[FloatArray, list[Finding]]:
    """(n, 3) the middles of features in World, NaN where there is none in metres, and what there is
    to say about it."""
    places = np.full((len(features), 3), np.nan)
    frames = {m.id: m.frame for f in features if (m := model_of(studio.records, f)) is not None}
    frames = frames or {m.id: m.frame for m in studio.session.of(Model)}
    if len(frames) > 1 and any(frame.kind != "crs" for frame in frames.values()):
        return places, [Finding("sets.no-common-frame")]
    measured = studio.measured(f.id for f in features)
    for row, feature in enumerate(features):
        points = measured[feature.id].points
        if measured[feature.id].metric and len(points):
            places[row] = points.mean(axis=0)
    lost = int(np.sum(~np.isfinite(places).all(axis=1)))
    if lost == len(places):
        return places, [Finding("sets.not-in-metres")]
    if lost:
        return places, [Finding("sets.partly-in-metres", count=lost)]
    return places, []


def propose(of: Candidates, options: SetOptions) -> Proposed:
    """Propose sets among the candidates; runs in any thread. Raises UsageError."""
    from vomstudio.geology.sets.proposals import propose_sets_of_poles

    found = propose_sets_of_poles(of.poles, options, places=of.places)
    names: list[str] = []
    number = 1
    while len(names) < len(found.sets):
        if f"J{number}" not in of.taken:
            names.append(f"J{number}")
        number += 1
    return Proposed(of, found, tuple(names), tuple(_cone(of, found, one) for one in found.sets))


def _cone(of: Candidates, found: SetProposal, one: ProposedSet) -> float | None:
    from vomstudio.geology.populations.set_statistics import mean_regions
    from vomstudio.geology.statistics import fisher

    rows = np.flatnonzero(np.array(found.assignment) == one.name)
    poles, turns = of.poles[rows], of.turns.of(rows)
    if not turns.known:
        return one.cone95_deg
    _, total = mean_regions(poles, fisher(poles, directed=False), False, turns)
    return None if total is None else total.largest_deg


def remarks_on(made: Proposed, options: SetOptions) -> list[Finding]:
    """Return warnings about the proposed sets and their candidates."""
    from vomstudio.geology.sets.axial_mixture import MIN_MEMBERS

    found = made.found
    said = [*found.warnings, *made.of.remarks]
    if not found.sets and options == SetOptions():
        said.insert(0, Finding("sets.none-distinct", minimum=MIN_MEMBERS))
    if any(one.kappa is None and one.n > 1 for one in found.sets):
        said.append(Finding("sets.parallel"))
    return said
