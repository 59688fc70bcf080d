"""List of the feature groups of a panel: selection, type or set."""

from __future__ import annotations

from vomstudio.core.words import tr
from vomstudio.io.text.repeated_rows import repeats_finding
from vomstudio.project.kinds import get_kind
from vomstudio.project.records import FeatureType, Record, TypedFeature
from vomstudio.project.repeated_features import first_picks
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.number_formatting import natural_sort_key
from vomstudio.ui.base.studio import Studio

Choice = tuple[str, str, str]
"""Group of features: "all", "selection", "type" with the id of the type, or "set" with the id of
the type and the name of the set."""

ALL: Choice = ("all", "", "")
SELECTED: Choice = ("selection", "", "")


class GroupBox(ComboBox):
    """List of groups of features.

    Parameters
    ----------
    all_title : str
        Title of the entry for all features, which is the default. Without this entry, the
        default is the first type.
    """

    def __init__(self, studio: Studio, all_title: str = "") -> None:
        super().__init__()
        self._studio = studio
        self._fixed_entries: list[tuple[str, Choice]] = [(tr("Selection"), SELECTED)]
        if all_title:
            self._fixed_entries.insert(0, (all_title, ALL))
        self.keep_narrow()

    def choice(self) -> Choice:
        """Return the selected group."""
        data = self.currentData()
        return self._fixed_entries[0][1] if data is None else data

    def list_groups(self) -> None:
        """List the existing groups, keeping the selected group if it still exists."""
        previous = self.choice()
        groups = [*self._fixed_entries]
        features = [f for f in self._studio.session.of(TypedFeature) if get_kind(f).net is not None]
        for type_ in self._studio.session.of(FeatureType):
            members = [f for f in features if f.type_id == type_.id]
            if not members:
                continue
            groups.append((type_.name, ("type", type_.id, "")))
            names = sorted({f.set_name for f in members if f.set_name}, key=natural_sort_key)
            for name in names:
                title = tr("{type}: {set}", type=type_.name, set=name)
                groups.append((title, ("set", type_.id, name)))
        entries = [(self.itemText(i), self.itemData(i)) for i in range(self.count())]
        if entries == groups:
            return
        choices = [choice for _, choice in groups]
        self.clear()
        for title, choice in groups:
            self.addItem(title, choice)
        default_index = 0 if ALL in choices else min(1, len(groups) - 1)
        # If it was the only entry, it was not selected by the user.
        keep_previous = previous in choices and len(entries) > 1
        self.setCurrentIndex(choices.index(previous) if keep_previous else default_index)

    def features(self) -> list[TypedFeature]:
        """Return the features of the group that can be plotted on a net, without repeats."""
        return first_picks(self._selected_features(), self._studio.records)

    def exclusion_messages(self) -> list[str]:
        """Return messages about repeats that are excluded from the group."""
        selected_features = self._selected_features()
        count = len(selected_features) - len(first_picks(selected_features, self._studio.records))
        return [repeats_finding(count).message] if count else []

    def _selected_features(self) -> list[TypedFeature]:
        choice_kind, type_id, name = self.choice()
        if choice_kind == "selection":
            records = self._studio.records
            selected_records: list[Record | None] = [
                records.get(i) for i in self._studio.selection.ids
            ]
            return [
                f
                for f in selected_records
                if isinstance(f, TypedFeature) and get_kind(f).net is not None
            ]
        return [
            f
            for f in self._studio.session.of(TypedFeature)
            if get_kind(f).net is not None
            and (
                choice_kind == "all"
                or (f.type_id == type_id and (choice_kind == "type" or f.set_name == name))
            )
        ]
