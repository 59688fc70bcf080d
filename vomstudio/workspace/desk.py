"""A project worked on without a window, by a command or a script.

Every change is the journalled edit that the window makes, and is made at once, in this thread.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from vomstudio.document import edits
from vomstudio.document.edit import change
from vomstudio.document.kinds.trace import Trace
from vomstudio.document.records import FeatureType, Model, Point, Record, get
from vomstudio.document.session import Session
from vomstudio.errors import DocumentError, GeometryError, InputError, UsageError, VomError
from vomstudio.geometry import transform
from vomstudio.geometry.streaming.surfaces import surface_of
from vomstudio.geometry.surface import Surface
from vomstudio.io.models import model_cache
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.project.folder import Project
from vomstudio.io.settings import Settings
from vomstudio.progress import Progress, Silent
from vomstudio.tools.surroundings import around
from vomstudio.workspace.declared import Declared, placed
from vomstudio.workspace.models import name_of, new_model

Array = npt.NDArray[np.float64]
Named = TypeVar("Named", Model, FeatureType)


@dataclass(frozen=True, eq=False)
class Picks:
    """Points along one line on a model: (n, 3) in World."""

    name: str
    points: Array


@dataclass(frozen=True)
class AddedModel:
    """new : False where the project had this file already"""

    model: Model
    new: bool
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class AddedPicks:
    """skipped : name and reason of each that defines no plane"""

    traces: tuple[Trace, ...]
    skipped: tuple[tuple[str, str], ...]
    warnings: tuple[str, ...]


class ProjectDesk:
    """Changes are in the journal at once; `save` makes them the state that the next who opens the
    project is not asked about."""

    def __init__(self, project: Project, progress: Progress | None = None) -> None:
        self.project = project
        self._progress = progress or Silent()
        self._surfaces: dict[str, Surface | None] = {}

    @classmethod
    @contextlib.contextmanager
    def opened(
        cls, folder: Path, settings: Settings, progress: Progress | None = None
    ) -> Iterator[ProjectDesk]:
        """Raises InputError where it is no project, or open elsewhere."""
        project = Project.open(folder, settings=settings.affecting_results)
        try:
            yield cls(project, progress)
        finally:
            project.close()

    @property
    def session(self) -> Session:
        return self.project.session

    # --- finding -----------------------------------------------------------------------------
    def find_model(self, wanted: str | None) -> Model:
        """By id or name, whatever its case; None for the only one. Raises UsageError."""
        models = self.session.of(Model)
        found = _matching(models, wanted) if wanted is not None else models
        if len(found) == 1:
            return found[0]
        names = ", ".join(model.name for model in models)
        if not models:
            raise UsageError("the project has no model yet; add one first.", field="--model")
        if wanted is None:
            raise UsageError(f"name one of the models: {names}.", field="--model")
        if found:
            ids = ", ".join(model.id for model in found)
            raise UsageError(
                f"several models are called {wanted}; name one by its id: {ids}.", field="--model"
            )
        raise UsageError(f"no model is called {wanted}; there are {names}.", field="--model")

    def find_type(self, wanted: str) -> FeatureType:
        """By name or id, whatever its case. Raises UsageError."""
        types = self.session.of(FeatureType)
        if found := _matching(types, wanted):
            return found[0]
        names = ", ".join(kind.name for kind in types)
        raise UsageError(f"no feature type is called {wanted}; there are {names}.", field="--type")

    # --- changes -----------------------------------------------------------------------------
    def add_model(self, path: Path, declared: Declared | None = None) -> AddedModel:
        """Read a model and make it part of the project. Raises InputError, UsageError."""
        path = path.resolve()
        folder = model_cache.folder_of(path, self.project.cache)
        loaded = model_cache.load(path, folder, self._progress)
        models = self.session.of(Model)
        same = [m for m in models if m.content_hash == loaded.content_hash]
        if same:
            said = f"the project has this file already, as {same[0].name}"
            return AddedModel(same[0], False, (said,))
        placement = placed(
            path, loaded.crs, loaded.turned_about is not None, declared or Declared()
        )
        model = new_model(
            name_of(path),
            self.project.model_path(path),
            loaded.kind,
            loaded.content_hash or "",
            placement.frame,
        )
        self.session.apply(edits.add_model(self.session.records, model))
        self._surfaces[model.id] = surface_of(loaded.data)
        return AddedModel(model, True, (*loaded.warnings, *placement.warnings))

    def add_picks(
        self, picks: Sequence[Picks], model: Model, kind: FeatureType, set_name: str = ""
    ) -> AddedPicks:
        """A trace for each that defines a plane, all as one edit. Raises GeometryError where none
        does."""
        surface, warnings = self._surface(model)
        records: dict[str, Record] = dict(self.session.records)
        traces: list[Trace] = []
        skipped: list[tuple[str, str]] = []
        for pick in picks:
            trace = _trace(pick, model, kind, set_name, surface)
            try:
                edit = edits.add_trace(records, trace)
            except GeometryError as error:
                skipped.append((pick.name, error.message))
                continue
            named = get(edit.after, trace.id, Trace)
            assert named is not None
            records[trace.id] = named
            traces.append(named)
        if not traces:
            first = f"; the first, {skipped[0][0]}: {skipped[0][1]}" if skipped else ""
            raise GeometryError(f"none of the {len(picks)} lines of points is a plane{first}.")
        after: dict[str, Record | None] = {trace.id: trace for trace in traces}
        what = traces[0].name if len(traces) == 1 else f"{len(traces)} traces"
        self.session.apply(change(self.session.records, f"Add {what}", after))
        return AddedPicks(tuple(traces), tuple(skipped), warnings)

    def undo(self) -> str:
        """The label of what was undone. Raises DocumentError where there is nothing."""
        label = self.session.undo_label
        if label is None:
            raise DocumentError("there is nothing to undo")
        self.session.undo()
        return label

    def redo(self) -> str:
        """The label of what was done again. Raises DocumentError where there is nothing."""
        label = self.session.redo_label
        if label is None:
            raise DocumentError("there is nothing to do again")
        self.session.redo()
        return label

    def save(self) -> None:
        if self.session.dirty:
            self.session.save()

    # --- models' data ------------------------------------------------------------------------
    def read_model(self, model: Model) -> LoadedModel:
        """The data of a model of the project, in its file's frame. Raises InputError where its file
        is gone, damaged, or not the one that was measured on."""
        path = self.project.find_model(model)
        if path is None:
            raise InputError(f"{model.name} is not where it was", file=model.path)
        folder = model_cache.folder_of(path, self.project.cache)
        loaded = model_cache.load(path, folder, self._progress)
        if loaded.content_hash != model.content_hash:
            raise InputError(f"has changed since {model.name} was measured on it", file=path)
        return loaded

    def _surface(self, model: Model) -> tuple[Surface | None, tuple[str, ...]]:
        """None, with the reason, where a model's file is not there any more."""
        if model.id in self._surfaces:
            return self._surfaces[model.id], ()
        path = self.project.find_model(model)
        why = f"{model.name} is not where it was ({model.path})"
        found: Surface | None = None
        if path is not None:
            try:
                folder = model_cache.folder_of(path, self.project.cache)
                loaded = model_cache.load(path, folder, self._progress)
                if loaded.content_hash == model.content_hash:
                    found = surface_of(loaded.data)
                else:
                    why = f"{path} has changed since {model.name} was measured on it"
            except VomError as error:
                why = str(error)
        self._surfaces[model.id] = found
        if found is not None:
            return found, ()
        return None, (f"{why}: resolution and outcrop are not known to the new planes",)


def _matching(records: Sequence[Named], wanted: str) -> list[Named]:
    exact = [record for record in records if record.id == wanted]
    return exact or [r for r in records if r.name.casefold() == wanted.casefold()]


def _trace(
    pick: Picks, model: Model, kind: FeatureType, set_name: str, surface: Surface | None
) -> Trace:
    to_file = np.asarray(np.linalg.inv(transform.matrix(model.to_world)), np.float64)
    points = transform.apply(to_file, pick.points)
    vertices: tuple[Point, ...] = tuple((float(x), float(y), float(z)) for x, y, z in points)
    trace = Trace(
        id=edits.new_id("trace"),
        name=pick.name,
        type_id=kind.id,
        model_id=model.id,
        model_hash=model.content_hash,
        vertices=vertices,
        set_name=set_name,
    )
    if surface is None:
        return trace
    resolution, normal = around(surface, vertices)
    return replace(trace, resolution=resolution, outcrop_normal=normal)
