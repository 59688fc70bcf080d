"""Candidate planes for proposed sets, and the proposal computed from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.project.kinds import get_kind
from vomstudio.project.records import FeatureType, Model, TypedFeature
from vomstudio.project.registration_errors import get_model, get_models, get_rotation_errors
from vomstudio.project.repeated_features import first_picks
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray, IntArray
    from vomstudio.geology.common_rotation_errors import RotationErrors
    from vomstudio.geology.sets.proposals import ProposedSet
    from vomstudio.ui.panels.net.feature_sets import Groups

MIN_PLANES = 3

Choice = tuple[str, str]
"""Group of planes: ("selection", ""), ("picked", "") or ("type", type id)."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Candidate planes for proposed sets.

    Attributes
    ----------
    types : (n,) tuple of str
        Name of the feature type of each plane; sets never contain several types.
    poles : (n, 3) float64
        Unit normals in the World frame.
    centres : (n, 3) float64
        Mid-points in the World frame in metres, NaN if unknown.
    rotation_errors : RotationErrors
        Rotation errors that poles have in common because of the registrations of their models.
    reserved_names : frozenset of str
        Names of sets that contain other planes.
    includes_assigned : bool
        Whether planes that already belong to a set are included.
    """

    ids: tuple[str, ...]
    types: tuple[str, ...]
    poles: FloatArray
    centres: FloatArray
    rotation_errors: RotationErrors
    reserved_names: frozenset[str]
    warnings: tuple[Finding, ...]
    includes_assigned: bool


@dataclass(frozen=True, eq=False)
class ProposalResult:
    """Proposed sets of candidate planes.

    Attributes
    ----------
    sets : tuple of ProposedSet
        Sets of all types.
    assignment : (n,) tuple of int
        Index of the set of each candidate, or -1.
    names : tuple of str
        Proposed name of each set.
    cones_deg : tuple of float or None
        95 % half-angle of each set mean, including the registration error if it is known.
    """

    candidates: Candidates
    sets: tuple[ProposedSet, ...]
    assignment: tuple[int, ...]
    names: tuple[str, ...]
    cones_deg: tuple[float | None, ...]
    warnings: tuple[Finding, ...]

    @property
    def unassigned_count(self) -> int:
        """Number of candidates that are not in a set."""
        return self.assignment.count(-1)

    def groups(self, names: Sequence[str]) -> Groups:
        """Return the plane ids of each set in order, followed by the unassigned planes.

        Planes of sets with an empty name count as unassigned.
        """
        members: list[list[str]] = [[] for _ in range(len(names) + 1)]
        for id_, k in zip(self.candidates.ids, self.assignment, strict=True):
            has_name = k >= 0 and bool(names[k].strip())
            members[k if has_name else len(names)].append(id_)
        titles = [*(name.strip() for name in names), ""]
        return tuple((t, tuple(ids)) for t, ids in zip(titles, members, strict=True))

    def set_names(self, names: Sequence[str]) -> dict[str, str]:
        """Return the new set name of each plane, by plane id.

        Unassigned planes are included only if sets are replaced.
        """
        return {
            id_: name
            for name, ids in self.groups(names)
            for id_ in ids
            if name or self.candidates.includes_assigned
        }


def assignable_features(studio: Studio, choice: Choice) -> list[TypedFeature]:
    """Return the features of a group whose kind can have a plane and a set.

    Repeated picks are omitted.
    """
    group, type_id = choice
    if group == "selection":
        records = [studio.records.get(i) for i in studio.selection.ids]
        features = [f for f in records if isinstance(f, TypedFeature)]
    else:
        features = list(studio.session.of(TypedFeature))
    if group == "type":
        features = [f for f in features if f.type_id == type_id]
    elif group == "picked":
        features = [f for f in features if get_kind(f).evidence == "picked"]
    features = first_picks(features, studio.records)
    return [f for f in features if "plane" in get_kind(f).orientations and _has_set(f)]


def _has_set(feature: TypedFeature) -> bool:
    return any(a.field == "set_name" for a in get_kind(feature).attributes)


def collect_candidates(studio: Studio, choice: Choice, *, include_assigned: bool) -> Candidates:
    """Return the candidate planes of a group.

    Parameters
    ----------
    studio : Studio
    choice : Choice
    include_assigned : bool
        Whether to include planes that already belong to a set.

    Raises
    ------
    GeometryError
        If there are fewer than three planes.
    """
    features = assignable_features(studio, choice)
    measurements = studio.measured(f.id for f in features)
    planes = [f for f in features if measurements[f.id].plane is not None]
    assigned_planes = [f for f in planes if f.set_name]
    selected_planes = planes if include_assigned else [f for f in planes if not f.set_name]
    if len(selected_planes) < MIN_PLANES:
        code = (
            "sets.too-few-planes"
            if include_assigned or not assigned_planes
            else "sets.too-few-without-set"
        )
        raise GeometryError(Finding(code, count=len(selected_planes), minimum=MIN_PLANES))
    warnings = []
    if assigned_planes:
        code = "sets.replaced" if include_assigned else "sets.left-out"
        warnings.append(Finding(code, count=len(assigned_planes)))
    titles = {type_.id: type_.name for type_ in studio.session.of(FeatureType)}
    positions, findings = _locate_features(studio, selected_planes)
    warnings += findings
    selected_ids = {f.id for f in selected_planes}
    reserved_names = {
        f.set_name
        for f in studio.session.of(TypedFeature)
        if f.set_name and f.id not in selected_ids
    }
    poles = -np.array(
        [p.normal() for f in selected_planes if (p := measurements[f.id].plane) is not None]
    )
    ids = tuple(f.id for f in selected_planes)
    rotations = get_rotation_errors(get_models(studio.records, selected_planes))
    return Candidates(
        ids=ids,
        types=tuple(titles.get(f.type_id, "") for f in selected_planes),
        poles=poles,
        centres=positions,
        rotation_errors=rotations,
        reserved_names=frozenset(reserved_names),
        warnings=tuple(warnings),
        includes_assigned=include_assigned,
    )


def _locate_features(
    studio: Studio, features: Sequence[TypedFeature]
) -> tuple[FloatArray, list[Finding]]:
    """Return the mid-points of features, and warnings about missing positions.

    Returns
    -------
    (n, 3) float64
        Mid-points in the World frame in metres, NaN for features without metric positions.
    list of Finding
        Warnings.
    """
    centres = np.full((len(features), 3), np.nan)
    frames = {m.id: m.frame for f in features if (m := get_model(studio.records, f)) is not None}
    frames = frames or {m.id: m.frame for m in studio.session.of(Model)}
    if len(frames) > 1 and any(frame.kind != "crs" for frame in frames.values()):
        return centres, [Finding("sets.no-common-frame")]
    measurements = studio.measured(f.id for f in features)
    for row, feature in enumerate(features):
        points = measurements[feature.id].points
        if measurements[feature.id].metric and len(points):
            centres[row] = points.mean(axis=0)
    missing_count = int(np.sum(~np.isfinite(centres).all(axis=1)))
    if missing_count == len(centres):
        return centres, [Finding("sets.not-in-metres")]
    if missing_count:
        return centres, [Finding("sets.partly-in-metres", count=missing_count)]
    return centres, []


def propose(candidates: Candidates, options: SetOptions) -> ProposalResult:
    """Propose sets for the candidate planes, separately for each type. Runs in any thread.

    Raises
    ------
    UsageError
        If the seeds are invalid.
    """
    from vomstudio.geology.sets.proposals import propose_sets_of_poles

    sets: list[ProposedSet] = []
    names: list[str] = []
    cones: list[float | None] = []
    warnings: list[Finding] = []
    assignment = np.full(len(candidates.ids), -1)
    types = list(dict.fromkeys(candidates.types))
    for type_name in types:
        rows = np.flatnonzero(np.array(candidates.types) == type_name)
        if len(rows) < max(MIN_PLANES, options.exactly or 0):
            finding = Finding("sets.type-too-small", type=type_name, count=len(rows))
            warnings.append(finding)
            continue
        proposal = propose_sets_of_poles(
            candidates.poles[rows], options, positions=candidates.centres[rows]
        )
        warnings += (item for item in proposal.warnings if item not in warnings)
        for set_ in proposal.sets:
            members = rows[np.array(proposal.assignment) == set_.name]
            assignment[members] = len(sets)
            sets.append(set_)
            names.append(_new_name(type_name, {*candidates.reserved_names, *names}))
            cones.append(_cone(candidates, members, set_))
    return ProposalResult(
        candidates=candidates,
        sets=tuple(sets),
        assignment=tuple(assignment.tolist()),
        names=tuple(names),
        cones_deg=tuple(cones),
        warnings=tuple(warnings),
    )


def _new_name(type_name: str, reserved_names: set[str]) -> str:
    """Return the first unused set name, such as J1 for joints."""
    initial = next((c for c in type_name if c.isalpha()), "S").upper()
    names = (f"{initial}{number}" for number in count(1))
    return next(name for name in names if name not in reserved_names)


def _cone(candidates: Candidates, rows: IntArray, proposed_set: ProposedSet) -> float | None:
    from vomstudio.geology.populations.set_statistics import mean_regions
    from vomstudio.geology.statistics import fisher

    poles, rotations = candidates.poles[rows], candidates.rotation_errors.of(rows)
    if not rotations.has_known_errors:
        return proposed_set.cone95_deg
    _, total = mean_regions(poles, fisher(poles, is_directed=False), False, rotations)
    return None if total is None else total.largest_deg


def proposal_warnings(result: ProposalResult, options: SetOptions) -> list[Finding]:
    """Return warnings about the proposed sets and their candidates."""
    from vomstudio.geology.sets.axial_mixture import MIN_MEMBERS

    warnings = [*result.warnings, *result.candidates.warnings]
    if not result.sets and options == SetOptions():
        warnings.insert(0, Finding("sets.none-distinct", minimum=MIN_MEMBERS))
    if any(set_.kappa is None and set_.n > 1 for set_ in result.sets):
        warnings.append(Finding("sets.parallel"))
    return warnings
