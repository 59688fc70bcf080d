"""What a tool is given, as plain data; everything it says and shows is kept."""

from __future__ import annotations

import numpy as np

from vomstudio.project.measurement_cache import measure_all
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent


class Paths:
    """A finder of paths whose answers the test gives."""

    def __init__(self) -> None:
        self.asked: list = []
        self.photos: list[str] = []

    def follow(self, model_id, cost, ends, *, photo="", is_live, callback):
        self.asked.append((model_id, cost, ends, is_live, callback))
        self.photos.append(photo)


class Elements:
    """The faces and points of models that are given."""

    def __init__(self) -> None:
        self.models: dict = {}
        self.look = None
        self.masks: dict = {}
        self.near: dict = {}
        self.is_slow = False
        self.later: list = []
        self.cut: list = []

    def view_snapshot(self):
        return self.look

    def shown(self):
        return list(self.models)

    def data(self, model_id):
        return self.models.get(model_id)

    def spacing(self, model_id):
        return 0.1

    def neighbours(self, model_id, then):
        from vomstudio.extraction.selection.neighbours import build_neighbour_graph

        if self.is_slow:
            self.later.append(then)
            return None
        if model_id not in self.near:
            self.near[model_id] = build_neighbour_graph(self.models[model_id], 0.1)
        return self.near[model_id]

    def be_done(self):
        """The neighbour graph has been built."""
        self.is_slow = False
        later, self.later = self.later, []
        # Only the last caller is called.
        for then in later[-1:]:
            then()

    def hidden(self, model_id):
        return self.masks.get(model_id)

    def hide(self, model_id, hidden):
        self.masks.pop(model_id, None)
        if hidden is not None and hidden.any():
            self.masks[model_id] = hidden

    def cut_out(self, model_id, mask):
        self.cut.append((model_id, mask))


class Context:
    """A ToolContext without a window."""

    def __init__(self, session, journal) -> None:
        self.session, self.journal = session, journal
        self.next_type_id, self.next_set = "bedding", ""
        self.shown: list = []
        self.said: list[str] = []
        self.made: list[str] = []
        self.rows_when_shown: list[int] = []
        self.feature_discarded: list = []
        self.selected: list = []
        self.paths = Paths()
        self.elements = Elements()

    def set_next_type(self, type_id, set_name):
        self.next_type_id, self.next_set = type_id, set_name

    def surface(self, model_id):
        return None

    def run_in_background(self, work, then):
        then(work())

    def measure(self, feature):
        return measure_all(self.session.records, [feature])[0]

    def format_attitude(self, measurement):
        return measurement.attitude()

    def show(self, preview):
        self.shown.append(preview)
        self.rows_when_shown.append(len(self.journal.kept))

    def report(self, message):
        self.said.append(message)

    hint = report

    def tool_changed(self):
        pass

    def report_discarded(self, report_discarded):
        self.feature_discarded.append(report_discarded)

    def report_created(self, feature_id):
        self.made.append(feature_id)

    def world_positions(self, hits):
        return np.array([hit.position for hit in hits]).reshape(-1, 3)

    def feature_positions(self):
        points = {f.id: self.measure(f).points for f in self.session.features()}
        return {id_: each.mean(axis=0) for id_, each in points.items()}

    def select(self, feature_ids, how):
        self.selected.append((tuple(feature_ids), how))


def hit(point, model_id="m1") -> Hit:
    return Hit(model_id, "face", 0, tuple(map(float, point)))


def event(kind=Pointer.CLICK, at=None, handle=None, ctrl=False, model_id="m1", button=Button.LEFT):
    found = None if at is None else hit(at, model_id)
    return PointerEvent(kind, 0.0, 0.0, button, False, ctrl, found, handle)
