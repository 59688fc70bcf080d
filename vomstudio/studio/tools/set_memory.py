"""Set last used with each feature type."""

from __future__ import annotations


class SetMemory:
    """Set of the next feature, remembered for each feature type."""

    def __init__(self) -> None:
        self._sets: dict[str, str] = {}

    def clear(self) -> None:
        """Clear all sets because another project is opened."""
        self._sets.clear()

    def choose_set(self, current: tuple[str, str], type_id: str, set_name: str) -> str:
        """Return the set of the next feature after the user has changed the type or set.

        Parameters
        ----------
        current : tuple of str
            Present type and set, which are remembered.
        type_id, set_name : str
            Chosen type and set. A set that was not changed together with the type belongs to the
            previous type, so it is replaced by the last set of the new type.
        """
        self._sets[current[0]] = current[1]
        if type_id != current[0] and set_name == current[1]:
            return self._sets.get(type_id, "")
        return set_name
