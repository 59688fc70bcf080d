"""Lengths that were measured on a model, and a scale that is known beforehand, as observations of
its place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.errors import UsageError
from vomstudio.io.control.observation_tables import Pairs, ScaleBar
from vomstudio.registration.compass_evidence import Segment
from vomstudio.registration.observations import KeptScale, Lengths, Observed, Points
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

_TAPE = 0.005
"""One sigma of a length by tape whose ends are picked on a model, as a share of it."""
KEPT = 1e-4
"""One sigma of a scale that is kept, as a share of it."""


def lengths_of(
    bars: Sequence[ScaleBar], segments: Sequence[Segment], pairs: Pairs | None
) -> list[Lengths]:
    """Scale bars between points of `pairs` that are no checks, and lengths between two places.
    Raises UsageError for a bar between points that are not there, and for two ends at one place."""
    labels, first, second, length, sigma = [], [], [], [], []
    places = {} if pairs is None else dict(zip(pairs.labels, pairs.model, strict=True))
    for bar in bars:
        for label in (bar.first, bar.second):
            if label not in places:
                raise UsageError(
                    tr(
                        "The scale bar names the point {label}, which is not among the pairs. "
                        "Add it, with its place on the model.",
                        label=label,
                    ),
                    field="--scale-bars",
                )
        if bar.check:
            continue
        labels.append(f"{bar.first} - {bar.second}")
        first.append(places[bar.first])
        second.append(places[bar.second])
        length.append(bar.length_m)
        sigma.append(np.nan if bar.sigma_m is None else bar.sigma_m)
    for number, line in enumerate(segments, 1):
        labels.append(line.label or tr("length {number}", number=number))
        first.append(np.asarray(line.first))
        second.append(np.asarray(line.second))
        length.append(line.value)
        sigma.append(_TAPE * line.value if line.sigma is None else line.sigma)
    if not labels:
        return []
    ends = np.array(first, np.float64), np.array(second, np.float64)
    short = ~(np.linalg.norm(ends[1] - ends[0], axis=1) > 0)
    if short.any():
        number = int(np.argmax(short))
        raise UsageError(
            tr("Both ends of a length are at one place of the model. Choose two places."),
            field="--scale-bars" if number < len(labels) - len(segments) else "--scale",
        )
    return [Lengths(labels, *ends, np.array(length), np.array(sigma))]


def kept_scale(scale: float, kinds: Sequence[Observed], extent: Array | None) -> list[KeptScale]:
    """A scale that is known, in metres per unit of the model, as a length across the model.

    extent : (n, 3) points of the model, None to take the points among `kinds`
    """
    places = [] if extent is None or not len(extent) else [extent]
    places = places or [kind.model for kind in kinds if isinstance(kind, Points)]
    middle, size = np.zeros(3), 1.0
    if places:
        every = np.concatenate(places)
        middle = every.mean(axis=0)
        size = float(np.linalg.norm(np.ptp(every, axis=0))) or 1.0
    end = middle + [size, 0.0, 0.0]
    # One unit is as long everywhere and in every direction: which one is taken does not matter.
    length = np.array([scale * size])
    label = tr("the scale that is kept")
    return [KeptScale([label], middle[None], end[None], length, KEPT * length)]
