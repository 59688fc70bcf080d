"""Commands that remove unreachable edits and files from a project, and restore them."""

from __future__ import annotations

from PySide6.QtWidgets import QMessageBox, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.project.compaction import CompactionPlan
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Notice, Studio

_BYTES_PER_MB = 1e6


def commands(studio: Studio, parent: QWidget) -> list[Command]:
    """Create the commands that compact a project and undo the compaction."""
    return [
        Command(
            "compact_project",
            tr("&Compact project…"),
            lambda: _compact(studio, parent),
            tip=tr("Remove edits and files that undo cannot restore."),
            disabled_reason=lambda: _disabled_reason(studio),
        ),
        Command(
            "take_back_compaction",
            tr("Undo compaction"),
            lambda: _undo_compaction(studio),
            tip=tr("Restore the removed edits, until the project is closed."),
            disabled_reason=lambda: (
                None if studio.project.is_compacted else Finding("compaction.not-done")
            ),
        ),
    ]


def _disabled_reason(studio: Studio) -> Finding | None:
    if studio.session.dirty:
        return Finding("compaction.unsaved")
    return Finding("feature.open") if studio.open_tool is not None else None


def _compact(studio: Studio, parent: QWidget) -> None:
    plan = studio.project.compaction()
    if plan.is_empty:
        studio.info(Finding("compaction.nothing-to-remove"))
        return
    question = tr("Compact {project}?", project=studio.project.name)
    answer = QMessageBox.question(parent, question, compaction_text(plan))
    if answer != QMessageBox.StandardButton.Yes:
        return
    try:
        studio.project.compact()
    except VomError as error:
        studio.fail(error)
        return
    studio.history_changed.emit()
    studio.notice.emit(Notice(Finding("compaction.done"), "info", "take_back_compaction"))


def compaction_text(plan: CompactionPlan) -> str:
    """Describe what a compaction removes and its consequences, for a question to the user."""
    sentences = [
        tr(
            "{rows} of {total} journal rows contain edits that were undone and then replaced.",
            rows=plan.rows,
            total=plan.total_rows,
        )
    ]
    if plan.assets:
        sentences.append(
            tr_n(
                "{count} file of {size:.1f} MB belongs to such edits.",
                "{count} files of {size:.1f} MB belong to such edits.",
                len(plan.assets),
                size=plan.asset_bytes / _BYTES_PER_MB,
            )
        )
    if plan.stages:
        sentences.append(
            tr_n(
                "{count} stage of reconstructions ({size:.1f} MB) belongs to earlier photos or"
                " settings and would have to be computed again.",
                "{count} stages of reconstructions ({size:.1f} MB) belong to earlier photos or"
                " settings and would have to be computed again.",
                len(plan.stages),
                size=plan.stage_bytes / _BYTES_PER_MB,
            )
        )
    consequence = tr(
        "Undo and redo cannot reach these edits, but they document your measurements. Compaction of"
        " the journal can be undone until the project is closed."
    )
    return f"{' '.join(sentences)}\n\n{consequence}"


def _undo_compaction(studio: Studio) -> None:
    try:
        studio.project.undo_compaction()
    except VomError as error:
        studio.fail(error)
        return
    studio.history_changed.emit()
    studio.info(Finding("compaction.undone"))
