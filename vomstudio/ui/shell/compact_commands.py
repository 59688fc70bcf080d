"""Taking out of a project what nothing can reach any more, and taking that back."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication
from PySide6.QtWidgets import QMessageBox, QWidget

from vomstudio.errors import VomError
from vomstudio.io.project.compaction import Plan
from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.studio import Notice, Studio

_MEGABYTE = 1e6


def commands(studio: Studio, parent: QWidget) -> list[Command]:
    """parent : of the question"""
    return [
        Command("compact_project", "&Compact project…", lambda: _compact(studio, parent), None, (),
                "Take out steps and files that nothing can reach any more",
                lambda: _why_not(studio)),
        Command("take_back_compaction", "Take back the compaction", lambda: _take_back(studio),
                None, (), "Until the project is closed",
                lambda: None if studio.project.is_compacted else "the project was not compacted "
                "since it was opened"),
    ]  # fmt: skip


def _why_not(studio: Studio) -> str | None:
    if studio.session.dirty:
        return "save the project first"
    return "close the unfinished feature first" if studio.open_tool is not None else None


def _compact(studio: Studio, parent: QWidget) -> None:
    plan = studio.project.compaction()
    if plan.nothing:
        studio.info(_tr("Everything in the project can still be reached: nothing was taken out."))
        return
    question = _tr("Compact {0}?").format(studio.project.name)
    answer = QMessageBox.question(parent, question, told(plan))
    if answer != QMessageBox.StandardButton.Yes:
        return
    try:
        studio.project.compact()
    except VomError as error:
        studio.fail(error)
        return
    studio.history_changed.emit()
    words = _tr("The project is compacted. This can be taken back until it is closed.")
    studio.notice.emit(Notice(words, "info", "take_back_compaction"))


def told(plan: Plan) -> str:
    """What would go, before anything does."""
    words = _tr("{0} of {1} rows of its journal hold steps that were undone and then replaced.")
    said = words.format(plan.rows, plan.of_rows)
    if plan.assets:
        files = _tr(" {0} files of {1:.1f} MB belong to such steps.")
        said += files.format(len(plan.assets), plan.asset_bytes / _MEGABYTE)
    return said + _tr(
        "\n\nNothing can reach them any more, but they are part of the record of how the "
        "measurements were made. Everything that can be undone or done again stays. This can be "
        "taken back until the project is closed."
    )


def _take_back(studio: Studio) -> None:
    try:
        studio.project.take_back_compaction()
    except VomError as error:
        studio.fail(error)
        return
    studio.history_changed.emit()
    studio.info(_tr("The journal is as it was before the compaction, with what was done since."))


def _tr(text: str) -> str:
    return QCoreApplication.translate("Compaction", text)
