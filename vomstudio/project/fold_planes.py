"""Selection of planes for the computation of a fold axis, for net, statistics and views."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.geology.common_rotation_errors import RotationErrors
from vomstudio.geology.fold_planes import ExcludedRows, FoldFilter, select_planes
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.project.measurement import Measurement, Records
from vomstudio.project.records import TypedFeature
from vomstudio.project.registration_errors import get_models, get_rotation_errors, max_bowing_deg
from vomstudio.project.repeated_features import first_picks


@dataclass(frozen=True, eq=False)
class FoldPlanes:
    """Planes of one fold in the World frame.

    Parameters
    ----------
    features : tuple of TypedFeature
    azimuth_deg, dip_deg : (n,) float64
        Dip directions and dips.
    rotation_errors : RotationErrors or None
        Rotation errors of the registrations, or None if the planes have been rotated.
    bowed_deg : float or None
        Difference in dip between the edges of the most strongly bowed model, or None if unknown.
    not_good : int or None
        Number of planes whose verdict is not good, or None if no plane has a verdict.
    left_out : tuple of ExcludedRows
        Planes of the same kind that are not used, with the reasons.
    """

    features: tuple[TypedFeature, ...]
    azimuth_deg: FloatArray
    dip_deg: FloatArray
    rotation_errors: RotationErrors | None
    bowed_deg: float | None
    not_good: int | None
    left_out: tuple[ExcludedRows, ...]

    def __len__(self) -> int:
        return len(self.features)

    def axis(self) -> FoldAxis:
        """Return the fold axis, which is computed only once for the same planes.

        Raises
        ------
        GeometryError
            If the planes do not define an axis.
        """
        rotation_errors = self.rotation_errors
        has_known_rotation_errors = rotation_errors is not None and rotation_errors.has_known_errors
        axis = _axis(
            self.azimuth_deg.tobytes(),
            self.dip_deg.tobytes(),
            (rotation_errors.group.tobytes(), rotation_errors.rotations.tobytes())
            if has_known_rotation_errors and rotation_errors
            else None,
            self.bowed_deg,
            tuple(feature.name or feature.id for feature in self.features),
            tuple(bool(getattr(feature, "overturned", False)) for feature in self.features),
        )
        if isinstance(axis, GeometryError):
            raise axis
        return axis


@lru_cache(maxsize=8)
def _axis(
    azimuth: bytes,
    dip: bytes,
    rotation_errors: tuple[bytes, bytes] | None,
    bowing_deg: float | None,
    names: tuple[str, ...],
    overturned: tuple[bool, ...],
) -> FoldAxis | GeometryError:
    known_rotation_errors = rotation_errors and RotationErrors(
        np.frombuffer(rotation_errors[0], np.int64),
        np.frombuffer(rotation_errors[1]).reshape(-1, 3, 3),
    )
    try:
        return fold_axis(
            np.frombuffer(azimuth),
            np.frombuffer(dip),
            known_rotation_errors,
            bowing_deg,
            names=names,
            overturned=overturned,
        )
    except GeometryError as error:
        return error


def fold_planes(
    records: Records,
    features: Iterable[TypedFeature],
    measurements: Mapping[str, Measurement],
    fold_filter: FoldFilter,
) -> FoldPlanes:
    """Select the planes of a fold from the features of one type.

    Repeats of other features and features without a plane are excluded.
    """
    planar_first_picks = [
        first_pick
        for first_pick in first_picks(features, records)
        if measurements[first_pick.id].plane is not None
    ]
    verdicts = [
        measurements[planar_first_pick.id].verdict for planar_first_pick in planar_first_picks
    ]
    selection = select_planes(
        [None if verdict is None else verdict.quality for verdict in verdicts],
        [planar_first_pick.set_name for planar_first_pick in planar_first_picks],
        fold_filter,
    )
    used_features = [
        planar_first_pick
        for planar_first_pick, is_used in zip(planar_first_picks, selection.is_used, strict=True)
        if is_used
    ]
    planes = [
        plane
        for used_feature in used_features
        if (plane := measurements[used_feature.id].plane) is not None
    ]
    models = get_models(records, used_features)
    return FoldPlanes(
        tuple(used_features),
        np.array([plane.dip_direction_deg for plane in planes], np.float64),
        np.array([plane.dip_deg for plane in planes], np.float64),
        get_rotation_errors(models),
        max_bowing_deg(models),
        selection.not_good,
        selection.left_out,
    )
