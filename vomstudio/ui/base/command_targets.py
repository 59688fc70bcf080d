"""Targets of commands, such as the selected features and the current model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from PySide6.QtCore import QStandardPaths
from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from vomstudio.core.files.regular import is_folder
from vomstudio.core.findings import Finding
from vomstudio.core.paths import resource
from vomstudio.core.words import tr, tr_n
from vomstudio.project.paths import PROJECT_SUFFIX
from vomstudio.project.records import (
    Feature,
    Model,
    ModelFeature,
    PickedFeature,
    TypedFeature,
    get_feature,
)
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.project.measurement import Measurement

Line = TypeVar("Line", bound=PickedFeature)


def selected_features(studio: Studio) -> list[str]:
    """Return the ids of the selected features, ignoring models and other records."""
    records = studio.records
    return [i for i in studio.selection.ids if get_feature(records, i) is not None]


def missing_feature_finding(studio: Studio) -> Finding | None:
    """Return a finding if no feature is selected, otherwise None."""
    records = studio.records
    # Runs at every click; the first id is nearly always sufficient.
    has_feature = any(get_feature(records, i) is not None for i in studio.selection.ids)
    return None if has_feature else Finding("action.no-feature")


def missing_model_finding(studio: Studio) -> Finding | None:
    """Return a finding if no model is open, otherwise None."""
    return None if studio.models else Finding("action.no-model")


def closed_model_finding(studio: Studio) -> Finding | None:
    """Return a finding if there is no current model or it is not open, otherwise None.

    Parameters
    ----------
    studio : Studio

    Returns
    -------
    Finding or None
    """
    model = current_model(studio)
    if model is None:
        return Finding("action.no-model")
    return None if model.id in studio.models else Finding("model.not-open")


def current_model(studio: Studio) -> Model | None:
    """Return the model that was selected last, directly or through one of its features.

    If no model or feature of a model is selected, return the only model with an undeclared frame,
    or else the last model. Return None if the project has no models.
    """
    records, models = studio.records, studio.session.of(Model)
    for id_ in reversed(studio.selection.ids):
        record = records.get(id_)
        if isinstance(record, ModelFeature):
            record = records.get(record.model_id)
        if isinstance(record, Model):
            return record
    undeclared_models = [m for m in models if m.frame.kind == "undeclared"]
    if len(undeclared_models) == 1:
        return undeclared_models[0]
    return models[-1] if models else None


def current_feature(studio: Studio) -> Feature | None:
    """Return the object that was selected last if it is a feature, otherwise None."""
    current_id = studio.selection.current if studio.has_project else None
    return None if current_id is None else get_feature(studio.records, current_id)


def current_line(studio: Studio, line_class: type[Line], min_vertices: int = 2) -> Line | None:
    """Return the current feature if it is a `line_class` with enough vertices, else None."""
    feature = current_feature(studio)
    return (
        feature
        if isinstance(feature, line_class) and len(feature.vertices) >= min_vertices
        else None
    )


def start_folder(studio: Studio) -> str:
    """Return the start folder of dialogs that open files.

    This is the first existing folder of the recent projects and models, excluding the sample
    project, or else the folder of the user's documents.
    """
    sample = resource("sample").parent
    for text in studio.settings.recent:
        folder = Path(text).parent
        if is_folder(folder) and not folder.is_relative_to(sample):
            return str(folder)
    return documents_folder()


def documents_folder() -> str:
    """Return the folder of the user's documents, or the home folder if it does not exist."""
    documents = QStandardPaths.writableLocation(QStandardPaths.StandardLocation.DocumentsLocation)
    return documents if documents and Path(documents).is_dir() else str(Path.home())


