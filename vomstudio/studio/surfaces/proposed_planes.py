"""Planes of proposals that are shown on the net before they are accepted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from vomstudio.geology.orientation import Plane

_PREFIX = "proposal:"
"""Distinguishes the ids of proposals from those of features."""


@dataclass(frozen=True)
class ProposedPlanes:
    """Planes of the listed proposals of a panel.

    Parameters
    ----------
    owner : str
        Name of the panel.
    title : str
        Translated title, for the legend of the net.
    planes : tuple of Plane
        Planes in the World frame.
    indices : tuple of int
        Index of the proposal of each plane.
    selection : frozenset of int
        Indices of the proposals that are selected in the panel.
    """

    owner: str
    title: str
    planes: tuple[Plane, ...]
    indices: tuple[int, ...]
    selection: frozenset[int] = frozenset()

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the planes on the net, which differ from the ids of features."""
        return tuple(f"{_PREFIX}{self.owner}:{index}" for index in self.indices)

    @property
    def selected_ids(self) -> frozenset[str]:
        """Ids of the selected proposals on the net."""
        return frozenset(f"{_PREFIX}{self.owner}:{index}" for index in self.selection)


def is_proposal(id_: str) -> bool:
    """Return whether an id of the net belongs to a proposal.

    Parameters
    ----------
    id_ : str

    Returns
    -------
    bool
    """
    return id_.startswith(_PREFIX)


def proposal_indices(owner: str, ids: Iterable[str]) -> list[int]:
    """Return the indices of a panel's proposals among ids of the net, in ascending order.

    Parameters
    ----------
    owner : str
    ids : iterable of str

    Returns
    -------
    list of int
    """
    prefix = f"{_PREFIX}{owner}:"
    return sorted(int(id_.removeprefix(prefix)) for id_ in ids if id_.startswith(prefix))
