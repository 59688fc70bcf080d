"""Jobs on the surface of one model: its fields."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.jobs.job import Job, Lane
from vomstudio.jobs.registration_tasks import StandingModel, in_world
from vomstudio.progress import Progress

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Arrays = dict[str, npt.NDArray[np.generic]]


@dataclass(frozen=True)
class FieldsOrder:
    """key : names the model as it stands, so that what `out` holds already need not be made again;
    out : the file for the fields"""

    model: StandingModel
    radius_m: float
    key: str
    out: Path


@dataclass(frozen=True)
class ComputedFields:
    """out : float32 arrays of all points of the model, by the keys of
    `extraction.surface_fields.KINDS`; typical_count : points within the radius"""

    out: Path
    typical_count: int
    warnings: tuple[str, ...]


def _compute(asked: FieldsOrder, progress: Progress) -> ComputedFields:
    import numpy as np

    from vomstudio.extraction.surface_fields import KINDS, surface_fields

    mark = f"{asked.key} {asked.radius_m!r}"
    kept = _kept(asked.out, mark)
    if kept is not None:
        return kept
    found = surface_fields(in_world(asked.model, progress), asked.radius_m, progress)
    arrays: dict[str, Any] = {key: found.values[key] for key in KINDS}
    arrays |= {
        "mark": np.array(mark),
        "count": np.array(found.typical_count),
        "said": np.array(found.warnings, np.str_),
    }
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    part = asked.out.with_name(f"{asked.out.stem}.part.npz")
    np.savez(part, **arrays)
    os.replace(part, asked.out)
    return ComputedFields(asked.out, found.typical_count, found.warnings)


def _kept(out: Path, mark: str) -> ComputedFields | None:
    """What was made of this model with this radius before."""
    import zipfile

    import numpy as np

    from vomstudio.extraction.surface_fields import KINDS

    try:
        with np.load(out) as arrays:
            if str(arrays["mark"]) != mark or not set(KINDS) <= set(arrays.files):
                return None
            said = tuple(str(each) for each in arrays["said"])
            return ComputedFields(out, int(arrays["count"]), said)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None


COMPUTE_FIELDS = Job("compute_fields", Lane.PRODUCTS, FieldsOrder, ComputedFields, _compute)

JOBS = (COMPUTE_FIELDS,)