def results_folder(studio: Studio) -> Path:
    """Return the folder that is proposed for results.

    This is the first existing folder of: the folder last used in the project, the parent folder of
    the saved project, the folder last used in another project, the parent folders of recent
    projects, and the folder of the user's documents.

    Parameters
    ----------
    studio : Studio

    Returns
    -------
    Path
    """
    recent_projects = (
        Path(text) for text in studio.settings.recent if text.endswith(PROJECT_SUFFIX)
    )
    folders = [
        studio.results_folder,
        None if studio.project.is_untitled else studio.project.folder.parent,
        Path(studio.settings.results_folder) if studio.settings.results_folder else None,
        *(path.parent for path in recent_projects),
    ]
    existing_folders = (folder for folder in folders if folder is not None and is_folder(folder))
    return next(existing_folders, Path(documents_folder()))


def remember_target(studio: Studio, path: Path) -> None:
    """Store the folder of a result, so that it is proposed for the next result.

    Parameters
    ----------
    studio : Studio
    path : Path
    """
    studio.results_folder = path.absolute().parent
    studio.workspace.preferences.remember_results(studio.results_folder)


def ask_for_target(
    parent: QWidget,
    studio: Studio,
    title: str,
    default_name: str | Path,
    formats: Mapping[str, str],
) -> Path | None:
    """Return the output file that the user selects, or None if the user cancels.

    The folder of the file is proposed for the next result.

    Parameters
    ----------
    parent : QWidget
    studio : Studio
    title : str
        Title of the dialog.
    default_name : str or Path
        Proposed file. A relative path refers to the folder of results.
    formats : mapping of str to str
        Names of the formats, keyed by file extension. The extension of the selected format is
        added if the user does not type one.
    """
    patterns = {f"{label} (*.{suffix})": f".{suffix}" for suffix, label in formats.items()}
    file = results_folder(studio) / default_name
    answer = ask_for_file(parent, title, file, patterns, allow_any_extension=True)
    if answer is None:
        return None
    remember_target(studio, answer[0])
    return answer[0]


def ask_for_file(
    parent: QWidget,
    title: str,
    default_path: Path,
    patterns: Mapping[str, str],
    *,
    allow_any_extension: bool = False,
) -> tuple[Path, str] | None:
    """Return the output file and pattern that the user selects, or None on cancel.

    Parameters
    ----------
    parent : QWidget
    title : str
        Title of the dialog.
    default_path : Path
        Proposed file.
    patterns : mapping of str to str
        File patterns of the dialog, with the ending (such as ".csv" or "_faults.txt") that is
        added if the user does not type its extension.
    allow_any_extension : bool
        Whether the extension of another pattern is also accepted.
    """
    selected_filter = next(
        (p for p, e in patterns.items() if e == default_path.suffix), next(iter(patterns))
    )
    while True:
        filename, pattern = QFileDialog.getSaveFileName(
            parent, title, str(default_path), ";;".join(patterns), selected_filter
        )
        if not filename:
            return None
        if pattern not in patterns:
            pattern = selected_filter
        endings = patterns.values() if allow_any_extension else (patterns[pattern],)
        if Path(filename).suffix.lower() in {Path(f"name{suffix}").suffix for suffix in endings}:
            return Path(filename), pattern
        path = Path(filename + patterns[pattern])
        # The dialog has confirmed the name without the ending, which is a different file.
        if not path.exists() or confirm_replacement(parent, [path.name]):
            return path, pattern
        default_path, selected_filter = Path(filename), pattern


def current_measurement(studio: Studio) -> Measurement | None:
    """Return the measurement of the current typed feature, or None if it is missing."""
    if not studio.has_project or (current_id := studio.selection.current) is None:
        return None
    if not isinstance(studio.records.get(current_id), TypedFeature):
        return None
    return studio.measured([current_id])[current_id]


def confirm_replacement(parent: QWidget, names: list[str]) -> bool:
    """Ask whether existing files may be replaced, and return the answer."""
    answer = QMessageBox.question(
        parent,
        tr("Replace files?"),
        tr_n(
            "{files} already exists. Replace it?",
            "{files} already exist. Replace them?",
            len(names),
            files=escape_markup(", ".join(names)),
        ),
    )
    return answer == QMessageBox.StandardButton.Yes
