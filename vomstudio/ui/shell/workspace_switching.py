"""Which workspace comes by itself, and what stands in the middle of the window."""

from __future__ import annotations

from PySide6.QtCore import QObject

from vomstudio.core.words import tr
from vomstudio.project.records import Feature, Model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.shell.central_area import OutcropPlace
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.workspaces import Workspaces

_PHOTOS, _OUTCROP, _TOOL = "photos", "interpret", "tool"


class WorkspaceFollowing(QObject):
    """What is opened is shown in the workspace that fits; a workspace that has nothing to show yet
    says in one line what it is for."""

    def __init__(
        self,
        studio: Studio,
        survey: PhotoSurvey,
        docks: WindowDocks,
        workspaces: Workspaces,
        place: OutcropPlace,
    ) -> None:
        super().__init__(place)
        self._studio, self._survey = studio, survey
        self._docks, self._workspaces, self._place = docks, workspaces, place
        self._model = self._feature = False
        for signal in (survey.changed, workspaces.moved, workspaces.changed):
            signal.connect(self.refresh)
        for signal in (studio.edited, studio.project_opened, studio.model_loaded):
            signal.connect(self._data_changed)
        workspaces.settled.connect(lambda: studio.keep_window(workspaces.to_keep()))

    def photos_opened(self) -> None:
        """The user has had a folder of photos opened, or wants to see its panel."""
        self._workspaces.switch(_PHOTOS)
        self._docks.bring_forward(_PHOTOS)

    def path_opened(self) -> None:
        """The user has had a model or a project opened."""
        # Elsewhere the outcrop is in sight, and the user chose that workspace.
        if self._workspaces.shown.middle:
            self._workspaces.switch(_OUTCROP)

    def tool_chosen(self) -> None:
        """The user has chosen a tool, which works on the outcrop."""
        if not self._place.shows_outcrop:
            self._workspaces.switch(_OUTCROP)
        self._docks.bring_forward(_TOOL)

    def _data_changed(self, *_: object) -> None:
        # There may be thousands: the first of each will do.
        records = self._studio.records.values()
        self._model = any(isinstance(record, Model) for record in records)
        self._feature = any(isinstance(record, Feature) for record in records)
        self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the outcrop, or photos in its place, and the line of an empty workspace."""
        shown, model = self._workspaces.shown, self._model
        filling = self._workspaces.filling
        instead = self._docks.get(filling or shown.middle)
        self._place.show_outcrop(
            (model and not filling) or instead is None or instead.isHidden() or instead.isFloating()
        )
        by_photos = shown.middle and not model
        if by_photos:
            self._place.name_outcrop(self._docks[shown.middle].windowTitle(), shown.icon)
        else:
            self._place.name_outcrop(tr("Outcrop"), "image-filter-hdr")
        if shown.needs == "model":
            empty = not model
        elif shown.needs == "photos":
            empty = self._survey.folder is None
        else:
            empty = not self._feature
        self._place.say_purpose(tr(shown.purpose) if empty else "")
