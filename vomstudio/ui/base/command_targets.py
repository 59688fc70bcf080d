"""What a command is about: the chosen features, the current model, the folder to begin in."""

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
from vomstudio.project.records import Feature, Model, OnAModel, Picked, Typed, get_feature
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.project.measurement import Measurement

Line = TypeVar("Line", bound=Picked)


def selected_features(studio: Studio) -> list[str]:
    """The ids of the selected features; models and other records are left out."""
    records = studio.records
    return [i for i in studio.selection.ids if get_feature(records, i) is not None]


def why_no_feature(studio: Studio) -> Finding | None:
    """Return that no feature is selected; None if one is."""
    records = studio.records
    # Asked at every click, and nearly always told by the first one.
    chosen = any(get_feature(records, i) is not None for i in studio.selection.ids)
    return None if chosen else Finding("action.no-feature")


def why_no_model(studio: Studio) -> Finding | None:
    """Return that no model is open; None if one is."""
    return None if studio.models else Finding("action.no-model")


def current_model(studio: Studio) -> Model | None:
    """The selected model, or the only one, or the one of the selected feature."""
    records, models = studio.records, studio.session.of(Model)
    for id_ in reversed(studio.selection.ids):
        record = records.get(id_)
        if isinstance(record, OnAModel):
            record = records.get(record.model_id)
        if isinstance(record, Model):
            return record
    undeclared = [m for m in models if m.frame.kind == "undeclared"]
    if len(undeclared) == 1:
        return undeclared[0]
    return models[-1] if models else None


def current_feature(studio: Studio) -> Feature | None:
    """Return the feature that was selected last; None without a selection."""
    current = studio.selection.current if studio.has_project else None
    return None if current is None else get_feature(studio.records, current)


def current_line(studio: Studio, kind: type[Line], min_vertices: int = 2) -> Line | None:
    """Return the current feature if it is of this kind and has enough vertices."""
    feature = current_feature(studio)
    return feature if isinstance(feature, kind) and len(feature.vertices) >= min_vertices else None


def start_folder(studio: Studio) -> str:
    """Where dialogs that ask for a file begin: beside what was open last, and never among the
    program's own files, as those of the sample are."""
    own = resource("sample").parent
    for text in studio.settings.recent:
        folder = Path(text).parent
        if is_folder(folder) and not folder.is_relative_to(own):
            return str(folder)
    documents = QStandardPaths.writableLocation(QStandardPaths.StandardLocation.DocumentsLocation)
    return documents if documents and Path(documents).is_dir() else str(Path.home())


def ask_for_target(
    parent: QWidget, studio: Studio, title: str, name: str, formats: Mapping[str, str]
) -> Path | None:
    """The file that the user chooses to write; None for none. name : that is proposed; formats :
    their names by their endings, the ending of the chosen one is added where none is typed"""
    patterns = {f"{said} (*.{ending})": f".{ending}" for ending, said in formats.items()}
    proposed = Path(start_folder(studio)) / name
    asked = ask_for_file(parent, title, proposed, patterns, ending_decides=True)
    return None if asked is None else asked[0]


def ask_for_file(
    parent: QWidget,
    title: str,
    proposed: Path,
    patterns: Mapping[str, str],
    *,
    ending_decides: bool = False,
) -> tuple[Path, str] | None:
    """The file that the user chooses to write, and the pattern; None for none. patterns : what the
    dialog shows, with the ending that is added where none is typed, as ".csv"; ending_decides : the
    ending of another pattern will do as well"""
    first = next((p for p, e in patterns.items() if e == proposed.suffix), next(iter(patterns)))
    typed, chosen = QFileDialog.getSaveFileName(
        parent, title, str(proposed), ";;".join(patterns), first
    )
    if not typed:
        return None
    if chosen not in patterns:
        chosen = first
    known = patterns.values() if ending_decides else (patterns[chosen],)
    if Path(typed).suffix.lower() in known:
        return Path(typed), chosen
    path = Path(typed + patterns[chosen])
    # The dialog has asked about the name without its ending, which is of another file.
    if path.exists() and not confirm_replacement(parent, [path.name]):
        return None
    return path, chosen


def current_measurement(studio: Studio) -> Measurement | None:
    """Of the feature that is selected, where it is one with an attitude."""
    if not studio.has_project or (current := studio.selection.current) is None:
        return None
    if not isinstance(studio.records.get(current), Typed):
        return None
    return studio.measured([current])[current]


def confirm_replacement(parent: QWidget, names: list[str]) -> bool:
    """Whether the user wants files that are there already to be replaced."""
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
