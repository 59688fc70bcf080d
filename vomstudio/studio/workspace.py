"""Connection of all parts of the application, with or without a window."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal
from vomstudio.core.words import tr
from vomstudio.io.settings import Settings
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds import GROUPS, visibility_group
from vomstudio.project.records import Feature, Model, get_feature
from vomstudio.project.selection import Selection
from vomstudio.studio.background import Background
from vomstudio.studio.blind_repeats import BlindRepeats
from vomstudio.studio.derived_quantities import DerivedQuantities
from vomstudio.studio.display import Display
from vomstudio.studio.editing import Editing
from vomstudio.studio.fold_choice import FoldChoice
from vomstudio.studio.history import History
from vomstudio.studio.layer_export import GisLayers
from vomstudio.studio.model_loading import ModelLoader
from vomstudio.studio.models import Models
from vomstudio.studio.notices import Notices
from vomstudio.studio.owner_thread import BlockingRunner, Call, Post, TimerFactory, run_immediately
from vomstudio.studio.path_finding import PathFinding
from vomstudio.studio.photos import PhotoLinks
from vomstudio.studio.preferences import Preferences
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs
from vomstudio.studio.surfaces.face_grids import FaceGrids
from vomstudio.studio.surfaces.facet_proposals import FacetProposals
from vomstudio.studio.surfaces.model_cutting import ModelCutting
from vomstudio.studio.surfaces.outcrop_elements import ModelElements
from vomstudio.studio.surfaces.surface_fields import ModelFields
from vomstudio.studio.surfaces.trace_proposals import TraceProposals
from vomstudio.studio.surroundings_update import SurroundingsUpdate
from vomstudio.studio.tool_host import ToolHost
from vomstudio.studio.visibility import Visibility


class Workspace:
    """Container that connects the parts of the application, with actions on several parts.

    Views must connect to these signals and never to a session, because a session ends when
    another project is opened.

    Attributes
    ----------
    project_opened : Signal
        Emitted after another project has been opened, before its models are loaded.
    edited, history_changed : Signal
        Emitted after derived quantities have been updated.
    recovery_found : Signal
        Emits projects that a crash left open.
    """

    def __init__(
        self,
        settings: Settings,
        post: Post,
        later: TimerFactory,
        run_blocking: BlockingRunner = run_immediately,
    ) -> None:
        self.project_opened: Signal[()] = Signal()
        self.edited: Signal[Edit] = Signal()
        self.history_changed: Signal[()] = Signal()
        self.recovery_found: Signal[list[Path]] = Signal()
        self.settings = settings
        self.notices = Notices()
        self._is_closed = False

        def hand_over(call: Call) -> None:
            # The receiver may have been deleted by the time of the call.
            post(lambda: None if self._is_closed else call())

        def background(name: str, **options: Any) -> Background:
            new_background = Background(post, name, **options)
            self._backgrounds.append(new_background)
            return new_background

        self._backgrounds: list[Background] = []
        self.preferences = Preferences(settings, self.notices, hand_over, later)
        self.jobs = Jobs(hand_over)
        self.selection = Selection()
        self.projects = Projects(self.preferences, self.notices, run_blocking)
        self.editing = Editing(self.projects, self.notices)
        self.derived = DerivedQuantities(self.projects, lambda: settings.thresholds)
        self.visibility = Visibility(self.projects)
        self.fold = FoldChoice(self.projects, self.derived, self.selection)
        self.display = Display(lambda values: self.projects.store_view("display", values), later)
        self.loader = ModelLoader(
            self.jobs,
            background("models", is_daemon=False),
            background("streams", niceness=5),
            later,
            lambda: settings.point_budget,
        )
        self.models = Models(
            self.projects, self.editing, self.loader, self.jobs, self.preferences, self.notices
        )
        self.elements = ModelElements(
            self.projects,
            self.models,
            self.visibility,
            background("neighbours"),
            ModelCutting(self.projects, self.models, self.jobs, self.notices),
        )
        self.photos = PhotoLinks(
            self.projects, self.models, self.notices, background("photos of models")
        )
        self.tools = ToolHost(
            self.projects,
            self.models,
            self.derived,
            self.selection,
            self.preferences,
            self.notices,
            PathFinding(self.models, background("path finding", threads=1), self.photos.of),
            self.elements,
            background("tool"),
            self.visibility,
            hand_over,
        )
        self.surroundings = SurroundingsUpdate(
            self.projects, self.models, self.editing, self.notices, background("surroundings")
        )
        self.fields = ModelFields(
            self.projects,
            self.models,
            self.derived,
            self.display,
            self.jobs,
            background("surface fields"),
        )
        self.facets = FacetProposals(
            self.projects,
            self.models,
            self.editing,
            self.display,
            self.jobs,
            lambda: settings.thresholds,
            background("facets"),
            self.derived.store_expected_measurements,
        )
        self.proposed_traces = TraceProposals(
            self.projects,
            self.editing,
            self.tools,
            self.jobs,
            lambda: settings.thresholds,
            background("proposed traces"),
        )
        self.grids = FaceGrids(self.projects, self.models, background("cells"))
        self.repeats = BlindRepeats(
            self.projects, self.tools, self.visibility, self.selection, hand_over
        )
        self.history = History(self.projects, self.editing, self.tools, self.notices)
        self.layers = GisLayers(self.projects, self.jobs, self.notices, later)
        self._join()

    def _join(self) -> None:
        self.loader.problem.connect(lambda finding: self.notices.warn(finding, "error"))
        self.projects.leaving.connect(self._leave)
        self.projects.opened.connect(self._begin_project)
        self.projects.edited.connect(self._follow_edit)
        self.projects.history_changed.connect(self.history_changed.emit)
        self.projects.saved.connect(self.layers.write)
        self.tools.undo_changed.connect(self.history_changed.emit)
        self.models.loaded.connect(self.photos.look)
        self.models.loaded.connect(self.elements.loaded)
        self.models.loaded.connect(self.surroundings.offer_update)

    # --- change of the project ----------------------------------------------------------------
    def _begin_project(self) -> None:
        session = self.projects.session
        self.derived.begin()
        self.visibility.load()
        self.elements.load()
        self.tools.begin()
        self.display.load(self.projects.view("display"))
        self.selection.set(())
        self.fold.begin()
        self.photos.forget_all()
        self.fields.begin()
        self.facets.drop()
        self.proposed_traces.drop()
        self.grids.begin()
        self.project_opened.emit()
        self.history_changed.emit()
        if session.is_recovered:
            self.notices.warn(Finding("project.recovered"))
        self._report_skipped(self.projects.project.problems)
        for model in session.of(Model):
            self.models.load(model)
        if session.draft is not None:
            self.tools.restore(session.draft.state)

    def _report_skipped(self, problems: Sequence[Finding]) -> None:
        for problem in problems:
            self.notices.warn(_omitted_files_finding((problem,)))
        if len(problems) > 1:
            # The bar shows only the newest notice.
            self.notices.warn(_omitted_files_finding(problems))

    def _leave(self) -> None:
        self.repeats.clear_state()
        self.facets.drop()
        self.proposed_traces.drop()
        self.display.flush()
        self.loader.forget_all()
        self.layers.write_pending()
        self.tools.clear_state()
        self.elements.clear_state()
        self.history.clear_state()
        self.models.open_models.clear()

    def offer_recovery(self, excluded_folders: Collection[Path] = ()) -> None:
        """Emit `recovery_found` if a crash left projects open, except in `excluded_folders`."""
        if folders := self.projects.unclosed(excluded_folders):
            self.recovery_found.emit(folders)

    @property
    def has_work_to_save(self) -> bool:
        """Whether closing now would discard unsaved work."""
        session, is_open = self.projects.session, self.tools.open_tool is not None
        has_reconstructions = self.projects.unsaved_reconstructions
        if (
            self.projects.is_complete_on_disk
            and not session.dirty
            and not is_open
            and not has_reconstructions
        ):
            return False
        return (
            bool(session.features())
            or is_open
            or not self.projects.project.is_untitled
            or has_reconstructions
        )

    def discard(self) -> None:
        """Undo all unsaved changes, which stay in the history. Raises VomError."""
        if (tool := self.tools.open_tool) is not None:
            tool.cancel()
        self.projects.discard()

    def close(self) -> None:
        """Close the project and stop all workers despite errors when the program ends."""
        self._is_closed = True
        for background in self._backgrounds:
            background.stop()
        with ExitStack() as steps:
            steps.callback(self.jobs.close)
            steps.callback(self.layers.finish)
            steps.callback(self.projects.leave)

    # --- edits -------------------------------------------------------------------------------
    def _follow_edit(self, edit: Edit) -> None:
        for id_, record in edit.after.items():
            if isinstance(record, Model) and id_ not in self.models.open_models:
                self.models.load(record)
        self.tools.keep_next_type()
        self._show_hidden_types(edit)
        self._report_duplicate_names(edit)
        self.derived.refresh(edit)
        self.selection.retain(self.projects.records)
        self.edited.emit(edit)
        self.photos.follow_edit(edit)
        self.fields.follow_edit(edit)
        self.facets.follow_edit(edit)
        self.proposed_traces.follow_edit(edit)
        self.grids.follow_edit(edit)
        self.repeats.follow_edit(edit)
        self.tools.document_changed()
        self.layers.write_soon()

    def _show_hidden_types(self, edit: Edit) -> None:
        """Show the types of new features, which would otherwise vanish when they are added."""
        new_features = [
            r for i, r in edit.after.items() if isinstance(r, Feature) and not edit.before[i]
        ]
        hidden_groups = {
            group for f in new_features if not self.visibility.visible(group := visibility_group(f))
        }
        if hidden_groups:
            self.visibility.set_visible(hidden_groups, True)
            names = sorted(self._group_name(group) for group in hidden_groups)
            self.notices.info(Finding("type.shown-again", types=", ".join(names)))

    def _group_name(self, group: str) -> str:
        record = self.projects.records.get(group)
        titles = {item.id: tr(item.title) for item in GROUPS}
        return titles.get(group, group) if record is None else record.name

    def _report_duplicate_names(self, edit: Edit) -> None:
        """Warn about equally named features, because tables and layers identify them by name.

        Only renamed and imported features are checked, because a single new feature is named by
        the next free number.
        """
        new_records = {id_: r for id_, r in edit.after.items() if isinstance(r, Feature) and r.name}
        old_records = {id_: edit.before[id_] for id_ in new_records}
        renamed_ids = {
            i
            for i, r in old_records.items()
            if isinstance(r, Feature) and r.name != new_records[i].name
        }
        added_ids = {i for i, r in old_records.items() if r is None}
        checked_ids = renamed_ids | (added_ids if len(added_ids) > 1 else set())
        if not checked_ids:
            return
        name_counts = Counter(feature.name for feature in self.projects.session.features())
        duplicate_names = sorted(
            {new_records[i].name for i in checked_ids if name_counts[new_records[i].name] > 1}
        )
        if duplicate_names:
            self.notices.warn(
                Finding(
                    "feature.same-names",
                    count=len(duplicate_names),
                    names=", ".join(duplicate_names[:5])
                    + (" …" if len(duplicate_names) > 5 else ""),
                )
            )

    def delete_selected(self, excluded_ids: Collection[str] = ()) -> bool:
        """Delete the selected features in one edit. Return False if nothing was deleted."""
        records = self.projects.records
        feature_ids = [i for i in self.selection.ids if get_feature(records, i) is not None]
        ids = [i for i in feature_ids if i not in excluded_ids]
        return bool(ids) and self.editing.attempt(edits.delete, ids)


def _omitted_files_finding(problems: Sequence[Finding]) -> Finding:
    example = problems[0]
    return Finding(
        "project.parts-left-out",
        count=len(problems),
        first=example.message,
        first_code=example.code,
    )
