"""The list from which the features of a panel are chosen: the selection, a type, or a set of it."""

from __future__ import annotations

from vomstudio.core.words import tr
from vomstudio.io.text.repeated_rows import repeats_finding
from vomstudio.project.kinds import kind_of
from vomstudio.project.records import FeatureType, Record, Typed
from vomstudio.project.repeated_features import first_picks
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.number_formatting import natural_sort_key
from vomstudio.ui.base.studio import Studio

Choice = tuple[str, str, str]
"""What is described: "all", "selection", or "type" with the id of a type and "", or "set" with the
name of a set of it."""

ALL: Choice = ("all", "", "")
SELECTED: Choice = ("selection", "", "")


class GroupBox(ComboBox):
    """everything : title of an entry for all features, which is then the first choice; without it
    the first type is"""

    def __init__(self, studio: Studio, all_title: str = "") -> None:
        super().__init__()
        self._studio = studio
        self._always: list[tuple[str, Choice]] = [(tr("Selection"), SELECTED)]
        if all_title:
            self._always.insert(0, (all_title, ALL))
        self.keep_narrow()

    def choice(self) -> Choice:
        """What is chosen."""
        data = self.currentData()
        return self._always[0][1] if data is None else data

    def list_groups(self) -> None:
        """The groups that there are; the one that was chosen stays, where it is still there."""
        chosen = self.choice()
        groups = [*self._always]
        features = [f for f in self._studio.session.of(Typed) if kind_of(f).net is not None]
        for type_ in self._studio.session.of(FeatureType):
            own = [f for f in features if f.type_id == type_.id]
            if not own:
                continue
            groups.append((type_.name, ("type", type_.id, "")))
            names = sorted({f.set_name for f in own if f.set_name}, key=natural_sort_key)
            for name in names:
                title = tr("{type}: {set}", type=type_.name, set=name)
                groups.append((title, ("set", type_.id, name)))
        shown = [(self.itemText(i), self.itemData(i)) for i in range(self.count())]
        if shown == groups:
            return
        known = [choice for _, choice in groups]
        self.clear()
        for title, choice in groups:
            self.addItem(title, choice)
        first = 0 if ALL in known else min(1, len(groups) - 1)
        # Where there was nothing else to choose, nobody has chosen it.
        keep = chosen in known and len(shown) > 1
        self.setCurrentIndex(known.index(chosen) if keep else first)

    def features(self) -> list[Typed]:
        """Those of the choice that stand on a net, without repeats: these are no further
        structures."""
        return first_picks(self._selected_features(), self._studio.records)

    def exclusion_messages(self) -> list[str]:
        """What is said of repeats in the choice."""
        chosen = self._selected_features()
        count = len(chosen) - len(first_picks(chosen, self._studio.records))
        return [repeats_finding(count).message] if count else []

    def _selected_features(self) -> list[Typed]:
        of, type_id, name = self.choice()
        if of == "selection":
            records = self._studio.records
            found: list[Record | None] = [records.get(i) for i in self._studio.selection.ids]
            return [f for f in found if isinstance(f, Typed) and kind_of(f).net is not None]
        return [
            f
            for f in self._studio.session.of(Typed)
            if kind_of(f).net is not None
            and (of == "all" or (f.type_id == type_id and (of == "type" or f.set_name == name)))
        ]
